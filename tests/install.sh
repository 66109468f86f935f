#!/bin/sh
# install.sh: what `make install` puts on a machine, moved to another place and used from there: examples
# build and run through pkg-config and CMake, shared and static, as C99 and C++17; pages of the manual are
# clean and, like completions, as complete as --help; uninstall leaves nothing. Prints `ok install-NAME`,
# `FAILED install-NAME: why` or `skipped install-NAME: why` for each rule. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=install-
. tests/common/rules.sh
CC=${CC:-cc}
CXX=${CXX:-c++}
work=$PWD/build/install
first=$work/first root=$work/moved

quiet_make() {
    MAKEFLAGS='' make --no-print-directory config=release CC="$CC" "$@" >/dev/null
}

# ---- What is installed ---------------------------------------------------------------------------------

# Below a prefix that is not there, and through DESTDIR; then the whole is moved.
installs() {
    rm -rf "$work" && mkdir -p "$work"
    quiet_make install DESTDIR="$first" PREFIX=/opt/htree || return 1
    mv "$first/opt/htree" "$root"
}

soname_is() { # soname_is LIBRARY NODE
    readelf -d "$root/lib/$1.so" | grep -q "SONAME.*\[$1\.so\.0\]" || { echo "no soname $1.so.0"; return 1; }
    nm -D --defined-only "$root/lib/$1.so" | awk -v node="$2" '
        $2 == "T" && $3 !~ "@@" node "$" { print $3 " is not of version " node; found = 1 }
        END { exit found }'
}

is_small() {
    strip -o "$work/stripped.so" "$root/lib/libhtree.so"
    bytes=$(wc -c <"$work/stripped.so")
    [ "$bytes" -le 614400 ] || { echo "libhtree.so has $bytes bytes"; return 1; }
}

uninstalls() {
    quiet_make install DESTDIR="$work/gone" libdir=/usr/local/lib/any || return 1
    quiet_make uninstall DESTDIR="$work/gone" libdir=/usr/local/lib/any || return 1
    left=$(find "$work/gone" ! -type d)
    [ -z "$left" ] || { echo "uninstall leaves $left"; return 1; }
}

# ---- Through pkg-config --------------------------------------------------------------------------------

in_place() { # in_place WORD...: with the moved files and nothing else of ours
    env PKG_CONFIG_PATH="$root/lib/pkgconfig" LD_LIBRARY_PATH="$root/lib" "$@"
}

minimal_is_right() {
    answer=$(in_place "$1") || { echo "$1 ended with $?: $answer"; return 1; }
    case $answer in "triangle 3 at t = "*) ;; *) echo "$1 says: $answer" && return 1 ;; esac
}

packaged() { # packaged NAME COMPILER LANGUAGE STANDARD SOURCE PACKAGE FLAG
    flags=$(in_place pkg-config --define-prefix --cflags --libs $7 "$6") || return 1
    [ -z "$7" ] || flags="$(echo "$flags" | sed 's/-lhtree\(_cl\)\{0,1\}\b/-l:libhtree\1.a/g')"
    # shellcheck disable=SC2086
    $2 -x "$3" "-std=$4" -o "$work/$1" "$5" -x none $flags -lm
}

packaged_minimal() {
    packaged "$@" && minimal_is_right "$work/$1"
}

# Without a device it says so, and that is an answer too: it found the library.
packaged_opencl() {
    packaged "$@" || return 1
    said=$(in_place "$work/$1" 2>&1) || case $said in *OpenCL*) ;; *) echo "$said" && return 1 ;; esac
}

check_packages() {
    minimal=$root/share/doc/libhtree/examples/minimal.c
    rule pkg-config-shared packaged_minimal minimal-shared "$CC" c c99 "$minimal" htree ''
    rule pkg-config-static packaged_minimal minimal-static "$CC" c c99 "$minimal" htree --static
    if have "$CXX"; then
        rule pkg-config-c++ packaged_minimal minimal-hpp "$CXX" c++ c++17 bindings/cpp/examples/minimal.cpp htree ''
    else
        skip pkg-config-c++ 'no C++ compiler (apt-get install g++)'
    fi
    if [ -f "$root/lib/libhtree_cl.so" ]; then
        opencl=$root/share/doc/libhtree/examples/opencl.c
        rule pkg-config-cl packaged_opencl opencl-shared "$CC" c c99 "$opencl" htree-cl ''
        rule pkg-config-cl-static packaged_opencl opencl-static "$CC" c c99 "$opencl" htree-cl --static
    fi
}

# ---- Through CMake -------------------------------------------------------------------------------------

consumer() { # consumer FOLDER VERSION: a project of somebody else's
    mkdir -p "$work/$1"
    cp examples/minimal.c examples/opencl.c bindings/cpp/examples/minimal.cpp "$work/$1/"
    cat >"$work/$1/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.16)
project(consumer LANGUAGES C CXX)
set(CMAKE_C_STANDARD 99)
set(CMAKE_CXX_STANDARD 17)
find_package(htree $2 REQUIRED)
add_executable(minimal minimal.c)
target_link_libraries(minimal PRIVATE htree::htree m)
add_executable(minimal-hpp minimal.cpp)
target_link_libraries(minimal-hpp PRIVATE htree::cpp)
if(TARGET htree::cl)
  add_executable(opencl opencl.c)
  target_link_libraries(opencl PRIVATE htree::cl m)
endif()
CMAKE
}

