# SPDX-License-Identifier: GPL-2.0-or-later
"""What follows from the configurations that lab.error has measured: the paper's own beside them, which are
best, the front of error against time, the order of the mask's error."""

import math
from typing import Any

from lab.numbers import Topics, frame, number, seconds, table, text_of

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
    rows = list(rows)
    for (body, mesh), tick_s in _PAPER_S.items():
        same = [i for i, row in enumerate(rows) if row[:2] == [body, mesh] and row[at["precision"]] != "float64"]
        ours = next((rows[i] for i in same if rows[i][at["force"]] == "interpolated"), None)
        if ours is not None:
            theirs = {"force": _PAPER, "precision": "", "tick": seconds(tick_s), "flash": "", "precompute": ""}
            rows.insert(same[-1] + 1, [theirs.get(name, cell) for name, cell in zip(columns, ours)])
    return rows


def _best(points: dict[str, Any]) -> list[str]:
    """Of each row the costs in which no other finger with a size is better in both, or as good in one and better in the
    other. A point's force goes to zero with the mesh, and is right on one mesh by chance: it is left out."""
    found = frame(points)
    sized = found[~found["force"].isin(("interpolated", "consistent", _PAPER))]
    best = [""] * len(found)
    for name, column in _AXES.items():
        for _, body in sized.groupby("body"):
            both = body[["error, RMS", column]].to_numpy(float)
            less, least = both[:, None] <= both, both[:, None] < both  # [other, row, quantity]
            for k in body.index[~(less.all(2) & least.any(2)).any(0)]:
                best[k] += f", {name}" if best[k] else name
    return best


def _order(columns: list[str], rows: list[list[Any]]) -> list[list[Any]]:
    """How fast the mask's mean error falls on the cubes, and its order from one mesh to the next. Nothing is told by an
    error that is not above the truth's own, or that crosses zero."""
    told = 0.002
    coarser: dict[tuple[str, str], tuple[int, float]] = {}
    made = []
    for row in (dict(zip(columns, row)) for row in rows):
        if ([row[c] for c in ("force", "god-object", "precision")] != ["pressure-mask", "nearest", "float32"]
                or not row["body"].startswith("cube")):
            continue
        cells, mean, order = int(row["mesh"].split()[0]) - 1, row["mean error"]["value"], ""  # "13 a side"
        coarse, before = coarser.get((row["body"], row["element"]), (cells, 0.0))
        coarser[row["body"], row["element"]] = cells, mean
        if before * mean > 0 and abs(mean) > told:
            fell = math.log(abs(before / mean)) / math.log(cells / coarse)
            order = number(fell, "{:.1f}")
        made.append([row["body"], row["element"], row["mesh"], row["mean error"], order])
    return made


def derive(topics: Topics) -> None:
    """Adds to `points`, as lab.error leaves it, the paper's rows and "best in", and to `topics` `front` and
    `order`. Leaves points alone that have them."""
    points = topics.get("points")
    if points is None or _BEST in points["columns"]:
        return
    columns = points["columns"]
    rows = _with_paper(columns, points["rows"])
    rows = [[*row, best] for row, best in zip(rows, _best({"columns": columns, "rows": rows}))]
    run = {key: points[key] for key in ("command", "machine") if key in points}
    error = columns.index("error, RMS")
    front = sorted((row for row in rows if "time" in row[-1]), key=lambda row: (text_of(row[0]), row[error]["value"]))
    topics["points"] = {**run, **table([*columns, _BEST], rows)}
    topics["front"] = {**run, **table([*columns, _BEST], front)}
    topics["order"] = {**run, **table("body | element | mesh | mean error of the mask | order", _order(columns, rows))}
