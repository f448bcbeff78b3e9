# From the hand's coordinates to the body's: docs/pictures/device-frames.svg. `make figures` calls it with `out`.
# Coordinates are pixels, y upwards.
set encoding utf8
set terminal svg size 860,330 font "DejaVu Sans,13" background "white"
set output out
unset border; unset tics; unset key
set xrange [0:860]; set yrange [0:330]
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
set style arrow 1 head filled size 9,18 lw 2 lc rgb "#333333"
set style arrow 2 head filled size 9,18 lw 2 lc rgb "#c04020"
set style arrow 3 head filled size 9,18 lw 1.5 lc rgb "#4070b0"

# The device's frame: x to the right, y up, z to the user, drawn down to the left.
set label 1 "{/:Bold device}  (one whose y is up)" at 30,305
set arrow from 120,110 to 240,110 as 1
set arrow from 120,110 to 120,230 as 1
set arrow from 120,110 to 60,60 as 1
set label "x" at 246,108; set label "y" at 114,246; set label "z, to the user" at 14,44
set label "O" at 128,96
set object 1 circle at 190,185 size 6 fillcolor rgb "#c04020" fillstyle solid noborder
set label "x_{device}" at 200,196
set arrow from 190,185 to 190,240 as 2
set label "F_{device} = s_f (R M)^T F" at 176,262

# The body's frame: z up.
set label "{/:Bold body}" at 560,305
set arrow from 620,110 to 740,110 as 1
set arrow from 620,110 to 620,230 as 1
set arrow from 620,110 to 690,165 as 1
set label "x" at 746,108; set label "z" at 614,246; set label "y" at 696,172
set label "p = position" at 560,92
set object 2 rect from 655,40 to 835,86 fillcolor rgb "#e6ecf4" fillstyle solid border rgb "#808080"
set label "the mesh, its own place" at 668,62
set object 3 circle at 775,150 size 6 fillcolor rgb "#c04020" fillstyle solid noborder
set label "x = p + s_x R M x_{device}" at 660,205
set arrow from 775,150 to 775,190 as 2
set label "F" at 783,178

set arrow from 300,170 to 520,170 as 3
set label "motion: scale s_x, turn R, mirror M" at 410,186 center
set arrow from 520,140 to 300,140 as 3
set label "force: scale s_f, transposed" at 410,124 center
plot NaN notitle
