# docs/pictures/contact-edge.svg. scripts/plots.sh calls it with `out` and with `data`, haptable-contact's edge.dat.
set terminal svg size 900,420 font "DejaVu Sans,12" background "white"
array mode[3] = ["nearest", "nearest, release 0.01 N/ms", "least energy, release 0.01 N/ms"]
do for [m=1:3] {
  stats data using (column(1 + m)) name "FORCE" nooutput
  stats data using 1 name "TIME" nooutput
  stats data using ($1 == TIME_max ? column(1 + m) : NaN) name "LAST" nooutput
  @must (FORCE_max > 0.05) sprintf("a force of the edge, %s", mode[m])
  @must (LAST_max == 0) sprintf("the finger leaving, %s", mode[m])
}
set output out
set title "Force while a finger slides out over a convex edge of the cube, 2 mm deep at 50 mm/s"
set grid
set ylabel "size of the force, N"
set xlabel "time from the press's end, ms"
set yrange [0:*]
set key inside right top samplen 2 reverse Left
plot for [m=1:3] data using 1:(column(1 + m)) with lines linewidth 2 title mode[m]
