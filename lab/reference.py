# SPDX-License-Identifier: GPL-2.0-or-later
"""The body itself, by elements that are not the product's, and how far it gives under a finger.

C = w^T K^-1 w, m/N: the mean displacement, weighted by the finger's pressure, under a force of 1 N. Solids of
tetrahedra are scikit-fem's; boxes are 27-node bricks with a linear pressure in each (they do not lock).
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
import scipy.sparse as sp
from numpy.typing import NDArray

from lab import LabError
from lab.cholmod import Factor

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  #: of a tetrahedron, in the order of their middles
_PIECES = 12  # of a cell's or a triangle's side, over which a pressure is integrated


# ---- a finger ------------------------------------------------------------------------------------------------------

def smooth(q: Array) -> Array:
    """The mask's pressure, of q = (r / radius)^2."""
    return (1.0 - q) ** 2


def uniform(q: Array) -> Array:
    """A disc that presses evenly."""
    return np.ones_like(q)


def hertz(q: Array) -> Array:
    """A sphere in Hertz's contact."""
    return np.sqrt(1.0 - q)


@dataclass(frozen=True)
class Footprint:
    """A pressure over a round part of a surface; its size does not matter."""

    centre: Array  #: [3] m
    radius: float  #: m
    profile: Callable[[Array], Array] = smooth

    def pressure(self, x: Array) -> Array:
        """At points [..., 3]; 0 outside."""
        q = ((x - self.centre) ** 2).sum(-1) / self.radius**2
        return np.where(q < 1.0, self.profile(np.minimum(q, 1.0)), 0.0)


def normed(shares: Array) -> Array:
    """Shares of a load of 1. Raises LabError where the finger is not on the surface."""
    if not shares.sum() > 0.0:
        raise LabError("the laboratory's finger is not on the surface: no node is under it")
    return shares / shares.sum()


@functools.lru_cache(None)
def _pieces() -> Array:
    """[144, 3] area coordinates of the middles of equal triangles that a triangle is cut into."""
    n = _PIECES
    upright = [(3 * i + 1, 3 * j + 1) for i in range(n) for j in range(n - i)]
    turned = [(3 * i + 2, 3 * j + 2) for i in range(n) for j in range(n - i - 1)]
    ab = np.array(upright + turned) / (3.0 * n)
    return np.column_stack([1.0 - ab.sum(1), ab])


def shares_on(x: Array, triangles: Indices, footprint: Footprint) -> Array:
    """[N] shares of nodes at x [N, 3]. triangles: [q, 3] corners, or [q, 6] with the nodes between 01 12 20."""
    corner = x[triangles[:, :3]]
    longest = np.linalg.norm(corner - np.roll(corner, 1, 1), axis=2).max(1)
    near = np.linalg.norm(corner[:, 0] - footprint.centre, axis=1) < footprint.radius + longest
    triangles, corner = triangles[near], corner[near]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    a = _pieces()
    shape = a if triangles.shape[1] == 3 else np.column_stack([a * (2.0 * a - 1.0), 4.0 * a * np.roll(a, -1, 1)])
    load = np.einsum("q,qp,pn->qn", area, footprint.pressure(a @ corner), shape)
    return normed(np.bincount(triangles.ravel(), load.ravel(), len(x)))


# ---- a body --------------------------------------------------------------------------------------------------------

