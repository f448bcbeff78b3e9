# SPDX-License-Identifier: GPL-2.0-or-later
"""CalculiX (ccx), another program, on the same nodes and elements under the same forces: decks and their results.

Decks are in millimetres, newtons and megapascals: ccx prints seven digits, and its tolerances suit such numbers."""

import re
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError
from lab.reference import Array, Indices

_MM, _MPA = 1e3, 1e-6


def _line(*values: Any) -> str:
    """Of a card: reals with all their digits."""
    return ",".join(f"{v:.13g}" if isinstance(v, float) else str(v) for v in values)


@dataclass(frozen=True)
class Deck:
    """A body as CalculiX is told of it."""

    x: Array  #: [N, 3] m
    elements: Indices  #: [t, 4] (C3D4) or [t, 10] (C3D10): in scikit-fem's order, and VTK's
    held: Indices
    young: float
    poisson: float
    large_strain: bool = False  #: neo-Hookean, or Yeoh's, geometry as it deforms
    yeoh: tuple[float, float] = (0.0, 0.0)  #: C20 / C10, C30 / C10
    sections: str = ""  #: CalculiX's cards in place of the material and its section
    loads: str = ""  #: and for each load besides it

    def model(self) -> str:
        """Nodes, elements, material and what is held."""
        lines = ["*NODE, NSET=NALL", *(_line(i, *x) for i, x in enumerate((_MM * self.x).tolist(), 1)),
                 f"*ELEMENT, TYPE=C3D{self.elements.shape[1]}, ELSET=EALL",
                 *(_line(e, *nodes) for e, nodes in enumerate((self.elements + 1).tolist(), 1)),
                 "*NSET, NSET=HELD", *(f"{node}," for node in (self.held + 1).tolist())]
        lines += [self.sections.rstrip("\n")] if self.sections else [
            "*MATERIAL, NAME=BODY", *self._material(), "*SOLID SECTION, ELSET=EALL, MATERIAL=BODY"]
        return "\n".join(lines + (["*BOUNDARY", "HELD,1,3"] if len(self.held) else [])) + "\n"

    def _material(self) -> list[str]:
        e, nu = _MPA * self.young, self.poisson
        if not self.large_strain:
            return ["*ELASTIC", _line(e, nu)]
        mu, kappa = e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu))
        if any(self.yeoh):
            higher = (0.5 * mu * ratio for ratio in self.yeoh)
            return ["*HYPERELASTIC, YEOH", _line(0.5 * mu, *higher, 2.0 / kappa, 0.0, 0.0)]
        return ["*HYPERELASTIC, NEO HOOKE", _line(0.5 * mu, 2.0 / kappa)]

    def step(self, forces: Array) -> str:
        at = np.flatnonzero(forces.any(1))
        lines = ["*STEP" + (", NLGEOM, INC=200" if self.large_strain else ""), "*STATIC", "*CLOAD, OP=NEW"]
        lines += [_line(node + 1, c + 1, forces[node, c]) for node in at for c in range(3)]
        # Of the increments the last alone is printed.
        return "\n".join(lines) + "\n" + self.loads + "*NODE PRINT, NSET=NALL, FREQUENCY=1000\nU\n*END STEP\n"


