# docs/pictures/contact-line.svg. `make figures` calls it with `out` and with `data`, haptable-contact's line.dat.
set terminal svg size 900,820 font "DejaVu Sans,12" background "white"
set output out
set multiplot layout 3,1 title "Normal stiffness felt along a line over the top of the 30 mm cube, 1 mm deep, nu = 0.3"
set grid
set ylabel "N/m"
set xlabel "mm along the line"
set key outside
array force[3] = ["interpolated", "consistent", "pressure mask of 5 mm"]
do for [f=0:2] {
  set title force[f + 1]
  set yrange [0:*]
  plot for [m=0:3] data using 1:(column(2 + 3 * m + f)) every 5 with lines linewidth 2 \
       title word("9 13 17 25", m + 1)." nodes a side"
}
unset multiplot
