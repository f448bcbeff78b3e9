#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# units.sh [--write] FOLDER FILE.cpp...: prints the names of translation units FOLDER/*.cpp, each of which includes files
# of one folder, as many as have 1400 lines together, and writes them. So the compiler reads headers and makes templates
# once for all of them. What reads headers in another way ("#define float double") stands alone. A unit that is as it was
# keeps its time. Called by make for the tests, from the project's root.
set -eu
write=
[ "$1" != --write ] || { write=yes && shift; }
to=$1
shift
[ -z "$write" ] || mkdir -p "$to"
printf '%s\n' "$@" | LC_ALL=C sort | xargs -r wc -l | awk -v most=1400 -v to="$to" -v write="$write" '
    function put(unit, file) { text[to "/" unit ".cpp"] = text[to "/" unit ".cpp"] "#include \"" file "\"\n" }
    $2 == "total" { next }
    {
        room = $2
        sub(/\/[^\/]*$/, "", room)
        gsub(/\//, "-", room)
        alone = 0
        while ((getline line < $2) > 0) alone += line ~ /^#define float /
        close($2)
        if (alone) { put(room "-alone-" ++apart, $2); next }
        if (room != last || lines + $1 > most) { lines = 0; number = room == last ? number + 1 : 1 }
        last = room
        lines += $1
        put(room "-" number, $2)
    }
    END {
        for (unit in text) {
            print unit
            if (!write) continue
            kept = ""
            while ((getline line < unit) > 0) kept = kept line "\n"
            close(unit)
            if (kept != text[unit]) printf "%s", text[unit] > unit
        }
    }' | LC_ALL=C sort
