# docs/pictures/contact-loop.svg. `make figures` calls it with `out` and with `data`, haptable-contact's loop.dat.
set terminal svg size 900,480 font "DejaVu Sans,12" background "white"
set output out
set title "Energy given to the user around a loop: in 5 mm, aside 8 mm, out, back (cube, nu = 0.3)"
set grid
set ylabel "microjoules"
set xlabel "leg of the loop"
set key outside
mode(m) = sprintf("%s, %s", word("interpolated consistent mask", m % 3 + 1), m < 3 ? "nearest" : "least energy")
plot for [m=0:2] data using 1:(column(2 + m)) every 8 with lines linewidth 2 title mode(m), \
     for [m=3:5] data using 1:(column(2 + m)) every 8 with lines linewidth 2 dashtype 2 title mode(m)
