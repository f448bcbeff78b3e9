# SPDX-License-Identifier: GPL-2.0-or-later
"""What the contact modes feel like and cost, for docs/CONTACT.md, and curves for its plots: `make bench`, `make
figures`. Beside proxies, haptable-contact times ticks itself."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from lab import LabError, binding, scenes
from lab.error import FORCES, GOD_OBJECTS, time_ticks
from lab.numbers import Topics, count, error_of, number, write_file, write_topics
from lab.reference import Array
from lab.scenes import Scene
from lab.specimens import cube_scene

MODES = [(force, god_object) for god_object in GOD_OBJECTS for force in FORCES]
LINE_NODES = (9, 13, 17, 25)  # nodes a side
_RELEASE = 0.01  # N/ms, that least energy has by default
_UP = np.array([0.0, 0.0, 1.0])


class Bodies:
    """Scenes in every mode, computed once, and fingers on them. Their forces are the body's own: no limit cuts them."""

    def __init__(self, build: Path, haptable: ModuleType) -> None:
        self.build, self._haptable = build, haptable

    def folder(self, scene: Scene, force: str, mask_radius: float) -> Path:
        mask = {"mask_radius": mask_radius} if force == "pressure-mask" else {}
        radius = f"-{1e3 * mask_radius:.3g}mm" if mask else ""
        return self._made(f"{scene['name']}-{force}{radius}",
                          json.dumps({**scene, "contact": {"force": force, **mask}}))

    def with_tool(self, scene: Scene, mask_radius: float) -> Path:
        """Of a disc of 12 points, under masks; any two places of the cube are coupled by a block."""
        return self._made(f"{scene['name']}-disc", json.dumps(
            {**scene, "contact": {"force": "pressure-mask", "mask_radius": mask_radius},
             "tables": {**scene.get("tables", {}), "coupling_bytes": 8_000_000},
             "tool": {"shape": "disc", "radius": 0.006, "points": 12}}))

    @functools.lru_cache(None)  # noqa: B019  as long as the laboratory runs
    def _made(self, name: str, scene: str) -> Path:
        folder = self.build / "contact" / name
        scenes.precompute(json.loads(scene), folder, self.build)
        return folder

    def with_release(self, scene: Scene, force: str, god_object: str, slew: float) -> Any:
        """Of a scene without the device's limits, with release_slew, N/ms."""
        contact = {"force": force, "god_object": god_object, "release_slew": slew}
        off = {"max_force": 100.0, "max_speed": "off", "max_force_rate": "off", "mean_force": "off"}
        name = f"{scene['name']}-{force}-{god_object}-release-{slew:g}"
        return self._haptable.load(self._made(name, json.dumps({**scene, "contact": contact, "device": off})))

    def body(self, scene: Scene, force: str, god_object: str, mask_radius: float) -> Any:
        return self._haptable.load(self.folder(scene, force, mask_radius), god_object=god_object, bare=True)

    def cube(self, nodes: int, force: str, god_object: str) -> Any:
        """A mask with a radius of two edges."""
        return self.body(contact_cube(nodes), force, god_object, 2.0 * 0.03 / (nodes - 1))


def contact_cube(nodes: int, poisson: float = 0.3) -> Scene:
    """The paper's cube; of more than 9 nodes a side only the middle of its top may be touched."""
    scene = cube_scene(nodes, poisson, top=False)
    if nodes > 9:
        scene["touch"] = [{"box": [0.004, 0.004, 0.03 - 1e-9, 0.026, 0.026, 1.0]}]
    return scene


def mouse() -> Scene:
    scene = scenes.read(Path("meshes/mouse.toml"))
    return {**scene, "tables": {**scene.get("tables", {}), "columns": "none"}}


# ---- curves --------------------------------------------------------------------------------------------------------

