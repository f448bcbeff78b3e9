#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# figures.sh [NAME ...]: remakes these pictures of README.md and docs/, or all, in docs/pictures/. `make figures` calls
# it from the project's root, when programs and scenes are made. A picture that does not show what it is about is an
# error, and the one that is there stays.
set -eu
BUILD=${BUILD:-build}
work=$BUILD/figures
pictures=${PICTURES:-docs/pictures}
. scripts/own.sh
plain "$BUILD"
own "$work" figures

drawings="signal-path states device-frames contact relaxation fingers relaxation-sliding measured"
views="liver-dent liver demo cube-ghost mouse-mesh law-bar law-ball law-balloon liver-sag law-fibres law-bed"
pages="touch touch-two"
films="mouse free-cube grasp-cube jelly jelly-two"

# ---- what a picture is about ---------------------------------------------------------------------------------------

# shows CSV COLUMN LOW HIGH [TICK]: refuses a servo's CSV whose column is never at most LOW, or never at least HIGH (at
# that tick, else in any). |force| is the force's size.
shows() {
    awk -F, -v csv="$1" -v column="$2" -v low="$3" -v high="$4" -v tick="${5:-}" '
        NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i
            if (column == "|force|" || column in at) next
            print csv ": has no column " column >"/dev/stderr"; bad = 1; exit }
        tick != "" && $at["tick"] != tick { next }
        { value = column == "|force|" ? sqrt($at["force_x"]^2 + $at["force_y"]^2 + $at["force_z"]^2) : $at[column]
          if (n++ == 0 || value < least) least = value
          if (n == 1 || value > most) most = value }
        END { if (bad) exit 1
            if (n > 0 && least + 0 <= low + 0 && most + 0 >= high + 0) exit 0
            if (n == 0) least = most = "nothing"
            printf("%s: %s is to go from %s to %s%s, and goes from %s to %s\n", csv, column, low, high,
                (tick == "" ? "" : " at tick " tick), least, most) >"/dev/stderr"
            exit 1 }' "$1"
}
# presses CSV NEWTONS [TICK]: a contact with this force or more.
presses() { shows "$1" contact 1 1 "${3:-}" && shows "$1" '|force|' 1e9 "$2" "${3:-}"; }

# counts TABLES KEY LEAST: refuses tables whose summary.json has less of KEY.
counts() {
    number=$(sed -n "s/.*\"$2\": *\([-+.0-9e]*\).*/\1/p" "$1/summary.json" | head -n 1)
    awk -v number="$number" -v least="$3" 'BEGIN { exit !(number + 0 >= least + 0) }' ||
        { echo "$1/summary.json: $2 is to be $3 or more, and is ${number:-not there}" >&2 && exit 1; }
}

# put NAME: the picture in $work, now that it is whole.
put() {
    [ "$(stat -c %s "$work/$1")" -lt 3000000 ] || { echo "$work/$1: is over 3 MB" >&2 && exit 1; }
    mv "$work/$1" "$pictures/$1"
    echo "  $pictures/$1"
}

# ---- drawings and plots --------------------------------------------------------------------------------------------

# plot NAME [DEFINITIONS]: docs/figures/NAME.gp draws NAME.svg.
plot() {
    sh scripts/plot.sh "$1" "$work/$1.svg" "${2:-}"
    put "$1.svg"
}

figure_signal_path() { plot signal-path; }
figure_states() { plot states; }
figure_device_frames() { plot device-frames; }

# From outside to 6 mm under the cube's top, at 0.1 m/s.
figure_contact() {
    awk 'BEGIN { print "x,y,z"; for (s = 0; s < 1.001; s += 1 / 70)
        printf "%.6f,%.6f,%.6f\n", 0.013 - 0.0012 * s, 0.0165 + 0.0007 * s, 0.031 - 0.007 * s }' >"$work/tick.path.csv"
    "$BUILD/cube/servo" --quiet --replay "$work/tick.path.csv" --out "$work/tick.csv"
    plot contact "felt='$(tail -n 1 "$work/tick.csv" | tr , ' ')'"
}

