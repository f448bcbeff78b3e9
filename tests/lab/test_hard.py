# SPDX-License-Identifier: GPL-2.0-or-later
"""Every hard case is exact within the bound of its condition, or told, or refused with its cause."""

import math
from pathlib import Path

import numpy as np
import pytest
from lab import LabError, hard
from lab.reference import Mesh
from lab.specimens import cells, read_elements

DOUBLE, FLOAT = 2.0**-53, 2.0**-24  # unit roundoffs
NAMES = [case.name for case in hard.hard_cases(Path("build/hard/meshes"))]


def inverse_bound(reference):
    """What an entry of L may err by, as a share of sqrt(L_ii L_jj): a Cholesky factor is that of K + dK with |dk_ij| <=
    (a few) sqrt(n) u sqrt(k_ii k_jj) (Demmel 1989), and dL = -L dK L. Both sides of a comparison do, and the assembly
    rounds each k_ij: hence 8."""
    return 8.0 * math.sqrt(np.count_nonzero(np.einsum("ncnc->nc", reference.compliance))) * DOUBLE * reference.condition


def _expect_stiffness(body, reference):
    """Every S is symmetric, positive definite, and the reference's within the bound of its condition; precompute prints
    that condition, to a tenth of a digit."""
    bound, s = inverse_bound(reference), body.compare_stiffness(reference)
    assert s.in_terms_of_l <= 3.0 * bound, "of a block's 3 diagonal entries"
    assert s.asymmetry <= DOUBLE
    assert s.least_eigenvalue > 0.0
    checks = body.summary["checks"]
    assert abs(math.log10(checks["scaled_condition"] / reference.condition)) < 0.1
    assert abs(checks["largest_block_condition"] / s.condition - 1.0) <= s.condition * bound


def _expect_force(body, reference, god_object):
    """A finger that goes into a patch is felt, with the reference's force within the bound of S's condition: a force is
    some 24 roundings of its terms, and a god-object lies at a sum of three corners, found in float. Where the force is
    more than 1e-3 off, precompute has said so."""
    force = body.compare_force(reference, god_object, most=60)
    assert force.touches > 0
    assert force.missed == 0
    assert force.rounding <= 24.0 * FLOAT
    assert force.misplaced <= 8.0 * FLOAT
    if god_object == "nearest":  # whose finger presses as precompute's does
        assert force.worst <= 3.0 * body.stated, "what precompute states holds of other points, too"
    assert force.worst <= hard.MOST_ERROR or body.warned


@pytest.mark.parametrize("name", NAMES)
def test_a_hard_case_is_exact_or_told_or_refused(name, tmp_path, build):
    case, reference = next(case for case in hard.hard_cases(tmp_path) if case.name == name), None
    for force in hard.FORCES:
        if case.refusal:
            with pytest.raises(LabError) as refused:
                hard.HardBody(case, force, tmp_path / "out")
            assert case.refusal in str(refused.value)
            assert "\n" not in str(refused.value)
            assert not (tmp_path / "out").exists()
            continue
        body = hard.HardBody(case, force, tmp_path / "out")
        if reference is None:
            mesh = read_elements(tmp_path / "out/mesh.vtu")
            reference = hard.solve_densely(case.scene, *mesh, body.held)
        assert np.isfinite(reference.compliance).all()
        _expect_stiffness(body, reference)
        for god_object in ("nearest", "least-energy"):
            _expect_force(body, reference, god_object)


def test_the_reference_is_the_inverse_of_the_stiffness_of_one_tetrahedron():
    """Held on three corners, the fourth moves by the block of K of its gradient g: V (mu (g.g I + g g^T) + lambda g
    g^T)."""
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2.0]]), np.array([[0, 1, 2, 3]]))
    scene = {"mesh": {}, "material": {"young": 2.6, "poisson": 0.3}}  # mu 1, lambda 1.5
    reference = hard.solve_densely(scene, mesh.x, mesh.tets, np.array([True, True, True, False]))
    volume, g = 1.0 / 3.0, 0.5
    expected = np.diag([1.0, 1.0, 1.0 / 3.5]) / (volume * g**2)
    np.testing.assert_allclose(reference.compliance[3, :, 3], expected, rtol=4 * DOUBLE, atol=1e-15)
    assert reference.condition == pytest.approx(1.0)


@pytest.mark.parametrize("averaged", [False, True])
def test_the_reference_moves_rigidly_and_pulls_evenly(averaged):
    """A cube that is held on its three coordinate planes' nodes, all of them: K is positive definite, and symmetric."""
    mesh = cells((2, 2, 2))
    scene = {"mesh": {"element": "average-nodal-pressure"} if averaged else {},
             "material": {"young": 1.0, "poisson": 0.45}}
    reference = hard.solve_densely(scene, mesh.x, mesh.tets, mesh.x.min(1) == 0.0)
    flat = reference.compliance.reshape(3 * len(mesh.x), -1)
    np.testing.assert_allclose(flat, flat.T, rtol=0, atol=4 * DOUBLE * np.abs(flat).max())
    assert 1.0 < reference.condition < 1e3


@pytest.mark.parametrize("ratio", [1e-3, 1e-6])
def test_slivers_have_their_radius_ratio(ratio):
    mesh = hard.slivers(4, ratio)
    a, b, c = (mesh.x[mesh.tets[-1, k]] - mesh.x[mesh.tets[-1, 0]] for k in (1, 2, 3))
    volume = abs(a @ np.cross(b, c)) / 6
    areas = sum(np.linalg.norm(np.cross(p, q)) / 2 for p, q in ((a, b), (b, c), (c, a), (b - a, c - a)))
    circumradius = np.linalg.norm(a @ a * np.cross(b, c) + b @ b * np.cross(c, a) + c @ c * np.cross(a, b)) / (12
                                                                                                               * volume)
    assert 3 * (3 * volume / areas) / circumradius == pytest.approx(ratio, rel=64 * DOUBLE / ratio + 1e-3)


def test_eighty_tetrahedra_share_the_middle_of_the_ball():
    mesh = hard.hub()
    assert mesh.tets.shape == (80, 4)
    assert np.isin(0, mesh.tets).all()
    assert (mesh.tets == 0).any(1).all()
    assert len(mesh.x) == 43


def test_an_outcome_that_is_off_and_not_told_is_wrong():
    class Silent:
        warned = False
    case, off = hard.HardCase("a", {}), hard.ForceErrors(touches=1, worst=2e-3)
    assert hard.Outcome(Silent(), force=off).verdict(case) == "WRONG"
    assert hard.Outcome(Silent(), force=hard.ForceErrors(touches=1, worst=1e-4)).verdict(case) == "within 1e-3"
    assert hard.Outcome(Silent(), force=hard.ForceErrors(touches=1, missed=1)).verdict(case) == "WRONG"
    assert hard.Outcome(None, "fixed: all are loose").verdict(hard.HardCase("a", {}, "loose")) == "refused"
    assert hard.Outcome(None, "no such file").verdict(hard.HardCase("a", {}, "loose")) == "WRONG"
    Silent.warned = True
    assert hard.Outcome(Silent(), force=off).verdict(case) == "told"
