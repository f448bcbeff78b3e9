# SPDX-License-Identifier: GPL-2.0-or-later
"""What the contact modes feel like and cost, for docs/CONTACT.md, and curves for its plots: `make bench`, `make
figures`. Beside proxies, haptable-contact times ticks itself."""

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lab import binding, build, say, scenes
from lab.error import FORCES, GOD_OBJECTS, in_contact, time_ticks
from lab.numbers import Topic, Topics, count, error_of, number, table, write_topics
from lab.reference import Array
from lab.scenes import Scene, touched, vary
from lab.specimens import cube_scene

MODES = [(force, god_object) for god_object in GOD_OBJECTS for force in FORCES]
LINE_NODES = (9, 13, 17, 25)  # nodes a side
_RELEASE = 0.01  # N/ms, that least energy has by default
_UP = np.array([0.0, 0.0, 1.0])


# ---- bodies: scenes in every mode, computed once. Their forces are the body's own: no limit cuts them --------------

_MADE: set[Path] = set()


def folder_of(scene: Scene) -> Path:
    """Of its tables."""
    identity = zlib.crc32(json.dumps(scene).encode())
    folder = build() / "contact" / f"{scene['name']}-{scene['contact']['force']}-{identity:08x}"
    if folder not in _MADE:
        scenes.precompute(scene, folder)
        _MADE.add(folder)
    return folder


def with_tool(scene: Scene, radius: float) -> Path:
    """Of a disc of 12 points, 3.3 mm apart, under masks; any two places of the cube are coupled by a block."""
    return folder_of(vary(touched(scene, "pressure-mask", radius), tables={"coupling_bytes": 20_000_000},
                          tool={"shape": "disc", "radius": 0.006, "points": 12}))


def with_release(scene: Scene, force: str, god_object: str, slew: float) -> Any:
    """Of a scene without the device's limits, with release_slew, N/ms."""
    return binding.load().load(folder_of(
        vary(touched(scene, force, god_object=god_object, release_slew=slew),
             device={"max_force": 100.0, "max_speed": "off", "max_force_rate": "off", "mean_force": "off"})))


def body_of(scene: Scene, force: str, god_object: str, radius: float) -> Any:
    return binding.load().load(folder_of(touched(scene, force, radius)), god_object=god_object, bare=True)


def cube_body(nodes: int, force: str, god_object: str) -> Any:
    """A mask with a radius of two edges."""
    return body_of(contact_cube(nodes), force, god_object, 2.0 * 0.03 / (nodes - 1))


def contact_cube(nodes: int, poisson: float = 0.3) -> Scene:
    """The paper's cube; of more than 9 nodes a side only the middle of its top may be touched."""
    middle = [{"box": [0.004, 0.004, 0.03 - 1e-9, 0.026, 0.026, 1.0]}]
    return vary(cube_scene(nodes, poisson, top=False), touch=middle if nodes > 9 else None)


# ---- curves --------------------------------------------------------------------------------------------------------

def _forces(body: Any, path: Array) -> Array:
    return body.servo().replay(path)["force"].astype(float)


def _given(force: Array, path: Array) -> Array:
    """Energy that is given to the user from each place of a path to the next, J."""
    return 0.5 * ((force[1:] + force[:-1]) * np.diff(path, axis=0)).sum(1)


def stiffness_along_a_line() -> tuple[Array, Array]:
    """mm along 7 mm over the top of cubes, and N/m [points, nodes a side, force]: 1 mm deep, nu = 0.3."""
    t = -0.0035 + 1e-5 * np.arange(701)
    on = np.stack([0.015 + 0.9487 * t, 0.0153 + 0.3162 * t, np.full_like(t, 0.03)], 1)
    path = np.vstack([on[0] + 0.001 * _UP, on - 0.001 * _UP])
    felt = [[_forces(body_of(contact_cube(nodes), force, "nearest", 0.005), path)[1:, 2] for force in FORCES]
            for nodes in LINE_NODES]
    return 1e3 * t, np.moveaxis(np.array(felt), 2, 0) / 0.001


def energy_around_a_loop() -> Array:
    """[points, 7]: place on the loop, and energy that has been given to the user so far, uJ, a column a mode: in at the
    centre, 5 mm deep to (5, 6) mm aside, out, over the surface back."""
    a, b = np.array([0.015, 0.015, 0.03]), np.array([0.020, 0.021, 0.03])
    corners = np.array([a + 0.0005 * _UP, a - 0.005 * _UP, b - 0.005 * _UP, b + 0.0005 * _UP, a + 0.0005 * _UP])
    place = np.arange(1601) / 400.0
    path = np.stack([np.interp(place, np.arange(5), corners[:, c]) for c in range(3)], 1)
    given = [_given(_forces(body_of(contact_cube(5), *mode, 0.006), path), path) for mode in MODES]
    return np.column_stack([place, *(np.append(0.0, 1e6 * np.cumsum(energy)) for energy in given)])


