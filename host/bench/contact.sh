#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Draws the pictures of docs/FEEL.md and puts the measured table into docs/CONTACT.md. Called by `make bench` from the root.
set -eu
BUILD=${BUILD:-build}
mkdir -p "$BUILD/contact"
"$BUILD/bin/haptable-contact" -o "$BUILD/contact"
gnuplot <<PLOT
set terminal pngcairo size 1000,900 font "DejaVu Sans,10"
set output "docs/pictures/contact-line.png"
set multiplot layout 3,1 title "Normal stiffness felt along a line over the top of the 30 mm cube, 1 mm deep, nu = 0.3"
set grid
set ylabel "N/m"
set xlabel "mm along the line"
set key outside
array force[3] = ["interpolated", "consistent", "pressure mask of 5 mm"]
do for [f=0:2] {
  set title force[f + 1]
  set yrange [0:*]
  plot for [m=0:2] "$BUILD/contact/line.dat" using 1:(column(2 + 3 * m + f)) with lines linewidth 2 \
       title word("9 13 17", m + 1)." nodes a side"
}
unset multiplot
reset
set terminal pngcairo size 900,480 font "DejaVu Sans,10"
set output "docs/pictures/contact-loop.png"
set title "Energy given to the user around a loop: in 5 mm, aside 8 mm, out, back (cube, nu = 0.3)"
set grid
set ylabel "microjoules"
set xlabel "leg of the loop"
set key outside
plot "$BUILD/contact/loop.dat" using 1:2 with lines linewidth 2 title "interpolated, nearest", \
     "" using 1:3 with lines linewidth 2 title "consistent, nearest", \
     "" using 1:4 with lines linewidth 2 title "mask, nearest", \
     "" using 1:5 with lines linewidth 2 dashtype 2 title "interpolated, least energy", \
     "" using 1:6 with lines linewidth 2 dashtype 2 title "consistent, least energy", \
     "" using 1:7 with lines linewidth 2 dashtype 2 title "mask, least energy"
set output "docs/pictures/contact-edge.png"
set title "Force while sliding out over a convex edge, 2 mm deep at 50 mm/s"
set ylabel "N"
set xlabel "ms"
plot "$BUILD/contact/edge.dat" using 1:2 with lines linewidth 2 title "nearest", \
     "" using 1:3 with lines linewidth 2 title "nearest, release 0.01 N/ms", \
     "" using 1:4 with lines linewidth 2 title "least energy, release 0.01 N/ms"
PLOT
awk -v table="$BUILD/contact/steps.md" '
    /<!-- steps -->/ { print; while ((getline line < table) > 0) print line; skip = 1; next }
    /<!-- end of steps -->/ { skip = 0 }
    !skip' docs/CONTACT.md >"$BUILD/contact/page.md" && cp "$BUILD/contact/page.md" docs/CONTACT.md
echo "bench: contact modes in docs/CONTACT.md"
