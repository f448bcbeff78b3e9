#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# The tests under each of OpenBLAS's kernels that this processor can run, with 1 and with 2 threads: another kernel adds
# in another order, and no bound may hold by luck. Fails where a test does, where an error comes nearer to its bound
# than a third (tests/tolerance.hpp), and where tables of ten scenes are not the same bytes under all kernels
# (docs/SPEC.md says how often rounding may part them).
# Called by `make test-kernels` from the project's root; arguments name kernels. ONLY=tables: no tests (make test-tables).
set -u

BUILD=${BUILD:-build}
folder=$BUILD/tests/kernels
# Not those that see no kernel: pictures, messages, readers, images, generated C, strokes on made-up blocks.
filter='-View*:*Loop*:*Target*:*Session*:Strokes.*:Fill*:*Mesh.*:*WholeMesh/*:Instructions*:Process.*'
filter="$filter:Codegen.TheText*:Modes.*:FirmwareReadme.*"

has() { for flag; do grep -m 1 '^flags' /proc/cpuinfo | grep -qw "$flag" || return 1; done; }
# OpenBLAS's kernels by the instructions that they take.
names="Nehalem Sandybridge Haswell Zen SkylakeX"
can_run() {
    case $1 in
    Nehalem) has sse4_2 ;;
    Sandybridge) has avx ;;
    Haswell | Zen) has avx2 fma ;;
    SkylakeX) has avx512f avx512dq avx512bw avx512vl ;;
    *) return 0 ;; # named by the caller
    esac
}
# The first $1 processors that this process may run on, as taskset takes them.
processors() { taskset -cp $$ | sed 's/.*: //' | tr , '\n' | awk -F- '{for (i = $1; i <= $NF; i++) print i}' | head -n "$1" | paste -sd,; }

scenes="cube cube-consistent cube-two jelly jelly-two grasp-cube mouse mouse-mask hard/torus laws/bar"

# choose KERNELS THREADS: what runs from here on.
choose() {
    if [ -n "$1" ]; then export OPENBLAS_CORETYPE="$1"; else unset OPENBLAS_CORETYPE; fi
    export OPENBLAS_NUM_THREADS="$2"
}

# "SCENE TABLES_HASH" of each scene, into $folder/NAME.tables.
tables() {
    choose "$1" "$2"
    for scene in $scenes; do
        made=$folder/scenes/${1:-chosen}-$2/$scene
        "$BUILD/bin/haptable-precompute" "meshes/$scene.toml" -o "$made" --threads "$2" --quiet >/dev/null 2>"$folder/said" ||
            { cat "$folder/said" >&2; echo "$scene none"; continue; }
        echo "$scene $(sed -n 's/.*"tables_hash": "\([0-9a-f]*\)".*/\1/p' "$made/summary.json")"
    done >"$folder/${1:-chosen}-$2.tables"
}

# The tests with kernels $1 (empty: those that a user's programs choose) and $2 threads; prints a line of the table.
run() {
    choose "$1" "$2"
    export HAPTABLE_MARGINS="$folder/${1:-chosen}-$2.margins"
    said=$(taskset -c "$(processors "$2")" sh scripts/test.sh --gtest_filter="$filter" | tail -n 1)
    mv "$BUILD/tests/log" "$folder/${1:-chosen}-$2.log"
    took=$(sed -n 's/^computes with //p' "$folder/${1:-chosen}-$2.log" | sort -u | paste -sd,)
    nearest=$(grep -v tolerance_test "$HAPTABLE_MARGINS" | sort -g | tail -n 1 | cut -d' ' -f1)
    printf '%-10s %-32s %7s  %-38s %s\n' "${1:-chosen}" "$took" "$2" "$said" "$nearest"
    [ "$said" != "${said#* 0 failed}" ] || failed=$((failed + 1))
}

rm -rf "$folder"
mkdir -p "$folder"
failed=0 runs=0
echo "left out: Prescott and older kernels: Prescott's strsm writes over its own stack, and their bits depend on where a"
echo "          matrix lies in memory. Programs take them only where a processor has no others (host/inverse/solve/blas_core.cpp)."
chosen=""
for kernels in ${*:-$names}; do
    if can_run "$kernels"; then chosen="$chosen $kernels"; else echo "left out: $kernels: this processor lacks its instructions"; fi
done
for kernels in "" $chosen; do
    for threads in 1 2; do
        tables "$kernels" "$threads"
    done
done
parted=$(cat "$folder"/*.tables | sort -u | cut -d' ' -f1 | uniq -d | paste -sd' ')
if [ -z "$parted" ] && ! grep -q none "$folder"/*.tables; then
    echo "tables: the same bytes of$(printf ' %s' $scenes) under$chosen, 1 and 2 threads"
else
    grep -E "$(echo "none|$parted" | sed 's/ /|/g; s/|$//')" "$folder"/*.tables
    failed=$((failed + 1))
fi
if [ "${ONLY:-}" != tables ]; then
    printf '%-10s %-32s %7s  %-38s %s\n' kernels took threads tests "largest error / bound"
    for kernels in "" $chosen; do
        for threads in 1 2; do
            run "$kernels" "$threads"
            runs=$((runs + 1))
        done
    done
    sh scripts/margins.sh "$folder"/*.margins || failed=$((failed + 1))
fi
echo "$runs runs, $failed failed; logs in $folder"
[ "$failed" -eq 0 ]
