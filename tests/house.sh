#!/bin/sh
# house.sh: the rules of the house that no test program can see: layers, the header alone, what the
# library needs and exports, and what its sources may contain. Prints `ok NAME` or `FAILED NAME: why`
# for each rule, and the details above it. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=
. tests/common/rules.sh
release=build/release
shared=$release/libhtree.so
static=$release/libhtree.a
shared_cl=$release/libhtree_cl.so
static_cl=$release/libhtree_cl.a
CC=${CC:-cc}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

has_opencl() {
    [ -f "$shared_cl" ]
}

# ---- The headers --------------------------------------------------------------------------------------

# Header $5 alone, then twice, by compiler $1 in language $2 and standard $3.
header_compiles() {
    extension=c
    [ "$2" = c++ ] && extension=cpp
    printf '#include "%s"\n#include "%s"\nint main(void) { return (int)htree_version() == 0; }\n' "$5" "$5" \
        >"$work/header.$extension"
    # shellcheck disable=SC2086
    $1 -x "$2" "-std=$3" -pedantic -Wall -Wextra -Wshadow -Wconversion -Werror $4 -Iinclude -fsyntax-only \
        "$work/header.$extension"
}

# Whether compiler $1 knows standard $3 of language $2.
knows() {
    # shellcheck disable=SC2086
    echo 'int main(void) { return 0; }' | $1 -x "$2" "-std=$3" -fsyntax-only - 2>/dev/null
}

check_headers() {
    for compiler in "$CC" gcc clang; do
        have "${compiler%% *}" || continue
        for standard in c99 c11 c17; do
            knows "$compiler" c $standard || continue
            rule "header-${compiler%% *}-$standard" header_compiles "$compiler" c $standard \
                '-Wmissing-prototypes -Wc++-compat' htree.h
            has_opencl || continue
            rule "header-cl-${compiler%% *}-$standard" header_compiles "$compiler" c $standard \
                '-Wmissing-prototypes -Wc++-compat' htree_cl.h
        done
    done
    for compiler in g++ clang++; do
        have $compiler || continue
        for standard in c++98 c++11 c++14 c++17 c++20; do
            knows $compiler c++ $standard || continue
            # C++98 knows long long as an extension only; the header's uint64_t may be one.
            rule "header-$compiler-$standard" header_compiles $compiler c++ $standard -Wno-long-long htree.h
            has_opencl || continue
            rule "header-cl-$compiler-$standard" header_compiles $compiler c++ $standard -Wno-long-long htree_cl.h
        done
    done
}

# ---- The library --------------------------------------------------------------------------------------

# Library $1 exports nothing but names that begin with $2.
only_ours_is_exported() {
    strangers=$(exported "$1" | grep -v "^$2")
    [ -z "$strangers" ] || { echo "$1 exports" $strangers; return 1; }
}


# Printing, ending the process and what keeps global state. vsnprintf writes to memory and is fine.
nothing_exits_or_prints() {
    found=$(nm -D --undefined-only "$1" | awk '{ sub(/@.*/, "", $2); print $2 }' |
        grep -xE 'abort|_?_?exit|_Exit|quick_exit|atexit|v?f?printf|__v?f?printf_chk|puts|fputs|putchar|fwrite|perror|fopen|getenv|srand|rand|signal|setlocale|__assert_fail')
    [ -z "$found" ] || { echo "$1 calls" $found; return 1; }
}

needs_libc_only() {
    needed=$(readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
        grep -vE "^(libc|libm|libpthread|ld-linux[a-z0-9-]*|$2)\\.so")
    [ -z "$needed" ] || { echo "$1 needs" $needed; return 1; }
}

