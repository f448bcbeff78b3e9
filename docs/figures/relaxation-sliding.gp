# docs/pictures/relaxation-sliding.svg. scripts/figures.sh calls it with `out` and with `errors`, the rows of
# docs/TIME.md: speed times time over radius, error after a long press, after a short one.
set terminal svg size 720,400 font "DejaVu Sans,12" background "white"
stats errors using 2 name "LONG" nooutput
stats errors using 3 name "SHORT" nooutput
@must (LONG_records > 4 && LONG_min < 0.01 && LONG_max > 0.2) 'an error that rises with the speed'
@must (SHORT_index_max < SHORT_records - 1) 'a peak after a short press'
set output out
set logscale xy
set grid
set xlabel "speed x relaxation time / mask's radius" offset 0,0.4
set ylabel "error of the force, of its size"
set format x "%g"
set format y "%g"
set yrange [2e-4:1]
set key inside right bottom samplen 2 reverse Left opaque
plot errors using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 0.6 title "after 8 times of rest", \
     "" using 1:3 with linespoints linewidth 2 pointtype 5 pointsize 0.6 title "pressed in 20 ms", \
     0.05 with lines dashtype 2 linecolor "gray30" title "5 %"
