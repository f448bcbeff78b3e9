# SPDX-License-Identifier: GPL-2.0-or-later
"""Instructions of a tick on microcontrollers, and what a scene pays for what it names (docs/COSTS.md, docs/data): `make
bench` calls this when images are made."""

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, build, output_of, say, scenes, told
from lab.error import FORCES
from lab.numbers import Topic, Topics, count, number, percent, seconds, table, write_topics
from lab.scenes import Scene, touched, vary

#: Targets, their names, and parts at the clock that they are sold with.
TARGETS = {"cortex-m4": "Cortex-M4F", "cortex-m7": "Cortex-M7", "cortex-m33": "Cortex-M33", "rv32": "rv32imafc"}
PARTS = (("cortex-m33", "M33", 150e6), ("cortex-m4", "M4F", 168e6), ("rv32", "rv32", 400e6), ("cortex-m7", "M7", 600e6))
MILLISECOND = 168e3  # instructions: 168 MHz, one a clock
_REJECTED, _CONTACT, _LIMITED = 3, 2, 4

#: By name: the scene of meshes/, and the radius of its masks.
BODIES = {"cube": ("cube", 0.012), "mouse": ("mouse", 0.006), "needle": ("hard/needle", 0.004),
          "torus": ("hard/torus", 0.010)}


def count_ticks(folder: Path, *options: object, path: str = "hard") -> Any:
    """What haptable-count tells of a folder's ticks."""
    return told("haptable-count", folder, "--build", build(), "--path", path, *options)


def stacks_of(tables: Path, target: str) -> dict[str, int]:
    """Stack of what a board calls, bytes, by name. The tables name the functions; the call graphs are those of the
    cube's images, which hold every function before the linker drops what no table names."""
    cross, model = "riscv64-unknown-elf-" if target == "rv32" else "arm-none-eabi-", tables.with_suffix(".o")
    output_of(f"{cross}gcc", "-c", "-ffreestanding", "-Ifirmware", tables / "model.c", "-o", model)
    found = output_of("python3", "scripts/stack.py", build() / "cube/firmware" / target, model, CROSS=cross)
    return {entry: int(stack) for entry, stack in (line.split() for line in found.splitlines())}


class Ticks:
    """Instructions of counted ticks: of all, and of those with contact before and after. Contact is that of all
    fingers; the first tick has none before it."""

    def __init__(self, *runs: dict[str, Any], skip_rejected: bool = True) -> None:
        self.all: list[int] = []
        self.sliding: list[int] = []
        for counted in runs:
            states, instructions = np.array(counted["states"]), np.array(counted["instructions"])[1:]
            touches = np.isin(states, (_CONTACT, _LIMITED)).all(1)
            counts = (states[1:, 0] != _REJECTED) | (not skip_rejected)
            self.all += instructions[counts].tolist()
            self.sliding += instructions[counts & touches[:-1] & touches[1:]].tolist()
            if not self.sliding:
                raise LabError("the laboratory's fingers touched nothing: no instructions were counted")
        #: Of those that slide; of 99.9 % of all; of all.
        self.median, self.most, self.worst = (int(np.quantile(of, share, method="lower")) for of, share in (
            (self.sliding, 0.5), (self.all, 0.999), (self.all, 1.0)))

    def require_below(self, bound: int, what: str) -> None:
        if self.worst > bound:
            raise LabError(f"{what}: a tick is above its bound in host/target/modes.cpp")


def parts_in_time(bound: int, worst: int, time_s: float = 0.9e-3) -> str:
    """Parts on which every tick ends in that time, at an instruction a clock: by the bound, or by all that were
    counted; "none" where there is none."""
    told: dict[str, list[str]] = {"": [], "counted: ": []}
    for _, name, clock in PARTS:
        if worst <= time_s * clock:
            told["" if bound <= time_s * clock else "counted: "].append(f"{name} {1e-6 * clock:.0f} MHz")
    return "; ".join(how + ", ".join(names) for how, names in told.items() if names) or "none"


