# SPDX-License-Identifier: GPL-2.0-or-later
"""The hard cases: bodies and materials at the ends of what is allowed, and past them, each against a dense reference in
long double: `make bench`, for docs/HARD.md. tests/lab/test_hard.py holds each to its bound."""

import itertools
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lab import LabError, binding, build, say, scenes
from lab.numbers import error_of, table, write_topics
from lab.reference import Array, Indices, Mesh, positive
from lab.scenes import Scene, vary
from lab.specimens import cells, cube_scene, grid, read_elements, write_tetgen

FORCES = ("interpolated", "consistent")
MOST_ERROR = 1e-3  #: of the servo's force: beyond it precompute warns
MOST_FORCE = 1e14  #: N: none is cut, it is the body's that is judged
PATCHES = 100  #: that a finger goes into, at the most
_SIDE = 0.03  # m, of the paper's cube


# ---- cases ---------------------------------------------------------------------------------------------------------

@dataclass(frozen=True)
class HardCase:
    name: str
    scene: Scene
    refusal: str = ""  #: what the error must say; empty: it is computed


def slivers(n: int, radius_ratio: float) -> Mesh:
    """The cube in two layers of n by n cells whose diagonals do not meet: on each face between them lies a sliver, four
    nodes near the corners of a square, of this radius ratio (three inradii over the circumradius)."""
    edge = _SIDE / n
    sag = radius_ratio * edge / np.sqrt(1.125)  # inradius sag / 4, circumradius edge / sqrt 2
    k, j, i = np.indices((3, n + 1, n + 1)).reshape(3, -1)
    points = np.stack([edge * i, edge * j, 0.5 * _SIDE * k - sag * i * j * (k == 1)], 1)
    number_of = np.arange(len(points)).reshape(3, n + 1, n + 1)
    below = cells((n, n, 1)).tets
    above = number_of[1:, :, ::-1].ravel()[below]  # mirrored
    flat = [number_of[1, j:j + n, i:i + n].ravel() for i, j in ((0, 0), (1, 1), (1, 0), (0, 1))]
    return Mesh(points, positive(points, np.vstack([below, above, np.stack(flat, 1)])))


def hub() -> Mesh:
    """A ball of 20 mm whose middle is one node that all 80 tetrahedra share: an icosahedron's faces, in four each."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    corner = np.array([np.roll([0.0, a, b], turn) for turn in range(3) for a in (-1, 1) for b in (-golden, golden)])
    middle = np.array([a + b for a, b in itertools.combinations(corner, 2) if np.linalg.norm(a - b) < 2.1])
    ball = np.vstack([corner, middle])
    ball *= 0.02 / np.linalg.norm(ball, axis=1, keepdims=True)
    faces = ConvexHull(ball).simplices + 1
    x = np.vstack([np.zeros(3), ball])
    return Mesh(x, positive(x, np.column_stack([np.zeros(len(faces), int), faces])))


def cone(sides: int) -> Mesh:
    """`sides` patches meet at its tip."""
    turn = 2.0 * np.pi * np.arange(sides) / sides
    ring = 0.02 * np.stack([np.cos(turn), np.sin(turn), np.zeros(sides)], 1)
    points = np.vstack([[[0.0, 0.0, 0.0], [0.0, 0.0, 0.02]], ring])
    return Mesh(points, positive(points, np.array([[0, 1, 2 + s, 2 + (s + 1) % sides] for s in range(sides)])))


def _cubes() -> list[HardCase]:
    """The paper's cube of other materials and sizes."""
    def of(name: str, young: float = 1e4, poisson: float = 0.3, side: float = _SIDE, element: str | None = None,
           **more: Any) -> HardCase:
        scene = cube_scene(5, poisson, top=False)
        base = [{"box": [-1e4, -1e4, -1e4, 1e4, 1e4, 1e-9 * side]}]
        return HardCase(name, vary(scene, name="hard-cube", mesh={"side": side, "element": element},
                                   material={"young": young}, fixed=base, **more))

    def below(young: float) -> dict[str, Any]:
        box = [-1.0, -1.0, 0.5 * _SIDE, 1.0, 1.0, 1.0]
        return {"region": [{"box": box, "young": young, "poisson": 0.3}]}
    averaged = "average-nodal-pressure"
    return [of("Poisson's ratio 0", poisson=0.0),
            of("Poisson's ratio 0, average nodal pressure", poisson=0.0, element=averaged),
            of("Poisson's ratio 0.4999", poisson=0.4999),
            of("Poisson's ratio 0.4999, average nodal pressure", poisson=0.4999, element=averaged),
            of("1 Pa", 1.0),
            of("200 GPa", 200e9),
            of("1e9 Pa over 1e3 Pa", 1e3, **below(1e9)),
            of("1e3 Pa over 1e9 Pa", 1e9, **below(1e3)),
            of("1 um", side=1e-6),
            of("100 m", side=100.0)]


