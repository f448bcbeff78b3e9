#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# validate.sh EXPORTS VENV: what the projects' own tools say of folders that haptable-codegen --export wrote:
# EXPORTS/arduino, platformio, esp-idf, zephyr. Tools of PyPI, installed into VENV.
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
# PlatformIO reads both manifests. Its list of licences is on the network: without that line.
for kind in arduino platformio; do
    cp -r "$exports/$kind" "$work/$kind"
    sed -i '/"license"/d' "$work/$kind"/library.*
    (cd "$work/$kind" && "$venv/bin/pio" pkg pack . -o "$work/$kind.tar.gz") >"$work/said" 2>&1 || { cat "$work/said" >&2; exit 1; }
    tar tzf "$work/$kind.tar.gz" | grep -qx 'src/model.c' || { echo "$kind: the package has no src/model.c" >&2; exit 1; }
done
cp -r "$exports/esp-idf" "$work/esp-idf"
(cd "$work/esp-idf" && "$venv/bin/compote" manifest lint && "$venv/bin/compote" component pack --name haptable) >"$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
printf 'config FPU\n\tbool\n\tdefault y\nsource "%s/zephyr/zephyr/Kconfig"\n' "$exports" >"$work/Kconfig"
"$venv/bin/python" - "$work/Kconfig" <<'END'
import sys
import kconfiglib
kconfig = kconfiglib.Kconfig(sys.argv[1])
name = next(s for s in kconfig.syms if s.startswith("HAPTABLE_"))
kconfig.syms[name].set_value(2)
sys.exit(bool(kconfig.warnings) or kconfig.syms[name].str_value != "y")
END
