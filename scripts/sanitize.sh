#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# sanitize.sh FOLDER...: haptable-precompute, built with Address- and UndefinedBehaviorSanitizer, judges every mesh in the
# folders: whatever it says about one, no sanitizer may say anything. Called by `make sanitize`.
set -u
program=${BUILD:-build}/sanitize/bin/haptable-precompute
scene=$(mktemp -d)
trap 'rm -rf "$scene"' EXIT
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1
count=0
failed=0
for folder in "$@"; do
    for mesh in "$folder"/*.*; do
        case $mesh in *.md | *.fixed) continue ;; esac
        case $mesh in *surf_*) fill="node_count = 1000" ;; *) fill="linearize = true" ;; esac
        printf 'name = "a"\n[mesh]\nfile = "%s"\nscale = 0.001\n%s\n[material]\nyoung = 1e4\npoisson = 0.3\n[[fixed]]\nbox = [-1e9, -1e9, -1e9, 1e9, 1e9, 1e9]\n' \
            "$(realpath "$mesh")" "$fill" >"$scene/a.toml"
        timeout 300 "$program" "$scene/a.toml" --check >"$scene/said" 2>&1
        status=$?
        count=$((count + 1))
        if [ $status -gt 1 ] || grep -qE 'AddressSanitizer|runtime error' "$scene/said"; then
            echo "sanitize: $mesh: status $status" && grep -E 'AddressSanitizer|runtime error|SUMMARY' "$scene/said" | head -n 3
            failed=$((failed + 1))
        fi
    done
done
echo "sanitize: $count meshes, $failed with findings"
[ $failed = 0 ]
