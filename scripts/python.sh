#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# python.sh FOLDER: a Python environment with the packages that tests talk to: Haply's own client of its boards
# (HaplyHAPI), a WebSocket and an LCM that are not ours; and in FOLDER/wheels what tests install by themselves, for they
# run where there is no network: what our Python package needs, a notebook, the tools of board ecosystems.
set -eu
folder=$1
packages="HaplyHAPI==1.0.1 websockets==15.0.1 lcm==1.5.3 taplo==0.9.3"
wheels="setuptools>=68 wheel cffi>=1.16 numpy>=1.22 nbclient ipykernel platformio==6.2.0 idf-component-manager kconfiglib"

[ -x "$folder/bin/pip" ] || python3 -m venv "$folder"
{
    # shellcheck disable=SC2086 # lists of packages
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check $packages &&
        "$folder/bin/python" -m pip wheel --quiet --disable-pip-version-check --wheel-dir "$folder/wheels" $wheels
} || {
    echo "python: pip could not install $packages $wheels into $folder (does this machine reach pypi.org?)" >&2
    exit 1
}
