# SPDX-License-Identifier: GPL-2.0-or-later
"""Instructions of a tick on microcontrollers, and what a scene pays for what it names (docs/COSTS.md, docs/data): `make
bench` calls this when images are made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, scenes, told
from lab.error import FORCES
from lab.numbers import Topics, count, number, seconds, write_topics
from lab.scenes import Scene

#: Targets, their names, and parts at the clock that they are sold with.
TARGETS = {"cortex-m4": "Cortex-M4F", "cortex-m7": "Cortex-M7", "cortex-m33": "Cortex-M33", "rv32": "rv32imafc"}
PARTS = (("cortex-m33", "M33", 150e6), ("cortex-m4", "M4F", 168e6), ("rv32", "rv32", 400e6), ("cortex-m7", "M7", 600e6))
_MILLISECOND = 168e3  # instructions: 168 MHz, one a clock
_REJECTED, _CONTACT, _LIMITED = 3, 2, 4

BODIES = {"cube": ("cube", 0.012), "mouse": ("mouse", 0.006), "needle": ("hard/needle", 0.004),
          "torus": ("hard/torus", 0.010)}


def count_ticks(build: Path, folder: Path, *options: str, path: str = "hard") -> Any:
    """What haptable-count tells of a folder's ticks."""
    return told(build / "bin/haptable-count", folder, "--build", build, "--path", path, *options)


def quantile(values: Sequence[int], fraction: float) -> int:
    return sorted(values)[int(fraction * (len(values) - 1))]


@dataclass
class Ticks:
    """Instructions of ticks with contact before and after, and of all."""

    sliding: list[int] = field(default_factory=list)
    all: list[int] = field(default_factory=list)

    def add(self, counted: dict[str, Any], skip_rejected: bool = True) -> "Ticks":
        """Contact is that of all fingers. The first tick has none before it."""
        states, instructions = np.array(counted["states"]), np.array(counted["instructions"])[1:]
        touches = np.isin(states, (_CONTACT, _LIMITED)).all(1)
        counts = (states[1:, 0] != _REJECTED) | (not skip_rejected)
        self.all += instructions[counts].tolist()
        self.sliding += instructions[counts & touches[:-1] & touches[1:]].tolist()
        if not self.sliding:
            raise LabError("the laboratory's fingers touched nothing: no instructions were counted")
        return self

    def require_below(self, bound: int, what: str) -> None:
        if max(self.all) > bound:
            raise LabError(f"{what}: a tick is above its bound in host/target/modes.cpp")


def parts_in_time(bound: int, worst: int, time_s: float = 0.9e-3) -> str:
    """Parts on which every tick ends in that time, at an instruction a clock: by the bound, or by all that were
    counted; "none" where there is none."""
    told: dict[str, list[str]] = {"": [], "counted: ": []}
    for _, name, clock in PARTS:
        if worst <= time_s * clock:
            told["" if bound <= time_s * clock else "counted: "].append(f"{name} {1e-6 * clock:.0f} MHz")
    return "; ".join(how + ", ".join(names) for how, names in told.items() if names) or "none"


# ---- every mode, on four bodies ------------------------------------------------------------------------------------

def _cell(ticks: Ticks) -> dict[str, Any]:
    """median / 99.9 % / worst"""
    values = [quantile(ticks.sliding, 0.5), quantile(ticks.all, 0.999), max(ticks.all)]
    return {"value": values, "text": " / ".join(f"{v:,}" for v in values)}


def _of_a_millisecond(instructions: int) -> dict[str, Any]:
    return number(instructions / _MILLISECOND, f"{100 * instructions / _MILLISECOND:.0f} %")


def with_force(scene: Scene, force: str, radius: float) -> Scene:
    mask = {"mask_radius": radius} if force == "pressure-mask" else {}
    contact = {k: v for k, v in scene.get("contact", {}).items() if k != "mask_radius"}
    return {**scene, "contact": {**contact, "force": force, **mask}, "tables": {"columns": "none"}}


