# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of docs/STROKES.md, of the counts that haptable-strokes writes: `make strokes`."""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pandas as pd

from lab.numbers import Topic, Topics, count, number, table, write_topics


def source_identity(folder: Path) -> str:
    """A hash of the C sources and headers in a folder, without comments and white space."""
    found = hashlib.blake2b(digest_size=8)
    for file in sorted(p for p in folder.iterdir() if p.suffix in (".c", ".h")):
        text = re.sub(r"/\*.*?(\*/|\Z)|//[^\n]*|\s", "", file.read_text(encoding="utf-8"), flags=re.S)
        found.update(f"{file.name}\0{text}\0".encode())
    return found.hexdigest()


def kind_of(mode: dict[str, Any]) -> str:
    touching = "tool" if mode["tool"] else "hands" if mode["fingers"] > 2 else "two" if mode["fingers"] == 2 else "one"
    return touching + (", free" if mode["free"] else ", held") + (", rings" if mode["rings"] else "")


def _frame(counts: dict[str, Any]) -> pd.DataFrame:
    """A row a body and mode: what the mode is, its counts, and strokes by fault."""
    return pd.DataFrame([{**{key: mode[key] for key in ("force", "god_object")}, "body": k, "kind": kind_of(mode),
                          "friction": "yes" if mode["friction"] else "no", **tally,
                          **{f"fault {fault}": strokes for fault, strokes in tally["faults"].items()}}
                         for mode in counts["modes"] for k, body in enumerate(counts["bodies"])
                         for tally in [body["modes"][mode["name"]]]])


def _faults(sums: pd.Series, faults: list[str]) -> str:
    """ "0", or "3 lost, 1 jump"; "-" where nothing was stroked."""
    if sums["strokes"] == 0:
        return "-"
    return ", ".join(f"{sums[fault]} {fault.removeprefix('fault ')}" for fault in faults if sums[fault]) or "0"


def _fault_table(tallies: pd.DataFrame, columns: dict[str, str], faults: list[str]) -> Topic:
    """columns: how the page calls what is summed by."""
    sums = tallies.groupby(list(columns), sort=False)[["strokes", *faults]].sum().reset_index()
    return table([*columns.values(), "strokes", *(f.removeprefix("fault ") for f in faults)],
                 [[*row[:len(columns)], *map(count, row[len(columns):])] for row in sums.to_numpy().tolist()])


def _mesh_table(counts: dict[str, Any], tallies: pd.DataFrame, faults: list[str]) -> Topic:
    """A row a mesh with a column a way of touching it, all forces and god-objects together."""
    sums = tallies.groupby(["body", "kind"], sort=False)[["strokes", *faults]].sum()
    kinds = list(dict.fromkeys(tallies["kind"]))
    return table(["mesh", "nodes", "strokes", *kinds],
                 [[body["name"] + (", filled" if body["filled"] else ""), f"{body['nodes']:,}",
                   count(int(sums.loc[k]["strokes"].sum())), *(_faults(sums.loc[k, kind], faults) for kind in kinds)]
                  for k, body in enumerate(counts["bodies"])])


def _reason(why: str) -> str:
    """Without the file's path, which the error begins with."""
    head, _, rest = why.partition(": ")
    return rest if rest and "/" in head else why


def _design_table(tallies: pd.DataFrame) -> Topic:
    """What is by design, and how often, by god-object."""
    sums = tallies.groupby("god_object", sort=False).sum(numeric_only=True)

    def shares(what: str, part: str) -> list[Any]:
        return [what, *(number(share, "{:.2g} %" if share else "0", 100)
                        for share in (sums[part] / sums["strokes"].clip(lower=1)).tolist())]
    rates = (1e6 * sums["limits"] / sums["contact_ticks"].clip(lower=1)).tolist()
    return table(["by design", *sums.index], [
        shares("strokes with a tick in free air, the god-object behind a part", "behind_strokes"),
        shares("and more than 20 such ticks on end", "long_behind_strokes"),
        ["motions of a tick through a part that were not felt", *map(count, sums["passed_motions"].tolist())],
        shares("strokes that met `max_force`", "clamped_strokes"),
        ["limits of walks, slides and searches, in a million ticks in contact",
         *(number(rate, "{:,.0f}") for rate in rates)]])


def _minutes(s: float) -> Topic:
    return number(s, "{:.1f} minutes", 1 / 60)


def tables(counts: dict[str, Any], firmware: Path = Path("firmware")) -> Topics:
    """counts: as haptable-strokes writes them. firmware: its sources are told by their identity."""
    total, identity, tallies = counts["total"], source_identity(firmware), _frame(counts)
    faults = [f"fault {fault}" for fault in total["faults"]]
    each_s = 1e5 * total["cpu_s"] / max(1, total["strokes"])
    return {
        "strokes-firmware": number(int(identity[:8], 16), identity),
        "strokes-count": count(total["strokes"]), "strokes-ticks": count(total["ticks"]),
        "strokes-contact": count(total["contact_ticks"]), "strokes-both": count(total["both_ticks"]),
        "strokes-area": number(total["most_area"], "{:.2g}", 2**24),
        "strokes-broken": count(len(total["broken"])), "strokes-bodies": count(len(counts["bodies"])),
        "strokes-seed": count(counts["seed"]), "strokes-cpu": _minutes(total["cpu_s"]),
        "strokes-cpu-rate": number(each_s, "{:.0f} s"),
        "strokes-cpu-tables": _minutes(sum(body["tables_cpu_s"] for body in counts["bodies"])),
        "strokes-modes": _fault_table(tallies, {"force": "force", "god_object": "god-object", "friction": "friction"},
                                      faults),
        "strokes-kinds": _fault_table(tallies, {"kind": "fingers and body"}, faults),
        "strokes-meshes": _mesh_table(counts, tallies, faults),
        "strokes-left-out": table("left out | why", [[one["name"], _reason(one["why"])] for one in counts["left_out"]]),
        "contact-by-design": _design_table(tallies)}


def make(counts: Path, out: Path) -> None:
    """Tables of what haptable-strokes counted."""
    write_topics(out, tables(json.loads(counts.read_text(encoding="utf-8"))), "make strokes")
