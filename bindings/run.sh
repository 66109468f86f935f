#!/bin/sh
# run.sh [BINDING...]: runs bindings/BINDING/test.sh of those, or of all. The last line is
# `bindings: N passed, N failed, N skipped`, counted in bindings.
#
# A binding is skipped (status 77) where the machine lacks its tools; with HTREE_REQUIRE_ALL=1 that is
# a failure. The variables that test.sh reads are described in README.md.
set -u
cd "$(dirname "$0")/.." || exit 1
root=$(pwd)
LIMIT=1200 # seconds a binding
export HTREE_LIB_DIR="${HTREE_LIB_DIR:-$root/build/release}"
export HTREE_CONFORMANCE="${HTREE_CONFORMANCE:-$HTREE_LIB_DIR/conformance.json}"
scratch=${HTREE_BINDINGS_OUT:-$root/build/bindings}
passed=0 failed=0 skipped=0

limited() {
    if command -v timeout >/dev/null; then timeout "$LIMIT" "$@"; else "$@"; fi
}

fail() {
    failed=$((failed + 1))
    sed 's/^/    /' "$2"
    echo "FAILED $1: $3"
}

# A binding passes if its script succeeds and its last line says that some tests passed and none failed.
run_binding() {
    log=$scratch/$1.log
    HTREE_BINDINGS_OUT=$scratch/$1 limited sh "bindings/$1/test.sh" >"$log" 2>&1
    code=$?
    last=$(tail -n 1 "$log")
    if [ $code -eq 77 ]; then
        if [ "${HTREE_REQUIRE_ALL:-0}" = 1 ]; then
            fail "$1" "$log" "skipped, but HTREE_REQUIRE_ALL is set"
        else
            skipped=$((skipped + 1))
            echo "$last"
        fi
    elif [ $code -eq 124 ]; then
        fail "$1" "$log" "stopped after $LIMIT s"
    elif [ $code -ne 0 ]; then
        fail "$1" "$log" "exit status $code"
    elif ! printf '%s\n' "$last" | grep -qE "^$1: [1-9][0-9]* passed, 0 failed$"; then
        fail "$1" "$log" "its last line is not \`$1: N passed, 0 failed\`"
    else
        passed=$((passed + 1))
        echo "$last"
    fi
}

if [ $# -eq 0 ]; then
    for test in bindings/*/test.sh; do
        [ -f "$test" ] && set -- "$@" "$(basename "$(dirname "$test")")"
    done
fi
for need in "$HTREE_LIB_DIR/libhtree.so" "$HTREE_CONFORMANCE"; do
    [ -f "$need" ] || { echo "FAILED bindings: no $need: make lib conformance"; exit 1; }
done
mkdir -p "$scratch" || exit 1
for binding in "$@"; do run_binding "$binding"; done
echo "bindings: $passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ] && [ $((passed + skipped)) -gt 0 ]
