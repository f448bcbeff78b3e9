# docs/pictures/relaxation.svg. `make figures` calls it with `out` and with `felt`, the servo's CSV of a path over the
# liver's top at x, y = 0.
set terminal svg size 900,420 font "DejaVu Sans,12" background "white"
set output out
set title "The liver pressed 10 mm deep, let go, and pressed again after 1 s"
set datafile separator ","
set grid
set xlabel "s"
set ylabel "force, N"
set y2label "under the shape at rest, mm"
set y2tics
set ytics nomirror
set key outside below
plot felt every 20::1 using ($1/1000):(sqrt($15**2+$16**2+$17**2)) with lines linewidth 2 title "force", \
     "" every 20::1 using ($1/1000):($5==1 ? 1000*sqrt(($2-$12)**2+($3-$13)**2+($4-$14)**2) : 0) axes x1y2 with lines \
        linewidth 1 dashtype 2 title "finger"
