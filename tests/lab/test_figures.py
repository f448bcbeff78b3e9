# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the pages: each is drawn of what it is about, and refused, without a file, where its input does not show
that."""

import copy
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from programs import write_program

from lab import LabError, drawings, figure, figures, plots
from lab.figure import Figure
from lab.numbers import read_numbers

NUMBERS = read_numbers(figure.ROOT / "docs/numbers.json")


def drawn(this: Figure, folder: Path) -> str:
    """The SVG's text; a PDF lies beside it, and nothing else."""
    this.save(folder)
    assert sorted(p.name for p in folder.iterdir()) == [f"{this.name}.pdf", f"{this.name}.svg"]
    return (folder / f"{this.name}.svg").read_text(encoding="utf-8")


def refused(what: str, draw, *arguments) -> None:
    with pytest.raises(LabError, match="is to show " + what):
        draw(*arguments)


# ---- what every figure keeps to ------------------------------------------------------------------------------------

def simple() -> tuple[Figure, object]:
    this = Figure("simple")
    axes = this.axes(width=4, height=3)
    axes.plot([0, 1, 2], [0, 1, 4], "o-")
    axes.set(xlabel="time, s", ylabel="force, N")
    return this, axes


def test_a_figure_is_an_svg_and_a_pdf_with_the_same_bytes_again(tmp_path):
    svg = drawn(simple()[0], tmp_path)
    assert "time, s" in svg
    again = tmp_path / "again"
    again.mkdir()
    simple()[0].save(again)
    for name in ("simple.svg", "simple.pdf"):
        assert (again / name).read_bytes() == (tmp_path / name).read_bytes(), name


@pytest.mark.parametrize("spoil, what", [
    (lambda axes: axes.set(ylabel="force"), "the unit of every axis"),
    (lambda axes: axes.plot([0.01], [0.01], "s"), "no symbols on top of each other"),
    (lambda axes: [axes.text(0.5, 2, text) for text in ("this", "that")], "'this' beside 'that'"),
    (lambda axes: axes.text(1, 1, "on a point", ha="center", va="center"), "'on a point' beside every symbol"),
    (lambda axes: axes.text(1.5, 2.5, "on a line", ha="center", va="center"), "'on a line' beside every line"),
    (lambda axes: axes.text(1.9, 2, "a text that leads out of the picture", in_layout=False), "all of 'a text"),
])
def test_a_figure_that_cannot_be_read_is_refused_and_leaves_no_file(tmp_path, spoil, what):
    this, axes = simple()
    spoil(axes)
    refused(what, this.save, tmp_path)
    assert list(tmp_path.iterdir()) == []


def empty():
    """Axes from 0 to 10, drawn."""
    this, axes = simple()
    axes.set(xlim=(0, 10), ylim=(0, 10))
    this.figure.canvas.draw()
    return axes


def test_symbols_are_left_out_where_they_have_no_room():
    axes, taken = empty(), []
    assert figure.thinned(axes, [1, 1.01, 5], [1, 1, 5], 6.0, taken) == [0, 2]
    assert figure.thinned(axes, [5, 9], [5, 9], 6.0, taken) == [1], "those of the first curve stay"


def test_names_of_points_are_where_no_symbol_is_and_within_the_frame():
    axes, taken = empty(), []
    x, y = [1, 5, 5.8, 9.9], [5, 5, 5, 5]
    figure.thinned(axes, x, y, 1.0, taken)
    figure.name_points(axes, [("free", 1, 5), ("left", 5, 5), ("left too", 9.9, 5),
                              ("no room for so long a name" * 3, 5.8, 5)], taken)
    assert [(t.get_text(), t.get_ha()) for t in axes.texts] == [("free", "left"), ("left", "right"),
                                                                ("left too", "right")]


def test_names_of_points_are_beside_lines():
    axes = empty()
    axes.plot([5, 10], [5, 5], ":")
    figure.name_points(axes, [("left", 5, 5)], [])
    assert [(t.get_text(), t.get_ha()) for t in axes.texts] == [("left", "right")]


# ---- drawings ------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("draw, text", [(drawings.signal_path, "haptable_step"), (drawings.states, "latched"),
                                        (drawings.device_frames, "to the user")])
def test_drawings_can_be_read(tmp_path, draw, text):
    assert text in drawn(draw(), tmp_path)


