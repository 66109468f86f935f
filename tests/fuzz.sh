#!/bin/sh
# fuzz.sh FOLDER SECONDS [TARGET...]: runs the libFuzzer programs of FOLDER for so many seconds each, two
# at a time, with the corpora in FOLDER/corpus, which are kept. What is found lies in FOLDER/found; the
# last line counts runs and findings. An input that takes FUZZ_TIMEOUT=10 seconds is a finding.
set -u
folder=$1 seconds=$2
shift 2
[ $# -gt 0 ] || set -- ply aff tree scene api
mkdir -p "$folder/found"

run_target() {
    corpus=$folder/corpus/$1 log=$folder/$1.log
    mkdir -p "$corpus"
    FUZZ_SEEDS=$corpus "$folder/fuzz_$1" >"$log" 2>&1 || { cat "$log"; return 1; }
    ASAN_OPTIONS=allocator_may_return_null=1 "$folder/fuzz_$1" "-max_total_time=$seconds" -max_len=8192 \
        "-timeout=${FUZZ_TIMEOUT:-10}" -rss_limit_mb=2048 -print_final_stats=1 "-artifact_prefix=$folder/found/$1-" \
        "$corpus" >>"$log" 2>&1
    code=$?
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
    echo "$1: ${runs:-0} runs, ${edges:-0} edges$([ $code -eq 0 ] || echo ", FOUND: $log")"
}

if [ "${FUZZ_ONE-}" ]; then
    run_target "$1"
    exit
fi
printf '%s\n' "$@" | FUZZ_ONE=1 xargs -P "${JOBS:-2}" -n 1 sh "$0" "$folder" "$seconds" | tee "$folder/summary"
awk '{ runs += $2 } / FOUND: / { ++found } END { printf "%d runs, %d findings\n", runs, found; exit found > 0 }' \
    "$folder/summary"