def in_time(most: float, ticks: Ticks, bound: int) -> str:
    """Whether every tick ends in time, at an instruction a clock: by its bound, by all that were counted, by all but
    one in a thousand, or not."""
    told = {"bound": bound, "counted": ticks.worst, "99.9 %": ticks.most}
    return next((name for name, instructions in told.items() if instructions <= most), "no")


# ---- every mode, on four bodies ------------------------------------------------------------------------------------

def _several(*counts: int) -> Topic:
    """median / 99.9 % / worst"""
    return number(list(counts), " / ".join(["{:,}"] * len(counts)))


def _of_a_millisecond(instructions: int) -> Topic:
    return percent(instructions / MILLISECOND)


def modes() -> Topics:
    def counted(body: str, force: str) -> list[dict[str, Any]]:
        file, radius = BODIES[body]
        folder = build() / f"modes/{body}-{force}"
        scenes.precompute(touched(scenes.read(file), force, radius), folder)
        return [{**one, "body": body} for one in count_ticks(folder, "--every-mode")]
    with ThreadPoolExecutor(2) as pool:  # the emulators are other processes
        jobs = [pool.submit(counted, body, force) for force in FORCES for body in BODIES]
        everything = [one for job in jobs for one in job.result()]
    fan = max(one["fan"] for one in everything)
    names = dict.fromkeys(one["mode"] for one in everything)
    # Alone, with friction, with passivity.
    order = [name for more in ("", "friction", "passivity") for force in FORCES for name in names
             if name.split()[0] == force and " ".join(name.split()[2:]) == more]
    # A bound is that of the body's own fan; the table's is that of the largest.
    bound = {one["mode"]: one["bound"] for one in everything if one["fan"] == fan}

    def ticks(mode: str, target: str, bodies: Iterable[str] = BODIES) -> Ticks:
        return Ticks(*(one for one in everything
                       if one["mode"] == mode and one["target"] == target and one["body"] in bodies))

    def cells(*found: Ticks) -> list[Topic]:
        return [_several(one.median, one.most, one.worst) for one in found]
    by_body, by_target, by_rate = [], [], []
    others, clocks = ("cortex-m4", "cortex-m33", "rv32"), {target: (name, clock) for target, name, clock in PARTS}
    for mode in order:
        found = [ticks(mode, "cortex-m7", [body]) for body in BODIES]
        by_body.append([mode, *cells(*found), _of_a_millisecond(max(one.worst for one in found)),
                        count(bound[mode]), _of_a_millisecond(bound[mode])])
        on = {target: ticks(mode, target) for target in TARGETS}
        for one in on.values():
            one.require_below(bound[mode], mode)
        by_target.append([mode, *cells(*(on[target] for target in others))])
        by_rate.append([mode, *(in_time(clocks[target][1] / rate, on[target], bound[mode])
                                for target in (*others, "cortex-m7") for rate in (5e3, 10e3))])
    rates = [f"{clocks[target][0]}, {rate} kHz" for target in (*others, "cortex-m7") for rate in (5, 10)]
    return {"modes-by-body": table(["Cortex-M7: force, god-object", *BODIES, "worst, of 1 ms", "bound", "of 1 ms"],
                                   by_body),
            "modes-by-target": table(["force, god-object", *(TARGETS[target] for target in others)], by_target),
            "modes-by-rate": table(["force, god-object", *rates], by_rate), "modes-fan": count(fan)}


# ---- two fingers; bodies that move ---------------------------------------------------------------------------------

def fingers() -> Topics:
    """Two fingers beside one on a Cortex-M7, the cube's top being touched, on the same strokes."""
    costs, rates = [], []
    for force in FORCES:
        scene = vary(touched(scenes.read("cube"), force, 0.012, fingers=2),
                     touch=[{"box": [-1.0, -1.0, 0.0299, 1.0, 1.0, 1.0]}])
        folder = build() / f"fingers/{force}"
        scenes.precompute(scene, folder)
        of = ("--every-mode", "--target", "cortex-m7")
        for one, two in zip(count_ticks(folder, *of), count_ticks(folder, *of, "--two")):
            alone, both = Ticks(one, skip_rejected=False), Ticks(two, skip_rejected=False)
            costs.append([one["mode"], count(alone.median), count(both.median),
                          number(both.median / alone.median, "{:.2f}"), count(both.most), count(both.worst),
                          count(two["bound"]), parts_in_time(two["bound"], both.worst)])
            rates.append([one["mode"], *(parts_in_time(two["bound"], both.worst, t) for t in (0.2e-3, 0.1e-3))])
    return {"fingers": table("force, god-object | one finger | two in contact | ratio | 99.9 % | worst of all | "
                             "bound | in 0.9 ms", costs),
            "fingers-by-rate": table("force, god-object | 5 kHz | 10 kHz", rates)}


