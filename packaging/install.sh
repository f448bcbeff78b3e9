#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# install.sh DESTDIR PREFIX LIBDIR: called by `make install` from the project's root, all built. What it puts there is
# listed in share/haptable/installed.txt, which `make uninstall` reads.
set -eu
destdir=$1 prefix=$2 libdir=$3
case $prefix$libdir in
*[!A-Za-z0-9/._+@~,-]*) echo "install: PREFIX=$prefix: give letters, digits and / . _ + @ ~ , -" >&2 && exit 1 ;;
/*) ;;
*) echo "install: PREFIX=$prefix: give it from the root, as in PREFIX=\$HOME/.local" >&2 && exit 1 ;;
esac
share=$prefix/share/haptable
list=$(mktemp)
trap 'rm -f "$list"' EXIT
umask 022

# put MODE FOLDER FILE...: into a folder of the system, each listed.
put() {
    mode=$1 folder=$2
    shift 2
    mkdir -p "$destdir$folder"
    for file in "$@"; do
        install -m "$mode" "$file" "$destdir$folder/"
        echo "$folder/$(basename "$file")" >>"$list"
    done
}

for program in precompute codegen device view bridge run fit; do put 755 "$prefix/bin" "$BUILD/bin/haptable-$program"; done
put 755 "$prefix/bin" packaging/haptable-build

put 644 "$prefix/lib/haptable" "$BUILD"/lib/haptable-*.so "$BUILD/lib/libhaptable-servo.a"
for part in "$BUILD"/lib/page/*; do put 644 "$share/page" "$part"; done

# What a scene's servo and an image for a microcontroller are compiled from.
put 644 "$share/firmware" firmware/*.[ch] firmware/README.md firmware/CMakeLists.txt firmware/idf_component.yml firmware/library.* firmware/*.pdsc
put 644 "$share/firmware/zephyr" firmware/zephyr/*
put 644 "$share/firmware/port" firmware/port/*
for file in $(cd packaging && find boards -type f); do put 644 "$share/$(dirname "$file")" "packaging/$file"; done
for file in host/session/servo/main.cpp host/session/servo/servo.hpp host/session/scene.hpp host/session/scene_state.hpp host/base/error.hpp; do
    put 644 "$share/servo/$(dirname "$file")" "$file"
done
put 644 "$libdir" "$BUILD/lib/libhaptable.so.1"
ln -sf libhaptable.so.1 "$destdir$libdir/libhaptable.so"
echo "$libdir/libhaptable.so" >>"$list"
put 644 "$prefix/include/haptable" host/library/haptable_library.h
put 644 "$prefix/share/doc/haptable/examples" host/library/examples/*
version=$("$BUILD/bin/haptable-precompute" --version | cut -d' ' -f2)
for template in haptable.pc haptable-config.cmake haptable-config-version.cmake; do
    sed "s|@prefix@|$prefix|g; s|@libdir@|$libdir|g; s|@version@|$version|g" packaging/$template.in >"$BUILD/package/$template"
done
put 644 "$libdir/pkgconfig" "$BUILD/package/haptable.pc"
put 644 "$libdir/cmake/haptable" "$BUILD/package/haptable-config.cmake" "$BUILD/package/haptable-config-version.cmake"

put 644 "$share/lcm" codegen/lcm/*.lcm
put 644 "$prefix/include/haptable" "$BUILD"/lcm/haptable/*.hpp
put 644 "$share/meshes" $(find meshes -maxdepth 1 -type f)
put 644 "$share" docs/scene.schema.json

for page in $(find docs README.md CHANGELOG.md CONTRIBUTING.md firmware/README.md -name '*.md' -o -path 'docs/pictures/*' -type f -o -path 'docs/data/*' -type f); do
    put 644 "$prefix/share/doc/haptable/$(dirname "$page")" "$page"
done
put 644 "$prefix/share/doc/haptable" LICENSE
mkdir -p "$BUILD/package/gz"
for page in "$BUILD"/package/man/*.1; do
    gzip -9n <"$page" >"$BUILD/package/gz/$(basename "$page").gz"
    put 644 "$prefix/share/man/man1" "$BUILD/package/gz/$(basename "$page").gz"
done
install -D -m 644 packaging/completion.bash "$destdir$prefix/share/bash-completion/completions/haptable-precompute"
echo "$prefix/share/bash-completion/completions/haptable-precompute" >>"$list"
for program in build codegen device view bridge run fit; do # bash looks by the program's name
    ln -sf haptable-precompute "$destdir$prefix/share/bash-completion/completions/haptable-$program"
    echo "$prefix/share/bash-completion/completions/haptable-$program" >>"$list"
done

echo "$share/installed.txt" >>"$list"
sed 's|/\./|/|' "$list" | sort >"$destdir$share/installed.txt"
chmod 644 "$destdir$share/installed.txt"
echo "haptable is installed in $destdir$prefix ($(wc -l <"$list") files, $(du -sh "$destdir$share" | cut -f1) of it in share/haptable)"
