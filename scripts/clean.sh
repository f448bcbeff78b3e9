#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# clean.sh BUILD [all]: removes what make made, but, without `all`, not the tables of scenes, which may have taken days,
# nor the finished columns of a run that was cut short. A folder that make did not set up is left alone. Called by
# `make clean` and `make distclean`.
set -eu
build=$1
[ -d "$build" ] || exit 0
[ -e "$build/setup.stamp" ] || {
    echo "clean: make did not set up $build (it has no setup.stamp): nothing in it is removed" >&2
    exit 1
}
[ "${2:-}" != all ] || exec rm -rf -- "$build"

# A folder that haptable-precompute wrote, or writes into.
is_scene() { [ -e "$1/node_id.npy" ] || [ -e "$1/columns.unfinished" ]; }

kept=""
for path in "$build"/* "$build"/.[!.]*; do
    [ -e "$path" ] || continue
    if is_scene "$path"; then
        rm -rf "$path/firmware" "$path/servo" "$path"/*.o "$path"/*.c.d "$path/servo.d"
        kept="$kept $path"
    elif [ "$path" != "$build/setup.stamp" ]; then
        rm -rf "$path"
    fi
done
if [ -n "$kept" ]; then
    echo "clean: kept the tables in$kept (make distclean removes them too)"
else
    rm -rf "$build"
fi
