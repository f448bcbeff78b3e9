# SPDX-License-Identifier: GPL-2.0-or-later
"""The bodies that speed and error are measured on: their meshes, the places that are pressed, and how stiff the body
itself is there."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from lab import LabError, say, scenes
from lab.numbers import Topic, Topics, percent, table
from lab.reference import Array, Bricks, Footprint, Indices, Mesh, Solid, Tetrahedra, graded, positive
from lab.scenes import Scene, vary

PLACES = 12
COARSE, MIDDLE, FINE = range(3)


# ---- meshes --------------------------------------------------------------------------------------------------------

def read_elements(file: Path) -> tuple[Array, Indices]:
    """Nodes [N, 3] m and tetrahedra that haptable-precompute drew: [t, 4], or [t, 10] with the nodes between 01 12 20
    03 13 23."""
    mesh = meshio.read(file)
    return mesh.points, mesh.cells_dict["tetra10" if "tetra10" in mesh.cells_dict else "tetra"].astype(np.int64)


def read_vtu(file: Path) -> Mesh:
    """A mesh of linear tetrahedra."""
    x, tets = read_elements(file)
    return Mesh(x, positive(x, tets))


def mesh_of(scene: Scene, folder: Path) -> Mesh:
    """Of linear tetrahedra, by a run of haptable-precompute into `folder`."""
    scenes.precompute(vary(scene, mesh={"element": None}, contact=None, tables={"columns": "none"}), folder)
    return read_vtu(folder / "mesh.vtu")


def write_tetgen(mesh: Mesh, file: Path) -> Path:
    """NAME.node and NAME.ele; the first of them."""
    file.parent.mkdir(parents=True, exist_ok=True)
    meshio.write(file.with_suffix(".node"), meshio.Mesh(mesh.x, {"tetra": mesh.tets}))
    return file.with_suffix(".node")


def cells(count: Sequence[int]) -> Mesh:
    """A unit cube of cells, each cut into six tetrahedra along its diagonal: count of them along x, y, z."""
    nx, ny, nz = count
    z, y, x = np.indices((nz + 1, ny + 1, nx + 1)).reshape(3, -1)
    low = np.flatnonzero((x < nx) & (y < ny) & (z < nz))
    steps = np.array([1, nx + 1, (nx + 1) * (ny + 1)])
    ways = [np.cumsum([0, *steps[list(way)]]) for way in itertools.permutations(range(3))]
    points = np.stack([x / nx, y / ny, z / nz], 1)
    return Mesh(points, positive(points, (low[:, None, None] + np.array(ways)).reshape(-1, 4)))


def grid(planes: Sequence[Array]) -> Mesh:
    """The cells between planes in five tetrahedra each, neighbours mirrored."""
    nx, ny, nz = (len(p) for p in planes)
    number_of = np.arange(nx * ny * nz).reshape(nz, ny, nx)
    k, j, i = np.indices((nz - 1, ny - 1, nx - 1)).reshape(3, -1)
    corners, tets = np.indices((2, 2, 2)).reshape(3, -1).T, []
    for parity in (0, 1):
        here = (i + j + k) % 2 == parity
        is_end = corners.sum(1) % 2 == parity
        beside = [[end, *(end ^ np.eye(3, dtype=int))] for end in corners[is_end]]
        for tet in (corners[~is_end], *beside):
            tets.append(np.stack([number_of[k + z, j + y, i + x][here] for x, y, z in tet], 1))
    z, y, x = np.indices(number_of.shape).reshape(3, -1)
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
    return vary({"name": f"cube{side}-{100 * poisson:.0f}",
                 "mesh": {"generate": "cube", "nodes_per_side": side, "side": 0.03},
                 "material": {"young": 1e4, "poisson": poisson},
                 "fixed": [{"box": [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]}], "tables": {"columns": "none"}},
                touch=[{"box": [-1.0, -1.0, 0.03 - 1e-9, 1.0, 1.0, 1.0]}] if top else None)


def _cubes(poisson: float, quick: bool) -> Specimen:
    return Specimen(f"cube, nu {poisson}", 0.005, [
        Meshed(f"{side} a side", cube_scene(side, poisson), fineness, side)
        for side, fineness in ((5, COARSE), (9, COARSE), (13, MIDDLE), (17, MIDDLE), (25, FINE), (33, FINE))
        if not quick or side <= 13])


def _from_file(name: str, radius: float, quick: bool, folder: Path) -> Specimen:
    """A scene of meshes/ as it is, and with its tetrahedra in eight."""
    scene = scenes.read(name)
    mesh = mesh_of(scene, folder / f"{name}-mesh")
    meshes = [Meshed(f"{len(mesh.x):,} nodes", scene, MIDDLE)]
    if not quick:
        fine = mesh.in_eight()
        file = write_tetgen(fine, folder / f"{name}-in-eight")
        meshes.append(Meshed(f"{len(fine.x):,} nodes", {**scene, "name": f"{name}-in-eight",
                                                        "mesh": {"file": str(file.resolve())}}, FINE))
    return Specimen(name, radius, meshes)


def specimens(quick: bool, folder: Path) -> list[Specimen]:
    """The cubes (nu 0.3 and 0.49), the mouse and the liver; quick: with fewer meshes. Files are written into folder."""
    return [_cubes(0.3, quick), _cubes(0.49, quick), _from_file("mouse", 0.010, quick, folder),
            _from_file("liver", 0.015, quick, folder)]


def is_held(scene: Scene) -> Callable[[Array], Any]:
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


def mesh_places(scene: Scene, mesh: Mesh, surface: Indices, radius: float) -> list[Place]:
    """Twelve points of a mesh's patches around which its surface is free and nearly flat as far as the finger reaches.
    surface: [q, 3], in the order that the points are drawn in."""
    corner = mesh.x[surface]
    points = np.concatenate([corner, 0.5 * (corner + np.roll(corner, -1, 1))], 1)
    held = is_held(scene)(points.reshape(-1, 3)).reshape(-1, 6)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    random = np.random.RandomState(3)._bit_generator
    places: list[Place] = []
    for _ in range(10000):
        t = int(random.random_raw()) % len(surface)
        alpha = np.array([1.0 + int(random.random_raw()) % 1000 for _ in range(3)])
        place = Place(alpha / alpha.sum() @ corner[t], normal[t])
        near = np.linalg.norm(points - place.on, axis=2) < 1.2 * radius
        if not (near & ((normal @ place.outward < 0.7)[:, None] | held)).any():
            places.append(place)
        if len(places) == PLACES:
            return places
    raise LabError(f"a mesh of {len(mesh.x)} nodes: no places for the laboratory to press; take a smaller finger")


# ---- the body itself -----------------------------------------------------------------------------------------------

def cube_body(poisson: float, inner: int, outer: int) -> Bricks:
    across = graded(0.0, 0.03, 0.006, 0.024, inner, outer)
    return Bricks([across, across, graded(0.0, 0.03, 0.021, 0.03, inner // 2, outer + 1)], 1e4, poisson)


def normals(body: Solid, places: Sequence[Place], radius: float) -> Array:
    """n . S n, N/m, under a finger of this radius at each place."""
    stiffness = body.stiffness([Footprint(place.on, radius) for place in places])
    return np.array([place.outward @ s @ place.outward for place, s in zip(places, stiffness)])


def truths(specimen: Specimen, folder: Path) -> list[Truth]:
    """Minutes."""
    meshed = specimen.meshes[0]
    say("the body itself:", specimen.name)
    if meshed.side:
        nu = meshed.scene["material"]["poisson"]
        bodies: Sequence[Solid] = (cube_body(nu, 14, 4), cube_body(nu, 10, 3))
        places = spiral((0.015, 0.015, 0.03), 0.008, PLACES)
    else:
        mesh = read_vtu(folder / f"{specimen.name}-mesh/mesh.vtu")
        bodies = [reference(meshed.scene, of) for of in (mesh.in_eight(), mesh)]
        surface = np.load(folder / f"{specimen.name}-mesh/surface.npy").astype(np.int64)
        places = mesh_places(meshed.scene, mesh, surface, specimen.radius)
    fine = bodies[0].stiffness([Footprint(place.on, specimen.radius) for place in places])
    coarse = normals(bodies[1], places, specimen.radius)
    return [Truth(place, s, along / (place.outward @ s @ place.outward) - 1.0)
            for place, s, along in zip(places, fine, coarse)]


def truth_table(folder: Path) -> Topic:
    rows = []
    for specimen in specimens(True, folder):
        for t in truths(specimen, folder):
            x, s = t.place.on, t.stiffness
            rows.append([specimen.name,
                         {"value": [*x, *t.place.outward], "text": ", ".join(f"{1e3 * v:.1f}" for v in x) + " mm"},
                         {"value": [s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]],
                          "text": f"{t.normal:.1f} N/m"}, percent(t.coarser, "{:+.2f} %")])
    return table("body | place | stiffness along the normal | on the coarser mesh", rows)


def truth_of(topics: Topics, specimen: str) -> list[Truth]:
    """As docs/numbers.json has it. Raises LabError where a specimen has none."""
    found = []
    for name, place, stiffness, coarser in topics.get("truth", {"rows": []})["rows"]:
        if name == specimen:
            x, (xx, yy, zz, xy, yz, zx) = np.array(place["value"]), stiffness["value"]
            s = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
            found.append(Truth(Place(x[:3], x[3:]), s, coarser["value"]))
    if not found:
        raise LabError(f"{specimen}: docs/numbers.json has no truth of it; run make bench-large PART=truth")
    return found
