#!/bin/sh
# bench.sh: what htree-bench promises beside its figures: JSON that parses, rays that come back bit for
# bit, and a line on stderr for whatever it refuses. Prints `ok NAME` or `FAILED NAME: why` for each rule,
# and the details above it. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=bench-
. tests/common/rules.sh
bench=${1:-build/release}/htree-bench
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
small='--scene knot:3000 --size 64x48 --frame 30 --rounds 1 --seconds 0'

if [ ! -x "$bench" ]; then
    skip_all "there is no $bench (it needs libpng)"
fi

# The program with small figures and more words; what it says goes to $work/out and $work/err.
run() {
    # shellcheck disable=SC2086
    "$bench" $small "$@" >"$work/out" 2>"$work/err"
}

works() {
    run "$@" || { cat "$work/err"; echo "$* ended with $?"; return 1; }
}

# Ends with status $1 and one line on stderr that contains $2, when given the words after these.
refuses() {
    status=$1 text=$2
    shift 2
    run "$@"
    code=$?
    [ "$code" -eq "$status" ] || { echo "$* ended with $code, not $status"; return 1; }
    [ "$(wc -l <"$work/err")" -eq 1 ] || { cat "$work/err"; echo "$* did not say one line"; return 1; }
    grep -q -e "$text" "$work/err" || { cat "$work/err"; echo "$* did not say '$text'"; return 1; }
}

# ---- What it writes -----------------------------------------------------------------------------------

keys='scene peer config threads ns_per_triangle bytes_per_triangle peak_bytes_per_triangle
    refit_ns_per_triangle mrays_primary mrays_primary_packet mrays_ao mrays_diffuse T_T_ms disagreements'

json_parses() {
    works --threads 1,2 --kind fast,h,fast+lazy,best,best+compact --json "$work/a.json" || return 1
    python3 -m json.tool "$work/a.json" >"$work/a.txt" || { echo "not JSON"; return 1; }
    for key in $keys; do
        [ "$(grep -c "\"$key\":" "$work/a.txt")" -eq 10 ] || { echo "$key is not in each of ten rows"; return 1; }
    done
    ! grep -q '"ns_per_triangle": null\|"mrays_[adps].*y*": 0,\|"T_T_ms": null' "$work/a.txt" ||
        { echo "a figure is missing"; return 1; }
    [ "$(grep -c '"refit_ns_per_triangle": null' "$work/a.txt")" -eq 6 ] ||
        { echo "h, lazy and compact trees are not refitted, others are"; return 1; }
    [ "$(grep -c '"disagreements": 0$' "$work/a.txt")" -eq 10 ] || { echo "structures disagree"; return 1; }
}

says_nothing_on_stderr() {
    works || return 1
    [ ! -s "$work/err" ] || { cat "$work/err"; echo "a progress bar without a terminal"; return 1; }
}

# Lines that name a set of rays, their number, and how many hit.
sets() {
    grep -E '^(primary|frame|ambient|diffuse|shadow): ' "$work/out"
}

rays_come_back() {
    works --kind fast --threads 1 --save-rays "$work/a.rays" || return 1
    sets >"$work/a.sets"
    [ "$(wc -l <"$work/a.sets")" -eq 5 ] || { echo "not five sets of rays"; return 1; }
    works --kind h --threads 2 --load-rays "$work/a.rays" --save-rays "$work/b.rays" || return 1
    sets >"$work/b.sets"
    cmp "$work/a.rays" "$work/b.rays" || return 1
    diff "$work/a.sets" "$work/b.sets" || { echo "loaded rays hit other things"; return 1; }
}

seeds_make_other_rays() {
    works --kind fast --seed 1 --save-rays "$work/a.rays" || return 1
    works --kind fast --seed 2 --save-rays "$work/b.rays" || return 1
    ! cmp -s "$work/a.rays" "$work/b.rays" || { echo "the seed changes nothing"; return 1; }
}

# ---- What it refuses ----------------------------------------------------------------------------------