def bodies() -> Topics:
    """Sessions of bodies that nothing holds, or that ring: median of the ticks with contact before and after, and the
    worst of all."""
    rows = []
    for what, scene, path in (("a cube that nothing holds", "free-cube", "tip"),
                              ("the same, two fingers", "grasped", "grasp"),
                              ("a jelly, {} modes", "ringing", "knock"),
                              ("the same, two fingers", "squeezed", "squeeze"),
                              ("the same, two fingers, that nothing holds", "wobbling", "grasp")):
        found = {one["target"]: one for one in count_ticks(build() / scene, path=path)}
        on = [Ticks(found[target], skip_rejected=False) for target in TARGETS]
        bound = found["cortex-m7"]["bound"]
        for one in on:
            one.require_below(bound, what)
        rows.append([what.format(found["cortex-m7"].get("modes")), *(_several(one.median, one.worst) for one in on),
                     count(bound), parts_in_time(bound, max(one.worst for one in on))])
    return {"bodies": table(["a tick of", *TARGETS.values(), "bound", "in 0.9 ms"], rows)}


# ---- a scene pays for what it names --------------------------------------------------------------------------------

#: What a scene names: tables whose keys change it.
Change = dict[str, Any]


def _relaxes(*terms: tuple[float, float], **more: Any) -> Change:
    return {"relaxation": [{"share": share, "time": time} for share, time in terms], "contact": more}


_RUBS = {"friction": 0.5, "kinetic_friction": 0.5}
_FOUR = {"points": [[-3e-3, -3e-3, 0.0], [3e-3, -3e-3, 0.0], [3e-3, 3e-3, 0.0], [-3e-3, 3e-3, 0.0]]}
_NO_LIMITS = {"max_speed": "off", "max_force_rate": "off", "mean_force": "off"}


