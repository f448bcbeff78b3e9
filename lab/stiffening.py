# SPDX-License-Identifier: GPL-2.0-or-later
"""Dents that stiffen: the force of the tables beside CalculiX's at large strain, many minutes: `make bench-large
PART=stiffening`.

F = Psi'(e) C^-1 u,   e = 1/2 u . C^-1 u:   u the mean displacement of the nodes under the finger, C and Psi' the
tables' own. CalculiX has the same tetrahedra with Yeoh's material, and gives the force that holds them at u."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, scenes
from lab.calculix import Deck, forces
from lab.large_strain import aside
from lab.numbers import Topics, number
from lab.reference import Array
from lab.scenes import Scene
from lab.specimens import is_held, read_elements

YEOH = (5.0, 0.0)
LEVELS = 6
DEEPEST = 0.3  #: of the least extent
WAYS = ("pressing", "oblique", "sideways", "pulling")
_EACH = 2  #: places of a body: the first two that the curve was not fitted to

#: Bodies: scene, nodes a side of the cube, radius of the mask (m).
BODIES = {"cube": ("cube", 9, 0.006), "mouse": ("mouse-mask", 0, 0.006), "liver": ("liver", 0, 0.015)}


@dataclass(frozen=True)
class Curve:
    """Psi'."""

    c: tuple[float, float, float]
    energy: float  #: e_0, J

    def factor(self, energy: float) -> float:
        s = min(1.0, max(0.0, energy / self.energy)) ** 0.5
        return 1.0 + s * (self.c[0] + s * (self.c[1] + s * self.c[2]))


@dataclass(frozen=True)
class Finger:
    """A vertex of the tables: nodes under the mask there, and what the linear body answers."""

    outward: Array
    nodes: Array
    weights: Array
    stiffness: Array  #: C^-1 [3, 3], N/m

    def force(self, u: Array, curve: Curve | None) -> Array:
        """N; without a curve the linear one."""
        linear = self.stiffness @ u
        felt: Array = (1.0 if curve is None else curve.factor(0.5 * float(u @ linear))) * linear
        return felt


def stiffening_scene(body: str) -> Scene:
    """A finger that sticks and is held, so that it goes every way."""
    name, side, radius = BODIES[body]
    scene = scenes.read(Path(f"meshes/{name}.toml"))
    scene["name"] = f"{body}-stiffens"
    scene["material"] = {**scene["material"], "stiffening": {"yeoh": list(YEOH)}}
    if side:
        scene["mesh"]["nodes_per_side"] = side
        scene["material"]["poisson"] = 0.45
    scene["contact"] = {"force": "pressure-mask", "mask_radius": radius, "friction": 0.5, "grab": True}
    scene["device"] = {"max_force": 100.0}
    scene["tables"] = {"columns": "none"}
    return scene


