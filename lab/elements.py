# SPDX-License-Identifier: GPL-2.0-or-later
"""What each element is worth beside the body itself: `make bench-large PART="elements elsewhere"`. Its masks'
stiffness, its cost, and how far linear ones lock."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab import binding, say, scenes
from lab.error import ELEMENTS, felt_at
from lab.numbers import Topic, Topics, number, percent, seconds, table
from lab.reference import Array, Bricks, Mesh, Solid, graded
from lab.scenes import Scene, vary
from lab.specimens import (FINE, PLACES, Place, Specimen, cells, cube_body, cube_scene, mesh_of, mesh_places, normals,
                           reference, specimens, spiral, truth_of, write_tetgen)

_DEPTH = 1e-4  # m: on the patch that the place lies on
_NOT_KEPT = 0.4999  # a ratio that docs/numbers.json has no truth of
_RATIOS = (0.3, 0.49, _NOT_KEPT)
_LOCKING_RATIOS = (0.3, 0.45, 0.49, 0.499, 0.4999)


def _excess(felt: Array, body: Array) -> Topic:
    """The mean over the fingers of one over the other, less 1."""
    return percent(float(np.mean(felt / body) - 1.0), "{:+.1f} %")


class Masked:
    """Scenes of one element under masks of one radius; Poisson's ratio comes later."""

    def __init__(self, scene: Scene, element: str, radius: float, folder: Path) -> None:
        self._scene = vary(scene, mesh={"element": element}, contact=None)
        self._radius, self._folder = radius, folder
        self.nodes = 0
        self.told: float | None = None  #: by the last run: how much a finger feels it too stiff

    def at(self, poisson: float, places: Sequence[Place]) -> Array:
        """n . S n under the fingers, N/m, as the servo has it."""
        scene = vary(self._scene, material={"poisson": poisson})
        summary = scenes.precompute(scenes.touched(scene, "pressure-mask", self._radius), self._folder)
        self.nodes = summary["counts"]["nodes"]
        self.told = summary["element"]["expected_locking"] if summary["element"].get("places") else None
        body = binding.load().load(self._folder, god_object="nearest", bare=True)
        return np.array([place.outward @ felt_at(body, place, _DEPTH) / _DEPTH for place in places])

    def cpu_s(self, poisson: float) -> float:
        """Of the factor and the blocks L_ii, one thread."""
        scene = vary(self._scene, material={"poisson": poisson})
        cost = scenes.precompute(scene, self._folder, "--threads", "1")["cpu_s"]
        return float(cost["analysis"] + cost["factor"] + cost["blocks"])


# ---- worth and locking ---------------------------------------------------------------------------------------------

def _worth(cube: Specimen, topics: Topics, folder: Path) -> Topic:
    places = spiral((0.015, 0.015, 0.03), 0.008, PLACES)
    say("the body itself: cube, nu", _NOT_KEPT)  # the coarser mesh stands for both
    body = {nu: normals(cube_body(nu, 10, 3), places, cube.radius) if nu == _NOT_KEPT else
            np.array([t.normal for t in truth_of(topics, f"cube, nu {nu}")]) for nu in _RATIOS}
    rows, linear_s = [], {}
    for element in ELEMENTS:
        for meshed in cube.meshes:
            if meshed.side in ((17, 25, 33) if element == "quadratic" else (5, 33)):
                continue
            say(f"elements: {element}, {meshed.name}")
            masked = Masked(meshed.scene, element, cube.radius, folder / "elements")
            off = [_excess(masked.at(nu, places), itself) for nu, itself in body.items()]
            cpu_s = masked.cpu_s(0.49)
            if element == "linear":
                linear_s[meshed.side] = cpu_s
            rows.append([f"{element}, {meshed.name}", f"{masked.nodes:,}", *off, seconds(cpu_s),
                         number(cpu_s / linear_s[meshed.side], "{:.1f}") if meshed.side in linear_s else ""])
    ratios = " | ".join(f"ratio {nu}" for nu in _RATIOS)
    return table(f"element, nodes a side | nodes | {ratios} | factor and blocks, 0.49 | over linear", rows)


def _locking(bodies: Sequence[Specimen], topics: Topics, folder: Path) -> Topic:
    rows = []
    for specimen in bodies:
        places = [truth.place for truth in truth_of(topics, specimen.name)]
        for meshed in specimen.meshes:
            if meshed.fineness == FINE or meshed.side in (5, 17):
                continue
            name = f"{specimen.name.split(',')[0]}, {meshed.name}"
            say("locking:", name)
            linear, quadratic = (Masked(meshed.scene, element, specimen.radius, folder / "locking")
                                 for element in ("linear", "quadratic"))
            for nu in _LOCKING_RATIOS:
                felt = linear.at(nu, places)
                rows.append([name, number(specimen.radius, "{:g} mm", 1e3), f"{nu}",
                             "" if linear.told is None else percent(linear.told, "{:+.1f} %"),
                             _excess(felt, quadratic.at(nu, places))])
    return table("body, mesh | finger's radius | Poisson's ratio | told by a run | over quadratic, the same mesh", rows)


def elements(topics: Topics, folder: Path) -> Topics:
    bodies = [s for s in specimens(False, folder) if s.name != "cube, nu 0.49"]  # the other one's mesh
    return {"locking": _locking(bodies, topics, folder), "elements": _worth(bodies[0], topics, folder)}


# ---- other fingers, places and bodies ------------------------------------------------------------------------------

