#!/bin/sh
# bench.sh RENDER OUT [MESH]: times every kind on the built-in scenes, or on one mesh, single thread.
# Writes OUT/bench.txt: the machine, the command, and a row per scene and kind.
set -eu
render=$1 out=$2 mesh=${3:-}
mkdir -p "$out"
json=$(mktemp) && trap 'rm -f "$json"' EXIT

value() { sed -n "s/.*\"$1\"[^:]*: *\"\{0,1\}\([^,\"}]*\).*/\1/p" "$json" | head -n 1; }

row() { # row KIND SCENE-ARGUMENTS...
    kind=$1
    shift
    "$render" "$@" --kind "$kind" --threads 1 --size 500x500 --mode depth -q --json "$json" -o "$json.png" ||
        return 0
    rm -f "$json.png"
    awk -v scene="$(value scene)" -v kind="$kind" -v n="$(value triangles)" -v ns="$(value N_NS)" \
        -v ts="$(value N_TS)" -v it="$(value N_IT)" -v tc="$(value T_C)" -v tr="$(value T_R)" \
        -v bytes="$(value bytes)" 'BEGIN {
        printf "%-22s %-10s %9d %10d %7.2f %6.2f %9.2f %8.1f %9.2f %8.2f %7.1f\n", scene, kind, n, ns, ts, it,
            tc * 1e3, tc * 1e9 / n, tr * 1e3, 0.25 / tr, bytes / n }'
}

{
    echo "machine: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), 1 thread"
    echo "command: make bench${mesh:+ MESH=$(basename "$mesh")}"
    printf "%-22s %-10s %9s %10s %7s %6s %9s %8s %9s %8s %7s\n" scene kind triangles N_NS N_TS N_IT \
        "T_C ms" "ns/tri" "T_R ms" "Mrays/s" "B/tri"
    for kind in ug kd bvh-median bvh-sah skd h ah; do
        if [ -n "$mesh" ]; then
            row "$kind" "$mesh"
        else
            for scene in knot:70000 terrain:200000 city:100000 crowd:300000 soup:1000000; do
                row "$kind" --scene "$scene"
            done
        fi
    done
} | tee "$out/bench.txt"
