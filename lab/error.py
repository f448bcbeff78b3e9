# SPDX-License-Identifier: GPL-2.0-or-later
"""How far the force is from the body's, by configuration, against what it costs: `make bench`.

Ours is measured by the product's own programs and library; the body is docs/numbers.json's truth (lab.specimens)."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg

from lab import LabError, binding, scenes, told
from lab.cholmod import one_thread
from lab.numbers import Topics, error_of, number, read_numbers, seconds, write_topics
from lab.reference import Array, Footprint, Indices, Mesh, Tetrahedra, shares_on
from lab.specimens import Meshed, Specimen, Truth, read_vtu, reference, specimens, truth_of

ELEMENTS = ("linear", "average-nodal-pressure", "quadratic")
FORCES = ("interpolated", "consistent", "pressure-mask")
GOD_OBJECTS = ("nearest", "least-energy")
PRECISIONS = ("float32", "float16", "int16")
COLUMNS = ["body", "mesh", "element", "force", "god-object", "precision", "error, RMS", "mean error", "tick", "flash",
           "precompute"]

_DEPTH = 0.001  # m, of a press
_RESIDUAL = 1e-3  # relative, at which conjugate gradients stop
_DENSE_NODES = 800  # more are not inverted
_TICK_MOTION = 4e-5  # m: 40 mm/s
_MIDDLE, _FINE = 1, 2  # fineness


# ---- ticks ---------------------------------------------------------------------------------------------------------

def time_ticks(build: Path, folders: Sequence[Path], depth: float, ticks: int, repetitions: int,
               every: bool = False) -> list[dict[str, Any]]:
    """CPU time of a tick of each folder's servo, sliding round a circle; every: in each precision and god-object. Keys:
    precision, god_object, bytes (of the tables), tick_s (a list, all in turn)."""
    timed: list[dict[str, Any]] = told(
        build / "bin/haptable-bench-ticks", *folders, "--depth", depth, "--ticks", ticks, "--repetitions", repetitions,
        *(["--every"] if every else []))
    return timed


# ---- a configuration -----------------------------------------------------------------------------------------------

def _row(names: Sequence[str], felt: Sequence[tuple[Array, Array, Array]], tick_s: float, flash: float,
         precompute_s: float) -> list[Any]:
    """felt: of every place the force, the body's, and the normal."""
    error = np.sqrt(np.mean([(np.linalg.norm(f - body) / np.linalg.norm(body)) ** 2 for f, body, _ in felt]))
    mean = np.mean([n @ f / (n @ body) - 1.0 for f, body, n in felt])
    return [*names, number(float(error), _percent(error)),
            number(float(mean), ("" if mean < 0.0 else "+") + _percent(mean)),
            seconds(tick_s), _bytes(flash), seconds(precompute_s)]


def _percent(share: float) -> str:
    """2.6 %, 107 %"""
    percent = 100.0 * share
    return f"{percent:.2g} %" if abs(percent) < 10.0 else f"{percent:.0f} %"


def _bytes(n: float) -> dict[str, Any]:
    return number(float(n), f"{1e-3 * n:.3g} kB" if n < 1e6 else f"{1e-6 * n:.3g} MB")


def _is_measured(meshed: Meshed, element: str, force: str, quick: bool) -> bool:
    """Points have no stiffness of their own on fine meshes. Middles make a mesh as fine as one of twice its nodes."""
    most = _FINE if force == "pressure-mask" and not quick else _MIDDLE
    return meshed.fineness + (element == "quadratic") <= most


def _folder(build: Path, meshed: Meshed, element: str, force: str) -> Path:
    return build / "error" / f"{meshed.scene['name']}-{element}-{force}"


def force_at(body: Any, truth: Truth) -> Array:
    """What the servo gives at a place, N: into contact from outside, then until a god-object that moves has come to
    rest."""
    on, n = truth.place.on, truth.place.outward
    felt = body.servo().replay(np.vstack([on + _DEPTH * n, np.tile(on - _DEPTH * n, (50, 1))]))[-1]
    if felt["state"] != 2:
        raise LabError(f"{body.name}: the laboratory's finger lost contact: nothing was measured")
    force: Array = felt["force"].astype(float)
    return force


def measure_points(specimen: Specimen, meshed: Meshed, truths: Sequence[Truth], build: Path, quick: bool,
                   haptable: ModuleType) -> list[list[Any]]:
    """A row for every configuration of one mesh."""
    rows = []
    for element in ELEMENTS:
        for force in FORCES:
            if not _is_measured(meshed, element, force, quick):
                continue
            mask = {"mask_radius": specimen.radius} if force == "pressure-mask" else {}
            scene = {**meshed.scene, "mesh": {**meshed.scene["mesh"], "element": element},
                     "contact": {"force": force, **mask}}
            folder = _folder(build, meshed, element, force)
            precompute_s = sum(scenes.precompute(scene, folder, build)["cpu_s"].values())
            for timed in time_ticks(build, [folder], _DEPTH, 5000, 7, every=True):
                precision, god_object = timed["precision"], timed["god_object"]
                body = haptable.load(folder, precision=precision, god_object=god_object, bare=True)
                felt = [(force_at(body, t), t.force(god_object == "least-energy", _DEPTH), t.place.outward)
                        for t in truths]
                rows.append(_row([specimen.name, meshed.name, element, force, god_object, precision], felt,
                                 float(np.median(timed["tick_s"])), timed["bytes"], precompute_s))
    return rows