def _results(text: str, folder: Path, parse: Callable[[str], list[Any]], least: int) -> list[Any]:
    """What `parse` finds in what ccx prints of this deck. Raises LabError where ccx is missing, or where it finds less
    than `least`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "job.inp").write_text(text, encoding="utf-8")
    result = folder / "job.dat"
    result.unlink(missing_ok=True)
    try:
        with (folder / "job.log").open("w", encoding="utf-8") as log:
            status = subprocess.run(["ccx", "-i", "job"], cwd=folder, stdout=log, stderr=log, check=False).returncode
    except FileNotFoundError as error:
        raise LabError("ccx: is not there; run sh scripts/setup.sh lab") from error
    found = parse(result.read_text(encoding="utf-8") if result.exists() else "")
    if len(found) < least:
        raise LabError(f"ccx ended with {status} and {len(found)} of {least} results; see {folder / 'job.log'}")
    return found


def _blocks(quantity: str) -> Callable[[str], list[Array]]:
    """Rows of number, x, y, z, in order of the numbers, of each step that prints this quantity."""
    return lambda text: [np.array(block.split(), float).reshape(-1, 4)
                         for block in re.split(rf"^.*{quantity}.*$", text, flags=re.M)[1:]]


def displacements(deck: Deck, loads: Sequence[Array], folder: Path) -> list[Array]:
    """[N, 3] m after each load [N, 3] N, one after the other. At large strain it may end before the last load: there
    are fewer results then. Raises LabError where ccx is missing or ends without a result."""
    return [cells[:, 1:] / _MM for cells in _results(deck.model() + "".join(map(deck.step, loads)), folder,
                                                     _blocks("displacements"), 1 if deck.large_strain else len(loads))]


def forces(deck: Deck, nodes: Indices, weights: Array, moved: Sequence[Array], folder: Path) -> list[Array]:
    """N [3] that hold the weighted mean displacement of the nodes at each of `moved`, m [3], one after the other; the
    deck is of large strain, and there are fewer results where ccx finds no rest."""
    reference = len(deck.x) + 1
    first = np.argsort(-weights, kind="stable")  # the first term is what CalculiX eliminates
    lines = [f"*NODE, NSET=REF\n{reference},0,0,0"]
    for c in (1, 2, 3):
        lines += [f"*EQUATION\n{len(nodes) + 1}", *(_line(nodes[k] + 1, c, weights[k]) for k in first),
                  f"{reference},{c},-1"]
    lines += ["*NSET, NSET=PRESSED", *(f"{node + 1}," for node in nodes)]
    for u in moved:
        lines += ["*STEP, NLGEOM, INC=200\n*STATIC\n*BOUNDARY",
                  *(_line(reference, c, c, _MM * by) for c, by in enumerate(u, 1)),
                  "*NODE PRINT, NSET=PRESSED, FREQUENCY=1000\nRF\n*END STEP"]
    cells = _results(deck.model() + "\n".join(lines) + "\n", folder, _blocks("forces"), 1)
    return [one[:, 1:].sum(0) for one in cells]


def pressing(deck: Deck, x: Array, triangles: Indices, touched: Indices, moves: Array, folder: Path) -> Array:
    """[k, 3] N on a rigid tool of these points and triangles after each of its moves [k, 3] m, one after the other, in
    contact without friction with the deck's touched nodes. The tool is wedges behind its triangles; the contact has 10
    N/mm^3, far above the body's modulus over its size."""
    corner, normal = x[triangles], np.zeros_like(x)
    np.add.at(normal, triangles, np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, None])
    behind = x - 0.1 * np.ptp(x, axis=0).max() * normal / np.linalg.norm(normal, axis=1)[:, None]
    first, elements = len(deck.x) + 1, range(len(deck.elements) + 1, len(deck.elements) + 1 + len(triangles))
    wedges = first + np.column_stack([triangles + len(x), triangles])
    cards = ["*NODE, NSET=TOOL", *(_line(first + i, *p) for i, p in enumerate((_MM * np.vstack([x, behind])).tolist())),
             "*ELEMENT, TYPE=C3D6, ELSET=ETOOL", *(_line(e, *w) for e, w in zip(elements, wedges.tolist())),
             "*MATERIAL, NAME=RIGID", "*ELASTIC", "1,0.3", "*SOLID SECTION, ELSET=ETOOL, MATERIAL=RIGID",
             "*NSET, NSET=TOUCHED", *(f"{node}," for node in (touched + 1).tolist()),
             "*SURFACE, NAME=BODY, TYPE=NODE", "TOUCHED,", "*SURFACE, NAME=FACE", *(f"{e}, S2" for e in elements),
             "*SURFACE INTERACTION, NAME=HARD", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", "10,1e-09",
             "*CONTACT PAIR, INTERACTION=HARD, TYPE=NODE TO SURFACE", "BODY, FACE"]
    for move in moves.tolist():
        cards += ["*STEP, INC=100", "*STATIC", "1., 1., 1e-4, 1.", "*BOUNDARY",
                  *(_line("TOOL", c, c, _MM * part) for c, part in enumerate(move, 1)),
                  "*NODE PRINT, NSET=HELD, TOTALS=ONLY, FREQUENCY=1000", "RF", "*END STEP"]
    totals = _results(deck.model() + "\n".join(cards) + "\n", folder,
                      lambda text: re.findall(r"total force.*\n\s*\n(.*)", text), len(moves))
    return np.array([total.split() for total in totals], float)
