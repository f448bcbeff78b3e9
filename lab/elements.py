# SPDX-License-Identifier: GPL-2.0-or-later
"""What each element is worth beside the body itself: `make bench-large PART="elements elsewhere"`. Its masks'
stiffness, its cost, and how far linear ones lock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from lab import LabError, binding, scenes
from lab.error import ELEMENTS
from lab.numbers import Topics, number, seconds
from lab.reference import Array, Bricks, Footprint, Mesh, Solid, graded
from lab.scenes import Scene
from lab.specimens import (PLACES, Place, cells, cube_body, cube_scene, mesh_of, mesh_places, reference,
                           specimens, spiral, truth_of, write_tetgen)

_DEPTH = 1e-4  # m: on the patch that the place lies on
_NOT_KEPT = 0.4999  # a ratio that docs/numbers.json has no truth of
_RATIOS = (0.3, 0.49, _NOT_KEPT)
_LOCKING_RATIOS = (0.3, 0.45, 0.49, 0.499, 0.4999)


def _percent(share: float) -> dict[str, Any]:
    return number(float(share), f"{100.0 * share:+.1f} %")


def excess(felt: Array, body: Array) -> float:
    """The mean over the fingers of one over the other, less 1."""
    return float(np.mean(felt / body) - 1.0)


class Masked:
    """Scenes of one element under masks of one radius; Poisson's ratio comes later."""

    def __init__(self, scene: Scene, element: str, radius: float, folder: Path, build: Path,
                 haptable: ModuleType) -> None:
        self._scene = {**scene, "mesh": {**scene["mesh"], "element": element}}
        self._radius, self._folder, self._build, self._haptable = radius, folder, build, haptable
        self.nodes = 0
        self.told: float | None = None  #: by the last run: how much a finger feels it too stiff

    def at(self, poisson: float, places: Sequence[Place]) -> Array:
        """n . S n under the fingers, N/m, as the servo has it."""
        summary = scenes.precompute(self._with(poisson, {"force": "pressure-mask", "mask_radius": self._radius}),
                                    self._folder, self._build)
        self.nodes = summary["counts"]["nodes"]
        self.told = summary["element"]["expected_locking"] if summary["element"].get("places") else None
        body = self._haptable.load(self._folder, god_object="nearest", bare=True)
        felt = []
        for place in places:
            path = np.vstack([place.on + _DEPTH * place.outward, place.on - _DEPTH * place.outward])
            touch = body.servo().replay(path)[-1]
            if touch["state"] != 2:
                raise LabError(f"{body.name}: the laboratory's finger lost contact: nothing was measured")
            felt.append(place.outward @ touch["force"] / _DEPTH)
        return np.array(felt)

    def cpu_s(self, poisson: float) -> float:
        """Of the factor and the blocks L_ii, one thread."""
        cost = scenes.precompute(self._with(poisson, {}), self._folder, self._build, "--threads", "1")["cpu_s"]
        return float(cost["analysis"] + cost["factor"] + cost["blocks"])

    def _with(self, poisson: float, contact: dict[str, Any]) -> Scene:
        return {**self._scene, "material": {**self._scene["material"], "poisson": poisson}, "contact": contact}


# ---- worth and locking ---------------------------------------------------------------------------------------------

def _worth(meshes: Sequence[Any], radius: float, topics: Topics, folder: Path, build: Path,
           haptable: ModuleType) -> dict[str, Any]:
    places = spiral((0.015, 0.015, 0.03), 0.008, PLACES)
    print(f"bench: the body itself: cube, nu {_NOT_KEPT}", flush=True)
    nearly: Solid = cube_body(_NOT_KEPT, 10, 3)  # the coarser mesh stands for both
    felt = np.linalg.inv(nearly.compliances([nearly.shares(Footprint(p.on, radius)) for p in places]))[:, 2, 2]
    body = [felt if nu == _NOT_KEPT else np.array([t.normal for t in truth_of(topics, f"cube, nu {nu}")])
            for nu in _RATIOS]
    rows, linear_s = [], {}
    for element in ELEMENTS:
        for meshed in meshes:
            if meshed.side in ((17, 25, 33) if element == "quadratic" else (5, 33)):
                continue
            print(f"bench: elements: {element}, {meshed.name}", flush=True)
            masked = Masked(meshed.scene, element, radius, folder / "elements", build, haptable)
            off = [_percent(excess(masked.at(nu, places), itself)) for nu, itself in zip(_RATIOS, body)]
            cpu_s = masked.cpu_s(0.49)
            if element == "linear":
                linear_s[meshed.side] = cpu_s
            ratio = cpu_s / linear_s[meshed.side] if meshed.side in linear_s else None
            rows.append([f"{element}, {meshed.name}", f"{masked.nodes:,}", *off, seconds(cpu_s),
                         "" if ratio is None else number(ratio, f"{ratio:.1f}")])
    return {"columns": ["element, nodes a side", "nodes", *(f"ratio {nu}" for nu in _RATIOS), "factor and blocks, 0.49",
                        "over linear"], "rows": rows}


