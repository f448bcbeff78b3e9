# SPDX-License-Identifier: GPL-2.0-or-later
"""What large bodies take: summaries of haptable-precompute as a table."""

import json
from pathlib import Path

import numpy as np
import pytest

from lab import LabError, large
from lab.numbers import texts
from lab.specimens import cube_scene


def run(folder: Path, stiffness: list, **changed) -> Path:
    """What haptable-precompute leaves, as far as it is read."""
    folder.mkdir()
    summary = {"reused": False, "body_hash": "b", "counts": {"nodes": 1713},
               "factor": {"fill": 608781.0, "flops": 1.3e8},
               "cpu_s": {"factor": 0.0201, "blocks": 12.94, "columns": 0.36}, "time_s": {"factor": 0.5, "blocks": 9.0},
               "drawing": "columns", "memory": {"peak_bytes": 117407744}, **changed}
    (folder / "summary.json").write_text(json.dumps(summary))
    np.save(folder / "stiffness.npy", np.array(stiffness))
    return folder


def test_a_row_a_run_with_its_difference_to_the_first_of_its_body(tmp_path):
    ranks = {"cpu_s": [1.0, 2.0], "peak_bytes": [5e6, 7e6]}
    made = large.runs_table([("one", run(tmp_path / "1", [1.0, -4.0])),
                             ("two", run(tmp_path / "2", [1.0, -4.002], ranks=ranks, drawing="none")),
                             ("other", run(tmp_path / "3", [1.0], body_hash="c"))])
    assert texts(made) == [
        ["one", "1,713", "6.1e+05", "1.3e+08", "0.02", "13", "0.36", "9.5", "13", "117", ""],
        ["two", "1,713", "6.1e+05", "1.3e+08", "0.02", "13", "-", "9.5", "3", "5, 7", "5.0e-04"],
        ["other", "1,713", "6.1e+05", "1.3e+08", "0.02", "13", "0.36", "9.5", "13", "117", ""]]
    assert all(len(row) == len(made["columns"]) for row in made["rows"])


def test_a_run_that_measured_nothing_or_another_body_is_an_error_that_names_it(tmp_path):
    with pytest.raises(LabError, match="again: took an earlier run's tables"):
        large.runs_table([("again", run(tmp_path / "1", [1.0], reused=True))])
    with pytest.raises(LabError, match="two: has other nodes"):
        large.runs_table([("one", run(tmp_path / "2", [1.0])), ("two", run(tmp_path / "3", [1.0, 2.0]))])


def test_a_part_of_another_name_is_an_error_that_names_those_there_are(tmp_path, monkeypatch):
    monkeypatch.setenv("BUILD", str(tmp_path))
    with pytest.raises(LabError, match="no part smalll; large, scale, scan"):
        large.make(["large", "smalll"])
    assert list(tmp_path.iterdir()) == [], "before anything is run"


def test_what_a_mask_adds_is_told_by_its_stages(tmp_path, build):
    row = large.mask_row("cube", cube_scene(5, 0.3, top=False), 0.012, tmp_path, 1e9)
    assert len(row) == len(large.MASK_COLUMNS) and row[1] == "125"
    cells = dict(zip(large.MASK_COLUMNS, row))
    parts = sum(cells[name]["value"] for name in ("masks", "planned", "blocks", "products", "files, C"))
    assert cells["all"]["value"] == pytest.approx(parts) and cells["pairs"]["value"] > cells["places"]["value"] > 100
    assert cells["dense product"]["value"] == pytest.approx(cells["operations"]["value"] / 1e9)
