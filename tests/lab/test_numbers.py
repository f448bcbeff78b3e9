# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured numbers between the markers of a page: each has one owner."""

import json
import subprocess
import sys

import pytest

from lab import LabError, numbers
from lab.figure import ROOT
from lab.numbers import count, fill, find_faults, number

TOPICS = {
    "worst": {"command": "make bench", "machine": "a processor", **count(9275)},
    "steps": {"command": "make bench", "machine": "a processor", "columns": ["mode", "cube"],
              "rows": [["nearest", number(6.21e-8, "62.1 ns")], ["least", number(1.234e-3, "1.234 ms")]]},
}
PAGE = ("# A page\n\nAt the worst <!-- worst -->?<!-- /worst --> instructions.\n\n<!-- steps -->\nold\n"
        "<!-- /steps -->\n")
FILLED = ("# A page\n\nAt the worst <!-- worst -->9,275<!-- /worst --> instructions.\n\n<!-- steps -->\n| mode | "
          "cube |\n"
          "|---|---|\n| nearest | 62.1 ns |\n| least | 1.234 ms |\n<!-- /steps -->\n")


def test_a_page_is_filled_between_its_markers_and_nowhere_else():
    assert fill("a.md", PAGE, TOPICS) == FILLED
    assert fill("a.md", FILLED, TOPICS) == FILLED, "twice is once"
    one = "<!-- a comment -->\n<!-- worst -->\n"
    assert fill("a.md", one, TOPICS) == one
    with pytest.raises(LabError, match="a.md: the marker speed"):
        fill("a.md", "<!-- speed -->x<!-- /speed -->", TOPICS)


@pytest.mark.parametrize("pages, fault", [
    ({"a.md": FILLED, "b.md": "In 1234 and 62.1 and 150.\n"}, None),
    ({"a.md": FILLED + "<!-- worst -->9,275<!-- /worst -->"}, "worst stands in 2 places"),
    ({"a.md": FILLED.replace("9,275", "9,306")}, "a.md: worst is not what numbers.json says"),
    ({"a.md": FILLED, "b.md": "It takes 9,275 instructions.\n"}, "b.md: quotes 9275, of worst"),
    ({"a.md": FILLED, "b.md": "It takes 1.234 ms.\n"}, "b.md: quotes 1.234, of steps"),
    ({"a.md": FILLED + "<!-- speed -->x<!-- /speed -->"}, "the marker speed has no number"),
])
def test_every_number_has_one_owner_and_faults_are_told(pages, fault):
    faults = find_faults(pages, TOPICS)
    assert [fault in told for told in faults] == ([True] if fault else [])


def test_a_csv_file_is_the_topic_of_its_name():
    csv = "mode,cube\nnearest,62.1 ns\nleast,1.234 ms\n"
    assert fill("data/steps.csv", "", TOPICS) == csv
    odd = {"columns": ["", "a, b"], "rows": [["", 'say "x"']]}
    assert numbers.to_csv(odd) == ',"a, b"\n,"say ""x"""\n'
    page = {"a.md": "<!-- worst -->9,275<!-- /worst -->"}
    assert find_faults({**page, "data/steps.csv": csv}, TOPICS) == []
    for pages, fault in [({**page, "data/steps.csv": "old"}, "steps.csv: steps is not what numbers.json says"),
                         ({"a.md": FILLED, "data/steps.csv": csv}, "steps stands in 2 places"),
                         ({"a.md": FILLED, "data/gone.csv": ""}, "gone.csv: the topic gone has no number")]:
        told = find_faults(pages, TOPICS)
        assert len(told) == 1 and fault in told[0], told


def test_two_numbers_of_a_file_of_data_are_a_quote_and_one_of_them_is_chance():
    topics = {"steps": {"columns": ["", "ticks"], "rows": [["mask", count(5233)], ["least", count(8342)]]}}
    pages = {"data/steps.csv": numbers.to_csv(topics["steps"])}
    assert find_faults({**pages, "b.md": "The peer takes 5,233 of them.\n"}, topics) == []
    faults = find_faults({**pages, "b.md": "From 5,233 to 8,342.\n"}, topics)
    assert len(faults) == 1 and "b.md: quotes 5233, 8342, of steps" in faults[0]


