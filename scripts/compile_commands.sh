#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# compile_commands.json of make's own commands: `make -nB ... | compile_commands.sh`. One entry a source, the first.
# Called by `make compile_commands.json` from the project's root.
set -eu
in_json='s/\\/\\\\/g; s/"/\\"/g'
FOLDER=$(printf '%s\n' "$PWD" | sed "$in_json")
export FOLDER
sed -nE 's/^(ccache )?((g\+\+|gcc|c\+\+|cc|clang|clang\+\+) .* -c ([^ ]+\.(c|cpp)) -o [^ ]+)$/\4\t\2/p' | sed "$in_json" |
    awk -F'\t' '
        BEGIN { printf "[" }
        !seen[$1]++ {
            printf "%s\n {\"directory\": \"%s\", \"file\": \"%s\", \"command\": \"%s\"}", entries++ ? "," : "", ENVIRON["FOLDER"], $1, $2
        }
        END { print "\n]"; exit !entries }'
