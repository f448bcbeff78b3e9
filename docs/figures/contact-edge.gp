# docs/pictures/contact-edge.svg. `make figures` calls it with `out` and with `data`, haptable-contact's edge.dat.
set terminal svg size 900,420 font "DejaVu Sans,12" background "white"
set output out
set title "Force while sliding out over a convex edge, 2 mm deep at 50 mm/s"
set grid
set ylabel "N"
set xlabel "ms"
set key outside
plot data using 1:2 with lines linewidth 2 title "nearest", \
     "" using 1:3 with lines linewidth 2 title "nearest, release 0.01 N/ms", \
     "" using 1:4 with lines linewidth 2 title "least energy, release 0.01 N/ms"