# Down 10 mm into the liver for 8 s, out for 1 s, and again. Places are "ms mm", smoothly.
relaxation_path() {
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
}
figure_relaxation() {
    relaxation_path
    "$BUILD/liver-capsule/servo" --quiet --replay "$work/relaxation.path.csv" --out "$work/relaxation.csv"
    plot relaxation "felt='$work/relaxation.csv'"
}

# Two fingers on the cube's top: the second 1 mm deep, the first to 4 mm and out again.
figure_fingers() {
    awk 'BEGIN { print "x,y,z,x2,y2,z2"
         for (i = 0; i < 1600; ++i) {
             a = i < 300 ? i / 300 : 1
             b = i < 500 ? 0 : i < 900 ? (i - 500) / 400 : i < 1000 ? 1 : i < 1400 ? (1400 - i) / 400 : 0
             printf "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", 0.0113, 0.0152, 0.0302 - 0.0042 * b, 0.0188, 0.0152, 0.0302 - 0.0012 * a
         } }' >"$work/fingers.path.csv"
    "$BUILD/cube-two/servo" --quiet --replay "$work/fingers.path.csv" --out "$work/fingers.csv"
    plot fingers "felt='$work/fingers.csv'"
}

# The table of docs/TIME.md, which a test measures.
figure_relaxation_sliding() {
    awk -F'|' '/speed x time . radius/ { on = 1; next } on && /^\|[- |]*$/ { next } on && !/^\|/ { exit } on { print $2, $3, $4 }' \
        docs/TIME.md >"$work/sliding.txt"
    plot relaxation-sliding "errors='$work/sliding.txt'"
}

# What was measured.
figure_measured() {
    "$BUILD/bin/haptable-contact" --curves --build "$BUILD/contact"
    sh scripts/plots.sh docs/numbers.json "$work"
    for name in accuracy error-time error-flash error-precompute large-strain contact-line contact-loop contact-edge; do
        put "$name.svg"
    done
}

# ---- pictures ------------------------------------------------------------------------------------------------------

# view NAME TABLES OPTIONS: haptable-view draws the picture or film NAME.
view() {
    name=$1 tables=$2
    shift 2
    "$BUILD/bin/haptable-view" "$tables" --quiet "$@" -o "$work/$name"
    put "$name"
}

# The dent that is there 0.1 s after the finger has left, in a session on the same path.
figure_liver_dent() {
    relaxation_path
    "$BUILD/bin/haptable-run" meshes/liver-capsule.toml --path "$work/relaxation.path.csv" --lockstep --seconds 9 \
        --draw nothing --quiet --out "$work/relaxation"
    presses "$work/relaxation/servo.csv" 0.2 8000
    shows "$work/relaxation/servo.csv" contact 0 0 8650
    view liver-dent.png "$BUILD/liver-capsule" --log "$work/relaxation/session.lcmlog" --ticks 8650 --size 640x480
}

# The liver poked and dragged over, as docs/LIVER.md has it.
figure_liver() {
    "$BUILD/bin/haptable-run" meshes/liver-capsule.toml --path poke,drag --lockstep --seconds 6 --draw nothing --quiet \
        --out "$work/liver"
    shows "$work/liver/servo.csv" '|force|' 0 0.2
    view liver.gif "$BUILD/liver-capsule" --log "$work/liver/session.lcmlog" --every 150 --size 400x300 --elevation 25
}

# Figures 1 and 2 of the paper.
figure_demo() {
    BUILD=$BUILD sh scripts/demo.sh --figures >/dev/null
    for felt in cube-uz cube-ux mouse-uz; do presses "$BUILD/demo/$felt.csv" 0.01 150; done
    for picture in cube-mesh cube-uz cube-ux mouse-uz; do
        cp "$BUILD/demo/$picture.png" "$work/"
        put "$picture.png"
    done
}

