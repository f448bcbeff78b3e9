# SPDX-License-Identifier: GPL-2.0-or-later
"""How far the force is from the body's, by configuration, against what it costs: `make bench`.

Ours is measured by the product's own programs and library; the body is docs/numbers.json's truth (lab.specimens)."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg

from lab import LabError, binding, build, say, scenes, told
from lab.cholmod import one_thread
from lab.numbers import Topic, Topics, error_of, frame, number, percent, read_numbers, seconds, table, write_topics
from lab.reference import Array, Footprint, Indices, Mesh, Tetrahedra
from lab.scenes import touched, vary
from lab.specimens import FINE, MIDDLE, Meshed, Place, Specimen, Truth, read_vtu, reference, specimens, truth_of

ELEMENTS = ("linear", "average-nodal-pressure", "quadratic")
FORCES = ("interpolated", "consistent", "pressure-mask")
GOD_OBJECTS = ("nearest", "least-energy")
COLUMNS = ["body", "mesh", "element", "force", "god-object", "precision", "error, RMS", "mean error", "tick", "flash",
           "precompute"]

_DEPTH = 0.001  # m, of a press
_RESIDUAL = 1e-3  # relative, at which conjugate gradients stop
_DENSE_NODES = 800  # more are not inverted
_TICK_MOTION = 4e-5  # m: 40 mm/s


# ---- what the product feels ----------------------------------------------------------------------------------------

def time_ticks(folders: Sequence[Path], depth: float, ticks: int, repetitions: int) -> list[dict[str, Any]]:
    """CPU time of a tick of each folder's servo, sliding round a circle, in each precision and god-object. Keys:
    precision, god_object, bytes (of the tables), tick_s (a list, all in turn)."""
    return told("haptable-bench-ticks", *folders, "--depth", depth, "--ticks", ticks, "--repetitions", repetitions)


def in_contact(body: Any, felt: Any) -> Array:
    """Forces of ticks that all must be in contact, N."""
    if not (felt["state"] == 2).all():
        raise LabError(f"{body.name}: the laboratory's finger lost contact: nothing was measured")
    return felt["force"].astype(float)


def felt_at(body: Any, place: Place, depth: float) -> Array:
    """What the servo gives at a place, N: into contact from outside, then until a god-object that moves has come to
    rest."""
    deep = depth * place.outward
    return in_contact(body, body.servo().replay(np.vstack([place.on + deep, np.tile(place.on - deep, (50, 1))]))[-1])


# ---- a configuration -----------------------------------------------------------------------------------------------

def _row(names: Sequence[str], felt: Sequence[tuple[Array, Array, Array]], tick_s: float, flash: float,
         precompute_s: float) -> list[Any]:
    """felt: of every place the force, the body's, and the normal."""
    error = np.sqrt(np.mean([(np.linalg.norm(f - body) / np.linalg.norm(body)) ** 2 for f, body, _ in felt]))
    mean = np.mean([n @ f / (n @ body) - 1.0 for f, body, n in felt])
    return [*names, _percent(error), _percent(mean, sign="+"), seconds(tick_s), _bytes(flash), seconds(precompute_s)]


def _percent(share: float, sign: str = "") -> Topic:
    """2.6 %, 107 %"""
    return percent(share, f"{{:{sign}{'.2g' if abs(share) < 0.1 else '.0f'}}} %")


def _bytes(n: float) -> Topic:
    return number(float(n), "{:.3g} kB", 1e-3) if n < 1e6 else number(float(n), "{:.3g} MB", 1e-6)


def _is_measured(meshed: Meshed, element: str, force: str, quick: bool) -> bool:
    """Points have no stiffness of their own on fine meshes. Middles make a mesh as fine as one of twice its nodes."""
    most = FINE if force == "pressure-mask" and not quick else MIDDLE
    return meshed.fineness + (element == "quadratic") <= most


def _folder(meshed: Meshed, element: str, force: str) -> Path:
    return build() / "error" / f"{meshed.scene['name']}-{element}-{force}"


