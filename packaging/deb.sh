#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# deb.sh STAGE OUT: Debian packages of what `make install` put into STAGE (PREFIX=/usr): haptable (the programs),
# libhaptable1 (the library), libhaptable-dev (its header). Called by `make deb` from the project's root. DEBFULLNAME,
# DEBEMAIL: who packages it. SOURCE_DATE_EPOCH: when; otherwise the last commit's.
set -eu
stage=$1 out=$2
maintainer="${DEBFULLNAME:-the haptable developers} <${DEBEMAIL:-haptable@example.org}>"
date=$(date -uRd "@${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}")
triplet=$(dpkg-architecture -qDEB_HOST_MULTIARCH)
arch=$(dpkg-architecture -qDEB_HOST_ARCH)
version=$(sed -n 's/.*kVersion = "\([^"]*\)".*/\1/p' host/base/program.hpp)-1
work=$out/work
rm -rf "$work"
mkdir -p "$work/debian"
root() { echo "$work/$1"; }

# take PACKAGE PATH...: what of the stage is that package's.
take() {
    package=$1
    shift
    for path in "$@"; do
        mkdir -p "$(root "$package")/$(dirname "$path")"
        mv "$stage/$path" "$(root "$package")/$path"
    done
}
lib=usr/lib/$triplet
take libhaptable1 "$lib/libhaptable.so.1"
take libhaptable-dev "$lib/libhaptable.so" "$lib/pkgconfig" "$lib/cmake" usr/include usr/share/doc/haptable/examples
mkdir -p "$(root libhaptable-dev)/usr/share/doc/libhaptable-dev"
mv "$(root libhaptable-dev)/usr/share/doc/haptable/examples" "$(root libhaptable-dev)/usr/share/doc/libhaptable-dev/"
rmdir "$(root libhaptable-dev)/usr/share/doc/haptable"
rm "$stage/usr/share/haptable/installed.txt" "$stage/usr/share/doc/haptable/LICENSE" # dpkg's list, and its copyright file
mkdir -p "$(root haptable)"
mv "$stage/usr" "$(root haptable)/usr"
# Debian's own three.js.
ln -sf ../../javascript/three/three.min.js "$(root haptable)/usr/share/haptable/page/three.min.js"

for package in haptable libhaptable1 libhaptable-dev; do
    doc=$(root "$package")/usr/share/doc/$package
    mkdir -p "$doc" "$(root "$package")/DEBIAN"
    { printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n\nFiles: *\nCopyright: 2026 the haptable developers\nLicense: GPL-2+ and Expat\n'
      sed 's/^$/./; s/^/ /' LICENSE; } >"$doc/copyright"
    printf 'haptable (%s) bookworm; urgency=medium\n\n  * See CHANGELOG.md of haptable.\n\n\n' "$version" |
        sed "\$s|^| -- $maintainer  $date|" | gzip -9n >"$doc/changelog.Debian.gz"
done

# Nothing that a debugger wants.
find "$work" -type f \( -name '*.so*' -o -path '*/usr/bin/*' \) | while read -r file; do
    case $(head -c 4 "$file" | tr -d '\0') in *ELF*) strip --strip-unneeded --remove-section=.comment --remove-section=.note "$file" ;; esac
done
find "$work" -name '*.a' -exec strip --strip-debug --enable-deterministic-archives {} +

echo 'libhaptable 1 libhaptable1' >"$(root libhaptable1)/DEBIAN/shlibs"
echo 'activate-noawait ldconfig' >"$(root libhaptable1)/DEBIAN/triggers"

# depends_on FILE...: the libraries that these are linked to, as Debian names them.
depends_on() {
    printf 'Source: haptable\n\nPackage: haptable\nArchitecture: any\n' >"$work/debian/control"
    files=$(for file in "$@"; do readlink -f "$file"; done)
    # shellcheck disable=SC2086 # a list
    (cd "$work" && dpkg-shlibdeps -O --ignore-missing-info $files 2>/dev/null | sed 's/^shlibs:Depends=//')
}
control() { # PACKAGE SECTION DEPENDS TITLE TEXT
    cat >"$(root "$1")/DEBIAN/control" <<END
Package: $1
Source: haptable
Version: $version
Architecture: $arch
Maintainer: $maintainer
Installed-Size: $(du -sk --exclude=DEBIAN "$(root "$1")" | cut -f1)
Depends: $3
Section: $2
Priority: optional
Description: $4
$5
END
    (cd "$(root "$1")" && find usr -type f -print0 | sort -z | xargs -0 md5sum >DEBIAN/md5sums)
    find "$(root "$1")" -type d -exec chmod 755 {} +
    dpkg-deb --root-owner-group --build "$(root "$1")" "$out" >/dev/null
}
control haptable science \
    "$(depends_on "$(root haptable)"/usr/bin/haptable-[!b]* "$(root haptable)"/usr/bin/haptable-bridge "$(root haptable)"/usr/lib/haptable/*.so), g++, liblcm-dev, libfmt-dev, libxxhash-dev, libjs-three, fonts-dejavu-core, gnuplot-nox" \
    "soft objects that a haptic device can touch at 1 kHz" \
    " A tetrahedral mesh, a material and the nodes that are held still go in. Out
 come tables of the inverse stiffness, and a servo that feels them: on a
 microcontroller, or here over LCM. Programs to precompute, to simulate a
 device, to draw, and to run a session."
control libhaptable1 libs "$(depends_on "$(root libhaptable1)/$lib/libhaptable.so.1")" \
    "soft objects for haptic devices: the tables of a scene, loaded and felt" \
    " Loads the folder that haptable-precompute wrote, and touches it: forces,
 god-objects, deformation. The servo is the one that haptable generates."
control libhaptable-dev libdevel "libhaptable1 (= $version)" \
    "soft objects for haptic devices: header, pkg-config and CMake" \
    " What a program needs that is to be linked with libhaptable1, examples, and
 the LCM messages of haptable in C++."
rm -rf "$work"
ls -s "$out"/*.deb
