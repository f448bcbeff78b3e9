#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# purpose.sh PROGRAM: the first sentence of its --help, as a manual's title has it: a small letter first, no stop.
set -eu
"$1" --help | sed -n '1{s/[.:;].*//;s/^\(.\)/\L\1/;p;}'
