#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# uninstall.sh DESTDIR PREFIX: removes the files that `make install` listed, and the folders that this leaves empty.
set -eu
destdir=$1 prefix=$2
list=$destdir$prefix/share/haptable/installed.txt
[ -r "$list" ] || {
    echo "uninstall: there is no $list: is haptable installed with another PREFIX?" >&2
    exit 1
}
files=$(mktemp)
trap 'rm -f "$files"' EXIT
cp "$list" "$files"
while read -r file; do rm -f "$destdir$file"; done <"$files"
# The deepest first; what holds other files stays.
while read -r file; do
    folder=$(dirname "$file")
    while [ "$folder" != / ] && [ "$folder" != "$prefix" ]; do
        echo "$folder"
        folder=$(dirname "$folder")
    done
done <"$files" | sort -ur | while read -r folder; do rmdir "$destdir$folder" 2>/dev/null || true; done
echo "haptable is no longer in $destdir$prefix"
