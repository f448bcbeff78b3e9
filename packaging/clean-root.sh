#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# clean-root.sh FOLDER: installs the packages of `make deb` into a Debian 12 that has nothing else, and goes from there
# to a force: a scene by haptable-build, a mesh by Gmsh's module, a page, and the C example by pkg-config; then removes
# them. Needs mmdebstrap, root (or a user's namespaces) and a mirror. Leaves nothing.
set -eu
folder=$1
[ "$(id -u)" = 0 ] && mode=root || mode=unshare
inside=$(mktemp)
trap 'rm -f "$inside"' EXIT
cat >"$inside" <<'END'
set -eux
used() { df --output=used -k / | tail -n 1; }
since() { echo $(($(date +%s) - $1)); }
begin=$(date +%s) before=$(used)
apt-get install -y --no-install-recommends /packages/*.deb pkgconf >/dev/null
echo "clean-root: installed in $(since "$begin") s, $((($(used) - before) / 1000)) MB with all that it depends on"
for program in build precompute codegen device view bridge run fit; do
    haptable-$program --version && test -s /usr/share/man/man1/haptable-$program.1.gz
done
begin=$(date +%s)
mkdir "/a scene" && cd "/a scene"
cp /usr/share/haptable/meshes/* .
haptable-build cube.toml --quiet
build/cube/servo --poke top
echo "clean-root: from there to the cube's force in $(since "$begin") s"
haptable-precompute mouse.toml --quiet
haptable-view build/cube --page touch.html --quiet && test -s touch.html
haptable-codegen build/cube --export platformio -o exported && test -s exported/src/model.c
cp /usr/share/doc/libhaptable-dev/examples/touch.c . && cc touch.c $(pkg-config --cflags --libs haptable) -o touch && ./touch build/cube
du -sk /usr/share/haptable /usr/lib/haptable
apt-get purge -y haptable libhaptable-dev libhaptable1 >/dev/null
for left in /usr/share/haptable /usr/lib/haptable /usr/bin/haptable-build; do test ! -e $left; done
END
# The hooks are commands of the shell, with the root as $1.
FOLDER=$(cd "$folder" && pwd) INSIDE=$inside
export FOLDER INSIDE
mmdebstrap --quiet --mode=$mode --variant=apt --format=null bookworm \
    --customize-hook='mkdir "$1/packages" && cp "$FOLDER"/*.deb "$1/packages/" && cp "$INSIDE" "$1/inside"' \
    --customize-hook='chroot "$1" sh /inside'
echo "clean-root: well"
