#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Runs the tests, one process a processor, says why some were skipped, and ends with one line: N passed, N failed, N
# skipped. Called by `make test` from the project's root; arguments go to the test program (BUILD=build sh
# scripts/test.sh --gtest_filter='Mesh*'). `test.sh whole`: those that prove packages, installed copies and several
# machines, which `make test-all` runs besides.
set -u

BUILD=${BUILD:-build}
export BUILD
unit=$BUILD/tests/unit
part=part
[ "${1:-}" != whole ] || { part=whole && shift; }
[ $# = 0 ] || part=chosen
log=$BUILD/tests/log
jobs=$BUILD/tests/jobs
[ -x "$unit" ] || { echo "$unit is not built: run make test" >&2; exit 1; }

# The tests of the closed loop need LCM. Where it cannot work they skip, each with a line that says why.
loopback="sh scripts/loopback.sh"
$loopback true || loopback=""

# One job: make in the same folder, which two may not do at once. It and the other long suites come first, each a job of
# its own; the rest goes into jobs of a few dozen tests, suites whole: a suite may make once what all its tests touch.
makers="DebianPackages PythonPackage Installed Liver MakeScene"
long="Export Strokes TouchPage NodalPressure LivePage Modes/ModeInBrowser Inverse3 Shared/WholePrecompute Elements
    PressureMask Scenes/Target PrecomputeRun Run All/ElementLoop FaultySession"
# MPI's processes spin where they wait: beside others on the same processors they take ten times as long. They go first,
# alone.
alone="Ranks/Mpi Ranks/MpiOfMore"
whole=$(sed -n 's/^TEST[_FP]*(\([A-Za-z0-9]*\),.*/\1/p' tests/packaging/*.cpp tests/host/mpi/*.cpp | sort -u | tr '\n' ' ')
rm -rf "$jobs"
mkdir -p "$jobs"
"$unit" "$@" --gtest_list_tests | awk -v whole="$whole" -v part=$part -v folder="$jobs" -v makers="$makers" -v long="$long" -v alone="$alone" -v most=40 '
    function job(number) { return sprintf("%s/%03d", folder, number) }
    BEGIN {
        for (i = split(whole, names); i > 0; i--) is_whole[names[i]] = 1
        for (i = split(alone, names); i > 0; i--) first[names[i]] = 0
        for (i = split(makers, names); i > 0; i--) first[names[i]] = 1
        for (i = last = split(long, names); i > 0; i--) first[names[i]] = i + 1
        last += 2
    }
    # "Suite.  # TypeParam() = ...", then "  Test  # GetParam() = ..." of each of its tests.
    /^[^ ].*\.( |$)/ {
        suite = $1
        if (size >= most) { last++; size = 0 }
        name = substr(suite, 1, length(suite) - 1)
        fixture = name
        sub(/^[^\/]*\//, "", fixture)
        is_asked = part == "chosen" || (fixture in is_whole) == (part == "whole")
        if (!is_asked) next
        to = name in first ? job(first[name]) : job(last)
        next
    }
    /^  / && is_asked { print suite $1 >to; if (to == job(last)) size++ }'

# All goes to a log a job; people see suites, failures and reasons to skip, not every test that is well.
# shellcheck disable=SC2016 # for the shell of each job
work='
    job=$0
    $loopback "$unit" "$@" --gtest_filter="$(tr "\n" : <"$job")" >"$job.log" 2>&1
    echo $? >"$job.status"
    grep -v -e "^\[ RUN" -e "^\[       OK" -e "^\[-*\] [0-9]* tests\{0,1\} from [^ ]*$" -e "^\[-*\] Global" \
        -e "^\[==*\]" -e "^\[  PASSED" -e "^Note: Google" -e "^Running main" -e "^$" "$job.log"'
export loopback unit
[ ! -e "$jobs/000" ] || sh -c "$work" "$jobs/000" "$@"
find "$jobs" -type f -not -name '000*' | sort | xargs -P "$(nproc)" -I{} sh -c "$work" {} "$@"
cat "$jobs"/*.log >"$log"

# Counted from the lines with a time, one a test: a program that crashes has no summary, but it has these.
count() { grep -c "^\[$1\] .* ms)\$" "$log"; }
passed=$(count '       OK ')
failed=$(count '  FAILED  ')
skipped=$(count '  SKIPPED ')
status=0
for job in $(find "$jobs" -type f -not -name '*.*' | sort); do
    ended=$(cat "$job.status")
    [ "$ended" = 0 ] || status=1
    [ "$ended" = 0 ] || grep -q '^\[  FAILED  \] .* ms)$' "$job.log" || {
        echo "the test program ended with status $ended in: $(sed -n 's/^\[ RUN *\] //p' "$job.log" | tail -n 1)"
        failed=$((failed + 1))
    }
done
# Each reason once, with its count. ../shared has meshes of other people, which no clone has.
sed -n '/: Skipped$/{n;p;}' "$log" | sed 's|^no "\{0,1\}\.\./shared.*|no ../shared|' | sort | uniq -c | sort -rn |
    sed 's/^ *\([0-9]*\) /skipped \1: /'
echo "$passed passed, $failed failed, $skipped skipped" | tee "$BUILD/tests/$part.closing"
[ "$status" -eq 0 ]
