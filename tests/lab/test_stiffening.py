# SPDX-License-Identifier: GPL-2.0-or-later
"""Dents that stiffen, beside CalculiX's."""

import shutil

import numpy as np
import pytest

from lab import stiffening
from lab.stiffening import Curve, Finger

needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx: sh scripts/setup.sh lab")


def test_a_force_is_the_linear_one_times_the_curves():
    curve = Curve((0.5, -0.25, 1.0), 2e-3)
    assert curve.factor(0.0) == 1.0 and curve.factor(2e-3) == curve.factor(1.0) == 2.25
    assert curve.factor(0.5e-3) == pytest.approx(1.0 + 0.25 - 0.0625 + 0.125)
    finger = Finger(np.array([0.0, 0.0, 1.0]), np.array([1, 2]), np.array([0.25, 0.75]), np.diag([100.0, 200.0, 400.0]))
    u = np.array([0.0, 0.0, -np.sqrt(2.0 * 0.5e-3 / 400.0)])
    assert finger.force(u, None) == pytest.approx(400.0 * u)
    assert finger.force(u, curve) == pytest.approx(400.0 * curve.factor(0.5e-3) * u)


@needs_ccx
def test_dents_are_calculixs_and_nowhere_worse_than_linear(tmp_path, build, monkeypatch):
    monkeypatch.setattr(stiffening, "BODIES", {"cube": ("cube", 7, 0.008)})
    rows = stiffening.measure("cube", tmp_path)
    assert len(rows) == 2 * 4 * stiffening.LEVELS
    for way in stiffening.WAYS:
        off = np.array([[row[7]["value"], row[8]["value"]] for row in rows if row[2] == way])
        stiffened, linear = np.sqrt((off**2).mean(0))
        assert linear > 0.1, "deep enough to stiffen"
        assert stiffened < linear
    (body,) = stiffening.limits(rows)
    assert body[0] == "cube" and len(body) == 2 + len(stiffening.WAYS) + 2
