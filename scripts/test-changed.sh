#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Runs the suites of C++ beside sources that are newer than the last run of this that was green or, before the first one,
# differ from the last commit; and names the files of pytest there, which start programs. Called by `make test-changed`
# from the project's root, when the tests are built.
set -u
BUILD=${BUILD:-build}
green=$BUILD/tests/changed.green
touch "$green.now"
if [ -e "$green" ]; then
    changed=$(find host codegen firmware tests -type f -name '*.[chp]*' -newer "$green")
else
    changed=$(git diff --name-only HEAD -- host codegen firmware tests && git ls-files -o --exclude-standard host codegen firmware tests)
fi
# What tests a file: NAME_test.cpp of its folder in tests/, or where there is none all of that folder.
tests="" files=""
for file in $changed; do
    folder=tests/$(dirname "${file#tests/}") name=$(basename "$file")
    name=${name%%.*}
    if [ -e "$folder/${name%_test}_test.cpp" ]; then
        tests="$tests $folder/${name%_test}_test.cpp"
    elif [ -d "$folder" ]; then
        tests="$tests $(find "$folder" -maxdepth 1 -name '*_test.cpp' | tr '\n' ' ')"
        files="$files $(find "$folder" -maxdepth 1 -name 'test_*.py' | tr '\n' ' ')"
    else
        echo "$folder: there is none; make test runs what else tests $file"
    fi
done
# shellcheck disable=SC2086 # a word a file
suites=$([ -z "$tests" ] || sed -n 's/^\(TYPED_\)\{0,1\}TEST[_FP]*(\([A-Za-z0-9]*\),.*/\2/p' $tests | sort -u)
filter=$(for suite in $suites; do printf '%s.*:*/%s.*:' "$suite" "$suite"; done)
[ -n "$filter" ] || { echo "nothing that tests of C++ are beside has changed" && exit 0; }
BUILD=$BUILD sh "$(dirname "$0")/test.sh" --gtest_filter="$filter" || exit 1
mv "$green.now" "$green"
# shellcheck disable=SC2086 # a word a file
set -- $(echo $files | tr ' ' '\n' | sort -u)
[ $# = 0 ] || echo "of programs, when they are made: sh scripts/loopback.sh python3 -m pytest --import-mode=importlib $*"
