# SPDX-License-Identifier: GPL-2.0-or-later
"""build/report: index.html, one page of what was measured; configurations.html, which a reader sorts and filters;
csv/TOPIC.csv, every table as values in SI units."""

import html
import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any

from lab import LabError, build, plots
from lab.numbers import (REPORT_ONLY, Topic, Topics, frame, read_numbers, replace, runs, shown, text_of, write_file)
from lab.numbers import table as made

#: The contents: pages of docs/ by part, in order. A page with numbers that is in none comes under "More".
PARTS = {
    "Error and speed": ("ACCURACY", "HARD", "design/elements", "design/speed"),
    "Contact": ("CONTACT", "STROKES"),
    "Microcontrollers": ("COSTS", "MICROCONTROLLER"),
    "Devices and sessions": ("DEVICES", "LOOP", "TOUCH", "FIRST"),
    "Precompute": ("design/meshes",),
    "Ways in": ("INSTALL", "PYTHON"),
}
_HERE = Path(__file__).parent
#: Tables of as many rows have a field that filters them.
_MANY = 12
#: Columns of at most so many different texts have a list of choices on the page of configurations.
_CHOICES = 12


def _markdown(text: str) -> str:
    """HTML, by cmark-gfm."""
    try:
        return subprocess.run(["cmark-gfm", "-e", "table"], input=text, stdout=subprocess.PIPE, text=True,
                              check=True).stdout
    except FileNotFoundError as error:
        raise LabError("report: no cmark-gfm: sh scripts/setup.sh lab installs it") from error


def _plain(text: str) -> str:
    """Markdown of a cell as HTML: code is all that cells hold."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", html.escape(text, quote=False))


def _slug(heading: str) -> str:
    """The anchor that git hosts give a heading of this HTML."""
    text = html.unescape(re.sub(r"<[^>]*>", "", heading)).lower().replace(" ", "-")
    return re.sub(r"[^a-z0-9_-]", "", text)


def _filters(topic: Topic, choices: bool) -> str:
    filters = ""
    for k, column in enumerate(topic["columns"] if choices else []):
        texts = list(dict.fromkeys(row[k] for row in topic["rows"] if isinstance(row[k], str)))
        if 1 < len(texts) <= _CHOICES and all(isinstance(row[k], str) for row in topic["rows"]):
            options = "".join(f"<option>{html.escape(text)}</option>" for text in texts if text)
            filters += (f'<label>{_plain(column)} <select data-column="{k}"><option value="">all</option>{options}'
                        "</select></label>")
    if len(topic["rows"]) > _MANY:
        filters += '<label>rows with <input type="search" placeholder="words"></label><output></output>'
    return filters


def table(name: str, topic: Topic, *, choices: bool = False) -> str:
    """A topic's table, sorted by values where a heading is pressed; its CSV beside it."""
    def td(cell: Any) -> str:
        value = "" if isinstance(cell, str) else cell["value"]
        value = value[0] if isinstance(value, list) else value
        data = "" if value == "" else f" data-v={json.dumps(str(value))} class=n"
        return f"<td{data}>{_plain(text_of(cell))}</td>"
    head = "".join(f'<th scope="col"><button type="button">{_plain(column) or "&nbsp;"}</button></th>'
                   for column in topic["columns"])
    body = "".join(f"<tr>{''.join(map(td, row))}</tr>" for row in topic["rows"])
    return (f'<div class="sortable" id="table-{name}"><div class="filters">{_filters(topic, choices)}'
            f'<a href="csv/{name}.csv" download>CSV</a></div><div class="wide"><table><thead><tr>{head}</tr></thead>'
            f"<tbody>{body}</tbody></table></div></div>")


def figure_of(file: Path, caption: str = "") -> str:
    """An SVG within the page, with its PDF to load down where there is one."""
    text = file.read_text(encoding="utf-8")
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->\s*", "", text[text.index("<svg"):], flags=re.S)
    for _ in ("width", "height"):  # wide as its column
        svg = re.sub(r'(<svg[^>]*?) (?:width|height)="[^"]*"', r"\1", svg, count=1)
    pdf = file.with_suffix(".pdf")
    link = f' <a href="{pdf.name}" download>PDF</a>' if pdf.exists() else ""
    return f'<figure id="figure-{file.stem}">{svg}<figcaption>{caption}{link}</figcaption></figure>'