def measure_points(specimen: Specimen, meshed: Meshed, truths: Sequence[Truth], quick: bool) -> Iterator[list[Any]]:
    """A row for every configuration of one mesh."""
    for element in ELEMENTS:
        for force in (force for force in FORCES if _is_measured(meshed, element, force, quick)):
            scene = touched(vary(meshed.scene, mesh={"element": element}), force, specimen.radius)
            folder = _folder(meshed, element, force)
            precompute_s = sum(scenes.precompute(scene, folder)["cpu_s"].values())
            for timed in time_ticks([folder], _DEPTH, 5000, 7):
                how = {key: timed[key] for key in ("god_object", "precision")}
                body = binding.load().load(folder, bare=True, **how)
                felt = [(felt_at(body, t.place, _DEPTH), t.force(how["god_object"] == "least-energy", _DEPTH),
                         t.place.outward) for t in truths]
                yield _row([specimen.name, meshed.name, element, force, *how.values()], felt,
                           float(np.median(timed["tick_s"])), timed["bytes"], precompute_s)


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
        beta = (np.linalg.pinv(edges) @ (x - a)[:, :, None])[..., 0]
        alpha = np.column_stack([1.0 - beta.sum(1), beta])
        off = np.linalg.norm(a + (edges @ beta[:, :, None])[..., 0] - x, axis=1)
        on = np.flatnonzero((alpha.min(1) > -1e-9) & (off < 1e-6 * np.linalg.norm(edges, axis=(1, 2))))
        if len(on) == 0:
            raise LabError("the laboratory presses a place that is on no patch")
        return self.patch[on[0]], alpha[on[0]]

    def point(self, patch: Indices, alpha: Array) -> Array:
        return np.bincount(patch, alpha, len(self.mesh.x))

    def mask(self, patch: Indices, alpha: Array) -> Array:
        """The tables' weights: a quadratic on every patch."""
        begin, node, weight = self._spread
        shares = np.zeros(len(self.mesh.x))
        for c, d in ((0, 1), (1, 2), (2, 0)):
            edge = int(np.flatnonzero((self._edge == np.sort(patch[[c, d]])).all(1))[0])
            for k, times in ((int(np.searchsorted(self._vertex, patch[c])), alpha[c] ** 2),
                             (len(self._vertex) + edge, 2.0 * alpha[c] * alpha[d])):
                np.add.at(shares, node[begin[k]:begin[k + 1]], times * weight[begin[k]:begin[k + 1]])
        return shares

    def stiffness(self, shares: Array) -> Array:
        return np.linalg.inv(self.body.compliances([shares])[0])


# ---- what one would do instead -------------------------------------------------------------------------------------

def conjugate_gradients(k: sp.csr_matrix, b: Array, x: Array) -> Array:
    """K x = b of each column, from x on, with K's diagonal as preconditioner, to a relative residual of 1e-3."""
    inverse = sp.diags(1.0 / k.diagonal())
    return np.stack([cg(k, right, now, tol=_RESIDUAL, atol=0.0, M=inverse)[0] for right, now in zip(b.T, x.T)], 1)


def _timed(solve: Callable[[], Any]) -> tuple[Any, float]:
    begin = time.process_time()
    x = solve()
    return x, time.process_time() - begin