class Solid:
    """K of nodes [N, 3], three unknowns a node, those of `held` [N] or [N, 3] left out."""

    def __init__(self, k: sp.spmatrix, held: NDArray[np.bool_]) -> None:
        held = np.broadcast_to(held[:, None] if held.ndim == 1 else held, (k.shape[0] // 3, 3))
        self.free: Indices = np.flatnonzero(~held.ravel())
        self.k = k.tocsr()[self.free][:, self.free].tocsc()

    @functools.cached_property
    def factor(self) -> Factor:
        return Factor(self.k)

    def solve(self, forces: Array) -> Array:
        """[N, 3] m under forces [N, 3] N."""
        moved = np.zeros(forces.size)
        moved[self.free] = self.factor.solve(forces.ravel()[self.free])
        return moved.reshape(-1, 3)

    def loads(self, shares: Sequence[Array]) -> Array:
        """[free, 3 k]: of every finger a force along x, y, z."""
        w = np.zeros((3 * len(shares[0]), 3 * len(shares)))
        for f, share in enumerate(shares):
            for c in range(3):
                w[c::3, 3 * f + c] = share
        return w[self.free]

    def compliances(self, shares: Sequence[Array]) -> Array:
        """C of each finger, [k, 3, 3]."""
        w = self.loads(shares)
        x = self.factor.solve(w)
        return np.array([w[:, f:f + 3].T @ x[:, f:f + 3] for f in range(0, w.shape[1], 3)])


def lame(young: float, poisson: float) -> tuple[float, float]:
    """lambda, mu."""
    return young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


# ---- tetrahedra, by scikit-fem -------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Mesh:
    """Nodes [N, 3] m and tetrahedra [t, 4]."""

    x: Array
    tets: Indices

    @functools.cached_property
    def edges(self) -> Indices:
        """[e, 2] ascending: every edge once."""
        pairs = self.tets[:, EDGES].reshape(-1, 2)
        return np.unique(np.sort(pairs, 1), axis=0)

    def middle(self, a: Indices, b: Indices) -> Indices:
        """Numbers of the nodes in the middle of edges, after all corners."""
        n = len(self.x)
        key = self.edges[:, 0] * n + self.edges[:, 1]
        return n + np.searchsorted(key, np.minimum(a, b) * n + np.maximum(a, b))

    @functools.cached_property
    def middles(self) -> Indices:
        """[t, 6] of every tetrahedron, by EDGES."""
        return np.column_stack([self.middle(self.tets[:, a], self.tets[:, b]) for a, b in EDGES])

    @functools.cached_property
    def surface(self) -> Indices:
        """[q, 3] triangles of one tetrahedron only, counter-clockwise from outside where the volumes are positive."""
        faces = self.tets[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]].reshape(-1, 3)
        _, first, count = np.unique(np.sort(faces, 1), axis=0, return_index=True, return_counts=True)
        return faces[np.sort(first[count == 1])]

    def in_eight(self) -> "Mesh":
        """Every tetrahedron in eight: four at the corners, the octahedron between them along its shortest diagonal."""
        x = np.vstack([self.x, self.x[self.edges].mean(1)])
        t = self.tets
        m = self.middles
        between = {frozenset(p): m[:, e] for e, p in enumerate(EDGES)}
        small = [np.column_stack([t[:, c], *(between[frozenset((c, d))] for d in range(4) if d != c)])
                 for c in range(4)]
        diagonals = np.array([[0, 5, 1, 2, 3, 4], [1, 3, 0, 2, 5, 4], [2, 4, 0, 1, 5, 3]])  # its ends, then the ring
        length = np.column_stack([np.linalg.norm(x[m[:, d[0]]] - x[m[:, d[1]]], axis=1) for d in diagonals])
        ring = np.take_along_axis(m, diagonals[length.argmin(1)], 1)
        small += [ring[:, [0, 1, 2 + r, 2 + (r + 1) % 4]] for r in range(4)]
        return Mesh(x, positive(x, np.vstack(small)))


def positive(x: Array, tets: Indices) -> Indices:
    """Turned so that volumes are positive."""
    a, b, c, d = (x[tets[:, k]] for k in range(4))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0.0
    return np.where(turned[:, None], tets[:, [0, 1, 3, 2]], tets)


class Tetrahedra(Solid):
    """Linear or quadratic tetrahedra, of straight edges. x: [N, 3], of quadratic ones with the nodes in the middle of
    edges after the corners; triangles: the surface's, [q, 3] or [q, 6].

    is_held: of nodes x. averaged: quadratic ones resist the mean change of their volume only (Crouzeix and Raviart
    1973: one pressure an element, stable for any ratio). symmetric: nothing goes through the planes x = 0 and y = 0."""

    def __init__(self, mesh: Mesh, young: float, poisson: float, is_held: Callable[[Array], NDArray[np.bool_]],
                 quadratic: bool = False, averaged: bool = False, symmetric: bool = False) -> None:
        self.mesh, self.x, self.triangles = mesh, mesh.x, mesh.surface
        if quadratic:
            t = mesh.surface
            self.x = np.vstack([mesh.x, mesh.x[mesh.edges].mean(1)])
            self.triangles = np.column_stack([t, *(mesh.middle(t[:, c], t[:, (c + 1) % 3]) for c in range(3))])
        fixed = is_held(self.x)
        self.held: Indices = np.flatnonzero(fixed)
        held = np.repeat(fixed[:, None], 3, 1)
        if symmetric:
            held[:, :2] |= self.x[:, :2] == 0.0
        super().__init__(self._assemble(lame(young, poisson), quadratic, averaged), held)

    def _assemble(self, material: tuple[float, float], quadratic: bool, averaged: bool) -> sp.spmatrix:
        import skfem
        from skfem.helpers import ddot, div, sym_grad
        fem = skfem_mesh(self.mesh)
        element = skfem.ElementVector(skfem.ElementTetP2() if quadratic else skfem.ElementTetP1())
        basis = skfem.Basis(fem, element, intorder=2)
        lam, mu = material
        kept = 0.0 if averaged else lam
        k = skfem.asm(skfem.BilinearForm(
            lambda u, v, _: 2.0 * mu * ddot(sym_grad(u), sym_grad(v)) + kept * div(u) * div(v)), basis)
        if averaged:
            mean = skfem.asm(skfem.BilinearForm(lambda u, v, _: div(u) * v), basis,
                             basis.with_element(skfem.ElementTetP0()))
            volume = np.asarray(basis.dx).sum(1)
            k = k + lam * mean.T @ sp.diags(1.0 / volume) @ mean
        dofs = basis.nodal_dofs
        if quadratic:
            of_edge = self.mesh.middle(fem.edges[0].astype(np.int64), fem.edges[1].astype(np.int64)) - len(self.mesh.x)
            dofs = np.hstack([dofs, basis.edge_dofs[:, np.argsort(of_edge)]])
        order = dofs.T.ravel()
        return k.tocsr()[order][:, order]

    def shares(self, footprint: Footprint, top: float | None = None) -> Array:
        """top: of the triangles in that height only."""
        t = self.triangles
        return shares_on(self.x, t if top is None else t[(self.x[t[:, :3], 2] == top).all(1)], footprint)


def skfem_mesh(mesh: Mesh) -> Any:
    """The mesh as scikit-fem has it. Raises LabError where that is not there."""
    try:
        import skfem
    except ImportError as error:
        raise LabError("scikit-fem: is not there; run make lab (does this machine reach pypi.org?)") from error
    return skfem.MeshTet(np.ascontiguousarray(mesh.x.T), np.ascontiguousarray(mesh.tets.T))


# ---- boxes of bricks -----------------------------------------------------------------------------------------------

def graded(low: float, high: float, begin: float, end: float, inner: int, outer: int) -> Array:
    """Planes from low to high: `inner` cells of equal size within [begin, end], on either side `outer` that grow in a
    geometric series."""
    cell = (end - begin) / inner

    def outwards(length: float) -> Array:
        if not length > 1e-9 * (high - low):
            return np.empty(0)
        powers = np.arange(1, outer + 1)
        ratio = scipy.optimize.brentq(lambda r: cell * (r**powers).sum() - length, 1e-3, 1e3, xtol=1e-15, rtol=1e-14)
        return np.cumsum(cell * ratio**powers)
    planes = np.concatenate([begin - outwards(begin - low)[::-1], np.linspace(begin, end, inner + 1),
                             end + outwards(high - end)])
    planes[[0, -1]] = low, high
    return planes


_SHAPE = (lambda s: np.stack([0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)], -1),
          lambda s: np.stack([s - 0.5, -2 * s, s + 0.5], -1))
_GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 9.0


class _Line:
    """Quadratic elements on the cells of a line: one axis of a grid. What it integrates are factors of Kronecker
    products."""

    def __init__(self, planes: Array) -> None:
        self.planes, self.cells, self.nodes = planes, len(planes) - 1, 2 * len(planes) - 1
        self.half = 0.5 * np.diff(planes)
        value, slope = _SHAPE[0](_GAUSS), _SHAPE[1](_GAUSS)
        self.of = [[self._square(self._both(a, b), 1 - i - j) for j, b in enumerate((value, slope))]
                   for i, a in enumerate((value, slope))]  # [derived on the left][on the right]
        self.against = [[self._rows((_WEIGHT * _GAUSS**p) @ f, 1 - d) for d, f in enumerate((value, slope))]
                        for p in range(2)]  # [degree of the pressure][derived]

    def _both(self, a: Array, b: Array) -> Array:
        return np.einsum("q,qa,qb->ab", _WEIGHT, a, b)

    def _at(self) -> Indices:
        return 2 * np.arange(self.cells)[:, None] + np.arange(3)

    def _square(self, element: Array, power: int) -> sp.csr_matrix:
        at = self._at()
        row, column = np.broadcast_arrays(at[:, :, None], at[:, None, :])
        data = self.half[:, None, None] ** power * element
        return sp.csr_matrix((data.ravel(), (row.ravel(), column.ravel())), shape=(self.nodes, self.nodes))

    def _rows(self, element: Array, power: int) -> sp.csr_matrix:
        row = np.repeat(np.arange(self.cells), 3)
        data = self.half[:, None] ** power * element
        return sp.csr_matrix((data.ravel(), (row, self._at().ravel())), shape=(self.cells, self.nodes))

    @property
    def x(self) -> Array:
        x = np.empty(self.nodes)
        x[::2], x[1::2] = self.planes, 0.5 * (self.planes[1:] + self.planes[:-1])
        return x

    def points(self) -> tuple[Array, sp.csr_matrix]:
        """Where a pressure is taken, and the shape functions there times the points' lengths: a cell in pieces."""
        s = (-1.0 + (2.0 * np.arange(_PIECES)[:, None] + 1.0 + _GAUSS) / _PIECES).ravel()
        weight = np.tile(_WEIGHT, _PIECES) / _PIECES
        x = (self.planes[:-1, None] + (s + 1.0) * self.half[:, None]).ravel()
        data = self.half[:, None, None] * (weight[:, None] * _SHAPE[0](s))
        row, column = np.broadcast_arrays(np.arange(len(x)).reshape(self.cells, -1, 1), self._at()[:, None, :])
        return x, sp.csr_matrix((data.ravel(), (row.ravel(), column.ravel())), shape=(len(x), self.nodes))


