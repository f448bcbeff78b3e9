# SPDX-License-Identifier: GPL-2.0-or-later
#
# What scripts that write folders share: `. scripts/own.sh`. The programs have the same rule (host/base/own_folder.hpp).

# own FOLDER HOLDS: makes the folder with its mark .haptable; ends the script where it holds files without that mark.
own() {
    mark=$1/.haptable
    if [ -f "$mark" ] && [ ! -L "$mark" ] && [ "$(head -n 1 "$mark")" = "haptable $2" ]; then return; fi
    if [ -e "$mark" ] || [ -L "$mark" ] || { [ -e "$1" ] && [ -n "$(ls -A "$1")" ]; }; then
        echo "$1: holds files that are not haptable's $2 (by its .haptable): move them away, or give another BUILD" >&2
        exit 1
    fi
    mkdir -p "$1"
    printf 'haptable %s\n.\n' "$2" >"$mark"
}
