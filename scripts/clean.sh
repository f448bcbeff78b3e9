#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# clean.sh BUILD: removes what make made, but not the tables of scenes, which may have taken days, nor the finished
# columns of a run that was cut short. Called by `make clean`.
set -eu
build=$1
[ -d "$build" ] || exit 0

# A folder that haptable-precompute wrote, or writes into; DIR.columns/ is what is done of a run.
is_scene() { [ -e "$1/summary.json" ] && [ -e "$1/node_id.npy" ]; }

kept=""
for path in "$build"/* "$build"/.[!.]*; do
    [ -e "$path" ] || continue
    if is_scene "$path"; then
        rm -rf "$path/firmware" "$path/servo" "$path"/*.o "$path"/*.c.d "$path/servo.d"
        kept="$kept $path"
    else
        case $path in
        *.columns) kept="$kept $path" ;;
        *) rm -rf "$path" ;;
        esac
    fi
done
if [ -n "$kept" ]; then
    echo "clean: kept the tables in$kept (make distclean removes them too)"
else
    rmdir "$build"
fi
