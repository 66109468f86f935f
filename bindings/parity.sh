#!/bin/sh
# parity.sh [--write]: every public function of include/htree.h has its place in every binding.
#
# A binding is a folder with a test.sh; it has a function if its sources, comments, tests and examples
# aside, name the C symbol. Prints what is missing, and whether the table in bindings/README.md is
# stale; exits with 1 if anything is. --write writes the table.
set -u
cd "$(dirname "$0")/.." || exit 1
readme=bindings/README.md
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

# The names that HTREE_API declares, in the header's order. A declaration may take several lines.
functions() {
    sed 's,/\*[^*]*\*/,,' include/htree.h |
        awk '/^#/ { next }
            /^HTREE_API / { waiting = 1 }
            waiting && match($0, /htree_[a-z_]+\(/) { print substr($0, RSTART, RLENGTH - 1); waiting = 0 }'
}

bindings() {
    for test in bindings/*/test.sh; do
        [ -f "$test" ] && basename "$(dirname "$test")"
    done
}

# The sources of binding $1 without lines that are comments: what a build or a test made, and what is
# only written about, does not count.
sources() {
    find "bindings/$1" \( -name tests -o -name test -o -name examples -o -name target -o -name build \
        -o -name node_modules -o -name '.*' -o -name '__pycache__' \) -prune \
        -o -type f ! -name '*.md' ! -name '*_test.go' ! -name '*.test.*' ! -name test.sh -print |
        while read -r file; do
            grep -vE '^[[:space:]]*(//|/\*|\*|#([^[a-z!]|$))' "$file"
        done
}

table() {
    printf '| function |' && sed 's/.*/ & |/' "$work/bindings" | tr -d '\n' && echo
    printf '|---|' && sed 's/.*/:-:|/' "$work/bindings" | tr -d '\n' && echo
    while read -r function; do
        printf '| `%s` |' "$function"
        while read -r binding; do
            if grep -qw "$function" "$work/sources.$binding"; then printf ' yes |'; else printf ' - |'; fi
        done <"$work/bindings"
        echo
    done <"$work/functions"
}

# README.md with the table between its marks.
with_table() {
    awk -v table="$work/table" '
        /^<!-- parity -->$/ { print; while ((getline line < table) > 0) print line; inside = 1; next }
        /^<!-- end of parity -->$/ { inside = 0 }
        !inside' "$readme"
}

functions >"$work/functions"
bindings >"$work/bindings"
count=$(wc -l <"$work/functions")
if [ "$count" -lt 1 ] || [ ! -s "$work/bindings" ]; then
    echo "FAILED parity: found $count functions in include/htree.h and these bindings:" $(cat "$work/bindings")
    exit 1
fi
while read -r binding; do sources "$binding" >"$work/sources.$binding"; done <"$work/bindings"
table >"$work/table"
with_table >"$work/readme"

bad=0
for binding in $(cat "$work/bindings"); do
    missing=$(while read -r function; do
        grep -qw "$function" "$work/sources.$binding" || echo "$function"
    done <"$work/functions")
    [ -z "$missing" ] && continue
    bad=1
    echo "FAILED parity: bindings/$binding lacks" $missing
done
if [ "$(grep -cE '^<!-- (end of )?parity -->$' "$readme")" -ne 2 ]; then
    bad=1
    echo "FAILED parity: $readme lacks the marks of the table"
elif [ "${1-}" = --write ]; then
    cp "$work/readme" "$readme"
elif ! cmp -s "$work/readme" "$readme"; then
    bad=1
    echo "FAILED parity: the table in $readme is stale: sh bindings/parity.sh --write"
fi
[ $bad -eq 0 ] && echo "ok parity: $count functions in $(tr '\n' ' ' <"$work/bindings" | sed 's/ $//')"
exit $bad
