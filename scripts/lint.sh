#!/bin/sh
# What the compiler's warnings do not say: the arrows between the folders, what the firmware must not hold, the form of
# the files, clang-tidy on the C++ and cppcheck on the C. Called by `make lint` from the project's root, everything built.
set -eu
BUILD=${BUILD:-build}
failed=0
complain() {
    echo "lint: $*" >&2
    failed=1
}

includes="-I. -I$BUILD -I$BUILD/lcm -isystem /usr/include/eigen3 -isystem /usr/include/suitesparse -isystem /usr/include/cairo"
unreadable='/port/|_template.h$' # of our C++, or included by its instances alone
if command -v mpicxx >/dev/null; then
    for folder in $(mpicxx --showme:incdirs); do includes="$includes -isystem $folder"; done
else
    unreadable="$unreadable|host/(inverse|precompute)/mpi/"
fi

# ---- arrows: what a folder may include of the project -------------------------------------------------------------
arrow() { # FOLDER ALLOWED...: prefixes of includes; a part of it that has a line of its own stands aside
    folder=$1
    shift
    pattern=$(echo "$*" | sed 's/ /|/g')
    parts=$(sed -n "s|^arrow \\($folder/[^ ]*\\) .*|\\1/|p" scripts/lint.sh | paste -sd'|')
    found=$(grep -rnE '#include "' "$folder" --include='*.[ch]' --include='*.[ch]pp' | grep -vE "^(${parts:-/})|#include \"($pattern)" || true)
    [ -z "$found" ] || complain "$folder may include only $*:
$found"
}
arrow firmware haptable model.h display.h
arrow host/base host/base
arrow host/dense host/dense
arrow host/tables host/base host/tables
arrow host/scene host/base host/dense host/scene
arrow host/mesh host/base host/mesh
arrow host/fem host/base host/mesh/quadratic_tet.hpp host/fem
arrow codegen host/base host/tables codegen firmware/haptable.h firmware/haptable_model.h firmware/haptable_scene.h firmware/haptable_deformation.h firmware/haptable_body.h firmware/haptable_modes.h firmware/haptable_pair.h firmware/haptable_tool.h
# What computes K^-1 knows nothing of scenes, of the report and of the product's files.
arrow host/inverse host/base host/dense host/inverse
# What solves with a factor is linked without what makes one.
arrow host/inverse/solve host/base host/tables host/inverse/solve
# A mesh with what holds it and what it is made of; then what of L = K^-1 a scene needs; then a run and its folder.
arrow host/body host/base host/dense host/scene host/mesh host/fem host/inverse host/body
arrow host/compliance host/base host/dense host/tables host/inverse host/body codegen/pair.hpp host/compliance
arrow host/precompute host/base host/dense host/scene host/mesh/audit.hpp host/mesh/read_mesh.hpp host/tables host/inverse host/body host/compliance codegen host/precompute
arrow host/link host/base host/link haptable/
arrow host/session host/base host/link "host/session/[^/]*.hpp" firmware/haptable.h firmware/haptable_model.h firmware/haptable_body.h firmware/haptable_modes.h firmware/haptable_scene.h firmware/haptable_tool.h firmware/haptable_hands.h haptable/
arrow host/session/servo host/base host/link host/session host/session/servo model.h haptable/
arrow host/target host/base host/tables codegen host/target firmware/haptable_model.h firmware/haptable_scene.h firmware/haptable_bounds.h firmware/haptable_pair.h firmware/haptable_tool.h
arrow host/session/bridge host/base host/link host/session host/session/bridge host/tables codegen firmware/haptable_body.h firmware/haptable_line.h firmware/haptable_line_points.h firmware/haptable_tool.h firmware/haptable_pair.h firmware/haptable_model.h haptable/
arrow host/device host/base host/link host/scene host/tables host/device haptable/
arrow host/run host/base host/link host/scene host/run haptable/
arrow host/fit host/base host/dense host/scene host/session/servo host/tables host/fit codegen
arrow host/strokes host/base host/session/scene_state.hpp host/inverse/cholmod_inverse.hpp host/link/finger_path.hpp host/mesh host/body host/precompute host/scene host/tables host/strokes codegen firmware/haptable_model.h firmware/haptable_scene.h firmware/haptable_pair.h
arrow host/library host/precompiled.hpp host/base host/tables host/session/energy.hpp host/library host/session/scene_state.hpp codegen firmware/haptable_model.h firmware/haptable_body.h
# Its C is the page's (host/page/wasm): it includes the firmware as an image does.
arrow host/page host/base host/tables "host/page/[^/]*.hpp" host/view/colormap.hpp host/view/surface.hpp host/device/point_device.hpp codegen firmware/haptable_model.h haptable deform.h hand.h
arrow host/page/live host/base host/device host/link host/page host/tables host/view codegen haptable/
arrow host/view host/base host/fem/hooke.hpp host/link host/tables host/inverse/solve host/view codegen firmware/haptable_model.h haptable/

