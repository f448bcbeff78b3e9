#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Remakes every picture of README.md and docs/, in docs/pictures/. Called by `make figures` from the project's root, when
# programs and scenes are made. `scripts/figures.sh pictures` makes those of the viewer and the page alone.
set -eu
BUILD=${BUILD:-build}
work=$BUILD/figures
pictures=docs/pictures
. scripts/own.sh
plain "$BUILD"
own "$work" figures

# plot NAME [DEFINITIONS]: docs/figures/NAME.gp draws NAME.svg.
plot() {
    gnuplot -e "out='$work/$1.svg'; ${2:-}" "docs/figures/$1.gp"
    mv "$work/$1.svg" "$pictures/$1.svg"
    echo "  $pictures/$1.svg"
}

if [ "${1:-}" != pictures ]; then
# ---- drawings ------------------------------------------------------------------------------------------------------

plot signal-path
plot states
plot device-frames

# From outside to 6 mm under the cube's top.
printf 'x,y,z\n0.013,0.0165,0.031\n0.0118,0.0172,0.024\n' >"$work/tick.path.csv"
"$BUILD/cube/servo" --quiet --replay "$work/tick.path.csv" --out "$work/tick.csv"
plot contact "felt='$(tail -n 1 "$work/tick.csv" | tr , ' ')'"

# Down 10 mm into the liver for 8 s, out for 1 s, and again. Places are "ms mm", smoothly.
top=$("$BUILD/liver-capsule/servo" --poke top --json | sed -n 's/.*"at_m": "\(.*\)".*/\1/p')
awk -v top="$top" 'BEGIN { split(top, at, " "); print "x,y,z" }
     NR > 1 { for (i = 0; i < $1 - t; ++i) {
         s = i / ($1 - t); s = s * s * s * (10 - 15 * s + 6 * s * s)
         printf "%.6f,%.6f,%.6f\n", at[1], at[2], at[3] + (d + s * ($2 - d)) / 1e3 } }
     { t = $1; d = $2 }' >"$work/relaxation.path.csv" <<PLACES
0 5
400 -10
8400 -10
8600 5
9600 5
10000 -10
14000 -10
14300 5
PLACES
"$BUILD/liver-capsule/servo" --quiet --replay "$work/relaxation.path.csv" --out "$work/relaxation.csv"
plot relaxation "felt='$work/relaxation.csv'"

# Two fingers on the cube's top: the second 1 mm deep, the first to 4 mm and out again.
awk 'BEGIN { print "x,y,z,x2,y2,z2"
     for (i = 0; i < 1600; ++i) {
         a = i < 300 ? i / 300 : 1
         b = i < 500 ? 0 : i < 900 ? (i - 500) / 400 : i < 1000 ? 1 : i < 1400 ? (1400 - i) / 400 : 0
         printf "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", 0.0113, 0.0152, 0.0302 - 0.0042 * b, 0.0188, 0.0152, 0.0302 - 0.0012 * a
     } }' >"$work/fingers.path.csv"
"$BUILD/cube-two/servo" --quiet --replay "$work/fingers.path.csv" --out "$work/fingers.csv"
plot fingers "felt='$work/fingers.csv'"

# The table of docs/TIME.md, which a test measures.
awk -F'|' '/speed x time . radius/ { on = 1; next } on && /^\|[- |]*$/ { next } on && !/^\|/ { exit } on { print $2, $3, $4 }' \
    docs/TIME.md >"$work/sliding.txt"
plot relaxation-sliding "errors='$work/sliding.txt'"

# ---- plots of what was measured ------------------------------------------------------------------------------------

"$BUILD/bin/haptable-contact" --curves --build "$BUILD/contact"
sh scripts/plots.sh docs/numbers.json "$work"
for name in accuracy error-time error-flash error-precompute large-strain contact-line contact-loop contact-edge; do
    mv "$work/$name.svg" "$pictures/$name.svg"
    echo "  $pictures/$name.svg"
done

fi
# The dent that is there 0.1 s after the finger has left, in a session on the same path.
"$BUILD/bin/haptable-run" meshes/liver-capsule.toml --path "$work/relaxation.path.csv" --lockstep --seconds 9 \
    --draw nothing --quiet --out "$work/relaxation"
"$BUILD/bin/haptable-view" "$BUILD/liver-capsule" --quiet --log "$work/relaxation/session.lcmlog" --ticks 8650 \
    --size 640x480 -o "$pictures/liver-dent.png"
echo "  $pictures/liver-dent.png"

