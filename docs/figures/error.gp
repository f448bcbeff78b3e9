# Error of the force against what it costs, one point a configuration: docs/pictures/error-AXIS.svg. `make figures` calls
# it with `out`, with `data`, the values of the topic "points" in docs/numbers.json, and with `axis`: time, flash or
# precompute.
set terminal svg size 1000,940 font "DejaVu Sans,12" background "white"
set output out
column_of = axis eq "time" ? 9 : axis eq "flash" ? 10 : 11
unit = axis eq "time" ? "microseconds of CPU a tick" : axis eq "flash" ? "kB of tables" : "seconds of CPU to precompute"
scale = axis eq "time" ? 1e6 : axis eq "flash" ? 1e-3 : 1
set multiplot layout 2,2 margins 0.085,0.98,0.06,0.86 spacing 0.09,0.1 title "How far the force is from the body's, against ".unit
set logscale xy
# One frame for all four, so that bodies can be compared; left of the points is where names stand.
stats data using (scale * column(column_of)) nooutput
set xrange [(axis eq "time" ? 2e-4 : STATS_min / 12):STATS_max * 3]
set yrange [0.03:300]
set grid
set format x "10^{%T}"
set format y "%g"
set xlabel unit
set ylabel "error of the force, RMS, % of it" offset 1,0
set ytics (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200)
array force[7] = ["interpolated", "consistent", "pressure-mask", "dense inverse", "sparse solve", "conjugate gradients", "the paper, 1998"]
array colour[7] = [0x3b528b, 0x21918c, 0xd6337c, 0x9a958a, 0x6b6459, 0x2d2a26, 0x7c3aed]
array sign[7] = [6, 8, 4, 2, 1, 3, 15]
is(b, f, least) = strcol(1) eq b && strcol(4) eq force[f] && (strcol(5) eq "least-energy") == least
at(b, f, least) = is(b, f, least) ? scale * column(column_of) : NaN
best(b) = strcol(1) eq b && strstrt(strcol(12), axis) > 0 ? scale * column(column_of) : NaN
# Of precisions next to each other, one has a name.
named(b) = axis eq "precompute" || strcol(6) eq (axis eq "time" ? "float32" : "float16") ? best(b) : NaN
# Of the best front: nodes a side, or of all; the elements where they are not linear.
short(mesh, element) = word(mesh, 1).(element eq "linear" ? "" : element eq "quadratic" ? " quadratic" : " nodal pressure")
array body[4] = ["cube, nu 0.3", "cube, nu 0.49", "mouse", "liver"]
do for [b=1:4] {
  set title body[b]
  if (b == 1) { set key at screen 0.5,0.96 center top maxrows 4 font ",9" samplen 1 reverse Left } else { unset key }
  plot for [f=1:7] data using (at(body[b], f, 0)):(100 * column(7)) with points pointtype sign[f] linecolor rgb colour[f] title force[f], \
       for [f=1:3] data using (at(body[b], f, 1)):(100 * column(7)) with points pointtype sign[f] + 1 linecolor rgb colour[f] \
           title force[f].", least energy", \
       data using (named(body[b])):(100 * column(7)):(short(strcol(2), strcol(3))) with labels right offset -1.6,0 font ",8" textcolor rgb 0x4a5568 notitle, \
       data using (best(body[b])):(100 * column(7)) with points pointtype 6 pointsize 2.2 linewidth 2 linecolor rgb 0xc2410c title "best front"
}
unset multiplot