configure() { # configure FOLDER STATIC
    CC=$CC CXX=$CXX cmake -S "$work/$1" -B "$work/$1/build" -DCMAKE_PREFIX_PATH="$root" -DHTREE_STATIC="$2"
}

cmade() { # cmade FOLDER STATIC
    consumer "$1" 0.1
    configure "$1" "$2" && cmake --build "$work/$1/build" || return 1
    minimal_is_right "$work/$1/build/minimal" && minimal_is_right "$work/$1/build/minimal-hpp" || return 1
    needs=$(readelf -d "$work/$1/build/minimal" | grep -c 'NEEDED.*libhtree')
    [ "$needs" = "$([ "$2" = ON ] && echo 0 || echo 1)" ] || { echo "linked the other way: $needs"; return 1; }
}

# Before 1.0 another minor version is another ABI.
refuses_other_versions() {
    for version in 0.0.9 0.2 1.0; do
        consumer "wants-$version" $version
        if configure "wants-$version" OFF >/dev/null 2>&1; then
            echo "find_package(htree $version) takes this version"
            return 1
        fi
    done
}

# ---- The manual and completion -------------------------------------------------------------------------

lints() {
    # Neighbours are looked for where pages are installed, which is not here.
    found=$(mandoc -T lint -W style packaging/man/* | grep -v 'referenced manual not found')
    [ -z "$found" ] || { echo "$found"; return 1; }
}

manual_names_every_function() {
    for function in $(sed -n 's/^HTREE_API .*\b\(htree_[a-z_]*\)(.*/\1/p' include/htree.h); do
        grep -q "^\.F[no] $function\b" packaging/man/htree.3 || { echo "htree.3 lacks $function"; return 1; }
    done
}

# Every option of --help is in the page and the completion, and the other way round.
options_agree() {
    "$root/bin/$1" --help | grep -oE -- '--[a-z][a-z0-9-]+' | sort -u >"$work/$1.help"
    sed -n 's/^\.It //p' packaging/man/"$1.1" | grep -oE ' -[a-z][a-z0-9-]+' | sed 's/ -/--/' | sort -u \
        >"$work/$1.page"
    sed -n "/local options='/,/'\$/p" packaging/completion/"$1" | grep -oE -- '--[a-z][a-z0-9-]+' | sort -u \
        >"$work/$1.completion"
    diff "$work/$1.help" "$work/$1.page" && diff "$work/$1.help" "$work/$1.completion"
}

completes() { # completes PROGRAM WANTED WORD...: bash, asked to complete the last word, offers what is wanted
    program=$1 wanted=$2
    shift 2
    offered=$(PATH="$root/bin:$PATH" bash -c '
        . "$0" && COMP_WORDS=("$@") && COMP_CWORD=$(($# - 1)) && "_${1//-/_}" "$1" && echo "${COMPREPLY[*]}"
        ' "$root/share/bash-completion/completions/$program" "$program" "$@")
    [ "$offered" = "$wanted" ] || { echo "$program $* offers '$offered'"; return 1; }
}

check_programs() {
    for page in packaging/man/*.1; do
        program=$(basename "$page" .1)
        [ -x "$root/bin/$program" ] || continue
        rule "options-of-$program" options_agree "$program"
    done
    if [ -x "$root/bin/htree-render" ] && have bash; then
        rule completion-option completes htree-render '--mode' --mo
        rule completion-kind completes htree-render 'bvh-sah bvh-median' --kind bvh
        rule completion-scene completes htree-render 'terrain' --scene ter
        rule completion-list completes htree-table1 'kd,h,bvh-median kd,h,bvh-sah' --method kd,h,bvh
    fi
}

# ---- All of it -----------------------------------------------------------------------------------------

rule installs installs
[ -d "$root" ] || exit 1
rule soname soname_is libhtree HTREE_0.1
[ -f "$root/lib/libhtree_cl.so" ] && rule soname-of-cl soname_is libhtree_cl HTREE_0.1
rule is-small is_small
rule uninstalls uninstalls
if have pkg-config; then check_packages; else skip pkg-config 'no pkg-config'; fi
if have cmake && have "$CXX"; then
    rule cmake-shared cmade cmake-shared OFF
    rule cmake-static cmade cmake-static ON
    rule cmake-versions refuses_other_versions
else
    skip cmake 'no cmake, or no C++ compiler (apt-get install cmake g++)'
fi
rule manual-names-every-function manual_names_every_function
if have mandoc; then rule manual-lints lints; else skip manual-lints 'no mandoc (apt-get install mandoc)'; fi
check_programs
exit $bad