def measure_instead(specimen: Specimen, meshed: Meshed, all_truths: Sequence[Truth]) -> Iterator[list[Any]]:
    """C = w^T K^-1 w in every tick, by three ways that need no table: in double, one thread, under the mask."""
    truths = all_truths[:1 if meshed.fineness == FINE else 3]  # a tick of conjugate gradients may take seconds
    one_thread()
    folder = _folder(meshed, "linear", "pressure-mask")
    on = Discrete(meshed.scene, folder)
    k = on.body.k.tocsr()
    cost = scenes.summary_of(folder)["cpu_s"]
    assembled_s = cost["mesh"] + cost["assembly"]  # of the product's own: the same matrix

    def row(what: str, solve: Callable[[Array, Array], Array], flash: float, precompute_s: float) -> list[Any]:
        """solve: from the loads, and the last tick's displacements."""
        felt, taken = [], []
        for truth in truths:
            place = truth.place
            patch, alpha = on.locate(place.on)
            w = on.body.loads([on.mask(patch, alpha)])
            x = solve(w, np.zeros_like(w))
            felt.append((_DEPTH * np.linalg.inv(w.T @ x) @ place.outward, truth.force(False, _DEPTH), place.outward))
            # A tick along the patch's longest way: towards its middle.
            way = on.mesh.x[patch].mean(0) - place.on
            w = on.body.loads([on.mask(*on.locate(place.on + _TICK_MOTION * way / np.linalg.norm(way)))])
            taken.append(_timed(lambda: solve(w, x))[1])  # noqa: B023
        return _row([specimen.name, meshed.name, "linear", what, "none", "float64"], felt, float(np.median(taken)),
                    flash, precompute_s)
    yield row("conjugate gradients", lambda w, last: conjugate_gradients(k, w, last), 12.0 * k.nnz, assembled_s)
    factor, factor_s = _timed(lambda: on.body.factor)
    factor_s += assembled_s
    yield row("sparse solve", lambda w, _: factor.solve(w), factor.bytes, factor_s)
    if len(on.touchable) <= _DENSE_NODES:
        unknowns = (3 * on.touchable[:, None] + np.arange(3)).ravel()
        at = np.searchsorted(on.body.free, unknowns)
        inverse, inverse_s = _timed(lambda: on.body.inverse(unknowns))

        def dense(w: Array, _: Array) -> Array:
            x = np.zeros_like(w)
            x[at] = inverse @ w[at]
            return x
        yield row("dense inverse", dense, 8.0 * inverse.size, factor_s + inverse_s)


# ---- the contact of a discrete body --------------------------------------------------------------------------------

def contact_errors(specimen: Specimen, meshed: Meshed, truths: Sequence[Truth]) -> Iterator[list[Any]]:
    """The largest over the places: of the force in float32, against the contact imposed, of the drawn surface."""
    on = Discrete(meshed.scene, _folder(meshed, "linear", "pressure-mask"))
    for force in FORCES:
        body = binding.load().load(_folder(meshed, "linear", force), god_object="nearest", precision="float32",
                                   bare=True)
        worst = np.max([_contact_error(on, force, t.place, felt_at(body, t.place, _DEPTH), specimen.radius)
                        for t in truths], 0).tolist()
        yield [f"{specimen.name}, {meshed.name}", force, error_of(worst[0]),
               *(error_of(value) if value < 1e-3 else percent(value, "{:.2g} %") for value in worst[1:])]


def _contact_error(on: Discrete, force: str, place: Place, felt: Array, radius: float) -> list[float]:
    patch, alpha = on.locate(place.on)
    u, point, is_mask = -_DEPTH * place.outward, on.point(patch, alpha), force == "pressure-mask"
    shares = on.mask(patch, alpha) if is_mask else point
    if force == "interpolated":
        loads = np.zeros((len(shares), 3))
        for node, a in zip(patch, alpha):
            loads[node] = a * on.stiffness(on.point(np.array([node]), np.ones(1))) @ u
    else:
        loads = np.outer(shares, on.stiffness(shares) @ u)
    imposed = on.body.shares(Footprint(place.on, radius)) if is_mask else point
    pairs = (felt, -loads.sum(0)), (felt, -on.stiffness(imposed) @ u), (shares @ on.body.solve(loads), u)
    return [float(np.linalg.norm(found - wanted) / np.linalg.norm(wanted)) for found, wanted in pairs]


# ---- what follows from the configurations ---------------------------------------------------------------------------

_PAPER = "the paper, 1998"
#: Forces of the paper's Table 2 on its Pentium Pro of 200 MHz, s: body, mesh and time. Its equations are those of our
#: point that is interpolated, nearest; so is its error. It had the same counts of nodes and patches, a mouse of its
#: own.
_PAPER_S = {("cube, nu 0.49", "5 a side"): 15e-6, ("mouse", "1,713 nodes"): 12e-6}
_FORCE, _PRECISION, _ERROR = (COLUMNS.index(name) for name in ("force", "precision", "error, RMS"))


