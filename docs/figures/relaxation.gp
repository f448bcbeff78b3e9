# docs/pictures/relaxation.svg. scripts/figures.sh calls it with `out` and with `felt`, the servo's CSV of a path over
# the liver's top at x, y = 0.
set terminal svg size 900,560 font "DejaVu Sans,12" background "white"
set datafile separator ","
stats felt every ::1 using (sqrt($15**2+$16**2+$17**2)) name "FORCE" nooutput
stats felt every ::1 using ($1 > 8300 && $1 < 8400 ? sqrt($15**2+$16**2+$17**2) : NaN) name "HELD" nooutput
stats felt every ::1 using ($1 > 8800 && $1 < 9500 ? sqrt($15**2+$16**2+$17**2) : NaN) name "AWAY" nooutput
stats felt every ::1 using ($1 > 9600 ? sqrt($15**2+$16**2+$17**2) : NaN) name "AGAIN" nooutput
@must (HELD_min > 0 && HELD_max < 0.8 * FORCE_max) 'a force that relaxes'
@must (FORCE_index_max < 1000 && FORCE_max > 0.2) 'a peak as the finger comes in'
@must (AWAY_max == 0) 'the finger let go'
@must (AGAIN_max > HELD_max && AGAIN_max < 0.95 * FORCE_max) 'a second peak, lower than the first'
set output out
set multiplot layout 2,1 margins 0.08,0.98,0.09,0.92 spacing 0.02,0.06 \
    title "The liver pressed 10 mm deep, let go, and pressed again after 1 s"
set grid
unset key
set format x ""
set ylabel "size of the force, N" offset 1,0
set yrange [0:*]
set xrange [0:14.5]
plot felt every 20::1 using ($1/1000):(sqrt($15**2+$16**2+$17**2)) with lines linewidth 2 linecolor rgb color_force
set format x "%g"
set xlabel "time, s" offset 0,0.4
set ylabel "depth under the rest shape, mm" offset 1,0
set yrange [0:11]
plot felt every 20::1 using ($1/1000):($5==1 ? 1000*sqrt(($2-$12)**2+($3-$13)**2+($4-$14)**2) : 0) \
     with lines linewidth 2 linecolor rgb color_finger
unset multiplot
