#!/bin/sh
# Runs the bench on the cube and the mouse and draws its plot. Called by `make bench` from the project's root.
set -eu
BUILD=${BUILD:-build}
"$BUILD/bin/haptable-bench" meshes/cube.toml meshes/mouse.toml --build "$BUILD" \
    -o docs/ACCURACY.md --data "$BUILD/bench.dat"
gnuplot <<PLOT
set terminal pngcairo size 900,480 font "DejaVu Sans,10"
set output "docs/accuracy.png"
set title "One tick, CPU time (1 ms is the servo's period)"
set style data histogram
set style histogram clustered gap 1
set style fill solid 0.9 border -1
set logscale y
set ylabel "microseconds"
set yrange [0.01:*]
set format y "10^{%T}"
set grid ytics
set xtics rotate by -15
set arrow from graph 0,first 1000 to graph 1,first 1000 nohead dashtype 2
plot "$BUILD/bench.dat" using 2:xtic(1) title "cube" linecolor rgb "#3b528b", \
     "" using 3 title "mouse" linecolor rgb "#5ec962"
PLOT
echo "bench: report in docs/ACCURACY.md, plot in docs/accuracy.png"
