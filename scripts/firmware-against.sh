#!/bin/sh
# SPDX-License-Identifier: MIT
#
# firmware-against.sh REVISION BUILD MAKE WORD...: builds the same image of another revision in a work tree of its own,
# which stays in BUILD/against for the next time, and prints both size tables as one.
set -eu
revision=$1 build=$2 make=$3
shift 3
tree=$build/against
commit=$(git rev-parse --verify --quiet "$revision^{commit}" || git rev-parse --verify --quiet "origin/$revision^{commit}") || {
    echo "firmware-diff: git knows no revision $revision: AGAINST=..." >&2
    exit 1
}
if [ -e "$tree/.git" ]; then
    git -C "$tree" checkout --quiet --detach "$commit"
else
    git worktree prune
    git worktree add --quiet --detach "$tree" "$commit"
fi
echo "building $(git log -1 --format='%h %s' "$commit")"
# Its own make, its own folder. A scene that this revision does not have is ours to give.
$make --no-print-directory -C "$tree" BUILD=build "$@" firmware >"$tree.log" 2>&1 || { tail -n 5 "$tree.log" >&2; exit 1; }
scene=$(printf '%s\n' "$@" | sed -n 's/^SCENE=//p')
target=$(printf '%s\n' "$@" | sed -n 's/^TARGET=//p')
name=$("$build/bin/haptable-precompute" --print-name -- "$scene")
sh scripts/firmware-diff.sh "$tree/build/$name/firmware/$target/size.txt" "$build/$name/firmware/$target/size.txt"
