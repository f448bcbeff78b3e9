# Times of one tick and of what one would do instead: docs/pictures/accuracy.svg. `make figures` calls it with `out` and
# with `data`: the values of the topic "speed" in docs/numbers.json.
set terminal svg size 900,480 font "DejaVu Sans,12" background "white"
stats data using (1e6 * $2) every ::0::0 name "SLIDING" nooutput
stats data using (1e6 * $2) every ::2::2 name "EVERY" nooutput
stats data using (1e6 * $2) every ::4::4 name "SOLVE" nooutput
@must (SLIDING_max < 1000) 'a force within a tick of 1 ms'
@must (EVERY_max > 5 * SLIDING_max && SOLVE_max > 5 * SLIDING_max) 'a tick that costs less than what one would do instead'
set output out
set title "CPU time of one tick, and of what else there is to do"
set key top left
set style data histogram
set style histogram clustered gap 1
set style fill solid 0.9 border -1
set logscale y
set ylabel "microseconds of CPU"
set yrange [0.01:*]
set format y "10^{%T}"
set grid ytics
set xtics font ",10"
set bmargin 4
set label "a tick of the servo: 1 ms" at graph 0.01, first 1300 font ",10"
set arrow from graph 0,first 1000 to graph 1,first 1000 nohead dashtype 2
array what[6] = ["force,\nsliding", "force,\n2 mm above", "instead: nearest\nof every patch", "displacement,\nequation 8", "instead: a solve\nby the factor", "a picture,\n960 x 720"]
plot data using (1e6 * $2):xtic(what[int($0) + 1]) every ::0::5 title "cube" linecolor rgb "#3b528b", \
     "" using (1e6 * $3) every ::0::5 title "mouse" linecolor rgb "#5ec962"
