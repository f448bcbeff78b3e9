#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# peers.sh DIR NAME: brings a haptic library that `make bench` times beside the servo, at one commit, and builds
# DIR/NAME.so of it with host/bench/peers/NAME.cpp. PEERS: a folder or a URL that has the repositories.
set -eu
DIR=$1
NAME=$2
export GIT_TERMINAL_PROMPT=0

bring() { # OWNER LIBRARY COMMIT: its code, into DIR/LIBRARY
    [ -d "$DIR/$2/.git" ] || git init --quiet "$DIR/$2"
    git -C "$DIR/$2" config remote.origin.url "${PEERS:-https://github.com/$1}/$2"
    git -C "$DIR/$2" sparse-checkout set src include
    git -C "$DIR/$2" fetch --quiet --depth 1 --filter=blob:none origin "$3"
    git -C "$DIR/$2" checkout --quiet FETCH_HEAD
}

header() { # LIBRARY: what its CMake makes of LIBRARY.cmake where nothing optional is there
    mkdir -p "$DIR/include/$1"
    sed -e 's|^#cmakedefine \(.*\)|/* #undef \1 */|' -e 's/\${[A-Z0-9_]*_VERSION}/0/' \
        "$DIR/$1/include/$1/$1.cmake" >"$DIR/include/$1/$1.h"
}

sources=host/bench/peers/$NAME.cpp
from() { # FOLDER SOURCE...
    folder=$1
    shift
    for name; do sources="$sources $folder/$name.cpp"; done
}

mkdir -p "$DIR"
case $NAME in
hapi)
    bring ChristianFrisson HAPI 533299c7076e012f2ac21286c81aabbddfffd3d7 # a mirror of what SenseGraphics published
    bring ChristianFrisson H3DUtil 4d13ea0804dcb4c3a9fdcc95302f008be0a2d3de
    header HAPI
    header H3DUtil
    from "$DIR/HAPI/src" GodObjectRenderer HAPIHapticsRenderer HapticTriangleTree CollisionObjects PlaneConstraint \
        HAPIHapticShape HAPISurfaceObject HAPIFrictionSurface FrictionSurface HAPIHapticsDevice HAPIForceEffect \
        HapticShapeConstraint DeviceLog
    from "$DIR/H3DUtil/src" Threads TimeStamp RefCountedClass Console Matrix4d Matrix3d Matrix4f Matrix3f Quaterniond \
        Quaternion Rotationd Rotation Vec3f Vec2f Vec4f Exception H3DTimer
    flags="-I$DIR/include -I$DIR/HAPI/include -I$DIR/H3DUtil/include"
    ;;
chai3d)
    bring chai3d chai3d 7c76b1f2dbe11ef5a3d3cbd7ef3286ff720b7a2d # 3.3.0
    from "$DIR/chai3d/src" forces/CAlgorithmFingerProxy forces/CGenericForceAlgorithm collisions/CCollisionAABB \
        collisions/CCollisionAABBTree collisions/CCollisionBrute collisions/CGenericCollision world/CWorld \
        world/CMesh world/CGenericObject graphics/CTriangleArray graphics/CDisplayList graphics/CFog \
        materials/CMaterial system/CGenericType system/CString
    # QNX: without OpenGL. Copying a texture, which no surface here has, would bring every image format.
    flags="-DQNX -I$DIR/chai3d/src -isystem /usr/include/eigen3 -Wl,--defsym=_ZN6chai3d10cTexture1d4copyEv=0"
    ;;
esac
# shellcheck disable=SC2086 # file names of theirs hold no spaces
g++ -std=gnu++14 -O3 -march=native -w -DNDEBUG -fPIC -shared -fvisibility=hidden -ffunction-sections -Wl,--gc-sections \
    -Wl,--no-undefined -I. $flags $sources -o "$DIR/$NAME.so.beside"
mv "$DIR/$NAME.so.beside" "$DIR/$NAME.so"
