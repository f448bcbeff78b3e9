#!/bin/sh
# SPDX-License-Identifier: MIT
#
# rooms.sh: the lines of each room of firmware/rooms.txt; exit status 1 where an arrow between two files goes up or in a
# circle, where a file is in no room, or where a header's function does more than one statement for another room.
# FIRMWARE is another folder to look at.
set -eu
firmware=${FIRMWARE:-firmware}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
firmware=$(cd "$firmware" && pwd)

# ---- module, room, its place in the order, * ------------------------------------------------------------------------
awk '/^$/ { below = 1 } below && NF {
    star = $2 == "*"
    if (!($1 in order)) order[$1] = ++rooms
    for (i = 2 + star; i <= NF; ++i) print $i, $1, order[$1], star ? "*" : "-"
}' "$firmware/rooms.txt" >"$work/rooms"

# ---- arrows: "from to how" -------------------------------------------------------------------------------------------
# Of a file's name, its module.
module='function module(file) { sub(/.*\//, "", file); sub(/\.[cho]$/, "", file); sub(/^haptable_/, "", file); return file }'
awk -v work="$work" "$module"'
    FNR == NR { is_in[$1] = 1; next }
    FNR == 1 { name = module(FILENAME); if (!(name in is_in)) print FILENAME " is in no room of rooms.txt" }
    { ++lines[name] }
    /^#include "haptable[a-z0-9_]*\.h"/ { split($0, quoted, "\""); to = module(quoted[2]); if (to != name) print name, to, "includes" >(work "/arrows") }
    END { for (name in lines) print name, lines[name] >(work "/lines") }' "$work/rooms" "$firmware"/*.[ch] >"$work/faults"
(cd "$work" && gcc -std=c99 -ffreestanding -O0 -w -I"$firmware" -c "$firmware"/*.c && nm -gA ./*.o) | awk "$module"'
    { sub(/:/, " ") }
    $2 == "U" { ++calls; caller[calls] = module($1); callee[calls] = $3; next }
    { at[$4] = module($1) }
    END { for (i = 1; i <= calls; ++i) if (callee[i] in at) print caller[i], at[callee[i]], "calls " callee[i] " of" }' >>"$work/arrows"
awk 'NR == FNR { room[$1] = $2; order[$1] = $3; next }
    order[$2] > order[$1] { how = $3 " " $4 " " $5; sub(/ +$/, "", how); print $1 " (" room[$1] ") " how " " $2 ", which is above it (" room[$2] ")" }' \
    "$work/rooms" "$work/arrows" | sort -u >>"$work/faults"
awk '{ print $1, $2 }' "$work/arrows" | sort -u >"$work/edges"
tsort "$work/edges" >/dev/null 2>"$work/circle" || echo "a circle of files: $(sed -n 's/^tsort: \([a-z0-9_]*\)$/\1/p' "$work/circle" | tr '\n' ' ')" >>"$work/faults"

# ---- functions of headers: "name module statements" ------------------------------------------------------------------
awk 'function close_function() { if (name != "" && statements > 1) print name, file; name = "" }
    FNR == 1 { file = FILENAME; sub(/.*\//, "", file); sub(/\.h$/, "", file); sub(/^haptable_/, "", file) }
    /^static / && /\(/ { name = $0; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name); statements = 0 }
    name != "" { line = $0; sub(/\/\*.*/, "", line); statements += gsub(/;/, "", line) }
    /^}/ || /^static .*}$/ { close_function() }' "$firmware"/*.h >"$work/inline"
while read -r name from; do
    grep -q "^$from .* \*$" "$work/rooms" && continue
    grep -lE "(^|[^A-Za-z0-9_])$name\(" "$firmware"/*.[ch] | while read -r file; do
        grep -qE "^static .*[ *]$name\(" "$file" || echo "$name $from $file" # or it is one of its own
    done
done <"$work/inline" |
    awk "$module"'NR == FNR { room[$1] = $2; next }
        { $3 = module($3) }
        room[$2] != room[$3] { print $3 " (" room[$3] ") calls " $1 "() of a header of " room[$2] ": move it into a .c file" }' \
        "$work/rooms" - >>"$work/faults"

awk 'NR == FNR { lines[$1] += $2; next }
    !($2 in of) { name[++rooms] = $2 } { of[$2] += lines[$1]; ++modules[$2]; all += lines[$1] }
    END { for (i = 1; i <= rooms; ++i) printf "%-9s %5d lines, %2d modules\n", name[i], of[name[i]], modules[name[i]]; printf "%-9s %5d lines\n", "all", all }' \
    "$work/lines" "$work/rooms"
[ ! -s "$work/faults" ] || { cat "$work/faults" >&2; exit 1; }
