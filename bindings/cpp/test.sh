#!/bin/sh
# test.sh: builds and runs every test of the C++ headers, from anywhere. HTREE_LIB_DIR,
# HTREE_CONFORMANCE and HTREE_BINDINGS_OUT are described in ../README.md. The last line is
# `cpp: N passed, N failed`; status 77 means that the machine lacks what the tests need.
set -u
here=$(cd "$(dirname "$0")" && pwd) || exit 1
root=$(cd "$here/../.." && pwd) || exit 1
lib=${HTREE_LIB_DIR:-$root/build/release}
out=${HTREE_BINDINGS_OUT:-$root/build/bindings/cpp}
HTREE_CONFORMANCE=${HTREE_CONFORMANCE:-$root/build/release/conformance.json}
LD_LIBRARY_PATH=$lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export HTREE_CONFORMANCE LD_LIBRARY_PATH
LIMIT=300 # seconds a program
passed=0 failed=0

have() {
    command -v "$1" >/dev/null 2>&1
}

skip() {
    echo "skipped cpp: $1"
    exit 77
}

have g++ || skip "g++ is missing (apt-get install g++)"
includes() {
    echo "#include <$1>" | g++ -std=c++11 -x c++ -fsyntax-only - 2>/dev/null
}
includes doctest/doctest.h || skip "doctest is missing (apt-get install doctest-dev)"
includes nlohmann/json.hpp || skip "nlohmann's json is missing (apt-get install nlohmann-json3-dev)"
mkdir -p "$out" || exit 1
compilers=g++
if have clang++; then compilers="g++ clang++"; else echo "note: no clang++: tested with g++ only"; fi

# Runs test $1, the words after it. A failing test shows what it printed.
check() {
    name=$1
    shift
    if "$@" >"$out/log" 2>&1; then
        passed=$((passed + 1))
        echo "ok $name"
    else
        failed=$((failed + 1))
        sed 's/^/    /' "$out/log"
        echo "FAILED $name"
    fi
}

limited() {
    if have timeout; then timeout "$LIMIT" "$@"; else "$@"; fi
}

WARN="-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"
INCLUDES="-I$root/include -I$here/include"
LINK="-L$lib -lhtree -lm -lpthread"

# ---- The tests in every standard, by every compiler, in both ways of errors --------------------------

# Builds the tests in folder $1 with compiler $2 and flags $3, a file at a time on each core.
build() {
    mkdir -p "$1"
    # shellcheck disable=SC2086
    printf '%s\n' "$here"/tests/*.cpp |
        xargs -P "${JOBS:-2}" -I FILE sh -c '
            "$1" $2 -c "$4" -o "$3/$(basename "$4" .cpp).o"' sh "$2" "$3" "$1" FILE &&
        "$2" $3 -o "$1/tests" "$1"/*.o $LINK
}

# Builds and runs; every test case of the program counts.
suite() {
    suite=$1 folder=$out/$1
    rm -rf "$folder"
    check "$suite compiles" build "$folder" "$2" "$3 $WARN $INCLUDES"
    [ -x "$folder/tests" ] || return
    limited "$folder/tests" >"$folder/log" 2>&1
    code=$?
    good=$(sed -n 's/.*test cases:.*| *\([0-9]*\) passed.*/\1/p' "$folder/log")
    bad=$(sed -n 's/.*test cases:.*| *\([0-9]*\) failed.*/\1/p' "$folder/log")
    passed=$((passed + ${good:-0})) failed=$((failed + ${bad:-0}))
    if [ $code -eq 0 ] && [ "${good:-0}" -gt 0 ]; then
        echo "ok $suite: $good tests"
    else
        [ "${bad:-0}" -gt 0 ] || failed=$((failed + 1))
        sed 's/^/    /' "$folder/log"
        echo "FAILED $suite: exit status $code"
    fi
}

NO_EXCEPTIONS="-fno-exceptions -fno-rtti -DDOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS"
for compiler in $compilers; do
    for standard in 11 17 20; do
        suite "$compiler-c++$standard" "$compiler" "-std=c++$standard -O0"
        suite "$compiler-c++$standard-no-exceptions" "$compiler" "-std=c++$standard -O0 $NO_EXCEPTIONS"
    done
done
suite g++-c++17-status g++ "-std=c++17 -O2 -DHTREE_HPP_STATUS"
SANITIZE="-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all"
suite g++-c++20-sanitized g++ "-std=c++20 $SANITIZE"

# ---- What must not compile, and what must be refused -------------------------------------------------

# Succeeds if the statements $2 compile. With $1 = no, if they do not.
compiles() {
    printf '#include <htree.hpp>\nvoid f(const ht::tree &t, ht::options o) {\n(void)t; (void)o; %s\n}\n' \
        "$2" >"$out/snippet.cpp"
    # shellcheck disable=SC2086
    if g++ -std=c++11 $INCLUDES -fsyntax-only "$out/snippet.cpp"; then
        [ "$1" = yes ]
    else
        [ "$1" = no ]
    fi
}