def stiffness_along_a_line(bodies: Bodies) -> tuple[Array, Array]:
    """mm along 7 mm over the top of cubes, and N/m [points, nodes a side, force]: 1 mm deep, nu = 0.3."""
    t = -0.0035 + 1e-5 * np.arange(701)
    on = np.stack([0.015 + 0.9487 * t, 0.0153 + 0.3162 * t, np.full_like(t, 0.03)], 1)
    path = np.vstack([on[0] + 0.001 * _UP, on - 0.001 * _UP])
    felt = [[bodies.body(contact_cube(nodes), force, "nearest", 0.005).servo().replay(path)["force"][1:, 2]
             for force in FORCES] for nodes in LINE_NODES]
    return 1e3 * t, np.moveaxis(np.array(felt, float), 2, 0) / 0.001


def energy_around_a_loop(bodies: Bodies) -> Array:
    """[points, 7]: place on the loop, and energy that has been given to the user so far, uJ, a column a mode: in at the
    centre, 5 mm deep to (5, 6) mm aside, out, over the surface back."""
    a, b = np.array([0.015, 0.015, 0.03]), np.array([0.020, 0.021, 0.03])
    corners = np.array([a + 0.0005 * _UP, a - 0.005 * _UP, b - 0.005 * _UP, b + 0.0005 * _UP, a + 0.0005 * _UP])
    place = np.arange(1601) / 400.0
    path = np.stack([np.interp(place, np.arange(5), corners[:, c]) for c in range(3)], 1)
    columns = [place]
    for force, god_object in MODES:
        f = bodies.body(contact_cube(5), force, god_object, 0.006).servo().replay(path)["force"].astype(float)
        work = 0.5e6 * ((f[1:] + f[:-1]) * np.diff(path, axis=0)).sum(1)
        columns.append(np.concatenate([[0.0], np.cumsum(work)]))
    return np.stack(columns, 1)


def force_over_an_edge(bodies: Bodies) -> Array:
    """[ms, 4]: tick and |F|, N, while sliding out over the cube's convex edge, 2 mm deep at 50 mm/s: the paper's force,
    the same with a release of 0.01 N/ms, and with the least-energy god-object, which has that by default."""
    tick = np.arange(-40, 241)
    path = np.stack([0.022 + 5e-5 * np.maximum(0, tick), np.full(len(tick), 0.0171),
                     0.03 - np.minimum(0.002, 5e-5 * (tick + 40))], 1)
    path = np.vstack([[0.022, 0.0171, 0.031], path])
    columns = [np.linalg.norm(bodies.with_release(contact_cube(5), "interpolated", god_object, slew)
                              .servo().replay(path)["force"].astype(float), axis=1)[1:]
               for god_object, slew in (("nearest", 0.0), ("nearest", _RELEASE), ("least-energy", _RELEASE))]
    return np.stack([tick, *columns], 1)


def curves(bodies: Bodies) -> tuple[Array, Array]:
    """line.dat, loop.dat and edge.dat in build/contact; the line."""
    at, stiffness = stiffness_along_a_line(bodies)
    for name, table in (("line", np.column_stack([at, stiffness.reshape(len(at), -1)])),
                        ("loop", energy_around_a_loop(bodies)), ("edge", force_over_an_edge(bodies))):
        write_file(bodies.build / f"contact/{name}.dat",
                   "".join(" ".join(f"{v:.7g}" for v in row) + "\n" for row in table))
    return at, stiffness


# ---- tables --------------------------------------------------------------------------------------------------------

def stiffness_table(stiffness: Array) -> dict[str, Any]:
    """Mean and ripple, (max - min) / mean, of the stiffness along the line."""
    rows = []
    for m, nodes in enumerate(LINE_NODES):
        means = stiffness[:, m].mean(0)
        ripples = np.ptp(stiffness[:, m], axis=0) / means
        rows.append([f"{nodes}",
                     *({"value": [float(mean), float(ripple)], "text": f"{mean:.1f} N/m, {100 * ripple:.2g} %"}
                                   for mean, ripple in zip(means, ripples))])
    return {"columns": ["nodes a side", "interpolated", "consistent", "mask of 5 mm"], "rows": rows}


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
    path = [corners[:1]]
    for a, b in zip(corners, corners[1:]):
        steps = max(1, int(np.linalg.norm(b - a) / 1e-5))
        path.append(a + (b - a) * np.arange(1, steps + 1)[:, None] / steps)
    return np.vstack(path)


