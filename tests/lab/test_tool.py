# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid sphere against a cube: CalculiX's contact, kept in sphere.csv, beside Hertz and beside the sampled tool."""

import shutil

import numpy as np
import pytest

from lab import tool
from lab.figure import ROOT

KEPT = np.genfromtxt(ROOT / "tests/lab/sphere.csv", delimiter=",", names=True)


def test_the_kept_forces_are_hertz_to_the_mesh():
    """19 nodes a side: edges of 1.7 mm under a contact of 2.2 to 5.5 mm, on a cube that is held 30 mm below."""
    assert np.abs(KEPT["force_n"] / tool.hertz(KEPT["depth_m"]) - 1.0).max() < 0.1


@pytest.fixture
def folder(tmp_path, build):
    """19 points, 2.6 mm apart, under masks of 0.8 of that."""
    return tool.tables(19, 19, 35.0, 0.0021, tmp_path / "sphere")


def test_a_sampled_sphere_feels_what_calculix_finds(folder):
    """From 1 mm on seven points and more touch; at 0.5 mm three do, which a contact of 2.2 mm does not know."""
    off = np.abs(tool.by_tool(folder) / KEPT["force_n"] - 1.0)
    assert off[1:].max() < 0.05 and off[0] < 0.15


def test_a_sampled_punch_and_its_tilt(tmp_path, build):
    """12 points under a mask of 2.3 mm, edges of 1.25 mm; the cube is 3.5 % stiffer than a half-space."""
    force, about_x, about_y = tool.punch(25, 12, 0.006, tmp_path / "punch")
    assert abs(force / tool.stiffening(0.006) - 1.0) < 0.05
    assert max(abs(about_x - 1.0), abs(about_y - 1.0)) < 0.05


@pytest.mark.skipif(shutil.which("ccx") is None, reason="no ccx: sh scripts/setup.sh lab")
def test_calculix_gives_the_kept_forces_at_two_depths(folder, monkeypatch):
    monkeypatch.setattr(tool, "DEPTHS", KEPT["depth_m"][:2])
    assert np.abs(tool.by_calculix(folder) / KEPT["force_n"][:2] - 1.0).max() < 1e-3
