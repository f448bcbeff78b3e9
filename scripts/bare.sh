#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# bare.sh CMD...: runs a command in a clone of this project's HEAD in a Debian 12 that has what debootstrap puts there,
# git and make, and nothing else; prints its time. Needs mmdebstrap, root (or a user's namespaces) and a mirror. Leaves
# nothing.
set -eu
[ $# -gt 0 ] || { echo "bare.sh: say which command to run: bare.sh CMD..." >&2; exit 2; }
[ "$(id -u)" = 0 ] && mode=root || mode=unshare
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
git clone --quiet --no-local . "$work/haptable"
cat >"$work/inside" <<END
unset MAKEFLAGS MAKELEVEL MFLAGS
cd /haptable
TIMEFORMAT='bare: %R s, of which the processors worked %U s and the kernel %S s'
time $*
END
WORK=$work
export WORK
# The hooks are commands of the shell, with the root as $1.
mmdebstrap --quiet --mode=$mode --variant=important --include=git,make --format=null bookworm \
    --customize-hook='cp -r "$WORK/haptable" "$WORK/inside" "$1/"' \
    --customize-hook='chroot "$1" bash /inside'
