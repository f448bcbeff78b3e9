# SPDX-License-Identifier: GPL-2.0-or-later
"""Dents that stiffen: the force of the tables beside CalculiX's at large strain, many minutes: `make bench-large
PART=stiffening`.

F = Psi'(e) C^-1 u,   e = 1/2 u . C^-1 u:   u the mean displacement of the nodes under the finger, C and Psi' the
tables' own. CalculiX has the same tetrahedra with Yeoh's material, and gives the force that holds them at u."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, say, scenes
from lab.calculix import Deck, forces
from lab.large_strain import aside
from lab.numbers import Topics, number, percent, table
from lab.reference import Array
from lab.scenes import Scene, touched, vary
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
        return (1.0 if curve is None else curve.factor(0.5 * float(u @ linear))) * linear


def stiffening_scene(body: str) -> Scene:
    """A finger that sticks and is held, so that it goes every way."""
    name, side, radius = BODIES[body]
    cube = {"mesh": {"nodes_per_side": side}, "material": {"poisson": 0.45}} if side else {}
    scene = touched(vary(scenes.read(name), **cube), "pressure-mask", radius, friction=0.5, grab=True)
    return {**vary(scene, name=f"{body}-stiffens", material={"stiffening": {"yeoh": list(YEOH)}}),
            "device": {"max_force": 100.0}}


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


def measure(body: str, folder: Path) -> list[list[Any]]:
    """Rows of the curve: body, place, way, depth, force along the way by CalculiX, and what the tables lack of it. As
    deep as the curve was fitted: so much of the extent, or until the linear force is the limit."""
    scene = stiffening_scene(body)
    tables = folder / scene["name"]
    fit = scenes.precompute(scene, tables)["stiffening"]
    curve = Curve(tuple(fit["curve"]), fit["energy_j"])
    x, tets = read_elements(tables / "mesh.vtu")
    deck = Deck(x, tets, np.flatnonzero(is_held(scene)(x)), scene["material"]["young"], scene["material"]["poisson"],
                large_strain=True, yeoh=YEOH)
    deepest = DEEPEST * float(np.ptp(x, axis=0).min())
    limit = float(np.median([deepest * place["pressed_n_per_m"] for place in fit["by_place"]]))
    rows: list[list[Any]] = []
    for place, finger in enumerate(fingers(tables, [place["node"] for place in fit["by_place"]])):
        n, t = finger.outward, aside(finger.outward)
        for name, way in zip(WAYS, (-n, (t - n) / 2**0.5, t, n)):
            say(f"stiffening: {body}, place {place}, {name}")
            depth = min(deepest, limit / float(np.linalg.norm(finger.stiffness @ way)))
            moved = [depth * level / LEVELS * way for level in range(1, LEVELS + 1)]
            held = forces(deck, finger.nodes, finger.weights, moved, folder / f"{body}-{place}-{name}")
            for u, force in zip(moved, held):
                ours = [finger.force(u, law) for law in (curve, None)]
                rows.append([body, str(place), name, number(float(u @ way), "{:.2f} mm", 1e3),
                             *(number(float(f @ way), "{:.3f} N") for f in (force, *ours)),
                             *(percent(float(np.linalg.norm(f - force) / np.linalg.norm(force)), "{:.1f} %")
                               for f in ours)])
    return rows


def limits(rows: Sequence[list[Any]]) -> list[list[Any]]:
    """A row a body: its deepest dent, and what is off of the linear force and of the stiffened one, root mean square,
    by way and over all; the worst."""
    made: list[list[Any]] = []
    for body in dict.fromkeys(row[0] for row in rows):
        of_body = [row for row in rows if row[0] == body]
        off = [np.array([[row[8]["value"], row[7]["value"]] for row in of_body if row[2] in ways])
               for ways in (*([way] for way in WAYS), WAYS)]
        cells = [*(np.sqrt((one**2).mean(0)) for one in off), off[-1].max(0)]
        made.append([body, number(max(row[3]["value"] for row in of_body), "{:.1f} mm", 1e3),
                     *(number(cell.tolist(), "{:.0f}, {:.1f} %", 100) for cell in cells)])
    return made


def stiffening(_: Topics, folder: Path) -> Topics:
    rows = [row for body in BODIES for row in measure(body, folder)]
    return {"stiffening": table(f"body | to | {' | '.join(WAYS)} | all | worst", limits(rows)),
            "stiffening-curve": table("body | place | way | depth | CalculiX | stiffened | linear | stiffened is off | "
                                      "linear is off", rows)}
