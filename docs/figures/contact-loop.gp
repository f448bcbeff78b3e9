# docs/pictures/contact-loop.svg. scripts/plots.sh calls it with `out` and with `data`, haptable-contact's loop.dat.
set terminal svg size 900,480 font "DejaVu Sans,12" background "white"
array given[6]
stats data using 1 name "LEG" nooutput
do for [m=0:5] {
  stats data using (column(2 + m)) name "ENERGY" nooutput
  stats data using ($1 == LEG_max ? column(2 + m) : NaN) name "LAST" nooutput
  given[m + 1] = LAST_max
  @must (ENERGY_min < -100) sprintf("energy that is stored, curve %d", m + 1)
}
@must (given[1] > 0 && given[2] > 0 && given[3] > 0) 'loops of the nearest god-object that give energy'
@must (given[4] <= 0 && given[5] <= 0 && given[6] <= 0) 'loops of least energy that give none'
set output out
set title "Energy given to the user around a loop over the cube's top (nu = 0.3)"
set grid
set ylabel "energy given, µJ"
set xlabel "place on the loop"
set xtics ("start" 0, "5 mm in" 1, "8 mm aside" 2, "out" 3, "back" 4)
set key inside left top maxrows 3 samplen 2 reverse Left font ",11" opaque
mode(m) = sprintf("%s, %s", word("interpolated consistent mask", m % 3 + 1), m < 3 ? "nearest" : "least energy")
colour(m) = int(word("3887755 2199948 14037884", m % 3 + 1))
plot for [m=0:2] data using 1:(column(2 + m)) every 8 with lines linewidth 2 linecolor rgb colour(m) title mode(m), \
     for [m=3:5] data using 1:(column(2 + m)) every 8 with lines linewidth 2 dashtype 2 linecolor rgb colour(m) \
         title mode(m)
