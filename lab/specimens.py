# SPDX-License-Identifier: GPL-2.0-or-later
"""The bodies that speed and error are measured on: their meshes, the places that are pressed, and how stiff the body
itself is there."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, scenes
from lab.numbers import Topics, number
from lab.reference import Array, Bricks, Footprint, Indices, Mesh, Solid, Tetrahedra, graded, positive
from lab.scenes import Scene

PLACES = 12
_COARSE, _MIDDLE, _FINE = range(3)


# ---- meshes --------------------------------------------------------------------------------------------------------

def read_array(file: Path, name: str) -> Array:
    """An array of a VTU file that haptable-precompute drew, as one row."""
    found = re.search(rf'Name="{name}"[^>]*>([^<]*)<', file.read_text(encoding="utf-8"))
    if found is None:
        raise LabError(f"{file}: has no array {name}; make the tables again")
    return np.array(found[1].split(), float)


def read_elements(file: Path) -> tuple[Array, Indices]:
    """Nodes [N, 3] m and tetrahedra that haptable-precompute drew: [t, 4], or [t, 10] with the nodes between 01 12 20
    03 13 23."""
    types = read_array(file, "types")
    nodes = 10 if (types == 24).any() else 4
    tets = read_array(file, "connectivity").astype(np.int64)[:nodes * int(np.isin(types, (10, 24)).sum())]
    return read_array(file, "Points").reshape(-1, 3), tets.reshape(-1, nodes)


def read_vtu(file: Path) -> Mesh:
    """A mesh of linear tetrahedra."""
    return Mesh(*read_elements(file))


def mesh_of(scene: Scene, folder: Path, build: Path) -> Mesh:
    """Of linear tetrahedra, by a run of haptable-precompute into `folder`."""
    plain = {**scene, "mesh": {k: v for k, v in scene["mesh"].items() if k != "element"},
             "contact": {}, "tables": {"columns": "none"}}
    scenes.precompute(plain, folder, build)
    return read_vtu(folder / "mesh.vtu")


def write_tetgen(mesh: Mesh, file: Path) -> Path:
    """NAME.node and NAME.ele; the first of them."""
    file.parent.mkdir(parents=True, exist_ok=True)
    node, ele = file.with_suffix(".node"), file.with_suffix(".ele")
    node.write_text(f"{len(mesh.x)} 3 0 0\n" + "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in
                                                        enumerate(mesh.x.tolist())), encoding="utf-8")
    ele.write_text(f"{len(mesh.tets)} 4 0\n" + "".join(f"{i} {a} {b} {c} {d}\n" for i, (a, b, c, d) in
                                                       enumerate(mesh.tets.tolist())), encoding="utf-8")
    return node


def cells(count: Sequence[int]) -> Mesh:
    """A unit cube of cells, each cut into six tetrahedra along its diagonal: count of them along x, y, z."""
    nx, ny, nz = count
    number_of = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nz + 1, ny + 1, nx + 1)
    low = np.array(np.meshgrid(range(nz), range(ny), range(nx), indexing="ij")).reshape(3, -1)
    tets = []
    for way in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        at, corners = low.copy(), []
        for axis in (None, *way):
            if axis is not None:
                at[2 - axis] += 1
            corners.append(number_of[tuple(at)])
        tets.append(np.stack(corners, 1))
    z, y, x = np.indices(number_of.shape).reshape(3, -1)
    points = np.stack([x / nx, y / ny, z / nz], 1)
    return Mesh(points, positive(points, np.stack(tets, 1).reshape(-1, 4)))


def grid(planes: Sequence[Array]) -> Mesh:
    """The cells between planes in five tetrahedra each, neighbours mirrored."""
    nx, ny, nz = (len(p) for p in planes)
    corner = np.arange(nx * ny * nz).reshape(nz, ny, nx)
    tets = []
    fives = {0: ("000", ("000", "110", "101", "011")), 1: ("100", ("100", "010", "001", "111"))}
    k, j, i = np.indices((nz - 1, ny - 1, nx - 1)).reshape(3, -1)

    def node(x: int, y: int, z: int) -> Indices:
        return corner[k + z, j + y, i + x]
    for parity, (_, ends) in fives.items():
        here = (i + j + k) % 2 == parity
        ends_at = [tuple(int(c) for c in e) for e in ends]
        inner = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1) if (x, y, z) not in ends_at]
        tets.append(np.stack([node(*p)[here] for p in inner], 1))
        for e in ends_at:
            beside = [tuple(1 - v if c == a else v for a, v in enumerate(e)) for c in range(3)]
            tets.append(np.stack([node(*p)[here] for p in (e, *beside)], 1))
    z, y, x = np.indices(corner.shape).reshape(3, -1)
    points = np.stack([planes[0][x], planes[1][y], planes[2][z]], 1)
    return Mesh(points, positive(points, np.vstack(tets)))


# ---- bodies --------------------------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Meshed:
    """One mesh of a body."""

    name: str  #: "13 a side", "1,713 nodes"
    scene: Scene  #: without columns
    fineness: int
    side: int = 0  #: nodes a side of a cube


@dataclass(frozen=True)
class Specimen:
    name: str
    radius: float  #: m, of the finger's footprint, and of the mask
    meshes: list[Meshed] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    on: Array  #: [3] m, on the surface at rest
    outward: Array  #: [3] unit normal


@dataclass(frozen=True)
class Truth:
    """What stands for the body: elements on a mesh that no configuration has, and on a coarser one."""

    place: Place
    stiffness: Array  #: S [3, 3], N/m: the finger feels -S u
    coarser: float = 0.0  #: relative change of n . S n on the coarser mesh

    @property
    def normal(self) -> float:
        """n . S n, N/m."""
        return float(self.place.outward @ self.stiffness @ self.place.outward)

    def force(self, slides: bool, depth: float) -> Array:
        """N. A finger that is held on the surface, as by the nearest god-object, meets S u. One that slides without
        friction, as with least energy, gives way along the surface: depth / (n . C n) along the normal."""
        n = self.place.outward
        return depth / (n @ np.linalg.inv(self.stiffness) @ n) * n if slides else depth * self.stiffness @ n


def cube_scene(side: int, poisson: float, top: bool = True) -> Scene:
    """The paper's cube of 30 mm, held at its base; its top may be touched, or all of it."""
    scene: Scene = {"name": f"cube{side}-{100 * poisson:.0f}",
                    "mesh": {"generate": "cube", "nodes_per_side": side, "side": 0.03},
                    "material": {"young": 1e4, "poisson": poisson},
                    "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]}], "tables": {"columns": "none"}}
    if top:
        scene["touch"] = [{"box": [-1.0, -1.0, 0.03 - 1e-9, 1.0, 1.0, 1.0]}]
    return scene


def _cubes(poisson: float, quick: bool) -> Specimen:
    sides = [side for side in (5, 9, 13, 17, 25, 33) if not quick or side <= 13]
    return Specimen(f"cube, nu {poisson}", 0.005, [
        Meshed(f"{side} a side", cube_scene(side, poisson), _FINE if side > 17 else _MIDDLE if side > 9 else _COARSE,
               side)
        for side in sides])


def _from_file(name: str, radius: float, quick: bool, folder: Path, build: Path) -> Specimen:
    """A scene of meshes/ as it is, and with its tetrahedra in eight."""
    scene = scenes.read(Path(f"meshes/{name}.toml"))
    scene["tables"] = {**scene.get("tables", {}), "columns": "none"}
    mesh = mesh_of(scene, folder / f"{name}-mesh", build)
    meshes = [Meshed(f"{len(mesh.x):,} nodes", scene, _MIDDLE)]
    if not quick:
        fine = mesh.in_eight()
        file = write_tetgen(fine, folder / f"{name}-in-eight")
        meshes.append(Meshed(f"{len(fine.x):,} nodes", {**scene, "name": f"{name}-in-eight",
                                                         "mesh": {"file": str(file.resolve())}}, _FINE))
    return Specimen(name, radius, meshes)


def specimens(quick: bool, folder: Path, build: Path) -> list[Specimen]:
    """The cubes (nu 0.3 and 0.49), the mouse and the liver; quick: with fewer meshes. Files are written into folder."""
    return [_cubes(0.3, quick), _cubes(0.49, quick), _from_file("mouse", 0.010, quick, folder, build),
            _from_file("liver", 0.015, quick, folder, build)]


def is_held(scene: Scene) -> Any:
    """Of points [N, 3]: whether a box of the scene holds them."""
    boxes = [np.array(fixed["box"]) for fixed in scene["fixed"]]
    return lambda x: np.any([((x >= b[:3]) & (x <= b[3:])).all(1) for b in boxes], axis=0)


def reference(scene: Scene, mesh: Mesh, quadratic: bool = True, averaged: bool = False) -> Tetrahedra:
    material = scene["material"]
    return Tetrahedra(mesh, material["young"], material["poisson"], is_held(scene), quadratic, averaged)


# ---- places --------------------------------------------------------------------------------------------------------

def spiral(middle: Sequence[float], width: float, count: int) -> list[Place]:
    """On a plane that faces +z: no mesh has its nodes there."""
    k = np.arange(count)
    r, angle = 0.5 * width * np.sqrt((k + 0.5) / count), 2.399963 * k  # the golden angle
    return [Place(np.array(middle) + (x, y, 0.0), np.array([0.0, 0.0, 1.0]))
            for x, y in zip(r * np.cos(angle), r * np.sin(angle))]


def mesh_places(body: Tetrahedra, surface: Indices, radius: float) -> list[Place]:
    """Twelve points of a mesh's patches around which its surface is free and nearly flat as far as the finger reaches.
    surface: [q, 3], in the order that the points are drawn in."""
    held = np.zeros(len(body.x), bool)
    held[body.held] = True
    nodes = np.column_stack([surface, *(body.mesh.middle(surface[:, c], surface[:, (c + 1) % 3]) for c in range(3))])
    a, b, c = (body.x[surface[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    random = np.random.RandomState(3)._bit_generator
    places: list[Place] = []
    for _ in range(10000):
        t = int(random.random_raw()) % len(surface)
        alpha = np.array([1.0 + int(random.random_raw()) % 1000 for _ in range(3)])
        place = Place(alpha / alpha.sum() @ body.x[surface[t]], normal[t])
        near = np.linalg.norm(body.x[nodes] - place.on, axis=2) < 1.2 * radius
        if not (near & ((normal @ place.outward < 0.7)[:, None] | held[nodes])).any():
            places.append(place)
        if len(places) == PLACES:
            return places
    raise LabError(f"a mesh of {len(body.mesh.x)} nodes: no places for the laboratory to press; take a smaller finger")


# ---- the body itself -----------------------------------------------------------------------------------------------

def cube_body(poisson: float, inner: int, outer: int) -> Bricks:
    across = graded(0.0, 0.03, 0.006, 0.024, inner, outer)
    return Bricks([across, across, graded(0.0, 0.03, 0.021, 0.03, inner // 2, outer + 1)], 1e4, poisson)


def solve_truth(bodies: Sequence[Any], places: Sequence[Place], radius: float) -> list[Truth]:
    """bodies: the finer one last. Minutes."""
    stiffness = []
    for body in bodies:
        solid: Solid = body()
        stiffness.append(np.linalg.inv(solid.compliances([solid.shares(Footprint(p.on, radius)) for p in places])))
    truths = [Truth(place, s) for place, s in zip(places, stiffness[-1])]
    return [Truth(t.place, t.stiffness, Truth(t.place, s).normal / t.normal - 1.0) for t,
            s in zip(truths, stiffness[0])]


def truths(folder: Path, build: Path) -> list[tuple[str, list[Truth]]]:
    solved = []
    for specimen in specimens(True, folder, build):
        scene = specimen.meshes[0].scene
        print(f"bench: the body itself: {specimen.name}", flush=True)
        if specimen.meshes[0].side:
            nu = scene["material"]["poisson"]
            bodies = [lambda: cube_body(nu, 10, 3), lambda: cube_body(nu, 14, 4)]  # noqa: B023
            places = spiral((0.015, 0.015, 0.03), 0.008, PLACES)
        else:
            mesh = read_vtu(folder / f"{specimen.name}-mesh/mesh.vtu")
            bodies = [lambda: reference(scene, mesh), lambda: reference(scene, mesh.in_eight())]  # noqa: B023
            surface = np.load(folder / f"{specimen.name}-mesh/surface.npy").astype(np.int64)
            places = mesh_places(bodies[0](), surface, specimen.radius)
        solved.append((specimen.name, solve_truth(bodies, places, specimen.radius)))
    return solved


def truth_table(solved: list[tuple[str, list[Truth]]]) -> dict[str, Any]:
    rows = []
    for name, of_body in solved:
        for t in of_body:
            x, s = t.place.on, t.stiffness
            rows.append([name,
                         {"value": [*x, *t.place.outward], "text": ", ".join(f"{1e3 * v:.1f}" for v in x) + " mm"},
                         {"value": [s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]],
                          "text": f"{t.normal:.1f} N/m"},
                         number(t.coarser, f"{100.0 * t.coarser:+.2f} %")])
    return {"columns": ["body", "place", "stiffness along the normal", "on the coarser mesh"], "rows": rows}


def truth_of(topics: Topics, specimen: str) -> list[Truth]:
    """As docs/numbers.json has it. Raises LabError where a specimen has none."""
    found = []
    for name, place, stiffness, coarser in topics.get("truth", {"rows": []})["rows"]:
        if name != specimen:
            continue
        x, (xx, yy, zz, xy, yz, zx) = np.array(place["value"]), stiffness["value"]
        found.append(Truth(Place(x[:3], x[3:]), np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]), coarser["value"]))
    if not found:
        raise LabError(f"{specimen}: docs/numbers.json has no truth of it; run make bench-large PART=truth")
    return found