# ---- the mesh in double --------------------------------------------------------------------------------------------

class Discrete:
    """The linear elements of a folder's mesh, by scikit-fem, under the masks that the folder's tables have."""

    def __init__(self, scene: scenes.Scene, folder: Path) -> None:
        self.mesh: Mesh = read_vtu(folder / "mesh.vtu")
        self.body: Tetrahedra = reference(scene, self.mesh, quadratic=False)
        self.patch: Indices = np.load(folder / "patch.npy").astype(np.int64)
        self.touchable: Indices = np.load(folder / "node_id.npy").astype(np.int64)
        self._vertex, self._edge = np.load(folder / "vertex_id.npy"), np.load(folder / "edge_id.npy").astype(np.int64)
        self._spread = [np.load(folder / f"spread_{name}.npy") for name in ("begin", "node", "weight")]

    def locate(self, x: Array) -> tuple[Indices, Array]:
        """The patch that a point lies on, and its area coordinates there. Raises LabError where it lies on none."""
        a, b, c = (self.mesh.x[self.patch[:, k]] for k in range(3))
        edges = np.stack([b - a, c - a], 2)
        turned = edges.transpose(0, 2, 1)
        beta = np.linalg.solve(turned @ edges, turned @ (x - a)[:, :, None])[..., 0]
        alpha = np.column_stack([1.0 - beta.sum(1), beta])
        off = np.linalg.norm(a + (edges @ beta[:, :, None])[..., 0] - x, axis=1)
        on = np.flatnonzero((alpha.min(1) > -1e-9) & (off < 1e-6 * np.linalg.norm(edges, axis=(1, 2))))
        if len(on) == 0:
            raise LabError("the laboratory presses a place that is on no patch")
        return self.patch[on[0]], alpha[on[0]]

    def point(self, patch: Indices, alpha: Array) -> Array:
        shares = np.zeros(len(self.mesh.x))
        shares[patch] = alpha
        return shares

    def mask(self, patch: Indices, alpha: Array) -> Array:
        """The tables' weights: a quadratic on every patch."""
        begin, node, weight = self._spread
        shares = np.zeros(len(self.mesh.x))
        for c in range(3):
            d = (c + 1) % 3
            edge = int(np.flatnonzero((self._edge == np.sort(patch[[c, d]])).all(1))[0])
            for k, times in ((int(np.searchsorted(self._vertex, patch[c])), alpha[c] ** 2),
                             (len(self._vertex) + edge, 2.0 * alpha[c] * alpha[d])):
                np.add.at(shares, node[begin[k]:begin[k + 1]], times * weight[begin[k]:begin[k + 1]])
        return shares

    def stiffness(self, shares: Array) -> Array:
        s: Array = np.linalg.inv(self.body.compliances([shares])[0])
        return s


# ---- what one would do instead -------------------------------------------------------------------------------------

def conjugate_gradients(k: sp.csr_matrix, b: Array, x: Array) -> Array:
    """K x = b of each column, from x on, with K's diagonal as preconditioner, to a relative residual of 1e-3."""
    inverse = sp.diags(1.0 / k.diagonal())
    return np.stack([cg(k, right, now, tol=_RESIDUAL, atol=0.0, M=inverse)[0] for right, now in zip(b.T, x.T)], 1)


def _timed(solve: Callable[[], Any]) -> tuple[Any, float]:
    begin = time.process_time()
    x = solve()
    return x, time.process_time() - begin


