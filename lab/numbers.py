# SPDX-License-Identifier: GPL-2.0-or-later
"""docs/numbers.json: what was measured, by topic, and the markers of the pages that show it.

A topic is a number, {"value", "text"}, or a table, {"columns", "rows"}; a cell of a row is a text or a number. A value
is in SI units or a count; it is a list where one cell tells several (median, worst). "command" and "machine" tell what
measured the topic, and where.
"""

import json
import os
import re
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lab import LabError

Topic = dict[str, Any]
Topics = dict[str, Topic]

#: Topics that only the report shows: a row for every configuration.
REPORT_ONLY = ("large-strain-curve", "order", "points", "stiffening-curve", "truth")


# ---- what a bench makes --------------------------------------------------------------------------------------------

def number(value: Any, form: str, scale: Any = 1) -> Topic:
    """A value, or a list of them. Its text is `form` of the value times `scale`, or of each times its own."""
    value = value.item() if isinstance(value, np.generic) else value
    values = value if isinstance(value, list) else [value]
    scales = scale if isinstance(scale, tuple) else [scale] * len(values)
    return {"value": value, "text": form.format(*(times * v for times, v in zip(scales, values)))}


def count(n: int) -> Topic:
    """9,275"""
    return number(n, "{:,}")


def error_of(relative: float) -> Topic:
    """1.5e-07"""
    return number(relative, "{:.1e}")


def percent(share: float, form: str = "{:.0f} %") -> Topic:
    return number(share, form, 100)


def seconds(s: float) -> Topic:
    """0.25 us, 12.1 ms: three digits"""
    scale, unit = next(((scale, unit) for scale, unit in ((1, "s"), (1e3, "ms"), (1e6, "us")) if scale * s >= 1),
                       (1e9, "ns"))
    return number(s, f"{{:.3g}} {unit}", scale)


def table(columns: str | list[str], rows: Iterable[list[Any]]) -> Topic:
    """columns: as a row of a page has them, "body | force | error"."""
    return {"columns": columns.split(" | ") if isinstance(columns, str) else columns, "rows": list(rows)}


def text_of(cell: Any) -> str:
    return cell if isinstance(cell, str) else cell["text"]


def texts(topic: Topic) -> list[list[str]]:
    return [[text_of(cell) for cell in row] for row in topic["rows"]]


