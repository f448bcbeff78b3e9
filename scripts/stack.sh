#!/bin/sh
# SPDX-License-Identifier: MIT
#
# stack.sh FOLDER MODEL: worst-case stack of haptable_step, bytes: the deepest path through the call graph that gcc wrote
# beside each object of the folder, for the functions that the tables in MODEL (an object) name. CROSS is the prefix of
# the compiler's tools.
set -eu
folder=$1

# A call through a pointer is one of the functions that the tables name, none of which is already on the path; out of a
# force, an energy or a compliance it is one that unpacks blocks.
named=$("${CROSS}nm" "$2" | awk '$1 == "U" { print $2 }' | tr '\n' ' ')
stack=$(cat "$folder"/*.ci | awk -v root=haptable_step -v named="$named" '
    function bare(title) { sub(/^.*:/, "", title); return title }
    /^node:/ {
        split($0, part, "\""); name = bare(part[2])
        if (match(part[4], /[0-9]+ bytes/)) bytes[name] = substr(part[4], RSTART, RLENGTH) + 0
        if (part[4] ~ /dynamic,|bounded/) unbounded = unbounded " " name
    }
    /^edge:/ { split($0, part, "\""); edges[bare(part[2])] = edges[bare(part[2])] " " bare(part[4]) }
    function reached_from(name,   list, n, i, names) {
        if (name !~ /^haptable_(force|energy|compliance)_/) return named
        n = split(named, list, " ")
        for (i = 1; i <= n; ++i) if (list[i] ~ /^haptable_unpack_/) names = names " " list[i]
        return names
    }
    function deepest(names, direct, caller,   list, n, i, d, most) {
        n = split(names, list, " ")
        most = 0
        for (i = 1; i <= n; ++i) {
            if (!direct && on_path[list[i]]) continue
            d = list[i] == "__indirect_call" ? deepest(reached_from(caller), 0) : depth(list[i])
            if (d > most) most = d
        }
        return most
    }
    function depth(name,   most) {
        if (on_path[name]) { print "recursion through " name > "/dev/stderr"; failed = 1; exit 1 }
        on_path[name] = 1
        most = deepest(edges[name], 1, name)
        on_path[name] = 0
        return most + bytes[name]
    }
    END { if (failed) exit 1; print depth(root) }')

[ "${stack:-0}" -gt 0 ] || {
    echo "stack.sh: no call graph beside the objects in $folder (a compiler cache leaves it out): build without one" >&2
    exit 1
}
echo "$stack"
