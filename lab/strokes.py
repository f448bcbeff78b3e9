# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of docs/STROKES.md, of the counts that haptable-strokes writes: `make strokes`."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from lab.numbers import Topics, count, number, write_topics

Tally = dict[str, Any]
Mode = dict[str, Any]
_SUMMED = ("strokes", "ticks", "contact_ticks", "both_ticks", "limits", "clamped_strokes", "behind_strokes",
           "long_behind_strokes", "passed_motions", "cpu_s")


def source_identity(folder: Path) -> str:
    """A hash of the C sources and headers in a folder, without comments and white space."""
    found = hashlib.blake2b(digest_size=8)
    for file in sorted(p for p in folder.iterdir() if p.suffix in (".c", ".h")):
        text = re.sub(r"/\*.*?(\*/|\Z)|//[^\n]*|\s", "", file.read_text(encoding="utf-8"), flags=re.S)
        found.update(f"{file.name}\0{text}\0".encode())
    return found.hexdigest()


def _sum(tallies: Iterable[Tally]) -> Tally:
    total: Tally = {**dict.fromkeys(_SUMMED, 0), "faults": {}, "most_area": 0.0, "broken": 0}
    for tally in tallies:
        for name in _SUMMED:
            total[name] += tally[name]
        for fault, strokes in tally["faults"].items():
            total["faults"][fault] = total["faults"].get(fault, 0) + strokes
        total["most_area"] = max(total["most_area"], tally["most_area"])
        total["broken"] += len(tally["broken"])
    return total


def kind_of(mode: Mode) -> str:
    return (("two" if mode["fingers"] == 2 else "one") + (", free" if mode["free"] else ", held")
            + (", rings" if mode["rings"] else ""))


def _by(counts: dict[str, Any], way: Callable[[Mode], tuple[str, ...]], bodies: list[Any]) -> dict[tuple[str, ...],
                                                                                                   Tally]:
    """Tallies of these bodies, summed by what `way` tells of a mode."""
    parts: dict[tuple[str, ...], list[Tally]] = {}
    for mode in counts["modes"]:
        parts.setdefault(way(mode), []).extend(body["modes"][mode["name"]] for body in bodies)
    return {name: _sum(tallies) for name, tallies in parts.items()}


def _faults(tally: Tally) -> str:
    """ "0", or "3 lost, 1 jump"; "-" where nothing was stroked."""
    if tally["strokes"] == 0:
        return "-"
    return ", ".join(f"{strokes} {fault}" for fault, strokes in tally["faults"].items() if strokes) or "0"


def _fault_table(counts: dict[str, Any], columns: list[str], way: Callable[[Mode], tuple[str, ...]]) -> dict[str, Any]:
    sums = _by(counts, way, counts["bodies"])
    faults = list(counts["total"]["faults"])
    return {"columns": [*columns, "strokes", *faults],
            "rows": [[*name, count(t["strokes"]), *(count(t["faults"].get(fault, 0)) for fault in faults)]
                     for name, t in sums.items()]}


def _mesh_table(counts: dict[str, Any]) -> dict[str, Any]:
    """A row a mesh with a column a way of touching it, all forces and god-objects together."""
    rows, kinds = [], list(dict.fromkeys(map(kind_of, counts["modes"])))
    for body in counts["bodies"]:
        sums = _by(counts, lambda mode: (kind_of(mode),), [body])
        rows.append([body["name"] + (", filled" if body["filled"] else ""), f"{body['nodes']:,}",
                     count(sum(t["strokes"] for t in sums.values())), *(_faults(sums[kind,]) for kind in kinds)])
    return {"columns": ["mesh", "nodes", "strokes", *kinds], "rows": rows}


def _reason(why: str) -> str:
    """Without the file's path, which the error begins with."""
    head, _, rest = why.partition(": ")
    return rest if rest and "/" in head else why


def _share(part: int, whole: int) -> dict[str, Any]:
    share = part / whole if whole else 0.0
    return number(share, f"{100 * share:.2g} %" if part else "0")


def _design_table(counts: dict[str, Any]) -> dict[str, Any]:
    """What is by design, and how often, by god-object."""
    sums = _by(counts, lambda mode: (mode["god_object"],), counts["bodies"])

    def shares(what: str, part: str) -> list[Any]:
        return [what, *(_share(t[part], t["strokes"]) for t in sums.values())]
    rates = [1e6 * t["limits"] / max(1, t["contact_ticks"]) for t in sums.values()]
    return {"columns": ["by design", *(god_object for god_object, in sums)],
            "rows": [shares("strokes with a tick in free air, the god-object behind a part", "behind_strokes"),
                     shares("and more than 20 such ticks on end", "long_behind_strokes"),
                     ["motions of a tick through a part that were not felt",
                      *(count(t["passed_motions"]) for t in sums.values())],
                     shares("strokes that met `max_force`", "clamped_strokes"),
                     ["limits of walks, slides and searches, in a million ticks in contact",
                      *(number(rate, f"{round(rate):,}") for rate in rates)]]}


def _minutes(s: float) -> dict[str, Any]:
    return number(s, f"{s / 60:.1f} minutes")


def tables(counts: dict[str, Any], firmware: Path = Path("firmware")) -> Topics:
    """counts: as haptable-strokes writes them. firmware: its sources are told by their identity."""
    total, identity = counts["total"], source_identity(firmware)
    each_s = 1e5 * total["cpu_s"] / max(1, total["strokes"])
    return {
        "strokes-firmware": number(int(identity[:8], 16), identity),
        "strokes-count": count(total["strokes"]), "strokes-ticks": count(total["ticks"]),
        "strokes-contact": count(total["contact_ticks"]), "strokes-both": count(total["both_ticks"]),
        "strokes-area": number(total["most_area"], f"{total['most_area'] * 2**24:.2g}"),
        "strokes-broken": count(len(total["broken"])), "strokes-bodies": count(len(counts["bodies"])),
        "strokes-seed": count(counts["seed"]), "strokes-cpu": _minutes(total["cpu_s"]),
        "strokes-cpu-rate": number(each_s, f"{each_s:.0f} s"),
        "strokes-cpu-tables": _minutes(sum(body["tables_cpu_s"] for body in counts["bodies"])),
        "strokes-modes": _fault_table(counts, ["force", "god-object", "friction"], lambda mode: (
            mode["force"], mode["god_object"], "yes" if mode["friction"] else "no")),
        "strokes-kinds": _fault_table(counts, ["fingers and body"], lambda mode: (kind_of(mode),)),
        "strokes-meshes": _mesh_table(counts),
        "strokes-left-out": {"columns": ["left out", "why"],
                             "rows": [[one["name"], _reason(one["why"])] for one in counts["left_out"]]},
        "contact-by-design": _design_table(counts)}


def make(counts: Path, out: Path) -> None:
    """Tables of what haptable-strokes counted."""
    write_topics(out, tables(json.loads(counts.read_text(encoding="utf-8"))), "make strokes")