# The liver poked and dragged over, as docs/LIVER.md has it.
"$BUILD/bin/haptable-run" meshes/liver-capsule.toml --path poke,drag --lockstep --seconds 6 --draw nothing --quiet \
    --out "$work/liver"
"$BUILD/bin/haptable-view" "$BUILD/liver-capsule" --quiet --log "$work/liver/session.lcmlog" --every 150 --size 400x300 \
    --elevation 25 -o "$pictures/liver.gif"
echo "  $pictures/liver.gif"

# ---- pictures and film ---------------------------------------------------------------------------------------------

BUILD=$BUILD sh scripts/demo.sh --figures >/dev/null
for picture in cube-mesh cube-uz cube-ux mouse-uz; do
    cp "$BUILD/demo/$picture.png" "$pictures/$picture.png"
    echo "  $pictures/$picture.png"
done

# What else a picture shows: the rest shape as a ghost, nodal forces of a mask, a mesh as it is judged.
"$BUILD/bin/haptable-view" "$BUILD/cube" --quiet --csv "$BUILD/demo/cube-uz.csv" --ticks 150 --ghost --size 640x480 \
    -o "$pictures/cube-ghost.png"
echo "  $pictures/cube-ghost.png"
"$BUILD/bin/haptable-view" "$BUILD/mouse" --quiet --mesh --elevation -30 --size 640x480 -o "$pictures/mouse-mesh.png"
echo "  $pictures/mouse-mesh.png"

# A picture a law (docs/MATERIALS.md).
# sag NAME SCENE [OPTIONS]: the scene under its own weight.
sag() {
    name=$1 scene=$2
    shift 2
    "$BUILD/bin/haptable-precompute" "$scene" -o "$work/$name" --quiet
    "$BUILD/bin/haptable-view" "$work/$name" --quiet --sag --ghost --size 480x360 "$@" -o "$pictures/$name.png"
    echo "  $pictures/$name.png"
}
# press NAME SCENE X Y TOP [OPTIONS]: pressed 2 mm deep.
press() {
    name=$1 scene=$2
    awk -v x="$3" -v y="$4" -v top="$5" 'BEGIN { print "x,y,z"
        for (i = 0; i <= 100; ++i) printf "%g,%g,%.6f\n", x, y, top + 5e-4 - 2.5e-5 * i }' >"$work/$name.path.csv"
    shift 5
    "$BUILD/$scene/servo" --quiet --replay "$work/$name.path.csv" --out "$work/$name.csv"
    "$BUILD/bin/haptable-view" "$BUILD/$scene" --quiet --csv "$work/$name.csv" --ticks 100 --size 480x360 "$@" \
        -o "$pictures/$name.png"
    echo "  $pictures/$name.png"
}
sag law-bar meshes/laws/bar.toml --azimuth -90 --elevation 5 --zoom 0.85 --exaggerate 10
sag law-ball meshes/laws/ball.toml --zoom 0.75 --exaggerate 3 --range 4
sag law-balloon meshes/laws/balloon.toml --zoom 0.75 --exaggerate 3 --range 4
sag liver-sag meshes/liver-capsule.toml --azimuth -90 --elevation 10 --exaggerate 4
press law-fibres fibres 0.015 0.015 0.03 --azimuth -90 --elevation 75 --zoom 1.1 --exaggerate 2
press law-bed bed 0.0262 0.015 0.03 --azimuth -90 --elevation 8 --zoom 0.85 --exaggerate 3 --ghost

# The page in a browser, pressed and dragged by a pointer.
"$BUILD/bin/haptable-view" "$BUILD/mouse" --page "$work/touch.html" --quiet
"$BUILD/tests/touch_picture/touch-picture" "$work/touch.html" -o "$pictures/touch.png"
echo "  $pictures/touch.png"
"$BUILD/bin/haptable-view" "$BUILD/cube-two" --page "$work/touch-two.html" --quiet
"$BUILD/tests/touch_picture/touch-picture" "$work/touch-two.html" -o "$pictures/touch-two.png"
echo "  $pictures/touch-two.png"

# A finger's path through places "ms x y z", mm; between them it moves smoothly (minimum jerk).
smooth_path() {
    awk 'NR == 1 { print "x,y,z" }
         NR > 1 { for (i = 0; i < $1 - t; ++i) {
             s = i / ($1 - t); s = s * s * s * (10 - 15 * s + 6 * s * s)
             printf "%.6f,%.6f,%.6f\n", (x + s * ($2 - x)) / 1e3, (y + s * ($3 - y)) / 1e3, (z + s * ($4 - z)) / 1e3 } }
         { t = $1; x = $2; y = $3; z = $4 }'
}