def tick(**changed: float) -> pd.DataFrame:
    """The last tick of a path through the paper's cube."""
    row = dict(tick=70, x=0.0118, y=0.0172, z=0.024, contact=1, node_i=112, node_j=118, node_k=111, alpha_i=0.28,
               alpha_j=0.29, alpha_k=0.43, god_x=0.0118, god_y=0.0172, god_z=0.03, force_x=-0.05, force_y=0.02,
               force_z=0.64)
    return pd.DataFrame([{**row, **changed}])


def test_contact_shows_god_object_patch_displacement_and_force(tmp_path):
    text = drawn(drawings.contact(tick()), tmp_path)
    for label in ("u = x − g", "F, the force on the finger: 0.64", "g, the god-object", "x, the finger"):
        assert label in text
    refused("a contact", drawings.contact, tick(contact=0))
    refused("the god-object on the surface", drawings.contact, tick(god_z=0.029))
    refused("u, 3 mm long", drawings.contact, tick(z=0.029))
    refused("F, 0.3 N or more", drawings.contact, tick(force_z=0.1))


# ---- plots of a servo's CSV ----------------------------------------------------------------------------------------

def test_fingers_shows_that_one_gives_way_to_the_other(tmp_path):
    def felt(falls: bool) -> pd.DataFrame:
        t = np.arange(1600)
        press = np.maximum(0, 1 - np.abs(t - 900) / 300)
        return pd.DataFrame(dict(tick=t, z=0.0302 - 0.004 * press, z2=0.029, force_z=0.5 * press,
                                 force_z2=0.12 * (1 - press if falls else 1 + 0 * press)))
    drawn(plots.fingers(felt(True)), tmp_path)
    refused("the second force falling", plots.fingers, felt(False))


def test_relaxation_shows_two_peaks(tmp_path):
    def felt(left: float) -> pd.DataFrame:
        t = np.arange(14300)
        since = np.abs(t - np.where(t < 8600, 400, 10000))
        is_in = ((t > 300) & (t < 8500)) | (t > 9900)
        force = np.where(is_in, np.where(t < 8600, 1, 0.85) * (left + (1 - left) * np.exp(-since / 1e3)), 0)
        return pd.DataFrame(dict(tick=t, x=0, y=0, z=0, god_x=0, god_y=0, god_z=0.01, contact=is_in * 1, force_x=0,
                                 force_y=0, force_z=force))
    drawn(plots.relaxation(felt(0.6)), tmp_path)
    refused("a force that relaxes", plots.relaxation, felt(1.0))


def test_relaxation_sliding_shows_an_error_that_rises_and_a_peak(tmp_path):
    def rows(at_10: float) -> np.ndarray:
        return np.array([[0.01, 5e-4, 5e-4], [0.12, .045, .045], [0.4, .17, .16], [2, .35, .18], [10, .42, at_10]])
    drawn(plots.relaxation_sliding(rows(0.05)), tmp_path)
    refused("a peak after a short press", plots.relaxation_sliding, rows(0.4))


# ---- haptable-contact's curves -------------------------------------------------------------------------------------

def saved(tmp_path: Path, table: np.ndarray) -> Path:
    np.savetxt(tmp_path / "data", table)
    return tmp_path / "data"


def test_curves_of_contact_show_what_they_are_about(tmp_path):
    out = tmp_path / "out"
    out.mkdir()

    def line(last_mask: float) -> Path:
        x = 0.05 * np.arange(-70, 71)
        columns = [x]
        for m in range(4):
            columns += [0 * x + 40 / (1 + m), (60 + 15 * np.sin(4 * x)) / (1 + m), 0 * x + (75 if m < 3 else last_mask)]
        return saved(tmp_path, np.column_stack(columns))
    plots.contact_line(line(74)).save(out)
    refused("a mask that does not change", plots.contact_line, line(20))

    def loop(given: float) -> Path:
        leg = np.arange(401) / 100
        return saved(tmp_path,
                     np.column_stack([leg] + [-900 * np.sin(np.pi * leg / 4) + (300 if m < 3 else given) * leg / 4
                                                        for m in range(6)]))
    plots.contact_loop(loop(-200)).save(out)
    refused("loops of least energy that give none", plots.contact_loop, loop(50))

    def edge(after: float) -> Path:
        t = np.arange(-40, 241)
        force = np.where(t < 0, 0.14 * (t + 40) / 40, np.where(t < 160, 0.14 - 4e-4 * t, after))
        return saved(tmp_path, np.column_stack([t, force, force, force]))
    plots.contact_edge(edge(0)).save(out)
    refused("the finger leaving", plots.contact_edge, edge(0.05))


# ---- plots of docs/numbers.json ------------------------------------------------------------------------------------