def _with_paper(rows: list[list[Any]]) -> list[list[Any]]:
    """A row of the paper's behind the tables of its body and mesh, before what one would do instead."""
    rows = list(rows)
    for (body, mesh), tick_s in _PAPER_S.items():
        same = [i for i, row in enumerate(rows) if row[:2] == [body, mesh] and row[_PRECISION] != "float64"]
        ours = next((rows[i] for i in same if rows[i][_FORCE] == "interpolated"), None)
        if ours is not None:
            theirs = {"force": _PAPER, "precision": "", "tick": seconds(tick_s), "flash": "", "precompute": ""}
            rows.insert(same[-1] + 1, [theirs.get(name, cell) for name, cell in zip(COLUMNS, ours)])
    return rows


def _best(rows: list[list[Any]]) -> list[str]:
    """Of each row the costs in which no other finger with a size is better in both, or as good in one and better in the
    other. A point's force goes to zero with the mesh, and is right on one mesh by chance: it is left out."""
    found = frame(table(COLUMNS, rows))
    sized = found[~found["force"].isin(("interpolated", "consistent", _PAPER))]
    best: list[list[str]] = [[] for _ in rows]
    for name, column in (("time", "tick"), ("flash", "flash"), ("precompute", "precompute")):
        for _, body in sized.groupby("body"):
            both = body[["error, RMS", column]].to_numpy(float)
            less, least = both[:, None] <= both, both[:, None] < both  # [other, row, quantity]
            for k in body.index[~(less.all(2) & least.any(2)).any(0)]:
                best[k].append(name)
    return [", ".join(names) for names in best]


def _order(rows: list[list[Any]]) -> Iterator[list[Any]]:
    """How fast the mask's mean error falls on the cubes, and its order from one mesh to the next. Nothing is told by an
    error that is not above the truth's own, or that crosses zero."""
    told = 0.002
    coarser: dict[tuple[str, str], tuple[int, float]] = {}
    for body, mesh, element, force, god_object, precision, _, mean_error, *_ in rows:
        if (force, god_object, precision) == ("pressure-mask", "nearest", "float32") and body.startswith("cube"):
            cells, mean, order = int(mesh.split()[0]) - 1, mean_error["value"], ""  # "13 a side"
            coarse, before = coarser.get((body, element), (cells, 0.0))
            coarser[body, element] = cells, mean
            if before * mean > 0 and abs(mean) > told:
                order = number(math.log(abs(before / mean)) / math.log(cells / coarse), "{:.1f}")
            yield [body, element, mesh, mean_error, order]


def derived(points: list[list[Any]]) -> Topics:
    """With the paper's rows and "best in"; the front of error against time; the order of the mask's error."""
    rows = _with_paper(points)
    rows = [[*row, best] for row, best in zip(rows, _best(rows))]
    front = sorted((row for row in rows if "time" in row[-1]), key=lambda row: (row[0], row[_ERROR]["value"]))
    return {"points": table([*COLUMNS, "best in"], rows), "front": table([*COLUMNS, "best in"], front),
            "order": table("body | element | mesh | mean error of the mask | order", _order(rows))}


# ---- topics --------------------------------------------------------------------------------------------------------

def make(out: Path, quick: bool = False) -> None:
    """Error against the body of every configuration, and what it costs. quick: coarse meshes only."""
    topics, points, contacts = read_numbers(), [], []
    for specimen in specimens(quick, build() / "error"):
        truths = truth_of(topics, specimen.name)
        for meshed in specimen.meshes:
            say(f"error and speed: {specimen.name}, {meshed.name}")
            points += measure_points(specimen, meshed, truths, quick)
            points += measure_instead(specimen, meshed, truths)
        contacts += contact_errors(specimen, specimen.meshes[2 if len(specimen.meshes) > 2 else 0], truths)
    write_topics(out, {
        **derived(points),
        "contact-error": table("body | force | float32 against its own equations in double | against that contact "
                               "imposed | the drawn surface misses the finger by, of the depth", contacts)})
