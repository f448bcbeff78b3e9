#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# plot.sh NAME OUT [DEFINITIONS]: docs/figures/NAME.gp draws OUT, an SVG, by gnuplot; DEFINITIONS are what it is called
# with. It has the colours of host/view/colors.inc, as color_finger. A figure that does not show what it is about
# (docs/figures/must.gp) is an error, and leaves no file. Called from the project's root.
set -eu
colors=$(sed -n 's/^COLOR(\([a-z_]*\), \(0x[0-9a-f]*\),.*/color_\1=\2;/p' host/view/colors.inc | tr '\n' ' ')
trap 'rm -f "$2.new"' EXIT
gnuplot -e "$colors must=\"call 'docs/figures/must.gp'\"; name='$1'; out='$2.new'; ${3:-}" "docs/figures/$1.gp"
mv "$2.new" "$2"