def _meshes(folder: Path) -> list[HardCase]:
    """Bodies of other shapes, and held otherwise."""
    def of(name: str, mesh: Mesh, held: Any, refusal: str = "", young: float = 1e4) -> HardCase:
        """held: [N] bool of the mesh's nodes."""
        file = write_tetgen(mesh, folder / name.replace(" ", "-").replace(":", "-"))
        low, high = mesh.x.min(0), mesh.x.max(0)
        # More than the coordinates' rounding, less than the thinnest sliver.
        e = 1e-9 * np.linalg.norm(high - low) + 2.0**-50 * np.linalg.norm(0.5 * (low + high))
        fixed = [{"box": [*(x - e).tolist(), *(x + e).tolist()]} for x in mesh.x[held]]
        return HardCase(name, {"name": "hard-case", "mesh": {"file": str(file.resolve())},
                               "material": {"young": young, "poisson": 0.3}, "fixed": fixed or None}, refusal)

    def bar(name: str, count: tuple[int, int, int], size: tuple[float, float, float], held: Any, turned: bool = False,
            at: Any = (0.0, 0.0, 0.0), **more: Any) -> HardCase:
        """held: of the nodes of a box [0, size], which is then turned and moved."""
        mesh = cells(count)
        x = mesh.x * size
        # About no axis of the coordinates: entries of blocks in float then are of the stiffest direction's size.
        turn = Rotation.from_rotvec(0.7 * np.array([0.36, 0.48, 0.8])).as_matrix() if turned else np.eye(3)
        return of(name, Mesh(x @ turn.T + at, mesh.tets), held(x), **more)

    def near(*corners: tuple[float, float, float]) -> Any:
        return np.min([np.linalg.norm(plain.x - _SIDE * np.array(c), axis=1) for c in corners], 0) < 1e-6

    def far(name: str, diagonals: float) -> HardCase:
        at = np.array([0.6, -0.64, 0.48]) * diagonals * _SIDE * np.sqrt(3.0)
        return bar(name, (4, 4, 4), (_SIDE,) * 3, lambda x: x[:, 2] < 1e-3 * _SIDE, at=at)
    needle: Any = ((1, 1, 30), (0.001, 0.001, 0.1), lambda x: x[:, 2] < 1e-6)
    plate: Any = ((6, 6, 1), (0.1, 0.1, 0.001), lambda x: np.minimum(x, 0.1 - x)[:, :2].min(1) < 1e-6)
    plain = grid([np.linspace(0.0, _SIDE, 5)] * 3)  # as `generate = "cube"` has it
    sliver, ball, cones = slivers(4, 1e-6), hub(), {sides: cone(sides) for sides in (32, 60)}
    return [
        of("slivers of radius ratio 1e-6", sliver, sliver.x[:, 2] < 1e-9),
        bar("needle 1:100", *needle),
        bar("needle 1:100, askew", *needle, turned=True),
        bar("needle 1:100 of steel, askew", *needle, turned=True, young=200e9),
        bar("plate 1:100", *plate),
        bar("plate 1:100, askew", *plate, turned=True),
        of("held at three nodes", plain, near((0, 0, 0), (1, 0, 0), (0, 1, 0))),
        of("held at all nodes but one", plain, ~near((1, 1, 1))),
        # By the mesh alone: the pivots of K would tell too, but only after it was factorised, and "to rounding".
        of("held at one node", plain, near((0, 0, 0)), "fixed: 124 of 125 nodes are under-constrained"),
        of("free", plain, np.zeros(len(plain.x), bool), "fixed: 125 of 125 nodes are under-constrained"),
        of("80 tetrahedra at a node", ball, ball.x[:, 2] < -0.012),
        of("32 patches at a node", cones[32], cones[32].x[:, 2] < 1e-9),
        of("60 patches at a node", cones[60], cones[60].x[:, 2] < 1e-9, "60 touchable patches meet at node"),
        far("900 diagonals from the origin", 900),
        far("1e6 diagonals from the origin", 1e6)]


