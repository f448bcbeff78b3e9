#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# units.sh [--write] MOST PREFIX FILE.cpp...: prints the names of translation units PREFIX<room>.<number>.cpp, each of
# which includes files of one folder, as many as have MOST lines together, and writes them. So the compiler reads headers
# and makes templates once for all of them. What reads headers in another way (a macro for a keyword, the kernel's
# headers), and CGAL's, which take a minute, stand alone. A unit that is as it was keeps its time.
set -eu
write=
[ "$1" != --write ] || { write=yes && shift; }
most=$1 prefix=$2
shift 2
[ -z "$write" ] || mkdir -p "$(dirname "$prefix.")"
printf '%s\n' "$@" | LC_ALL=C sort | xargs -r wc -l | awk -v most="$most" -v prefix="$prefix" -v write="$write" '
    # A main is a program of its own, and clang-tidy reads several in one unit.
    function put(unit, file, is_main) {
        is_main = file ~ /\/main\.cpp$/
        unit = prefix unit ".cpp"
        if (is_main) text[unit] = text[unit] "#define main main_" ++mains "\n"
        text[unit] = text[unit] "#include \"" file "\"  // NOLINT(bugprone-suspicious-include)\n"
        if (is_main) text[unit] = text[unit] "#undef main\n"
    }
    $2 == "total" { next }
    {
        room = $2
        sub(/\/[^\/]*$/, "", room)
        gsub(/\//, "-", room)
        alone = 0
        while ((getline line < $2) > 0) alone += line ~ /^#define float |^#include <(asm|CGAL)\//
        close($2)
        if (alone) { put(room ".alone-" ++apart, $2); next }
        if (room != last || lines + $1 > most) { lines = 0; number = room == last ? number + 1 : 1 }
        last = room
        lines += $1
        put(room "." number, $2)
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