def modes(build: Path, bodies: Sequence[str] = tuple(BODIES), targets: Sequence[str] = tuple(TARGETS),
          strokes: int = 200) -> Topics:
    def counted(body: str, force: str) -> list[dict[str, Any]]:
        file, radius = BODIES[body]
        folder = build / f"modes/{body}-{force}"
        scenes.precompute(with_force(scenes.read(Path(f"meshes/{file}.toml")), force, radius), folder, build)
        found: list[dict[str, Any]] = count_ticks(build, folder, "--every-mode", "--target", ",".join(targets),
                                                  "--strokes",
                                                  str(strokes))
        return [{**one, "body": body} for one in found]
    with ThreadPoolExecutor(2) as pool:  # the emulators are other processes
        jobs = [pool.submit(counted, body, force) for force in FORCES for body in bodies]
        everything = [one for job in jobs for one in job.result()]
    fan = max(one["fan"] for one in everything)
    names = list(dict.fromkeys(one["mode"] for one in everything))
    # Alone, with friction, with passivity.
    order = [name for more in ("", "friction", "passivity") for force in FORCES for name in names
             if name.split()[0] == force and " ".join(name.split()[2:]) == more]
    # A bound is that of the body's own fan; the table's is that of the largest.
    bound = {one["mode"]: one["bound"] for one in everything if one["fan"] == fan}

    def ticks(mode: str, target: str, of: Sequence[str]) -> Ticks:
        whole = Ticks()
        for one in everything:
            if one["mode"] == mode and one["target"] == target and one["body"] in of:
                whole.add(one)
        return whole
    by_body, by_target, by_rate = [], [], []
    for mode in order:
        cells = [ticks(mode, "cortex-m7", [body]) for body in bodies] if "cortex-m7" in targets else []
        if cells:
            worst = max(max(t.all) for t in cells)
            by_body.append([mode, *map(_cell, cells), _of_a_millisecond(worst), count(bound[mode]),
                            _of_a_millisecond(bound[mode])])
        on = {target: ticks(mode, target, bodies) for target in targets}
        for t in on.values():
            t.require_below(bound[mode], mode)
        by_target.append([mode, *(_cell(on[target]) for target in ("cortex-m4", "cortex-m33", "rv32") if target in on)])
        by_rate.append([mode, *(in_time(clock / rate, on[target], bound[mode])
                                for target, _, clock in RATED for rate in (5e3, 10e3) if target in on)])
    columns = [f"{name}, {rate} kHz" for target, name, _ in RATED for rate in (5, 10) if target in targets]
    return {"modes-by-body": {"columns": ["Cortex-M7: force, god-object", *bodies, "worst, of 1 ms", "bound",
                                          "of 1 ms"],
                              "rows": by_body},
            "modes-by-target": {"columns": ["force, god-object", "Cortex-M4F", "Cortex-M33", "rv32imafc"],
                                "rows": by_target},
            "modes-by-rate": {"columns": ["force, god-object", *columns], "rows": by_rate}, "modes-fan": count(fan)}


RATED = tuple(sorted(PARTS, key=lambda part: ("cortex-m4", "cortex-m33", "rv32", "cortex-m7").index(part[0])))


def in_time(most: float, ticks: Ticks, bound: int) -> str:
    """Whether every tick ends in time, at an instruction a clock: by its bound, by all that were counted, by all but
    one in a thousand, or not."""
    if bound <= most:
        return "bound"
    if max(ticks.all) <= most:
        return "counted"
    return "99.9 %" if quantile(ticks.all, 0.999) <= most else "no"


# ---- two fingers; bodies that move ---------------------------------------------------------------------------------

def fingers(build: Path) -> Topics:
    """Two fingers beside one on a Cortex-M7, the cube's top being touched, on the same strokes."""
    costs, rates = {}, {}
    for force in FORCES:
        scene = with_force(scenes.read(Path("meshes/cube.toml")), force, 0.012)
        scene["contact"]["fingers"] = 2
        scene["touch"] = [{"box": [-1.0, -1.0, 0.0299, 1.0, 1.0, 1.0]}]
        folder = build / f"fingers/{force}"
        scenes.precompute(scene, folder, build)
        of = ("--every-mode", "--target", "cortex-m7")
        for one, two in zip(count_ticks(build, folder, *of), count_ticks(build, folder, *of, "--two")):
            alone, both = Ticks().add(one, False), Ticks().add(two, False)
            median, medians, worst = quantile(alone.sliding, 0.5), quantile(both.sliding, 0.5), max(both.all)
            costs[one["mode"]] = [count(median), count(medians), number(medians / median, f"{medians / median:.2f}"),
                                  count(quantile(both.sliding, 0.999)), count(worst), count(two["bound"]),
                                  parts_in_time(two["bound"], worst)]
            rates[one["mode"]] = [parts_in_time(two["bound"], worst, t) for t in (0.2e-3, 0.1e-3)]
    order = sorted(costs, key=lambda mode: (FORCES.index(mode.split()[0]),))
    return {"fingers": {"columns": ["force, god-object", "one finger", "two in contact", "ratio", "99.9 %",
                                    "worst of all",
                                    "bound", "in 0.9 ms"], "rows": [[m, *costs[m]] for m in order]},
            "fingers-by-rate": {"columns": ["force, god-object", "5 kHz", "10 kHz"],
                                "rows": [[m, *rates[m]] for m in order]}}