def hard_cases(folder: Path) -> list[HardCase]:
    """Meshes are written below `folder`. Small: some hundred nodes at most."""
    return _cubes() + _meshes(folder)


# ---- the reference -------------------------------------------------------------------------------------------------

@dataclass(frozen=True)
class Reference:
    """L = K^-1 by dense elimination in long double, from the mesh and the elements' energies."""

    compliance: Array  #: [N, 3, N, 3] m/N, 0 at held nodes; rounded to double last
    condition: float  #: largest over least eigenvalue of K scaled to a diagonal of 1


def _materials(scene: Scene, middle: Array) -> tuple[Array, Array, Indices]:
    """lambda and mu of tetrahedra with these middles [t, 3], in long double, and the number of their region."""
    number_of = np.zeros(len(middle), np.int64)
    materials = [scene["material"], *scene.get("region", [])]
    for r, region in enumerate(materials[1:], 1):
        box = np.array(region["box"])
        number_of[((middle >= box[:3]) & (middle <= box[3:])).all(1)] = r
    young, nu = (np.array([m[key] for m in materials], np.longdouble)[number_of] for key in ("young", "poisson"))
    return young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu)), number_of


def solve_densely(scene: Scene, x: Array, tets: Indices, held: Any) -> Reference:
    """K = sum_e V_e B^T D B. held: [N] bool. Takes n^3 operations of the x87: some hundred nodes at most."""
    lame, mu, region = _materials(scene, x[tets].mean(1))
    p = x.astype(np.longdouble)[tets]
    a, b, c = (p[:, k] - p[:, 0] for k in (1, 2, 3))
    six = np.einsum("tc,tc->t", a, np.cross(b, c))
    g = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], 1) / six[:, None, None]  # of corners 1 to 3
    g = np.concatenate([-g.sum(1, keepdims=True), g], 1)  # [t, 4, 3]
    volume = np.abs(six) / 6
    averaged = scene["mesh"].get("element") == "average-nodal-pressure"
    kept = np.minimum(lame, mu / 2) if averaged else lame
    # mu (g_a . g_b I + g_b g_a^T) + lambda g_a g_b^T
    outer = np.einsum("tac,tbd->tacbd", g, g)
    k_e = kept[:, None, None, None, None] * outer + mu[:, None, None, None, None] * (
        outer.transpose(0, 1, 4, 3, 2) + np.einsum("tae,tbe,cd->tacbd", g, g, np.eye(3)))
    k_e *= volume[:, None, None, None, None]
    rows = (3 * tets[:, :, None] + np.arange(3)).reshape(len(tets), 12)
    k = np.zeros((3 * len(x), 3 * len(x)), np.longdouble)
    np.add.at(k, (rows[:, :, None], rows[:, None, :]), k_e.reshape(-1, 12, 12))
    if averaged:  # theta_a: the mean of div u over the elements of one material at a node, by V_e / 4
        for r, node in itertools.product(np.unique(region), range(len(x))):
            at = np.flatnonzero((region == r) & (tets == node).any(1))
            if len(at):
                theta = np.zeros(len(k), np.longdouble)
                np.add.at(theta, rows[at], (volume[at, None, None] / 4 * g[at]).reshape(-1, 12))
                rest = (lame - kept)[at[0]]
                k += rest / (volume[at].sum() / 4) * np.outer(theta, theta)
    free = np.flatnonzero(np.repeat(~held, 3))
    k = k[np.ix_(free, free)]
    root = np.sqrt(np.diag(k))
    scaled = k / np.outer(root, root)
    inverse = _inverse(scaled)
    compliance = np.zeros((3 * len(x), 3 * len(x)))
    compliance[np.ix_(free, free)] = (inverse / np.outer(root, root)).astype(float)
    condition = np.linalg.eigvalsh(scaled.astype(float))[-1] * np.linalg.eigvalsh(inverse.astype(float))[-1]
    return Reference(compliance.reshape(len(x), 3, len(x), 3), float(condition))


