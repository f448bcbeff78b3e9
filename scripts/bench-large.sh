#!/bin/sh
# SPDX-License-Identifier: MIT
#
# What large bodies take, on one machine and over ranks of MPI: bench-large.sh PART OUT.json, PART one of
#   large   haptable-precompute on one and two threads, and on bodies that take minutes (docs/PRECOMPUTE.md)
#   scan    how a surface with a scanner's noise is filled (docs/design/meshes.md)
#   masks   what a pressure mask adds, to 64,000 nodes (docs/design/masks.md)
#   truth, known, large-strain, elements, elsewhere   forces against what is known without us (docs/REFERENCES.md,
#           docs/design/small-strain.md, elements.md, locking.md, elsewhere.md)
#   scale   haptable-precompute-mpi on 1, 2 and 4 ranks of this machine (docs/SCALE.md)
# Called by `make bench-large` from the project's root, everything built.
set -eu
BUILD=${BUILD:-build}
part=$1 out=$2
folder=$BUILD/large
. scripts/own.sh
own "$folder" measurements

# cube NODES_A_SIDE COLUMNS: prints the scene file of a cube of 30 mm, its base held, touchable everywhere.
cube() {
    file=$folder/cube-$1-$2.toml
    printf 'name = "cube-%s"\n[mesh]\ngenerate = "cube"\nnodes_per_side = %s\nside = 0.03\n[material]\nyoung = 1e4\npoisson = 0.3\n[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n[tables]\ncolumns = "%s"\n' \
        "$1" "$1" "$2" >"$file"
    echo "$file"
}

# run NAME SCENE COMMAND...: runs it into a folder of that name, and adds both to $runs (a list of NAME=DIR, one a line).
runs=""
run() {
    name=$1 scene=$2 into=$folder/$(echo "$1" | tr ' ,:' '---')
    shift 2
    echo "bench: $name" >&2
    "$@" "$scene" -o "$into" --force --quiet
    runs="$runs$name=$into
"
}
one=$BUILD/bin/haptable-precompute
tell() { # TOPIC
    printf '%s' "$runs" | tr '\n' '\0' |
        xargs -0 "$BUILD/bin/haptable-bench-runs" --topic "$1" --command "make bench-large PART=$part" -o "$out"
}

case $part in
large)
    run "mouse" meshes/mouse.toml "$one"
    run "cube of 30 a side, one thread" "$(cube 30 surface)" "$one" --threads 1
    run "two threads" "$(cube 30 surface)" "$one" --threads 2
    run "columns in double" "$(cube 30 surface)" "$one" --threads 2 --column-tolerance 0
    run "cube of 63 a side, tolerance 1e-3" "$(cube 63 none)" "$one" --tolerance 1e-3
    if [ -f ../shared/meshes/pepper_big.vtu ]; then
        pepper=$folder/pepper.toml
        printf 'name = "pepper"\n[mesh]\nfile = "%s"\nscale = 0.001\n[material]\nyoung = 1e4\npoisson = 0.3\n[[fixed]]\nbox = [-1, -1, -1, 1, -0.02, 1]\n[tables]\ncolumns = "none"\n' \
            "$PWD/../shared/meshes/pepper_big.vtu" >"$pepper"
        run "pepper, tolerance 1e-3" "$pepper" "$one" --tolerance 1e-3
    fi
    tell precompute-runs
    ;;
scale)
    for side in 12 20 25 30; do
        columns=$([ $side -gt 20 ] && echo none || echo surface)
        run "cube of $side a side: one machine" "$(cube $side "$columns")" "$one" --threads 1 --column-tolerance 0
        for ranks in 1 2 4; do
            run "$side a side, ranks: $ranks" "$(cube $side "$columns")" \
                env OMPI_MCA_rmaps_base_oversubscribe=1 mpirun --allow-run-as-root --oversubscribe -n $ranks "$BUILD/bin/haptable-precompute-mpi"
        done
    done
    tell scale-runs
    ;;
scan)
    pepper=../shared/meshes/pepper_big.vtu
    [ ! -f "$pepper" ] || "$BUILD/bin/haptable-bench-scan" "$pepper" --build "$folder" -o "$out"
    ;;
masks)
    "$BUILD/bin/haptable-bench-inversion" --masks --sides 12,20,28,40 --scene meshes/mouse-mask.toml --build "$folder/masks" -o "$out"
    ;;
known) "$BUILD/bin/haptable-bench-error" --known-answers --build "$folder" -o "$out" ;;
truth | large-strain | elements | elsewhere) "$BUILD/bin/haptable-bench-error" "--$part" --build "$folder" -o "$out" ;;
*)
    echo "bench-large: no part $part; large, masks, scale, scan, truth, known, large-strain, elements or elsewhere" >&2
    exit 2
    ;;
esac
