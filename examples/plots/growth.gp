# growth.gp: construction time against the number of triangles.
# Wants folder (of the scripts), data, out.
set terminal pngcairo size 1300,1000 font "DejaVu Sans,11" background "#ffffff"
set output out
load folder."/style.gp"
set termoption enhanced
set multiplot layout 2,2 title "Construction time, one thread" font "DejaVu Sans,15" \
    margins 0.075,0.985,0.07,0.90 spacing 0.085,0.11
set logscale xy
set format x "10^{%L}"
set xlabel "triangles"
set xrange [8e3:1.3e7]
label(k) = k eq "ug" ? "uniform grid" : k eq "kd" ? "kd-tree" : \
    k eq "bvh-median" ? "BVH, median" : k eq "bvh-sah" ? "BVH, SAH" : k eq "skd" ? "SKD-tree" : k eq "h" ? "H-tree" : "AH-tree"
do for [scene in "soup waves"] {
    about = scene eq "soup" ? "soup: random triangles in a cube" : "waves: a height field"
    set title about font "DejaVu Sans,12"
    set ylabel "T_C in seconds"
    set yrange [5e-4:20]
    set format y "%g"
    set key top left reverse Left samplen 2
    plot for [i=1:7] data index scene."-".word(kinds, i) using 1:2 with linespoints ls i \
        title label(word(kinds, i))
}
do for [scene in "soup waves"] {
    set title "the same, per triangle" font "DejaVu Sans,12"
    set ylabel "nanoseconds per triangle"
    set yrange [60:6000]
    set ytics add (60, 100, 200, 500, 1000, 2000, 5000)
    unset key
    plot for [i=1:7] data index scene."-".word(kinds, i) using 1:3 with linespoints ls i \
        notitle
}
unset multiplot
