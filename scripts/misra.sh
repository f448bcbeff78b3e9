#!/bin/sh
# MISRA C:2012 as far as cppcheck's addon goes: every rule that firmware/*.c deviates from must stand, with its reason,
# in firmware/misra.txt, and every rule there must still be needed. `misra.sh --list` prints the places.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
found=$work/found
# The addon reads a dump that cppcheck writes beside each source: beside a copy.
cp -r firmware "$work"
(cd "$work" && for file in firmware/*.c; do
    cppcheck --quiet --std=c99 --enable=style --addon=misra --suppress=missingInclude -Ifirmware \
        --template='{file}:{line} {id}' "$file" 2>&1 | grep -E 'misra-c2012-[0-9]' || true
done) | sort -u >"$found"
[ "${1:-}" != --list ] || cat "$found"
deviations=$(sed 's/.*misra-c2012-//' "$found" | sort -Vu)
listed=$(sed -n 's/^\([0-9]*\.[0-9]*\) .*/\1/p' firmware/misra.txt | sort -Vu)
[ "$deviations" = "$listed" ] || {
    echo "misra: firmware deviates from: $(echo "$deviations" | tr '\n' ' ')" >&2
    echo "misra: firmware/misra.txt has: $(echo "$listed" | tr '\n' ' ')" >&2
    exit 1
}
