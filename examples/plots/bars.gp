# bars.gp: T_C and T_R of each structure, stacked to T_T, one panel per scene.
# Wants folder (of the scripts), data, scenes (names of its blocks), out.
set terminal pngcairo size 1400,820 font "DejaVu Sans,10" background "#ffffff"
set output out
load folder."/style.gp"
count = words(scenes)
columns = count > 4 ? 4 : count
set multiplot layout (count + columns - 1) / columns, columns title \
    "Milliseconds to 500 x 500 primary rays, one thread: construction T_C below, tracing T_R above" \
    font "DejaVu Sans,13" margins 0.05,0.985,0.11,0.88 spacing 0.045,0.19
set style data histograms
set style histogram rowstacked
set style fill solid 0.95 noborder
set boxwidth 0.72
set xtics rotate by -40 scale 0
set grid noxtics ytics
set yrange [0:*]
set key top right reverse Left samplen 1
do for [i=1:count] {
    scene = word(scenes, i)
    set title scene font "DejaVu Sans,12"
    if (i > 1) { unset key }
    plot data index scene using (1e3 * $2):xtic(1) lc rgb "#44546a" title "T_C", \
         "" index scene using (1e3 * $3) lc rgb "#e8b04b" title "T_R"
}
unset multiplot
