# precision.gp: what coarser splits cost and save, relative to the least value of each curve.
# Wants folder (of the scripts), data, scenes (the first part of its blocks' names), out.
set terminal pngcairo size 1300,680 font "DejaVu Sans,11" background "#ffffff"
set output out
load folder."/style.gp"
set multiplot layout 1,2 title \
    "Precision of the splits against time, relative to the best of each curve" \
    font "DejaVu Sans,14" margins 0.06,0.985,0.22,0.85 spacing 0.07,0.1
set key outside below center maxrows 2 reverse Left samplen 4
names = "T_C T_R N_TS"
field(i) = i == 1 ? 2 : i == 2 ? 3 : 5
do for [study in "h-buckets ah-cells"] {
    buckets = study eq "h-buckets"
    about = buckets ? "H-tree by buckets M" : "AH-tree by cells per triangle"
    set title about font "DejaVu Sans,12"
    set xlabel (buckets ? "M" : "cells of the grid per triangle")
    set ylabel "relative"
    if (buckets) { set xtics (2, 4, 8, 16, 32, 64) } else { \
        set xtics ("1/16" 0.0625, "1/8" 0.125, "1/4" 0.25, "1/2" 0.5, 1, 2, 4, 8, 16) }
    # Ranges apply to stats too.
    unset logscale
    set autoscale
    array least[6]
    do for [s=1:words(scenes)] { do for [i=1:3] {
        stats data index word(scenes, s)."-".study using (column(field(i))) nooutput
        least[3 * (s - 1) + i] = STATS_min
    } }
    set logscale x 2
    if (buckets) { set xrange [1.8:71] } else { set xrange [0.056:17.9] }
    set yrange [0.9:*]
    plot for [s=1:words(scenes)] for [i=1:3] data index word(scenes, s)."-".study \
        using 1:(column(field(i)) / least[3 * (s - 1) + i]) with linespoints \
        lc rgb word("#0072b2 #d55e00 #777777", i) lw 2 dt s pt (s == 1 ? 7 : 6) ps 1.1 \
        title word(names, i).", ".word(scenes, s)
}
unset multiplot
