#!/bin/sh
# SPDX-License-Identifier: MIT
#
# size.sh FOLDER IMAGE: where an image's flash, RAM and stack go, and what it must not hold. CROSS is the prefix of the
# compiler's tools. Exit status 1 when a check fails.
set -eu
folder=$1
image=$2
elf=$folder/$image.elf
symbols=$(mktemp)
trap 'rm -f "$symbols"' EXIT
"${CROSS}nm" -S "$elf" >"$symbols"
value() { printf '%d' "0x$(awk -v name="$1" '$NF == name { print $1 }' "$symbols")"; }
# Bytes of code and constants that the linker kept of an object, from its map: " .text.name" and on that line or the
# next "address size object". With -Os what several files call is weak, and the first of them has it: a row of its own.
bytes_of() {
    awk -v object="$1" '
        FNR == NR { if ($3 == "W") shared[".text." $4] = 1; next }
        /^Linker script and memory map/ { kept = 1 }
        kept && /^ \.(text|rodata)/ {
            name = $1
            if (NF == 1) { getline; size = $2; from = $3 } else { size = $3; from = $4 }
            if (from == object && !(name in shared)) print size
        }' "$symbols" "$folder/$2.map" | sum
}
sum() { total=0; while read -r bytes; do total=$((total + bytes)); done; echo $total; }
# What a file is for: the line at its head.
purpose() { sed -n '3s/^ \* //p' "firmware/$1" 2>/dev/null; }
row() { printf '  %-42s %9s %s\n' "$1" "$2" "${3:-}"; }

# ---- what must not be there -----------------------------------------------------------------------------------------
bad=$(awk '{ print $NF }' "$symbols" | grep -E '^(__aeabi_[dfil]*2?[df][a-z0-9]*|__(add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord)[sdt]f[23]|__(fix|float|extend|trunc)[a-z]*[sdt]f.*|malloc|calloc|realloc|free|_?sbrk|printf)$' || true)
bad="$bad$("${CROSS}objdump" -d "$elf" | grep -oE '\.f64|\bf[a-z]+\.d\b' | sort -u || true)"
[ -z "$bad" ] || { echo "size.sh: $elf holds what the firmware must not use: $bad" >&2; exit 1; }
# Names that could meet a user's: all but ours, what gcc calls (haptable_memory.c, libgcc) and gp's address.
short=$("${CROSS}nm" -g "$elf" | awk '{ print $NF }' | grep -vE '^(haptable_|HAPTABLE_|mem(cpy|move|set|cmp)$|__)' || true)
[ -z "$short" ] || { echo "size.sh: $elf exports names that do not begin with haptable_: $short" >&2; exit 1; }

stacks=$(python3 "$(dirname "$0")/stack.py" "$folder" "$folder/model.o")
flash=$("${CROSS}size" -A "$elf" | awk '$1 == ".text" || $1 == ".data" { sum += $2 } END { print sum }')
ram=$("${CROSS}size" -A "$elf" | awk '$1 == ".data" || $1 == ".bss" || $1 == ".stack" { sum += $2 } END { print sum }')
flash_has=$(value haptable_port_flash_bytes)
ram_has=$(value haptable_port_ram_bytes)
code=0
echo "$elf"
echo "flash, bytes"
for object in "$folder"/*.o; do
    [ "$object" != "$folder/model.o" ] || continue
    bytes=$(bytes_of "$object" "$image")
    [ "$bytes" != 0 ] || continue
    code=$((code + bytes))
    file=$(basename "$object" .o).c
    row "  code of $file" "$bytes" "$(purpose "$file")"
done
shared=$(awk '$3 == "W" { print "0x" $2 }' "$symbols" | sum)
[ "$shared" = 0 ] || row "  code that files share" "$shared" "small functions of headers, once each"
code=$((code + shared))
row "code of the servo" $code
# The tables are the arrays that model.c keeps to itself.
"${CROSS}nm" -S --no-sort "$folder/model.o" | awk 'NF == 4 && $3 == "r" && $4 != "compliance" { print $4, "0x" $2 }' |
    while read -r table bytes; do row "table $table" "$((bytes))"; done
row "whole image" "$flash" "of $flash_has: $((flash_has - flash)) spare"
echo "RAM, bytes"
row "the servo's state" "$(awk 'NF == 4 && $4 == "scene_state" { print "0x" $2 }' "$symbols" | xargs printf '%d')"
echo "$stacks" | while read -r entry bytes; do row "stack of $entry" "$bytes" "at the most, by the call graph"; done
row "whole image with its stack" "$ram" "of $ram_has: $((ram_has - ram)) spare"
