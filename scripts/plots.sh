#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# The plots of what was measured: plots.sh NUMBERS OUT draws OUT/*.svg from NUMBERS (docs/numbers.json) and, where
# haptable-contact has left them, from its curves. Called from the project's root by `make report` and `make figures`.
set -eu
BUILD=${BUILD:-build}
numbers=$1
out=$2
. scripts/own.sh
plain "$BUILD" "$out"

data_of() { "$BUILD/bin/haptable-report" --numbers "$numbers" --plot "$1" >"$out/$1.dat"; }
# draw NAME SCRIPT DATA [DEFINITIONS]
draw() { gnuplot -e "out='$out/$1.svg'; data='$3'; ${4:-}" "docs/figures/$2.gp"; }

data_of speed
draw accuracy accuracy "$out/speed.dat"
data_of points
for axis in time flash precompute; do draw error-$axis error "$out/points.dat" "axis='$axis'"; done
data_of large-strain-curve
draw large-strain large-strain "$out/large-strain-curve.dat"
for curve in line loop edge; do
    [ ! -e "$BUILD/contact/$curve.dat" ] || draw contact-$curve contact-$curve "$BUILD/contact/$curve.dat"
done
