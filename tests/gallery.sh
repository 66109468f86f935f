#!/bin/sh
# gallery.sh: the page of `make gallery`, with small pictures, in headless Chromium: see gallery/check.mjs. Prints
# `ok gallery-NAME`, `FAILED gallery-NAME: why` or `skipped gallery: why`. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=gallery-
. tests/common/rules.sh
site=build/gallery-test

chromium=$(command -v chromium || command -v chromium-browser) ||
    skip_all 'no chromium (apt-get install chromium)'
for tool in node npm; do
    have $tool || skip_all "no $tool (apt-get install nodejs npm)"
done
[ -x build/release/htree-nodes ] || skip_all 'no htree-nodes (make, with libpng)'

make_site() {
    SIZE=96x72 FILM=64x48 FRAMES=3 TREE=400 sh docs/gallery/make.sh build/release $site &&
        (cd $site.work && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
}

rule made make_site
[ $bad -eq 0 ] || exit 1
exec timeout 200 node tests/gallery/check.mjs $site $site.work/node_modules/playwright-core "$chromium"
