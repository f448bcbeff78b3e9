# SPDX-License-Identifier: GPL-2.0-or-later
"""Rigid tools pressed into a cube: a sampled sphere beside CalculiX's contact on the same tetrahedra and Hertz, a
sampled flat punch and its tilt beside closed forms."""

from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

from lab import binding, scenes
from lab.calculix import Deck, Rigid, pressing
from lab.reference import Array, Bricks, Footprint, graded, uniform
from lab.scenes import Scene, touched, vary
from lab.specimens import cube_scene, read_elements

RADIUS = 0.01
SIDE = 0.03
YOUNG, POISSON = 1e4, 0.3  # of cube_scene
DEPTHS = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0]) * 1e-3
#: That the sphere stands above the cube before it is pressed: CalculiX begins without contact.
_GAP = 1e-5


def scene(nodes_per_side: int, points: int, angle: float, mask_radius: float) -> Scene:
    """A cube that is held below, touched from above by a sphere about the tool's handle."""
    cube = touched(cube_scene(nodes_per_side, POISSON), "pressure-mask", mask_radius)
    return vary(cube, name=f"sphere-{nodes_per_side}",
                tool={"shape": "sphere", "radius": RADIUS, "points": points, "angle": angle},
                device={"max_force": 100.0, "mean_force": "off"})


def hertz(depth: Array) -> Array:
    """N, on a half-space."""
    return 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * np.sqrt(RADIUS) * depth**1.5


def cap(angle: float, rings: int, around: int) -> Rigid:
    """Of a sphere about the origin, what lies within an angle of -z, rad."""
    ring, step = np.mgrid[1:rings + 1, 0:around]
    polar, azimuth = (angle / rings * ring).ravel(), (2.0 * np.pi / around * step).ravel()
    flat = polar * [np.cos(azimuth), np.sin(azimuth)]
    x = RADIUS * np.column_stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)])
    triangles = Delaunay(np.vstack([[0.0, 0.0], flat.T])).simplices[:, ::-1]  # seen from below
    return Rigid(np.vstack([[0.0, 0.0, -RADIUS], x]), triangles)


def by_calculix(folder: Path) -> Array:
    """N at each of DEPTHS. folder: of the scene's tables; the job is written beside them."""
    x, elements = read_elements(folder / "mesh.vtu")
    deck = Deck(x, elements, np.flatnonzero(x[:, 2] < 1e-9), YOUNG, POISSON)
    sphere = cap(np.radians(60.0), 14, 32)
    above = Rigid(sphere.x + [0.5 * SIDE, 0.5 * SIDE, SIDE + RADIUS + _GAP], sphere.triangles)
    moves = np.outer(DEPTHS + _GAP, [0.0, 0.0, -1.0])
    return pressing(deck, above, np.flatnonzero(x[:, 2] > SIDE - 1e-9), moves, folder.with_suffix(".ccx"))[:, 2]


def by_tool(folder: Path) -> Array:
    """N at each of DEPTHS, of the scene's tool: pressed by 20 um a tick from above, then at rest for 60 ticks."""
    depth, rest = [-1e-3], []
    for until in DEPTHS.tolist():
        steps = int(np.ceil((until - depth[-1]) / 2e-5))
        depth += np.linspace(depth[-1], until, steps + 1)[1:].tolist() + 60 * [until]
        rest.append(len(depth) - 1)
    handle = np.column_stack([np.full((len(depth), 2), 0.5 * SIDE), SIDE + RADIUS - np.array(depth)])
    felt = binding.load().load(str(folder)).tool().replay(handle, np.tile([1.0, 0.0, 0.0, 0.0], (len(depth), 1)))
    return felt["force"][rest, 2].astype(float)


def punch(nodes_per_side: int, points: int, radius: float, folder: Path) -> tuple[float, float, float]:
    """Of a flat punch with masks of 0.7 of the spacing: force over 2 a E* d, and the torque of a tilt about x and about
    y over 4/3 a^3 E* theta."""
    mask = 0.7 * float(np.sqrt(2.0 * np.pi / np.sqrt(3.0) / points)) * radius
    disc = {"shape": "disc", "radius": radius, "points": points}
    scenes.precompute({**scene(nodes_per_side, points, 60.0, mask), "tool": disc}, folder)
    tool = binding.load().load(str(folder)).tool()
    deep, tilt, modulus = 0.15 * radius, 0.05, YOUNG / (1.0 - POISSON**2)
    z = SIDE - np.append(np.linspace(-5e-4, deep, int((deep + 5e-4) / 2e-5)), np.full(60, deep))
    handle = np.column_stack([np.full((len(z), 2), 0.5 * SIDE), z])
    flat = tool.replay(handle, np.tile([1.0, 0.0, 0.0, 0.0], (len(z), 1)))[-1]
    half, rest = 0.5 * np.linspace(0.0, tilt, 200), np.tile(handle[-1], (200, 1))
    torque = []
    for axis in (0, 1):
        turn = np.column_stack([np.cos(half), np.zeros((200, 3))])
        turn[:, 1 + axis] = np.sin(half)
        torque.append(float(flat["torque"][axis] - tool.replay(rest, turn)["torque"][-1, axis]))
        tool.replay(rest, turn[::-1])
    tilted = 4.0 / 3.0 * radius**3 * modulus * tilt
    return float(flat["force"][2]) / (2.0 * radius * modulus * deep), torque[0] / tilted, torque[1] / tilted


def stiffening(radius: float) -> float:
    """Of the cube beside a half-space, under a punch: what its size changes of the displacement under an even pressure
    on the same disc, it changes under the punch, whose load is the same from afar."""
    width, height = 0.5 * SIDE / radius, SIDE / radius
    across, down = graded(0.0, width, 0.0, 1.5, 3, 3), graded(0.0, height, height - 1.5, height, 3, 3)
    body = Bricks([across, across, down], 1.0, POISSON, quarter=True)
    disc = Footprint(np.array([0.0, 0.0, height]), 1.0, uniform)
    compliance = float(np.ravel(body.compliances([body.shares(disc)]))[-1]) / (1.0 - POISSON**2)
    return 0.5 / (0.5 + compliance - 16.0 / (3.0 * np.pi**2))


def tables(nodes_per_side: int, points: int, angle: float, mask_radius: float, folder: Path) -> Path:
    scenes.precompute(scene(nodes_per_side, points, angle, mask_radius), folder)
    return folder
