#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Runs the tests, one process more than processors, as some wait for a clock or a browser; says why some were skipped,
# and ends with one line: N passed, N failed, N skipped. Called by `make test` from the project's root; arguments go to
# the test program (BUILD=build sh scripts/test.sh --gtest_filter='Mesh*'). `test.sh whole`: those that prove packages,
# installed copies, the laboratory and several machines, which `make test-all` runs besides: tests/packaging, tests/lab
# and tests/host/mpi.
set -u

BUILD=${BUILD:-build}
export BUILD
unit=$BUILD/tests/unit
part=part
[ "${1:-}" != whole ] || { part=whole && shift; }
[ $# = 0 ] || part=chosen
log=$BUILD/tests/log
jobs=$BUILD/tests/jobs
times=$BUILD/tests/times
[ -x "$unit" ] || { echo "$unit is not built: run make test" >&2; exit 1; }

# The tests of the closed loop need LCM. Where it cannot work they skip, each with a line that says why.
loopback="sh scripts/loopback.sh"
$loopback true || loopback=""

# What can run by itself, a line each: a file of Python, or a suite with its tests' number. A suite whole: it may make
# once what all its tests touch. MPI's processes spin where they wait: beside others on the same processors they take
# ten times as long, so they go first, alone.
rm -rf "$jobs"
mkdir -p "$jobs"
mpi=$(sed -n 's/^TEST[_FP]*(\([A-Za-z0-9]*\),.*/\1/p' tests/host/mpi/*.cpp | sort -u | tr '\n' ' ')
case $part in
chosen) ;;
whole) find tests/packaging tests/lab -name 'test_*.py' ;;
part) find tests -name 'test_*.py' -not -path 'tests/packaging/*' -not -path 'tests/lab/*' ;;
esac >"$jobs/all"
"$unit" "$@" --gtest_list_tests | awk -v mpi="$mpi" -v part=$part '
    BEGIN { for (i = split(mpi, names); i > 0; i--) is_whole[names[i]] = 1 }
    function tell() { if (size && (part == "chosen" || alone == (part == "whole"))) print suite, size, alone; size = 0 }
    # "Suite.  # TypeParam() = ...", then "  Test  # GetParam() = ..." of each of its tests.
    /^[^ ].*\.( |$)/ {
        tell()
        suite = fixture = $1
        sub(/^[^\/]*\//, "", fixture)
        sub(/[.\/].*/, "", fixture)
        alone = fixture in is_whole
    }
    /^  / { size++ }
    END { tell() }' >>"$jobs/all"

# The longest of the last run first, so that no processor is idle at the end; before the first run those of another
# machine (sort -k2 -rn of its times). Suites of a second and less go into jobs of twenty tests: of those that never ran,
# one may be long.
[ -e "$times" ] || cp tests/longest.txt "$times"
awk -v times="$times" '
    BEGIN { while ((getline line < times) > 0) { split(line, of); took[of[1]] = of[2] } }
    { ms = $1 in took ? took[$1] : $1 ~ /[.]py$/ ? 1e6 : $2 > 40 ? 1e5 : 999; print ms, $1, $2, $3 }' "$jobs/all" |
    sort -k1,1rn -k2,2 | awk -v folder="$jobs" '
    function job(number) { return sprintf("%s/%03d", folder, number) }
    $2 ~ /[.]py$/ { print $2 >job(++last); few = 0; next } # no suite joins its job
    $4 { print $2 "*" >job(0); next }
    $1 >= 1000 { print $2 "*" >job(++last); next }
    { if (!few || few + $3 > 20) { last++; few = 0 } few += $3; print $2 "*" >job(last) }'

# All goes to a log a job; people see suites, failures and reasons to skip, not every test that is well.
# shellcheck disable=SC2016 # for the shell of each job
work='
    job=$0
    case $(cat "$job") in
    *.py) $loopback env PYTHONPATH=tests /usr/bin/python3 -m pytest -q -p shard -p no:cacheprovider --tb=short --rootdir=. \
        --import-mode=importlib "$(cat "$job")" >"$job.log" 2>&1 ;;
    *) $loopback "$unit" "$@" --gtest_filter="$(tr "\n" : <"$job")" >"$job.log" 2>&1 ;;
    esac
    echo $? >"$job.status"
    grep -v -e "^\[ RUN" -e "^\[       OK" -e "^\[-*\] [0-9]* tests\{0,1\} from [^ ]*$" -e "^\[-*\] Global" \
        -e "^\[==*\]" -e "^\[  PASSED" -e "^Note: Google" -e "^Running main" -e "^[0-9]* passed.* in " -e "^ *\[[ 0-9]*%\]$" -e "^$" "$job.log"'
export loopback unit
[ ! -e "$jobs/000" ] || sh -c "$work" "$jobs/000" "$@"
find "$jobs" -type f -name '[0-9]*' -not -name '000*' | sort | xargs -P $(($(nproc) + 1)) -I{} sh -c "$work" {} "$@"
cat "$jobs"/*.log >"$log"

# What each took, for the next run.
sed -n 's/^\[       OK \] \(.*[.]py\)::.* (\([0-9]*\) ms)$/\1 \2/p
    s/^\[       OK \] \([A-Za-z0-9_/]*[.]\)[^ ]* (\([0-9]*\) ms)$/\1 \2/p' "$log" |
    awk '{ took[$1] += $2 } END { for (name in took) print name, took[name] }' >"$jobs/took"
[ $part = chosen ] || { sort -u -k1,1 "$jobs/took" "$times" >"$times.beside" && mv "$times.beside" "$times"; }

# Counted from the lines with a time, one a test: a program that crashes has no summary, but it has these.
count() { grep -c "^\[$1\] .* ms)\$" "$log"; }
passed=$(count '       OK ')
failed=$(count '  FAILED  ')
skipped=$(count '  SKIPPED ')
status=0
for job in $(find "$jobs" -type f -name '[0-9]*' -not -name '*.*' | sort); do
    ended=$(cat "$job.status")
    [ "$ended" = 0 ] || status=1
    [ "$ended" = 0 ] || grep -q '^\[  FAILED  \] .* ms)$' "$job.log" || {
        echo "the test program ended with status $ended in: $(sed -n 's/^\[ RUN *\] //p' "$job.log" | tail -n 1) of $(cat "$job")"
        failed=$((failed + 1))
    }
done
for file in $(grep '[.]py$' "$jobs/all"); do
    grep -q "\] $file::" "$log" || { echo "$file: none of its tests ran" && failed=$((failed + 1)) status=1; }
done
# Each reason once, with its count. ../shared has meshes of other people, which no clone has.
sed -n '/: Skipped$/{n;p;}' "$log" | sed 's|^no "\{0,1\}\.\./shared.*|no ../shared|' | sort | uniq -c | sort -rn |
    sed 's/^ *\([0-9]*\) /skipped \1: /'
echo "$passed passed, $failed failed, $skipped skipped" | tee "$BUILD/tests/$part.closing"
[ "$status" -eq 0 ]
