# How a scene becomes a force and a picture: docs/pictures/signal-path.svg. `make figures` calls it with `out`.
# Coordinates are pixels, y upwards.
set encoding utf8
set terminal svg size 1040,480 font "DejaVu Sans,13" background "white"
set output out
unset border; unset tics; unset key
set xrange [0:1040]; set yrange [0:480]
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0

# A place: left, bottom, right, top, and what is written in its corner.
$place << EOD
10 350 1030 470 "once, on the host: haptable-precompute"
150 170 890 310 "every millisecond, on the microcontroller: haptable\\_step"
150 10 890 130 "beside it, at its own rate: haptable-view"
EOD

# A box: middle, width, height, text.
$host << EOD
90 398 130 56 "scene, mesh"
265 398 130 56 "stiffness K"
440 398 130 56 "factor of K"
615 398 130 56 "blocks of\nL = K⁻¹"
790 398 130 56 "tables (.npy)"
955 398 110 56 "model.c"
EOD
$tick << EOD
235 228 140 80 "{/:Bold contact}\ngod-object g,\nfriction"
405 228 140 80 "{/:Bold force}\nu = x − g\nF = −S(α) u"
590 228 170 80 "{/:Bold gate}\nfinite, at most\nmax\\_force"
785 228 160 80 "{/:Bold where named}\nrelease,\npassivity"
EOD
$view << EOD
330 62 260 66 "{/:Bold equation 8}\nu_r = Σ L_{ri} F_i"
650 62 240 66 "{/:Bold picture}\nPNG, film, ParaView"
EOD
$device << EOD
72 228 104 80 "{/:Bold device}\nor its\nsimulation"
EOD

# A line: from, to. The last piece of a path has the arrow's head.
$arrow << EOD
155 398 200 398
330 398 375 398
505 398 550 398
680 398 725 398
855 398 900 398
305 228 335 228
475 228 505 228
675 228 705 228
460 62 530 62
820 330 820 310
EOD
$line << EOD
955 370 955 330
955 330 820 330
EOD
$felt_arrow << EOD
124 228 165 228
72 150 72 188
EOD
$felt_line << EOD
785 188 785 150
785 150 72 150
EOD
$drawn_arrow << EOD
440 188 440 95
1005 62 890 62
EOD
$drawn_line << EOD
1005 350 1005 62
EOD
$note << EOD
842 322 "the servo's tables"
84 141 "force F"
138 242 "x"
449 140 "nodal forces F_i"
898 76 "columns of L"
EOD

lines(text) = strstrt(text, "\n") == 0 ? 1 : strstrt(text[strstrt(text, "\n") + 1:*], "\n") == 0 ? 2 : 3
middle(y, text) = y + 8.5 * (lines(text) - 1)
grey = 0x4a5568; red = 0xc2410c; blue = 0x1d4ed8
plot $place using (($1 + $3) / 2):(($2 + $4) / 2):(($3 - $1) / 2):(($4 - $2) / 2) with boxxyerror \
         fillcolor rgb 0xf4f1ea fillstyle solid 1.0 border linecolor rgb 0xd6d0c4, \
     for [data in "line felt_line drawn_line"] "$".data using 1:2:($3 - $1):($4 - $2) with vectors nohead linewidth 1.5 \
         linecolor rgb (data eq "line" ? grey : data eq "felt_line" ? red : blue), \
     for [data in "arrow felt_arrow drawn_arrow"] "$".data using 1:2:($3 - $1):($4 - $2) with vectors size 9,20 filled \
         linewidth 1.5 linecolor rgb (data eq "arrow" ? grey : data eq "felt_arrow" ? red : blue), \
     for [data in "host tick view device"] "$".data using 1:2:($3 / 2):($4 / 2) with boxxyerror linecolor rgb grey \
         fillcolor rgb (data eq "host" ? 0xdbe7f3 : data eq "tick" ? 0xfde6d3 : data eq "view" ? 0xdff0e0 : 0xffffff) \
         fillstyle solid 1.0 border linecolor rgb grey, \
     for [data in "host tick view device"] "$".data using 1:(middle($2, strcol(5))):5 with labels, \
     $place using ($1 + 12):($4 - 14):5 with labels left font ",12" textcolor rgb 0x6b6558, \
     $note using 1:2:3 with labels left font ",11" textcolor rgb grey