def test_what_the_report_alone_shows_stands_on_no_page():
    topics = {**TOPICS, "points": TOPICS["steps"]}
    assert find_faults({"a.md": FILLED}, topics) == []
    faults = find_faults({"a.md": FILLED + "<!-- points -->\n| mode | cube |\n|---|---|\n| nearest | 62.1 ns |\n"
                                           "| least | 1.234 ms |\n<!-- /points -->"}, topics)
    assert len(faults) == 1 and "points stands in 1 places" in faults[0]


def test_numbers_go_through_their_file_and_replace_topics_by_name(tmp_path):
    file = tmp_path / "numbers.json"
    file.write_text(numbers.to_text(TOPICS), encoding="utf-8")
    assert numbers.read_numbers(file) == TOPICS
    kept = ROOT / "docs/numbers.json"
    assert numbers.to_text(numbers.read_numbers(kept)) == kept.read_text(encoding="utf-8"), "no line changes by reading"


def test_take_fills_numbers_and_pages_and_writes_nothing_where_a_marker_has_no_number(tmp_path):
    (tmp_path / "numbers.json").write_text(numbers.to_text(TOPICS), encoding="utf-8")
    (tmp_path / "new").mkdir()
    (tmp_path / "new/worst.json").write_text(json.dumps({"worst": {"command": "x", "machine": "y", **count(12)}}))

    def take(page: str):
        (tmp_path / "a.md").write_text(page, encoding="utf-8")
        return subprocess.run([sys.executable, "-m", "lab", "take", "--numbers", tmp_path / "numbers.json",
                               tmp_path / "new", tmp_path / "a.md"], cwd=ROOT, capture_output=True, text=True,
                               check=False)
    before = (tmp_path / "numbers.json").read_bytes()
    assert take(PAGE + "<!-- speed -->x<!-- /speed -->").returncode == 1
    assert (tmp_path / "numbers.json").read_bytes() == before
    ended = take(PAGE)
    assert ended.returncode == 0, ended.stderr
    assert "worst <!-- worst -->12<!-- /worst -->" in (tmp_path / "a.md").read_text(encoding="utf-8")
    assert numbers.read_numbers(tmp_path / "numbers.json")["worst"]["value"] == 12


def test_one_line_a_run_tells_what_it_measured():
    topics = {**TOPICS, "strokes": {"command": "make strokes", "machine": "another", **count(1)}}
    assert numbers.runs(topics) == (
        "| command | machine | topics of docs/numbers.json |\n|---|---|---|\n"
        "| `make bench` | a processor | steps, worst |\n| `make strokes` | another | strokes |\n")


@pytest.mark.parametrize("text", ["", "[]", '{"a": 1}', '{"a": {"columns": ["x"], "rows": [["1", "2"]]}}',
                                  '{"a": {"value": "1", "text": "1"}}'])
def test_a_file_that_holds_none_is_an_error_that_names_it(tmp_path, text):
    (tmp_path / "numbers.json").write_text(text)
    with pytest.raises(LabError, match="numbers.json"):
        numbers.read_numbers(tmp_path / "numbers.json")


def test_a_frame_has_values_by_name_and_a_column_for_each_of_several():
    topic = {"columns": ["", "a tick", "a tick"], "rows": [["cube", number([1.0, 2.0], "1 / 2"), ""],
                                                           ["mouse", number(3.0, "3"), number(4.0, "4")]]}
    made = numbers.frame(topic)
    assert list(made.columns) == ["what", "a tick", "a tick (2)", "a tick'"]
    assert made["a tick"].tolist() == [1, 3] and made["a tick'"].isna().tolist() == [True, False]


def test_numbers_are_rounded_as_people_read_them():
    from lab.numbers import error_of, seconds
    assert [count(n)["text"] for n in (999, 1234567)] == ["999", "1,234,567"]
    assert [seconds(s)["text"] for s in (6.21e-8, 1.05e-2, 42.0)] == ["62.1 ns", "10.5 ms", "42 s"]
    assert error_of(1.5e-7)["text"] == "1.5e-07"