def bodies(build: Path) -> Topics:
    """Sessions of bodies that nothing holds, or that ring: median of the ticks with contact before and after, and the
    worst of all."""
    rows = []
    for what, scene, path in (("a cube that nothing holds", "free-cube", "tip"),
                              ("the same, two fingers", "grasped", "grasp"),
                              ("a jelly, {} modes", "ringing", "knock"),
                              ("the same, two fingers", "squeezed", "squeeze"),
                              ("the same, two fingers, that nothing holds", "wobbling", "grasp")):
        found = {one["target"]: one for one in count_ticks(build, build / scene, path=path)}
        on = {target: Ticks().add(found[target], False) for target in TARGETS}
        bound, worst = found["cortex-m7"]["bound"], max(max(t.all) for t in on.values())
        for t in on.values():
            t.require_below(bound, what)
        cells = [(quantile(t.sliding, 0.5), max(t.all)) for t in on.values()]
        rows.append([what.format(found["cortex-m7"].get("modes")),
                     *({"value": list(c), "text": f"{c[0]:,} / {c[1]:,}"} for c in cells), count(bound),
                     parts_in_time(bound, worst)])
    return {"bodies": {"columns": ["a tick of", *TARGETS.values(), "bound", "in 0.9 ms"], "rows": rows}}


# ---- a scene pays for what it names --------------------------------------------------------------------------------

Change = Callable[[Scene], None]


def _set(**sections: dict[str, Any]) -> Change:
    def change(scene: Scene) -> None:
        for name, keys in sections.items():
            scene[name] = {**scene.get(name, {}), **keys}
    return change


def _relaxes(*terms: tuple[float, float], **contact: Any) -> Change:
    def change(scene: Scene) -> None:
        scene["relaxation"] = [{"share": share, "time": time} for share, time in terms]
        scene["contact"].update(contact)
    return change


_RUBS = {"friction": 0.5, "kinetic_friction": 0.5}
_FOUR = {"points": [[-3e-3, -3e-3, 0.0], [3e-3, -3e-3, 0.0], [3e-3, 3e-3, 0.0], [-3e-3, 3e-3, 0.0]]}
_NO_LIMITS = {"max_speed": "off", "max_force_rate": "off", "mean_force": "off"}


