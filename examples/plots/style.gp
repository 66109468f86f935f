# style.gp: what all plots share. The colours of the structures can be told apart by colour-blind
# readers too (after Okabe and Ito).
set encoding utf8
set termoption noenhanced
set style line 1 lc rgb "#777777" lw 2 pt 5 ps 1.1   # kd
set style line 2 lc rgb "#56b4e9" lw 2 pt 7 ps 1.1   # ug
set style line 3 lc rgb "#f0c000" lw 2 pt 9 ps 1.2   # bvh-median
set style line 4 lc rgb "#e69f00" lw 2 pt 11 ps 1.2  # bvh-sah
set style line 5 lc rgb "#cc79a7" lw 2 pt 13 ps 1.2  # skd
set style line 6 lc rgb "#0072b2" lw 2.5 pt 7 ps 1.1 # h
set style line 7 lc rgb "#d55e00" lw 2.5 pt 5 ps 1.1 # ah
set border 3 lc rgb "#444444"
set tics nomirror textcolor rgb "#222222"
set grid back lc rgb "#bbbbbb" lw 0.8
kinds = "kd ug bvh-median bvh-sah skd h ah"
