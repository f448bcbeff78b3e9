# SPDX-License-Identifier: GPL-2.0-or-later
"""docs/numbers.json: what was measured, by topic, and the markers of the pages that show it.

A topic is a number, {"value", "text"}, or a table, {"columns", "rows"}; a cell of a row is a text or a number. A value
is in SI units or a count; it is a list where one cell tells several (median, worst). "command" and "machine" tell what
measured the topic, and where.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path
from typing import Any

import pandas as pd

from lab import LabError

Topics = dict[str, dict[str, Any]]

#: Topics that only the report shows: a row for every configuration.
REPORT_ONLY = ("large-strain-curve", "order", "points", "stiffening-curve", "truth")


# ---- the file ------------------------------------------------------------------------------------------------------

def require_cell(cell: Any, where: str) -> None:
    """Raises LabError where `cell` is neither a text nor a number with its text."""
    if isinstance(cell, str):
        return
    if isinstance(cell, dict) and isinstance(cell.get("text"), str):
        value = cell.get("value")
        values = value if isinstance(value, list) else [value]
        if values and all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
            return
    raise LabError(f"{where}: {json.dumps(cell)} is no text and no number; measure again")


def require_topic(topic: Any, where: str) -> None:
    """Raises LabError where `topic` is neither a number nor a table whose rows have a cell a column."""
    if not isinstance(topic, dict):
        raise LabError(f"{where}: is no topic; measure again")
    if "rows" not in topic:
        require_cell(topic, where)
        return
    for i, row in enumerate(topic["rows"]):
        if not isinstance(row, list) or len(row) != len(topic.get("columns", [])):
            raise LabError(f"{where}: row {i} has not a cell a column; measure again")
        for cell in row:
            require_cell(cell, f"{where}: row {i}")


def read_numbers(file: Path) -> Topics:
    """The topics of `file`. Raises LabError that names the file and what is wrong with it."""
    try:
        topics = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise LabError(f"{file}: is no JSON: {error}; measure again with make bench") from error
    if not isinstance(topics, dict):
        raise LabError(f"{file}: holds no topics; measure again with make bench")
    for name, topic in topics.items():
        require_topic(topic, f"{file}: {name}")
    return topics


def to_text(topics: Topics) -> str:
    """As JSON with a row of a table a line, topics in order of their names: a change is seen in a diff."""
    def dump(value: Any) -> str:
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))

    def body(key: str, value: Any) -> str:
        if key == "rows" and value:
            return '  "rows": [\n' + ",\n".join("   " + dump(row) for row in value) + "]"
        return f'  "{key}": {dump(value)}'

    blocks = (f' "{name}": {{\n' + ",\n".join(body(*item) for item in topics[name].items()) + "}"
              for name in sorted(topics))
    return "{\n" + ",\n".join(blocks) + "\n}\n"


def write_file(file: Path, text: str) -> None:
    """Beside, then renamed: a file is whole or as it was."""
    file.parent.mkdir(parents=True, exist_ok=True)
    beside = file.with_name(file.name + ".beside")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, file)


def write_topics(file: Path, topics: Topics, command: str = "make bench") -> None:
    """With the command that measured them, and the machine, for take_folder()."""
    ran = {"command": command, "machine": machine()}
    write_file(file, to_text({name: {**ran, **topic} for name, topic in topics.items()}))


def take_folder(folder: Path, topics: Topics) -> None:
    """Topics of every .json of `folder` take the place of those of their names."""
    for file in sorted(folder.glob("*.json")):
        topics.update(read_numbers(file))


# ---- numbers as people read them -----------------------------------------------------------------------------------

def machine() -> str:
    """As base/machine.cpp tells it: processors and their name."""
    model = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), "processor")
    return f"{os.cpu_count()} x {model}"


def number(value: float, text: str) -> dict[str, Any]:
    return {"value": value, "text": text}


def count(n: int) -> dict[str, Any]:
    """9,275"""
    return number(n, f"{n:,}")


def error_of(relative: float) -> dict[str, Any]:
    """1.5e-07"""
    return number(relative, f"{relative:.1e}")


def seconds(s: float) -> dict[str, Any]:
    """0.25 us, 12.1 ms: three digits"""
    for least, scale, unit in ((1.0, 1.0, "s"), (1e-3, 1e3, "ms"), (1e-6, 1e6, "us"), (0.0, 1e9, "ns")):
        if s >= least:
            return number(s, f"{scale * s:.3g} {unit}")
    return number(s, f"{1e9 * s:.3g} ns")


# ---- pages ---------------------------------------------------------------------------------------------------------

_BEGIN = re.compile(r"<!-- ([a-z][a-z0-9-]*) -->")


def find_markers(text: str) -> list[tuple[str, int, int, int, int]]:
    """(topic, begin, inside, inside_end, end) of every pair "<!-- topic -->", "<!-- /topic -->", in order."""
    markers = []
    for match in _BEGIN.finditer(text):
        close = f"<!-- /{match[1]} -->"
        inside_end = text.find(close, match.end())
        if inside_end >= 0:
            markers.append((match[1], match.start(), match.end(), inside_end, inside_end + len(close)))
    return markers


def text_of(cell: Any) -> str:
    return cell if isinstance(cell, str) else cell["text"]


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def to_markdown(topic: dict[str, Any]) -> str:
    """A topic as a page shows it: a table on lines of its own, or the text of a number."""
    if "rows" not in topic:
        return topic["text"]
    rows = "".join(_row([text_of(cell) for cell in row]) for row in topic["rows"])
    return "\n" + _row(topic["columns"]) + "|" + "---|" * len(topic["columns"]) + "\n" + rows


def to_csv(topic: dict[str, Any]) -> str:
    """The same as CSV (RFC 4180): a line of columns, then the rows, each cell as a page shows it."""
    if "rows" not in topic:
        return topic["text"] + "\n"
    out = io.StringIO()
    rows = [topic["columns"], *([text_of(cell) for cell in row] for row in topic["rows"])]
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def _is_data(path: str) -> bool:
    """TOPIC.csv is that topic and nothing else, for tables that are looked up."""
    return path.endswith(".csv")


def _shown(path: str, text: str) -> list[tuple[str, str]]:
    """What a page shows: topics, and the text that stands there."""
    if _is_data(path):
        return [(Path(path).stem, text)]
    return [(topic, text[inside:inside_end]) for topic, _, inside, inside_end, _ in find_markers(text)]


def _no_number(path: str, topic: str) -> str:
    what = "topic" if _is_data(path) else "marker"
    return f"{path}: the {what} {topic} has no number; measure it (make bench), or remove it"


def fill(path: str, text: str, topics: Topics) -> str:
    """The page with its markers filled. Raises LabError for a marker or a file without a number."""
    for topic, _ in _shown(path, text):
        if topic not in topics:
            raise LabError(_no_number(path, topic))
    if _is_data(path):
        return to_csv(topics[Path(path).stem])
    filled, at = "", 0
    for topic, _, inside, inside_end, _ in find_markers(text):
        filled += text[at:inside] + to_markdown(topics[topic])
        at = inside_end
    return filled + text[at:]


def _long_numbers(text: str) -> set[str]:
    """Numbers of four digits or more, zeros at either end not counted, without commas. Fewer meet by chance."""
    found = set()
    for match in re.finditer(r"[0-9]+(,[0-9]{3})*(\.[0-9]+)?", text):
        digits = match[0].replace(",", "")
        is_year = len(match[0]) == 4 and digits == match[0]
        if len(digits.strip("0.").replace(".", "")) >= 4 and not is_year:
            found.add(digits)
    return found


def _quoted(topic: dict[str, Any]) -> set[str]:
    if "rows" not in topic:
        return _long_numbers(text_of(topic))
    return {n for row in topic["rows"] for cell in row if isinstance(cell, dict) for n in _long_numbers(cell["text"])}


def _without_markers(text: str) -> str:
    rest, at = "", 0
    for _, begin, _, _, end in find_markers(text):
        rest += text[at:begin]
        at = end
    return rest + text[at:]


def find_faults(pages: dict[str, str], topics: Topics) -> list[str]:
    """What is wrong, a line each: a marker without its number or with another one, a number on no page or on two, and
    one that a page quotes though another page owns it. `pages`: text by path. Of the thousands in the files of data one
    is met by chance, two of one file are a quote."""
    faults = []
    owners: dict[str, list[str]] = {}
    for path, text in pages.items():
        for topic, shown in _shown(path, text):
            owners.setdefault(topic, []).append(path)
            if topic not in topics:
                faults.append(_no_number(path, topic))
            elif shown != (to_csv if _is_data(path) else to_markdown)(topics[topic]):
                faults.append(f"{path}: {topic} is not what numbers.json says; fill the page with make report")
    here = {path: set() if _is_data(path) else _long_numbers(_without_markers(text)) for path, text in pages.items()}
    for name, topic in topics.items():
        places = owners.get(name, [])
        if len(places) != (0 if name in REPORT_ONLY else 1):
            faults.append(f"numbers.json: {name} stands in {len(places)} places of the pages, and must in "
                          + ("none: the report shows it" if name in REPORT_ONLY else "one"))
            continue
        if name in REPORT_ONLY:
            continue
        for path in pages:
            both = sorted(here[path] & _quoted(topic)) if path != places[0] else []
            if len(both) > _is_data(places[0]):
                faults.append(f"{path}: quotes {', '.join(both)}, of {name}, which stands on {places[0]}: link to it")
    return faults


def _read_pages(pages: list[Path]) -> dict[str, str]:
    return {str(file): file.read_text(encoding="utf-8") for file in pages}


def take(folder: Path, pages: list[Path], numbers: Path = Path("docs/numbers.json")) -> None:
    """Topics of the folder's files into `numbers`, and from there into pages. What is as it was is not written."""
    from lab import points
    topics = read_numbers(numbers)
    before, texts = to_text(topics), _read_pages(pages)
    take_folder(folder, topics)
    points.derive(topics)
    filled = {path: fill(path, text, topics) for path, text in texts.items()}
    for path, old, new in [(str(numbers), before, to_text(topics)), *((p, texts[p], filled[p]) for p in texts)]:
        if new != old:
            write_file(Path(path), new)