def _inverse(a: Any) -> Any:
    """Of a positive definite matrix in long double, by its Cholesky factor."""
    n, factor = len(a), a.copy()
    for i in range(n):
        factor[i:, i] /= np.sqrt(factor[i, i])
        factor[i + 1:, i + 1:] -= np.outer(factor[i + 1:, i], factor[i + 1:, i])
    y = np.eye(n, dtype=np.longdouble)
    for i in range(n):
        y[i] = (y[i] - factor[i, :i] @ y[:i]) / factor[i, i]
    return y.T @ y


# ---- what came out -------------------------------------------------------------------------------------------------

@dataclass
class StiffnessErrors:
    """S of every touchable free node, in double, against the reference's S_d."""

    worst: float = 0.0  #: |S - S_d| / |S_d|
    in_terms_of_l: float = 0.0  #: the same over cond(S): what L_ii was off by, whatever the inverse magnified
    asymmetry: float = 0.0  #: |S - S^T| / |S|
    least_eigenvalue: float = 1.0  #: of any S over its largest: below 0, S would pull
    condition: float = 1.0  #: of the worst S


@dataclass
class ForceErrors:
    """The servo's force as a finger goes straight into patches, one after the other, spread over the body."""

    touches: int = 0
    missed: int = 0
    worst: float = 0.0  #: |F - F_d| / |F_d|, F_d by the reference for the same finger and area coordinates
    rounding: float = 0.0  #: the same from the servo's own god-object, over cond(S): in units of 1, a few 2^-24
    misplaced: float = 0.0  #: from the god-object to its area coordinates' point, of the largest coordinate


