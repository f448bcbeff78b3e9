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
draw() { sh scripts/plot.sh "$2" "$out/$1.svg" "data='$3'; ${4:-}"; }

# costs COLUMN: body, force, number of that column, error, name of every configuration that has one, by tabs.
costs() {
    awk -F'"' -v column="$1" '{ split($13, number, " ")
        name = $4; sub(/ (a side|nodes)$/, "", name); sub(/average-nodal-pressure/, "nodal pressure", $6)
        if ($6 != "linear" && $6 != "") name = name " " $6
        if (number[column] > 0) print $2 "\t" $8 "\t" number[column] "\t" number[1] "\t" name }'
}
# fronts: those of a body and force that no other beats in both. A name stays where it has room below the last one.
fronts() {
    sort -t "$(printf '\t')" -k1,1 -k2,2 -k3,3g -k4,4g | awk -F'\t' -v OFS='\t' '
        $1 $2 != group { group = $1 $2; least = 1e9; named = 0.7 }
        $4 < 0.98 * least { least = $4; if ($4 < 0.55 * named) named = $4; else $5 = ""; print }'
}

data_of speed
draw accuracy accuracy "$out/speed.dat"
data_of points
for axis in "time 3" "flash 4" "precompute 5"; do
    costs "${axis#* }" <"$out/points.dat" >"$out/costs.dat"
    fronts <"$out/costs.dat" >"$out/fronts.dat"
    draw "error-${axis% *}" error "$out/costs.dat" "fronts='$out/fronts.dat'; axis='${axis% *}'"
done
data_of large-strain-curve
draw large-strain large-strain "$out/large-strain-curve.dat"
for curve in line loop edge; do
    [ ! -e "$BUILD/contact/$curve.dat" ] || draw contact-$curve contact-$curve "$BUILD/contact/$curve.dat"
done