def check(pages: list[Path], numbers: Path = Path("docs/numbers.json")) -> None:
    """Raises LabError with what is wrong, a line each."""
    if faults := find_faults(_read_pages(pages), read_numbers(numbers)):
        raise LabError("\n".join(faults))


def runs(topics: Topics) -> str:
    """A table in Markdown: which commands measured which topics, on which machine."""
    measured: dict[tuple[str, str], list[str]] = {}
    for name in sorted(topics):
        run = topics[name].get("command", "unknown"), topics[name].get("machine", "unknown")
        measured.setdefault(run, []).append(name)
    rows = (_row([f"`{command}`", on, ", ".join(names)]) for (command, on), names in sorted(measured.items()))
    return _row(["command", "machine", "topics of docs/numbers.json"]) + "|---|---|---|\n" + "".join(rows)


# ---- data frames ---------------------------------------------------------------------------------------------------

def frame(topic: dict[str, Any]) -> pd.DataFrame:
    """A table's values by the names of its columns; a text is itself, and an empty cell of a number is NaN.

    A cell of several values becomes columns "NAME", "NAME (2)", ... A column without a name is "what".
    """
    columns: dict[str, list[Any]] = {}
    for k, name in enumerate(topic["columns"]):
        cells = [row[k] for row in topic["rows"]]
        values = [cell if isinstance(cell, str) else cell["value"] for cell in cells]
        is_number = any(not isinstance(v, str) for v in values)
        values = [(float("nan") if v == "" else v) if is_number else v for v in values]
        most = max((len(v) for v in values if isinstance(v, list)), default=1)
        name = name or "what"
        while name in columns:
            name += "'"
        for part in range(most):
            columns[name if part == 0 else f"{name} ({part + 1})"] = [
                (v[part] if part < len(v) else float("nan")) if isinstance(v, list)
                else v if part == 0 else float("nan") for v in values]
    return pd.DataFrame(columns)
