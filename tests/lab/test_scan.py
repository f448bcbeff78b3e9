# SPDX-License-Identifier: GPL-2.0-or-later
"""A surface with the noise of a scanner."""

import numpy as np
import pytest
from lab import scan
from lab.reference import Mesh
from lab.specimens import cells


def test_the_surface_is_closed_and_looks_outwards():
    mesh = cells((3, 2, 2))
    patches = mesh.surface
    assert len(patches) == 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2)
    a, b, c = (mesh.x[patches[:, k]] for k in range(3))
    assert np.einsum("qc,qc->", a, np.cross(b, c)) / 6 == pytest.approx(1.0), "its volume"


def test_noise_moves_nodes_along_their_normals_and_at_most_by_its_share():
    """A flat top: its inner nodes move up and down, by up to that share of their shortest edge, a fifth in x."""
    mesh = cells((5, 5, 1))
    mesh = Mesh(mesh.x * (1.0, 1.0, 4.0), mesh.tets)
    moved = scan.noisy(mesh.x, mesh.surface, 0.3)
    inner = (mesh.x[:, 2] == 4.0) & (np.abs(mesh.x[:, :2] - 0.5).max(1) < 0.45)
    by = (moved - mesh.x)[inner]
    assert np.abs(by[:, :2]).max() < 1e-12
    assert 0.03 < np.abs(by[:, 2]).max() <= 0.06
    assert by[:, 2].min() < 0.0 < by[:, 2].max()


def test_a_run_tells_how_a_scan_was_filled(tmp_path, build):
    topic = scan.filling(cells((4, 4, 4)), tmp_path / "scan", nodes=100)["scan-filling"]
    assert topic["columns"] == ["notes, of 100 nodes wanted"]
    assert any("filled the surface of 192 triangles" in row[0] for row in topic["rows"])
