#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# fuzz.sh SECONDS [READER...]: every reader that we wrote and LCM's messages under libFuzzer with Address- and UndefinedBehaviorSanitizer,
# SECONDS each, from tests/fuzz/corpus. New inputs stay in build/fuzz/; `fuzz.sh merge` takes those that reach new code
# into the corpus. Exit status 1 and the input's path where one crashes, hangs or takes too much memory.
set -eu
here=tests/fuzz
out=${BUILD:-build}/fuzz
seconds=$1
shift
readers=${*:-abaqus vega vtu tetgen scene messages}
sources="host/dense/dense.cpp host/base/file.cpp host/base/interrupt.cpp host/base/json.cpp host/base/limits.cpp host/base/scene_options.cpp host/base/stiffening.cpp host/base/text.cpp host/mesh/lines.cpp host/mesh/read_abaqus.cpp host/mesh/read_vega.cpp
    host/mesh/read_vtu.cpp host/mesh/read_tetgen.cpp $(ls host/scene/*.cpp | grep -v /main.cpp) host/link/decode.cpp"
flags="-std=c++20 -g -O1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -I. -isystem ${BUILD:-build}/lcm -isystem /usr/include/eigen3"
command -v clang++ >/dev/null || { echo "fuzz: no clang++: the readers are not fuzzed"; exit 0; }
mkdir -p "$out/objects"
# An object is as new as every file of the host that it may read.
is_current() { [ -e "$1" ] && [ -z "$(find host "$here" -name '*.[ch]pp' -newer "$1" | head -n 1)" ]; }
objects=""
for source in $sources; do
    object=$out/objects/$(basename "$source").o
    is_current "$object" || ${CCACHE:-} clang++ $flags -c "$source" -o "$object"
    objects="$objects $object"
done
for reader in $readers; do
    program=$out/$reader
    mkdir -p "$out/found/$reader" "$here/corpus/$reader"
    is_current "$out/objects/$reader.o" ||
        ${CCACHE:-} clang++ $flags -DHAPTABLE_FUZZ=fuzz_$reader -c $here/readers.cpp -o "$out/objects/$reader.o"
    clang++ -fsanitize=fuzzer,address,undefined "$out/objects/$reader.o" $objects -o "$program" -lfmt -lpugixml -lz
    if [ "$seconds" = merge ]; then
        "$program" -merge=1 "$here/corpus/$reader" "$out/found/$reader" 2>&1 | tail -n 1
        continue
    fi
    "$program" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -max_len=4096 -artifact_prefix="$out/$reader-" \
        "$out/found/$reader" "$here/corpus/$reader" >"$out/$reader.log" 2>&1 ||
        { grep -E 'ERROR|runtime error|Test unit' "$out/$reader.log" >&2; echo "fuzz: $reader failed: $out/$reader.log" >&2; exit 1; }
    echo "fuzz: $reader: $(grep -o 'Done [0-9]* runs in [0-9]* second' "$out/$reader.log")s, no crash"
done
