#!/bin/sh
# mpi.sh: htree-mpi-render gives the same bytes by one, two and three processes, and all of them take part.
# Prints `ok mpi-NAME`, `FAILED mpi-NAME: why` or `skipped mpi: why`. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=mpi-
. tests/common/rules.sh
program=build/release/htree-mpi-render
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

if [ ! -x $program ] || ! command -v mpirun >/dev/null; then
    skip_all 'no htree-mpi-render, or no mpirun (apt-get install libopenmpi-dev openmpi-bin)'
fi

# More processes than cores are fine here, and so is root: a test machine may have one of both.
by() { # by PROCESSES WORD...
    processes=$1
    shift
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
        timeout 200 mpirun --oversubscribe -np "$processes" $program "$@" 2>&1
}

paints() {
    by "$1" "$work/$1.png" city 50000 >"$work/$1.log" || { cat "$work/$1.log"; return 1; }
    cmp "$work/1.png" "$work/$1.png"
}

all_take_part() {
    idle=$(sed 's/.*process://' "$work"/[23].log | tr ' ' '\n' | grep -cx 0)
    [ "$idle" -eq 0 ] || { cat "$work"/[23].log; return 1; }
}

refuses() {
    if by 2 "$work/none.png" nosuchscene >"$work/none.log"; then return 1; fi
    grep -q 'no such scene' "$work/none.log" && [ ! -e "$work/none.png" ]
}

rule one-process paints 1
rule two-processes paints 2
rule three-processes paints 3
rule all-take-part all_take_part
rule refuses refuses
exit $bad
