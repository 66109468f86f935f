#!/bin/sh
# onefile.sh: dist/htree.c, the library as one file: compiled by several compilers in several languages without a
# warning, with and without threads; the test programs over it; hits and trees that are the same as on
# every machine (test_golden) by gcc and clang at -O0, -O2 and -O3, on 64-bit ARM and on WebAssembly. Prints `ok onefile-NAME`, `FAILED
# onefile-NAME: why` or `skipped onefile-NAME: why` for each.
#
# HTREE_TEST_SCALE replaces the scale of the programs.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=onefile-
. tests/common/rules.sh
CC=${CC:-cc}
CLANG=${CLANG:-clang}
export HTREE_TEST_SCALE="${HTREE_TEST_SCALE:-0.03}"
folder=build/release/onefile
work=build/onefile

quiet_make() {
    MAKEFLAGS='' make -j2 --no-print-directory config=release "$@" >/dev/null
}

passes() { # passes WORD...: a program of tests, which must have passed some
    timeout 600 "$@" >"$work/log" 2>&1
    code=$?
    cat "$work/log"
    [ $code -eq 0 ] && grep -q '^\[  PASSED  \] [1-9]' "$work/log"
}

# ---- Compilers -----------------------------------------------------------------------------------------

compiles() { # compiles COMPILER FLAG...
    "$@" -pedantic -Wall -Wextra -Wconversion -Wmissing-prototypes -Wno-unknown-pragmas -Werror \
        -c -o "$work/compiled.o" dist/htree.c
}

exports_htree_only() {
    $CC -shared -fPIC -o "$work/onefile.so" dist/htree.c -lm -lpthread || return 1
    found=$(nm -D --defined-only "$work/onefile.so" | awk '{ print $3 }' | grep -v '^htree_')
    [ -z "$found" ] || { echo "dist/htree.c exports" $found; return 1; }
}

one_line() { # as its first words say
    $CC -O1 -Idist -o "$work/minimal" examples/minimal.c dist/htree.c -lm -lpthread && "$work/minimal"
}

# ---- Programs ------------------------------------------------------------------------------------------

all_tests() {
    for source in tests/test_*.c; do
        name=$(basename "$source" .c)
        case $name in test_cl* | test_aff | test_subdivide) ;; *) echo "$folder/$name" ;; esac
    done
}

# No threads: nothing to be raced, and no hook is called from elsewhere.
single_tests() {
    for name in golden trace query build lazy update; do
        [ -f "tests/test_$name.c" ] && echo "$folder/single_$name"
    done
}

# ---- Other compilers -----------------------------------------------------------------------------------

GOLDEN='tests/test_golden.c tests/common/rays.c tests/common/suite.c
    examples/mesh/decimal.c examples/mesh/shapes.c examples/mesh/subdivide.c'
golden_by() { # golden_by COMPILER LEVEL: neither changes a bit of hits and trees
    # shellcheck disable=SC2086
    "$1" -std=c99 "$2" -D_POSIX_C_SOURCE=200809L -Idist -Itests/common -Iexamples/mesh -o "$work/golden" \
        $GOLDEN dist/htree.c -lcmocka -lm -lpthread || return 1
    passes "$work/golden"
}

check_levels() {
    for compiler in gcc "$CLANG"; do
        if ! command -v "$compiler" >/dev/null; then
            skip "golden-$compiler" "no $compiler"
            continue
        fi
        for level in O0 O2 O3; do rule "golden-$compiler-$level" golden_by "$compiler" "-$level"; done
    done
}

# ---- Other machines ------------------------------------------------------------------------------------

golden_on_arm() {
    program=build/arm/onefile/test_golden
    quiet_make B=build/arm CC=aarch64-linux-gnu-gcc CFLAGS= LDFLAGS= $program || return 1
    passes qemu-aarch64 $program
}

check_arm() {
    if [ "$(uname -m)" = aarch64 ]; then
        return
    elif ! command -v qemu-aarch64 >/dev/null || ! echo 'int main(void) { return 0; }' |
        aarch64-linux-gnu-gcc -x c -o /dev/null - -lcmocka 2>/dev/null; then
        skip arm 'what it needs is what tests/arm.sh needs'
    else
        rule arm golden_on_arm
    fi
}

WASM_FLAGS='--target=wasm32-wasi -std=c99 -pedantic -Wall -Wextra -Werror -O2'
golden_on_wasm() {
    # shellcheck disable=SC2086
    "$CLANG" $WASM_FLAGS -DHTREE_NO_THREADS -c -o "$work/wasm.o" dist/htree.c || return 1
    # shellcheck disable=SC2086
    "$CLANG" $WASM_FLAGS -D_POSIX_C_SOURCE=200809L -Itests/wasm -Idist -Itests/common -Iexamples/mesh \
        -o "$work/golden.wasm" tests/test_golden.c tests/common/rays.c tests/common/suite.c \
        examples/mesh/decimal.c examples/mesh/shapes.c examples/mesh/subdivide.c "$work/wasm.o" || return 1
    passes node --no-warnings tests/wasm/run.mjs "$work/golden.wasm"
}

check_wasm() {
    if ! echo 'int main(void) { return 0; }' |
        "$CLANG" --target=wasm32-wasi -x c -o "$work/empty.wasm" - 2>/dev/null; then
        skip wasm 'no WebAssembly (apt-get install clang lld wasi-libc libclang-rt-dev-wasm32)'
    elif ! node -e 'new (require("node:wasi").WASI)({ version: "preview1" })' 2>/dev/null; then
        skip wasm 'no node with WASI'
    else
        rule wasm golden_on_wasm
    fi
}

# ---- All of it -----------------------------------------------------------------------------------------

mkdir -p "$work"
rule is-made quiet_make amalgamation
[ $bad -eq 0 ] || exit 1
# For the programs $CC compiles it as C99, and as GNU C without threads, with the same warnings. Those of
# clang do not depend on the optimiser.
# shellcheck disable=SC2086
rule by-cc-c99-portable compiles $CC -std=c99 -DHTREE_PORTABLE -O1
if command -v "$CLANG" >/dev/null; then
    for flags in -std=c99 '-std=gnu17 -DHTREE_NO_THREADS' '-std=c99 -DHTREE_PORTABLE'; do
        # shellcheck disable=SC2086
        rule "by-clang$(echo " $flags" | sed 's/ -\(std=\|DHTREE_\)/-/g')" compiles "$CLANG" $flags -fsyntax-only
    done
else
    skip by-clang "no $CLANG"
fi
rule one-line one_line
rule exports-htree-only exports_htree_only
# shellcheck disable=SC2046
rule tests-build quiet_make CC="$CC" $(all_tests) $(single_tests)
[ $bad -eq 0 ] || exit 1
for program in $(all_tests) $(single_tests); do
    rule "$(basename "$program" | sed 's/^test_//')" passes "$program"
done
check_levels
check_arm
check_wasm
exit $bad
