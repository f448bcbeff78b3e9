# SPDX-License-Identifier: GPL-2.0-or-later
"""What large bodies take, on one machine and over ranks of MPI: `make bench-large` calls this with the names of parts,
everything built. Each part writes PART.json into build/report."""

import time
import timeit
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, build, elements, known, large_strain, own, say, scan, scenes, specimens, stiffening
from lab.cholmod import one_thread
from lab.numbers import Topic, Topics, count, error_of, number, read_numbers, seconds, table, write_topics
from lab.scenes import summary_of, touched, vary

_SCANNED = Path("../shared/meshes/pepper_big.vtu")


# ---- what runs of haptable-precompute took -------------------------------------------------------------------------

def _short(value: float) -> Topic:
    """Two digits of what is below 10, else all before the point."""
    return number(value, "{:.2g}" if value < 10 else "{:.0f}")


def _row(name: str, folder: Path, first: Path) -> list[Any]:
    """`first`: the folder of the first run of the same body."""
    summary = summary_of(folder)
    if summary["reused"]:
        raise LabError(f"{name}: took an earlier run's tables; compute it with --force")
    stage, factor = summary["cpu_s"], summary["factor"]
    ranks = summary.get("ranks", {"cpu_s": [sum(stage.values())], "peak_bytes": [summary["memory"]["peak_bytes"]]})
    peak = [float(b) for b in ranks["peak_bytes"]]
    difference: Any = ""
    if folder != first:
        ours, theirs = (np.load(f / "stiffness.npy") for f in (folder, first))
        if ours.shape != theirs.shape:
            raise LabError(f"{name}: has other nodes than the first run of its body")
        difference = error_of(float(np.abs(ours - theirs).max() / np.abs(theirs).max()))
    return [name, f"{summary['counts']['nodes']:,}", error_of(factor["fill"]), error_of(factor["flops"]),
            _short(stage["factor"]), _short(stage["blocks"]),
            _short(stage["columns"]) if summary["drawing"] == "columns" else "-",
            _short(sum(summary["time_s"].values())), _short(sum(ranks["cpu_s"])),
            {"value": peak if len(peak) > 1 else peak[0], "text": ", ".join(f"{round(b / 1e6):,}" for b in peak)},
            difference]


def runs_table(runs: list[tuple[str, Path]]) -> Topic:
    """A row a run: its name and the folder that it wrote; differences are those to the first run of the same body."""
    first: dict[str, Path] = {}
    return table("run | nodes | factor nonzeros | operations | factor CPU s | blocks CPU s | columns CPU s | "
                 "all, elapsed s | all, CPU s | peak MB | stiffness.npy: difference",
                 [_row(name, folder, first.setdefault(summary_of(folder)["body_hash"], folder))
                  for name, folder in runs])


# ---- what a pressure mask adds to a run, beside a dense product of as many operations --------------------------------

MASK_COLUMNS = ["body, radius", "nodes", "places", "most nodes under one", "pairs", "operations", "masks", "planned",
                "blocks", "products", "files, C", "all", "dense product", "ratio"]


def dense_rate() -> float:
    """Operations a second of a large dense product, the fastest of three, one thread."""
    one_thread()
    a = np.ones((1000, 1000))
    return 2.0 * len(a)**3 / min(timeit.repeat(lambda: a @ a, timer=time.process_time, number=1, repeat=3))


def mask_row(name: str, scene: scenes.Scene, radius: float, folder: Path, rate: float) -> list[Any]:
    """rate: of dense_rate(). The pairs are planned with the factor's pattern; files are written and checked, as numbers
    and as C."""
    masked = scenes.precompute(touched(scene, "pressure-mask", radius), folder / "with", "--threads", "1")
    plain = scenes.precompute({**scene, "contact": {}}, folder / "without", "--threads", "1")["cpu_s"]
    cost, mask = masked["cpu_s"], masked["contact"]["mask"]

    def more(*stages: str) -> float:
        return max(0.0, sum(cost[stage] - plain[stage] for stage in stages))
    parts = [cost["masks"], more("analysis"), cost["mask_blocks"], cost["mask_products"], more("write", "codegen")]
    flops = mask["flops"] + mask["product_flops"]
    dense_s = flops / rate
    return [f"{name}, {1e3 * radius:g} mm", f"{masked['counts']['nodes']:,}",
            *(count(mask[key]) for key in ("places", "most_nodes", "pairs")), number(flops, "{:.2g}"),
            *map(seconds, (*parts, sum(parts), dense_s)), number(sum(parts) / dense_s, "{:.1f}")]


