# SPDX-License-Identifier: GPL-2.0-or-later
"""The body itself, by scikit-fem's elements, and how far it gives under a finger.

C = w^T K^-1 w, m/N: the mean displacement, weighted by the finger's pressure, under a force of 1 N. Boxes are 27-node
bricks with a linear pressure in each (they do not lock).
"""

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
_PIECES = 12  # of a face's side, over which a pressure is integrated


def scikit_fem() -> Any:
    """Its module. Raises LabError where that is not there."""
    try:
        import skfem
    except ImportError as error:
        raise LabError("scikit-fem: is not there; run make lab (does this machine reach pypi.org?)") from error
    return skfem


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


# ---- a mesh --------------------------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Mesh:
    """Nodes [N, 3] m and tetrahedra [t, 4]."""

    x: Array
    tets: Indices

    @functools.cached_property
    def fem(self) -> Any:
        """As scikit-fem has it."""
        return scikit_fem().MeshTet(np.ascontiguousarray(self.x.T), np.ascontiguousarray(self.tets.T))

    @functools.cached_property
    def surface(self) -> Indices:
        """[q, 3] triangles of one tetrahedron only, counter-clockwise from outside where the volumes are positive."""
        faces = self.tets[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]].reshape(-1, 3)
        _, first, count = np.unique(np.sort(faces, 1), axis=0, return_index=True, return_counts=True)
        return faces[np.sort(first[count == 1])]

    def in_eight(self) -> "Mesh":
        """Every tetrahedron in eight: four at the corners, the octahedron between them along its shortest diagonal."""
        skfem = scikit_fem()
        x = np.vstack([self.x, self.x[self.fem.edges.T].mean(1)])
        m = skfem.Basis(self.fem, skfem.ElementTetP2()).element_dofs.T[:, 4:]  # of edges 01 12 20 03 13 23
        small = [np.column_stack([self.tets[:, c], m[:, around]])
                 for c, around in enumerate(([0, 2, 3], [0, 1, 4], [2, 1, 5], [3, 4, 5]))]
        diagonals = np.array([[0, 5, 1, 2, 3, 4], [1, 3, 0, 2, 5, 4], [2, 4, 0, 1, 5, 3]])  # its ends, then the ring
        length = np.linalg.norm(x[m[:, diagonals[:, 0]]] - x[m[:, diagonals[:, 1]]], axis=2)
        ring = np.take_along_axis(m, diagonals[length.argmin(1)], 1)
        small += [ring[:, [0, 1, 2 + r, 2 + (r + 1) % 4]] for r in range(4)]
        return Mesh(x, positive(x, np.vstack(small)))


def positive(x: Array, tets: Indices) -> Indices:
    """Turned so that volumes are positive."""
    a, b, c, d = (x[tets[:, k]] for k in range(4))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0.0
    return np.where(turned[:, None], tets[:, [0, 1, 3, 2]], tets)


# ---- a body --------------------------------------------------------------------------------------------------------

def lame(young: float, poisson: float) -> tuple[float, float]:
    """lambda, mu."""
    return young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


