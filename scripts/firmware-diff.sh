#!/bin/sh
# SPDX-License-Identifier: MIT
#
# firmware-diff.sh THEN NOW: two size tables of size.sh as one, with what each row grew by. Rows that one of them lacks count 0.
set -eu
awk '
    match($0, /^  .*[^ ]  +[0-9]+( |$)/) {
        row = $0
        sub(/^ +/, "", row)
        name = row
        sub(/  +[0-9]+.*$/, "", name)
        value = substr(row, length(name) + 1) + 0
        if (!(name in seen)) { seen[name] = 1; order[++rows] = name }
        if (NR == FNR) before[name] = value; else after[name] = value
    }
    END {
        printf "%-44s %9s %9s %9s\n", "bytes", "then", "now", "change"
        for (i = 1; i <= rows; ++i) {
            name = order[i]
            change = after[name] - before[name]
            percent = before[name] > 0 && change != 0 ? sprintf("%+.1f %%", 100 * change / before[name]) : ""
            printf "%-44s %9d %9d %9s %s\n", name, before[name], after[name], change == 0 ? "" : sprintf("%+d", change), percent
        }
    }' "$1" "$2"
