# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of README.md and docs/, by name: `make figures` calls this when programs and scenes are made.

Drawings and plots are lab.drawings and lab.plots; pictures and films are haptable-view's. A picture that does not show
what it is about is an error, and the one that is there stays.
"""

import json
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lab import LabError, build, contact, drawings, output_of, own, plots
from lab.browser import touch_picture
from lab.figure import Figure
from lab.numbers import read_numbers
from lab.plots import force_size
from lab.scenes import summary_of

Places = list[tuple[float, ...]]  #: (ms, coordinates in mm ...)


# ---- paths and what was felt on them -------------------------------------------------------------------------------

def smooth(places: Places) -> np.ndarray:
    """A finger's path through places, a row a ms, metres: between them it moves smoothly (minimum jerk)."""
    rows = []
    for (t, *at), (until, *to) in zip(places, places[1:]):
        s = np.arange(until - t)[:, None] / (until - t)
        s = s**3 * (10 - 15 * s + 6 * s**2)
        rows.append(np.array(at) + s * (np.array(to) - np.array(at)))
    return np.concatenate(rows) / 1e3


def shows(felt: pd.DataFrame, about: object, column: str, low: float, high: float, when: str = "tick >= 0") -> None:
    """Raises LabError where `column` ("|force|": the force's size) is never at most `low`, or never at least `high`, in
    the ticks that `when` (of pandas.DataFrame.query) tells."""
    at = felt.query(when)
    values = force_size(at) if column == "|force|" else at[column]
    if not (len(values) and values.min() <= low and values.max() >= high):
        raise LabError(f"{about}: {column} is to go from {low:g} to {high:g} where {when}, and goes from "
                       f"{values.min():g} to {values.max():g}")


def presses(felt: pd.DataFrame, about: object, newtons: float, tick: int) -> None:
    """Raises LabError without a contact with this force, or more, at `tick`."""
    shows(felt, about, "contact", 1, 1, f"tick == {tick}")
    shows(felt, about, "|force|", np.inf, newtons, f"tick == {tick}")


class Studio:
    """Where figures are made: build/figures, from which `pictures` takes what is whole."""

    def __init__(self, pictures: Path) -> None:
        self.pictures, self.work = pictures, build() / "figures"
        own(self.work, "figures")

    def put(self, name: str) -> None:
        """The picture in work/, now that it is whole."""
        if (self.work / name).stat().st_size >= 3_000_000:
            raise LabError(f"{self.work / name}: is over 3 MB")
        os.replace(self.work / name, self.pictures / name)
        print(f"  {self.pictures / name}")

    def draw(self, figure: Figure) -> None:
        """NAME.svg into the pictures; NAME.pdf stays in work/."""
        figure.save(self.work)
        self.put(f"{figure.name}.svg")

    def path(self, name: str, *fingers: np.ndarray) -> Path:
        """The file of a path, a row a tick, of one finger or two."""
        file = self.work / f"{name}.path.csv"
        header = "x,y,z" if len(fingers) == 1 else "x,y,z,x2,y2,z2"
        np.savetxt(file, np.hstack(fingers), fmt="%.6f", delimiter=",", header=header, comments="")
        return file

    def felt(self, name: str, scene: str, *fingers: np.ndarray) -> pd.DataFrame:
        """What a servo gives on that path; kept as NAME.csv."""
        path, csv = self.path(name, *fingers), self.work / f"{name}.csv"
        output_of(build() / scene / "servo", "--quiet", "--replay", path, "--out", csv)
        return pd.read_csv(csv)

    def session(self, name: str, scene: str, path: object, *options: object) -> tuple[Path, pd.DataFrame]:
        """The folder of a session of the scene on that path, and what its servo gave."""
        out = self.work / name
        output_of(build() / "bin/haptable-run", f"meshes/{scene}.toml", "--path", path, "--out", out, "--lockstep",
                  "--draw", "nothing", "--quiet", *options)
        return out, pd.read_csv(out / "servo.csv")

    def view(self, name: str, scene: str, *options: object) -> None:
        """haptable-view draws the picture or film NAME of the scene's tables."""
        output_of(build() / "bin/haptable-view", build() / scene, "--quiet", *options, "-o", self.work / name)
        self.put(name)


