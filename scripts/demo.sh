#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# The demonstration: the paper's pictures, then the cube in a closed loop at 1 kHz over LCM, recorded and drawn.
# Called by `make demo` from the project's root when all is built. Results: $BUILD/demo/.
# `scripts/demo.sh --figures` is the first half alone.
set -eu

BUILD=${BUILD:-build}
demo=$BUILD/demo
. scripts/own.sh

# ---- the paper's figures: a scripted finger path through the servo, and its last tick drawn ------------------------

# straight X0 Y0 Z0 X1 Y1 Z1 N: a finger path of N ticks, in metres.
straight() {
    awk -v x0="$1" -v y0="$2" -v z0="$3" -v x1="$4" -v y1="$5" -v z1="$6" -v n="$7" 'BEGIN {
        print "x,y,z"
        for (i = 0; i < n; ++i) {
            s = i / (n - 1)
            printf "%.9g,%.9g,%.9g\n", x0 + s * (x1 - x0), y0 + s * (y1 - y0), z0 + s * (z1 - z0)
        }
    }'
}

# figure NAME SCENE X0 Y0 Z0 X1 Y1 Z1: presses the body of a scene along a straight path and draws the end of it.
figure() {
    name=$1 scene=$2
    shift 2
    straight "$@" 151 >"$demo/$name.path.csv"
    "$BUILD/$scene/servo" --quiet --replay "$demo/$name.path.csv" --out "$demo/$name.csv"
    "$BUILD/bin/haptable-view" "$BUILD/$scene" --quiet --csv "$demo/$name.csv" --ticks 150 -o "$demo/$name.png"
    echo "  $demo/$name.png"
}

figures() {
    echo "The paper's figures:"
    for scene in cube mouse; do
        "$BUILD/bin/haptable-view" "$BUILD/$scene" --quiet --mesh -o "$demo/$scene-mesh.png"
        echo "  $demo/$scene-mesh.png"
    done
    # Figure 1 b and c: 5 mm down in the middle of the top; 5 mm along x in a side face, a node above its middle.
    figure cube-uz cube 0.015 0.015 0.040 0.015 0.015 0.025
    figure cube-ux cube -0.010 0.015 0.0225 0.005 0.015 0.0225
    # Figure 2: the mouse, 5 mm down at the highest node of its back.
    figure mouse-uz mouse -0.01504909 0.00151810 0.0475 -0.01504909 0.00151810 0.0325
}

# ---- the loop: servo, device and logger as processes over LCM, in real time ----------------------------------------

# 1/100 s that all processors together waited while another virtual machine had theirs.
stolen() { awk '/^cpu / { print $9 }' /proc/stat; }

# value KEY FILE: a number of a program's --json summary.
value() { sed -n "s/^ *\"$1\": \([^,]*\),*\$/\1/p" "$2"; }

# why_late TICKS MISSED STOLEN: where more than one tick in a hundred was missed, what this machine has to do with it.
why_late() {
    [ $((100 * $2)) -gt "$1" ] || return 0
    echo "  this machine was late: a missed tick is one whose force came after its millisecond, and acted on the next."
    [ "$3" -le 10 ] || printf '    another virtual machine had its processors for %d.%02d s meanwhile\n' $(($3 / 100)) $(($3 % 100))
    chrt -f 49 true 2>/dev/null || echo "    real-time priority is for root: servo and device had to wait for what else runs here"
    echo "    sh scripts/demo.sh runs it again, without building"
}

loop() {
    stolen_before=$(stolen)
    sh scripts/loopback.sh "$BUILD/bin/haptable-run" meshes/cube.toml --path poke,drag,circle -o "$demo/cube-loop" ||
        return $?
    device=$demo/cube-loop/device.json
    why_late "$(value ticks "$device")" "$(value missed "$device")" $(($(stolen) - stolen_before))
}

# --------------------------------------------------------------------------------------------------------------------

own "$demo" demo
figures
[ "${1:-}" != --figures ] || exit 0
echo "The cube at 1 kHz over LCM (poke, drag, circle), then a picture of every 0.1 s:"
status=0
loop || status=$?
if [ "$status" -eq 77 ]; then
    echo "The closed loop was left out: LCM cannot work on this machine (see the line above)."
elif [ "$status" -ne 0 ]; then
    exit "$status"
fi
