#!/bin/sh
# run.sh CONFIG...: runs every test program of each config (release debug sanitize tsan coverage), two
# at a time; and tests/NAME.sh for every other word that it knows, one after the other beside them. What
# the programs of release counted is held against tests/bars.txt. The last line is `N passed, N failed`.
#
# HTREE_TEST_SCALE, if set, replaces the scale of every config, and no bar is held; JOBS replaces the
# number of programs that run at once.
set -u
cd "$(dirname "$0")/.." || exit 1
LIMIT=600 # seconds a program

scale_of() {
    case $1 in
    release) echo 1 ;;
    debug | coverage) echo 0.3 ;;
    sanitize) echo 0.1 ;;
    *) echo 0.05 ;;
    esac
}

limited() {
    if command -v timeout >/dev/null; then timeout "$LIMIT" "$@"; else "$@"; fi
}

# Thread sanitizer sees races in a driver that was not built for it, so only the mock runs under it; and
# none where there is one thread.
suits() {
    case $1-$(basename "$2" | sed 's/^test_//') in
    tsan-cl | tsan-cl_api | tsan-cl_processes) return 1 ;;
    tsan-cl_arguments | tsan-cl_devices | tsan-cl_faults) return 1 ;;
    tsan-aff | tsan-exact | tsan-file_broken | tsan-golden | tsan-isa | tsan-paper) return 1 ;;
    tsan-query | tsan-skew | tsan-special | tsan-subdivide | tsan-trace | tsan-triangle | tsan-watertight) return 1 ;;
    esac
}

# The number of tests that cmocka's summary calls $1 (PASSED or FAILED) in log $2.
number() {
    n=$(sed -n "s/^\[  $1  \] \([0-9][0-9]*\) test(s).*/\1/p" "$2" | tail -n 1)
    echo "${n:-0}"
}

# Runs program $2 of config $1 and appends `passed failed` to file $3. What it prints comes in one
# piece, because two of these run at once.
run_program() {
    config=$1 name=$(basename "$2") log=$2.log
    export HTREE_TEST_SCALE="${HTREE_TEST_SCALE:-$(scale_of "$config")}"
    export ASAN_OPTIONS="${ASAN_OPTIONS:-allocator_may_return_null=1}"
    export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions=$PWD/tests/lsan.txt:print_suppressions=0}"
    export UBSAN_OPTIONS="${UBSAN_OPTIONS:-print_stacktrace=1}"
    start=$(date +%s)
    limited "$2" >"$log" 2>&1
    code=$?
    passed=$(number PASSED "$log") failed=$(number FAILED "$log")
    why=
    if [ "$code" -ne 0 ] && [ "$failed" -eq 0 ]; then failed=1 why=" (exit status $code)"; fi
    if [ "$code" -eq 124 ]; then why=" (stopped after $LIMIT s)"; fi
    if [ $((passed + failed)) -eq 0 ]; then failed=1 why=" (it ran no test)"; fi
    echo "$passed $failed" >>"$3"
    text=$(printf '%-16s %-9s %4d s  %3d passed, %d failed%s' "${name#test_}" "$config" \
        $(($(date +%s) - start)) "$passed" "$failed" "$why")
    if [ "$failed" -ne 0 ]; then
        more=$(sed 's/^/    /' "$log")
    else
        more=$(sed -n 's/^count: /    /p' "$log")
    fi
    printf '%s\n' "$text${more:+
$more}"
}

# Adds up what the programs of release tallied, as `NUMBER NAME`, and appends to file $1 how many of the
# bars are met.
hold_bars() {
    for source in tests/test_*.c; do sed -n 's/^tally: //p' "build/release/tests/$(basename "$source" .c).log"; done \
        2>/dev/null | awk -v results="$1" -v whole="$([ -z "${HTREE_TEST_SCALE-}" ] && echo 1)" '
        /^#/ { next }
        { name = $0; sub(/^[0-9]+ /, "", name) }
        NR == FNR { bar[name] = $1; order[++bars] = name; next }
        { sum[name] += $1 }
        END {
            for (i = 1; i <= bars; ++i) {
                name = order[i]
                if (!whole) { printf "%12d %s\n", sum[name], name; continue }
                met = sum[name] >= bar[name]
                printf "%-6s %12d %s, %d at least\n", met ? "ok" : "FAILED", sum[name], name, bar[name]
                print met, !met >> results
            }
        }' tests/bars.txt -
}

# Runs tests/$1.sh, which prints `ok`, `FAILED` or `skipped` for each rule, and appends to file $2.
run_script() {
    log=build/$1.log
    sh "tests/$1.sh" >"$log" 2>&1
    code=$?
    cat "$log"
    passed=$(grep -c '^ok ' "$log") failed=$(grep -c '^FAILED ' "$log")
    if [ "$failed" -eq 0 ] && { [ "$code" -ne 0 ] || ! grep -qE '^(ok|skipped) ' "$log"; }; then
        failed=1
        echo "FAILED $1: tests/$1.sh checked nothing, or ended with $code"
    fi
    echo "$passed $failed" >>"$2"
}

case ${1-} in
--program)
    run_program "$2" "$3" "$4"
    exit 0
    ;;
--scripts)
    results=$2
    shift 2
    for name in "$@"; do run_script "$name" "$results"; done
    exit 0
    ;;
esac

# Prints a line of arguments for this script for each program of config $1, whose results go to file $2.
list_programs() {
    programs=$(find "build/$1/tests" -maxdepth 1 -type f -name 'test_*' ! -name '*.*' 2>/dev/null | sort)
    if [ -z "$programs" ]; then
        echo "FAILED $1: no programs in build/$1/tests: make config=$1 tests" >&2
        echo "0 1" >>"$2"
    fi
    for program in $programs; do
        # A program whose source is gone is left over from an earlier build.
        if [ -f "tests/$(basename "$program").c" ] && suits "$1" "$program"; then echo "--program $1 $program $2"; fi
    done
}

mkdir -p build
results=$(mktemp build/results.XXXXXX) || exit 1
trap 'rm -f "$results"' EXIT
scripts='' configs=''
for word in "$@"; do
    case $word in
    release | debug | sanitize | tsan | coverage) configs="$configs $word" ;;
    *) scripts="$scripts $word" ;;
    esac
done
{
    [ -z "$scripts" ] || echo "--scripts $results$scripts"
    for config in $configs; do list_programs "$config" "$results"; done
} | xargs -P "${JOBS:-2}" -L 1 sh tests/run.sh
case $configs in *release*) hold_bars "$results" ;; esac

awk '{ passed += $1; failed += $2 }
    END { printf "%d passed, %d failed\n", passed, failed; exit passed + failed == 0 || failed > 0 }' "$results"
