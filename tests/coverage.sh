#!/bin/sh
# coverage.sh [TEST...]: what of lib/ the tests run, by gcov: lines and branches of every source file, and in
# build/coverage/uncovered every line of it that none of them ran. Runs what `make config=coverage tests`
# built: all programs that need no device, or these, at HTREE_TEST_SCALE (0.02).
set -u
cd "$(dirname "$0")/.." || exit 1
out=build/coverage
export HTREE_TEST_SCALE="${HTREE_TEST_SCALE:-0.02}"
if [ $# -eq 0 ]; then
    set -- $(find "$out/tests" -maxdepth 1 -type f -name 'test_*' ! -name '*.*' ! -name 'test_cl*' -exec basename {} \; |
        sed 's/^test_//' | sort)
fi

find "$out" -name '*.gcda' -exec rm -f {} +
printf '%s\n' "$@" | xargs -P "${JOBS:-2}" -I NAME sh -c '
    timeout 600 "$1/tests/test_NAME" >"$1/tests/test_NAME.log" 2>&1 || echo "FAILED test_NAME: $1/tests/test_NAME.log"
' sh "$out"

# Objects share headers: a line counts as run if any of them ran it.
for source in lib/base/*.c lib/tree/*.c lib/build/*.c lib/build/*/*.c lib/trace/*.c lib/trace/*/*.c; do
    [ -f "$out/${source%.c}.gcda" ] && gcov -t -b -c -o "$out/$(dirname "$source")" "$source" 2>/dev/null
done | awk -v list="$out/uncovered" '
    /^ *-: *0:Source:/ { file = $0; sub(/.*Source:/, "", file); line = 0; next }
    /^branch / { if (file ~ /^lib\//) { n = ++nth[file, line, ++k]; b = file SUBSEP line SUBSEP k
            branch[b] = 1; if ($0 !~ /never executed/ && $3 + ($4 + 0) > 0 && $0 !~ /taken 0($| )/) took[b] = 1 } next }
    /^(call|function|unconditional) / { next }
    file ~ /^lib\// {
        k = 0; split($0, part, ":"); count = part[1]; gsub(/ /, "", count); line = part[2] + 0
        if (line == 0 || count == "-") next
        text[file, line] = substr($0, index($0, part[3])); all[file, line] = 1
        if (count !~ /^[#=]/) ran[file, line] = 1
    }
    END {
        for (key in all) { split(key, at, SUBSEP); ++lines[at[1]]; if (key in ran) ++good[at[1]]
            else print at[1] ":" at[2] ":" text[key] | ("sort -t: -k1,1 -k2,2n >" list) }
        for (key in branch) { split(key, at, SUBSEP); ++ways[at[1]]; if (key in took) ++taken[at[1]] }
        for (file in lines) {
            printf "%-32s %5d of %5d lines %6.1f %%  %5d of %5d branches %6.1f %%\n", file, good[file], lines[file],
                100 * good[file] / lines[file], taken[file], ways[file], ways[file] ? 100 * taken[file] / ways[file] : 100 | "sort"
            l += lines[file]; g += good[file]; w += ways[file]; t += taken[file]
        }
        close("sort")
        if (l == 0) { print "nothing was measured: make config=coverage tests"; exit 1 }
        printf "%-32s %5d of %5d lines %6.1f %%  %5d of %5d branches %6.1f %%\n", "all", g, l, 100 * g / l, t, w, 100 * t / w
    }'