class Solid:
    """K of nodes x [N, 3], three unknowns a node, those that are held left out.

    fem, element: the mesh and one displacement's element, as scikit-fem has them. pressures: at the points of an
    element, [q] each and at right angles to one another: the change of volume is resisted by its means under these
    alone, K = int 2 mu eps : eps + lambda D^T M^-1 D, D = int p div u, M = int p p. None: all of it is. is_held: of
    nodes. quarter: the planes of least x and y are planes of symmetry; the top is touched, in whole fingers of whose C
    only C_zz counts."""

    def __init__(self, fem: Any, element: Any, young: float, poisson: float, is_held: Callable[[Array], Any],
                 pressures: Callable[[Any], Sequence[Array]] | None = None, quarter: bool = False,
                 top: bool = False) -> None:
        skfem, (lam, mu) = scikit_fem(), lame(young, poisson)
        self._basis = basis = skfem.Basis(fem, element, intorder=element.maxdeg if len(fem.t) == 8 else 2)
        self._quarter = quarter
        self.x: Array = basis.doflocs.T.copy()
        self.elements: Indices = basis.element_dofs.T
        highest = fem.p[2].max()
        self._faces = fem.facets_satisfying(lambda x: x[2] == highest) if top else fem.boundary_facets()

        axes = list(itertools.product(range(3), repeat=2))
        products = {(a, b): skfem.BilinearForm(lambda u, v, _: v.grad[a] * u.grad[b]).coo_data(basis)  # noqa: B023
                    for a, b in axes}
        row, column = products[0, 0].indices
        of = {at: product.data for at, product in products.items()}
        even, kept = mu * (of[0, 0] + of[1, 1] + of[2, 2]), lam if pressures is None else 0.0
        entries = np.stack([mu * of[b, a] + kept * of[a, b] + (even if a == b else 0.0) for a, b in axes])
        places = [np.stack([3 * at + axis[k] for axis in axes]).ravel() for k, at in enumerate((row, column))]
        k = sp.coo_matrix((entries.ravel(), places), (3 * basis.N, 3 * basis.N)).tocsr()
        for p in pressures(basis) if pressures else ():
            mean = self._means(basis.dx * p)
            k = k + lam * mean.T @ sp.diags(1.0 / (basis.dx * p**2).sum(1)) @ mean
        held = np.repeat(np.asarray(is_held(self.x))[:, None], 3, 1)
        self.held: Indices = np.flatnonzero(held[:, 0])
        if quarter:
            held[:, :2] |= self.x[:, :2] == self.x[:, :2].min(0)
        self.free: Indices = np.flatnonzero(~held.ravel())
        self.k = k[self.free][:, self.free].tocsc()

    def _means(self, weight: Array) -> sp.csr_matrix:
        """[t, 3 N]: int weight div u of every element."""
        slopes = np.stack([(shape[0].grad * weight).sum(-1) for shape in self._basis.basis])  # [shape, axis, t]
        column = 3 * self._basis.element_dofs[:, None, :] + np.arange(3)[:, None]
        row = np.broadcast_to(np.arange(len(weight)), column.shape)
        return sp.csr_matrix((slopes.ravel(), (row.ravel(), column.ravel())), (len(weight), 3 * self._basis.N))

    @functools.cached_property
    def factor(self) -> Factor:
        return Factor(self.k)

    def solve(self, forces: Array) -> Array:
        """[N, 3] m under forces [N, 3] N."""
        moved = np.zeros(forces.size)
        moved[self.free] = self.factor.solve(forces.ravel()[self.free])
        return moved.reshape(-1, 3)

    def inverse(self, unknowns: Indices) -> Array:
        """K^-1 at some unknowns, dense."""
        at = np.searchsorted(self.free, unknowns)
        b = np.zeros((len(self.free), len(at)))
        b[at, np.arange(len(at))] = 1.0
        return np.ascontiguousarray(self.factor.solve(b)[at])

    def shares(self, footprint: Footprint) -> Array:
        """[N] shares of the nodes of a load of 1. Raises LabError where the finger is not on the surface."""
        fem = self._basis.mesh
        corner = fem.p[:, fem.facets[:, self._faces]]  # [3, corner, face]
        longest = np.linalg.norm(np.ptp(corner, axis=1), axis=0)
        near = np.linalg.norm(corner[:, 0].T - footprint.centre, axis=1) < footprint.radius + longest
        load = np.zeros(len(self.x))
        if near.any():
            skfem = scikit_fem()
            points = _pieces(len(corner[0]))
            faces = skfem.FacetBasis(fem, self._basis.elem, facets=self._faces[near], quadrature=points)
            load = skfem.LinearForm(lambda v, w: footprint.pressure(np.moveaxis(w.x, 0, -1)) * v).assemble(faces)
        if not load.sum() > 0.0:
            raise LabError("the laboratory's finger is not on the surface: no node is under it")
        return load / load.sum()

    def loads(self, shares: Sequence[Array]) -> Array:
        """[free, 3 k]: of every finger a force along x, y, z."""
        return np.hstack([np.kron(share[:, None], np.eye(3)) for share in shares])[self.free]

    def compliances(self, shares: Sequence[Array]) -> Array:
        """C of each finger, [k, 3, 3]. A quarter gives under 1 N on it as the whole under 4 N."""
        w = self.loads(shares)
        x = self.factor.solve(w) / (4.0 if self._quarter else 1.0)
        return np.array([w[:, f:f + 3].T @ x[:, f:f + 3] for f in range(0, w.shape[1], 3)])

    def stiffness(self, footprints: Sequence[Footprint]) -> Array:
        """S = C^-1, [k, 3, 3] N/m."""
        return np.linalg.inv(self.compliances([self.shares(footprint) for footprint in footprints]))


@functools.lru_cache(None)
def _pieces(corners: int) -> tuple[Array, Array]:
    """Points [2, q] and weights [q] on a triangle or a square: it is cut into equal parts; of squares each has Gauss's
    nine points."""
    n = _PIECES
    if corners == 3:
        upright = [(3 * i + 1, 3 * j + 1) for i in range(n) for j in range(n - i)]
        turned = [(3 * i + 2, 3 * j + 2) for i in range(n) for j in range(n - i - 1)]
        return np.array(upright + turned).T / (3.0 * n), np.full(n * n, 0.5 / (n * n))
    at = ((np.arange(n)[:, None] + 0.5 + 0.5 * np.sqrt(0.6) * np.arange(-1, 2)) / n).ravel()
    weight = np.tile(np.array([5.0, 8.0, 5.0]) / 18.0 / n, n)
    return np.stack(np.meshgrid(at, at)).reshape(2, -1), np.outer(weight, weight).ravel()


class Tetrahedra(Solid):
    """Linear or quadratic tetrahedra, of straight edges; of quadratic ones the nodes in the middle of edges come after
    the corners.

    averaged: quadratic ones resist the mean change of their volume only (Crouzeix and Raviart 1973: one pressure an
    element, stable for any ratio)."""

    def __init__(self, mesh: Mesh, young: float, poisson: float, is_held: Callable[[Array], Any],
                 quadratic: bool = False, averaged: bool = False, quarter: bool = False) -> None:
        skfem, self.mesh = scikit_fem(), mesh
        element = skfem.ElementTetP2() if quadratic else skfem.ElementTetP1()
        super().__init__(mesh.fem, element, young, poisson, is_held,
                         (lambda basis: [np.ones(basis.dx.shape[1])]) if averaged else None, quarter, top=quarter)


class Bricks(Solid):
    """A box between planes, held at its lowest. p = (1, x, y, z) in every brick."""

    def __init__(self, planes: Sequence[Array], young: float, poisson: float, quarter: bool = False) -> None:
        skfem = scikit_fem()
        super().__init__(skfem.MeshHex.init_tensor(*planes), skfem.ElementHex2(), young, poisson,
                         lambda x: x[:, 2] == planes[2][0],
                         pressures=lambda basis: [np.ones(basis.dx.shape[1]), *(basis.X - 0.5)],
                         quarter=quarter, top=True)


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
