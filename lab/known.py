# SPDX-License-Identifier: GPL-2.0-or-later
"""The elements beside closed forms and beside CalculiX: `make bench-large PART=known`."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
import scipy.optimize

from lab import say, scenes
from lab.calculix import Deck, displacements
from lab.numbers import Topic, error_of, number, percent, table
from lab.reference import Array, Bricks, Footprint, Mesh, Solid, Tetrahedra, graded, hertz, uniform
from lab.scenes import Scene, vary
from lab.specimens import grid, read_elements, read_vtu, reference, write_tetgen

Rows = Iterator[list[Any]]


# ---- half-spaces ---------------------------------------------------------------------------------------------------

def quarter(planes: Sequence[Array], poisson: float, quadratic: bool = False) -> Tetrahedra:
    """[0, W]^2 x [0, H], E = 1, held below, x = 0 and y = 0 planes of symmetry."""
    return Tetrahedra(grid(planes), 1.0, poisson, lambda x: x[:, 2] <= 0.0, quadratic, quarter=True)


def half_space(body: Callable[[Sequence[Array], float], Solid], poisson: float, inner: tuple[int, int],
               outer: tuple[int, int]) -> Array:
    """k (1 - nu^2), E = 1, under discs of radius 1: an even pressure, and Hertz's. The mesh's error falls with its
    square (of bricks it is far below), the block's with its size. Both are extrapolated."""
    def stiffness(size: float, inner: int, outer: int) -> Array:
        across = graded(0.0, size, 0.0, 1.5, inner, outer)
        block = body([across, across, graded(0.0, size, size - 1.5, size, inner, outer)], poisson)
        discs = [block.shares(Footprint(np.array([0.0, 0.0, size]), 1.0, profile)) for profile in (uniform, hertz)]
        return 1.0 / block.compliances(discs)[:, 2, 2]
    small, large = (fine + (fine - coarse) / 3.0 for coarse, fine in
                    ([stiffness(size, *cells) for cells in zip(inner, outer)] for size in (20.0, 40.0)))
    return (2.0 * large - small) * (1.0 - poisson**2)


def _share(value: float) -> Topic:
    return percent(float(value), "{:+.2g} %")


def _half_spaces() -> Rows:
    say("half-spaces")
    for elements, body, nu, inner, outer in (
            ("linear, nu 0.3", quarter, 0.3, (8, 16), (9, 18)),
            ("10-node tetrahedra, nu 0.3", lambda planes, nu: quarter(planes, nu, True), 0.3, (3, 6), (4, 7)),
            *((f"the reference's bricks, nu {nu}", lambda planes, nu: Bricks(planes, 1.0, nu, quarter=True), nu, (3, 6),
               (4, 6)) for nu in (0.3, 0.49))):
        answers = {"a uniform disc": 3.0 * np.pi**2 / 16.0, "Hertz's pressure": 5.0 / 3.0}
        for (what, answer), k in zip(answers.items(), half_space(body, nu, inner, outer)):
            yield [f"half-space under {what}, k (1 - nu^2) / (E a)", elements, number(k, "{:.3f}"),
                   number(answer, "{:.3f}"), _share(k / answer - 1.0)]


# ---- a bonded layer under a sphere ---------------------------------------------------------------------------------

def dimitriadis(chi: float, nu: float) -> float:
    """F of Dimitriadis et al. 2002 over Hertz's, for a layer bonded to its bed; chi = sqrt(R depth) / thickness <=
    1."""
    a = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    b = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    p = np.pi
    return float(1.0 - 2.0 * a / p * chi + 4.0 * a**2 / p**2 * chi**2
                 - 8.0 / p**3 * (a**3 + 4.0 * p**2 / 15.0 * b) * chi**3
                 + 16.0 * a / p**4 * (a**3 + 3.0 * p**2 / 5.0 * b) * chi**4)


_SPHERE = 100.0  # radius, of a layer of thickness 1: so flat that it is a paraboloid


def over_hertz(c: Array, fall: Array, chi: float, nu: float) -> float:
    """F over Hertz's, without friction: nodes under the sphere push, none pulls. c: compliance of a quarter's nodes;
    fall: the sphere's height above them where it begins to touch."""
    depth, root = chi**2 / _SPHERE, scipy.linalg.cholesky(c)
    force, _ = scipy.optimize.nnls(root, scipy.linalg.solve_triangular(root, depth - fall, trans="T"))
    return float(4.0 * force.sum() / (4.0 / 3.0 / (1.0 - nu**2) * np.sqrt(_SPHERE) * depth**1.5))


