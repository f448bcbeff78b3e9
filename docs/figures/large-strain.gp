# Where a linear body's force leaves a rubber's: docs/pictures/large-strain.svg. `make figures` calls it with `out` and
# with `data`: the values of the topic "large-strain-curve" in docs/numbers.json.
set terminal svg size 1200,400 font "DejaVu Sans,12" background "white"
array body[4] = ["cube, nu 0.3", "cube, nu 0.49", "mouse", "liver"]
array way[3] = ["pressing", "sideways", "pulling"]
is(b, w) = strcol(1) eq body[b] && strcol(2) eq way[w]
do for [b=1:4] { do for [w=1:3] {
  stats data using (is(b, w) ? abs($4 - 1) : NaN) name "BEND" nooutput
  @must (BEND_records > 2 && BEND_min < 0.1 && BEND_max > 0.05) \
       sprintf("a force that leaves the linear one, %s %s", body[b], way[w])
}}
set output out
set multiplot layout 1,4 margins 0.07,0.98,0.14,0.76 spacing 0.06,0.1 title "Force of a neo-Hookean body over the linear one (points: CalculiX; lines: expected by haptable-precompute; grey: within 10 %)"
set grid
set xlabel "displacement, mm"
set yrange [0.6:1.2]
set ytics 0.1
array colour[3] = [0x3b528b, 0x21918c, 0xd6337c]
array furthest_mm[4] = [16, 16, 30, 30]
array sign[3] = [7, 5, 9]
set style rect fillstyle solid 0.25 noborder
set object 1 rect from graph 0, first 0.9 to graph 1, first 1.1 behind fillcolor rgb 0xcbd5e0
do for [b=1:4] {
  set title body[b]
  set xrange [0:furthest_mm[b]]
  if (b == 1) { set key at screen 0.5,0.93 center top maxrows 1 samplen 2; set ylabel "F / F linear" } else { unset key; unset ylabel }
  plot for [w=1:3] data using (1e3 * $3):(is(b, w) ? $4 : NaN) with points pointtype sign[w] pointsize 0.6 linecolor rgb colour[w] title way[w], \
       for [w=1:3] data using (is(b, w) ? 1e3 * $3 : NaN):5 with lines linewidth 1.5 linecolor rgb colour[w] notitle
}
unset multiplot
