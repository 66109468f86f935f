#!/bin/sh
# gallery.sh: the page of `make gallery`, with small pictures, in headless Chromium: see gallery/check.mjs. Prints
# `ok gallery-NAME`, `FAILED gallery-NAME: why` or `skipped gallery: why`. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
site=build/gallery-test

skip() {
    [ "${HTREE_REQUIRE_ALL-}" = 1 ] && { echo "FAILED gallery: $1"; exit 1; }
    echo "skipped gallery: $1"
    exit 0
}

chromium=$(command -v chromium || command -v chromium-browser) ||
    skip 'no chromium (apt-get install chromium)'
for tool in node npm; do
    command -v $tool >/dev/null || skip "no $tool (apt-get install nodejs npm)"
done
[ -x build/release/htree-nodes ] || skip 'no htree-nodes (make, with libpng)'

make_site() {
    SIZE=96x72 FILM=64x48 FRAMES=3 TREE=400 sh docs/gallery/make.sh build/release $site &&
        (cd $site.work && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
}

if why=$(make_site 2>&1); then
    echo "ok gallery-made"
else
    printf '%s\n' "$why" | tail -n 20
    echo "FAILED gallery-made: $(printf '%s\n' "$why" | tail -n 1)"
    exit 1
fi
exec timeout 200 node tests/gallery/check.mjs $site $site.work/node_modules/playwright-core "$chromium"
