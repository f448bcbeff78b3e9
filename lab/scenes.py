# SPDX-License-Identifier: GPL-2.0-or-later
"""Scene files as dictionaries, for measurements that change a key or two."""

import json
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import tomli_w

from lab import LabError, build
from lab.numbers import write_file

Scene = dict[str, Any]


def read(name: str | Path) -> Scene:
    """A file, or one of meshes/ by its name. The path of its mesh leads there from anywhere; it has no columns."""
    file = name if isinstance(name, Path) else Path(f"meshes/{name}.toml")
    scene = tomllib.loads(file.read_text(encoding="utf-8"))
    if "file" in scene["mesh"]:
        scene["mesh"]["file"] = str((file.parent / scene["mesh"]["file"]).resolve())
    return vary(scene, tables={"columns": "none"})


def vary(scene: Scene, **sections: Any) -> Scene:
    """The scene with other keys in its tables, and other lists; None takes a key, a table or a list away."""
    varied = {**scene}
    for name, keys in sections.items():
        varied[name] = _with({**varied.get(name, {}), **keys}) if isinstance(keys, dict) else keys
    return _with(varied)


def _with(table: Scene) -> Scene:
    return {key: value for key, value in table.items() if value is not None}


def touched(scene: Scene, force: str, radius: float = 0.0, **more: Any) -> Scene:
    """The scene with this whole table [contact]. radius: m, of a mask; points have none."""
    mask = {"mask_radius": radius} if force == "pressure-mask" else {}
    return {**scene, "contact": {"force": force, **mask, **more}}


def summary_of(folder: Path) -> dict[str, Any]:
    """What precompute told of its tables."""
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def precompute(scene: Scene, folder: Path, *options: str, ranks: int = 0) -> dict[str, Any]:
    """Tables of the scene in `folder`, made anew; its summary. The scene's file stands beside it. ranks: of MPI; 0:
    without it. Raises LabError with what the program says."""
    file = folder.with_suffix(".toml")
    write_file(file, tomli_w.dumps(scene))
    program = [str(build() / "bin/haptable-precompute")]
    if ranks:
        program = ["env", "OMPI_MCA_rmaps_base_oversubscribe=1", "mpirun", "--allow-run-as-root", "--oversubscribe",
                   "-n", str(ranks), f"{program[0]}-mpi"]
    ended = subprocess.run([*program, file, "-o", folder, "--force", "--quiet", *options], stderr=subprocess.PIPE,
                           text=True, check=False)
    if ended.returncode != 0:
        raise LabError(f"{ended.stderr.strip()} (haptable-precompute ended with status {ended.returncode})")
    return summary_of(folder)