def _kron(factors: Sequence[sp.spmatrix]) -> sp.spmatrix:
    """Of x, y, z: x counts fastest."""
    return functools.reduce(lambda a, b: sp.kron(b, a, format="csr"), factors)


class Bricks(Solid):
    """A box, held at its lowest plane. K = int 2 mu eps : eps + lambda D^T M^-1 D, D = int p div u, M = int p p^T,
    p = (1, x, y, z) in every brick. quarter: its planes of least x and y are planes of symmetry; then only C_zz counts,
    and is the whole box's."""

    def __init__(self, planes: Sequence[Array], young: float, poisson: float, quarter: bool = False) -> None:
        self._axes = axes = [_Line(np.asarray(p)) for p in planes]
        self._quarter = quarter
        lam, mu = lame(young, poisson)
        products = {(e, f): _kron([axes[g].of[g == e][g == f] for g in range(3)])
                    for e, f in itertools.product(range(3), repeat=2)}
        blocks = [[mu * (products[d, c] + (sum(products[e, e] for e in range(3)) if c == d else 0))
                   for d in range(3)] for c in range(3)]
        volume = 8.0 * functools.reduce(np.multiply.outer, [axis.half for axis in axes[::-1]]).ravel()
        for p in (None, 0, 1, 2):  # the pressure's terms: 1, then along each axis
            swelling = [_kron([axes[g].against[g == p][g == c] for g in range(3)]) for c in range(3)]
            mass = sp.diags(lam / (volume if p is None else volume / 3.0))
            for c, d in itertools.product(range(3), repeat=2):
                blocks[c][d] = blocks[c][d] + swelling[c].T @ mass @ swelling[d]
        n = axes[0].nodes * axes[1].nodes * axes[2].nodes
        order = np.arange(3 * n).reshape(3, n).T.ravel()
        at = np.indices([axis.nodes for axis in axes[::-1]]).reshape(3, n)[::-1]  # of each node along x, y, z
        held = np.repeat((at[2] == 0)[:, None], 3, 1)
        if quarter:
            held[:, :2] |= (at[:2] == 0).T
        super().__init__(sp.bmat(blocks, format="csr")[order][:, order], held)

    def shares(self, footprint: Footprint) -> Array:
        """The pressure on the highest plane against the shape functions of its nodes."""
        (x, wx), (y, wy) = self._axes[0].points(), self._axes[1].points()
        at = np.stack([*np.broadcast_arrays(x[None, :], y[:, None]),
                       np.full((len(y), len(x)), self._axes[2].planes[-1])], -1)
        top = wy.T @ footprint.pressure(at) @ wx
        shares = np.zeros((self._axes[2].nodes, *top.shape))
        shares[-1] = top
        return normed(shares.ravel())

    def compliances(self, shares: Sequence[Array]) -> Array:
        """A quarter gives under 1 N on it as the whole under 4 N."""
        return super().compliances(shares) / (4.0 if self._quarter else 1.0)
