#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# bare.sh CMD: runs a shell's command in a clone of this project's HEAD in a Debian 12 that has what debootstrap puts
# there, git and make, and nothing else, with ../shared beside it where it is; prints its time. Needs mmdebstrap, root (or
# a user's namespaces) and a mirror. Leaves nothing, but for what clang-tidy had nothing to say of.
# Exit status: the command's, or 77 where such a root cannot be made.
set -eu
[ $# -gt 0 ] || { echo "bare.sh: say which command to run: bare.sh CMD" >&2; exit 2; }
[ "$(id -u)" = 0 ] && mode=root || mode=unshare
command -v mmdebstrap >/dev/null || { echo "bare.sh: no mmdebstrap here: no bare Debian is made" >&2; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
git clone --quiet --no-local . "$work/haptable"
[ ! -d ../shared ] || cp -r ../shared "$work/shared"
tidied=${XDG_CACHE_HOME:-$HOME/.cache}/haptable
mkdir -p "$work/cache/haptable" "$tidied"
cp -r "$tidied/." "$work/cache/haptable"
# A network whose certificates are its own has them in this machine's bundle; pip asks there.
[ ! -r /etc/ssl/certs/ca-certificates.crt ] || cp /etc/ssl/certs/ca-certificates.crt "$work/certificates.crt"
cat >"$work/inside" <<END
unset MAKEFLAGS MAKELEVEL MFLAGS
export HOME=/root XDG_CACHE_HOME=/cache
[ ! -e /certificates.crt ] || export PIP_CERT=/certificates.crt REQUESTS_CA_BUNDLE=/certificates.crt
cd /haptable
TIMEFORMAT='bare: %R s, of which the processors worked %U s and the kernel %S s'
time { $1; }
echo \$? >/status
END
WORK=$work
export WORK
# Runs a command in a root. That is the root of a mount namespace: behind a chroot the kernel gives no namespaces, of
# which some tests make a network or a disk. Where it cannot be, a chroot.
cat >"$work/enter" <<'END'
root=$1
shift
into='mount --rbind "$0" "$0" && cd "$0" && mount -t proc proc proc && pivot_root . mnt && umount -l mnt'
unshare -m sh -c "$into" "$root" && exec unshare -m sh -c "$into && exec \"\$@\"" "$root" "$@"
exec chroot "$root" "$@"
END
# The hooks are commands of the shell, with the root as $1.
mmdebstrap --quiet --mode=$mode --variant=important --include=git,make --format=null bookworm \
    --customize-hook='cp -r "$WORK"/* "$1/"' \
    --customize-hook='sh "$WORK/enter" "$1" bash /inside' \
    --customize-hook='cp "$1/status" "$WORK/" && cp -r "$1/cache" "$WORK/"' ||
    { echo "bare.sh: no bare Debian could be made here" >&2; exit 77; }
cp -r "$work/cache/haptable/." "$tidied"
exit "$(cat "$work/status")"
