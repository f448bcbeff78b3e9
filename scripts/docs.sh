#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Whether the pages can be read: no page longer than a reader's patience, nor all together than a week's, prose wrapped,
# every link leads somewhere.
# Called by scripts/lint.sh from the project's root; needs nothing built.
set -eu

reference='(CHANGELOG|docs/(SPEC|SCENE|NOTATION|STROKES)).md' # looked up, not read
most_words=1500
most_in_all=45000
most_columns=100
status=0
complain() {
    echo "docs: $*" >&2
    status=1
}

# Without what a program measured: <!-- topic -->, a table, <!-- /topic -->.
written() { awk '/^<!-- \/?[a-z-]+ -->$/ { table = !/\//; next } !table' "$@"; }

pages=$(git ls-files --cached --others --exclude-standard '*.md' ':!lab') # lab/configurations.md is the report's
for page in $pages; do
    words=$(written "$page" | wc -w)
    echo "$page" | grep -qE "$reference" || [ "$words" -le $most_words ] ||
        complain "$page has $words words, more than $most_words: split it by what a reader comes for"
    # Tables and code may be wider.
    wide=$(awk -v most=$most_columns '/^```/ { code = !code } !code && !/^\|/ && length($0) > most { print FNR }' "$page" | tr '\n' ' ')
    [ -z "$wide" ] || complain "$page: more than $most_columns columns in line $wide"
    # "](path#anchor)": the file is there, and the anchor is one of its headings in the form that git hosts give them.
    for link in $(grep -oE '\]\([^) ]+\)' "$page" | sed 's/^](//; s/)$//' | grep -vE '^[a-z]+:' | sort -u); do
        path=${link%%#*}
        target=$([ -n "$path" ] && echo "$(dirname "$page")/$path" || echo "$page")
        [ -e "$target" ] || { complain "$page: no $path"; continue; }
        case $link in
        *#*) sed -n 's/^#* //p' "$target" | tr 'A-Z ' 'a-z-' | tr -cd 'a-z0-9_\n-' | grep -qx -e "${link#*#}" ||
            complain "$page: $path has no heading #${link#*#}" ;;
        esac
    done
    # A label that is a page's name leads to that page.
    for link in $(grep -oE '\[[A-Za-z/_.-]+\.md\]\([^) ]+\)' "$page" | sort -u); do
        label=${link%%]*} path=${link#*(}
        [ "$(basename "${label#?}")" = "$(basename "${path%%[#)]*}")" ] || complain "$page: $link leads to another page"
    done
done
words=$(echo "$pages" | xargs cat | wc -w)
[ "$words" -le $most_in_all ] || complain "the pages have $words words together, more than $most_in_all"
exit $status