check "noexcept callbacks are taken" compiles yes 'auto p = [](double) noexcept { return false; }; o.progress(p);'
check "callbacks that may throw are not" compiles no 'auto p = [](double) { return false; }; o.progress(p);'
check "temporary callbacks are not" compiles no 'o.progress([](double) noexcept { return false; });'
check "objects that may throw are not" compiles no \
    'auto p = [](uint32_t, const ht::ray &, ht::hit &) { return false; }; ht::mesh().objects(nullptr, 0, p);'
check "tasks that may throw are not" compiles no 'auto p = [](uint32_t, ht::task) {}; o.tasks(p);'
check "a tree is not copied" compiles no 'ht::tree copy(t);'
check "a tree can be viewed" compiles yes 't.view();'
check "a tree that others may ask is not completed" compiles no 't.complete();'
check "nor updated" compiles no 't.update(ht::mesh(), ht::how::refit);'
check "a tree that is about to die cannot be viewed" compiles no 'ht::tree().view();'
check "vertices need three floats" compiles no 'double v[3] = {0, 0, 0}; ht::mesh m(v, 1); (void)m;'

# A header of the next minor version, over this library.
refuses_another_abi() {
    mkdir -p "$out/abi"
    sed 's/\(#define HTREE_VERSION_MINOR\) \([0-9]*\)/\1 (\2 + 1)/' "$root/include/htree.h" >"$out/abi/htree.h"
    ! cmp -s "$root/include/htree.h" "$out/abi/htree.h" || return 1
    # shellcheck disable=SC2086
    g++ -std=c++11 "-I$out/abi" "-I$here/include" "$here/examples/minimal.cpp" -o "$out/abi/minimal" $LINK || return 1
    "$out/abi/minimal" 2>"$out/abi/log" && return 1
    cat "$out/abi/log"
    grep -q '^unsupported: .*ABI' "$out/abi/log"
}
check "another minor version is refused" refuses_another_abi

# ---- The examples ------------------------------------------------------------------------------------

readme_shows_minimal() {
    awk '/^```cpp$/ { inside = 1; next } /^```$/ { if (inside) exit } inside' "$here/README.md" |
        diff -u "$here/examples/minimal.cpp" -
}
check "README.md shows minimal.cpp" readme_shows_minimal

# Example $1, the plain way.
example() {
    # shellcheck disable=SC2086
    g++ -std=c++11 -O2 $WARN $INCLUDES "$here/examples/$1.cpp" -o "$out/$1" $LINK
}

minimal_hits() {
    "$1" | tee "$out/minimal.txt" && grep -q '^triangle 3 at t = 1\.66667$' "$out/minimal.txt"
}

# The same picture by every kind of tree, of the right size, and not of one colour.
picture_is_drawn() {
    for kind in h kd bvh-sah ug; do "$1" "$out/$kind.ppm" $kind || return 1; done
    for kind in kd bvh-sah ug; do cmp "$out/h.ppm" "$out/$kind.ppm" || return 1; done
    [ "$(wc -c <"$out/h.ppm")" -eq $((15 + 320 * 240 * 3)) ] || return 1
    [ "$(od -An -v -tu1 -w3 -j15 "$out/h.ppm" | sort -u | wc -l)" -gt 1000 ]
}

check "minimal.cpp compiles" example minimal
check "minimal.cpp hits" minimal_hits "$out/minimal"
check "picture.cpp compiles" example picture
check "picture.cpp draws" picture_is_drawn "$out/picture"
check "picture.cpp refuses an unknown kind" sh -c '! "$1" "$2" no-such-kind' sh "$out/picture" "$out/no.ppm"

with_cmake() {
    rm -rf "$out/cmake"
    cmake -S "$here/examples" -B "$out/cmake" -DCMAKE_BUILD_TYPE=Release "-DHTREE_INCLUDE=$root/include" \
        "-DHTREE_LIB_DIR=$lib" && cmake --build "$out/cmake" && minimal_hits "$out/cmake/minimal"
}
if have cmake; then
    check "a CMake project builds and runs" with_cmake
else
    echo "note: no cmake: its example is not tested (apt-get install cmake)"
fi

is_formatted() {
    (cd "$root" && clang-format --dry-run -Werror "$here"/include/*.hpp "$here"/include/htree/*.hpp \
        "$here"/tests/*.[ch]pp "$here"/examples/*.cpp)
}
if have clang-format; then check "clang-format changes nothing" is_formatted; fi

echo "cpp: $passed passed, $failed failed"
[ $failed -eq 0 ]