def counts(tables: Path, section: str, key: str, least: float) -> None:
    """Raises LabError where the tables' summary.json has less of `key`."""
    number = summary_of(tables)[section][key]
    if number < least:
        raise LabError(f"{tables}/summary.json: {key} is to be {least:g} or more, and is {number}")


# ---- drawings and plots --------------------------------------------------------------------------------------------

def figure_contact(s: Studio, name: str) -> None:
    """From outside to 6 mm under the cube's top, at 0.1 m/s."""
    t = np.linspace(0, 1, 71)[:, None]
    s.draw(drawings.contact(s.felt("tick", "cube", np.array([0.013, 0.0165, 0.031]) + t * [-0.0012, 0.0007, -0.007])))


def _relaxation_path() -> np.ndarray:
    """Down 10 mm into the liver for 8 s, out for 1 s, and again."""
    poked = json.loads(output_of(build() / "liver-capsule/servo", "--poke", "top", "--json"))
    top = np.array([float(v) for v in poked["at_m"].split()])
    down = smooth([(0, 5), (400, -10), (8400, -10), (8600, 5), (9600, 5), (10000, -10), (14000, -10), (14300, 5)])
    return top + down * [0, 0, 1]


def figure_fingers(s: Studio, name: str) -> None:
    """Two fingers on the cube's top: the second 1 mm deep, the first to 4 mm and out again."""
    tick = np.arange(1600)
    first = np.interp(tick, [500, 900, 1000, 1400], [0, 1, 1, 0])
    second = np.interp(tick, [0, 300], [0, 1])

    def above(x: float, depth: np.ndarray) -> np.ndarray:
        return np.column_stack([np.full(1600, x), np.full(1600, 0.0152), 0.0302 - depth])
    s.draw(plots.fingers(s.felt(name, "cube-two", above(0.0113, 0.0042 * first), above(0.0188, 0.0012 * second))))


def figure_relaxation_sliding(s: Studio, name: str) -> None:
    """The table of docs/MATERIALS.md, which a test measures."""
    text = Path("docs/MATERIALS.md").read_text(encoding="utf-8")
    _, found, after = text.partition("speed x time / radius")
    if not found:
        raise LabError(f"docs/MATERIALS.md: has no table of 'speed x time / radius': {name} is drawn of it")
    lines = after.split("\n\n")[0].splitlines()[2:]
    s.draw(plots.relaxation_sliding(np.array([[float(cell) for cell in line.strip("|").split("|")[:3]]
                                              for line in lines])))


def figure_measured(s: Studio, name: str) -> None:
    """What was measured."""
    contact.curves()
    for plot in plots.measured(read_numbers(), build() / "contact", s.work):
        s.put(f"{plot}.svg")


# ---- pictures ------------------------------------------------------------------------------------------------------

def figure_liver_dent(s: Studio, name: str) -> None:
    """The dent that is there 0.1 s after the finger has left, in a session on the same path."""
    path = s.path("relaxation", _relaxation_path())
    out, felt = s.session("relaxation", "liver-capsule", path, "--seconds", 9)
    presses(felt, out, 0.2, 8000)
    shows(felt, out, "contact", 0, 0, "tick == 8650")
    s.view(f"{name}.png", "liver-capsule", "--log", out / "session.lcmlog", "--ticks", 8650, "--size", "640x480")


def figure_demo(s: Studio, name: str) -> None:
    """Figures 1 and 2 of the paper."""
    output_of("sh", "scripts/demo.sh", "--figures")
    demo = build() / "demo"
    for felt in ("cube-uz", "cube-ux", "mouse-uz"):
        presses(pd.read_csv(demo / f"{felt}.csv"), felt, 0.01, 150)
    for picture in ("cube-mesh.png", "cube-uz.png", "cube-ux.png", "mouse-uz.png"):
        shutil.copy(demo / picture, s.work)
        s.put(picture)


def figure_cube_ghost(s: Studio, name: str) -> None:
    """The rest shape as a ghost."""
    csv = build() / "demo/cube-uz.csv"
    presses(pd.read_csv(csv), csv, 0.1, 150)
    s.view(f"{name}.png", "cube", "--csv", csv, "--ticks", 150, "--ghost", "--size", "640x480")