# What else a picture shows: the rest shape as a ghost, a mesh as it is judged.
figure_cube_ghost() {
    presses "$BUILD/demo/cube-uz.csv" 0.1 150
    view cube-ghost.png "$BUILD/cube" --csv "$BUILD/demo/cube-uz.csv" --ticks 150 --ghost --size 640x480
}
figure_mouse_mesh() {
    counts "$BUILD/mouse" fixed_nodes 1
    view mouse-mesh.png "$BUILD/mouse" --mesh --elevation -30 --size 640x480
}

# A picture a law (docs/MATERIALS.md).
# sag NAME SCENE [OPTIONS]: the scene under its own weight.
sag() {
    name=$1 scene=$2
    shift 2
    "$BUILD/bin/haptable-precompute" "$scene" -o "$work/$name" --quiet
    counts "$work/$name" largest_sag_m 1e-4
    view "$name.png" "$work/$name" --sag --ghost --size 480x360 "$@"
}
# press NAME SCENE X Y TOP [OPTIONS]: pressed 2 mm deep.
press() {
    name=$1 scene=$2
    awk -v x="$3" -v y="$4" -v top="$5" 'BEGIN { print "x,y,z"
        for (i = 0; i <= 100; ++i) printf "%g,%g,%.6f\n", x, y, top + 5e-4 - 2.5e-5 * i }' >"$work/$name.path.csv"
    shift 5
    "$BUILD/$scene/servo" --quiet --replay "$work/$name.path.csv" --out "$work/$name.csv"
    presses "$work/$name.csv" 0.05 100
    view "$name.png" "$BUILD/$scene" --csv "$work/$name.csv" --ticks 100 --size 480x360 "$@"
}
figure_law_bar() { sag law-bar meshes/laws/bar.toml --azimuth -90 --elevation 5 --zoom 0.85 --exaggerate 10; }
figure_law_ball() { sag law-ball meshes/laws/ball.toml --zoom 0.75 --exaggerate 3 --range 4; }
figure_law_balloon() { sag law-balloon meshes/laws/balloon.toml --zoom 0.75 --exaggerate 3 --range 4; }
figure_liver_sag() { sag liver-sag meshes/liver-capsule.toml --azimuth -90 --elevation 10 --exaggerate 4; }
figure_law_fibres() { press law-fibres fibres 0.015 0.015 0.03 --elevation 75 --azimuth -90 --zoom 0.9 --exaggerate 2; }
figure_law_bed() { press law-bed bed 0.0262 0.015 0.03 --azimuth -90 --elevation 8 --zoom 0.85 --exaggerate 3 --ghost; }

# page NAME TABLES: the page in a browser, pressed and dragged by a pointer, which touch-picture wants to dent it.
page() {
    "$BUILD/bin/haptable-view" "$2" --page "$work/$1.html" --quiet
    "$BUILD/tests/touch_picture/touch-picture" "$work/$1.html" -o "$work/$1.png"
    put "$1.png"
}
figure_touch() { page touch "$BUILD/mouse"; }
figure_touch_two() { page touch-two "$BUILD/cube-two"; }

# ---- films ---------------------------------------------------------------------------------------------------------

# A finger's path through places "ms x y z", mm; between them it moves smoothly (minimum jerk).
smooth_path() {
    awk 'NR == 1 { print "x,y,z" }
         NR > 1 { for (i = 0; i < $1 - t; ++i) {
             s = i / ($1 - t); s = s * s * s * (10 - 15 * s + 6 * s * s)
             printf "%.6f,%.6f,%.6f\n", (x + s * ($2 - x)) / 1e3, (y + s * ($3 - y)) / 1e3, (z + s * ($4 - z)) / 1e3 } }
         { t = $1; x = $2; y = $3; z = $4 }'
}

# felt NAME SCENE: what the path $work/NAME.path.csv gives in a scene; film NAME SCENE OPTIONS: a film of it.
felt() { "$BUILD/$2/servo" --quiet --replay "$work/$1.path.csv" --out "$work/$1.csv"; }
film() {
    name=$1 scene=$2
    shift 2
    view "$name.gif" "$BUILD/$scene" --csv "$work/$name.csv" "$@"
}

