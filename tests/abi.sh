#!/bin/sh
# abi.sh: the ABI is the committed one: sizes, fields, constants and symbols as this compiler has them
# (abi.txt, abi_cl.txt), and by libabigail the types of everything that is exported (abi.xml, abi_cl.xml).
# Prints `ok abi-NAME`, `FAILED abi-NAME: why` or `skipped abi-NAME: why`. Uses the release build.
#
# abi.sh --write: commits to the ABI as it is now.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=abi-
. tests/common/rules.sh
CC=${CC:-cc}
release=build/release
debug=build/abi # with the types that libabigail reads
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

# ---- By the compiler -----------------------------------------------------------------------------------

# What header $1 declares: `size TYPE`, `field TYPE.FIELD` and `constant NAME`, in its order.
abi_names() {
    awk '
        /^typedef (u?int[0-9]+_t) [a-z_]+;/ { sub(/;/, "", $3); print "size", $3 }
        /^typedef struct [a-z_]+ \{/ { type = $3; print "size", type; next }
        /^}/ { type = "" }
        /^enum \{/ { listing = 1; next }
        /^};/ { listing = 0 }
        type != "" && /;/ {
            line = $0
            sub(/\/\*.*/, "", line)
            if (line ~ /\(\*/) {
                sub(/^[^(]*\(\*/, "", line)
                sub(/\).*/, "", line)
                print "field", type "." line
                next
            }
            if (!sub(/;.*/, "", line)) next
            sub(/^ *(const )?[a-z_0-9]+ /, "", line)
            n = split(line, names, ",")
            for (i = 1; i <= n; ++i) {
                gsub(/[ *]|\[[0-9]*\]/, "", names[i])
                print "field", type "." names[i]
            }
        }
        listing && /^ *HTREE_[A-Z_0-9]+ =/ { print "constant", $1 }
        /^#define HTREE_[A-Z_]+ +[0-9U]/ { print "constant", $2 }
    ' "include/$1"
}

# The ABI of header $1, this compiler and library $2.
abi_now() {
    abi_names "$1" >"$work/names"
    [ -s "$work/names" ] || { echo "cannot read include/$1"; return 1; }
    {
        echo "#include \"$1\""
        cat <<'C'
#include <stddef.h>
#include <stdio.h>
#define SIZE(type) printf("size %s %lu\n", #type, (unsigned long)sizeof(type));
#define FIELD(type, field) \
    printf("field %s.%s %lu %lu\n", #type, #field, (unsigned long)offsetof(type, field), \
           (unsigned long)sizeof(((type *)0)->field));
#define CONSTANT(name) printf("constant %s %.20g\n", #name, (double)(name));
int main(void) {
C
        awk '$1 == "size" { print "SIZE(" $2 ")" }
            $1 == "field" { split($2, part, "."); print "FIELD(" part[1] ", " part[2] ")" }
            $1 == "constant" { print "CONSTANT(" $2 ")" }' "$work/names"
        echo 'return 0; }'
    } >"$work/abi.c"
    # shellcheck disable=SC2086
    $CC -std=c99 -Iinclude -o "$work/abi" "$work/abi.c" || return 1
    echo '# Sizes, fields (offset, size), constants and symbols, on 64-bit machines: see tests/abi.sh.'
    "$work/abi"
    exported "$2" | sed 's/^/symbol /'
}

# The ABI of header $1 and library $2 is that of file $3.
abi_is_as_committed() {
    abi_now "$1" "$2" >"$work/abi.now" || return 1
    diff -u "$3" "$work/abi.now" ||
        { echo "the ABI differs from $3; if that is meant: sh tests/abi.sh --write"; return 1; }
}

# ---- By libabigail -------------------------------------------------------------------------------------

with_types() {
    MAKEFLAGS='' make -j2 --no-print-directory B=$debug config=debug CC="$CC" CFLAGS='-O0 -w' lib >/dev/null
}

# The types of the public headers; what else a library is made of is its own.
describe() { # describe LIBRARY
    abidw --headers-dir include --drop-private-types --exported-interfaces-only --short-locs \
        --no-parameter-names --no-corpus-path --no-comp-dir-path --no-elf-needed --no-architecture "$1"
}

types_are_as_committed() { # types_are_as_committed FILE LIBRARY
    abidiff --no-architecture "$1" "$2" ||
        { echo "types differ from $1; if that is meant: sh tests/abi.sh --write"; return 1; }
}

# ---- Both libraries ------------------------------------------------------------------------------------

for_each() { # for_each WORD: WORD HEADER LIBRARY FILE, of every library that is built
    "$1" htree.h libhtree.so tests/abi
    [ ! -f $release/libhtree_cl.so ] || "$1" htree_cl.h libhtree_cl.so tests/abi_cl
}

write() {
    abi_now "$1" "$release/$2" >"$3.txt" && describe "$debug/$2" >"$3.xml"
}

check_by_compiler() {
    rule "$2" abi_is_as_committed "$1" "$release/$2" "$3.txt"
}

check_by_libabigail() {
    rule "types-of-$2" types_are_as_committed "$3.xml" "$debug/$2"
}

if [ "${1-}" = --write ]; then
    have abidw || { echo "abidw is missing: apt-get install abigail-tools"; exit 1; }
    with_types && for_each write
    exit
fi

[ -f $release/libhtree.so ] || skip_all 'no libhtree.so: make lib'
for_each check_by_compiler
if have abidiff; then
    rule types-are-there with_types
    [ $bad -ne 0 ] || for_each check_by_libabigail
else
    skip types 'no abidiff (apt-get install abigail-tools)'
fi
exit $bad
