#!/bin/sh
# mutants.sh [NUMBER...]: tests of the tests. Puts the bugs of tests/mutants.txt, or those of these numbers,
# one by one into a copy of this checkout under build/mutants, and runs the tests that must fail: by
# themselves, quickly, at a twentieth of their counts. Prints a line for each bug; the last one is
# `N of N caught`. A bug whose text is no longer there is stale, and counts as not caught.
set -u
cd "$(dirname "$0")/.." || exit 1
list=$(pwd)/tests/mutants.txt
copy=build/mutants
LIMIT=60 # seconds a test
export HTREE_TEST_SCALE="${HTREE_TEST_SCALE:-0.05}"
export ASAN_OPTIONS=detect_leaks=0

# Line $2 (bug, file, find, put, test) of bug number $1.
entry() {
    awk -v wanted="$1" -v key="$2: " '
        /^bug: / { ++n }
        n == wanted && index($0, key) == 1 { print substr($0, length(key) + 1) }' "$list"
}

# Replaces the one place in file $1 where text $2 stands by text $3; \n in them is the end of a line.
replace() {
    FIND=$2 PUT=$3 awk '
        { text = text $0 "\n" }
        END {
            find = ENVIRON["FIND"]; put = ENVIRON["PUT"]
            gsub(/\\n/, "\n", find); gsub(/\\n/, "\n", put)
            at = index(text, find)
            if (!at || index(substr(text, at + 1), find)) exit 1
            printf "%s", substr(text, 1, at - 1) put substr(text, at + length(find))
        }' "$1" >"$1.mutant" && mv "$1.mutant" "$1"
}

build() {
    make -C "$copy" -s config=debug CFLAGS="-O1 -g0 -DNDEBUG -w" "build/debug/tests/test_$1" >"$copy/log" 2>&1
}

# Succeeds if test $1, built anew, fails.
fails() {
    build "$1" || { echo "build"; return 0; }
    (cd "$copy" && timeout "$LIMIT" "build/debug/tests/test_$1" >log 2>&1)
    code=$?
    [ $code -ne 0 ] && echo "test_$1"
}

# Files that differ are copied anew, so that make sees that the bug of the last run is gone.
git ls-files -co --exclude-standard | while read -r file; do
    cmp -s "$file" "$copy/$file" || { mkdir -p "$copy/$(dirname "$file")" && cp "$file" "$copy/$file"; }
done
count=$(grep -c '^bug: ' "$list")
[ $# -gt 0 ] || set -- $(seq "$count")
for name in $(for number in "$@"; do entry "$number" test; done | tr ' ' '\n' | sort -u); do
    build "$name" || { cat "$copy/log"; exit 1; }
    (cd "$copy" && timeout 600 "build/debug/tests/test_$name" >log 2>&1) ||
        { echo "FAILED test_$name fails without any bug"; tail -n 20 "$copy/log"; exit 1; }
done

caught=0
for number in "$@"; do
    file=$(entry "$number" file)
    bug=$(entry "$number" bug)
    cp -p "$file" "$copy/$file"
    if ! replace "$copy/$file" "$(entry "$number" find)" "$(entry "$number" put)"; then
        echo "STALE $number: $bug: its text is not in $file, or not once"
        cp "$file" "$copy/$file"
        continue
    fi
    by=
    for name in $(entry "$number" test); do by=$(fails "$name") && break; done
    if [ -n "$by" ] && [ "$by" != build ]; then
        caught=$((caught + 1))
        echo "ok $number: $bug: $by"
    else
        echo "MISSED $number: $bug${by:+ (it does not compile)}"
    fi
    cp "$file" "$copy/$file"
done
echo "$caught of $# caught"
[ "$caught" -eq $# ]
