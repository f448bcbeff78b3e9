#!/bin/sh
# Installs the Debian packages that are missing, and says which. Exit status 0: all are there.
# `setup.sh cross`: what images for microcontrollers need besides, compilers and emulators.
# `setup.sh mpi`: what precompute over several machines needs besides.
set -eu

packages="
g++ make pkg-config git
libeigen3-dev libsuitesparse-dev libopenblas-dev libxxhash-dev
libgmsh-dev libcgal-dev libpugixml-dev
liblcm-dev liblcm-bin iproute2
libosmesa6-dev libcairo2-dev libpng-dev zlib1g-dev fonts-dejavu-core
libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libfmt-dev
libgtest-dev libbenchmark-dev
gnuplot-nox
clang clang-format clang-tidy libclang-rt-14-dev cppcheck
"
[ "${1:-}" != cross ] || packages="
gcc-arm-none-eabi gcc-riscv64-unknown-elf
qemu-system-arm qemu-system-misc
"
[ "${1:-}" != mpi ] || packages="
libopenmpi-dev openmpi-bin libmumps-dev
"

missing=""
for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

echo "setup: installing$missing"
if [ "$(id -u)" = 0 ]; then
    sudo=""
elif command -v sudo >/dev/null 2>&1; then
    sudo="sudo"
else
    echo "setup: you are not root and there is no sudo. As root, run: apt-get install --no-install-recommends$missing" >&2
    exit 1
fi
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086 # a list of packages is meant to be split
$sudo apt-get update -qq &&
    $sudo apt-get install -y -qq --no-install-recommends $missing >/dev/null || {
    echo "setup: apt-get could not install:$missing (is this Debian 12, and does it reach a mirror?)" >&2
    exit 1
}