# Symbols of objects in sections that stay writable; tables of pointers in .data.rel.ro do not, and
# thread-local variables have sections of their own.
no_writable_globals() {
    found=$(objdump -t "$1" | awk '
        / O / { for (i = 1; i <= NF; ++i) if ($i ~ /^(\.data|\.bss|\*COM\*)/ && $i !~ /^\.data\.rel\.ro/) print $NF }')
    [ -z "$found" ] || { echo "$1 has writable globals:" $found; return 1; }
}

# The table of addresses is read-only after loading, the stack is not executable, arrays on the stack and
# the calls of libc that know their size are guarded.
is_hardened() {
    readelf -dW "$1" | grep -q BIND_NOW || { echo "$1 binds lazily"; return 1; }
    readelf -lW "$1" | grep -q GNU_RELRO || { echo "$1 has no RELRO"; return 1; }
    readelf -lW "$1" | grep GNU_STACK | grep -q ' RW ' || { echo "$1 has an executable stack"; return 1; }
    for guard in __stack_chk_fail __vsnprintf_chk; do
        nm -D --undefined-only "$1" | grep -q "$guard" || { echo "$1 lacks $guard"; return 1; }
    done
}

# ---- The sources --------------------------------------------------------------------------------------

sources() {
    find include lib tests examples bindings cl packaging Makefile -type f \( -name '*.[ch]' -o -name '*.[ch]pp' -o -name '*.sh' -o -name '*.cl' \
        -o -name '*.txt' -o -name '*.map' -o -name Makefile \) 2>/dev/null | grep -v '/out/'
}

sources_are_ascii() {
    # shellcheck disable=SC2046
    found=$(LC_ALL=C grep -ln '[^ -~	]' $(sources))
    [ -z "$found" ] || { echo "bytes that are not ASCII in" $found; return 1; }
}

no_marks_of_unfinished_work() {
    # shellcheck disable=SC2046
    found=$(grep -nE '\b(TO[D]O|FIX[M]E|XX[X]|HAC[K])\b' $(sources) README.md lib/README.md 2>/dev/null)
    [ -z "$found" ] || { echo "$found"; return 1; }
}

files_are_short() {
    long=$(for file in $(sources); do
        lines=$(wc -l <"$file")
        [ "$lines" -lt 600 ] || echo "$file has $lines lines"
    done)
    [ -z "$long" ] || { echo "$long"; return 1; }
}

readme_shows_minimal_c() {
    [ -f README.md ] || { echo "no README.md"; return 1; }
    awk '/^```c$/ { inside = 1; next } /^```$/ { if (inside) exit } inside' README.md >"$work/readme.c"
    [ -s "$work/readme.c" ] || { echo "README.md has no block of C"; return 1; }
    diff -u examples/minimal.c "$work/readme.c" ||
        { echo "the first block of C in README.md is not examples/minimal.c"; return 1; }
}

layers_are_kept() {
    sh tests/layers.sh
}

library_is_built() {
    [ -f "$static" ] && [ -f "$shared" ] || { echo "no $shared: make lib"; return 1; }
}

rule layers layers_are_kept
check_headers
rule library-is-built library_is_built
if [ -f "$static" ] && [ -f "$shared" ]; then
    rule only-htree-is-exported only_ours_is_exported "$shared" htree_
    rule nothing-exits-or-prints nothing_exits_or_prints "$shared"
    rule needs-libc-only needs_libc_only "$shared" none
    rule is-hardened is_hardened "$shared"
    rule no-writable-globals no_writable_globals "$static"
fi
if has_opencl; then
    rule only-htree-cl-is-exported only_ours_is_exported "$shared_cl" htree_cl_
    rule nothing-of-cl-exits-or-prints nothing_exits_or_prints "$shared_cl"
    rule cl-is-hardened is_hardened "$shared_cl"
    rule cl-needs-htree-and-libc-only needs_libc_only "$shared_cl" 'libhtree|libdl'
    rule no-writable-globals-of-cl no_writable_globals "$static_cl"
fi
rule readme-shows-minimal.c readme_shows_minimal_c
rule sources-are-ascii sources_are_ascii
rule no-marks-of-unfinished-work no_marks_of_unfinished_work
rule files-are-short files_are_short
exit $bad