def force_over_an_edge() -> Array:
    """[ms, 4]: tick and |F|, N, while sliding out over the cube's convex edge, 2 mm deep at 50 mm/s: the paper's force,
    the same with a release of 0.01 N/ms, and with the least-energy god-object, which has that by default."""
    tick = np.arange(-40, 241)
    path = np.stack([0.022 + 5e-5 * np.maximum(0, tick), np.full(len(tick), 0.0171),
                     0.03 - np.minimum(0.002, 5e-5 * (tick + 40))], 1)
    path = np.vstack([[0.022, 0.0171, 0.031], path])
    bodies = [with_release(contact_cube(5), "interpolated", god_object, slew)
              for god_object, slew in (("nearest", 0.0), ("nearest", _RELEASE), ("least-energy", _RELEASE))]
    return np.stack([tick, *(np.linalg.norm(_forces(body, path), axis=1)[1:] for body in bodies)], 1)


def curves() -> Array:
    """line.dat, loop.dat and edge.dat in build/contact; the stiffness along the line."""
    at, stiffness = stiffness_along_a_line()
    for name, rows in (("line", np.column_stack([at, stiffness.reshape(len(at), -1)])),
                       ("loop", energy_around_a_loop()), ("edge", force_over_an_edge())):
        np.savetxt(build() / f"contact/{name}.dat", rows, "%.7g")
    return stiffness


# ---- tables --------------------------------------------------------------------------------------------------------

def stiffness_table(stiffness: Array) -> Topic:
    """Mean and ripple, (max - min) / mean, of the stiffness along the line."""
    means = stiffness.mean(0)
    both = np.stack([means, np.ptp(stiffness, axis=0) / means], -1).tolist()  # [nodes a side][force]
    return table("nodes a side | interpolated | consistent | mask of 5 mm",
                 [[f"{nodes}", *(number(cell, "{:.1f} N/m, {:.2g} %", (1, 100)) for cell in row)]
                  for nodes, row in zip(LINE_NODES, both)])


def random_loop(body: Any, random: np.random.Generator) -> Array:
    """[points, 3] m: from outside of a random patch 0.9 to 3 mm deep, 1.8 to 6 mm along under it, out, and back, in
    steps of 10 um."""
    v = body.rest[body.patches[random.integers(len(body.patches))]]
    alpha = random.uniform(0.3, 1.0, 3)
    start = alpha @ v / alpha.sum()
    n = np.cross(v[1] - v[0], v[2] - v[0])
    n /= np.linalg.norm(n)
    side = np.cross(n, np.eye(3)[np.abs(n).argmin()])
    side /= np.linalg.norm(side)
    angle = 2.0 * np.pi * random.uniform(0.3, 1.0)
    depth, width = 0.003 * random.uniform(0.3, 1.0), 0.006 * random.uniform(0.3, 1.0)
    inside = start - depth * n
    across = inside + width * (np.cos(angle) * side + np.sin(angle) * np.cross(n, side))
    corners = [start + 0.001 * n, inside, across, across + (depth + 0.02) * n, start + 0.001 * n]
    legs = [np.linspace(a, b, max(1, int(np.linalg.norm(b - a) / 1e-5)) + 1)[1:] for a, b in zip(corners, corners[1:])]
    return np.vstack([corners[:1], *legs])


def given_by(body: Any, path: Array) -> float:
    """Energy given over the most that was stored; 0 where nothing was touched."""
    x = path.astype(np.float32).astype(float)
    felt = body.servo().replay(path)
    force = felt["force"].astype(float)
    stored = np.where(felt["state"] == 2, -0.5 * (force * (x - felt["god_object"])).sum(1), 0.0).max()
    return float(_given(force, x).sum() / stored) if stored > 0.0 else 0.0


def loop_table(loops: int) -> Topic:
    rows = []
    for name, scene, radius in (("cube, nu = 0.3", contact_cube(5), 0.008),
                                ("cube, nu = 0.49", contact_cube(5, 0.49), 0.008),
                                ("mouse", scenes.read("mouse"), 0.006)):
        for god_object in reversed(GOD_OBJECTS):
            row: list[Any] = [f"{name}, {god_object.replace('-', ' ')}"]
            for force in FORCES:
                body, random = body_of(scene, force, god_object, radius), np.random.default_rng(11)
                worst = max(0.0, *(given_by(body, random_loop(body, random)) for _ in range(loops)))
                row.append(number(worst, "{:.0e}" if worst < 0.01 else "{:.1f}"))
            rows.append(row)
    return table(" | interpolated | consistent | pressure mask", rows)


_BEGIN, _ALONG = np.array([0.006, 0.011, 0.03]), np.array([0.1, 0.03, 0.0])  # m on the surface, m/s