def fingers(folder: Path, fitted: Sequence[int]) -> list[Finger]:
    """Vertices that lie between those that the curve was fitted to."""
    vertex = np.load(folder / "vertex_id.npy")
    touchable = np.load(folder / "node_id.npy")
    begin, node, weight = (np.load(folder / f"spread_{part}.npy") for part in ("begin", "node", "weight"))
    x, surface = np.load(folder / "position.npy"), np.load(folder / "patch.npy")
    compliance = np.load(folder / "vertex_compliance.npy")
    found = []
    for k in range(_EACH):
        at = int(touchable[(3 * k + 2) * len(touchable) // (3 * _EACH + 1)])
        if at in fitted:
            raise LabError(f"{folder}: the curve was fitted to node {at}; press another")
        row = int(np.flatnonzero(vertex == at)[0])
        around = x[surface[(surface == at).any(1)]]
        normal = np.cross(around[:, 1] - around[:, 0], around[:, 2] - around[:, 0]).sum(0)
        part = slice(begin[row], begin[row + 1])
        found.append(Finger(normal / np.linalg.norm(normal), node[part], weight[part].astype(float),
                            np.linalg.inv(compliance[row])))
    return found


def felt(deck: Deck, finger: Finger, way: Array, deepest: float, folder: Path) -> list[tuple[Array, Array]]:
    """Displacement [3] m and CalculiX's force [3] N, a level each."""
    moved = [deepest * level / LEVELS * way for level in range(1, LEVELS + 1)]
    return list(zip(moved, forces(deck, finger.nodes, finger.weights, moved, folder)))


def reach(finger: Finger, way: Array, extent: float, force: float) -> float:
    """m: as deep as the curve was fitted: so much of the extent, or until the linear force is the limit."""
    return min(DEEPEST * extent, force / float(np.linalg.norm(finger.stiffness @ way)))


def measure(body: str, folder: Path, build: Path) -> list[list[Any]]:
    """Rows of the curve: body, place, way, depth, force along the way by CalculiX, and what the tables lack of it."""
    scene = stiffening_scene(body)
    tables = folder / scene["name"]
    fit = scenes.precompute(scene, tables, build)["stiffening"]
    curve = Curve(tuple(fit["curve"]), fit["energy_j"])
    x, tets = read_elements(tables / "mesh.vtu")
    deck = Deck(x, tets, np.flatnonzero(is_held(scene)(x)), scene["material"]["young"], scene["material"]["poisson"],
                large_strain=True, yeoh=YEOH)
    extent = float(np.ptp(x, axis=0).min())
    pressed = fingers(tables, [place["node"] for place in fit["by_place"]])
    limit = float(np.median([DEEPEST * extent * place["pressed_n_per_m"] for place in fit["by_place"]]))
    rows: list[list[Any]] = []
    for place, finger in enumerate(pressed):
        n, t = finger.outward, aside(finger.outward)
        for name, way in zip(WAYS, (-n, (t - n) / 2**0.5, t, n)):
            print(f"bench: stiffening: {body}, place {place}, {name}", flush=True)
            deepest = reach(finger, way, extent, limit)
            for u, force in felt(deck, finger, way, deepest, folder / f"{body}-{place}-{name}"):
                off = [float(np.linalg.norm(finger.force(u, law) - force) / np.linalg.norm(force))
                       for law in (curve, None)]
                depth, along = float(u @ way), float(force @ way)
                rows.append([body, str(place), name, number(depth, f"{1e3 * depth:.2f} mm"),
                             number(along, f"{along:.3f} N"),
                             *(number(float(finger.force(u, law) @ way), f"{float(finger.force(u, law) @ way):.3f} N")
                               for law in (curve, None)),
                             *(number(part, f"{100.0 * part:.1f} %") for part in off)])
    return rows


COLUMNS = ["body", "place", "way", "depth", "CalculiX", "stiffened", "linear", "stiffened is off", "linear is off"]


def limits(rows: Sequence[list[Any]]) -> list[list[Any]]:
    """A row a body: its deepest dent, and what is off of the linear force and of the stiffened one, root mean square,
    by way and over all; the worst."""
    table: list[list[Any]] = []
    for body in dict.fromkeys(row[0] for row in rows):
        of_body = [row for row in rows if row[0] == body]
        depth = max(row[3]["value"] for row in of_body)
        cells: list[Any] = [body, number(depth, f"{1e3 * depth:.1f} mm")]

        def cell(linear: float, stiffened: float) -> Any:
            return {"value": [linear, stiffened], "text": f"{100.0 * linear:.0f}, {100.0 * stiffened:.1f} %"}

        for ways in (*([way] for way in WAYS), WAYS):
            off = np.array([[row[8]["value"], row[7]["value"]] for row in of_body if row[2] in ways])
            cells.append(cell(*np.sqrt((off**2).mean(0)).tolist()))
        table.append([*cells, cell(*off.max(0).tolist())])
    return table


def stiffening(_: Topics, folder: Path, build: Path) -> Topics:
    rows = [row for body in BODIES for row in measure(body, folder, build)]
    return {"stiffening": {"columns": ["body", "to", *WAYS, "all", "worst"], "rows": limits(rows)},
            "stiffening-curve": {"columns": COLUMNS, "rows": rows}}
