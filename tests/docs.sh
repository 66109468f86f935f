#!/bin/sh
# docs.sh: every block of C in README.md, CONTRIBUTING.md and docs/ compiles without a warning, and runs if it is
# a program; links lead somewhere; figures of README.md and of Rust's are those of docs/results; drawings are what
# `make drawings` draws; doxygen has nothing to say; help fits a screen. Prints `ok docs-NAME`, `FAILED docs-NAME: why`
# or `skipped docs-NAME: why` for each.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=docs-
. tests/common/rules.sh
CC=${CC:-cc}
work=build/docs
pages="README.md CONTRIBUTING.md docs/*.md packaging/README.md examples/README.md tests/README.md lib/README.md
    lib/trace/README.md bindings/README.md"

# What a block that is no program may use without saying where it comes from.
prelude() {
    cat <<'C'
#define _POSIX_C_SOURCE 200809L
#include <htree.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
extern htree *tree;
extern const htree_mesh mesh;
extern float *positions;
extern htree_ray *rays;
extern htree_hit *hits;
extern uint64_t ray_count;
extern int frames;
void move(float *positions, int frame);
C
    grep -q 'htree_cl' "$1" && cat <<'C'
#include <htree_cl.h>
extern htree_cl *device;
extern htree_cl_tree *uploaded;
extern cl_command_queue queue;
extern cl_mem ray_buffer, hit_buffer;
C
    return 0
}

# Programs are taken as they are; functions get the prelude, statements a function around them too.
write_unit() {
    if grep -q '^int main' "$1"; then
        cat "$1"
        return
    fi
    prelude "$1"
    if grep -q '^static ' "$1"; then
        cat "$1"
    else
        echo 'void block(void);'
        echo 'void block(void) {'
        cat "$1"
        echo '}'
    fi
}

has_opencl() {
    echo '#include <CL/cl.h>' | $CC -DCL_TARGET_OPENCL_VERSION=120 -E - >/dev/null 2>&1
}

blocks_compile() {
    rm -rf "$work" && mkdir -p "$work"
    awk -v work="$work" '
        FNR == 1 { page = FILENAME; gsub(/[\/.]/, "_", page); n = 0 }
        /^```c$/ { file = work "/" page "_" ++n ".block"; next }
        /^```/ { file = "" }
        file { print >file }' README.md CONTRIBUTING.md docs/*.md
    count=0
    for block in "$work"/*.block; do
        grep -q htree_cl "$block" && ! has_opencl && continue
        unit=${block%.block}.c
        write_unit "$block" >"$unit"
        $CC -std=c99 -pedantic -Wall -Wextra -Wno-unused-variable -Wno-unused-function -Werror -Iinclude \
            -c -o "${unit%.c}.o" "$unit" || { echo "$unit does not compile" && return 1; }
        if grep -q '^int main' "$unit"; then
            $CC -o "${unit%.c}" "${unit%.c}.o" build/release/libhtree.a -lm -lpthread &&
                "${unit%.c}" || { echo "$unit does not run" && return 1; }
        fi
        count=$((count + 1))
    done
    [ $count -ge 15 ] || { echo "only $count blocks found" && return 1; }
    echo "count: $count blocks of C"
}

# Links to files, as [text](path) and ![text](path), seen from the page's folder.
links_lead_somewhere() {
    # shellcheck disable=SC2086
    for page in $pages; do
        for link in $(grep -oE '\]\([^)#]+' "$page" | sed 's/^](//' | grep -vE '^(https?|mailto):'); do
            [ -e "$(dirname "$page")/$link" ] || { echo "$page: no $link" && return 1; }
        done
    done
}

drawings_are_current() {
    MAKEFLAGS='' make -s config=release CC="$CC" build/release/docs/draw >/dev/null || return 1
    for drawing in docs/drawings/*.svg; do
        build/release/docs/draw "$(basename "$drawing" .svg)" | cmp - "$drawing" ||
            { echo "$drawing is old: make drawings" && return 1; }
    done
}

figures_are_measured() {
    [ "$(grep -c '^<!-- figures: ' README.md)" -ge 4 ] || { echo "README.md shows too few figures"; return 1; }
    for page in README.md bindings/rust/README.md; do
        sh docs/figures.sh $page >"$work/README.md" || return 1
        diff $page "$work/README.md" || { echo "$page has other figures than docs/results: make readme-figures"; return 1; }
    done
}

reference_is_clean() {
    rm -rf build/reference
    MAKEFLAGS='' make -s reference && grep -q htree_intersect build/reference/html/htree_8h.html
}

help_fits() { # 40 lines of 100 characters, and three examples
    for program in render animate table1 bench visibility nodes; do
        name=htree-$program
        "build/release/$name" --help >"$work/help" || return 1
        [ "$(wc -l <"$work/help")" -le 40 ] || { echo "$name --help has $(wc -l <"$work/help") lines"; return 1; }
        ! grep '.\{101\}' "$work/help" || { echo "$name --help has lines that are too long"; return 1; }
        [ "$(grep -c "^  $name " "$work/help")" -ge 3 ] || { echo "$name --help has no three examples"; return 1; }
    done
}

rule blocks-compile blocks_compile
rule links-lead-somewhere links_lead_somewhere
rule figures-are-measured figures_are_measured
rule drawings-are-current drawings_are_current
[ -x build/release/htree-render ] && rule help-fits help_fits
if have doxygen; then
    rule reference-is-clean reference_is_clean
else
    skip reference-is-clean 'no doxygen (apt-get install doxygen)'
fi
exit $bad