def _one_patch(folder: Path) -> Change:
    """Only the patch in the middle of the list: its nodes are the region."""
    def change(scene: Scene) -> None:
        x, patch = np.load(folder / "position.npy"), np.load(folder / "patch.npy")
        scene["touch"] = [{"box": [*(x[node] - 1e-9), *(x[node] + 1e-9)]} for node in patch[len(patch) // 2]]
    return change


def _display(folder: Path, rows: int) -> Change:
    def change(scene: Scene) -> None:
        nodes = np.load(folder / "node_id.npy")
        scene["tables"] = {"columns": "surface",
                           "display_rows": [int(nodes[i * len(nodes) // rows]) for i in range(rows)]}
    return change


def variants(radius: float, folder: Path) -> dict[str, Change]:
    """What a scene names beside mesh, material and what is held. folder: of the plain scene."""
    mask = {"force": "pressure-mask", "mask_radius": radius}
    return {
        "the paper's force, the whole surface": _set(),
        "one patch touched": _one_patch(folder),
        '`precision = "float16"`': _set(tables={"precision": "float16"}),
        '`precision = "int16"`': _set(tables={"precision": "int16"}),
        '`force = "consistent"`': _set(contact={"force": "consistent"}),
        '`force = "pressure-mask"`': _set(contact=mask),
        '`force = "pressure-mask"`, `precision = "float16"`': _set(contact=mask, tables={"precision": "float16"}),
        '`god_object = "least-energy"`': _set(contact={"god_object": "least-energy"}),
        "`friction = 0.5`": _set(contact=_RUBS),
        "`release_slew = 0.01`": _set(contact={"release_slew": 0.01}),
        "`passivity = true`": _set(contact={"passivity": True}),
        '`coupling = "auto"`': _set(contact={"coupling": "auto"}),
        '`element = "average-nodal-pressure"`': _set(mesh={"element": "average-nodal-pressure"}),
        "10 `display_rows`": _display(folder, 10),
        "mask, least energy, friction, release, passivity": _set(contact={
            **mask, **_RUBS, "god_object": "least-energy", "release_slew": 0.01, "passivity": True}),
    }


#: What costs the same whatever the mesh.
OF_ANY_MESH: dict[str, Change] = {
    "`stiffening = { yeoh = [5.0] }`": _set(material={"stiffening": {"yeoh": [5.0]}}),
    "`[[relaxation]]`, one term": _relaxes((0.3, 0.5)),
    "`[[relaxation]]`, two terms": _relaxes((0.3, 0.5), (0.2, 10.0)),
    "`[[relaxation]]`, one term, friction": _relaxes((0.3, 0.5), **_RUBS),
    "`grab = true`": _set(contact={"grab": True}),
    "`[tool]`, four points, consistent": _set(contact={"force": "consistent"}, tool=_FOUR),
    "the same, least energy": _set(contact={"force": "consistent", "god_object": "least-energy"}, tool=_FOUR),
    '`force_return = "ramp"`': _set(device={"force_return": "ramp"}),
    '`max_speed = "off"`': _set(device={"max_speed": "off"}),
    '`max_force_rate = "off"`': _set(device={"max_force_rate": "off"}),
    '`mean_force = "off"`': _set(device={"mean_force": "off"}),
    "`check = false`": _set(tables={"check": False}),
    "none of the limits, and no check": _set(device=_NO_LIMITS, tables={"check": False}),
}


def _plain(body: str) -> Scene:
    scene = scenes.read(Path(f"meshes/{BODIES[body][0]}.toml"))
    return {**scene, "contact": {}, "tables": {"columns": "none"}}


def cost_of(body: str, what: str, change: Change, build: Path) -> tuple[list[Any], dict[str, Any]]:
    """The row, and the summary of its tables."""
    scene = _plain(body)
    change(scene)
    folder = build / f"named/{body}"
    summary = scenes.precompute(scene, folder, build, "--threads", "1")
    tables, linked = sum(summary["flash"]["table"].values()), count_ticks(build, folder, "--link")
    one = count_ticks(build, folder, "--strokes", "100", "--target", "cortex-m7", path="strokes")[0]
    touching = sorted(n for n, (state,) in zip(one["instructions"], one["states"]) if state in (_CONTACT, _LIMITED))
    if not touching:
        raise LabError(f"{body}: {what}: the laboratory's finger touched nothing: no instructions were counted")
    median, worst = touching[len(touching) // 2], touching[-1]
    return [f"{body}: {what}", count(tables), count(linked["flash"] - tables), count(linked["ram"]),
            count(linked["stack"]),
            {"value": [median, worst], "text": f"{median:,} / {worst:,}"},
            seconds(sum(summary["cpu_s"].values()))], summary


def named(build: Path) -> Topics:
    rows: dict[str, list[Any]] = {"cube": [], "mouse": []}
    precision = []
    for body in rows:
        plain = build / f"named/{body}-plain"
        scenes.precompute(_plain(body), plain, build)
        for what, change in {**variants(BODIES[body][1], plain), **(OF_ANY_MESH if body == "cube" else {})}.items():
            row, summary = cost_of(body, what, change, build)
            rows[body].append(row)
            if what in ('`force = "consistent"`', '`force = "pressure-mask"`'):
                stored = summary["flash"]["precision"]
                precision.append([f"{body}: {what}", *(
                    {"value": [stored[p]["bytes"], stored[p]["worst_force_error"]],
                     "text": f"{stored[p]['bytes']:,}, {stored[p]['worst_force_error']:.1e}"}
                    for p in ("float32", "float16", "int16"))])
    columns = ["the scene names", "tables, bytes", "code, bytes", "RAM, bytes", "stack, bytes",
               "instructions a tick in contact, median / worst", "precompute"]
    # Every mesh's first, then what costs the same whatever the mesh.
    return {"named": {"columns": columns, "rows": rows["cube"]},
            "named-mouse": {"columns": columns, "rows": rows["mouse"]},
            "precision-compliance": {"columns": ["the scene names", "float32", "float16", "int16"], "rows": precision}}


def make(build: Path, out: Path) -> None:
    """Instructions of a tick on the microcontrollers, in every mode, and what a scene pays for what it names."""
    topics: Topics = {}
    for measure in (modes, fingers, bodies, named):
        print(f"bench: instructions: {measure.__name__}", flush=True)
        topics.update(measure(build))
    write_topics(out, topics)