def measure_instead(specimen: Specimen, meshed: Meshed, all_truths: Sequence[Truth], build: Path) -> list[list[Any]]:
    """C = w^T K^-1 w in every tick, by three ways that need no table: in double, one thread, under the mask."""
    truths = all_truths[:1 if meshed.fineness == _FINE else 3]  # a tick of conjugate gradients may take seconds
    one_thread()
    folder = _folder(build, meshed, "linear", "pressure-mask")
    on = Discrete(meshed.scene, folder)
    k = on.body.k.tocsr()
    cost = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["cpu_s"]
    assembled_s = cost["mesh"] + cost["assembly"]  # of the product's own: the same matrix

    def gradients(w: Array, last: Array | None) -> Array:
        return conjugate_gradients(k, w, np.zeros_like(w) if last is None else last)

    def row(what: str, solve: Callable[[Array, Array | None], Array], flash: float, precompute_s: float) -> list[Any]:
        felt, taken = [], []
        for truth in truths:
            place = truth.place
            patch, alpha = on.locate(place.on)
            w = on.body.loads([on.mask(patch, alpha)])
            x = solve(w, None)
            felt.append((_DEPTH * np.linalg.inv(w.T @ x) @ place.outward, truth.force(False, _DEPTH), place.outward))
            # A tick along the patch's longest way: towards its middle.
            way = on.mesh.x[patch].mean(0) - place.on
            w = on.body.loads([on.mask(*on.locate(place.on + _TICK_MOTION * way / np.linalg.norm(way)))])
            taken.append(_timed(lambda: solve(w, x))[1])  # noqa: B023
        return _row([specimen.name, meshed.name, "linear", what, "none", "float64"], felt, float(np.median(taken)),
                    flash, precompute_s)
    measured = [row("conjugate gradients", gradients, 12.0 * k.nnz, assembled_s)]
    factor, factor_s = _timed(lambda: on.body.factor)
    factor_s += assembled_s
    measured.append(row("sparse solve", lambda w, _: factor.solve(w), factor.bytes, factor_s))
    if len(on.touchable) > _DENSE_NODES:
        return measured
    unknown = np.searchsorted(on.body.free, (3 * on.touchable[:, None] + np.arange(3)).ravel())

    def invert() -> Array:
        b = np.zeros((factor.size, len(unknown)))
        b[unknown, np.arange(len(unknown))] = 1.0
        return np.ascontiguousarray(factor.solve(b)[unknown])
    inverse, inverse_s = _timed(invert)

    def dense(w: Array, _: Array | None) -> Array:
        x = np.zeros_like(w)
        x[unknown] = inverse @ w[unknown]
        return x
    measured.append(row("dense inverse", dense, 8.0 * inverse.size, factor_s + inverse_s))
    return measured


# ---- the contact of a discrete body --------------------------------------------------------------------------------

def contact_errors(specimen: Specimen, meshed: Meshed, truths: Sequence[Truth], build: Path,
                   haptable: ModuleType) -> list[list[Any]]:
    """The largest over the places: of the force in float32, against the contact imposed, of the drawn surface."""
    on = Discrete(meshed.scene, _folder(build, meshed, "linear", "pressure-mask"))
    rows = []
    for force in FORCES:
        body = haptable.load(_folder(build, meshed, "linear", force), god_object="nearest", precision="float32",
                             bare=True)
        worst = np.max([_contact_error(on, force, truth, force_at(body, truth), specimen.radius) for truth in truths],
                       0)

        def share(value: float) -> dict[str, Any]:
            return error_of(value) if value < 1e-3 else number(value, f"{100.0 * value:.2g} %")
        rows.append([f"{specimen.name}, {meshed.name}", force, error_of(float(worst[0])), share(float(worst[1])),
                     share(float(worst[2]))])
    return rows


def _contact_error(on: Discrete, force: str, truth: Truth, felt: Array, radius: float) -> tuple[float, float, float]:
    patch, alpha = on.locate(truth.place.on)
    u = -_DEPTH * truth.place.outward
    point = on.point(patch, alpha)
    shares = on.mask(patch, alpha) if force == "pressure-mask" else point
    loads = np.zeros((len(shares), 3))
    if force == "interpolated":
        for node, a in zip(patch, alpha):
            loads[node] = a * on.stiffness(on.point(np.array([node]), np.ones(1))) @ u
    else:
        loads = np.outer(shares, on.stiffness(shares) @ u)
    imposed = shares_on(on.mesh.x, on.patch, Footprint(truth.place.on, radius)) if force == "pressure-mask" else point
    meant, own = -on.stiffness(imposed) @ u, -loads.sum(0)
    moved = shares @ on.body.solve(loads)

    def norm(x: Array) -> float:
        return float(np.linalg.norm(x))
    return norm(felt - own) / norm(own), norm(felt - meant) / norm(meant), norm(moved - u) / norm(u)


# ---- topics --------------------------------------------------------------------------------------------------------

def make(build: Path, out: Path, numbers: Path = Path("docs/numbers.json"), quick: bool = False) -> None:
    """Error against the body of every configuration, and what it costs. numbers: where the truth is; quick: coarse
    meshes only."""
    haptable, topics = binding.load(build), read_numbers(numbers)
    points: list[list[Any]] = []
    contacts: list[list[Any]] = []
    for specimen in specimens(quick, build / "error", build):
        truths = truth_of(topics, specimen.name)
        for meshed in specimen.meshes:
            print(f"bench: error and speed: {specimen.name}, {meshed.name}", flush=True)
            points += measure_points(specimen, meshed, truths, build, quick, haptable)
            points += measure_instead(specimen, meshed, truths, build)
        coarse = specimen.meshes[2 if len(specimen.meshes) > 2 else 0]
        contacts += contact_errors(specimen, coarse, truths, build, haptable)
    tables: Topics = {"points": {"columns": COLUMNS, "rows": points},
                      "contact-error": {"columns": ["body", "force", "float32 against its own equations in double",
                                                    "against that contact imposed",
                                                    "the drawn surface misses the finger by, of the depth"],
                                        "rows": contacts}}
    write_topics(out, tables)
