#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# margins.sh FILE...: the assertions that came nearer to their bounds than a third, from files that the tests wrote with
# HAPTABLE_MARGINS; each once, at its nearest. Exit status 1 where there are any.
set -u

# tolerance_test.cpp misses bounds on purpose.
near=$(sort -gr "$@" | awk '$1 > 1 / 3 && $2 !~ /tolerance_test/ && !seen[$2]++')
[ -n "$near" ] || { echo "every error is within a third of its bound"; exit 0; }
echo "nearer to its bound than a third:"
echo "$near"
exit 1
