# Error of the force against what it costs: docs/pictures/error-AXIS.svg. scripts/plots.sh calls it with `out`, with
# `data`: body, force, cost, error, name of every configuration, with `fronts`: those that no other of the same force
# beats, and with `axis`: time, flash or precompute.
set terminal svg size 1000,900 font "DejaVu Sans,12" background "white"
set output out
unit = axis eq "time" ? "CPU time of a tick, µs" : axis eq "flash" ? "tables, kB" : "CPU time to precompute, s"
scale = axis eq "time" ? 1e6 : axis eq "flash" ? 1e-3 : 1
array body[4] = ["cube, nu 0.3", "cube, nu 0.49", "mouse", "liver"]
array force[7] = ["interpolated", "consistent", "pressure-mask", "dense inverse", "sparse solve", \
                  "conjugate gradients", "the paper, 1998"]
array shown[7] = ["interpolated (the paper's)", "consistent", "pressure mask", "instead: dense inverse", \
                  "instead: sparse solve", "instead: conjugate gradients", "the paper's own times, 1998"]
array colour[7] = [0x3b528b, 0x21918c, 0xd6337c, 0x9a958a, 0x6b6459, 0x2d2a26, 0x7c3aed]
array sign[7] = [6, 8, 5, 2, 1, 3, 15]
set datafile separator "\t"
there(b) = system(sprintf("awk -F'\t' '$1 == \"%s\" { print $2 }' %s | sort -u", body[b], fronts))
least(b, f) = sprintf("< awk -F'\\t' '$1 == \"%s\" && $2 == \"%s\"' %s", body[b], force[f], fronts)
do for [b=1:4] {
  stats least(b, 3) using (100 * $4) name "MASK" nooutput
  stats least(b, 1) using (100 * $4) name "POINT" nooutput
  @must (MASK_records > 1 && MASK_max > 2 * MASK_min) sprintf("an error of the mask that falls, %s", body[b])
  @must (MASK_min < POINT_min) sprintf("the mask nearer to the body than a point, %s", body[b])
}
stats fronts using (scale * $3) nooutput
# Names stand to the left, or where others are above and to the right: in free room.
set xrange [STATS_min / (axis eq "time" ? 2000 : axis eq "flash" ? 60 : 3):STATS_max * (axis eq "precompute" ? 100 : 4)]
set yrange [0.03:200]
set multiplot layout 2,2 margins 0.07,0.985,0.065,0.865 spacing 0.075,0.105 \
    title "Error of the force against ".unit.": of each force the configurations that none beats"
set logscale xy
side = axis ne "precompute" ? "right offset -1.2,0" : "left offset 0.7,0.5"
set grid
set format x "10^{%T}"
set format y "%g"
set xlabel unit offset 0,0.4
set ylabel "RMS error of the force, %" offset 1.5,0
set ytics (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)
do for [b=1:4] {
  set title body[b] offset 0,-0.6
  unset key
  if (b == 1) { set key at screen 0.5,0.965 center top maxrows 2 font ",11" samplen 2 width -4 reverse Left }
  forces = there(b)
  lines = ""
  do for [f=1:7] {
    look = sprintf("with linespoints pointtype %d pointsize 0.9 linewidth 1.5 linecolor rgb %d", sign[f], colour[f])
    front = sprintf("least(b, %d) using (scale * $3):(100 * $4) %s notitle, ", f, look)
    if (strstrt(forces, force[f]) > 0) { lines = lines.front }
    if (f < 7 || axis eq "time") { lines = lines.sprintf("keyentry %s title shown[%d], ", look, f) }
  }
  eval 'plot data using (strcol(1) eq body[b] ? scale * $3 : NaN):(100 * $4) with points pointtype 7 pointsize 0.25 \
            linecolor rgb 0xc0c5ce title "every configuration", '.lines.' \
        least(b, 3) using (scale * $3):(100 * $4):5 with labels @side font ",9" textcolor rgb colour[3] notitle'
}
unset multiplot
