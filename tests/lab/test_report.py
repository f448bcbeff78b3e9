# SPDX-License-Identifier: GPL-2.0-or-later
"""build/report: an answer first, tables that are sorted and filtered, CSV files, no page wider than the window."""

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest

from lab import LabError, report
from lab.figure import ROOT
from lab.numbers import REPORT_ONLY, read_numbers

NUMBERS = read_numbers(ROOT / "docs/numbers.json")


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    if shutil.which("cmark-gfm") is None:
        pytest.skip("no cmark-gfm: sh scripts/setup.sh lab installs it")
    out = tmp_path_factory.mktemp("report")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        patch.setenv("BUILD", "no build")
        report.make(out)
    return out


class Links(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.to: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id":
                self.ids.add(value)
            if name in ("href", "src") and tag in ("a", "img"):
                self.to.add(value)


def test_the_answer_comes_first_and_every_number_is_there(made):
    text = (made / "index.html").read_text(encoding="utf-8")
    main = text[text.index("<main>"):]
    assert (main.index('id="figure-error-time"') < main.index('id="table-answer"')
            < main.index('id="figure-error-flash"'))
    assert main.index('id="figure-error-precompute"') < main.index('id="ACCURACY"')
    for name, topic in NUMBERS.items():
        if "rows" in topic and name not in REPORT_ONLY:
            assert main.count(f'id="table-{name}"') == 1, name
    assert "stands here" not in main and "<!-- " not in main and "raw HTML" not in main


@pytest.mark.parametrize("name", ["index.html", "configurations.html"])
def test_every_link_leads_somewhere(made, name):
    links = Links((made / name).read_text(encoding="utf-8"))
    for to in links.to:
        path, _, anchor = to.partition("#")
        if re.match(r"[a-z]+:", to):
            continue
        if path == "":
            assert anchor in links.ids, to
        else:
            assert (made / path).exists(), to
            if anchor and path.endswith(".html"):
                assert anchor in Links((made / path).read_text(encoding="utf-8")).ids, to


def test_csv_files_have_every_row_as_values(made):
    points = pd.read_csv(made / "csv/points.csv")
    assert len(points) == len(NUMBERS["points"]["rows"])
    assert points["tick"].iloc[0] == pytest.approx(NUMBERS["points"]["rows"][0][8]["value"], rel=1e-8)
    assert {p.stem for p in (made / "csv").iterdir()} == {n for n, t in NUMBERS.items() if "rows" in t} | {"answer"}


def test_the_answer_names_the_mask_that_is_nearest_to_each_body():
    answer = report.answer(NUMBERS)
    points = pd.DataFrame([[c if isinstance(c, str) else c["value"] for c in row] for row in NUMBERS["points"]["rows"]],
                          columns=NUMBERS["points"]["columns"])
    for row in answer["rows"]:
        of = points[(points["body"] == row[0]) & (points["force"] == "pressure-mask")]
        assert row[3]["value"] == of["error, RMS"].min(), row[0]
    assert [row[10]["text"] for row in answer["rows"] if row[10]] == ["15 us", "12 us"], "the paper's"


def test_a_page_with_numbers_that_no_part_names_comes_under_more(tmp_path):
    (tmp_path / "design").mkdir()
    (tmp_path / "ACCURACY.md").write_text("# Accuracy\n\n<!-- speed -->\n<!-- /speed -->\n")
    (tmp_path / "NEW.md").write_text("# New\n\nAt <!-- modes-fan -->8<!-- /modes-fan --> patches.\n")
    pages = report.Pages(tmp_path, tmp_path, NUMBERS)
    assert pages.parts["More"] == ["NEW"] and pages.all[0] == "ACCURACY"
    assert "At 8 patches." in pages.section("NEW")


def test_numbers_that_are_missing_are_an_error_that_names_them(tmp_path):
    (tmp_path / "numbers.json").write_text("{}")
    with pytest.raises(LabError, match="has no large-strain-curve; measure it"):
        report.make(tmp_path / "out", tmp_path)


# ---- in a browser --------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("page", ["index.html", "configurations.html"])
@pytest.mark.parametrize("width", [1280, 390])
def test_no_page_is_wider_than_its_window(made, browser, page, width):
    browser.resize(width, 800)
    browser.open((made / page).as_uri())
    assert browser.evaluate("document.documentElement.scrollWidth") <= width


def test_a_heading_sorts_by_value_and_choices_and_words_filter(made, browser):
    browser.resize(1280, 800)
    browser.open((made / "configurations.html").as_uri())
    told = browser.evaluate("""(() => {
        const box = document.querySelector('#table-points'),
            rows = () => [...box.querySelectorAll('tbody tr')].filter(r => !r.hidden);
        const head = (k) => box.querySelectorAll('th button')[k].click();
        const told = [rows().length];
        head(8); told.push(Number(rows()[0].cells[8].dataset.v));
        head(8); told.push(Number(rows()[0].cells[8].dataset.v));
        const body = box.querySelector('select'); body.value = 'mouse';
        body.dispatchEvent(new Event('change')); told.push(rows().length);
        const words = box.querySelector('input'); words.value = 'quadratic mask';
        words.dispatchEvent(new Event('input')); told.push(rows().length);
        return told;
    })()""")
    rows = NUMBERS["points"]["rows"]
    ticks = [row[8]["value"] for row in rows]
    mouse = [row for row in rows if row[0] == "mouse"]
    quadratic = [row for row in mouse if row[2] == "quadratic" and "mask" in row[3]]
    assert told == [len(rows), min(ticks), max(ticks), len(mouse), len(quadratic)]