def spoilt(topic: str, spoil) -> dict:
    numbers = copy.deepcopy(NUMBERS)
    for row in numbers[topic]["rows"]:
        spoil(row)
    return numbers


def test_plots_of_numbers_are_drawn_and_show_what_they_are_about(tmp_path):
    plots.measured(NUMBERS, tmp_path / "no curves", tmp_path)
    made = {p.name for p in tmp_path.iterdir()}
    for name in ("accuracy", "error-time", "error-flash", "error-precompute", "large-strain", "stiffening"):
        assert {f"{name}.svg", f"{name}.pdf"} <= made

    def flat(row):
        if row[3] == "pressure-mask":
            row[6]["value"] = 0.05
    refused("an error of the mask that falls", plots.error, spoilt("points", flat), "time")
    refused("a force within a tick", plots.accuracy, spoilt("speed", lambda row: row[1].update(value=1e-3)))
    refused("a force that leaves the linear one", plots.large_strain,
            spoilt("large-strain-curve", lambda row: row[3].update(value=1.0)))
    refused("a force that grows beyond the linear one", plots.stiffening,
            spoilt("stiffening-curve", lambda row: row[4].update(value=row[6]["value"])))


def test_fronts_are_those_that_none_beats():
    points = pd.DataFrame([("cube", "a", 1.0, 0.5), ("cube", "a", 2.0, 0.6), ("cube", "a", 3.0, 0.4),
                           ("cube", "b", 9.0, 0.9), ("cube", "a", float("nan"), 0.1)],
                          columns=["body", "force", "tick", "error, RMS"])
    assert list(plots.fronts(points, "tick").index) == [0, 2, 3]


# ---- pictures ------------------------------------------------------------------------------------------------------

def test_a_path_begins_and_ends_at_rest_and_goes_through_its_places():
    path = figures.smooth([(0, 0, 5), (100, 10, 5), (300, -10, 5)])
    assert path.shape == (300, 2)
    assert np.allclose(path[[0, 50, 100, 200]], [[0, 0.005], [0.005, 0.005], [0.01, 0.005], [0, 0.005]])
    assert np.abs(np.diff(path, axis=0)[[0, 99, 100]]).max() < 2e-7


def test_a_picture_without_a_contact_is_refused_and_the_one_that_is_there_stays(tmp_path, monkeypatch):
    build, pictures = tmp_path / "build", tmp_path / "pictures"
    monkeypatch.setenv("BUILD", str(build))
    pictures.mkdir()
    write_program(build / "bin/haptable-view", 'for last; do :; done; echo drawn >"$last"\n')

    def make(force_n: float, contact: int) -> None:
        write_program(build / "bed/servo", "for last; do :; done; printf 'tick,contact,force_x,force_y,force_z\\n"
                f"99,1,0,0,1\\n100,{contact},0,0,{force_n}\\n' >\"$last\"\n")
        (pictures / "law-bed.png").write_text("before")
        figures.make(["law-bed"], pictures)

    make(0.3, 1)
    assert (pictures / "law-bed.png").read_text() == "drawn\n"
    for force_n, contact in ((0.0, 0), (0.01, 1)):
        with pytest.raises(LabError, match="where tick == 100"):
            make(force_n, contact)
        assert (pictures / "law-bed.png").read_text() == "before"


def test_a_picture_of_another_name_is_an_error_that_names_those_there_are():
    ended = subprocess.run([sys.executable, "-m", "lab", "figures", "no-such-figure"], cwd=figure.ROOT,
                           capture_output=True, text=True, check=False, env=os.environ)
    assert ended.returncode == 1
    assert "no figure no-such-figure" in ended.stderr and "law-bed" in ended.stderr


def test_a_folder_of_others_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("BUILD", str(tmp_path))
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures/mine").write_text("kept")
    with pytest.raises(LabError, match="holds files that are not haptable's"):
        figures.make(["states"], tmp_path)
    assert (tmp_path / "figures/mine").read_text() == "kept"


def test_one_mesh_of_a_body_is_drawn_as_quick_measures_it(tmp_path):
    """QUICK=1: of mouse and liver one mesh, whose elements' errors need not fall."""
    numbers = copy.deepcopy(NUMBERS)
    numbers["points"]["rows"] = [row for row in numbers["points"]["rows"]
                                 if row[1] in ("5 a side", "9 a side", "13 a side", "1,713 nodes", "1,700 nodes")
                                 and (row[0].startswith("cube") or row[2] != "quadratic")]
    plots.error(numbers, "time").save(tmp_path)