# ---- the rooms of the firmware ------------------------------------------------------------------------------------
sh scripts/rooms.sh >/dev/null || complain "firmware: the arrows above, or the rooms of firmware/rooms.txt"

# ---- firmware: freestanding, single precision, no heap, no recursion ----------------------------------------------
headers=$(grep -rhoE '#include <[^>]*>' firmware | sort -u | grep -vE '<(stdint|stddef|stdbool|limits|float)\.h>' || true)
[ -z "$headers" ] || complain "firmware needs more than a freestanding compiler: $headers"
words=$(grep -rnE '\b(double|goto)\b|\b(malloc|calloc|realloc|free|alloca|printf) *\(' firmware --include='*.[ch]' | grep -vE '^[^:]*:[0-9]*: *(/\*|\*|//)' | grep -vE '/\*.*\b(free|double)\b' || true)
[ -z "$words" ] || complain "firmware must not use:
$words"
calls=$(mktemp -d)
trap 'rm -rf "$calls"' EXIT
# clang-tidy takes minutes of every processor, and much of what follows one: side by side.
make -k -j"$(nproc)" --no-print-directory BUILD="$BUILD" tidy >"$calls/tidy" 2>&1 &
tidy=$!
for file in firmware/*.c; do
    gcc -std=c99 -ffreestanding -O0 -fcallgraph-info -Ifirmware -c "$file" -o "$calls/$(basename "$file").o"
done
# A cycle in the call graph is a recursion; tsort finds it.
sed -n 's/^edge: { sourcename: "\([^"]*\)" targetname: "\([^"]*\)".*/\1 \2/p' "$calls"/*.ci | sed 's/[^ ]*:\([a-z]\)/\1/g' >"$calls/edges"
tsort "$calls/edges" >/dev/null 2>"$calls/cycles" || complain "firmware recurses: $(cat "$calls/cycles")"

