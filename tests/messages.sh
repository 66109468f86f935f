#!/bin/sh
# messages.sh: what a program says to somebody who asked for something that cannot be: one line that begins with its
# name and says what to do instead, soon, and no file is left. Prints `ok messages-PROGRAM` or `FAILED
# messages-PROGRAM: why`. Uses the release build.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=messages-
. tests/common/rules.sh
programs=build/release
work=$(mktemp -d) || exit 1
logs=$(mktemp -d) || exit 1
trap 'rm -rf "$work" "$logs"' EXIT

[ -x $programs/htree-render ] || skip_all 'no programs, libpng is missing'

echo "shopping: milk, eggs" >"$work/list.txt"
echo "shopping: milk, eggs" >"$work/list.ply"
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n' \
    >"$work/short.ply"

# PROGRAMS | what is asked for | exit status | what the line says
kinds='choose from ug kd bvh-median bvh-sah skd h ah wide fast balanced best'
table() {
    cat <<TABLE
render animate bench visibility nodes | --kidn h | 2 | unknown option --kidn; did you mean --kind?
table1 | --metod h | 2 | unknown option --metod; did you mean --method?
animate | --pipelnie cloth | 2 | unknown option --pipelnie; did you mean --pipeline?
render | --treads=4 | 2 | unknown option --treads=4; did you mean --threads?
render animate table1 bench visibility nodes | --banana | 2 | unknown option --banana; see --help
render animate table1 bench visibility nodes | -x | 2 | unknown option -x; see --help
render animate bench visibility nodes | --kind | 2 | option --kind needs a value; see --help
render animate bench visibility nodes | --kind bvh | 2 | --kind bvh: no such structure; $kinds
table1 | --method bvh | 2 | --method bvh: no such structure; choose from
render animate table1 bench visibility | --size big | 2 | give WIDTHxHEIGHT, each from 1 to 16384, such as 640x480
render animate table1 bench visibility | --size 0x10 | 2 | give WIDTHxHEIGHT, each from 1 to 16384, such as 640x480
render animate table1 visibility | --threads 1000000 | 2 | --threads 1000000: give a whole number from 0 to 1024
bench | --threads 1000000 | 2 | --threads 1000000: give a whole number from 0 to 256
render animate table1 bench visibility | --threads -1 | 2 | --threads -1: give a whole number from 0 to
render visibility nodes | --scene teapot | 2 | --scene teapot: no such scene; choose from knot terrain
table1 bench | --scene teapot | 2 | --scene teapot: no such scene; choose from conference
render table1 bench visibility nodes | --scene knot:many | 2 | after ':' give a number of triangles up to 2^30
render animate | --spp 0 | 2 | --spp 0: give a whole number from 1 to
render | --mode pretty | 2 | choose from shaded normals depth prims steps tests
render visibility | --camera behind | 2 | give outside, inside or ex,ey,ez,lx,ly,lz[,fov]
render visibility | --up w | 2 | give x, y or z
render visibility nodes | a.ply b.ply | 2 | one mesh at a time, not 'b.ply' too
render visibility nodes | --scene knot a.ply | 2 | give a mesh or --scene, not both
render visibility nodes | knot | 1 | for the built-in scene write --scene knot
render table1 bench visibility nodes | $work/none.ply | 1 | none.ply: No such file or directory
render table1 bench visibility nodes | $work/list.ply | 1 | not a PLY file: it does not begin with 'ply'
render table1 bench visibility nodes | $work/short.ply | 1 | 3 of 'vertex' promised
render table1 bench visibility nodes | $work/list.txt | 1 | PLY
render table1 bench visibility nodes | $work | 1 | Is a directory
render visibility nodes | -o $work/none/x | 2 | none/: No such file or directory; name a file in a folder that can be
render table1 bench | --json $work/none/x | 2 | none/: No such file or directory; name a file in a folder that can be
animate | --webp $work/none/x cloth | 2 | none/: No such file or directory; name a file in a folder that can be
animate | -o $work/x.png cloth | 2 | give a name with a number in it, such as frame%04d.png
animate | | 2 | give a scene; see --help
animate | flag | 1 | give an AFF file, or crowd, explode or cloth
animate | $work/list.txt | 1 | give an AFF file, or crowd, explode or cloth
TABLE
}

