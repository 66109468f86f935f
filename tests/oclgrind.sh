#!/bin/sh
# oclgrind.sh: the kernels on Oclgrind, which simulates a device word by word: no read of what was never
# written, no access outside a buffer, no race, no call that OpenCL forbids; and the CPU's hits. A program
# for each kind and for the probe, 1000 rays by default: HTREE_TEST_SCALE=10 asks for 10,000. Prints
# `ok NAME` or `FAILED NAME: why` for each. Uses the release build.
#
# Two things are as they are because of Oclgrind 21.10. It is found as a driver, and not by its command,
# which puts itself before a program's own libOpenCL and not before one that is opened at run time. And it
# runs what the compiler gave it unoptimised: its optimised form stores a vector part by part, the part that
# is about to be overwritten as `undef` (a report for every hit that is right), and dies of the shuffles
# in wide.cl.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=oclgrind-
. tests/common/rules.sh
program=build/release/tests/cl_compare
driver=
for path in /usr/lib/oclgrind /usr/lib/*/oclgrind /usr/local/lib/oclgrind; do
    [ -f "$path/liboclgrind-rt-icd.so" ] && driver=$path/liboclgrind-rt-icd.so
done

[ -n "$driver" ] || skip_all 'no Oclgrind (apt-get install oclgrind)'
[ -x "$program" ] || skip_all "no $program: make config=release tests"
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
echo "$driver" >"$work/oclgrind.icd"
rays=$(awk -v scale="${HTREE_TEST_SCALE:-1}" 'BEGIN { n = int(1000 * scale); print n < 10 ? 10 : n }')

simulate() { # simulate KIND
    OCL_ICD_VENDORS=$work OCLGRIND_CHECK_API=1 OCLGRIND_UNINITIALIZED=1 OCLGRIND_DATA_RACES=1 \
        OCLGRIND_MAX_ERRORS=10 OCLGRIND_LOG=$work/$1.log OCLGRIND_BUILD_OPTIONS=-cl-opt-disable \
        timeout 600 "$program" "$1" "$rays" 60 >"$work/$1.out" 2>&1
    code=$?
    if [ $code -eq 0 ] && [ -f "$work/$1.log" ] && [ ! -s "$work/$1.log" ]; then
        echo "ok oclgrind-$1"
        sed 's/^/    /' "$work/$1.out"
    else
        head -n 60 "$work/$1.log"
        echo "FAILED oclgrind-$1: exit status $code: $(tail -n 1 "$work/$1.out")"
    fi
}

for kind in probe ug kd bvh-median bvh-sah skd h ah wide; do simulate $kind; done >"$work/all"
cat "$work/all"
! grep -q '^FAILED' "$work/all"