def figure_mouse_mesh(s: Studio, name: str) -> None:
    """A mesh as it is judged."""
    counts(build() / "mouse", "counts", "fixed_nodes", 1)
    s.view(f"{name}.png", "mouse", "--mesh", "--elevation", -30, "--size", "640x480")


def _sag(s: Studio, name: str, scene: str, options: str) -> None:
    """The scene under its own weight (docs/MATERIALS.md has a picture a law)."""
    tables = s.work / name
    output_of(build() / "bin/haptable-precompute", f"meshes/{scene}.toml", "-o", tables, "--quiet")
    counts(tables, "gravity", "largest_sag_m", 1e-4)
    s.view(f"{name}.png", f"figures/{name}", "--sag", "--ghost", "--size", "480x360", *options.split())


def _press(s: Studio, name: str, scene: str, x: float, y: float, options: str) -> None:
    """Pressed 2 mm deep into the top at z = 30 mm."""
    down = np.array([[x, y, 0.03 + 5e-4 - 2.5e-5 * i] for i in range(101)])
    presses(s.felt(name, scene, down), name, 0.05, 100)
    s.view(f"{name}.png", scene, "--csv", s.work / f"{name}.csv", "--ticks", 100, "--size", "480x360", *options.split())


def _page(s: Studio, name: str, scene: str) -> None:
    """The page in a browser, pressed and dragged by a pointer."""
    page = s.work / f"{name}.html"
    output_of(build() / "bin/haptable-view", build() / scene, "--page", page, "--quiet")
    touch_picture(page, s.work / f"{name}.png")
    s.put(f"{name}.png")


# ---- films ---------------------------------------------------------------------------------------------------------

Wanted = list[tuple[Any, ...]]  #: of `shows`: column, low, high, and when


def _film(s: Studio, name: str, fingers: list[Places], options: str, wanted: Wanted, scene: str = "") -> None:
    """Of fingers on paths, in the scene of its name or another."""
    felt = s.felt(name, scene or name, *map(smooth, fingers))
    for one in wanted:
        shows(felt, name, *one)
    s.view(f"{name}.gif", scene or name, "--csv", s.work / f"{name}.csv", *options.split())


def _session(s: Studio, name: str, path: str, options: str, wanted: Wanted, scene: str = "", run: str = "") -> None:
    """Of a session of that scene, or of its name's, as the pages have it."""
    out, felt = s.session(name, scene or name, path, *run.split())
    for one in wanted:
        shows(felt, out, *one)
    s.view(f"{name}.gif", scene or name, "--log", out / "session.lcmlog", "--every", 150, "--size", "400x300",
           "--elevation", 25, *options.split())


def _at(y: float, z: float, *ms_and_x: tuple[float, float]) -> Places:
    return [(ms, x, y, z) for ms, x in ms_and_x]


_GRASP = [(0, -8, 15, 20), (600, 2.5, 15, 20), (900, 2.5, 15, 20), (2100, 2.5, 15, 55), (3000, 2.5, 15, 55),
          (3600, -10, 15, 55), (4300, -10, 15, 55)]
_RINGING = "--every 12 --fps 20 --size 400x320 --zoom 0.75 --azimuth -75 --elevation 12"
_TIMES = (0, 150, 200, 450, 550, 600, 1150)