class Pages:
    """Pages of `docs` as sections of one page in `out`."""

    def __init__(self, docs: Path, out: Path, topics: Topics) -> None:
        self.docs, self.out, self.topics = docs, out, topics
        self.parts = {part: [page for page in pages if (docs / f"{page}.md").exists()] for part, pages in PARTS.items()}
        with_numbers = {str(p.relative_to(docs).with_suffix("")) for p in docs.rglob("*.md")
                        if shown(p.name, p.read_text(encoding="utf-8"))}
        if more := sorted(with_numbers.difference(*PARTS.values())):
            self.parts["More"] = more
        self.all = [page for pages in self.parts.values() for page in pages]
        self.shown: set[str] = set()  # figures, by name

    def title(self, page: str) -> str:
        return (self.docs / f"{page}.md").read_text(encoding="utf-8").split("\n", 1)[0].removeprefix("# ")

    def _link(self, page: str, attribute: str, to: str) -> str:
        """A link to a page of the report leads into it, one to another file to where that lies from `out`."""
        if re.match(r"[a-z]+:", to):
            return f'{attribute}="{to}"'
        path, _, anchor = to.partition("#")
        from_docs = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else f"{page}.md"
        if from_docs.removesuffix(".md") in self.all and from_docs.endswith(".md"):
            return f'{attribute}="#{from_docs.removesuffix(".md")}{":" if anchor else ""}{anchor}"'
        return f'{attribute}="{os.path.relpath(Path("docs") / from_docs, self.out)}"'

    def _picture(self, match: re.Match[str]) -> str:
        name, alt = Path(match[1]).stem, match[2]
        if name in self.shown:
            return f'<a href="#figure-{name}">{alt}</a>'
        self.shown.add(name)
        fresh = self.out / f"{name}.svg"
        return "</p>" + figure_of(fresh if fresh.exists() else Path("docs/pictures") / f"{name}.svg", alt) + "<p>"

    def section(self, page: str) -> str:
        text = (self.docs / f"{page}.md").read_text(encoding="utf-8")
        tables = {}

        def place(at: re.Match[str], topic: Topic) -> str:
            if "rows" not in topic:
                return text_of(topic)
            tables[f"<p>{_place(at[2])}</p>"] = table(at[2], topic)
            return _place(at[2])
        body = _markdown(replace(f"{page}.md", text, self.topics, place))
        body = re.sub(r'<img src="([^"]*\.svg)" alt="([^"]*)" />', self._picture, body).replace("<p></p>", "")
        body = re.sub(r'(?<=[ <])(href|src)="([^"]*)"', lambda m: m[0] if m[2].startswith(("csv/", "#figure-"))
                      or m[2].endswith(".pdf") else self._link(page, m[1], m[2]), body)
        body = _wide(_anchored(body, f"{page}:"))
        for placed, whole in tables.items():
            body = body.replace(placed, whole)
        return f'<section id="{page}">\n{body}</section>\n'


def _place(topic: str) -> str:
    return f"table of {topic} stands here"


def _anchored(body: str, of: str) -> str:
    """With an anchor at every heading."""
    return re.sub(r"<h([2-6])>(.*?)</h\1>", lambda m: f'<h{m[1]} id="{of}{_slug(m[2])}">{m[2]}</h{m[1]}>', body)


def _wide(body: str) -> str:
    """Its tables are pushed aside where they are wider than the window."""
    return body.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")


def answer(topics: Topics) -> Topic:
    """A table, a row a body: the mask that is nearest to the body of those in flash; beside it the solve of the
    whole body that is nearest, and the paper's."""
    columns, rows = topics["points"]["columns"], topics["points"]["rows"]
    force, error, tick = (columns.index(name) for name in ("force", "error, RMS", "tick"))

    def nearest(body: str, forces: tuple[str, ...], *shown: int) -> list[Any]:
        found = [row for row in rows if row[0] == body and row[force] in forces]
        best = min(found, key=lambda row: (row[error]["value"], row[tick]["value"]), default=[""] * len(columns))
        return [best[k] for k in shown]
    return made("body | mesh | element | mask: error | tick | flash | precompute | a solve: error | tick | "
                "the paper: error | tick", [
                    [body, *nearest(body, ("pressure-mask",), 1, 2, 6, 8, 9, 10),
                     *nearest(body, ("sparse solve", "dense inverse", "conjugate gradients"), 6, 8),
                     *nearest(body, ("the paper, 1998",), 6, 8)] for body in plots.BODIES])