def machine() -> str:
    """Processors and their name."""
    model = re.search(r"^model name\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text(), re.M)
    return f"{os.cpu_count()} x {model[1] if model else 'processor'}"


# ---- the file ------------------------------------------------------------------------------------------------------

def _is_cell(cell: Any) -> bool:
    """A text, or a number or several with their text."""
    value = cell.get("value") if isinstance(cell, dict) and isinstance(cell.get("text"), str) else None
    values = value if isinstance(value, list) else [value]
    return isinstance(cell, str) or (bool(values) and all(type(v) in (int, float) for v in values))


def _is_topic(topic: Any) -> bool:
    """A number, or a table whose rows have a cell a column."""
    if not isinstance(topic, dict) or "rows" not in topic:
        return _is_cell(topic) and not isinstance(topic, str)
    return all(len(row) == len(topic["columns"]) and all(map(_is_cell, row)) for row in topic["rows"])


def read_numbers(file: Path = Path("docs/numbers.json")) -> Topics:
    """The topics of `file`. Raises LabError that names the file and what is wrong with it."""
    try:
        topics = json.loads(file.read_text(encoding="utf-8"))
        wrong = [name for name, topic in topics.items() if not _is_topic(topic)]
    except (ValueError, AttributeError, KeyError, TypeError) as error:
        raise LabError(f"{file}: holds no topics: {error}; measure again with make bench") from error
    if wrong:
        raise LabError(f"{file}: {', '.join(wrong)}: no number, and no table of texts and numbers; measure again")
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
    """With the command that measured them, and the machine, for `take`."""
    ran = {"command": command, "machine": machine()}
    write_file(file, to_text({name: {**ran, **topic} for name, topic in topics.items()}))


# ---- pages ---------------------------------------------------------------------------------------------------------

_MARKER = re.compile(r"(<!-- ([a-z][a-z0-9-]*) -->)(.*?)(<!-- /\2 -->)", re.S)


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def to_markdown(topic: Topic) -> str:
    """A topic as a page shows it: a table on lines of its own, or the text of a number."""
    if "rows" not in topic:
        return text_of(topic)
    return ("\n" + _row(topic["columns"]) + "|" + "---|" * len(topic["columns"]) + "\n"
            + "".join(map(_row, texts(topic))))


def to_csv(topic: Topic) -> str:
    """The same as CSV (RFC 4180): a line of columns, then the rows, each cell as a page shows it."""
    if "rows" not in topic:
        return text_of(topic) + "\n"
    return pd.DataFrame(texts(topic), columns=topic["columns"]).to_csv(index=False)


def _is_data(path: str) -> bool:
    """TOPIC.csv is that topic and nothing else, for tables that are looked up."""
    return path.endswith(".csv")


def shown(path: str, text: str) -> list[tuple[str, str]]:
    """What a page shows: topics, and the text that stands there."""
    return [(Path(path).stem, text)] if _is_data(path) else [(at[2], at[3]) for at in _MARKER.finditer(text)]


def _no_number(path: str, topic: str) -> str:
    what = "topic" if _is_data(path) else "marker"
    return f"{path}: the {what} {topic} has no number; measure it (make bench), or remove it"


def replace(path: str, text: str, topics: Topics, show: Any) -> str:
    """The page with show(name, topic) in the place of its markers. Raises LabError for one without a number."""
    for topic, _ in shown(path, text):
        if topic not in topics:
            raise LabError(_no_number(path, topic))
    return _MARKER.sub(lambda at: show(at, topics[at[2]]), text)


def fill(path: str, text: str, topics: Topics) -> str:
    """The page with its markers filled. Raises LabError for a marker or a file without a number."""
    filled = replace(path, text, topics, lambda at, topic: at[1] + to_markdown(topic) + at[4])
    return to_csv(topics[Path(path).stem]) if _is_data(path) else filled


def _long_numbers(text: str) -> set[str]:
    """Numbers of four digits or more, zeros at either end not counted, without commas. Fewer meet by chance."""
    found = set()
    for match in re.finditer(r"[0-9]+(,[0-9]{3})*(\.[0-9]+)?", text):
        digits = match[0].replace(",", "")
        is_year = len(match[0]) == 4 and digits == match[0]
        if len(digits.strip("0.").replace(".", "")) >= 4 and not is_year:
            found.add(digits)
    return found


def _quoted(topic: Topic) -> set[str]:
    cells = [cell for row in topic.get("rows", [[topic]]) for cell in row]
    return {n for cell in cells if isinstance(cell, dict) for n in _long_numbers(cell["text"])}


def find_faults(pages: dict[str, str], topics: Topics) -> list[str]:
    """What is wrong, a line each: a marker without its number or with another one, a number on no page or on two, and
    one that a page quotes though another page owns it. `pages`: text by path. Of the thousands in the files of data one
    is met by chance, two of one file are a quote."""
    faults = []
    owners = defaultdict(list)
    for path, text in pages.items():
        for topic, stands in shown(path, text):
            owners[topic].append(path)
            if topic not in topics:
                faults.append(_no_number(path, topic))
            elif stands != (to_csv if _is_data(path) else to_markdown)(topics[topic]):
                faults.append(f"{path}: {topic} is not what numbers.json says; fill the page with make report")
    here = {path: set() if _is_data(path) else _long_numbers(_MARKER.sub("", text)) for path, text in pages.items()}
    for name, topic in topics.items():
        places, of_report = owners[name], name in REPORT_ONLY
        if len(places) != (0 if of_report else 1):
            faults.append(f"numbers.json: {name} stands in {len(places)} places of the pages, and must in "
                          + ("none: the report shows it" if of_report else "one"))
        elif not of_report:
            for path in (path for path in pages if path != places[0]):
                both = sorted(here[path] & _quoted(topic))
                if len(both) > _is_data(places[0]):
                    faults.append(f"{path}: quotes {', '.join(both)}, of {name}, which stands on {places[0]}: "
                                  "link to it")
    return faults


def _read_pages(pages: list[Path]) -> dict[str, str]:
    return {str(file): file.read_text(encoding="utf-8") for file in pages}


def take(folder: Path, pages: list[Path], numbers: Path = Path("docs/numbers.json")) -> None:
    """Topics of the folder's files into `numbers`, and from there into pages. What is as it was is not written."""
    topics = read_numbers(numbers)
    before = {str(numbers): to_text(topics), **_read_pages(pages)}
    for file in sorted(folder.glob("*.json")):
        topics.update(read_numbers(file))
    filled = {path: fill(path, text, topics) for path, text in before.items() if path != str(numbers)}
    for path, text in {str(numbers): to_text(topics), **filled}.items():
        if text != before[path]:
            write_file(Path(path), text)


def check(pages: list[Path], numbers: Path = Path("docs/numbers.json")) -> None:
    """Raises LabError with what is wrong, a line each."""
    if faults := find_faults(_read_pages(pages), read_numbers(numbers)):
        raise LabError("\n".join(faults))


def runs(topics: Topics) -> str:
    """A table in Markdown: which commands measured which topics, on which machine."""
    measured = defaultdict(list)
    for name in sorted(topics):
        run = tuple(topics[name].get(key, "unknown") for key in ("command", "machine"))
        measured[run].append(name)
    return to_markdown(table("command | machine | topics of docs/numbers.json",
                             ([f"`{command}`", on, ", ".join(names)] for (command, on), names
                              in sorted(measured.items()))))[1:]


# ---- data frames ---------------------------------------------------------------------------------------------------

def frame(topic: Topic) -> pd.DataFrame:
    """A table's values by the names of its columns; a text is itself, and an empty cell of a number is NaN.

    A cell of several values becomes columns "NAME", "NAME (2)", ... A column without a name is "what".
    """
    columns: dict[str, list[Any]] = {}
    for k, name in enumerate(topic["columns"]):
        cells = [row[k] if isinstance(row[k], str) else row[k]["value"] for row in topic["rows"]]
        values = [cell if isinstance(cell, list) else [cell] for cell in cells]
        is_number = not all(isinstance(cell, str) for cell in cells)
        name = name or "what"
        while name in columns:
            name += "'"
        for part in range(max(map(len, values), default=1)):
            columns[name if part == 0 else f"{name} ({part + 1})"] = [
                float("nan") if part >= len(of) or (is_number and of[part] == "") else of[part] for of in values]
    return pd.DataFrame(columns)
