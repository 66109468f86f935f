# heat.gp: three pictures of 500 x 500 side by side, pixel for pixel.
# Wants files, names, heading, out.
set terminal pngcairo size 1520,556 font "DejaVu Sans,12" background "#ffffff"
set output out
set termoption noenhanced
set multiplot
unset border
unset tics
unset key
set label 1 heading at screen 0.5, screen 0.975 center font "DejaVu Sans,13"
do for [i=1:3] {
    set lmargin at screen (5 + 505.0 * (i - 1)) / 1520
    set rmargin at screen (5 + 505.0 * (i - 1) + 500) / 1520
    set bmargin at screen 5.0 / 556
    set tmargin at screen 505.0 / 556
    set xrange [-0.5:499.5]
    set yrange [-0.5:499.5]
    set label 2 word(names, i) at graph 0.5, screen 0.93 center
    plot word(files, i) binary filetype=png with rgbimage notitle
}
unset multiplot
