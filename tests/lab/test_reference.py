# SPDX-License-Identifier: GPL-2.0-or-later
"""The body itself by elements that are not the product's: against closed forms, against what an earlier program of
other elements found, and the product against them."""

import json
import subprocess

import numpy as np
import pytest
import scipy.sparse as sp

from lab import LabError, binding, scenes
from lab.cholmod import Factor
from lab.elements import Masked
from lab.error import Discrete, conjugate_gradients, felt_at, time_ticks
from lab.figure import ROOT
from lab.known import dimitriadis, pulled_apart
from lab.large_strain import NeoHooke, departure, depth_off, where_off
from lab.reference import Bricks, Footprint, Mesh, Tetrahedra, graded, hertz, lame, uniform
from lab.specimens import (Place, cells, cube_scene, grid, mesh_of, mesh_places, read_vtu, reference, spiral, truth_of,
                           write_tetgen)

ROUNDING = 1e-9  # of a factor of condition 1e6 in double

MIDDLE = np.array([0.015, 0.015, 0.03])  # of the cube's top


def skfem():
    pytest.importorskip("skfem", reason="no scikit-fem: make lab")


# ---- elements ------------------------------------------------------------------------------------------------------

def test_the_factor_solves_and_says_what_is_not_definite():
    random = np.random.default_rng(1)
    a = sp.random(200, 200, 0.05, random_state=1)
    k = a @ a.T + sp.eye(200)
    b = random.normal(size=(200, 3))
    factor = Factor(k)
    assert np.abs(k @ factor.solve(b) - b).max() < 1e-10
    assert factor.solve(b[:, 0]).shape == (200,) and factor.bytes > 8 * 200
    with pytest.raises(LabError, match="not positive definite"):
        Factor(sp.diags([1.0, -1.0, 1.0]))


def given_by_a_box(poisson, radius, *pressure):
    """By bricks along z under a unit force: held at its base as a column that may shrink is not."""
    skfem()
    body = Bricks([np.linspace(0, 1, 3)] * 2 + [graded(0.0, 2.0, 0.5, 1.0, 2, 2)], 3.0, poisson)
    return body.compliances([body.shares(Footprint(np.array([0.5, 0.5, 2.0]), radius, *pressure))])[0][2, 2]


def test_bricks_without_poissons_effect_are_a_column():
    """u = F z / E A, exactly: ratio 0."""
    assert given_by_a_box(0.0, 1e3, uniform) == pytest.approx(2.0 / 3.0, rel=ROUNDING)


def test_bricks_do_not_lock():
    assert given_by_a_box(0.49, 0.4) / given_by_a_box(0.4999, 0.4) < 1.05  # of a body; linear tetrahedra double


@pytest.mark.parametrize("quadratic", [False, True])
def test_tetrahedra_pass_the_patch_test(quadratic):
    """A linear field needs no force on inner nodes."""
    skfem()
    mesh = grid([np.array([0, 0.3, 0.5, 1.0])] * 3)
    body = Tetrahedra(mesh, 2.0, 0.4, lambda x: np.zeros(len(x), bool), quadratic)
    field = body.x @ np.array([[1, 2, 3], [4, 5, 6], [7, 8, 10]]) * 1e-3
    force = (body.k @ field.ravel()).reshape(-1, 3)
    inside = ((body.x > 0) & (body.x < 1)).all(1)
    assert inside.any() and np.abs(force[inside]).max() < ROUNDING * np.abs(force).max()


@pytest.mark.parametrize(("name", "radius"), [("mouse", 0.010), ("liver", 0.015)])
def test_the_body_is_what_docs_say(name, radius, tmp_path, build):
    """Places and stiffnesses that a program of other elements' code found are kept in docs/numbers.json."""
    skfem()
    kept = truth_of(json.loads((ROOT / "docs/numbers.json").read_text()), name)
    scene = scenes.read(ROOT / f"meshes/{name}.toml")
    body = reference(scene, mesh_of(scene, tmp_path / "mesh"))
    places = mesh_places(scene, body.mesh, np.load(tmp_path / "mesh/surface.npy").astype(np.int64), radius)
    c = body.compliances([body.shares(Footprint(p.on, radius)) for p in places])
    for place, one, truth in zip(places, c, kept):
        assert np.abs(place.on - truth.place.on).max() < 1e-12
        normal = place.outward @ np.linalg.inv(one) @ place.outward
        assert normal == pytest.approx(truth.normal * (1.0 + truth.coarser), rel=ROUNDING)


def test_cutting_in_eight_keeps_the_body():
    skfem()
    mesh = cells((2, 1, 1))
    fine = mesh.in_eight()

    def volume(m):
        a, b, c, d = (m.x[m.tets[:, k]] for k in range(4))
        return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    assert len(fine.tets) == 8 * len(mesh.tets) and volume(fine).min() > 0
    assert volume(fine).sum() == pytest.approx(1.0) and len(fine.surface) == 4 * len(mesh.surface)
    assert (fine.x[:len(mesh.x)] == mesh.x).all()