def _one_patch(folder: Path) -> Change:
    """Only the patch in the middle of the list: its nodes are the region."""
    x, patch = np.load(folder / "position.npy"), np.load(folder / "patch.npy")
    corners = x[patch[len(patch) // 2]]
    return {"touch": [{"box": [*(at - 1e-9).tolist(), *(at + 1e-9).tolist()]} for at in corners]}


def _display(folder: Path, rows: int) -> Change:
    nodes = np.load(folder / "node_id.npy")
    return {"tables": {"columns": "surface", "display_rows": [int(nodes[i * len(nodes) // rows]) for i in range(rows)]}}


def variants(radius: float, folder: Path) -> dict[str, Change]:
    """What a scene names beside mesh, material and what is held. folder: of the plain scene."""
    mask, half = {"force": "pressure-mask", "mask_radius": radius}, {"precision": "float16"}
    return {
        "the paper's force, the whole surface": {},
        "one patch touched": _one_patch(folder),
        '`precision = "float16"`': {"tables": half},
        '`precision = "int16"`': {"tables": {"precision": "int16"}},
        '`force = "consistent"`': {"contact": {"force": "consistent"}},
        '`force = "pressure-mask"`': {"contact": mask},
        '`force = "pressure-mask"`, `precision = "float16"`': {"contact": mask, "tables": half},
        '`god_object = "least-energy"`': {"contact": {"god_object": "least-energy"}},
        "`friction = 0.5`": {"contact": _RUBS},
        "`release_slew = 0.01`": {"contact": {"release_slew": 0.01}},
        "`passivity = true`": {"contact": {"passivity": True}},
        '`coupling = "auto"`': {"contact": {"coupling": "auto"}},
        '`element = "average-nodal-pressure"`': {"mesh": {"element": "average-nodal-pressure"}},
        "10 `display_rows`": _display(folder, 10),
        "mask, least energy, friction, release, passivity": {"contact": {
            **mask, **_RUBS, "god_object": "least-energy", "release_slew": 0.01, "passivity": True}},
    }


#: What costs the same whatever the mesh.
OF_ANY_MESH: dict[str, Change] = {
    "`stiffening = { yeoh = [5.0] }`": {"material": {"stiffening": {"yeoh": [5.0]}}},
    "`[[relaxation]]`, one term": _relaxes((0.3, 0.5)),
    "`[[relaxation]]`, two terms": _relaxes((0.3, 0.5), (0.2, 10.0)),
    "`[[relaxation]]`, one term, friction": _relaxes((0.3, 0.5), **_RUBS),
    "`grab = true`": {"contact": {"grab": True}},
    "`[tool]`, four points, consistent": {"contact": {"force": "consistent"}, "tool": _FOUR},
    "the same, least energy": {"contact": {"force": "consistent", "god_object": "least-energy"}, "tool": _FOUR},
    '`force_return = "ramp"`': {"device": {"force_return": "ramp"}},
    '`max_speed = "off"`': {"device": {"max_speed": "off"}},
    '`max_force_rate = "off"`': {"device": {"max_force_rate": "off"}},
    '`mean_force = "off"`': {"device": {"mean_force": "off"}},
    "`check = false`": {"tables": {"check": False}},
    "none of the limits, and no check": {"device": _NO_LIMITS, "tables": {"check": False}},
}


def plain_scene(body: str) -> Scene:
    return {**scenes.read(BODIES[body][0]), "contact": {}, "tables": {"columns": "none"}}


def cost_of(body: str, what: str, change: Change) -> tuple[list[Any], dict[str, Any]]:
    """The row, and the summary of its tables."""
    folder = build() / f"named/{body}"
    summary = scenes.precompute(vary(plain_scene(body), **change), folder, "--threads", "1")
    tables, linked = sum(summary["flash"]["table"].values()), count_ticks(folder, "--link")
    stack = stacks_of(folder, "cortex-m7")["haptable_step"]
    one = count_ticks(folder, "--strokes", "100", "--target", "cortex-m7", path="strokes")[0]
    touching = sorted(n for n, (state,) in zip(one["instructions"], one["states"]) if state in (_CONTACT, _LIMITED))
    if not touching:
        raise LabError(f"{body}: {what}: the laboratory's finger touched nothing: no instructions were counted")
    return [f"{body}: {what}", *map(count, (tables, linked["flash"] - tables, linked["ram"], stack)),
            _several(touching[len(touching) // 2], touching[-1]), seconds(sum(summary["cpu_s"].values()))], summary


def named() -> Topics:
    rows: dict[str, list[Any]] = {"cube": [], "mouse": []}
    precision = []
    for body in rows:
        plain = build() / f"named/{body}-plain"
        scenes.precompute(plain_scene(body), plain)
        for what, change in {**variants(BODIES[body][1], plain), **(OF_ANY_MESH if body == "cube" else {})}.items():
            row, summary = cost_of(body, what, change)
            rows[body].append(row)
            if what in ('`force = "consistent"`', '`force = "pressure-mask"`'):
                stored = summary["flash"]["precision"]
                precision.append([f"{body}: {what}", *(
                    number([stored[p]["bytes"], stored[p]["worst_force_error"]], "{:,}, {:.1e}")
                    for p in ("float32", "float16", "int16"))])
    columns = ("the scene names | tables, bytes | code, bytes | RAM, bytes | stack, bytes | "
               "instructions a tick in contact, median / worst | precompute")
    # Every mesh's first, then what costs the same whatever the mesh.
    return {"named": table(columns, rows["cube"]), "named-mouse": table(columns, rows["mouse"]),
            "precision-compliance": table("the scene names | float32 | float16 | int16", precision)}


def make(out: Path) -> None:
    """Instructions of a tick on the microcontrollers, in every mode, and what a scene pays for what it names."""
    topics: Topics = {}
    for measure in (modes, fingers, bodies, named):
        say("instructions:", measure.__name__)
        topics.update(measure())
    write_topics(out, topics)
