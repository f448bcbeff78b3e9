#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# The report as one page: index.sh DOCS OUT makes OUT/index.html of the pages of DOCS that hold what was measured, with
# their plots, drawn from DOCS/numbers.json, in it. Called by `make report` from the project's root.
set -eu
BUILD=${BUILD:-build}
docs=$1
out=$2
. scripts/own.sh
plain "$docs" "$out"
pages="ACCURACY REFERENCES design/small-strain HARD CONFIGURATIONS design/elements design/elsewhere design/locking CONTACT FEEL STROKES design/speed design/proxies INSTRUCTIONS COSTS MICROCONTROLLER LATENCY DEVICES STABILITY TOUCH TIME LIVER PRECOMPUTE design/masks design/meshes SCALE INSTALL PYTHON"

for page in $(cd "$docs" && grep -lE '^<!-- [a-z-]+ -->$' *.md design/*.md | sed 's/\.md$//'); do
    case " $pages " in *" $page "*) ;; *) echo "report: $docs/$page.md holds numbers and is not in it: name it in scripts/report.sh" >&2 && exit 1 ;; esac
done

# A link to a page of the report leads into it, one to another file to where that lies from OUT. Links of a page in a
# folder are told from docs/ first.
from_docs() { # PAGE
    case $1 in
    */*) sed -E "s@href=\"([a-zA-Z][^\":]*\.md[^\"]*)\"@href=\"${1%/*}/\1\"@g; s@href=\"\.\./([^\":]*)\"@href=\"\1\"@g" ;;
    *) cat ;;
    esac
}
inward="s:href=\"($(echo "$pages" | tr ' ' '|'))\.md(#[^\"]*)?\":href=\"#\1\":g"
outward="s:(href|src)=\"([a-zA-Z.][^\":]*)\":\1=\"$(realpath --relative-to="$out" docs)/\2\":g"

/usr/bin/python3 -m lab --build "$BUILD" plots "$docs/numbers.json" "$out"

# An <img> of an SVG becomes the SVG; its prolog (XML, DOCTYPE) stays outside.
with_pictures() {
    awk -v fresh="$out" '
        match($0, /<img src="[^"]*\.svg"/) {
            name = substr($0, RSTART + 10, RLENGTH - 11)
            sub(/.*\//, "", name)
            file = fresh "/" name
            if ((getline line < file) < 0) file = "docs/pictures/" name
            close(file)
            print "<figure>"
            while ((getline line < file) > 0) { if (line ~ /<svg/) inside = 1; if (inside) print line }
            inside = 0
            close(file)
            print "</figure>"
            next
        }
        { print }'
}

{
    cat <<'HEAD'
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>haptable: speed against error</title>
<style>
body { font: 15px/1.5 "DejaVu Sans", sans-serif; max-width: 72em; margin: 2em auto; padding: 0 1em; color: #1a202c }
table { border-collapse: collapse; font-size: 13px; display: block; overflow-x: auto; margin: 1em 0 }
th, td { border: 1px solid #cbd5e0; padding: 3px 8px; text-align: left; vertical-align: top }
th { background: #edf2f7 }
h1 { border-bottom: 2px solid #1a202c; margin-top: 2em }
pre { background: #edf2f7; padding: 8px; overflow-x: auto }
figure { margin: 1em 0 }
svg { max-width: 100%; height: auto }
</style></head><body>
HEAD
    printf '<nav>'
    for page in $pages; do printf '<a href="#%s">%s</a> ' "$page" "$(sed -n '1s/^# //p' "$docs/$page.md")"; done
    printf '<a href="#runs">What was run</a></nav>\n'
    for page in $pages; do
        printf '<section id="%s">\n' "$page"
        cmark-gfm -e table "$docs/$page.md" | grep -v '^<!-- raw HTML omitted -->$' | from_docs "$page" | sed -E "$inward; $outward" | with_pictures
        printf '</section>\n'
    done
    printf '<section id="runs"><h1>What was run</h1>\n'
    "$BUILD/bin/haptable-report" --numbers "$docs/numbers.json" --runs | cmark-gfm -e table
    printf '</section></body></html>\n'
} >"$out/index.html.beside"
mv "$out/index.html.beside" "$out/index.html"
echo "  $out/index.html"
