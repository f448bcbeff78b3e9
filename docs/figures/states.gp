# The servo's states: docs/pictures/states.svg. `make figures` calls it with `out`. Coordinates are pixels, y upwards.
set encoding utf8
set terminal svg size 1040,370 font "DejaVu Sans,13" background "white"
set output out
unset border; unset tics; unset key
set xrange [0:1040]; set yrange [0:370]
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0

# A box: middle, width, height, text.
$zero << EOD
110 250 150 70 "{/:Bold 0 silent}\nno force"
350 250 150 70 "{/:Bold 1 free}\nno force"
360 60 170 70 "{/:Bold 3 rejected}\nno force"
110 60 150 70 "{/:Bold 5 faulted}\nno force, latched"
EOD
$force << EOD
640 250 160 70 "{/:Bold 2 contact}\nthe body's force"
920 250 160 70 "{/:Bold 4 limited}\ngain below 1"
EOD
$up << EOD
185 262 275 262
425 262 560 262
840 238 720 238
EOD
$down << EOD
560 238 425 238
720 262 840 262
640 215 447 80
920 215 447 55
EOD
$back << EOD
275 238 185 238
360 95 360 215
275 60 185 60
140 95 300 215
EOD
$note << EOD
230 278 "a position"
492 278 "through the surface"
492 222 "outside, seen"
780 278 "a limit acts"
780 222 "ramp, gain is 1"
760 92 "no position, or one that no finger\nreaches in time"
410 160 "20 good ticks"
232 78 "repeated"
160 165 "acknowledged"
230 222 "20 ms"
520 335 "From every state: 20 ms without a position → silent.   Damaged tables, a force that is no number → faulted.\nA red line may lower the force in one tick; a blue one begins at the force that is, and lets it rise with the body, max\\_force\\_rate and the ramp alone."
EOD
grey = 0x4a5568; red = 0xc2410c; blue = 0x1d4ed8
lines(text) = strstrt(text, "\n") == 0 ? 1 : 2
middle(y, text) = y + 8.5 * (lines(text) - 1)
plot for [data in "up down back"] "$".data using 1:2:($3 - $1):($4 - $2) with vectors size 9,20 filled linewidth 1.5 \
         linecolor rgb (data eq "up" ? blue : data eq "down" ? red : grey), \
     for [data in "zero force"] "$".data using 1:2:($3 / 2):($4 / 2) with boxxyerror linecolor rgb grey \
         fillcolor rgb (data eq "zero" ? 0xdbe7f3 : 0xfde6d3) fillstyle solid 1.0 border linecolor rgb grey, \
     for [data in "zero force"] "$".data using 1:(middle($2, strcol(5))):5 with labels, \
     $note using 1:(middle($2, strcol(3))):3 with labels font ",11" textcolor rgb grey
