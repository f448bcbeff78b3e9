#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# python.sh FOLDER: a Python environment with the packages that tests talk to: Haply's own client of its boards
# (HaplyHAPI), a WebSocket and an LCM that are not ours.
set -eu
folder=$1
packages="HaplyHAPI==1.0.1 websockets==15.0.1 lcm==1.5.3"

[ -x "$folder/bin/pip" ] || python3 -m venv "$folder"
# shellcheck disable=SC2086 # a list of packages
"$folder/bin/pip" install --quiet --disable-pip-version-check $packages || {
    echo "python: pip could not install $packages into $folder (does this machine reach pypi.org?)" >&2
    exit 1
}
