#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# tidy.sh COMPILER FILE OPTION...: clang-tidy on a C file or on a unit of a folder (units.sh). What it had nothing to say of is
# remembered for every clone of this user, by the checks and by all that it reads (our files as they are, the preprocessed
# text with its macros): it takes 20 s a room, the preprocessor two seconds. TIDIED=FOLDER: where; default
# $XDG_CACHE_HOME/haptable/tidy.
set -eu
compiler=$1 file=$2
shift 2
checks=tests/clang-tidy.yaml
tidied=${TIDIED:-${XDG_CACHE_HOME:-$HOME/.cache}/haptable/tidy}
read_by_it=$({ clang-tidy --version && cat "$checks" "$0" && "$compiler" "$@" -E -dD "$file" &&
    "$compiler" "$@" -MM "$file" | tr -d '\\' | tr ' ' '\n' | grep -v ':$' | xargs cat; } | sha256sum)
known=$tidied/${read_by_it%% *}
[ ! -e "$known" ] || exit 0
# int is as wide as a pointer on every target, and what it counts is below 65,536.
[ "${file%.c}" = "$file" ] && but="" || but=-bugprone-implicit-widening-of-multiplication-result
said=$(clang-tidy --quiet --config-file="$checks" --checks="$but" "$file" -- "$@" 2>&1) || {
    echo "$said" | grep -vE '^[0-9]+ (warning|error)s?.* generated'
    exit 1
}
mkdir -p "$tidied"
: >"$known"
