#!/bin/sh
# dist.sh: the archive of `make dist`, unpacked where there is no repository: it builds without a warning,
# finds the hits and trees of every other machine, installs and uninstalls, and is the same bytes when it is
# made again. Prints `ok dist-NAME` or `FAILED dist-NAME: why` for each.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=dist-
. tests/common/rules.sh
CC=${CC:-cc}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

unpacks() {
    MAKEFLAGS='' make -s dist || return 1
    tar -C "$work" -xzf dist/libhtree-*.tar.gz || return 1
    mv "$work"/libhtree-* "$work/tree"
}

is_reproducible() {
    before=$(cksum <"$(ls dist/libhtree-*.tar.gz)")
    MAKEFLAGS='' make -s dist || return 1
    [ "$before" = "$(cksum <"$(ls dist/libhtree-*.tar.gz)")" ] || { echo "another archive"; return 1; }
}

there() {
    (cd "$work/tree" && MAKEFLAGS='' make -s -j2 WERROR=1 CC="$CC" CFLAGS=-O1 "$@")
}

builds() {
    there lib build/release/minimal && "$work/tree/build/release/minimal" | grep -q '^triangle 3'
}

passes() {
    there build/release/tests/test_golden && "$work/tree/build/release/tests/test_golden"
}

installs() {
    there install DESTDIR="$work/root" && [ -f "$work/root/usr/local/include/htree.h" ] || return 1
    there uninstall DESTDIR="$work/root" && [ -z "$(find "$work/root" -type f)" ]
}

if ! git rev-parse --git-dir >/dev/null 2>&1; then
    skip_all 'no repository to make an archive of'
fi
rule unpacks unpacks
rule is-reproducible is_reproducible
rule builds builds
rule passes passes
rule installs installs
exit $bad
