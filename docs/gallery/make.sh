#!/bin/sh
# make.sh PROGRAMS OUT: the gallery as a static site in OUT, made by the programs in the folder PROGRAMS. What
# needs npm (the tree viewer) or libwebp (films) is left out with a line where they are missing.
#
# SIZE, FILM and FRAMES replace the size of pictures, the size of films, and the number of their frames; TREE
# the number of triangles in the viewer.
set -eu
programs=$1 out=$2
here=$(dirname "$0")
size=${SIZE:-800x600} film=${FILM:-480x360} frames=${FRAMES:-40} tree=${TREE:-1500}
work=$out.work
version=$(sed -n 's/^VERSION := //p' "$here/../../Makefile")
rm -rf "$out"
mkdir -p "$out/pictures" "$out/trees" "$work"
: >"$work/figures.sed"

# ---- Pictures ------------------------------------------------------------------------------------------

# picture NAME ARGUMENT...: and its figures, as @NAME.KEY@ in the page
picture() {
    file=$1
    shift
    "$programs/htree-render" "$@" --size "$size" --spp 4 -q -o "$out/pictures/$file.png" --json "$work/$file.json"
    tr -d '{}",:' <"$work/$file.json" | awk -v name="$file" '
        function grouped(n) { return n < 1000 ? n : grouped(int(n / 1000)) "," sprintf("%03d", n % 1000) }
        function say(text) { print "s|@" name "." $1 "@|" text "|g" }
        $1 == "triangles" { say(grouped($2)) }
        $1 ~ /^N_(TS|IT)$/ { say(sprintf("%.1f", $2)) }
        $1 == "bytes" { say(sprintf("%.1f MB", $2 / 1e6)) }' >>"$work/figures.sed"
}

# scene NAME TITLE TEXT ARGUMENT...: a picture, two heat maps, and the lines of the page for them
scene() {
    name=$1 title=$2 text=$3
    shift 3
    picture "$name" "$@"
    picture "$name-steps" "$@" --mode steps
    picture "$name-tests" "$@" --mode tests
    cat >>"$work/scenes.html" <<HTML
<h3>$title</h3>
<figure class="scene">
<a href="pictures/$name.png"><img src="pictures/$name.png" $pixels loading="lazy" alt="$title, rendered with soft light"></a>
<a href="pictures/$name-steps.png"><img src="pictures/$name-steps.png" $pixels loading="lazy" alt="Heat map of nodes visited per ray"></a>
<a href="pictures/$name-tests.png"><img src="pictures/$name-tests.png" $pixels loading="lazy" alt="Heat map of triangles tested per ray"></a>
<figcaption>$text <span>@$name.triangles@ triangles, an H-tree of @$name.bytes@; a ray visits @$name.N_TS@ nodes and
tests @$name.N_IT@ triangles on average.</span></figcaption>
</figure>
HTML
}

# kind NAME TITLE: the crowd's heat map in a tree of that kind
kind() {
    picture "kind-$1" --scene crowd --camera 5,4.2,9,0,0.2,1,48 --kind "$1" --mode steps --heat-max 120
    cat >>"$work/kinds.html" <<HTML
<figure><img src="pictures/kind-$1.png" $pixels loading="lazy" alt="Heat map of nodes visited in a tree of kind $1">
<figcaption><b>$2.</b> @kind-$1.N_TS@ nodes, @kind-$1.N_IT@ triangles a ray; @kind-$1.bytes@.</figcaption></figure>
HTML
}

pixels="width=\"${size%x*}\" height=\"${size#*x}\""
: >"$work/scenes.html"
: >"$work/kinds.html"
echo "pictures"
scene knot "A rope in a knot" "Much of the picture is air, and most of the tree is about where." --scene knot
scene terrain "Mountains" "Ridges stand before valleys: rays that pass a ridge closely pay for it." \
    --scene terrain --camera 0.9,0.85,1.5,0,0.05,-0.1,42
scene city "A city on one huge floor" "Two triangles as large as all others together." \
    --scene city --camera 17,13,27,1,0,3,40
scene crowd "A crowd" "Small detail on a wide floor, the teapot in the stadium many times over." \
    --scene crowd --camera 5,4.2,9,0,0.2,1,48
kind kd "kd-tree"
kind h "H-tree"
kind ah "AH-tree"
kind skd "Spatial kd-tree"
kind bvh-sah "BVH"
kind wide "Wide tree"
cp "$here"/../drawings/*.svg "$here"/../pictures/bars.png "$here"/../pictures/growth.png \
    "$here"/../pictures/precision.png "$out/pictures/"

# ---- Films ---------------------------------------------------------------------------------------------

# movie SCENE NAME ARGUMENT...: and a still of its middle for people who want no motion
movie() {
    name=$2 of=$1
    shift 2
    "$programs/htree-animate" "$of" --size "$film" --frames "$frames" -q --threads 0 "$@" \
        --webp "$out/pictures/$name.webp" || cp "$out/pictures/crowd.png" "$out/pictures/$name.webp"
    "$programs/htree-animate" "$of" --size "$film" --frames 3 --every 2 -q "$@" -o "$work/$name%d.png"
    cp "$work/${name}1.png" "$out/pictures/$name.png"
}

echo "films"
movie cloth cloth
movie crowd march --kind ah

# ---- Tree viewer ---------------------------------------------------------------------------------------

echo "trees"
for scene in knot city terrain crowd; do
    "$programs/htree-nodes" --scene "$scene:$tree" --kind h,ah,skd,kd,bvh-sah,wide,ug -o "$out/trees/$scene.json"
    { printf 'htreeScene("%s",' "$scene" && cat "$out/trees/$scene.json" && echo ');'; } >"$out/trees/$scene.js"
done

# Packages come into the work folder, where nothing of the repository is; into the page goes one script.
viewer() {
    cp "$here"/*.js "$here/package.json" "$here/package-lock.json" "$here/.npmrc" "$work/"
    (cd "$work" && npm ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error >npm.log 2>&1) ||
        { cat "$work/npm.log" >&2 && return 1; }
    "$work/node_modules/.bin/esbuild" "$work/viewer.js" --bundle --minify --legal-comments=eof --log-level=warning \
        --target=es2020 --outfile="$out/viewer.js"
}

if command -v npm >/dev/null; then
    viewer
else
    echo 'document.getElementById("viewer").hidden = true;' >"$out/viewer.js"
    echo "note: no tree viewer: npm is missing (apt-get install nodejs npm)" >&2
fi

# ---- The page ------------------------------------------------------------------------------------------

cp "$here/page.css" "$out/"
cat >>"$work/figures.sed" <<SED
s|@version@|$version|
s|@motion.width@|${film%x*}|
s|@motion.height@|${film#*x}|
SED
sed -e "/^@scenes@\$/{
r $work/scenes.html
d
}" -e "/^@kinds@\$/{
r $work/kinds.html
d
}" "$here/page.html" | sed -f "$work/figures.sed" >"$out/index.html"
if grep -n '@[a-z-]*\.[A-Za-z_]*@' "$out/index.html"; then
    echo "error: figures are missing in the page" >&2
    exit 1
fi
echo "$out/index.html"