def slide(body: Any, depth: float, ticks: int = 180, ticks_per_ms: int = 1, begin: Array = _BEGIN,
          along: Array = _ALONG) -> Array:
    """[ticks + 1, 3] N of a straight slide at `along` m/s over the cube's top, after a press of 0.1 s."""
    deep = begin - depth * _UP
    press = deep + depth * (np.arange(100, -1, -1) / 99.0)[:, None] * _UP
    way = deep + 1e-3 / ticks_per_ms * np.arange(ticks + 1)[:, None] * along
    return in_contact(body, body.servo().replay(np.vstack([press, way]))[len(press):])


def largest_change(force: Array) -> float:
    return float(np.linalg.norm(np.diff(force, axis=0), axis=1).max())


def relative_change(force: Array, depth: float) -> float:
    """Of the tangential force, in units of k v dt."""
    return largest_change(force[:, :2]) / float(force[:, 2].mean() / depth * 1e-3 * np.linalg.norm(_ALONG))


def _millinewtons(n: float) -> Topic:
    return number(n, f"{{:.{1 if n < 0.00995 else 0}f}} mN", 1e3)


def change_table() -> Topic:
    """Largest change of the tangential force from tick to tick while sliding at 100 mm/s."""
    columns = [f"{force}, {god_object.replace('-', ' ')}" for force, god_object in MODES]
    return table(["nodes a side", "depth", *columns],
                 [[f"{nodes}", f"{1e3 * depth:.0f} mm",
                   *(number(relative_change(slide(cube_body(nodes, *mode), depth), depth), "{:.2g}") for mode in MODES)]
                  for nodes in (5, 9, 13) for depth in (0.001, 0.002)])


def settling() -> Topic:
    """By how much the force differs at 1 and at 100 kHz, relative, in 99.9 % of the ticks of those slides."""
    off: list[Array] = []
    for nodes in (5, 9, 13):
        for mode in MODES:
            body = cube_body(nodes, *mode)
            coarse, fine = slide(body, 0.002), slide(body, 0.002, 18000, 100)[::100]
            off.append(np.linalg.norm(coarse - fine, axis=1) / np.linalg.norm(fine, axis=1))
    ordered = np.sort(np.concatenate(off))
    return error_of(float(ordered[int(0.999 * len(ordered))]))


def jump_table() -> Topic:
    """Largest change of the force in a tick at the jumps of the least-energy god-object."""
    return table("force | 1 mm deep | 2 mm deep", [
        [force, *(_millinewtons(largest_change(slide(cube_body(9, force, "least-energy"), depth)))
                  for depth in (0.001, 0.002))] for force in FORCES])


def release_table() -> Topic:
    """The same with the consistent force 2 mm deep, over 12 lines, by release and speed: of the scene itself with that
    release."""
    def worst(slew: float, speed: float) -> float:
        body = with_release(contact_cube(9), "consistent", "least-energy", slew)
        return max(largest_change(slide(body, 0.002, int(0.018 / (1e-3 * speed)),
                                        begin=np.array([0.006, 0.008 + 0.001 * k, 0.03]),
                                        along=np.array([speed, 0.3 * speed * (1 if k % 2 else -1), 0.0])))
                   for k in range(12))
    return table("release_slew | 20 mm/s | 100 mm/s", [
        [f"{slew:g} N/ms" if slew else "0: none", *(_millinewtons(worst(slew, speed)) for speed in (0.02, 0.1))]
        for slew in (0.0, 0.01, 0.005)])


def cost_table(repetitions: int) -> Topic:
    """What a step costs in each mode, over the paper's, sliding 2 mm deep, and how many bytes its tables have."""
    def costs(scene: Scene, radius: float) -> dict[tuple[str, str], tuple[float, int]]:
        return {(force, t["god_object"]): (float(np.median(t["tick_s"])), t["bytes"]) for force in FORCES
                for t in time_ticks([folder_of(touched(scene, force, radius))], 0.002, 10000, repetitions)
                if t["precision"] == "float32"}
    bodies = costs(contact_cube(5), 0.012), costs(scenes.read("mouse"), 0.006)
    return table("force | god-object | time of a step, cube | mouse | bytes of tables, cube | mouse", [
        [*mode, *(number(body[mode][0] / body[MODES[0]][0], "{:.2f}") for body in bodies),
         *(count(body[mode][1]) for body in bodies)] for mode in MODES])


def make(out: Path, repetitions: int = 15, loops: int = 1000) -> None:
    """What the contact modes feel like and cost, and curves for plots. repetitions: of each timing, whose median
    counts; loops: random ones of a body and mode."""
    tables: dict[str, Callable[[], Topic]] = {
        "modes-cost": lambda: cost_table(repetitions), "feel-stiffness": lambda: stiffness_table(curves()),
        "feel-loops": lambda: loop_table(loops), "feel-change": change_table, "feel-settling": settling,
        "feel-jumps": jump_table, "feel-release": release_table}
    topics: Topics = {}
    for name, made in tables.items():
        say(name)
        topics[name] = made()
    write_topics(out, topics)
