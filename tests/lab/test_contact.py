# SPDX-License-Identifier: GPL-2.0-or-later
"""What the contact modes feel like: what lab.contact tells is what an earlier program told, and what theory says."""

import json

import numpy as np
import pytest

from lab import LabError, contact
from lab.contact import body_of, contact_cube, cube_body, given_by, random_loop, slide
from lab.figure import ROOT


@pytest.fixture(autouse=True)
def _library(need):
    need("lib/libhaptable.so.1")


def test_slides_change_as_docs_say():
    kept = json.loads((ROOT / "docs/numbers.json").read_text())
    rows = [row for row in kept["feel-change"]["rows"] if row[0] == "9"]
    for row, depth in zip(rows, (0.001, 0.002)):
        for (force, god_object), cell in zip(contact.MODES, row[2:]):
            change = contact.relative_change(slide(cube_body(9, force, god_object), depth), depth)
            assert change == pytest.approx(cell["value"], rel=1e-3)


def test_a_loop_of_least_energy_gives_none_and_one_of_the_nearest_does():
    worst = {}
    for god_object in ("nearest", "least-energy"):
        body, random = body_of(contact_cube(5), "consistent", god_object, 0.0), np.random.default_rng(11)
        worst[god_object] = max(given_by(body, random_loop(body, random)) for _ in range(10))
    assert worst["nearest"] > 0.05
    assert worst["least-energy"] < 1e-3  # of float32's rounding over some thousand ticks


def test_a_loop_is_closed_in_steps_of_a_hundredth_of_a_millimetre():
    body = body_of(contact_cube(5), "consistent", "nearest", 0.0)
    path = random_loop(body, np.random.default_rng(1))
    assert path[0] == pytest.approx(path[-1]) and np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 2.1e-5


def test_a_release_lets_a_force_fall():
    edge = contact.force_over_an_edge()
    falls = [-np.diff(column).min() for column in edge[:, 1:].T]
    # What falls is what is left of the force; the finger slides on meanwhile.
    assert falls[0] > 0.05 and 0.0099 < falls[1] < 0.02 and 0.0099 < falls[2] < 0.02


def test_a_finger_that_loses_contact_is_an_error():
    with pytest.raises(LabError, match="lost contact"):
        slide(cube_body(9, "interpolated", "nearest"), 0.001, 1000)


def test_tables_of_a_stiffness():
    stiffness = np.ones((11, 4, 3)) * np.linspace(9, 11, 11)[:, None, None]
    table = contact.stiffness_table(stiffness)
    assert table["rows"][0][:2] == ["9", {"value": pytest.approx([10.0, 0.2]), "text": "10.0 N/m, 20 %"}]
    assert contact._millinewtons(0.0081)["text"] == "8.1 mN" and contact._millinewtons(0.083)["text"] == "83 mN"
