#!/bin/sh
# test.sh: formats, vets and tests the package, from any folder. See README.md.
# HTREE_LIB_DIR       the folder of libhtree.a and libhtree.so (build/release of this checkout)
# HTREE_CONFORMANCE   the conformance file (build/release/conformance.json)
# HTREE_BINDINGS_OUT  where everything is built (build/bindings/go)
# SPDX-License-Identifier: MIT
set -u
cd "$(dirname "$0")" || exit 1
repo=$(cd ../.. && pwd)
lib=$(cd "${HTREE_LIB_DIR:-$repo/build/release}" && pwd) || exit 1
out=${HTREE_BINDINGS_OUT:-$repo/build/bindings/go}
mkdir -p "$out" || exit 1
out=$(cd "$out" && pwd)
HTREE_CONFORMANCE=${HTREE_CONFORMANCE:-$repo/build/release/conformance.json}
GOCACHE=$out/cache
GOTOOLCHAIN=local
GOFLAGS="${GOFLAGS:-} -buildvcs=false"
CGO_ENABLED=1
export HTREE_CONFORMANCE GOCACHE GOTOOLCHAIN GOFLAGS CGO_ENABLED

have() {
    command -v "$1" >/dev/null 2>&1
}

have go || { echo "skipped go: go is missing (apt-get install golang-go)"; exit 77; }
cc=$(go env CC)
have "${cc%% *}" || { echo "skipped go: $cc is missing (apt-get install gcc)"; exit 77; }
[ -f "$lib/libhtree.a" ] || { echo "no libhtree.a in $lib: make lib"; exit 1; }

# Go does not see when a library changes, but it sees flags: its checksum is one of them.
checksum=$(cksum <"$lib/libhtree.a" | tr ' ' _)
CGO_CFLAGS="-O2 -g -I$repo/include -DHTREE_LIBRARY=$checksum"
static="$lib/libhtree.a -lm -lpthread"
export CGO_CFLAGS

passed=0
failed=0

# Runs the words after $1, and counts the tests that go reports, or else the command itself as one.
step() {
    name=$1
    shift
    echo "== $name"
    if "$@" >"$out/log" 2>&1; then
        status=0
    else
        status=$?
    fi
    ok=$(grep -c '^ *--- PASS: ' "$out/log")
    bad=$(grep -c '^ *--- FAIL: ' "$out/log")
    if [ $status -eq 0 ]; then
        [ $((ok + bad)) -gt 0 ] || ok=1
    else
        [ "$bad" -gt 0 ] || bad=1
        grep -vE '^ *(=== |--- PASS: )' "$out/log"
        echo "FAILED $name"
    fi
    passed=$((passed + ok))
    failed=$((failed + bad))
}

formatted() {
    unformatted=$(gofmt -l .) && [ -z "$unformatted" ] || { echo "gofmt -w $unformatted"; return 1; }
}

# The program in README.md, in a module of its own as README.md says, prints what it says.
readme() {
    rm -rf "$out/readme" && mkdir -p "$out/readme" &&
        awk '/^```go$/ { inside = 1; next } /^```$/ { if (inside) exit } inside' README.md >"$out/readme/main.go" &&
        printf 'module readme\n\ngo 1.19\n\nrequire htree v0.0.0\n\nreplace htree => %s\n' "$(pwd)" \
            >"$out/readme/go.mod" &&
        (cd "$out/readme" && CGO_LDFLAGS=$static go run -tags htreeenv . >said 2>err) || { cat "$out/readme/err"; return 1; }
    grep -qxF "prints \`$(cat "$out/readme/said")\`." README.md || { echo "it prints $(cat "$out/readme/said")"; return 1; }
}

with_pkg_config() {
    version=$(sed -n 's/^#define HTREE_VERSION_[MP][A-Z]* *//p' "$repo/include/htree.h" | paste -s -d . -)
    mkdir -p "$out/pkgconfig" &&
        printf 'Name: htree\nDescription: ray queries\nVersion: %s\nCflags: -I%s\nLibs: -L%s -lhtree\n' \
            "$version" "$repo/include" "$lib" >"$out/pkgconfig/htree.pc" &&
        PKG_CONFIG_PATH=$out/pkgconfig LD_LIBRARY_PATH=$lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} \
            go test -count=1 -v -tags libhtree -run 'Example|Mistake|Panic|Versions' .
}

# A build without cgo ends with an error that says so.
without_cgo() {
    ! CGO_ENABLED=0 go build . >"$out/nocgo" 2>&1 && grep -q 'htree_needs_cgo' "$out/nocgo" ||
        { cat "$out/nocgo"; return 1; }
}

rendered() {
    CGO_LDFLAGS=$static go run -tags htreeenv ./examples/render "$out/torus.png" &&
        [ "$(wc -c <"$out/torus.png")" -gt 20000 ]
}

if go tool -n cgo >/dev/null 2>&1 && echo 'package p' | gofmt >/dev/null 2>&1; then
    step format formatted
else
    echo "note: not checked: format (gofmt is missing)"
fi
step vet env CGO_LDFLAGS="$static" go vet -tags htreeenv ./...
step tests env CGO_LDFLAGS="$static" go test -count=1 -v -tags htreeenv .
if env CGO_LDFLAGS= go test -race -run NONE ./internal/cmemory >/dev/null 2>&1; then
    step "tests, race detector" env CGO_LDFLAGS="$static" go test -count=1 -v -race -tags htreeenv .
else
    echo "note: not checked: races (apt-get install golang-race-detector-runtime)"
fi
# What GODEBUG=cgocheck=2 was until Go 1.20 is a build of its own since.
case $(go env GOVERSION) in
go1.19* | go1.20*) strict=GODEBUG=cgocheck=2 ;;
*) strict=GOEXPERIMENT=cgocheck2 ;;
esac
step "tests, $strict" env CGO_LDFLAGS="$static" "$strict" go test -count=1 -v -tags htreeenv .
if have pkg-config; then
    step pkg-config with_pkg_config
else
    echo "note: not checked: the tag libhtree (apt-get install pkg-config)"
fi
if [ "$lib" = "$repo/build/release" ]; then
    step "the library of the checkout" go test -count=1 -v -run Example .
fi
step "without cgo" without_cgo
step README readme
step "example render" rendered
echo "go: $passed passed, $failed failed"
[ $failed -eq 0 ]
