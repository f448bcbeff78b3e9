#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# peers.sh DIR: brings the haptic libraries that `make bench` times beside the servo, each at one commit, and builds
# DIR/NAME.so of each with its file of host/bench/peers. PEERS: where their repositories are, a URL or a folder.
set -eu
DIR=$1
PEERS=${PEERS:-https://github.com/ChristianFrisson} # a mirror of what SenseGraphics published
export GIT_TERMINAL_PROMPT=0

bring() { # NAME COMMIT, into DIR/NAME
    [ -d "$DIR/$1/.git" ] || git init --quiet "$DIR/$1"
    git -C "$DIR/$1" fetch --quiet --depth 1 "$PEERS/$1" "$2" && git -C "$DIR/$1" checkout --quiet FETCH_HEAD
}

header() { # NAME: what its CMake makes of NAME.cmake where nothing optional is there
    mkdir -p "$DIR/include/$1"
    sed -e 's|^#cmakedefine \(.*\)|/* #undef \1 */|' -e 's/\${[A-Z0-9_]*_VERSION}/0/' \
        "$DIR/$1/include/$1/$1.cmake" >"$DIR/include/$1/$1.h"
}

mkdir -p "$DIR"
bring HAPI 533299c7076e012f2ac21286c81aabbddfffd3d7
bring H3DUtil 4d13ea0804dcb4c3a9fdcc95302f008be0a2d3de
header HAPI
header H3DUtil
sources=host/bench/peers/hapi.cpp
for name in GodObjectRenderer HAPIHapticsRenderer HapticTriangleTree CollisionObjects PlaneConstraint HAPIHapticShape \
    HAPISurfaceObject HAPIFrictionSurface FrictionSurface HAPIHapticsDevice HAPIForceEffect HapticShapeConstraint \
    DeviceLog; do
    sources="$sources $DIR/HAPI/src/$name.cpp"
done
for name in Threads TimeStamp RefCountedClass Console Matrix4d Matrix3d Matrix4f Matrix3f Quaterniond Quaternion \
    Rotationd Rotation Vec3f Vec2f Vec4f Exception H3DTimer; do
    sources="$sources $DIR/H3DUtil/src/$name.cpp"
done
# shellcheck disable=SC2086 # file names of theirs hold no spaces
g++ -std=gnu++14 -O3 -march=native -w -DNDEBUG -fPIC -shared -Wl,--no-undefined -I. -I"$DIR/include" \
    -I"$DIR/HAPI/include" -I"$DIR/H3DUtil/include" $sources -o "$DIR/hapi.so.beside"
mv "$DIR/hapi.so.beside" "$DIR/hapi.so"
