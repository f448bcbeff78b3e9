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
# Bytes of code that the linker kept of an object, from its map: " .text.name" and on that line or the next "address size object".
bytes_of() {
    awk -v object="$1" '
        /^Linker script and memory map/ { kept = 1 }
        kept && /^ \.text/ { if (NF == 1) { getline; size = $2; from = $3 } else { size = $3; from = $4 } if (from == object) print size }' \
        "$folder/$2.map" | { sum=0; while read -r bytes; do sum=$((sum + bytes)); done; echo $sum; }
}
row() { printf '  %-42s %9s %s\n' "$1" "$2" "${3:-}"; }

# ---- what must not be there -----------------------------------------------------------------------------------------
bad=$(awk '{ print $NF }' "$symbols" | grep -E '^(__aeabi_[dfil]*2?[df][a-z0-9]*|__(add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord)[sdt]f[23]|__(fix|float|extend|trunc)[a-z]*[sdt]f.*|malloc|calloc|realloc|free|_?sbrk|printf)$' || true)
bad="$bad$("${CROSS}objdump" -d "$elf" | grep -oE '\.f64|\bf[a-z]+\.d\b' | sort -u || true)"
[ -z "$bad" ] || { echo "size.sh: $elf holds what the firmware must not use: $bad" >&2; exit 1; }

# ---- worst-case stack: the deepest way through the call graph that gcc wrote beside each object ----------------------
# A call through a pointer is one of the functions that the tables name, none of which is already on the way; out of a
# force or an energy it is one that unpacks blocks.
named=$("${CROSS}nm" "$folder/model.o" | awk '$1 == "U" { print $2 }' | tr '\n' ' ')
stack=$(cat "$folder"/*.ci | awk -v root=haptable_step -v named="$named" '
    function bare(title) { sub(/^.*:/, "", title); return title }
    /^node:/ {
        split($0, part, "\""); name = bare(part[2])
        if (match(part[4], /[0-9]+ bytes/)) bytes[name] = substr(part[4], RSTART, RLENGTH) + 0
        if (part[4] ~ /dynamic,|bounded/) unbounded = unbounded " " name
    }
    /^edge:/ { split($0, part, "\""); edges[bare(part[2])] = edges[bare(part[2])] " " bare(part[4]) }
    function reached_from(name,   list, n, i, names) {
        if (name !~ /^haptable_(force|energy)_/) return named
        n = split(named, list, " ")
        for (i = 1; i <= n; ++i) if (list[i] ~ /^haptable_unpack_/) names = names " " list[i]
        return names
    }
    function deepest(names, direct, caller,   list, n, i, d, most) {
        n = split(names, list, " ")
        most = 0
        for (i = 1; i <= n; ++i) {
            if (!direct && on_way[list[i]]) continue
            d = list[i] == "__indirect_call" ? deepest(reached_from(caller), 0) : depth(list[i])
            if (d > most) most = d
        }
        return most
    }
    function depth(name,   most) {
        if (on_way[name]) { print "recursion through " name > "/dev/stderr"; failed = 1; exit 1 }
        on_way[name] = 1
        most = deepest(edges[name], 1, name)
        on_way[name] = 0
        return most + bytes[name]
    }
    END { if (failed) exit 1; print depth(root) }')

[ "${stack:-0}" -gt 0 ] || {
    echo "size.sh: no call graph beside the objects in $folder (a compiler cache leaves it out): build without one" >&2
    exit 1
}

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
    code=$((code + bytes))
    row "  code of $(basename "$object" .o).c" "$bytes"
done
row "code of the servo" $code
for table in vertex_m stiffness_n_per_m packed packed_scale_n_per_m patch neighbour box vertex_compliance_m_per_n edge_compliance_m_per_n \
    patch_compliance_m_per_n patch_edge; do
    grep -q " $table\$" "$symbols" || continue
    row "table $table" "$(awk -v name=$table 'NF == 4 && $4 == name { print $2 }' "$symbols" | head -n 1 | { read -r b; printf '%d' "0x$b"; })"
done
row "whole image" "$flash" "of $flash_has: $((flash_has - flash)) spare"
echo "RAM, bytes"
row "the servo's state" "$(awk 'NF == 4 && $4 == "servo_state" { print "0x" $2 }' "$symbols" | xargs printf '%d')"
row "stack of haptable_step, worst case" "$stack" "by the call graph"
row "whole image with its stack" "$ram" "of $ram_has: $((ram_has - ram)) spare"