# says PROGRAM ARGUMENTS STATUS TEXT
says() {
    ls -R "$work" >"$logs/before"
    # shellcheck disable=SC2086
    timeout 20 "$programs/htree-$1" $2 >"$logs/out" 2>"$logs/err" </dev/null
    code=$?
    what="htree-$1 $2"
    [ $code -eq "$3" ] || { echo "$what ended with $code, not $3"; return 1; }
    [ "$(wc -l <"$logs/err")" -eq 1 ] || { cat "$logs/err"; echo "$what did not say one line"; return 1; }
    grep -q "^htree-$1: " "$logs/err" || { cat "$logs/err"; echo "$what did not say who speaks"; return 1; }
    grep -qF -e "$4" "$logs/err" || { cat "$logs/err"; echo "$what did not say: $4"; return 1; }
    ls -R "$work" | cmp -s - "$logs/before" || { echo "$what left a file"; return 1; }
}

all_say() { # all_say PROGRAM
    rows=0
    table | sed 's/ *| */|/g' >"$logs/table"
    while IFS='|' read -r who asked status text; do
        case " $who " in *" $1 "*) ;; *) continue ;; esac
        says "$1" "$asked" "$status" "$text" || return 1
        rows=$((rows + 1))
    done <"$logs/table"
    [ $rows -ge 12 ] || { echo "only $rows messages"; return 1; }
    echo "count: $rows messages"
}

# A disk that takes no byte of any file.
fills() { # fills PROGRAM FILE ARGUMENTS: it says so in one line, and leaves nothing
    what="htree-$1 $3 with a full disk"
    # shellcheck disable=SC2086
    said=$(trap '' XFSZ && ulimit -f 0 && timeout 60 "$programs/htree-$1" $3 2>&1 >/dev/null </dev/null)
    code=$?
    [ $code -eq 1 ] || { echo "$said"; echo "$what ended with $code, not 1"; return 1; }
    [ "$said" = "htree-$1: $work/$2: File too large" ] || { echo "$said"; echo "$what did not say so"; return 1; }
    [ -z "$(find "$work" -name 'full*')" ] || { find "$work" -name 'full*'; echo "$what left a file"; return 1; }
    files=$((files + 1))
}

disk_is_full() {
    files=0
    fills render full.png "--scene knot:2000 --size 320x240 -o $work/full.png" &&
        fills render full.json "--scene knot:200 --size 32x32 --json $work/full.json" &&
        fills animate full00.png "--frames 3 --size 160x120 -o $work/full%02d.png cloth" &&
        fills animate full.webp "--frames 3 --size 160x120 --webp $work/full.webp cloth" &&
        fills animate full.json "--frames 30 --size 16x16 --json $work/full.json cloth" &&
        fills table1 full.json "--scene knot:300 --size 64x48 --json $work/full.json" &&
        fills table1 full.csv "--scene knot:300 --size 64x48 --csv $work/full.csv" &&
        fills bench full.rays "--scene knot:300 --size 64x48 --seconds 0.01 --save-rays $work/full.rays" &&
        fills bench full.json "--scene knot:300 --size 64x48 --seconds 0.01 --json $work/full.json" &&
        fills visibility full.png "--scene knot:2000 --size 320x240 -o $work/full.png" &&
        fills nodes full.json "--scene knot:2000 -o $work/full.json" &&
        echo "count: $files files refused"
}

for program in render animate table1 bench visibility nodes; do rule $program all_say $program; done
rule disk-is-full disk_is_full
exit $bad