def given_by(body: Any, path: Array) -> float:
    """Energy given over the most that was stored; 0 where nothing was touched."""
    x = path.astype(np.float32).astype(float)
    felt = body.servo().replay(path)
    force = felt["force"].astype(float)
    given = 0.5 * ((force[1:] + force[:-1]) * np.diff(x, axis=0)).sum()
    stored = np.where(felt["state"] == 2, -0.5 * (force * (x - felt["god_object"])).sum(1), 0.0).max()
    return float(given / stored) if stored > 0.0 else 0.0


def loop_table(bodies: Bodies, loops: int) -> dict[str, Any]:
    rows = []
    for name, scene, radius in (("cube, nu = 0.3", contact_cube(5), 0.008),
                                ("cube, nu = 0.49", contact_cube(5, 0.49), 0.008),
                                ("mouse", mouse(), 0.006)):
        for god_object in reversed(GOD_OBJECTS):
            row: list[Any] = [f"{name}, {god_object.replace('-', ' ')}"]
            for force in FORCES:
                body, random = bodies.body(scene, force, god_object, radius), np.random.default_rng(11)
                worst = max(0.0, *(given_by(body, random_loop(body, random)) for _ in range(loops)))
                row.append(number(worst, f"{worst:.0e}" if worst < 0.01 else f"{worst:.1f}"))
            rows.append(row)
    return {"columns": ["", "interpolated", "consistent", "pressure mask"], "rows": rows}


def slide(body: Any, begin: Array, along: Array, depth: float, ticks: int, ticks_per_ms: int = 1) -> Array:
    """[ticks + 1, 3] N of a straight slide at `along` m/s over the cube's top, after a press of 0.1 s."""
    deep = begin - depth * _UP
    press = deep + depth * (np.arange(100, -1, -1) / 99.0)[:, None] * _UP
    way = deep + 1e-3 / ticks_per_ms * np.arange(ticks + 1)[:, None] * along
    felt = body.servo().replay(np.vstack([press, way]))[len(press):]
    if not (felt["state"] == 2).all():
        raise LabError(f"{body.name}: the laboratory's finger lost contact: nothing was measured")
    force: Array = felt["force"].astype(float)
    return force


_BEGIN, _ALONG = np.array([0.006, 0.011, 0.03]), np.array([0.1, 0.03, 0.0])  # m on the surface, m/s


def _largest_change(force: Array) -> float:
    return float(np.linalg.norm(np.diff(force, axis=0), axis=1).max())


def _millinewtons(n: float) -> dict[str, Any]:
    return number(n, f"{1e3 * n:.{1 if n < 0.00995 else 0}f} mN")


def change_table(bodies: Bodies) -> dict[str, Any]:
    """Largest change of the tangential force from tick to tick while sliding at 100 mm/s, in units of k v dt."""
    rows = []
    for nodes in (5, 9, 13):
        for depth in (0.001, 0.002):
            row: list[Any] = [f"{nodes}", f"{1e3 * depth:.0f} mm"]
            for force, god_object in MODES:
                felt = slide(bodies.cube(nodes, force, god_object), _BEGIN, _ALONG, depth, 180)
                change = _largest_change(felt[:, :2]) / (felt[:, 2].mean() / depth * 1e-3 * np.linalg.norm(_ALONG))
                row.append(number(float(change), f"{change:.2g}"))
            rows.append(row)
    columns = [f"{force}, {god_object.replace('-', ' ')}" for force, god_object in MODES]
    return {"columns": ["nodes a side", "depth", *columns], "rows": rows}


def settling(bodies: Bodies) -> dict[str, Any]:
    """By how much the force differs at 1 and at 100 kHz, relative, in 99.9 % of the ticks of those slides."""
    off: list[Array] = []
    for nodes in (5, 9, 13):
        for force, god_object in MODES:
            body = bodies.cube(nodes, force, god_object)
            coarse = slide(body, _BEGIN, _ALONG, 0.002, 180)
            fine = slide(body, _BEGIN, _ALONG, 0.002, 18000, 100)[::100]
            off.append(np.linalg.norm(coarse - fine, axis=1) / np.linalg.norm(fine, axis=1))
    ordered = np.sort(np.concatenate(off))
    return error_of(float(ordered[int(0.999 * len(ordered))]))