def test_a_finger_beside_the_surface_is_an_error():
    skfem()
    body = Tetrahedra(cells((1, 1, 1)), 1.0, 0.3, lambda x: x[:, 2] == 0)
    with pytest.raises(LabError, match="no node is under it"):
        body.shares(Footprint(np.array([5.0, 0, 0]), 0.1))
    shares = body.shares(Footprint(np.array([0.5, 0.5, 1.0]), 0.4, hertz))
    assert shares.sum() == pytest.approx(1.0) and np.abs(shares[body.x[:, 2] == 0]).max() < 1e-15


# ---- the product beside them ---------------------------------------------------------------------------------------

@pytest.mark.parametrize(("radius", "poisson"), [(0.004, 0.3), (0.005, 0.3), (0.004, 0.4999)])
def test_quadratic_tetrahedra_are_the_body_where_a_finger_is_as_wide_as_two_edges(radius, poisson, tmp_path, build):
    """A finger of little more than an edge: 3.75 mm between corners. With all of lambda in the elements (C3D10) a
    pressure that is integrated exactly meets 6.4 % too much at a ratio of 0.3, for the mesh is too coarse: half of
    that."""
    across = graded(0.015, 0.03, 0.015, 0.0225, 6, 2)
    quarter = Bricks([across, across, graded(0.0, 0.03, 0.0225, 0.03, 4, 3)], 1e4, poisson, quarter=True)
    body = 1.0 / quarter.compliances([quarter.shares(Footprint(MIDDLE, radius))])[0][2, 2]
    masked = Masked(cube_scene(9, 0.3), "quadratic", radius, tmp_path / "t")
    felt = masked.at(poisson, [Place(MIDDLE, np.array([0.0, 0.0, 1.0]))])[0]
    assert felt / body == pytest.approx(1.0, abs=0.032)


@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("is_free", [False, True])
def test_modes_are_those_of_the_same_mesh(element, is_free, tmp_path, build):
    """K and M by scikit-fem, the least eigenvalues by SciPy's eigsh. Quadratic ones with a ratio of 0.16 are C3D10."""
    skfem()
    import scipy.sparse.linalg as sla
    from skfem import Basis, BilinearForm, ElementTetP1, ElementTetP2, ElementVector, MeshTet, asm
    from skfem.helpers import dot
    scene = {**cube_scene(5, 0.16, top=False), "body": {"modes": 8, "mode_damping": 0.05, "density": 1000.0}}
    scene["mesh"] = {**scene["mesh"], "element": element}
    if is_free:
        scene["body"]["free"] = True
        del scene["fixed"]
    found = scenes.precompute(scene, tmp_path / "t")["modes"]["frequency_hz"]
    mesh = mesh_of(cube_scene(5, 0.16, top=False), tmp_path / "mesh")
    free = [] if is_free else [0.0]
    body = Tetrahedra(mesh, 1e4, 0.16, lambda x: np.isin(x[:, 2], free), element == "quadratic")
    basis = Basis(MeshTet(mesh.x.T.copy(), mesh.tets.T.copy()),
                  ElementVector(ElementTetP2() if element == "quadratic" else ElementTetP1()), intorder=4)
    mass = 1000.0 * asm(BilinearForm(lambda u, v, _: dot(u, v)), basis).tocsr()[body.free][:, body.free]
    omega2 = sla.eigsh(body.k, k=8 + 6 * is_free, M=mass.tocsc(), sigma=-1.0, return_eigenvectors=False)
    wanted = np.sqrt(np.sort(np.abs(omega2))[6 * is_free:]) / (2 * np.pi)
    assert np.array(found[:8]) == pytest.approx(wanted, rel=1e-6)


def test_a_tick_of_a_folder_is_timed_in_every_precision(tmp_path, build):
    scenes.precompute(cube_scene(5, 0.3), tmp_path / "t")
    timed = time_ticks([tmp_path / "t"], 0.001, 100, 3)
    assert [(t["precision"], t["god_object"]) for t in timed] == [
        (p, g) for p in ("float32", "float16", "int16") for g in ("nearest", "least-energy")]
    assert all(len(t["tick_s"]) == 3 and min(t["tick_s"]) > 0 for t in timed)
    assert timed[0]["bytes"] == timed[1]["bytes"] > timed[4]["bytes"] > timed[2]["bytes"]


#: Of a cube of 5 nodes a side, nu 0.3, by another program: error RMS and mean error.
OLD_POINTS = {("interpolated", "nearest", "float32"), ("consistent", "least-energy", "float16"),
              ("pressure-mask", "nearest", "int16")}


