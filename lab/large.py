# SPDX-License-Identifier: GPL-2.0-or-later
"""What large bodies take, on one machine and over ranks of MPI: `make bench-large` calls this with the names of parts,
everything built. Each part writes PART.json into build/report."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, elements, known, large_strain, masks, output_of, own, scan, scenes, specimens, stiffening
from lab.numbers import Topics, error_of, number, read_numbers, write_file, write_topics

_COLUMNS = ["run", "nodes", "factor nonzeros", "operations", "factor CPU s", "blocks CPU s", "columns CPU s",
            "all, elapsed s", "all, CPU s", "peak MB", "stiffness.npy: difference"]


# ---- what runs of haptable-precompute took -------------------------------------------------------------------------

def _short(value: float) -> dict[str, Any]:
    """Two digits of what is below 10, else all before the point."""
    return number(value, f"{value:.2g}" if value < 10 else f"{value:.0f}")


def _row(name: str, folder: Path, first: Path) -> list[Any]:
    """`first`: the folder of the first run of the same body."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
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
    return [name, f"{summary['counts']['nodes']:,}", number(factor["fill"], f"{factor['fill']:.1e}"),
            number(factor["flops"], f"{factor['flops']:.1e}"), _short(stage["factor"]), _short(stage["blocks"]),
            _short(stage["columns"]) if summary["drawing"] == "columns" else "-",
            _short(sum(summary["time_s"].values())),
            _short(sum(ranks["cpu_s"])),
            {"value": peak if len(peak) > 1 else peak[0], "text": ", ".join(f"{round(b / 1e6):,}" for b in peak)},
            difference]


def runs_table(runs: list[tuple[str, Path]]) -> dict[str, Any]:
    """A row a run: its name and the folder that it wrote; differences are those to the first run of the same body."""
    first: dict[str, Path] = {}
    rows = []
    for name, folder in runs:
        body = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["body_hash"]
        rows.append(_row(name, folder, first.setdefault(body, folder)))
    return {"columns": _COLUMNS, "rows": rows}


# ---- parts ---------------------------------------------------------------------------------------------------------

class Runs:
    """Runs of haptable-precompute into folders below `folder`, one after the other."""

    def __init__(self, build: Path, folder: Path) -> None:
        self.build, self.folder = build, folder
        self.done: list[tuple[str, Path]] = []

    def cube(self, side: int, columns: str) -> Path:
        """The scene file of a cube of 30 mm with so many nodes a side, its base held, touchable everywhere."""
        return self.scene(f"cube-{side}", {"generate": "cube", "nodes_per_side": side, "side": 0.03}, 1e-9, columns)

    def scene(self, name: str, mesh: scenes.Scene, held_below_m: float, columns: str) -> Path:
        file = self.folder / f"{name}-{columns}.toml"
        write_file(file, scenes.to_toml({
            "name": name, "mesh": mesh, "material": {"young": 1e4, "poisson": 0.3},
            "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, held_below_m]}], "tables": {"columns": columns}}))
        return file

    def run(self, name: str, scene: Path, *options: str, ranks: int = 0) -> None:
        """`ranks`: of MPI; 0: haptable-precompute without it."""
        print(f"bench: {name}", flush=True)
        into = self.folder / name.translate(str.maketrans(" ,:", "---"))
        program = [str(self.build / "bin/haptable-precompute")]
        if ranks:
            program = ["env", "OMPI_MCA_rmaps_base_oversubscribe=1", "mpirun", "--allow-run-as-root", "--oversubscribe",
                       "-n",
                       str(ranks), f"{program[0]}-mpi"]
        output_of(*program, *options, str(scene), "-o", str(into), "--force", "--quiet")
        self.done.append((name, into))


def _large(runs: Runs) -> str:
    runs.run("mouse", Path("meshes/mouse.toml"))
    cube = runs.cube(30, "surface")
    runs.run("cube of 30 a side, one thread", cube, "--threads", "1")
    runs.run("two threads", cube, "--threads", "2")
    runs.run("columns in double", cube, "--threads", "2", "--column-tolerance", "0")
    runs.run("cube of 63 a side, tolerance 1e-3", runs.cube(63, "none"), "--tolerance", "1e-3")
    if _SCANNED.exists():
        mesh = {"file": str(_SCANNED.resolve()), "scale": 0.001}
        runs.run("pepper, tolerance 1e-3", runs.scene("pepper", mesh, -0.02, "none"), "--tolerance", "1e-3")
    return "precompute-runs"


def _scale(runs: Runs) -> str:
    for side in (12, 20, 25, 30):
        scene = runs.cube(side, "none" if side > 20 else "surface")
        runs.run(f"cube of {side} a side: one machine", scene, "--threads", "1", "--column-tolerance", "0")
        for ranks in (1, 2, 4):
            runs.run(f"{side} a side, ranks: {ranks}", scene, ranks=ranks)
    return "scale-runs"


_RUNS: dict[str, Callable[[Runs], str]] = {"large": _large, "scale": _scale}
_SCANNED = Path("../shared/meshes/pepper_big.vtu")


#: Parts that are measured here, of the topics that are known, a folder and the build folder.
_MEASURED: dict[str, Callable[[Topics, Path, Path], Topics]] = {
    "scan": lambda _, folder, build: scan.filling(scan.read_compressed(_SCANNED), folder / "scan", build),
    "masks": lambda _, folder, build: masks.costs(folder, build),
    "truth": lambda _, folder, build: {"truth": specimens.truth_table(specimens.truths(folder, build))},
    "known": lambda _, folder, build: {"known": known.known_answers(folder / "known", build)},
    "large-strain": large_strain.large_strain,
    "stiffening": stiffening.stiffening,
    "elements": elements.elements,
    "elsewhere": lambda _, folder, build: elements.elsewhere(folder, build)}
PARTS = (*_RUNS, *_MEASURED)


def make(parts: list[str], build: Path) -> None:
    """What large bodies take: parts, one after the other."""
    for part in parts:
        if part not in PARTS:
            raise LabError(f"bench-large: no part {part}; {', '.join(PARTS)}")
    for part in parts:
        out, folder = build / f"report/{part}.json", build / "large"
        own(folder, "measurements")
        if part == "scan" and not _SCANNED.exists():
            print(f"bench-large: {part}: no {_SCANNED}")
        elif part in _MEASURED:
            write_topics(out, _MEASURED[part](read_numbers(Path("docs/numbers.json")), folder, build),
                         f"make bench-large PART={part}")
        else:
            runs = Runs(build, folder)
            topic = _RUNS[part](runs)
            write_topics(out, {topic: runs_table(runs.done)}, f"make bench-large PART={part}")
