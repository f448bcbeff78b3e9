# SPDX-License-Identifier: GPL-2.0-or-later
"""How far linear bodies go: forces beside CalculiX's at large strain, many minutes: `make bench-large
PART=large-strain`.

F / F_linear = 1 + a t + b t^2 at a depth t, of a neo-Hookean body of linear tetrahedra:
  phi the displacements for a depth of 1, f_2 and f_3 the forces that its second and third order ask for, v what f_2
  gives where the finger holds still,   S = phi . K phi,   a = phi . f_2 / S,   b = (phi . f_3 + 2 v . f_2) / S
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab import say
from lab.calculix import Deck, displacements
from lab.numbers import Topics, number, table
from lab.reference import Array, Footprint, Tetrahedra, lame
from lab.scenes import Scene
from lab.specimens import Place, mesh_of, reference, specimens, truth_of

_LEVELS = 10


# ---- what is expected ----------------------------------------------------------------------------------------------

class NeoHooke:
    """Forces of linear tetrahedra whose energy is mu / 2 (J^-2/3 |F|^2 - 3) + kappa / 2 (J - 1)^2: CalculiX's."""

    def __init__(self, body: Tetrahedra, young: float, poisson: float) -> None:
        lam, self.mu = lame(young, poisson)
        self.kappa = lam + 2.0 / 3.0 * self.mu
        corner = body.mesh.x[body.mesh.tets]
        edges = corner[:, 1:] - corner[:, :1]
        self.volume = np.abs(np.linalg.det(edges)) / 6.0
        slope = np.linalg.inv(edges).transpose(0, 2, 1)
        self.gradient = np.concatenate([-slope.sum(1, keepdims=True), slope], 1)  # [t, 4, 3]
        self.tets, self.nodes = body.mesh.tets, len(body.mesh.x)

    def stress(self, u: Array) -> Array:
        """First Piola-Kirchhoff, [t, 3, 3]."""
        f = np.eye(3) + np.einsum("tac,tad->tcd", u[self.tets], self.gradient)
        j = np.linalg.det(f)[:, None, None]
        turned = np.linalg.inv(f).transpose(0, 2, 1)
        size = (f * f).sum((1, 2))[:, None, None]
        return self.mu * j ** (-2.0 / 3.0) * (f - size / 3.0 * turned) + self.kappa * (j - 1.0) * j * turned

    def forces(self, stress: Array) -> Array:
        """[N, 3] N that nodes ask for."""
        on = np.einsum("t,tcd,tad->tac", self.volume, stress, self.gradient)
        return np.stack([np.bincount(self.tets.ravel(), on[..., c].ravel(), self.nodes) for c in range(3)], 1)

    def orders(self, u: Array) -> tuple[Array, Array]:
        """f_2, f_3 of the series in u, by differences: the strain of a difference is 1e-2 and 2e-2, so that of the
        fifth order 1e-8 remains."""
        h = 1e-2 / np.abs(np.einsum("tac,tad->tcd", u[self.tets], self.gradient)).max()
        p = {k: self.stress(k * h * u) for k in (-2, -1, 1, 2)}
        second = (16.0 * (p[1] + p[-1]) - (p[2] + p[-2])) / (24.0 * h**2)
        third = (p[2] - p[-2] - 2.0 * (p[1] - p[-1])) / (12.0 * h**3)
        return self.forces(second), self.forces(third)


def departure(body: Tetrahedra, law: NeoHooke, shares: Array, way: Array) -> tuple[float, float]:
    """a per m, b per m^2, for a finger that holds the mean of its nodes' displacements in every direction."""
    c = body.compliances([shares])[0]
    pressed = np.outer(shares, np.linalg.solve(c, way))
    phi = body.solve(pressed)
    second, third = law.orders(phi)
    free = -body.solve(second)
    v = free - body.solve(np.outer(shares, np.linalg.solve(c, shares @ free)))
    s = float((phi * pressed).sum())
    return float((phi * second).sum() / s), float(((phi * third).sum() + 2.0 * (v * second).sum()) / s)


