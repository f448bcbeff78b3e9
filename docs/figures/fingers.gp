# docs/pictures/fingers.svg. `make figures` calls it with `out` and with `felt`, the servo's CSV of two fingers.
set terminal svg size 900,420 font "DejaVu Sans,12" background "white"
set output out
set title "Two fingers 7.5 mm apart on the cube: the second holds still, the first presses and leaves"
set datafile separator ","
set grid
set xlabel "s"
set ylabel "normal force, N"
set key outside below
plot felt every 2::1 using ($1/1000):17 with lines linewidth 2 title "first finger", \
     "" every 2::1 using ($1/1000):36 with lines linewidth 2 title "second finger", \
     "" every 2::1 using ($1/1000):(1000*(0.03-$4)/10) with lines linewidth 1 dashtype 2 title "first finger's depth, cm"
