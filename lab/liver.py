# SPDX-License-Identifier: GPL-2.0-or-later
"""What each part of meshes/liver-capsule.toml is worth: docs/LIVER.md."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, binding, scenes
from lab.numbers import count, number, write_topics
from lab.scenes import Scene

_STEP_M, _DEPTH_M, _HOLD = 2e-5, 0.005, 100  # a tick at 20 mm/s; the press; ticks of rest


def parts(whole: Scene, held: Scene) -> Iterator[tuple[str, Scene]]:
    """The scene as far as each part, the parts before it being there. `held`: whose [[fixed]] comes first."""
    scene = copy.deepcopy(whole)
    for key in ("membrane", "bed", "gravity", "relaxation"):
        del scene[key]
    scene["tables"] = {"columns": "none"}
    # The body's own force.
    scene["device"] = {"max_speed": "off", "max_force_rate": "off", "mean_force": "off"}
    scene["fixed"] = held["fixed"]
    yield "held at its back alone", scene
    scene["membrane"] = whole["membrane"]
    yield "and in its capsule", scene
    del scene["fixed"]
    scene["bed"] = whole["bed"]
    yield "on its beds, below and at the back, and not held", scene
    scene["gravity"] = {**whole["gravity"], "prestress": False}
    yield "sagging, and so another shape", scene
    scene["gravity"] = whole["gravity"]
    yield "with the stress of its weight", scene
    scene["relaxation"] = whole["relaxation"]
    yield "relaxing", scene


def press(body: Any) -> float:
    """N of a finger over the middle of the touchable surface's box that goes straight down, and then rests."""
    vertices = body.rest[np.unique(body.patches)]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    finger = np.array([*(0.5 * (low + high))[:2], high[2] + 0.001])
    servo = body.servo()
    touch = servo.step(finger)
    while not touch and finger[2] > low[2]:
        finger[2] = max(low[2], finger[2] - _STEP_M)
        touch = servo.step(finger)
    if not touch:
        raise LabError(f"{body.name}: the bench's finger met no surface")
    deepest = float(touch.god_object[2]) - _DEPTH_M
    while finger[2] > deepest:
        finger[2] = max(deepest, finger[2] - _STEP_M)
        servo.step(finger)
    for _ in range(_HOLD):
        touch = servo.step(finger)
    return float(np.linalg.norm(touch.force.astype(float)))


def make(build: Path, out: Path) -> None:
    """What each part of meshes/liver-capsule.toml is worth."""
    haptable = binding.load(build)
    meshes = Path("meshes")
    rows = []
    whole = scenes.read(meshes / "liver-capsule.toml")
    for name, scene in parts(whole, scenes.read(meshes / "liver.toml")):
        folder = build / "liver-parts"
        summary = scenes.precompute(scene, folder, build)
        force = press(haptable.load(folder))
        rows.append([name, number(force, f"{force:.3f} N"), count(sum(summary["flash"]["table"].values()))])
    write_topics(out, {"liver-parts": {"columns": ["the liver", "force", "tables, bytes"], "rows": rows}})