#: By name: what makes it, of a studio and that name.
FIGURES: dict[str, Callable[[Studio, str], None]] = {
    "signal-path": lambda s, _: s.draw(drawings.signal_path()),
    "states": lambda s, _: s.draw(drawings.states()),
    "device-frames": lambda s, _: s.draw(drawings.device_frames()),
    "contact": figure_contact,
    "relaxation": lambda s, name: s.draw(plots.relaxation(s.felt(name, "liver-capsule", _relaxation_path()))),
    "fingers": figure_fingers,
    "relaxation-sliding": figure_relaxation_sliding,
    "measured": figure_measured,
    "liver-dent": figure_liver_dent,
    # Poked and dragged over (docs/FIRST.md); a spatula pressed on it and turned (docs/TOOL.md).
    "liver": partial(_session, scene="liver-capsule", path="poke,drag", run="--seconds 6", options="",
                     wanted=[("|force|", 0, 0.2)]),
    "liver-spatula": partial(_session, path="roll,tilt", options="--azimuth -60 --zoom 0.8",
                             wanted=[("|force|", 0, 0.2), ("torque_y", -1e-3, 1e-3)]),
    "demo": figure_demo,
    "cube-ghost": figure_cube_ghost,
    "mouse-mesh": figure_mouse_mesh,
    "law-bar": partial(_sag, scene="laws/bar", options="--azimuth -90 --elevation 5 --zoom 0.85 --exaggerate 10"),
    "law-ball": partial(_sag, scene="laws/ball", options="--zoom 0.75 --exaggerate 3 --range 4"),
    "law-balloon": partial(_sag, scene="laws/balloon", options="--zoom 0.75 --exaggerate 3 --range 4"),
    "liver-sag": partial(_sag, scene="liver-capsule", options="--azimuth -90 --elevation 10 --exaggerate 4"),
    "law-fibres": partial(_press, scene="fibres", x=0.015, y=0.015,
                          options="--elevation 75 --azimuth -90 --zoom 0.9 --exaggerate 2"),
    "law-bed": partial(_press, scene="bed", x=0.0262, y=0.015,
                       options="--azimuth -90 --elevation 8 --zoom 0.85 --exaggerate 3 --ghost"),
    "touch": partial(_page, scene="mouse"),
    "touch-two": partial(_page, scene="cube-two"),
    # A finger tip of 12 mm over the mouse: down, aside, across, back, up.
    "mouse": partial(_film, scene="mouse-mask", fingers=[
        [(0, -15, 0, 44), (400, -15, 0, 31), (700, -15, 0, 30), (1700, 16, 13, 25), (2300, 16, -13, 25),
         (3100, -15, 0, 30), (3300, -15, 0, 30), (3700, -15, 0, 44)]],
        options="--every 80 --size 560x420 --elevation 32 --samples 4", wanted=[("|force|", 0, 0.05)]),
    # Down onto the top of a cube that nothing holds, and along it: friction tips it over its edge, by 43 degrees.
    "free-cube": partial(_film, fingers=[
        [(0, 15, 15, 45), (500, 15, 15, 26.5), (700, 15, 15, 26.5), (1900, 40, 15, 26.5), (2400, 40, 15, 60),
         (3000, 40, 15, 60)]],
        options="--every 50 --size 480x360 --zoom 0.5 --azimuth -60 --elevation 18",
        wanted=[("|force|", 0, 0.1), ("turn_w", 0.93, 1)]),
    # Two fingers on its sides: in, up by 24 mm, away.
    "grasp-cube": partial(_film, fingers=[_GRASP, [(ms, 30 - x, y, z) for ms, x, y, z in _GRASP]],
                          options="--every 50 --size 480x360 --zoom 0.45 --azimuth -60 --elevation 14",
                          wanted=[("body_z", 0.016, 0.04), ("contact2", 0, 1)]),
    # A knock on a jelly's side, four times as slow: it rings.
    "jelly": partial(_film, fingers=[_at(15, 26, (0, -15), (120, -2), (200, 6), (260, 6), (290, -15), (900, -15))],
                     options=_RINGING, wanted=[("|force|", 0, 0.03), ("mode_1", -1e-9, 1e-9, "tick > 320")]),
    # Two fingers take hold of it, pull it aside and let go, four times as slow.
    "jelly-two": partial(_film, fingers=[_at(15, 24, *zip(_TIMES, (-8, 3.5, 3.5, 11.5, 11.5, -16, -16))),
                                         _at(15, 24, *zip(_TIMES, (38, 26.5, 26.5, 34.5, 34.5, 52, 52)))],
                         options=_RINGING, wanted=[("|force|", 0, 0.1), ("contact2", 0, 1),
                                                   ("mode_1", -1e-9, 1e-9, "tick > 620")])}


def make(names: list[str], pictures: Path = Path("docs/pictures")) -> None:
    """Remakes pictures of README and docs: these, or all."""
    for name in names:
        if name not in FIGURES:
            raise LabError(f"figures: no figure {name}: give any of {' '.join(FIGURES)}")
    studio = Studio(pictures)
    for name in names or FIGURES:
        FIGURES[name](studio, name)
