# One tick of the servo on the top of the paper's cube: docs/pictures/contact.svg. `make figures` calls it with `out`
# and with `felt`, that tick's line of the servo's CSV: nodes, area coordinates, god-object and force are drawn from it.
set encoding utf8
set terminal svg size 780,546 font "DejaVu Sans,14" background "white"
set output out
unset border; unset tics; unset key
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
set size ratio -1
set xrange [-14:14]; set yrange [-9.9:9.7]

column_of(k) = real(word(felt, k))
array finger[3] = [1e3 * column_of(2), 1e3 * column_of(3), 1e3 * column_of(4)]    # finger, mm
array god[3] = [1e3 * column_of(12), 1e3 * column_of(13), 1e3 * column_of(14)] # god-object, mm
array force[3] = [column_of(15), column_of(16), column_of(17)]               # N
array node[3] = [column_of(6), column_of(7), column_of(8)]
newton = 9.0 # mm of the picture
size(x, y, z) = sqrt(x**2 + y**2 + z**2)
@must (column_of(5) == 1) 'a contact'
@must (abs(god[3] - 30) < 0.01) 'the god-object on the surface'
@must (abs(column_of(9) + column_of(10) + column_of(11) - 1) < 1e-3) 'the patch and its area coordinates'
@must (size(finger[1] - god[1], finger[2] - god[2], finger[3] - god[3]) > 3) 'u, 3 mm long'
@must (size(force[1], force[2], force[3]) > 0.3) 'F, 0.3 N or more'

# The generator's cube: 5 nodes a side, 7.5 mm between them, numbered x fastest, then y.
X(n) = 7.5 * (int(n) % 5)
Y(n) = 7.5 * (int(n) / 5 % 5)

# Seen from the front and above, without perspective: across and up, mm.
turn = -15.0 / 180 * pi; tilt = 42.0 / 180 * pi
across(x, y) = (x - 11.25) * cos(turn) - (y - 20) * sin(turn)
up(x, y, z) = ((x - 11.25) * sin(turn) + (y - 20) * cos(turn)) * sin(tilt) + (z - 30) * cos(tilt)

# Two patches a cell of the top; their common edge alternates from cell to cell.
set print $patch
do for [i = 0:2] { do for [j = 2:3] { do for [half = 0:1] { do for [k = 0:3] {
    c = ((i + j) % 2 + 1 + 2 * half + k % 3) % 4 # corner of the cell, counter-clockwise
    px = 7.5 * (i + (c == 1 || c == 2)); py = 7.5 * (j + (c > 1))
    print across(px, py), up(px, py, 30)
}
print ""
}}}
# The body is cut along a mesh line, so that the finger in it is seen.
set print $cut
print across(0, 15), up(0, 15, 30)
print across(22.5, 15), up(22.5, 15, 30)
print across(22.5, 15), up(22.5, 15, 24)
print across(0, 15), up(0, 15, 24)
print across(0, 15), up(0, 15, 30)
set print $touched
do for [k = 1:3] { print across(X(node[k]), Y(node[k])), up(X(node[k]), Y(node[k]), 30) }
unset print

gx = across(god[1], god[2]); gy = up(god[1], god[2], god[3])
fx = across(finger[1], finger[2]); fy = up(finger[1], finger[2], finger[3])
ex = gx + newton * (across(finger[1] + force[1], finger[2] + force[2]) - fx)
ey = gy + newton * (up(finger[1] + force[1], finger[2] + force[2], finger[3] + force[3]) - fy)
# All of it is in the picture.
in_picture(x, y) = abs(x) < 13 && abs(y) < 9
@must (in_picture(gx, gy) && in_picture(fx, fy) && in_picture(ex, ey)) 'finger, god-object and force in its frame'
blue = 0x1d4ed8; grey = 0x4a5568
do for [k = 1:3] {
    nx = across(X(node[k]), Y(node[k])); ny = up(X(node[k]), Y(node[k]), 30)
    set arrow from gx, gy to nx, ny nohead front dashtype 3 linecolor rgb grey
    set object circle at nx, ny size 0.22 front fillstyle solid fillcolor rgb grey
    away = sqrt((nx - gx)**2 + (ny - gy)**2)
    at_node = sprintf("V_%s, α_%s = %.2f", word("i j k", k), word("i j k", k), column_of(8 + k))
    lx = nx + 0.9 * (nx - gx) / away; ly = ny + (nx > gx && ny < gy ? 1.8 : 0.9) * (ny - gy) / away
    if (nx < gx) { set label at_node at lx, ly front right textcolor rgb grey }
    if (nx >= gx) { set label at_node at lx, ly front left textcolor rgb grey }
}
set arrow from gx, gy to fx, fy front size 0.5,18 filled linewidth 3 linecolor rgb blue
set arrow from gx, gy to ex, ey front size 0.5,18 filled linewidth 3 linecolor rgb color_force
set object circle at gx, gy size 0.34 front fillstyle solid fillcolor rgb color_god_object
set object circle at fx, fy size 0.55 front fillstyle solid fillcolor rgb color_finger
set label "u = x − g" at 0.35 * gx + 0.65 * fx, 0.35 * gy + 0.65 * fy front left offset 1.0, 0 textcolor rgb blue
set label sprintf("F, the force on the finger: %.2f N", sqrt(force[1]**2 + force[2]**2 + force[3]**2)) at ex, ey front left \
    offset 1.2, 0 textcolor rgb color_force
set label "x, the finger" at fx, fy front left offset 2.2, -0.3
set label "g, the god-object" at gx, gy front right offset -1.6, 1.0
set label "the surface at rest" at across(0.6, 29), up(0.6, 29, 30) front left offset 0.8, -1.6 font ",12" textcolor rgb grey
plot $patch using 1:2 with filledcurves closed fillcolor rgb 0xf4f1ea fillstyle solid 1.0 border linecolor rgb 0x9a958a, \
     $touched using 1:2 with filledcurves closed fillcolor rgb 0xfde6d3 fillstyle solid 1.0 border linecolor rgb color_finger, \
     $cut using 1:2 with filledcurves closed fillcolor rgb 0xe7e2d6 fillstyle solid 1.0 border linecolor rgb 0x9a958a