def jump_table(bodies: Bodies) -> dict[str, Any]:
    """Largest change of the force in a tick at the jumps of the least-energy god-object."""
    rows = [[force,
             *(_millinewtons(_largest_change(slide(bodies.cube(9, force, "least-energy"), _BEGIN, _ALONG, depth, 180)))
                      for depth in (0.001, 0.002))] for force in FORCES]
    return {"columns": ["force", "1 mm deep", "2 mm deep"], "rows": rows}


def release_table(bodies: Bodies) -> dict[str, Any]:
    """The same with the consistent force 2 mm deep, over 12 lines, by release and speed: of the scene itself with that
    release."""
    rows = []
    for slew in (0.0, 0.01, 0.005):
        body = bodies.with_release(contact_cube(9), "consistent", "least-energy", slew)
        row: list[Any] = [f"{slew:g} N/ms" if slew else "0: none"]
        for speed in (0.02, 0.1):
            lines = [(np.array([0.006, 0.008 + 0.001 * k, 0.03]),
                      np.array([speed, 0.3 * speed * (1 if k % 2 else -1), 0.0]))
                     for k in range(12)]
            row.append(_millinewtons(max(_largest_change(slide(body, begin, along, 0.002, int(0.018 / (1e-3 * speed))))
                                         for begin, along in lines)))
        rows.append(row)
    return {"columns": ["release_slew", "20 mm/s", "100 mm/s"], "rows": rows}


def cost_table(bodies: Bodies, repetitions: int) -> dict[str, Any]:
    """What a step costs in each mode, over the paper's, sliding 2 mm deep, and how many bytes its tables have."""
    scenes_of = (contact_cube(5), 0.012), (mouse(), 0.006)
    timed = [[_every(bodies, bodies.folder(scene, force, radius), repetitions) for force in FORCES]
             for scene, radius in scenes_of]
    rows = []
    for force, god_object in MODES:
        of = [body[FORCES.index(force)][god_object] for body in timed]
        ratios = [t / body[0]["nearest"][0] for (t, _), body in zip(of, timed)]
        rows.append([force, god_object, *(number(r, f"{r:.2f}") for r in ratios), *(count(size) for _, size in of)])
    return {"columns": ["force", "god-object", "time of a step, cube", "mouse", "bytes of tables, cube", "mouse"],
            "rows": rows}


def _every(bodies: Bodies, folder: Path, repetitions: int) -> dict[str, tuple[float, int]]:
    """By god-object: seconds a tick, and bytes, in float32."""
    return {t["god_object"]: (float(np.median(t["tick_s"])), t["bytes"])
            for t in time_ticks(bodies.build, [folder], 0.002, 10000, repetitions, every=True)
            if t["precision"] == "float32"}


def make(build: Path, out: Path | None, repetitions: int = 15, loops: int = 1000) -> None:
    """What the contact modes feel like and cost, and curves for plots. repetitions: of each timing, whose median
    counts; loops: random ones of a body and mode; out: None: the curves alone."""
    haptable = binding.load(build)
    bodies = Bodies(build, haptable)
    _, stiffness = curves(bodies)
    if out is None:
        return
    tables: dict[str, Callable[[], dict[str, Any]]] = {
        "modes-cost": lambda: cost_table(bodies, repetitions), "feel-stiffness": lambda: stiffness_table(stiffness),
        "feel-loops": lambda: loop_table(bodies, loops), "feel-change": lambda: change_table(bodies),
        "feel-settling": lambda: settling(bodies), "feel-jumps": lambda: jump_table(bodies),
        "feel-release": lambda: release_table(bodies)}
    topics: Topics = {}
    for name, table in tables.items():
        print(f"bench: {name}", flush=True)
        topics[name] = table()
    write_topics(out, topics)
