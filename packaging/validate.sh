#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# validate.sh EXPORTS VENV: what the projects' own tools say of folders that haptable-codegen --export wrote
# (EXPORTS/arduino, platformio, esp-idf, zephyr), and of the firmware of this project, from whose root it is called.
# Tools of PyPI, installed into VENV.
set -eu
exports=$1
mkdir -p "$2"
venv=$(cd "$2" && pwd)
packages="platformio==6.2.0 idf-component-manager kconfiglib"
[ -x "$venv/bin/pip" ] || python3 -m venv "$venv"
# shellcheck disable=SC2086 # a list of packages
"$venv/bin/pip" install --quiet --disable-pip-version-check $packages
export PLATFORMIO_CORE_DIR="$venv/platformio" PLATFORMIO_SETTING_ENABLE_TELEMETRY=no

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
said() { cat "$work/said" >&2 && exit 1; }

# packed FOLDER FILE: the package that PlatformIO makes of a copy has that file. Its list of licences is on the network:
# without that line.
packed() {
    sed -i '/"license"/d' "$1"/library.*
    (cd "$1" && "$venv/bin/pio" pkg pack . -o "$1.tar.gz") >"$work/said" 2>&1 || said
    tar tzf "$1.tar.gz" | grep -qx "$2" || { echo "$1: the package has no $2" >&2; exit 1; }
}
# PlatformIO reads both manifests, its own where both are there.
for kind in arduino platformio; do
    cp -r "$exports/$kind" "$work/$kind"
    packed "$work/$kind" src/model.c
    cp -r firmware "$work/firmware-$kind"
done
rm "$work/firmware-arduino/library.json"
mkdir "$work/whole" && cp -r library.json LICENSE firmware "$work/whole/"
packed "$work/firmware-arduino" haptable_servo.c
packed "$work/firmware-platformio" haptable_servo.c
packed "$work/whole" firmware/haptable_servo.c

# component FOLDER: as Espressif's component manager takes it.
component() { (cd "$1" && "$venv/bin/compote" manifest lint && "$venv/bin/compote" component pack --name haptable) >"$work/said" 2>&1 || said; }
cp -r "$exports/esp-idf" "$work/esp-idf" && component "$work/esp-idf"
cp -r firmware "$work/firmware-esp-idf" && component "$work/firmware-esp-idf"

# switches KCONFIG: a symbol that begins with HAPTABLE can be switched on.
switches() {
    printf 'config FPU\n\tbool\n\tdefault y\nsource "%s"\n' "$1" >"$work/Kconfig"
    "$venv/bin/python" - "$work/Kconfig" <<'END'
import sys
import kconfiglib
kconfig = kconfiglib.Kconfig(sys.argv[1])
name = next(s for s in kconfig.syms if s.startswith("HAPTABLE"))
kconfig.syms[name].set_value(2)
sys.exit(bool(kconfig.warnings) or kconfig.syms[name].str_value != "y")
END
}
switches "$exports/zephyr/zephyr/Kconfig"
switches "$PWD/firmware/zephyr/Kconfig"
