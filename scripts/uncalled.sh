#!/bin/sh
# SPDX-License-Identifier: MIT
#
# uncalled.sh: functions of firmware/ that nobody calls, one a line; exit status 1 where there are any. Functions of a
# header, and static ones: the linker drops them from every object that has them, all others being kept. Those with a
# name for others: no object of the servo's has it. Neither has a file of the images, the host or the tests.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for file in firmware/*.c; do
    gcc -std=c99 -ffreestanding -fPIC -O0 -fkeep-inline-functions -ffunction-sections -w -Ifirmware -c "$file" \
        -o "$work/$(basename "$file" .c).o"
done
gcc -shared -nostdlib -Wl,--gc-sections,--print-gc-sections -o "$work/all.so" "$work"/*.o 2>"$work/dropped"
for object in "$work"/*.o; do nm "$object" | awk '$2 ~ /[tT]/ { print $3 }'; done | sort | uniq -c >"$work/made"
{
    sed -n "s/.*'\.text\.\([A-Za-z0-9_]*\)' in file .*/\1/p" "$work/dropped" | sort | uniq -c |
        awk 'NR == FNR { made[$2] = $1; next } made[$2] == $1 { print $2 }' "$work/made" -
    nm --defined-only -g "$work/all.so" | awk '$2 == "T" { print $3 }' | sort >"$work/named"
    objdump -r "$work"/*.o | awk '$2 ~ /^R_/ { sub(/[-+]0x.*/, "", $3); print $3 }' | sort -u >"$work/called"
    comm -23 "$work/named" "$work/called"
} | sort -u | while read -r name; do
    grep -rqw "$name" firmware/port codegen host tests || echo "$name"
done >"$work/uncalled"
cat "$work/uncalled"
[ ! -s "$work/uncalled" ]