@dataclass(frozen=True)
class Touch:
    """Fingers of one size around one place: a row of the table."""

    place: str
    radius: float
    places: list[Place]


@dataclass(frozen=True)
class Elsewhere:
    """A body, the meshes that are judged on it, and how it is solved without them."""

    name: str
    touches: list[Touch]
    scene: Callable[[str], Scene]  #: of an element
    bodies: Callable[[float], Sequence[Solid]]  #: of a Poisson's ratio: on a fine mesh and a coarser one


def _boxes(planes: Callable[[int], Sequence[Array]], finest: int) -> Callable[[float], Sequence[Solid]]:
    """finest: cells of the fine part of the grid along x and y."""
    return lambda nu: [Bricks(planes(n), 1e4, nu) for n in (finest, finest * 3 // 4)]


def _cube() -> Elsewhere:
    """30 mm, 13 nodes a side, of quadratic tetrahedra 9 corners: its middle, 8.5 mm from an edge and from two."""
    def planes(n: int) -> Sequence[Array]:
        across = graded(0.0, 0.03, 0.0, 0.024, n, 2)
        return [across, across, graded(0.0, 0.03, 0.021, 0.03, n // 3, n // 4)]
    touches = [Touch(name, radius, spiral((x, y, 0.03), 0.002, 5)) for radius in (0.0035, 0.005, 0.007)
               for name, x, y in (("middle", 0.015, 0.015), ("8.5 mm from an edge", 0.015, 0.0085),
                                  ("8.5 mm from two edges", 0.0085, 0.0085))]
    return Elsewhere("cube, 13 a side (quadratic: 9)", touches,
                     lambda element: cube_scene(9 if element == "quadratic" else 13, 0.3), _boxes(planes, 16))


def _scene(name: str, mesh: Mesh, held_below: float, folder: Path) -> Scene:
    return {**cube_scene(2, 0.3, top=False), "name": name,
            "mesh": {"file": str(write_tetgen(mesh, folder / name).resolve())},
            "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, held_below]}]}


def _plate(folder: Path) -> Elsewhere:
    """60 mm square, 6 mm thick, glued to its bed, in cells of 2.5 x 2.5 x 2 mm of six tetrahedra each."""
    width, thick = 0.06, 0.006
    unit = cells((24, 24, 3))
    scene = _scene("plate", Mesh(unit.x * (width, width, thick), unit.tets), 1e-9, folder)
    scene["touch"] = [{"box": [-1.0, -1.0, thick - 1e-9, 1.0, 1.0, 1.0]}]
    touches = [Touch(name, radius, spiral((0.03, y, thick), 0.002, 5)) for radius in (0.005, 0.007)
               for name, y in (("middle", 0.03), ("8.5 mm from an edge", 0.0085))]

    def planes(n: int) -> Sequence[Array]:
        return [graded(0.0, width, 0.021, 0.039, n // 2, n // 6), graded(0.0, width, 0.0, 0.039, n, n // 6),
                graded(0.0, thick, 0.0, thick, n // 5, 0)]
    return Elsewhere("plate 60 x 60 x 6 mm, cells of 2.5 mm", touches, lambda _: scene, _boxes(planes, 20))


def ball_mesh() -> Mesh:
    """A ball of 30 mm: a cube's cells, blown up."""
    unit = cells((8, 8, 8))
    x = 2.0 * unit.x - 1.0
    length = np.linalg.norm(x, axis=1, keepdims=True)
    return Mesh(0.015 * np.abs(x).max(1, keepdims=True) * x / np.where(length > 0.0, length, 1.0), unit.tets)


def _on_mesh(name: str, scene: Scene, radii: Sequence[float], folder: Path) -> Elsewhere:
    """The body itself with one pressure a tetrahedron, on the mesh in eight and on the mesh."""
    where = folder / f"{scene['name']}-mesh"
    mesh = mesh_of(scene, where)
    places = mesh_places(scene, mesh, np.load(where / "surface.npy").astype(np.int64), max(radii))

    def bodies(nu: float) -> Sequence[Solid]:
        return [reference(vary(scene, material={"poisson": nu}), of, averaged=True) for of in (mesh.in_eight(), mesh)]
    return Elsewhere(f"{name}, {len(mesh.x):,} nodes", [Touch(f"{len(places)} places", r, places) for r in radii],
                     lambda _: scene, bodies)


def elsewhere(folder: Path) -> Topics:
    rows = []
    for body in (_cube(), _plate(folder),
                 _on_mesh("ball of 30 mm", _scene("ball", ball_mesh(), -0.009, folder), (0.005, 0.007), folder),
                 _on_mesh("mouse", scenes.read("mouse"), (0.007, 0.010), folder)):
        for nu in _RATIOS:
            say(f"{body.name}, Poisson's ratio {nu}")
            fine, coarse = body.bodies(nu)
            for touch in body.touches:
                itself, coarser = (normals(solid, touch.places, touch.radius) for solid in (fine, coarse))
                felt = [Masked(body.scene(element), element, touch.radius, folder / "elsewhere").at(nu, touch.places)
                        for element in ELEMENTS]
                rows.append([body.name, f"{1e3 * touch.radius:g} mm", touch.place, f"{nu}",
                             number(float(itself.mean()), "{:.4g} N/m"),
                             *(_excess(one, itself) for one in (coarser, *felt))])
    return {"elsewhere": table("body | finger's radius | where | Poisson's ratio | the body itself | on a coarser mesh"
                               f" | {' | '.join(ELEMENTS)}", rows)}