def test_errors_are_those_that_docs_have(tmp_path, build):
    topics = json.loads((ROOT / "docs/numbers.json").read_text())
    truths = truth_of(topics, "cube, nu 0.3")
    kept = {tuple(row[3:6]): row for row in topics["points"]["rows"]
            if row[:3] == ["cube, nu 0.3", "5 a side", "linear"]}
    for force, god_object, precision in OLD_POINTS:
        scenes.precompute(scenes.touched(cube_scene(5, 0.3), force, 0.005), tmp_path / force)
        body = binding.load().load(tmp_path / force, precision=precision, god_object=god_object, bare=True)
        off = [np.linalg.norm(felt_at(body, t.place, 0.001) - f) / np.linalg.norm(f)
               for t in truths for f in [t.force(god_object == "least-energy", 0.001)]]
        assert np.sqrt(np.mean(np.square(off))) == pytest.approx(kept[force, god_object, precision][6]["value"],
                                                                 rel=1e-4)


def test_gradients_find_what_the_factor_does(tmp_path, build):
    skfem()
    scene = scenes.touched(cube_scene(5, 0.3), "pressure-mask", 0.005)
    scenes.precompute(scene, tmp_path / "t")
    on = Discrete(scene, tmp_path / "t")
    place = spiral((0.015, 0.015, 0.03), 0.008, 1)[0]
    w = on.body.loads([on.mask(*on.locate(place.on))])
    assert w.sum() == pytest.approx(3.0, rel=1e-6)
    exact = on.body.factor.solve(w)
    near = conjugate_gradients(on.body.k.tocsr(), w, np.zeros_like(w))
    assert np.linalg.norm(on.body.k @ near - w, axis=0) == pytest.approx(0,
                                                                         abs=1.1e-3 * np.linalg.norm(w, axis=0).max())
    assert np.linalg.norm(near - exact) < 0.05 * np.linalg.norm(exact)
    with pytest.raises(LabError, match="on no patch"):
        on.locate(np.array([0.5, 0.5, 0.5]))


# ---- large strain --------------------------------------------------------------------------------------------------

def test_the_force_departs_from_the_linear_one_as_its_series_says(tmp_path, build):
    """Newton's method on a small body, against a and b."""
    skfem()
    body = reference(cube_scene(4, 0.3), mesh_of(cube_scene(4, 0.3), tmp_path / "mesh"), quadratic=False)
    law = NeoHooke(body, 1e4, 0.3)
    shares = body.shares(Footprint(MIDDLE, 0.012))
    a, b = departure(body, law, shares, np.array([0.0, 0.0, -1.0]))
    s = np.linalg.inv(body.compliances([shares])[0])[2, 2]
    ratios = []
    for depth in (2e-4, 4e-4):
        u, held = np.zeros_like(body.x), np.array([0.0, 0.0, -depth])
        force = np.zeros(3)
        for _ in range(40):  # the linear body's factor is near enough to converge
            left = np.outer(shares, force) - law.forces(law.stress(u))
            free = body.solve(left)
            pull = np.linalg.solve(body.compliances([shares])[0], held - shares @ (u + free))
            u, force = u + free + body.solve(np.outer(shares, pull)), force + pull
        ratios.append((-force[2] / (s * depth) - 1.0) / depth)
    # (F / F_linear - 1) / t = a + b t + c t^2, c of the order of a b
    assert 2 * ratios[0] - ratios[1] == pytest.approx(a, rel=1e-3)
    assert (ratios[1] - ratios[0]) / 2e-4 == pytest.approx(b, rel=0.1)


def test_where_a_force_is_off():
    assert where_off([(0.001, 1.02), (0.002, 1.10)], 0.05) == pytest.approx(0.001 + 0.03 / 0.08 * 0.001)
    assert where_off([(0.001, 0.99)], 0.05) == float("inf")
    assert depth_off(0.0, -100.0, 0.04) == pytest.approx(0.02)
    assert depth_off(0.0, 0.0, 0.04) == float("inf")


def test_known_laws():
    assert dimitriadis(1e-9, 0.3) == pytest.approx(1.0, abs=1e-8)
    assert lame(1.0, 0.25) == pytest.approx((0.4, 0.4))
    forces = pulled_apart(np.arange(9), 9)
    assert forces[3] == pytest.approx(-forces[6] / 0.4)


def test_a_mesh_that_is_written_is_read_by_the_product(tmp_path, build):
    mesh = cells((2, 2, 2))
    scene = {**cube_scene(5, 0.3, top=False), "mesh": {"file": str(write_tetgen(mesh, tmp_path / "six"))}}
    scenes.precompute(scene, tmp_path / "t")
    read = read_vtu(tmp_path / "t/mesh.vtu")
    assert (read.x == mesh.x).all() and len(read.tets) == 48 and isinstance(read, Mesh)


def test_ticks_of_no_folder_are_an_error(build, capfd):
    with pytest.raises(LabError, match="ended with status"):
        time_ticks([ROOT / "no-such-folder"], 0.001, 10, 1)
    assert "no-such-folder" in capfd.readouterr().err
    assert subprocess.run([str(build / "bin/haptable-bench-ticks"), "--help"], capture_output=True,
                          check=False).returncode == 0