# A finger tip of 12 mm over the mouse: down, aside, across, back, up.
smooth_path >"$work/mouse.path.csv" <<PLACES
0 -15 0 44
400 -15 0 31
700 -15 0 30
1700 16 13 25
2300 16 -13 25
3100 -15 0 30
3300 -15 0 30
3700 -15 0 44
PLACES
"$BUILD/mouse-mask/servo" --quiet --replay "$work/mouse.path.csv" --out "$work/mouse.csv"
"$BUILD/bin/haptable-view" "$BUILD/mouse-mask" --quiet --csv "$work/mouse.csv" --every 80 --size 560x420 --elevation 32 \
    --samples 4 -o "$pictures/mouse.gif"
echo "  $pictures/mouse.gif"
[ "$(stat -c %s "$pictures/mouse.gif")" -lt 3000000 ] || { echo "$pictures/mouse.gif: is over 3 MB" >&2 && exit 1; }

# Down onto the top of a cube that nothing holds, and along it: friction tips it over its edge.
smooth_path >"$work/free.path.csv" <<PLACES
0 15 15 45
500 15 15 26.5
700 15 15 26.5
1900 40 15 26.5
2400 40 15 60
3000 40 15 60
PLACES
"$BUILD/free-cube/servo" --quiet --replay "$work/free.path.csv" --out "$work/free.csv"
"$BUILD/bin/haptable-view" "$BUILD/free-cube" --quiet --csv "$work/free.csv" --every 50 --size 480x360 --zoom 0.5 \
    --azimuth -60 --elevation 18 -o "$pictures/free-cube.gif"
echo "  $pictures/free-cube.gif"

# Two fingers on its sides: in, up, away. The second is the first's mirror image.
smooth_path <<PLACES | awk -F, 'NR == 1 { print "x,y,z,x2,y2,z2" } NR > 1 { printf "%s,%.6f,%s,%s\n", $0, 0.03 - $1, $2, $3 }' \
    >"$work/grasp.path.csv"
0 -8 15 20
600 2.5 15 20
900 2.5 15 20
2100 2.5 15 55
3000 2.5 15 55
3600 -10 15 55
4300 -10 15 55
PLACES
"$BUILD/grasp-cube/servo" --quiet --replay "$work/grasp.path.csv" --out "$work/grasp.csv"
"$BUILD/bin/haptable-view" "$BUILD/grasp-cube" --quiet --csv "$work/grasp.csv" --every 50 --size 480x360 --zoom 0.45 \
    --azimuth -60 --elevation 14 -o "$pictures/grasp-cube.gif"
echo "  $pictures/grasp-cube.gif"

# A knock on a jelly's side, four times as slow: it rings.
smooth_path >"$work/jelly.path.csv" <<PLACES
0 -15 15 26
120 -2 15 26
200 6 15 26
260 6 15 26
290 -15 15 26
900 -15 15 26
PLACES
"$BUILD/jelly/servo" --quiet --replay "$work/jelly.path.csv" --out "$work/jelly.csv"
"$BUILD/bin/haptable-view" "$BUILD/jelly" --quiet --csv "$work/jelly.csv" --every 12 --fps 20 --size 400x320 --zoom 0.75 \
    --azimuth -75 --elevation 12 -o "$pictures/jelly.gif"
echo "  $pictures/jelly.gif"

# Two fingers take hold of it, pull it aside and let go, four times as slow.
smooth_path >"$work/first.path.csv" <<PLACES
0 -8 15 24
150 3.5 15 24
200 3.5 15 24
450 11.5 15 24
550 11.5 15 24
600 -16 15 24
1150 -16 15 24
PLACES
smooth_path >"$work/second.path.csv" <<PLACES
0 38 15 24
150 26.5 15 24
200 26.5 15 24
450 34.5 15 24
550 34.5 15 24
600 52 15 24
1150 52 15 24
PLACES
paste -d, "$work/first.path.csv" "$work/second.path.csv" | sed '1s/.*/x,y,z,x2,y2,z2/' >"$work/both.path.csv"
"$BUILD/jelly-two/servo" --quiet --replay "$work/both.path.csv" --out "$work/both.csv"
"$BUILD/bin/haptable-view" "$BUILD/jelly-two" --quiet --csv "$work/both.csv" --every 12 --fps 20 --size 400x320 \
    --zoom 0.75 --azimuth -75 --elevation 12 -o "$pictures/jelly-two.gif"
echo "  $pictures/jelly-two.gif"
