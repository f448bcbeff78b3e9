# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of strokes that were counted."""

import json
from pathlib import Path

import pytest
from lab import strokes
from lab.numbers import read_numbers, texts


def _tally(count=10, **more):
    return {**dict.fromkeys(("ticks", "contact_ticks", "both_ticks", "limits", "clamped_strokes", "behind_strokes",
                             "long_behind_strokes", "passed_motions", "cpu_s"), 0), "strokes": count, "most_area": 0.0,
            "faults": {"lost": 0, "force": 0}, "broken": [], **more}


def _counts(*tallies, total=None):
    """Of one body; a mode a tally: interpolated and nearest alone, the second with two fingers."""
    modes = [{"name": f"mode-{i}", "force": "interpolated", "god_object": "nearest", "friction": False,
              "fingers": 1 + i, "tool": False, "free": i == 1, "rings": False} for i in range(len(tallies))]
    return {"seed": 3, "total": total or _tally(20), "modes": modes, "left_out": [
        {"name": "a", "why": "meshes/a.off: is open: close it"}, {"name": "b", "why": "the same mesh as a"}],
        "bodies": [{"name": "cube", "filled": True, "nodes": 1250, "tables_cpu_s": 6.0,
                    "modes": {f"mode-{i}": tally for i, tally in enumerate(tallies)}}]}


def test_faults_are_summed_by_mode_by_way_and_by_mesh():
    made = strokes.tables(_counts(_tally(faults={"lost": 0, "force": 2}), _tally(faults={"lost": 3, "force": 1})))
    assert made["strokes-modes"]["columns"] == ["force", "god-object", "friction", "strokes", "lost", "force"]
    assert texts(made["strokes-modes"]) == [["interpolated", "nearest", "no", "20", "3", "3"]]
    assert texts(made["strokes-kinds"]) == [["one, held", "10", "0", "2"], ["two, free", "10", "3", "1"]]
    assert texts(made["strokes-meshes"]) == [["cube, filled", "1,250", "20", "2 force", "3 lost, 1 force"]]


def test_tools_and_hands_are_kinds_of_their_own():
    assert strokes.kind_of({"tool": True, "fingers": 1, "free": False, "rings": False}) == "tool, held"
    assert strokes.kind_of({"tool": False, "fingers": 8, "free": False, "rings": False}) == "hands, held"


def test_a_mode_without_strokes_is_no_clean_one():
    made = strokes.tables(_counts(_tally(), _tally(0)))
    assert texts(made["strokes-meshes"]) == [["cube, filled", "1,250", "10", "0", "-"]]


def test_left_out_meshes_say_why_without_their_path():
    assert texts(strokes.tables(_counts(_tally()))["strokes-left-out"]) == [["a", "is open: close it"],
                                                                             ["b", "the same mesh as a"]]


def test_what_is_by_design_is_told_as_shares_and_rates():
    table = strokes.tables(_counts(_tally(8, behind_strokes=1, limits=3, contact_ticks=1000)))["contact-by-design"]
    assert table["columns"] == ["by design", "nearest"]
    assert [row[1] for row in texts(table)] == ["12 %", "0", "0", "0", "3,000"]


# Counts are of the firmware that is there: make strokes && make report.
def test_counted_strokes_are_of_the_firmware_that_is_there():
    was = read_numbers(Path("docs/numbers.json"))["strokes-firmware"]["text"]
    now = strokes.source_identity(Path("firmware"))
    assert was == now, "the firmware has changed since docs/STROKES.md was counted: make strokes, then make report"


@pytest.mark.parametrize(("text", "same"), [
    ("int a(void)\n{ /**/ return 1 /\n2; }", True), ("int a(void) { return 1 / 3; }", False),
    ("int a(void) { return 1 / 2; } /* never closed", True)])
def test_sources_are_told_apart_by_what_they_do(tmp_path, text, same):
    (tmp_path / "a.c").write_text("/* one * two */ int a(void) { return 1 / 2; } // three\n")
    was = strokes.source_identity(tmp_path)
    (tmp_path / "a.c").write_text(text)
    assert (strokes.source_identity(tmp_path) == was) == same
    (tmp_path / "b.h").write_text("")
    assert strokes.source_identity(tmp_path) != was


def test_counts_of_a_run_become_a_file_of_topics(tmp_path):
    (tmp_path / "counts.json").write_text(json.dumps(_counts(_tally())))
    strokes.make(tmp_path / "counts.json", tmp_path / "out.json")
    topics = read_numbers(tmp_path / "out.json")
    assert topics["strokes-count"]["text"] == "20"
    assert topics["strokes-count"]["command"] == "make strokes"