def _page(title: str, nav: str, main: str) -> str:
    style, script = ((_HERE / f"report.{end}").read_text(encoding="utf-8") for end in ("css", "js"))
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{title}</title>\n'
            f"<style>\n{style}</style></head>\n<body>\n<nav><details open>"
            f"<summary>Contents</summary>\n{nav}</details></nav>"
            f"\n<main>\n{main}</main>\n<script>\n{script}</script>\n</body></html>\n")


def _items(links: list[tuple[str, str]]) -> str:
    return ("<ul>" + "".join(f'<li><a href="{to}">{html.escape(text, quote=False)}</a></li>' for to, text in links)
            + "</ul>\n")


def index(docs: Path, out: Path, topics: Topics) -> str:
    pages = Pages(docs, out, topics)
    captions = {
        "time": "RMS error of the force against the CPU time of a tick. Of each force the configurations that none "
                "beats in both; mesh and element stand beside the mask's. The paper's own times of 1998 and the "
                "solves that one would do instead stand in the same picture.",
        "flash": "The same against the bytes of the servo's tables.",
        "precompute": "The same against the CPU time from a scene to its tables.",
    }
    figures = [figure_of(out / f"error-{axis}.svg", caption) for axis, caption in captions.items()]
    pages.shown |= {f"error-{axis}" for axis in captions}
    main = ('<section id="answer"><h1>Speed against error</h1>\n' + figures[0]
            + "<p>For each body: the pressure mask that is nearest to the body itself, the nearest of the "
              "solves that one would do instead of tables, and the paper.</p>\n" + table("answer", answer(topics))
            + figures[1] + figures[2]
            + '<p>Every configuration: <a href="configurations.html">a table to sort and to filter</a>, or '
              '<a href="csv/points.csv">CSV</a>.</p></section>\n')
    nav = _items([("#answer", "Speed against error"), ("configurations.html", "Every configuration")])
    for part, of_part in pages.parts.items():
        nav += f"<h2>{part}</h2>" + _items([(f"#{page}", pages.title(page)) for page in of_part])
        main += "".join(pages.section(page) for page in of_part)
    looked_up = sorted(file.stem for file in (docs / "data").glob("*.csv"))
    if looked_up:
        main += '<section id="tables"><h1>Tables to look up</h1>\n' + "".join(
            f"<h2>{name}</h2>\n" + table(name, topics[name], choices=True) for name in looked_up) + "</section>\n"
        nav += _items([("#tables", "Tables to look up")])
    main += f'<section id="runs"><h1>What was run</h1>\n{_wide(_markdown(runs(topics)))}</section>\n'
    return _page("haptable: speed against error", nav + _items([("#runs", "What was run")]), main)


def configurations(topics: Topics) -> str:
    """The topics that only the report shows, with how each was taken (configurations.md)."""
    body = _markdown((_HERE / "configurations.md").read_text(encoding="utf-8"))
    for name in REPORT_ONLY:
        place = f"<p>{_place(name)}</p>"
        if body.count(place) != 1:
            raise LabError(f"lab/configurations.md: has to say once where the table of {name} stands")
        body = body.replace(place, table(name, topics[name], choices=True))
    nav = _items([("index.html", "The report")] + [(f"#{_slug(h)}", h) for h in re.findall(r"<h2>(.*?)</h2>", body)])
    return _page("haptable: every configuration", nav, _anchored(body, ""))


def make(out: Path, docs: Path = Path("docs")) -> None:
    """build/report: index.html, configurations.html, CSV files, figures; docs: pages and numbers.json."""
    topics = read_numbers(docs / "numbers.json")
    for name in REPORT_ONLY:
        if name not in topics:
            raise LabError(f"{docs}/numbers.json: has no {name}; measure it (make bench, make bench-large)")
    out.mkdir(parents=True, exist_ok=True)
    plots.measured(topics, build() / "contact", out)
    for name, topic in {**topics, "answer": answer(topics)}.items():
        if "rows" in topic:
            write_file(out / f"csv/{name}.csv", frame(topic).to_csv(index=False, float_format="%.9g"))
    write_file(out / "configurations.html", configurations(topics))
    write_file(out / "index.html", index(docs, out, topics))
    print(f"  {out}/index.html")