# A finger tip of 12 mm over the mouse: down, aside, across, back, up.
figure_mouse() {
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
    felt mouse mouse-mask
    shows "$work/mouse.csv" '|force|' 0 0.05
    film mouse mouse-mask --every 80 --size 560x420 --elevation 32 --samples 4
}

# Down onto the top of a cube that nothing holds, and along it: friction tips it over its edge.
figure_free_cube() {
    smooth_path >"$work/free-cube.path.csv" <<PLACES
0 15 15 45
500 15 15 26.5
700 15 15 26.5
1900 40 15 26.5
2400 40 15 60
3000 40 15 60
PLACES
    felt free-cube free-cube
    shows "$work/free-cube.csv" '|force|' 0 0.1
    shows "$work/free-cube.csv" turn_w 0.93 1 # by 43 degrees or more
    film free-cube free-cube --every 50 --size 480x360 --zoom 0.5 --azimuth -60 --elevation 18
}

# mirrored: a second finger, the first one's mirror image on a cube of 30 mm.
mirrored() { awk -F, 'NR == 1 { print "x,y,z,x2,y2,z2" } NR > 1 { printf "%s,%.6f,%s,%s\n", $0, 0.03 - $1, $2, $3 }'; }

# Two fingers on its sides: in, up, away.
figure_grasp_cube() {
    smooth_path <<PLACES | mirrored >"$work/grasp-cube.path.csv"
0 -8 15 20
600 2.5 15 20
900 2.5 15 20
2100 2.5 15 55
3000 2.5 15 55
3600 -10 15 55
4300 -10 15 55
PLACES
    felt grasp-cube grasp-cube
    shows "$work/grasp-cube.csv" body_z 0.016 0.04 # lifted by 24 mm, and dropped
    shows "$work/grasp-cube.csv" contact2 0 1
    film grasp-cube grasp-cube --every 50 --size 480x360 --zoom 0.45 --azimuth -60 --elevation 14
}

# A knock on a jelly's side, four times as slow: it rings.
figure_jelly() {
    smooth_path >"$work/jelly.path.csv" <<PLACES
0 -15 15 26
120 -2 15 26
200 6 15 26
260 6 15 26
290 -15 15 26
900 -15 15 26
PLACES
    felt jelly jelly
    shows "$work/jelly.csv" '|force|' 0 0.03
    awk -F, 'NR == 1 || $1 > 320' "$work/jelly.csv" >"$work/jelly.after.csv"
    shows "$work/jelly.after.csv" mode_1 -1e-9 1e-9 # to both sides
    film jelly jelly --every 12 --fps 20 --size 400x320 --zoom 0.75 --azimuth -75 --elevation 12
}

# Two fingers take hold of it, pull it aside and let go, four times as slow.
figure_jelly_two() {
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
    paste -d, "$work/first.path.csv" "$work/second.path.csv" | sed '1s/.*/x,y,z,x2,y2,z2/' >"$work/jelly-two.path.csv"
    felt jelly-two jelly-two
    shows "$work/jelly-two.csv" '|force|' 0 0.1
    shows "$work/jelly-two.csv" contact2 0 1
    awk -F, 'NR == 1 || $1 > 620' "$work/jelly-two.csv" >"$work/jelly-two.after.csv"
    shows "$work/jelly-two.after.csv" mode_1 -1e-9 1e-9
    film jelly-two jelly-two --every 12 --fps 20 --size 400x320 --zoom 0.75 --azimuth -75 --elevation 12
}

# shellcheck disable=SC2086 # lists
[ $# -gt 0 ] || set -- $drawings $views $pages $films
for figure in "$@"; do
    case " $drawings $views $pages $films " in
    *" $figure "*) "figure_$(echo "$figure" | tr - _)" ;;
    *) echo "figures.sh: no figure $figure: give any of $drawings $views $pages $films" >&2 && exit 1 ;;
    esac
done
