#!/bin/sh
# SPDX-License-Identifier: MIT
#
# stack.sh FOLDER MODEL: worst-case stack of haptable_step, bytes: the deepest path through the call graph that gcc
# wrote beside each object of the folder, for the functions that the scene in MODEL (an object) names, itself or through
# a struct of functions. CROSS is the prefix of the compiler's tools.
set -eu
folder=$1

# What each const struct of functions points to: "struct function", a static function by its file.
pointed=$(for object in "$folder"/*.o; do
    [ "$object" -ef "$2" ] || { "${CROSS}nm" "$object" && "${CROSS}objdump" -r "$object"; } |
        awk -v file="firmware/$(basename "$object" .o).c:" '
            NF == 3 && $2 == "t" { is_static[$3] = 1 }
            /^RELOCATION RECORDS/ { from = $4; sub(/^\[\.(s?rodata|data\.rel\.ro)\./, "", from); sub(/\]:$/, "", from); is_data = from !~ /^\[/ }
            is_data && $2 ~ /^R_/ { to = $3; sub(/[-+]0x.*/, "", to); sub(/^\.text\./, "", to); print from, (to in is_static ? file : "") to }'
done)
named=$("${CROSS}nm" "$2" | awk '$1 == "U" { print $2 }' | tr '\n' ' ')
for _ in 1 2; do
    named="$named $(echo "$pointed" | awk -v named="$named" '
        BEGIN { n = split(named, list, " "); for (i = 1; i <= n; ++i) is[list[i]] = 1 }
        is[$1] && !is[$2] { print $2 }' | sort -u | tr '\n' ' ')"
done

# A call through a pointer is one of the functions that are named, none of which is already on the path, and none of a
# rank above the caller's: what moves calls contacts, contacts call laws, laws unpack blocks. So what is deepest below a
# function depends on its level and on the named ones of ranks 4 and 5 on the path, and is found once for each. A
# god-object is called by steps, by friction and by what holds a contact; the surface, which all inline, calls hinges.
stack=$(cat "$folder"/*.ci | awk -v root=haptable_step -v named="$named" '
    function rank(name) {
        if (!(name in ranks)) ranks[name] = rank_of(name)
        return ranks[name]
    }
    function rank_of(name) {
        if (name ~ /^haptable_(init|check|scene)_/ || name ~ /_crc$/) return 0
        if (name == "haptable_moving" || name ~ /^haptable_step_/) return 1
        if (name ~ /^haptable_(contacts?|rows)_of_/ || name ~ /^haptable_(body|modes)_/) return 2
        if (name ~ /^haptable_(servo|pair)_step$/) return 3
        if (name ~ /^haptable_pair_/) return 5
        if (name ~ /^haptable_(force|energy|compliance)_/) return 7
        if (name ~ /^haptable_unpack_/) return 8
        if (name ~ /haptable_pair[a-z_]*\.c:/) return 6
        return 4
    }
    /^node:/ {
        split($0, part, "\""); name = part[2]
        if (match(part[4], /[0-9]+ bytes/)) bytes[name] = substr(part[4], RSTART, RLENGTH) + 0
        if (part[4] ~ /dynamic,|bounded/) unbounded = unbounded " " name
    }
    /^edge:/ { split($0, part, "\""); edges[part[2]] = edges[part[2]] " " part[4] }
    function deepest(names, level, is_direct, caller,   list, n, i, d, most) {
        n = split(names, list, " ")
        most = 0
        for (i = 1; i <= n; ++i) {
            if (!is_direct && list[i] ~ /^haptable_god_object_/ && caller !~ /step|friction|god_object|contacts?_of_|hold|held|moving/) continue
            if (!is_direct && (on_path[list[i]] || rank(list[i]) < level || (rank(list[i]) == level && level != 4 && level != 5))) continue
            d = list[i] == "__indirect_call" ? deepest(named, level, 0, caller) : depth(list[i], level)
            if (d > most) most = d
        }
        return most
    }
    function depth(name, level,   key) {
        if (on_path[name]) { print "recursion through " name > "/dev/stderr"; failed = 1; exit 1 }
        on_path[name] = 1
        if (name in bit) path[rank(name)] += bit[name]
        if ((is_named[name] || rank(name) == 3) && rank(name) > level) level = rank(name)
        key = name " " level " " (level <= 4 ? path[4] : 0) " " (level <= 5 ? path[5] : 0)
        if (!(key in below)) below[key] = deepest(edges[name], level, 1, name)
        if (name in bit) path[rank(name)] -= bit[name]
        on_path[name] = 0
        return below[key] + bytes[name]
    }
    END {
        if (failed) exit 1
        n = split(named, list, " ")
        for (i = 1; i <= n; ++i) {
            is_named[list[i]] = 1
            if (!(list[i] in bit) && rank(list[i]) ~ /^[45]$/) bit[list[i]] = 2 ^ count[rank(list[i])]++
        }
        print depth(root, 0)
    }')

[ "${stack:-0}" -gt 0 ] || {
    echo "stack.sh: no call graph beside the objects in $folder (a compiler cache leaves it out): build without one" >&2
    exit 1
}
echo "$stack"
