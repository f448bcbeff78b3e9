# SPDX-License-Identifier: GPL-2.0-or-later
"""What each part of meshes/liver-capsule.toml is worth: docs/FIRST.md."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, binding, build, scenes
from lab.numbers import count, number, table, write_topics
from lab.scenes import Scene, vary

_STEP_M, _DEPTH_M, _HOLD = 2e-5, 0.005, 100  # a tick at 20 mm/s; the press; ticks of rest


def parts(whole: Scene, held: Scene) -> Iterator[tuple[str, Scene]]:
    """The scene as far as each part, the parts before it being there. `held`: whose [[fixed]] comes first."""
    # The body's own force: no limits.
    scene = {**vary(whole, membrane=None, bed=None, gravity=None, relaxation=None, fixed=held["fixed"]),
             "device": {"max_speed": "off", "max_force_rate": "off", "mean_force": "off"}}
    for name, part in (
            ("held at its back alone", {}),
            ("and in its capsule", {"membrane": whole["membrane"]}),
            ("on its beds, below and at the back, and not held", {"fixed": None, "bed": whole["bed"]}),
            ("sagging, and so another shape", {"gravity": {**whole["gravity"], "prestress": False}}),
            ("with the stress of its weight", {"gravity": whole["gravity"]}),
            ("relaxing", {"relaxation": whole["relaxation"]})):
        scene = vary(scene, **part)
        yield name, scene


def press(body: Any) -> float:
    """N of a finger over the middle of the touchable surface's box that goes straight down, and then rests."""
    vertices = body.rest[np.unique(body.patches)]
    low, high = vertices.min(axis=0), vertices.max(axis=0)

    def down(to: float) -> Any:
        z = np.append(np.arange(high[2] + 0.001, to, -_STEP_M), np.full(_HOLD, to))
        return body.servo().replay(np.column_stack([np.tile(0.5 * (low + high)[:2], (len(z), 1)), z]))
    met = down(low[2])
    met = met[met["state"] == 2]
    if len(met) == 0:
        raise LabError(f"{body.name}: the bench's finger met no surface")
    return float(np.linalg.norm(down(float(met[0]["god_object"][2]) - _DEPTH_M)[-1]["force"].astype(float)))


def make(out: Path) -> None:
    """What each part of meshes/liver-capsule.toml is worth."""
    rows, folder = [], build() / "liver-parts"
    for name, scene in parts(scenes.read("liver-capsule"), scenes.read("liver")):
        summary = scenes.precompute(scene, folder)
        force = press(binding.load().load(folder))
        rows.append([name, number(force, "{:.3f} N"), count(sum(summary["flash"]["table"].values()))])
    write_topics(out, {"liver-parts": table("the liver | force | tables, bytes", rows)})