# ---- names: what would meet a user's own in a flat include path or at the link -----------------------------------
# The images' programs (port/) aside, whose names are the images'; size.sh looks at every symbol of an image.
for file in firmware/*.[ch] firmware/port/*.[chS]; do
    case $(basename "$file") in
    haptable.h | haptable_*) ;;
    *) grep -q '^int haptable_port_main' "$file" || complain "$file: its name must begin with haptable_" ;;
    esac
done
exported=$(nm -g --defined-only "$calls"/*.o | awk 'NF == 3 && $3 !~ /^haptable_/ { print $3 }')
[ -z "$exported" ] || complain "firmware exports names that do not begin with haptable_: $exported"
macros=$(grep -nE '^ *# *define ' firmware/*.h firmware/port/*.h | grep -vE '# *define (HAPTABLE_|([a-z0-9_]+)(\([a-z, ]*\))? haptable_\2)' || true)
[ -z "$macros" ] || complain "macros of firmware's headers must begin with HAPTABLE_:
$macros"
public='firmware/haptable.h firmware/haptable_types.h firmware/haptable_model.h firmware/haptable_scene.h firmware/haptable_line.h firmware/haptable_line_points.h firmware/haptable_deformation.h firmware/haptable_body.h firmware/haptable_modes.h'
# shellcheck disable=SC2086 # a list
types=$(grep -nE '^(struct|enum|union|typedef) |^ +[A-Z][A-Z0-9_]*( = [0-9]+)?,?( /.*)?$' $public | grep -viE 'haptable_' || true)
[ -z "$types" ] || complain "types and constants of the public headers must begin with haptable_:
$types"

# The one-definition rule: where two classes share a name, a program that is linked of both takes the members of either
# for both, and the linker does not say so. So the compiler reads every header at once: it refuses a second class, inline
# function or constant of a name. What a .cpp adds stands in an unnamed namespace, in a function or in a header's class.
headers=$(git ls-files 'host/*.hpp' 'codegen/*.hpp' 'tests/*.hpp' 'firmware/*.h' | grep -vE "$unreadable")
{
    for header in $headers; do echo "#include \"$header\""; done
    for header in "$BUILD"/lcm/haptable/*.hpp; do echo "#include \"haptable/$(basename "$header")\""; done
} >"$calls/headers.cpp"
# shellcheck disable=SC2086 # lists of options
g++ -std=c++20 -fsyntax-only -Drestrict=__restrict__ -Ifirmware $includes "$calls/headers.cpp" ||
    complain "two headers say different things of one name; rename one"
# shellcheck disable=SC2046 # file names of ours hold no spaces
shared=$(ctags --languages=C++ --c++-kinds=cgsu --fields=sZ --sort=no -f - $(git ls-files 'host/*.cpp' 'codegen/*.cpp' 'tests/*.cpp') |
    awk -F'\t' '!/__anon/ && $NF !~ /^scope:(class|struct|function):/ { print $1 " in " $2 }
        !/__anon/ && $NF ~ /^scope:(class|struct):/ {
            name = $NF "::" $1
            sub(/^scope:[a-z]*:/, "", name)
            if (name in place) print name " in " place[name] " and in " $2
            place[name] = $2
        }')
[ -z "$shared" ] || complain "a class of a .cpp that another may have too; put it into an unnamed namespace:
$shared"

# ---- MISRA C:2012, as far as cppcheck's addon goes: firmware/misra.txt lists what we deviate from, and why ------------
sh scripts/misra.sh || complain "MISRA C:2012: mend it, or give the reason in firmware/misra.txt"

# ---- functions of the firmware that nobody calls -----------------------------------------------------------------------
sh scripts/uncalled.sh || complain "firmware: nobody calls the functions above; take them out"

# ---- form ---------------------------------------------------------------------------------------------------------
# shellcheck disable=SC2046 # file names of ours hold no spaces
clang-format --dry-run -Werror $(git ls-files '*.c' '*.h' '*.cpp' '*.hpp') || complain "run make format"
! git grep -nE '^(<<<<<<<|>>>>>>>) ' || complain "a merge was not finished"
for file in $(git ls-files '*.c' '*.h' '*.cpp' '*.hpp' '*.sh'); do
    case $file in
    *.sh) ;;
    *) head -1 "$file" | grep -q SPDX-License-Identifier || complain "$file: its first line must name its licence" ;;
    esac
done

# ---- pages ---------------------------------------------------------------------------------------------------------
sh scripts/docs.sh || complain "the pages: mend what is said above"
# shellcheck disable=SC2046 # file names of ours hold no spaces
/usr/bin/python3 -m lab check $(git ls-files '*.md' 'docs/data/*.csv') || complain "the numbers of the pages: mend what is said above"

# ---- packages: what a bare machine lacks ---------------------------------------------------------------------------
sh scripts/packages.sh || complain "scripts/setup.sh: name the packages above in the set that needs them"

# ---- clang-tidy, cppcheck -----------------------------------------------------------------------------------------
# ctuuninitvar: a struct whose fields are set one by one is unset to it; clang-tidy follows the fields.
cppcheck --quiet --std=c99 --enable=warning,style,performance,portability --inline-suppr --error-exitcode=1 \
    --suppress=unusedStructMember --suppress=ctuuninitvar --suppress=missingInclude --suppress=comparePointers:firmware/port/* -Ifirmware firmware || complain "cppcheck"
wait "$tidy" || complain "clang-tidy"
cat "$calls/tidy"

[ $failed = 0 ] && echo "lint: clean"
exit $failed