class HardBody:
    """A case with its tables, through the whole way: scene to servo. Raises LabError where the case is refused."""

    def __init__(self, case: HardCase, force: str, folder: Path) -> None:
        self.force, self.folder = force, folder
        self.summary = scenes.precompute(vary(
            case.scene, contact={"force": force}, device={"max_force": MOST_FORCE, "mean_force": "off"},
            tables={"columns": "none"}), folder)
        self.held = meshio.read(folder / "mesh.vtu").point_data["fixed"].ravel() > 0
        self.stated = float(self.summary["force_error"]["servo"])
        self.warned = any("float32 loses" in w or "badly conditioned" in w for w in self.summary["warnings"])

    def compare_stiffness(self, reference: Reference) -> StiffnessErrors:
        nodes = np.load(self.folder / "node_id.npy")
        s = np.load(self.folder / "stiffness.npy").reshape(-1, 3, 3)
        turned = s.transpose(0, 2, 1)
        exact = np.linalg.inv(reference.compliance[nodes, :, nodes])
        off, condition = _off(s, exact), np.linalg.cond(exact)
        value = np.linalg.eigvalsh(0.5 * (s + turned))
        return StiffnessErrors(off.max(), (off / condition).max(), _off(s, turned).max(),
                               (value[:, 0] / value[:, 2]).min(), condition.max())

    def stiffness_at(self, reference: Reference, nodes: Indices, alpha: Array) -> Array:
        """S at area coordinates of nodes: sum alpha_a (L_aa)^-1, or (sum alpha_a alpha_b L_ab)^-1 with the servo's rule
        for held nodes."""
        rigid = self.summary["contact"]["rigid_stiffness_n_per_m"]
        if self.force == "interpolated":
            return np.sum([w * (rigid * np.eye(3) if self.held[n] else np.linalg.inv(reference.compliance[n, :, n]))
                           for w, n in zip(alpha, nodes)], 0)
        c = np.einsum("a,b,acbd->cd", alpha, alpha, reference.compliance[nodes][:, :, nodes])
        more: float = max(0.0, alpha[self.held[nodes]].sum() / rigid - np.trace(c) / 3.0)
        return np.linalg.inv(c + more * np.eye(3))

    def compare_force(self, reference: Reference, god_object: str = "nearest", most: int = PATCHES) -> ForceErrors:
        haptable = binding.load()
        body = haptable.load(self.folder, god_object=god_object, bare=True)
        depth, missed, found = self.summary["force_error"]["depth_m"], 0, []
        for a, b, c in body.rest[body.patches[::max(1, len(body.patches) // most)]]:
            normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
            on = 0.41 * a + 0.32 * b + 0.27 * c
            finger = on - depth * normal
            felt = body.servo().replay([on + depth * normal, finger])[1]
            if felt["state"] not in (haptable.State.CONTACT, haptable.State.LIMITED):
                missed += 1
                continue
            alpha, corners, force = felt["alpha"].astype(float), body.rest[felt["nodes"]], felt["force"].astype(float)
            at = alpha @ corners
            s = self.stiffness_at(reference, felt["nodes"], alpha)
            own = -s @ (np.float32(finger).astype(float) - felt["god_object"])
            found.append([_off(force, -s @ (finger - at)), _off(force, own) / np.linalg.cond(s),
                          np.linalg.norm(felt["god_object"] - at) / np.abs(corners).max()])
        return ForceErrors(len(found), missed, *np.max(found or np.zeros((1, 3)), 0).tolist())


def _off(measured: Array, exact: Array) -> Any:
    """Of a vector, or of each matrix of a list."""
    axis = (1, 2) if exact.ndim == 3 else None
    return np.linalg.norm(measured - exact, axis=axis) / np.linalg.norm(exact, axis=axis)


@dataclass
class Outcome:
    body: HardBody | None
    refused: str = ""
    stiffness: StiffnessErrors = field(default_factory=StiffnessErrors)
    force: ForceErrors = field(default_factory=ForceErrors)

    def verdict(self, case: HardCase) -> str:
        """ "WRONG" where the case is neither exact nor told nor refused with its cause."""
        if case.refusal or self.refused or self.body is None:
            return "refused" if case.refusal and case.refusal in self.refused else "WRONG"
        s, f = self.stiffness, self.force
        if not (s.least_eigenvalue > 0.0 and f.touches and not f.missed and np.isfinite(f.worst)):
            return "WRONG"
        return "told" if self.body.warned else "WRONG" if f.worst > MOST_ERROR else "within 1e-3"


def measure(case: HardCase, folder: Path) -> list[Outcome]:
    """By each force."""
    outcomes, reference = [], None
    for force in FORCES:
        try:
            body = HardBody(case, force, folder)
        except LabError as error:
            outcomes.append(Outcome(None, str(error)))
            continue
        reference = reference or solve_densely(case.scene, *read_elements(folder / "mesh.vtu"), body.held)
        outcomes.append(Outcome(body, "", body.compare_stiffness(reference), body.compare_force(reference)))
    return outcomes


def make(out: Path) -> None:
    """The hard cases, each against a dense reference in long double."""
    rows, remedies = [], []
    for case in hard_cases(build() / "hard/meshes"):
        say(case.name)
        outcomes = measure(case, build() / "hard/tables")
        verdicts = [outcome.verdict(case) for outcome in outcomes]
        verdict = next(v for v in ("WRONG", "told", "within 1e-3", "refused") if v in verdicts)
        if verdict == "WRONG":
            raise LabError(f"hard case \"{case.name}\": is neither exact nor told nor refused with its cause "
                           f"{''.join(o.refused for o in outcomes)}")
        bodies = [outcome.body for outcome in outcomes if outcome.body]
        errors = [] if not bodies else [
            bodies[0].summary["checks"]["scaled_condition"], outcomes[0].stiffness.worst,
            *(outcome.force.worst for outcome in outcomes), max(body.stated for body in bodies)]
        rows.append([case.name, *(map(error_of, errors) if errors else [""] * 5), verdict])
        remedies += [[case.name, body.force, error_of(body.stated), remedy["scene"], error_of(remedy["servo"])]
                     for body in bodies for remedy in body.summary["force_error"].get("remedies", [])]
    write_topics(out, {
        "hard": table("case | condition of K, scaled | S in double | force of the servo, interpolated | "
                      "the same, consistent | what the tool states | verdict", rows),
        "hard-remedies": table("case | force | error stated | what helps | error then", remedies)})
