#!/bin/sh
# gallery.sh RENDERER OUT [MESH]: pictures of the built-in scenes, or of MESH, into OUT: each shaded,
# and as heat maps of nodes visited and triangles tested per ray. Prints the files and the figures.
set -eu

render=$1
out=$2
mesh=${3:-}
mkdir -p "$out"

# three NAME ARGUMENT...: the three pictures of one scene
three() {
    name=$1
    shift
    "$render" "$@" --mode shaded -o "$out/$name.png"
    "$render" "$@" --mode steps -o "$out/$name-steps.png" -q
    "$render" "$@" --mode tests -o "$out/$name-tests.png" --json "$out/$name.json" -q
    echo "  $out/$name.png $out/$name-steps.png $out/$name-tests.png"
    # The JSON has one figure per line: show those that the heat maps are about.
    tr -d ',"{}' <"$out/$name.json" |
        awk '$1 ~ /^(N_NS|N_TS|N_IT|T_C|T_R|hit_fraction):$/ { printf "  %s %.4g", $1, $2 }
             END { print "" }'
}

if [ -n "$mesh" ]; then
    name=$(basename "$mesh")
    three "${name%.*}" "$mesh"
else
    three knot --scene knot
    three terrain --scene terrain --camera 0.9,0.85,1.5,0,0.05,-0.1,42
    three city --scene city --camera 17,13,27,1,0,3,40
    three crowd --scene crowd --camera 5,4.2,9,0,0.2,1,48
    three soup --scene soup:5000
fi
