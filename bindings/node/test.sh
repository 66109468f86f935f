#!/bin/sh
# Installs a copy of the package into $HTREE_BINDINGS_OUT, checks its types, runs its tests and
# its examples.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

skip() {
    echo "skipped node: $1 (apt-get install nodejs npm)"
    exit 77
}
command -v node >/dev/null || skip "no Node.js"
command -v npm >/dev/null || skip "no npm"
release=$(node -p 'process.versions.node.split(".")[0]')
[ "$release" -ge 18 ] || skip "Node.js $release is older than 18"

lib=$(cd "${HTREE_LIB_DIR:-$root/build/release}" && pwd)
conformance=${HTREE_CONFORMANCE:-$root/build/release/conformance.json}
conformance=$(cd "$(dirname "$conformance")" && pwd)/$(basename "$conformance")
out=${HTREE_BINDINGS_OUT:-$root/build/bindings/node}
mkdir -p "$out"
out=$(cd "$out" && pwd)

passed=0
failed=0
finish() {
    echo "node: $passed passed, $failed failed"
    [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
    exit $?
}
verdict() {
    if [ "$2" = "$3" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        printf 'failed: %s\n  wanted %s\n  got    %s\n' "$1" "$2" "$3"
    fi
}

# A library of another ABI, which the binding must refuse.
mkdir -p "$out/skew"
echo 'unsigned htree_version(void) { return 200; }' |
    "${CC:-cc}" -shared -fPIC -x c - -o "$out/skew/libhtree.so"

package=$out/package
rm -rf "$package"
mkdir -p "$package"
(cd "$here" && tar -cf - --exclude=node_modules .) | (cd "$package" && tar -xf -)
cd "$package"
if ! npm ci --ignore-scripts --no-audit --no-fund >"$out/npm.log" 2>&1; then
    cat "$out/npm.log"
    failed=1
    finish
fi

export HTREE_LIBRARY="$lib/libhtree.so" HTREE_CONFORMANCE="$conformance"
export HTREE_SKEWED="$out/skew/libhtree.so"

verdict "types" "" "$(npm run --silent types 2>&1)"

node --expose-gc --test --test-reporter=tap test/*.test.js >"$out/test.log" 2>&1 || true
grep -E '^ *not ok' -A 20 "$out/test.log" || true
count() { sed -n "s/^# $1 \([0-9]*\)$/\1/p" "$out/test.log" | tail -1; }
if [ -n "$(count pass)" ]; then
    passed=$((passed + $(count pass)))
    failed=$((failed + $(count fail) + $(count cancelled)))
else
    cat "$out/test.log"
    failed=$((failed + 1))
fi

sed -n '/^```js$/,/^```$/p' "$here/README.md" | sed '1d;/^```$/,$d' >"$package/readme.mjs"
verdict "README's example is examples/minimal.mjs" "$(sed 1d examples/minimal.mjs)" "$(cat readme.mjs)"
verdict "README's example" "triangle 3 at t = 1.6666666269302368
1 ray, hit" "$(node readme.mjs 2>&1)"
verdict "examples/occlusion.mjs" "$out/occlusion.pgm: 18432 triangles, 2162688 rays" \
    "$(node examples/occlusion.mjs "$out/occlusion.pgm" 2>&1)"
verdict "its picture has a pixel for each" 65551 "$(wc -c <"$out/occlusion.pgm")"
verdict "the package holds what it should" "index.d.mts index.d.ts index.js index.mjs" \
    "$(npm pack --dry-run --json 2>/dev/null | node -p '
        JSON.parse(require("fs").readFileSync(0))[0].files.map(({ path }) => path)
            .filter((path) => path.startsWith("index")).sort().join(" ")')"
finish
