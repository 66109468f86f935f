#!/bin/sh
# plots.sh TABLE1 RENDER OUT: measures and plots times per scene, heat maps, precision and growth
# into OUT; the data files stay beside the pictures, the machine and the command at their top.
#
# Scenes are looked for in HTREE_SCENES. OUT/table1.csv is taken as it is if it is there.
set -eu
table1=$1 render=$2 out=$3
scenes=${HTREE_SCENES:-scenes}
plots=$(dirname "$0")/plots
mkdir -p "$out"
command -v gnuplot >/dev/null || {
    echo "error: the plots need gnuplot (make deps, or apt-get install gnuplot-nox)" >&2
    exit 1
}

draw() { # draw SCRIPT PICTURE ASSIGNMENTS: the gnuplot script, told where things are
    gnuplot -e "folder='$plots'; out='$out/$2.png'; $3" "$plots/$1.gp"
    echo "  $out/$2.png"
}

grow() {
    # The slow kinds stop at a million, or the plot would take an hour.
    "$table1" --growth soup,waves --method kd,bvh-median,skd --to 1000000 >"$out/growth.dat"
    "$table1" --growth soup,waves --method ug,bvh-sah,h,ah --to 10000000 >>"$out/growth.dat"
    draw growth growth "data='$out/growth.dat'"
}

bars() {
    [ -f "$out/table1.csv" ] || "$table1" --csv "$out/table1.csv" >"$out/table1.txt"
    {
        sed -n '/^# machine/p; /^# command/p' "$out/table1.txt"
        awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
                 { gsub(/"/, "", $1) }
                 $1 != scene { scene = $1; printf "\n\n# %s\n", scene }
                 { print $at["kind"], $at["T_C"], $at["T_R"] }' "$out/table1.csv"
    } >"$out/bars.dat"
    names=$(sed -n 's/^"\([^"]*\)".*/\1/p' "$out/table1.csv" | uniq | tr '\n' ' ')
    draw bars bars "data='$out/bars.dat'; scenes='$names'"
}

# heat NAME MAX RENDER-ARGUMENTS...: N_TS of three structures with one scale
heat() {
    name=$1 most=$2
    shift 2
    for kind in kd h ah; do
        "$render" "$@" --kind $kind --mode steps --heat-max "$most" -q \
            -o "$out/steps-$name-$kind.png"
    done
    draw heat "steps-$name" "heading='$name: nodes visited per ray (N_TS), 0 to $most'; \
        names='kd-tree H-tree AH-tree'; \
        files='$out/steps-$name-kd.png $out/steps-$name-h.png $out/steps-$name-ah.png'"
}

heats() {
    if [ -f "$scenes/bunny.ply" ]; then
        heat bunny 100 "$scenes/bunny.ply"
    else
        heat knot 100 --scene knot:69451
    fi
    if [ -f "$scenes/conference.ply" ]; then
        heat conference 200 "$scenes/conference.ply" --camera inside
    else
        heat crowd 60 --scene crowd:331179
    fi
}

precision() {
    "$table1" --precision --repeat 11 --scene bunny --scene conference \
        >"$out/precision.dat"
    names=$(sed -n 's/^# \(.*\)-h-buckets$/\1/p' "$out/precision.dat" | tr '\n' ' ')
    draw precision precision "data='$out/precision.dat'; scenes='$names'"
}

bars
heats
precision
grow