def _locking(all_specimens: Sequence[Any], topics: Topics, folder: Path, build: Path,
             haptable: ModuleType) -> dict[str, Any]:
    rows = []
    for specimen in all_specimens:
        places = [truth.place for truth in truth_of(topics, specimen.name)]
        body = specimen.name.split(",")[0]
        for meshed in specimen.meshes:
            if meshed.fineness > 1 or meshed.side in (5, 17):
                continue
            print(f"bench: locking: {body}, {meshed.name}", flush=True)
            linear, quadratic = (Masked(meshed.scene, element, specimen.radius, folder / "locking", build, haptable)
                                 for element in ("linear", "quadratic"))
            for nu in _LOCKING_RATIOS:
                felt = linear.at(nu, places)
                rows.append([f"{body}, {meshed.name}", number(specimen.radius, f"{1e3 * specimen.radius:g} mm"),
                             f"{nu}",
                             "" if linear.told is None else _percent(linear.told),
                             _percent(excess(felt, quadratic.at(nu, places)))])
    return {"columns": ["body, mesh", "finger's radius", "Poisson's ratio", "told by a run",
                        "over quadratic, the same mesh"],
            "rows": rows}


def elements(topics: Topics, folder: Path, build: Path) -> Topics:
    haptable = binding.load(build)
    bodies = [s for s in specimens(False, folder, build) if s.name != "cube, nu 0.49"]  # the other one's mesh
    return {"locking": _locking(bodies, topics, folder, build, haptable),
            "elements": _worth(bodies[0].meshes, bodies[0].radius, topics, folder, build, haptable)}


# ---- other fingers, places and bodies ------------------------------------------------------------------------------

@dataclass(frozen=True)
class Touch:
    """Fingers of one size around one place: a row of the table."""

    place: str
    radius: float
    places: list[Place]


@dataclass(frozen=True)
class Elsewhere:
    """A body, the meshes that are judged on it, and how it is solved without them: on a fine mesh and a coarser one."""

    name: str
    touches: list[Touch]
    scene: Callable[[str], Scene]  #: of an element
    bodies: Callable[[float], Sequence[Callable[[], Solid]]]  #: of a Poisson's ratio


def _normals(body: Solid, touches: Sequence[Touch]) -> list[Array]:
    """n . S n of every touch's fingers, N/m."""
    stiffness = iter(np.linalg.inv(body.compliances([body.shares(Footprint(p.on, t.radius))
                                                     for t in touches for p in t.places])))
    return [np.array([p.outward @ next(stiffness) @ p.outward for p in t.places]) for t in touches]


def _boxes(planes: Callable[[int], Sequence[Array]], finest: int) -> Callable[[float], Sequence[Callable[[], Solid]]]:
    """finest: cells of the fine part of the grid along x and y."""
    def at(nu: float) -> Sequence[Callable[[], Solid]]:
        return [lambda n=n: Bricks(planes(n), 1e4, nu) for n in (finest, finest * 3 // 4)]  # type: ignore[misc]
    return at


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
    return {"name": name, "mesh": {"file": str(write_tetgen(mesh, folder / name).resolve())},
            "material": {"young": 1e4, "poisson": 0.3}, "tables": {"columns": "none"},
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
    return Mesh(np.where(length > 0.0,
                         0.015 * np.abs(x).max(1, keepdims=True) * x / np.where(length > 0.0, length, 1.0), x),
                unit.tets)


def _on_mesh(name: str, scene: Scene, radii: Sequence[float], folder: Path, build: Path) -> Elsewhere:
    """The body itself with one pressure a tetrahedron, on the mesh in eight and on the mesh."""
    where = folder / f"{scene['name']}-mesh"
    mesh = mesh_of(scene, where, build)
    places = mesh_places(reference(scene, mesh), np.load(where / "surface.npy").astype(np.int64), max(radii))

    def bodies(nu: float) -> Sequence[Callable[[], Solid]]:
        ratio = {**scene, "material": {**scene["material"], "poisson": nu}}
        return [lambda m=m: reference(ratio, m(), averaged=True)
                for m in (mesh.in_eight, lambda: mesh)]  # type: ignore[misc]
    return Elsewhere(f"{name}, {len(mesh.x):,} nodes", [Touch(f"{len(places)} places", r, places) for r in radii],
                     lambda _: scene, bodies)


def elsewhere(folder: Path, build: Path) -> Topics:
    haptable = binding.load(build)
    mouse = scenes.read(Path("meshes/mouse.toml"))
    rows = []
    for body in (_cube(), _plate(folder),
                 _on_mesh("ball of 30 mm", _scene("ball", ball_mesh(), -0.009, folder), (0.005, 0.007), folder, build),
                 _on_mesh("mouse", {**mouse, "tables": {"columns": "none"}}, (0.007, 0.010), folder, build)):
        for nu in _RATIOS:
            print(f"bench: {body.name}, Poisson's ratio {nu}", flush=True)
            fine, coarse = (_normals(solid(), body.touches) for solid in body.bodies(nu))
            for touch, itself, coarser in zip(body.touches, fine, coarse):
                felt = [Masked(body.scene(element), element, touch.radius, folder / "elsewhere", build, haptable)
                        .at(nu, touch.places) for element in ELEMENTS]
                mean = float(itself.mean())
                rows.append([body.name, f"{1e3 * touch.radius:g} mm", touch.place, f"{nu}",
                             number(mean, f"{mean:.4g} N/m"),
                             *(_percent(excess(one, itself)) for one in (coarser, *felt))])
    return {"elsewhere": {"columns": ["body", "finger's radius", "where", "Poisson's ratio", "the body itself",
                                      "on a coarser mesh", *ELEMENTS], "rows": rows}}
