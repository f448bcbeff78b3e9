#!/bin/sh
# setup.sh [SET...]: installs the Debian packages of the sets (default: demo) that are missing, and says which.
# setup.sh --list SET...: prints the packages of the sets, and installs nothing.
# Exit status 0: all are there. One at a time: two makes, or two jobs of one, may ask at once.
set -eu
lists=""
[ "${1:-}" != --list ] || { lists=yes && shift; }

# What a set needs besides demo.
packages_of() {
    case $1 in
    demo) # haptable-precompute, -device, -view and the servo of a scene
        echo g++ make iproute2 \
            libeigen3-dev libsuitesparse-dev libarpack2-dev libopenblas-dev libxxhash-dev libgmsh-dev libpugixml-dev \
            liblcm-dev liblcm-bin libwebsockets-dev libosmesa6-dev libcairo2-dev libpng-dev zlib1g-dev fonts-dejavu-core gnuplot-nox \
            libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libfmt-dev ;;
    surface) echo libcgal-dev ;; # closed surfaces
    touch) echo clang lld libjs-three ;; # the page: the servo as WebAssembly, and what draws
    test) echo libgtest-dev python3-pytest python3-numpy python3-venv python3-cffi python3-jsonschema clang libclang-rt-14-dev lld libjs-three chromium ffmpeg locales ;;
    lint) echo git python3 clang-format clang-tidy cppcheck universal-ctags ;;
    bench) echo libbenchmark-dev ;;
    lab) echo calculix-ccx cmark-gfm python3-numpy python3-scipy python3-pandas python3-matplotlib python3-meshio python3-tomli-w python3-cffi python3-pytest python3-venv ;; # lab/: pages and figures
    figures) echo ffmpeg chromium ;;
    cross) echo python3 gcc-arm-none-eabi gcc-riscv64-unknown-elf qemu-system-arm qemu-system-misc llvm ;; # microcontrollers
    bare) echo mmdebstrap ;; # a Debian of its own, where nobody has been
    package) echo help2man lintian mmdebstrap dpkg-dev cmake pkgconf python3-dev python3-venv ;; # make install, deb, wheel
    mpi) echo libopenmpi-dev openmpi-bin libmumps-dev ;; # several machines
    *) echo "setup: no set $1" >&2 && exit 2 ;;
    esac
}

packages=""
for set in "${@:-demo}"; do packages="$packages $(packages_of "$set")"; done
[ -z "$lists" ] || { echo "$packages" && exit 0; }

exec 9<"$0"
flock 9
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
# The next set a minute later does without another update.
has_new_lists() {
    [ -n "$(find /var/lib/apt/lists -maxdepth 0 -mmin -60)" ] && ls /var/lib/apt/lists/*Packages* >/dev/null 2>&1
}
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086 # a list of packages is meant to be split
{ has_new_lists || $sudo apt-get update -qq; } &&
    $sudo apt-get install -y -qq --no-install-recommends $missing >/dev/null || {
    echo "setup: apt-get could not install:$missing (is this Debian 12, and does it reach a mirror?)" >&2
    exit 1
}
