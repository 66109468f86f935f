#!/bin/sh
# Builds the jar with every warning an error, runs its tests and its examples. Writes only to
# $HTREE_BINDINGS_OUT and to Maven's own cache.
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

skip() {
    echo "skipped java: $1 (apt-get install openjdk-17-jdk-headless maven)"
    exit 77
}
command -v javac >/dev/null || skip "no JDK"
command -v mvn >/dev/null || skip "no Maven"
release=$(javac -version 2>&1 | sed 's/^javac \([0-9]*\).*/\1/')
[ "$release" -ge 17 ] || skip "JDK $release is older than 17"

lib=$(cd "${HTREE_LIB_DIR:-$root/build/release}" && pwd)
conformance=${HTREE_CONFORMANCE:-$root/build/release/conformance.json}
conformance=$(cd "$(dirname "$conformance")" && pwd)/$(basename "$conformance")
out=${HTREE_BINDINGS_OUT:-$root/build/bindings/java}
mkdir -p "$out"
out=$(cd "$out" && pwd)
log=$out/maven.log

passed=0
failed=0
finish() {
    echo "java: $passed passed, $failed failed"
    [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
    exit $?
}

# A library of another ABI, which the binding must refuse.
mkdir -p "$out/skew"
echo 'unsigned htree_version(void) { return 200; }' |
    "${CC:-cc}" -shared -fPIC -x c - -o "$out/skew/libhtree.so"

rm -rf "$out/target"
code=0
mvn -B -ntp -f "$here/pom.xml" -Dhtree.out="$out" -Dhtree.lib.dir="$lib" -Dskew.dir="$out/skew" \
    -Dconformance.file="$conformance" package >"$log" 2>&1 || code=$?
grep 'Tests run:.* -- in ' "$log" || true
counts=$(sed -n 's/^\[[A-Z]*\] Tests run: \([0-9]*\), Failures: \([0-9]*\), Errors: \([0-9]*\), Skipped: \([0-9]*\)$/\1 \2 \3 \4/p' "$log" | tail -1)
if [ -n "$counts" ]; then
    set -- $counts
    passed=$(($1 - $2 - $3 - $4))
    failed=$(($2 + $3))
fi
if [ "$code" -ne 0 ]; then
    grep -E '^\[(ERROR|WARNING)\]' "$log" | head -40
    [ "$failed" -gt 0 ] || failed=1
    finish
fi

# The examples run from the jar alone, with the library that it carries.
verdict() {
    if [ "$2" = "$3" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        printf 'failed: %s\n  wanted %s\n  got    %s\n' "$1" "$2" "$3"
    fi
}
classes=$(echo "$out"/target/htree-*.[0-9].jar):$(cat "$out/target/classpath")
sed -n '/^```java$/,/^```$/p' "$here/README.md" | sed '1d;/^```$/,$d' >"$out/Minimal.java"
verdict "README's example is examples/Minimal.java" "$(sed 1d "$here/examples/Minimal.java")" \
    "$(cat "$out/Minimal.java")"
verdict "README's example" "triangle 3 at t = 1.6666666" \
    "$(java -cp "$classes" "$out/Minimal.java")"
verdict "examples/AmbientOcclusion.java" "$out/occlusion.pgm: 18432 triangles, 2162688 rays" \
    "$(java -cp "$classes" "$here/examples/AmbientOcclusion.java" "$out/occlusion.pgm")"
verdict "its picture has a pixel for each" 65551 "$(wc -c <"$out/occlusion.pgm")"
finish
