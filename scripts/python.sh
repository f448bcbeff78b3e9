#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# python.sh FOLDER: a Python environment with the packages that tests talk to: Haply's own client of its boards
# (HaplyHAPI), a WebSocket and an LCM that are not ours. python.sh FOLDER/wheels: wheels that tests of packages install
# by themselves, for they run where there is no network: what our Python package needs, a notebook, the tools of board
# ecosystems.
set -eu
folder=$1
case $folder in
*/wheels)
    folder=${folder%/wheels}
    packages="setuptools>=68 wheel cffi>=1.16 numpy>=1.22 nbclient ipykernel platformio==6.2.0 idf-component-manager kconfiglib"
    brings="wheel --wheel-dir $folder/wheels" ;;
*)
    packages="HaplyHAPI==1.0.1 websockets==15.0.1 lcm==1.5.3 taplo==0.9.3"
    brings=install ;;
esac

[ -x "$folder/bin/pip" ] || python3 -m venv "$folder"
# shellcheck disable=SC2086 # lists of packages and words
"$folder/bin/python" -m pip $brings --quiet --disable-pip-version-check $packages || {
    echo "python: pip could not bring $packages to $1 (does this machine reach pypi.org?)" >&2
    exit 1
}
