#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Bytes of the servo on the microcontrollers, as numbers for docs/MICROCONTROLLER.md: bench-size.sh OUT.json. Called by
# `make bench` from the project's root, when the images are made.
set -eu
BUILD=${BUILD:-build}
targets="cortex-m4 cortex-m7 cortex-m33 rv32"
cross_of() { case $1 in rv32) echo riscv64-unknown-elf- ;; *) echo arm-none-eabi- ;; esac }

# A cell of bytes, with commas between thousands; a row of such cells.
cell() { printf '{"value":%d,"text":"%s"}' "$1" "$(echo "$1" | sed ':again; s/\([0-9]\)\([0-9]\{3\}\)\($\|,\)/\1,\2\3/; t again')"; }
row() {
    printf '   ["%s"' "$1"
    shift
    for bytes in "$@"; do printf ',' && cell "$bytes"; done
    printf ']'
}

# What `make firmware` prints of an image: size_of NAME TARGET ROW.
size_of() { awk -v row="$3" 'index($0, row) { sub(/^ *[^0-9]*/, ""); print $1 }' "$BUILD/$1/firmware/$2/size.txt"; }
sizes() { row "$1" "$(size_of cube cortex-m7 "$2")" "$(size_of mouse cortex-m7 "$2")"; }

# The stack of a mode on every target. Its tables name the functions; the call graphs are those of the cube's images,
# which hold every function before the linker drops what no table names.
stacks() { # WHAT FORCE GOD_OBJECT MORE...: lines of [contact]
    what=$1 folder=$BUILD/modes/stack
    mkdir -p "$folder"
    sed "s/^force = .*/force = \"$2\"/; s/^god_object = .*/god_object = \"$3\"/; s/^columns = .*/columns = \"none\"/" meshes/cube.toml |
        awk -v more="$4" '{ print } /^\[contact\]/ { print more }' >"$folder/stack.toml"
    "$BUILD/bin/haptable-precompute" "$folder/stack.toml" -o "$folder/tables" --quiet
    set -- "$what"
    for target in $targets; do
        cross=$(cross_of "$target")
        "${cross}gcc" -c -ffreestanding -Ifirmware "$folder/tables/model.c" -o "$folder/model.o"
        set -- "$@" "$(CROSS=$cross sh scripts/stack.sh "$BUILD/cube/firmware/$target" "$folder/model.o")"
    done
    row "$@"
}

mask='mask_radius = 0.012'
friction='friction = 0.5'
{
    printf '{\n "size": {\n  "command": "make bench",\n  "columns": ["-O2, Cortex-M7, bytes", "cube", "mouse"],\n  "rows": [\n'
    sizes "code of the servo" "code of the servo" && printf ',\n'
    sizes "state of the servo" "the servo's state" && printf '\n  ]\n },\n'
    printf ' "stack": {\n  "command": "make bench",\n  "columns": ["stack of a step, bytes"'
    for target in $targets; do printf ', "%s"' "$target"; done
    printf '],\n  "rows": [\n'
    stacks "the paper's mode" interpolated nearest "" && printf ',\n'
    stacks "mask, nearest" pressure-mask nearest "$mask" && printf ',\n'
    stacks "interpolated, least energy" interpolated least-energy "" && printf ',\n'
    stacks "consistent, least energy" consistent least-energy "" && printf ',\n'
    stacks "mask, least energy" pressure-mask least-energy "$mask" && printf ',\n'
    stacks "mask, least energy, friction" pressure-mask least-energy "$mask\n$friction" && printf '\n  ]\n }\n}\n'
} >"$1.beside"
mv "$1.beside" "$1"
