# SPDX-License-Identifier: GPL-2.0-or-later
"""What follows from the configurations that were measured."""

from lab.error import derived
from lab.figure import ROOT
from lab.numbers import number, read_numbers


def test_best_are_fingers_with_a_size_that_none_beats():
    measured = [("cube, nu 0.3", "5 a side", "interpolated", "float32", 0.001, 1e-9, 1, 1),
                ("cube, nu 0.3", "5 a side", "pressure-mask", "float32", 0.5, 1e-7, 10, 3),
                ("cube, nu 0.3", "9 a side", "pressure-mask", "float32", 0.1, 1e-7, 20, 3),
                ("cube, nu 0.3", "9 a side", "sparse solve", "float64", 0.05, 1e-3, 5, 1),
                ("mouse", "1,713 nodes", "pressure-mask", "float32", 0.9, 1e-6, 99, 9)]
    topics = derived([
        [body, mesh, "linear", force, "nearest", precision, *(number(v, str(v)) for v in (error, error, *costs))]
        for body, mesh, force, precision, error, *costs in measured])
    best = [row[-1] for row in topics["points"]["rows"]]
    assert best == ["", "", "time", "time, flash, precompute", "time, flash, precompute"]
    assert [row[1] for row in topics["front"]["rows"]] == ["9 a side", "9 a side", "1,713 nodes"], "by error"


def test_what_was_measured_before_gives_the_same_points_front_and_order():
    """docs/numbers.json as a fixture: without what follows from it, then with it again."""
    known = read_numbers(ROOT / "docs/numbers.json")
    whole = known["points"]
    rows = [row[:-1] for row in whole["rows"] if row[3] != "the paper, 1998"]
    topics = derived(rows)
    for name in ("points", "front"):
        assert topics[name]["columns"] == known[name]["columns"]
        assert topics[name]["rows"] == known[name]["rows"], name
    for made, kept in zip(topics["order"]["rows"], known["order"]["rows"], strict=True):
        assert made[:4] == kept[:4]
        assert (made[4]["text"] if made[4] else "") == (kept[4]["text"] if kept[4] else ""), made[:3]