# ---- parts ---------------------------------------------------------------------------------------------------------

def _run(folder: Path, name: str, scene: scenes.Scene, columns: str, *options: str, ranks: int = 0) -> tuple[str, Path]:
    """The run of that name: its folder below `folder`."""
    say(name)
    into = folder / name.translate(str.maketrans(" ,:", "---"))
    scenes.precompute(vary(scene, tables={"columns": columns}), into, *options, ranks=ranks)
    return name, into


def _cube(side: int) -> scenes.Scene:
    """Of 30 mm with so many nodes a side, its base held, touchable everywhere."""
    return vary(specimens.cube_scene(side, 0.3, top=False), name=f"cube-{side}")


def _large(_: Topics, folder: Path) -> Topics:
    run = partial(_run, folder)
    runs = [run("mouse", scenes.read("mouse"), "surface"),
            run("cube of 30 a side, one thread", _cube(30), "surface", "--threads", "1"),
            run("two threads", _cube(30), "surface", "--threads", "2"),
            run("columns in double", _cube(30), "surface", "--threads", "2", "--column-tolerance", "0"),
            run("cube of 63 a side, tolerance 1e-3", _cube(63), "none", "--tolerance", "1e-3")]
    if _SCANNED.exists():
        pepper = {**specimens.cube_scene(2, 0.3, top=False), "name": "pepper",
                  "mesh": {"file": str(_SCANNED.resolve()), "scale": 0.001},
                  "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, -0.02]}]}
        runs.append(run("pepper, tolerance 1e-3", pepper, "none", "--tolerance", "1e-3"))
    return {"precompute-runs": runs_table(runs)}


def _scale(_: Topics, folder: Path) -> Topics:
    runs, run = [], partial(_run, folder)
    for side in (12, 20, 25, 30):
        what = _cube(side), "none" if side > 20 else "surface"
        runs.append(run(f"cube of {side} a side: one machine", *what, "--threads", "1", "--column-tolerance", "0"))
        runs += [run(f"{side} a side, ranks: {ranks}", *what, ranks=ranks) for ranks in (1, 2, 4)]
    return {"scale-runs": runs_table(runs)}


def _masks(_: Topics, folder: Path) -> Topics:
    """Cubes, and the mouse of meshes/mouse-mask.toml in two elements."""
    mouse, rate, rows = scenes.read("mouse-mask"), dense_rate(), []
    bodies = [("cube", specimens.cube_scene(side, 0.3, top=False), 0.004) for side in (12, 20, 28, 40)]
    bodies += [(f"{mouse['name']}, {element}", vary(mouse, mesh={"element": element}), mouse["contact"]["mask_radius"])
               for element in ("linear", "quadratic")]
    for name, scene, radius in bodies:
        say("masks:", name, scene["mesh"].get("nodes_per_side", ""))
        rows.append(mask_row(name, scene, radius, folder / "masks", rate))
    return {"mask-costs": table(MASK_COLUMNS, rows)}


#: By name: what makes topics, of those that are known, and a folder.
PARTS: dict[str, Callable[[Topics, Path], Topics]] = {
    "large": _large, "scale": _scale,
    "scan": lambda _, folder: scan.filling(specimens.read_vtu(_SCANNED), folder / "scan"),
    "masks": _masks,
    "truth": lambda _, folder: {"truth": specimens.truth_table(folder)},
    "known": lambda _, folder: {"known": known.known_answers(folder / "known")},
    "large-strain": large_strain.large_strain,
    "stiffening": stiffening.stiffening,
    "elements": elements.elements,
    "elsewhere": lambda _, folder: elements.elsewhere(folder)}


def make(parts: list[str]) -> None:
    """What large bodies take: parts, one after the other."""
    for part in parts:
        if part not in PARTS:
            raise LabError(f"bench-large: no part {part}; {', '.join(PARTS)}")
    for part in parts:
        folder = build() / "large"
        own(folder, "measurements")
        if part == "scan" and not _SCANNED.exists():
            print(f"bench-large: {part}: no {_SCANNED}")
            continue
        write_topics(build() / f"report/{part}.json", PARTS[part](read_numbers(), folder),
                     f"make bench-large PART={part}")
