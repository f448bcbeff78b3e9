# SPDX-License-Identifier: GPL-2.0-or-later
"""What follows from the configurations that lab.error has measured: the paper's own beside them, which are
best, the front of error against time, the order of the mask's error."""

from __future__ import annotations

import math
from typing import Any

from lab.numbers import Topics, number, seconds, text_of

_BEST = "best in"
_AXES = {"time": "tick", "flash": "flash", "precompute": "precompute"}
_PAPER = "the paper, 1998"
#: Forces of the paper's Table 2 on its Pentium Pro of 200 MHz, s: body, mesh and time. Its equations are those of our
#: point that is interpolated, nearest; so is its error. It had the same counts of nodes and patches, a mouse of its
#: own.
_PAPER_S = {("cube, nu 0.49", "5 a side"): 15e-6, ("mouse", "1,713 nodes"): 12e-6}


def _with_paper(columns: list[str], rows: list[list[Any]]) -> list[list[Any]]:
    """A row of the paper's behind the tables of its body and mesh, before what one would do instead."""
    at = {name: k for k, name in enumerate(columns)}
    made: list[list[Any]] = []
    for (body, mesh), tick_s in _PAPER_S.items():
        same = [i for i, row in enumerate(rows) if (row[0], row[1]) == (body, mesh)
                and row[at["precision"]] != "float64"]
        ours = next((rows[i] for i in same if rows[i][at["force"]] == "interpolated"), None)
        if ours is None:
            continue
        paper = list(ours)
        paper[at["force"]], paper[at["precision"]], paper[at["tick"]] = _PAPER, "", seconds(tick_s)
        paper[at["flash"]] = paper[at["precompute"]] = ""  # it does not tell
        made.append([same[-1], paper])
    for after, paper in sorted(made, key=lambda one: -one[0]):
        rows = [*rows[:after + 1], paper, *rows[after + 1:]]
    return rows


def _best(columns: list[str], rows: list[list[Any]]) -> list[str]:
    """Of each row the costs in which no other finger with a size is better in both, or as good in one and better in the
    other. A point's force goes to zero with the mesh, and is right on one mesh by chance: it is left out."""
    at = {name: k for k, name in enumerate(columns)}

    def value(row: list[Any], column: str) -> float:
        cell = row[at[column]]
        return cell["value"] if isinstance(cell, dict) else math.nan
    sized = [row for row in rows if row[at["force"]] not in ("interpolated", "consistent", _PAPER)]

    def is_best(row: list[Any], column: str) -> bool:
        error, cost = value(row, "error, RMS"), value(row, column)
        return row in sized and not any(
            other[0] == row[0] and value(other, "error, RMS") <= error and value(other, column) <= cost
            and (value(other, "error, RMS") < error or value(other, column) < cost) for other in sized)
    return [", ".join(name for name, column in _AXES.items() if is_best(row, column)) for row in rows]


def _order(columns: list[str], rows: list[list[Any]]) -> list[list[Any]]:
    """How fast the mask's mean error falls on the cubes, and its order from one mesh to the next. Nothing is told by an
    error that is not above the truth's own, or that crosses zero."""
    told = 0.002
    at = {name: k for k, name in enumerate(columns)}
    coarser: dict[tuple[str, str], list[Any]] = {}
    made = []
    for row in rows:
        if [row[at[c]] for c in ("force", "god-object", "precision")] != ["pressure-mask", "nearest", "float32"]:
            continue
        if not row[0].startswith("cube"):
            continue
        element, mesh, mean = row[at["element"]], row[at["mesh"]], row[at["mean error"]]
        order: Any = ""
        last = coarser.get((row[0], element))
        if last is not None:
            before = last[at["mean error"]]["value"]
            if before * mean["value"] > 0 and abs(mean["value"]) > told:
                finer = (int(mesh.split()[0]) - 1) / (int(last[at["mesh"]].split()[0]) - 1)  # "13 a side"
                order = math.log(abs(before / mean["value"])) / math.log(finer)
                order = number(order, f"{order:.1f}")
        made.append([row[0], element, mesh, mean, order])
        coarser[row[0], element] = row
    return made


def derive(topics: Topics) -> None:
    """Adds to `points`, as lab.error leaves it, the paper's rows and "best in", and to `topics` `front` and
    `order`. Leaves points alone that have them."""
    points = topics.get("points")
    if points is None or _BEST in points["columns"]:
        return
    columns = points["columns"]
    rows = _with_paper(columns, points["rows"])
    rows = [[*row, best] for row, best in zip(rows, _best(columns, rows))]
    run = {key: points[key] for key in ("command", "machine") if key in points}
    error = columns.index("error, RMS")
    topics["points"] = {**run, "columns": [*columns, _BEST], "rows": rows}
    front = sorted((row for row in rows if "time" in row[-1]), key=lambda row: (text_of(row[0]), row[error]["value"]))
    topics["front"] = {**run, "columns": [*columns, _BEST], "rows": front}
    topics["order"] = {**run, "columns": ["body", "element", "mesh", "mean error of the mask", "order"],
                       "rows": _order(columns, rows)}
