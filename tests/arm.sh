#!/bin/sh
# arm.sh: the library for 64-bit ARM, cross-compiled and run by QEMU: no warning, no instruction that
# rounds a product and a sum at once, the hits and trees of every other machine (test_golden), and the
# oracle's hits by NEON and without; some of it once more under UBSan. Prints `ok arm-NAME` or `FAILED
# arm-NAME: why` for each.
#
# HTREE_TEST_SCALE replaces the scale of the programs.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=arm-
. tests/common/rules.sh
target=aarch64-linux-gnu
programs="trace watertight query isa golden lazy check objects triangle float_env"
under_ubsan="isa golden objects triangle"
ubsan="-fsanitize=undefined -fno-sanitize-recover=all -static-libubsan"

# build FOLDER FLAGS PROGRAM...: what make was told for this machine is not meant for that one.
build() {
    folder=build/$1 flags=$2
    shift 2
    # shellcheck disable=SC2046
    MAKEFLAGS='' make -j2 B="$folder" CC=$target-gcc WERROR=1 config=release CFLAGS="$flags" \
        LDFLAGS="$flags" $(printf "$folder/tests/test_%s " "$@") >/dev/null
}

# simulate FOLDER PROGRAM; what it prints comes in one piece, because two of these run at once.
simulate() {
    log=build/$1/$2.log
    HTREE_TEST_SCALE=${HTREE_TEST_SCALE:-0.03} timeout 600 qemu-aarch64 "build/$1/tests/test_$2" \
        >"$log" 2>&1
    code=$?
    if [ $code -eq 0 ] && grep -q '^\[  PASSED  \] [1-9]' "$log"; then
        text="ok $1-$2
$(sed -n 's/^count: /    /p' "$log")"
    else
        text="$(sed 's/^/    /' "$log")
FAILED $1-$2: exit status $code"
    fi
    printf '%s\n' "$text"
}

check_rounding() {
    fused=$($target-objdump -d build/arm/libhtree.a | grep -cE '[[:space:]]fn?m(add|sub|la|ls)')
    if [ "$fused" -eq 0 ]; then
        echo "ok arm-rounding"
    else
        echo "FAILED arm-rounding: $fused instructions multiply and add at once"
    fi
}

# shellcheck disable=SC2086
check_all() {
    build arm '' $programs || { echo "FAILED arm-build: see above" && return; }
    build arm-ubsan "$ubsan" $under_ubsan || { echo "FAILED arm-ubsan-build: see above" && return; }
    check_rounding
    { printf 'arm %s\n' $programs && printf 'arm-ubsan %s\n' $under_ubsan; } |
        xargs -P 2 -n 2 sh tests/arm.sh --program
}

if [ "${1-}" = --program ]; then
    simulate "$2" "$3"
    exit 0
fi

if [ "$(uname -m)" = aarch64 ]; then
    echo "skipped arm: this machine is one, and make test runs all of it"
    exit 0
fi
missing=
have $target-gcc || missing="$missing gcc-$target libc6-dev-arm64-cross"
have qemu-aarch64 || missing="$missing qemu-user"
echo 'int main(void) { return 0; }' | $target-gcc -x c -o /dev/null - -lcmocka 2>/dev/null ||
    missing="$missing libcmocka-dev:arm64"
[ -z "$missing" ] ||
    skip_all "it needs$missing (dpkg --add-architecture arm64; apt-get update; apt-get install them)"

mkdir -p build/arm
check_all >build/arm/all.log 2>&1
cat build/arm/all.log
! grep -q '^FAILED' build/arm/all.log
