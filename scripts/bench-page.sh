#!/bin/sh
# SPDX-License-Identifier: MIT
#
# What a page holds, as numbers for docs/TOUCH.md: bench-page.sh TABLES OUT.json makes the page of that folder of tables
# and counts its bytes. Called by `make bench` from the project's root.
set -eu
BUILD=${BUILD:-build}
tables=$1 out=$2
page=$out.html

"$BUILD/bin/haptable-view" "$tables" --page "$page" --quiet
whole=$(wc -c <"$page")
# base64 makes 4 bytes of 3.
in_base64() { echo $((($1 + 2) / 3 * 4)); }
bytes_after() { sed -n "s/.*$1\([0-9][0-9]*\).*/\1/p" "$page" | head -n 1; }
servo=$(in_base64 "$(wc -c <"$BUILD/lib/page/servo.wasm")")
all=$(in_base64 "$(bytes_after 'id="scene">{"bytes":')")
columns=$(in_base64 "$(bytes_after '"tables":{"columns":{"bytes":')")
error=$(sed -n 's/.*"columns":{"columns":[^}]*"error":\([0-9.e-]*\).*/\1/p' "$page" | head -n 1)
modes=$(grep -o '"model [0-9]*":' "$page" | wc -l)
rm "$page"

megabytes() { awk -v bytes="$1" 'BEGIN { printf "{\"value\":%d,\"text\":\"%.2g MB\"}", bytes, bytes / 1e6 }'; }
row() { printf '   ["%s",%s]' "$1" "$2"; }
{
    printf '{\n "page": {\n  "command": "make bench",\n  "columns": ["", "of the mouse"],\n  "rows": [\n'
    row "the page itself and three.js" "$(megabytes $((whole - servo - all)))" && printf ',\n'
    row "the servo, all modes in one WebAssembly module" "$(megabytes "$servo")" && printf ',\n'
    row "tables of $modes modes, and the surface" "$(megabytes $((all - columns)))" && printf ',\n'
    row "columns" "$(megabytes "$columns")" && printf ',\n'
    row "its worst column is off by, of its size" \
        "$(awk -v error="$error" 'BEGIN { printf "{\"value\":%s,\"text\":\"%.1e\"}", error, error }')" && printf '\n  ]\n }\n}\n'
} >"$out.beside"
mv "$out.beside" "$out"
