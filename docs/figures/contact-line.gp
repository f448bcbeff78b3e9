# docs/pictures/contact-line.svg. scripts/plots.sh calls it with `out` and with `data`, haptable-contact's line.dat.
set terminal svg size 900,760 font "DejaVu Sans,12" background "white"
array force[3] = ["interpolated (the paper's)", "consistent", "pressure mask of 5 mm"]
column_of(m, f) = 2 + 3 * m + f # nodes a side m: 9, 13, 17, 25
do for [f=0:2] {
  stats data using (column(column_of(0, f))) name sprintf("COARSE%d", f) nooutput
  stats data using (column(column_of(3, f))) name sprintf("FINE%d", f) nooutput
}
@must (FINE0_mean < 0.5 * COARSE0_mean) 'a point of force that softens with the mesh'
@must (FINE1_max > 1.2 * FINE1_min) 'the ripple of the consistent force'
@must (abs(FINE2_mean / COARSE2_mean - 1) < 0.1 && FINE2_max < 1.1 * FINE2_min) \
     'a mask that does not change with the mesh'
set output out
set multiplot layout 3,1 margins 0.08,0.98,0.07,0.87 spacing 0.02,0.085 \
    title "Normal stiffness along a line over the top of the 30 mm cube, 1 mm deep, nu = 0.3"
set grid
set ylabel "stiffness, N/m" offset 1,0
set xrange [-3.6:3.6]
set yrange [0:*]
do for [f=0:2] {
  set title force[f + 1] offset 0,-0.7
  if (f == 0) { set key at screen 0.5,0.945 center top maxrows 1 samplen 2 } else { unset key }
  if (f == 2) { set xlabel "position along the line, mm" offset 0,0.5 }
  plot for [m=0:3] data using 1:(column(column_of(m, f))) every 5 with lines linewidth 2 \
       title word("9 13 17 25", m + 1)." nodes a side"
}
unset multiplot
