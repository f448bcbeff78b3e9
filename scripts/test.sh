#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Runs every test, says why some were skipped, and ends with one line: N passed, N failed, N skipped. Called by
# `make test` from the project's root; arguments go to the test program (BUILD=build sh scripts/test.sh
# --gtest_filter='Mesh*').
set -u

BUILD=${BUILD:-build}
export BUILD
log=$BUILD/tests/log
[ -x "$BUILD/tests/unit" ] || { echo "$BUILD/tests/unit is not built: run make test" >&2; exit 1; }

# The tests of the closed loop need LCM. Where it cannot work they skip, each with a line that says why.
run="sh scripts/loopback.sh"
sh scripts/loopback.sh true || run=""

# All goes to the log; people see suites, failures and reasons to skip, not every test that is well.
{
    # shellcheck disable=SC2086 # a command and its argument
    $run "$BUILD/tests/unit" "$@" 2>&1
    echo $? >"$log.status"
} | tee "$log" | grep --line-buffered -v -e '^\[ RUN' -e '^\[       OK' -e '^\[-*\] [0-9]* tests\{0,1\} from [^ ]*$' -e '^$'
status=$(cat "$log.status")

# Counted from the lines with a time, one a test: a program that crashes has no summary, but it has these.
count() { grep -c "^\[$1\] .* ms)\$" "$log"; }
passed=$(count '       OK ')
failed=$(count '  FAILED  ')
skipped=$(count '  SKIPPED ')
if [ "$status" -ne 0 ] && [ "$failed" -eq 0 ]; then
    echo "the test program ended with status $status in: $(sed -n 's/^\[ RUN *\] //p' "$log" | tail -n 1)"
    failed=1
fi
# Each reason once, with its count. ../shared has meshes of other people, which no clone has.
sed -n '/: Skipped$/{n;p;}' "$log" | sed 's|^no "\{0,1\}\.\./shared.*|no ../shared|' | sort | uniq -c | sort -rn |
    sed 's/^ *\([0-9]*\) /skipped \1: /'
echo "$passed passed, $failed failed, $skipped skipped"
[ "$status" -eq 0 ]