broken_rays_are_refused() {
    works --kind fast --save-rays "$work/a.rays" || return 1
    head -c 100000 "$work/a.rays" >"$work/cut.rays"
    { cat "$work/a.rays"; echo; } >"$work/long.rays"
    sed '1s/htree/other/' "$work/a.rays" >"$work/other.rays"
    sed 's/^diffuse [0-9]* 0/diffuse 99999999999999 0/' "$work/a.rays" >"$work/huge.rays"
    sed 's/^frame \([0-9]*\) [0-9]*/frame \1 0/' "$work/a.rays" >"$work/row.rays"
    : >"$work/empty.rays"
    refuses 1 'ends before the last ray' --load-rays "$work/cut.rays" &&
        refuses 1 'more in it' --load-rays "$work/long.rays" &&
        refuses 1 'not a file of rays' --load-rays "$work/other.rays" &&
        refuses 1 'not a file of rays' --load-rays "$work/huge.rays" &&
        refuses 1 'not a file of rays' --load-rays "$work/row.rays" &&
        refuses 1 'not a file of rays' --load-rays "$work/empty.rays" &&
        refuses 1 'No such file' --load-rays "$work/none.rays" &&
        refuses 2 'No such file' --save-rays "$work/none/a.rays" &&
        refuses 2 'one scene' --scene city --load-rays "$work/a.rays" || return 1
    # shellcheck disable=SC2086
    "$bench" --scene knot:5000 --load-rays "$work/a.rays" >/dev/null 2>"$work/err"
    grep -q 'another number of triangles' "$work/err" || { echo "rays of another scene are traced"; return 1; }
}

arguments_are_refused() {
    refuses 2 'no such structure' --kind faster &&
        refuses 2 'after + comes' --kind fast+greedy &&
        refuses 2 'list of names' --kind fast,,best &&
        refuses 2 'give embree' --peer embre &&
        refuses 2 'give embree' --peer embree-slow &&
        refuses 2 'whole number from 0 to 256' --threads 1,300 &&
        refuses 2 'whole number from 0 to 256' --threads two &&
        refuses 2 'whole number from 1' --frame 0 &&
        refuses 2 'whole number from 1' --ambient 0 &&
        refuses 2 'whole number from 1' --rounds 0 &&
        refuses 2 'WIDTHxHEIGHT' --size 10 &&
        refuses 2 'no such scene' --scene nowhere &&
        refuses 2 'one number of --threads' --device none --threads 1,2 &&
        refuses 2 'unknown option' --fast &&
        refuses 2 'No such file' --json "$work/none/a.json" &&
        refuses 1 'none.ply' "$work/none.ply"
}

# ---- Beside the peer ----------------------------------------------------------------------------------

peer_agrees_or_is_missing() {
    if run --kind fast --peer embree-low,embree-refit,embree-medium-robust --threads 1,2 --json "$work/a.json"; then
        python3 -m json.tool "$work/a.json" >"$work/a.txt" || { echo "not JSON"; return 1; }
        [ "$(grep -c '"mrays_primary_packet": [0-9]' "$work/a.txt")" -eq 6 ] || { echo "packets are missing"; return 1; }
        grep -q '^htree against Embree in robust mode, 2 threads' "$work/out" || { echo "no ratios"; return 1; }
    else
        grep -q 'apt-get install libembree-dev' "$work/err" || { cat "$work/err"; return 1; }
    fi
}

# Lazy trees read the mesh as long as they live.
reads_no_freed_memory() {
    MAKEFLAGS='' make -s config=sanitize build/sanitize/htree-bench || return 1
    # shellcheck disable=SC2086
    UBSAN_OPTIONS=print_stacktrace=1 build/sanitize/htree-bench $small --frame 2 --threads 2 -q 2>&1 >"$work/out" | tail -n 20 >"$work/err"
    [ -s "$work/out" ] && [ ! -s "$work/err" ] || { cat "$work/err"; return 1; }
}

if have python3; then rule json-parses json_parses; else skip json-parses 'no python3'; fi
rule is-silent-without-a-terminal says_nothing_on_stderr
rule rays-come-back rays_come_back
rule seeds-make-other-rays seeds_make_other_rays
rule broken-rays-are-refused broken_rays_are_refused
rule arguments-are-refused arguments_are_refused
rule peer-agrees-or-is-missing peer_agrees_or_is_missing
rule reads-no-freed-memory reads_no_freed_memory
exit $bad
