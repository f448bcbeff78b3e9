#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Counts every contact mode on every target and puts the tables into docs/INSTRUCTIONS.md. Called by `make bench`.
set -eu
BUILD=${BUILD:-build}
table=$BUILD/modes/instructions.md
mkdir -p "$BUILD/modes"
"$BUILD/bin/haptable-bench-target" --build "$BUILD" -o "$table"
awk -v table="$table" '
    /<!-- modes -->/ { print; while ((getline line < table) > 0) print line; skip = 1; next }
    /<!-- end of modes -->/ { skip = 0 }
    !skip' docs/INSTRUCTIONS.md >"$BUILD/modes/page.md" && cp "$BUILD/modes/page.md" docs/INSTRUCTIONS.md
echo "bench: instructions by mode in docs/INSTRUCTIONS.md"
