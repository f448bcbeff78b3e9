# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid sphere pressed into a cube: a sampled tool beside CalculiX's contact on the same tetrahedra, and Hertz."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lab import scenes
from lab.binding import load
from lab.calculix import Deck, Rigid, pressing
from lab.reference import Array
from lab.scenes import Scene
from lab.specimens import read_elements

RADIUS = 0.01
SIDE = 0.03
YOUNG, POISSON = 1e4, 0.3
DEPTHS = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0]) * 1e-3
#: That the sphere stands above the cube before it is pressed: CalculiX begins without contact.
_GAP = 1e-5


def scene(nodes_per_side: int, points: int, angle: float, mask_radius: float) -> Scene:
    """A cube that is held below, touched from above by a sphere about the tool's handle."""
    top = [-1.0, -1.0, SIDE - 1e-6, 1.0, 1.0, 1.0]
    return {"name": f"sphere-{nodes_per_side}",
            "mesh": {"generate": "cube", "nodes_per_side": nodes_per_side, "side": SIDE},
            "material": {"young": YOUNG, "poisson": POISSON},
            "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]}], "touch": [{"box": top}],
            "contact": {"force": "pressure-mask", "mask_radius": mask_radius},
            "tool": {"shape": "sphere", "radius": RADIUS, "points": points, "angle": angle},
            "device": {"max_force": 100.0, "mean_force": "off"}, "tables": {"columns": "none"}}


def hertz(depth: Array) -> Array:
    """N, on a half-space."""
    force: Array = 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * np.sqrt(RADIUS) * depth**1.5
    return force


def cap(angle: float, rings: int, around: int) -> Rigid:
    """Of a sphere about the origin, what lies within an angle of -z, rad."""
    ring, step = np.mgrid[1:rings + 1, 0:around]
    polar, azimuth = (angle / rings * ring).ravel(), (2.0 * np.pi / around * step).ravel()
    x = RADIUS * np.column_stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)])
    def at(r: int, k: int) -> int:
        return 0 if r == 0 else 1 + (r - 1) * around + k % around
    triangles = [(0, at(1, k + 1), at(1, k)) for k in range(around)]
    for r in range(1, rings):
        for k in range(around):
            triangles += [(at(r, k), at(r + 1, k + 1), at(r + 1, k)), (at(r, k), at(r, k + 1), at(r + 1, k + 1))]
    return Rigid(np.vstack([[0.0, 0.0, -RADIUS], x]), np.array(triangles))


def by_calculix(folder: Path) -> Array:
    """N at each of DEPTHS. folder: of the scene's tables; the job is written beside them."""
    x, elements = read_elements(folder / "mesh.vtu")
    deck = Deck(x, elements, np.flatnonzero(x[:, 2] < 1e-9), YOUNG, POISSON)
    sphere = cap(np.radians(60.0), 14, 32)
    above = Rigid(sphere.x + [0.5 * SIDE, 0.5 * SIDE, SIDE + RADIUS + _GAP], sphere.triangles)
    moves = np.outer(DEPTHS + _GAP, [0.0, 0.0, -1.0])
    force: Array = pressing(deck, above, np.flatnonzero(x[:, 2] > SIDE - 1e-9), moves, folder.with_suffix(".ccx"))[:, 2]
    return force


def by_tool(folder: Path, build: Path) -> Array:
    """N at each of DEPTHS, of the scene's tool: pressed by 20 um a tick from above, then at rest for 60 ticks."""
    depth, rest = [-1e-3], []
    for until in DEPTHS.tolist():
        steps = int(np.ceil((until - depth[-1]) / 2e-5))
        depth += np.linspace(depth[-1], until, steps + 1)[1:].tolist() + 60 * [until]
        rest.append(len(depth) - 1)
    handle = np.column_stack([np.full((len(depth), 2), 0.5 * SIDE), SIDE + RADIUS - np.array(depth)])
    felt = load(build).load(str(folder)).tool().replay(handle, np.tile([1.0, 0.0, 0.0, 0.0], (len(depth), 1)))
    force: Array = felt["force"][rest, 2].astype(float)
    return force


def tables(nodes_per_side: int, points: int, angle: float, mask_radius: float, folder: Path, build: Path) -> Path:
    scenes.precompute(scene(nodes_per_side, points, angle, mask_radius), folder, build)
    return folder
