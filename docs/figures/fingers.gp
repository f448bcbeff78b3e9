# docs/pictures/fingers.svg. scripts/figures.sh calls it with `out` and with `felt`, the servo's CSV of two fingers.
set terminal svg size 900,560 font "DejaVu Sans,12" background "white"
set datafile separator ","
stats felt every ::1 using 17 name "FIRST" nooutput
stats felt every ::1 using 36 name "SECOND" nooutput
stats felt every ::(1 + FIRST_index_max)::(1 + FIRST_index_max) using 36 name "BESIDE" nooutput
@must (FIRST_max > 0.1 && FIRST_min == 0) 'the first finger pressing and leaving'
@must (SECOND_max > 0.05) 'the second finger in contact'
@must (BESIDE_max < 0.8 * SECOND_max) 'the second force falling as the first presses'
set output out
set multiplot layout 2,1 margins 0.08,0.98,0.09,0.86 spacing 0.02,0.06 \
    title "Two fingers 7.5 mm apart on the cube: the second holds still, the first presses and leaves"
set grid
set xrange [0:1.6]
set format x ""
set ylabel "normal force, N" offset 1,0
set key at screen 0.5,0.93 center top maxrows 1 samplen 2
plot felt every 2::1 using ($1/1000):17 with lines linewidth 2 linecolor rgb color_finger title "first finger", \
     "" every 2::1 using ($1/1000):36 with lines linewidth 2 linecolor rgb color_second_finger title "second finger"
unset key
set format x "%g"
set xlabel "time, s" offset 0,0.4
set ylabel "depth under the top, mm" offset 1,0
set yrange [-0.5:4.5]
plot felt every 2::1 using ($1/1000):(1000*(0.03-$4)) with lines linewidth 2 linecolor rgb color_finger, \
     "" every 2::1 using ($1/1000):(1000*(0.03-$23)) with lines linewidth 2 linecolor rgb color_second_finger
unset multiplot
