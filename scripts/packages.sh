#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# packages.sh: every header that the host, the code generator and the tests include, every library that they are linked
# with, and every program below that scripts and tests call, is of a package that setup.sh names, of one that such a package depends on, or of the compiler's own. dpkg
# says which package a file is of. So a package that is taken out of setup.sh is missed where it is still installed.
set -eu
programs='arm-none-eabi-gcc arm-none-eabi-nm ccx chromium clang clang-format clang-tidy cmake cmark-gfm cppcheck ctags
    dpkg-shlibdeps ffmpeg g++ gnuplot help2man lcm-gen lcm-logger lintian llvm-mca llvm-objdump make mmdebstrap mpirun
    pkg-config python3 qemu-system-arm qemu-system-riscv32 riscv64-unknown-elf-gcc wasm-ld'
found=$(mktemp -d)
trap 'rm -rf "$found"' EXIT

sets=$(sed -n 's/^    \([a-z]*\)) .*/\1/p' scripts/setup.sh)
# shellcheck disable=SC2086 # a list of sets
sh scripts/setup.sh --list $sets | tr ' ' '\n' | sort -u >"$found/named"
xargs dpkg-query -W -f '${Package}\n${Depends}, ${Pre-Depends}, ' <"$found/named" 2>/dev/null |
    tr ',|' '\n\n' | sed 's/^ *//; s/[ :(].*//' | sort -u >"$found/installs"

# shellcheck disable=SC2046 # file names of ours hold no spaces
grep -hoE '^ *# *include <[^>]+>' $(git ls-files host codegen tests | grep -E '\.[ch](pp)?$') |
    sed 's/.*<//; s/>//' | sort -u >"$found/headers"
folders="$(g++ -x c++ -E -v - </dev/null 2>&1 | sed -n 's/^ //; /^\/usr\/.*include/p') /usr/include/eigen3 /usr/include/suitesparse"
! command -v mpicxx >/dev/null || folders="$folders $(mpicxx --showme:incdirs)"
while read -r header; do
    for folder in $folders; do
        [ ! -e "$folder/$header" ] || { echo "$(readlink -f "$folder")/$header" && break; }
    done
done <"$found/headers" >"$found/files"
for library in $(grep -hoE -e ' -l[a-z][A-Za-z0-9_]*' Makefile packaging/*.mk scripts/fuzz.sh | sort -u | sed 's/ -l//'); do
    for kind in so a; do
        file=$(g++ -print-file-name="lib$library.$kind")
        [ "${file#/}" = "$file" ] || echo "$(readlink -f "${file%/*}")/${file##*/}"
    done
done >>"$found/files"

for program in $programs; do PATH=/usr/bin:/usr/sbin command -v "$program" || true; done >>"$found/files"
# An alternative's link is no package's: what it leads to is.
xargs dpkg -S <"$found/files" 2>&1 >"$found/owners" | sed -n "s/.*no path found matching pattern \\(.*bin\\)/\\1/p" |
    xargs -r readlink -f | xargs -r dpkg -S >>"$found/owners" 2>/dev/null || true
sed 's/:.*//' "$found/owners" | sort -u |
    grep -vE '^(libc6-dev|linux-libc-dev|libcrypt-dev|libgcc-.*|libstdc\+\+-.*|gcc-[0-9]+|g\+\+-[0-9]+)$' >"$found/used"
missing=$(comm -23 "$found/used" "$found/installs")
[ -s "$found/used" ] || { echo "packages.sh: dpkg knows no file that we include" >&2 && exit 1; }
[ -z "$missing" ] || {
    # shellcheck disable=SC2086 # on one line
    echo "packages.sh: we include or link files of these, which no set of scripts/setup.sh installs:" $missing >&2
    exit 1
}