def depth_off(a: float, b: float, share: float) -> float:
    """Least t at which |a t + b t^2| is `share`; infinite where it never is."""
    roots = [t.real for sign in (-1.0, 1.0) for t in np.roots([b, a, sign * share]) if abs(t.imag) < 1e-12
             and t.real > 0.0]
    return min(roots, default=float("inf"))


# ---- what CalculiX finds -------------------------------------------------------------------------------------------

def pull(body: Tetrahedra, material: dict[str, float], shares: Array, way: Array, step: float,
         folder: Path) -> list[tuple[float, float]]:
    """Displacement and ratio of the force to the linear one, a level each. The forces are those that the linear body
    answers with a step along the way, two steps, ...; what the other one gives under them is taken along the force:
    that is what does work. Where the body gives way aside too, the two directions are not one."""
    n_per_m = np.linalg.solve(body.compliances([shares])[0], way)
    loads = [np.outer(shares, step * level * n_per_m) for level in range(1, _LEVELS + 1)]
    felt, deck = [], Deck(body.x, body.elements, body.held, **material, large_strain=True)
    for level, moved in enumerate(displacements(deck, loads, folder), 1):
        u = float(shares @ (moved @ n_per_m) / (way @ n_per_m))
        felt.append((u, step * level / u))
    return felt


def where_off(felt: Sequence[tuple[float, float]], off: float) -> float:
    """Where |ratio - 1| first comes to `off`, between the levels; infinite: not within them."""
    u, ratio = np.array([(0.0, 1.0), *felt]).T
    away = np.abs(ratio - 1.0)
    k = next((k for k in range(1, len(u)) if away[k] >= off), None)
    return float("inf") if k is None else float(np.interp(off, away[k - 1:k + 1], u[k - 1:k + 1]))


def aside(n: Array) -> Array:
    """A unit vector at right angles."""
    is_upright = max(abs(n[0]), abs(n[1])) <= 1e-12 * abs(n[2])
    beside = np.array([0.0, -n[2], n[1]]) if is_upright else np.array([-n[1], n[0], 0.0])
    return beside / np.linalg.norm(beside)


def _depth(u: float, furthest: float) -> Any:
    return f"over {1e3 * furthest:.1f} mm" if u > furthest else number(u, "{:.1f} mm", 1e3)


def measure(name: str, scene: Scene, radius: float, place: Place, folder: Path) -> tuple[list[Any], list[Any]]:
    """Rows of limits and of the curve."""
    body = reference(scene, mesh_of(scene, folder / f"{scene['name']}-large"), quadratic=False)
    shares = body.shares(Footprint(place.on, radius))
    law = NeoHooke(body, **scene["material"])
    limits, curve = [], []
    for course, way in {"pressing": -place.outward, "pulling": place.outward, "sideways": aside(place.outward)}.items():
        say(f"large strain: {name}, {course}")
        a, b = departure(body, law, shares, way)
        felt = pull(body, scene["material"], shares, way, 0.2 * radius, folder / f"{scene['name']}-{course}")
        limits.append([name, course, *(_depth(u, felt[-1][0]) for off in (0.05, 0.1, 0.2)
                                       for u in (where_off(felt, off), depth_off(a, b, off)))])
        curve += [[name, course, number(u, "{:.2f} mm", 1e3), number(ratio, "{:.3f}"),
                   number(1.0 + u * (a + u * b), "{:.3f}")] for u, ratio in felt]
    return limits, curve


def large_strain(topics: Topics, folder: Path) -> Topics:
    measured = [measure(one.name, one.meshes[-1].scene, one.radius, truth_of(topics, one.name)[0].place, folder)
                for one in specimens(True, folder)]
    limits, curve = (sum(rows, []) for rows in zip(*measured))
    offs = "5 % off | expected | 10 % off | expected | 20 % off | expected"
    return {"large-strain": table(f"body | way | {offs}", limits),
            "large-strain-curve": table("body | way | displacement | force over the linear one | expected", curve)}