def layer_over_dimitriadis(chi: float, nu: float) -> float:
    """F over Dimitriadis's, extrapolated over the mesh (its error falls with the square of the edge) and corrected for
    the width. The mean of depths around it: the rim of contact moves from node to node."""
    def mean(width: float, cells: int) -> float:
        """On a quarter that is fine to 1.6 times chi; `cells` along each edge."""
        across = graded(0.0, width, 0.0, 1.6 * chi, cells // 2, cells - cells // 2)
        body = quarter([across, across, np.linspace(0.0, 1.0, cells + 1)], nu)
        r2 = (body.x[:, :2] ** 2).sum(1)
        near = np.flatnonzero((body.x[:, 2] == 1.0) & (r2 < (1.52 * chi) ** 2))
        c, fall = body.inverse(3 * near + 2), r2[near] / (2.0 * _SPHERE)
        return float(np.mean([over_hertz(c, fall, at, nu) / dimitriadis(at, nu)
                              for at in chi * np.linspace(0.94, 1.06, 9)]))
    coarse, fine = mean(5.0, 14), mean(5.0, 28)
    return fine + (fine - coarse) / 3.0 + mean(8.0, 14) - coarse


def _layers() -> Rows:
    say("a bonded layer")
    for chi in (0.25, 0.5, 1.0):
        off, answer = layer_over_dimitriadis(chi, 0.3), dimitriadis(chi, 0.3)
        yield [f"bonded layer under a sphere, F over Hertz's, sqrt(R d) = {chi:g} of it", "linear, nu 0.3",
               number(off * answer, "{:.3f}"), number(answer, "{:.3f}, Dimitriadis 2002"), _share(off - 1.0)]


# ---- CalculiX ------------------------------------------------------------------------------------------------------

def largest_difference(theirs: Array, ours: Array) -> float:
    return float(np.linalg.norm(ours - theirs, axis=1).max() / np.linalg.norm(theirs, axis=1).max())


def pulled_apart(nodes: Any, count: int) -> Array:
    """[count, 3] N: an oblique force on one of the nodes, its opposite on another."""
    forces = np.zeros((count, 3))
    force = np.array([0.03, -0.02, -0.09])
    forces[nodes[len(nodes) // 3]], forces[nodes[2 * len(nodes) // 3]] = force, -0.4 * force
    return forces


def by_columns(folder: Path, forces: Array) -> Array:
    """[N, 3] m of all nodes by the product's tables, columns = "all"."""
    node, rows = np.load(folder / "node_id.npy"), np.load(folder / "row_id.npy")
    columns = np.load(folder / "columns.npy", mmap_mode="r")
    moved = np.zeros_like(forces)
    for i in np.flatnonzero(forces.any(1)):
        moved[rows] += columns[int(np.flatnonzero(node == i)[0])] @ forces[i]
    return moved


def against_calculix(scene: Scene, folder: Path,
                     cards: Callable[[Mesh], tuple[str, str]] = lambda _: ("", "")) -> float:
    """How far the product's displacements are from CalculiX's, on its mesh in `folder`. cards: of the mesh, CalculiX's
    sections and loads."""
    scenes.precompute(vary(scene, tables={"columns": "all"}, contact=None), folder, "--column-tolerance", "0")
    x, elements = read_elements(folder / "mesh.vtu")
    forces, (sections, loads) = pulled_apart(np.load(folder / "node_id.npy"), len(x)), cards(Mesh(x, elements))
    held = np.setdiff1d(np.arange(len(x)), np.load(folder / "row_id.npy"))
    deck = Deck(x, elements, held, scene["material"]["young"], scene["material"]["poisson"], sections=sections,
                loads=loads)
    ours = by_columns(folder, forces) + (np.load(folder / "sag.npy") if "gravity" in scene else 0.0)
    return largest_difference(displacements(deck, [forces], folder / "ccx")[0], ours)


def against_c3d10(scene: Scene, folder: Path) -> float:
    """The same of the reference's 10-node tetrahedra, on the mesh of that folder under the same forces."""
    mesh = read_vtu(folder / "mesh.vtu")
    body = reference(scene, mesh)
    forces = np.zeros_like(body.x)
    forces[:len(mesh.x)] = pulled_apart(np.load(folder / "node_id.npy"), len(mesh.x))
    deck = Deck(body.x, body.elements, body.held, **scene["material"])
    return largest_difference(displacements(deck, [forces], folder / "c3d10")[0], body.solve(forces))


_SIDE, _LENGTH = 0.01, 0.1


def beam() -> Mesh:
    """10 x 10 x 100 mm: ten cubes of 4 x 4 x 4 cells, one upon the other."""
    across = np.linspace(0.0, _SIDE, 5)
    return grid([across, across, np.linspace(0.0, _LENGTH, 41)])


def beam_error(scene: Scene) -> float:
    """Deflection of the beam's end in 10-node tetrahedra over Timoshenko's, less 1. The disc is within the end: a wider
    one would push the sides near it too, and be felt as a shorter beam."""
    body: Solid = reference(scene, beam())
    end = Footprint(np.array([0.5 * _SIDE, 0.5 * _SIDE, _LENGTH]), 0.45 * _SIDE, uniform)
    given = body.compliances([body.shares(end)])[0, 0, 0]
    e, nu = scene["material"]["young"], scene["material"]["poisson"]
    inertia = _SIDE**4 / 12.0
    shear = (12.0 + 11.0 * nu) / (10.0 * (1.0 + nu)) / (e / (2.0 * (1.0 + nu)) * _SIDE**2)
    return float(given / (_LENGTH**3 / (3.0 * e * inertia) + shear * _LENGTH) - 1.0)


def _calculix(folder: Path) -> Rows:
    say("CalculiX")
    c3d10 = "the reference's 10-node tetrahedra"

    def row(what: str, elements: str, answer: str, difference: float) -> list[Any]:
        return [what, elements, "displacements of all nodes", f"CalculiX, {answer}", error_of(difference)]
    for name in ("cube", "mouse", "liver"):
        scene = scenes.read(name)
        yield row(name, "linear", "C3D4", against_calculix(scene, folder / name))
        yield row(name, c3d10, "C3D10", against_c3d10(scene, folder / name))
    scene = {"name": "beam", "mesh": {"file": str(write_tetgen(beam(), folder / "beam").resolve())},
             "material": {"young": 1e4, "poisson": 0.3}, "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]}]}
    yield row("cantilever 1:10", "linear", "C3D4", against_calculix(scene, folder / "beam-c3d4"))
    yield ["cantilever 1:10, deflection of its end", c3d10, "", "Timoshenko", _share(beam_error(scene))]


def known_answers(folder: Path) -> Topic:
    return table("body | elements | measured | known answer | off by",
                 [*_half_spaces(), *_layers(), *_calculix(folder)])
