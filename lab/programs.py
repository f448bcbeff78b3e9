# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of what the measuring programs of host/bench tell as JSON: speed and error of the servo, ticks beside peers,
devices, the inversion. `make bench` calls each."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab import binding, build, contact, cycles, scenes, told
from lab.error import FORCES, in_contact
from lab.numbers import Topic, Topics, count, error_of, number, percent, seconds, table, to_markdown, write_topics
from lab.reference import Array
from lab.scenes import Scene
from lab.target import MILLISECOND

Raw = dict[str, Any]  #: what a program tells


def _measured(cell: Callable[[float], Any]) -> Callable[[float | None], Any]:
    """A cell, or "-" where it was not measured."""
    return lambda value: "-" if value is None else cell(value)


_three = _measured(lambda value: number(value, "{:.3g}"))
_error = _measured(error_of)


def _over(a: float | None, b: float | None) -> float | None:
    return None if a is None or b is None else a / b


# ---- speed and error -----------------------------------------------------------------------------------------------

_SPEEDS = [
    ("force: god-object and equations 9 to 12, sliding", "force step, sliding", "15 us cube, 12 us mouse"),
    ("the same tick with the finger 2 mm above the surface", "force step, free", ""),
    ("for comparison: nearest point of every patch", "search over all patches", ""),
    ("displacement: equation 8, three nodes, free surface", "equation 8", "158 us cube, 4181 us mouse"),
    ("for comparison: one solve with a kept CHOLMOD factor", "one solve", ""),
    ("one picture, 960 x 720, without PNG, CPU of all threads", "draw", "97 Hz cube, 2 Hz mouse")]


def speed_tables(raw: Raw) -> Topics:
    """raw: of haptable-bench, with what speed() knows of each scene besides."""
    bodies: Raw = raw["scenes"]

    def median(row: str, name: str, of: str = "cpu_time") -> float:
        """s; Google Benchmark tells ns, and of the repetitions their mean and others besides."""
        return 1e-9 * float(np.median([run[of] for run in raw["runs"] if run["run_type"] == "iteration"
                                       and run["name"].startswith(f"{name}:{row}/")]))

    def row(what: str, cell: Callable[[str], Any], *beside: str) -> list[Any]:
        """cell: of a body's name."""
        return [what, *map(cell, bodies), *beside]

    def wanted(what: str, value: float, kept: bool, words: str) -> list[Any]:
        return [what, _three(value), words + (": kept" if kept else ": MISSED")]
    speed = [row(what, lambda name, r=measured: seconds(median(r, name)), beside) for what, measured, beside in _SPEEDS]
    speed.append(row("the same, elapsed", lambda name: seconds(median("draw", name, "real_time")), ""))
    speed.append(row("speed of the sliding finger", lambda name: number(bodies[name]["speed_m_s"], "{:.0f} mm/s", 1e3),
                     ""))
    step = {name: median("force step, sliding", name) for name in bodies}
    faster = {name: median("one solve", name) / step[name] for name in bodies}
    ratios = [wanted(f"{name}: one solve over a force step", ratio, ratio >= 30.0, "at least 30")
              for name, ratio in faster.items()]
    if len(step) == 2:
        (small, small_s), (large, large_s) = step.items()
        ratios.append(wanted(f"force step, {large} over {small}", large_s / small_s, large_s <= 1.3 * small_s,
                             "at most 1.3"))
    precisions = {name: body["precisions"] for name, body in bodies.items()}
    stored = [row(p, lambda name, p=p: number([precisions[name][p][key] for key in ("bytes", "worst_force_error")],
                                              "{:,}, {:.1e}")) for p in next(iter(precisions.values()))]
    names = " | ".join(bodies)
    return {
        "speed": table(f" | {names} | the paper (Pentium Pro, 200 MHz)", speed),
        "error": table(f" | {names} | against", [
            row("force in float32, sliding 2 mm deep, worst", lambda name: error_of(bodies[name]["force_error"]),
                "equations 9 to 12 in double"),
            row("displacement, float32 columns, worst", lambda name: error_of(bodies[name]["displacement_error"]),
                "a solve in double")]),
        "ratio": table(" | value | wanted", ratios),
        "precision": table(f" | {names}", stored)}


def force_error(folder: Path, path: Array) -> float:
    """The servo's force, its finger sliding on the path, against equations 9 to 12 in double from the same god-object:
    the largest of the relative differences."""
    body = binding.load().load(folder, bare=True)
    felt = body.servo().replay(np.vstack([path[0] + (0.0, 0.0, 0.004), path]))[1:]
    given = in_contact(body, felt)
    rigid = scenes.summary_of(folder)["contact"]["rigid_stiffness_n_per_m"]
    stiffness = np.tile(rigid * np.eye(3), (len(body.rest), 1, 1))
    stiffness[np.load(folder / "node_id.npy")] = np.load(folder / "stiffness.npy").reshape(-1, 3, 3)
    alpha, u = felt["alpha"].astype(float), path - felt["god_object"]
    wanted = -np.einsum("ta,taij,tj->ti", alpha, stiffness[felt["nodes"]], u)
    return float((np.linalg.norm(given - wanted, axis=1) / np.linalg.norm(wanted, axis=1)).max())


def speed(out: Path, repetitions: int = 9) -> None:
    """Speed of tick and picture."""
    raw = told("haptable-bench", "meshes/cube.toml", "meshes/mouse.toml", "--build", build(), "--repetitions",
               repetitions)
    for name, body in raw["scenes"].items():
        folder, path = build() / name, np.array(body["path_m"])
        round_m = np.linalg.norm(path - np.roll(path, 1, axis=0), axis=1).sum()
        body.update(precisions=scenes.summary_of(folder)["flash"]["precision"],
                    speed_m_s=1e3 * round_m / len(path), force_error=force_error(folder, path))
    write_topics(out, speed_tables(raw))


# ---- ticks beside peers ------------------------------------------------------------------------------------------

_QUANTILES = " | cube, mean | median | 99.9 % | mouse, mean | median | 99.9 %"


def times_of(fastest_s: Sequence[float], clock_s: float) -> list[float]:
    """Mean, median and 99.9 % of ticks without the clock's own time. A proxy's ticks alternate between short and long
    searches: its median is not its mean."""
    s = np.array(fastest_s) - clock_s
    return [float(s.mean()), *np.quantile(s, (0.5, 0.999), method="lower").tolist()]


def _times(ticks: Raw) -> dict[str, list[float]]:
    return {name: times_of(s, times_of(ticks["clock"], 0.0)[1]) for name, s in ticks.items() if name != "clock"}


def beside_tables(cube: Raw, mouse: Raw) -> Topics:
    """How many times as fast as a peer a whole tick of each mode is, with friction as the peer's with friction; first
    the peer's own times; the paper's mode above the surface, where all modes do the same. A table a peer. Each: of
    haptable-contact, of one body."""
    touching, above = ([_times(body[kind]) for body in (cube, mouse)] for kind in ("contact", "above"))
    modes = [name for name in touching[0] if name.split()[0] in FORCES]
    peers = [name for name in touching[0] if f"{name} friction" in touching[0] and name not in modes]

    def taken(what: str, of: list[dict[str, list[float]]], name: str) -> list[Any]:
        return [what, *(seconds(s) for body in of for s in body[name])]

    def faster(what: str, of: list[dict[str, list[float]]], mode: str, peer: str) -> list[Any]:
        peer += " friction" * mode.endswith(" friction")
        return [what, *(number(p / m, "{:.2f}") for body in of for p, m in zip(body[peer], body[mode]))]
    return {f"modes-beside-{peer}": table(_QUANTILES, [
        taken("it takes", touching, peer), taken("with friction", touching, f"{peer} friction"),
        taken("2 mm above", above, peer), *(faster(mode, touching, mode, peer) for mode in modes),
        faster("2 mm above", above, modes[0], peer)]) for peer in peers}


def tool_tables(bodies: dict[str, Raw]) -> Topics:
    """What a tick of a tool takes, and what as many proxies of each peer take on the same path. bodies: by name, of
    haptable-contact."""
    tools = [body["tool"] for body in bodies.values()]
    points = tools[0]["points"]
    said = {"nearest": f"{points} points, nearest", "least-energy": f"{points} points, least energy"}
    times = [_times(tool["ticks"]) for tool in tools]
    rows = [[said.get(name, f"{points} proxies of {name}"), *(seconds(s) for body in times for s in body[name])]
            for name in times[0]]
    pressing = [cell for tool in tools for cell in (number(tool["pressing"], "{:.1f}"), "", "")]
    header = "".join(f" | {name}, mean | median | 99.9 %" for name in bodies)
    return {"tool-beside-proxies": table(header, [*rows, ["points that press", *pressing]])}


def beside(out: Path, rounds: int = 30) -> None:
    """Ticks of the contact modes beside peers. Writes nothing where no peer could be had (make peers)."""
    peers = sorted((build() / "peers").glob("*.so"))

    def times(scene: Scene, radius: float, tool_radius: float) -> Raw:
        folders = (contact.folder_of(scenes.touched(scene, force, radius)) for force in FORCES)
        return told("haptable-contact", *folders, "--tool", contact.with_tool(scene, tool_radius),
                    *(word for peer in peers for word in ("--peer", peer)), "--rounds", rounds)
    if peers:
        cube, mouse = (contact.contact_cube(5), 0.012), (scenes.read("mouse"), 0.006)
        bodies = {"cube": times(*cube, 0.012), "mouse": times(*mouse, 0.0023), "wide masks": times(*mouse, 0.006)}
        write_topics(out, {**beside_tables(bodies["cube"], bodies["mouse"]), **tool_tables(bodies)})


# ---- devices -------------------------------------------------------------------------------------------------------

#: By column: the key, how much of it is one of the unit's, the unit.
_FIGURES = {"peak force": ("max_force_n", 1.0, "N"), "continuous": ("continuous_force_n", 1.0, "N"),
            "mass": ("mass_kg", 1e-3, "g"), "friction": ("friction_n", 1.0, "N"),
            "damping": ("damping_n_s_per_m", 1.0, "N s/m"), "encoder step": ("encoder_step_m", 1e-3, "mm"),
            "motors' bandwidth": ("bandwidth_hz", 1.0, "Hz"), "delay": ("delay_s", 1e-3, "ms"),
            "weight that nothing balances": ("unbalanced", 0.01, "%")}


def _of_thousands(value: float) -> str:
    return f"{value:.3g}" if value < 1000.0 else f"{round(value):,}"


def _stiffness(n_per_m: float | None) -> Any:
    return "none to 1e6" if n_per_m is None else number(n_per_m, _of_thousands(n_per_m))


def device_tables(raw: Raw) -> Topics:
    """raw: of haptable-bench-devices."""
    def figure(found: Raw, unit: float, name: str) -> Any:
        if found["source"] == "none" and found["value"] == 0.0:
            return "none"
        return number(found["value"], f"{_of_thousands(found['value'] / unit)} {name} ({found['source']})")

    def reach(model: Raw) -> str:
        sides = " x ".join(f"{1e3 * r:.0f}" for r in model["reach_m"])
        return f"{sides} mm ({model['reach_source']})" if model["reach_m"][0] else "endless"

    def stability(s: Raw) -> list[Any]:
        over = s["alone"] / s["promised"] if s["promised"] > 0.0 and s["alone"] is not None else None
        keys = ("soft", "stiff", "slow", "held", "passive")
        return [f"`{s['name']}`" + (", a tick later" if s["later"] else ""), number(s["delay_s"], "{:.2f} ms", 1e3),
                _stiffness(s["promised"]), _stiffness(s["alone"]), "-" if over is None else number(over, "{:.2f}"),
                *(_stiffness(s[key]) for key in keys), _stiffness(min(s["passive"], s["held"]))]
    figures = [[f"`{m['name']}`", m["title"], *(figure(m[key], unit, name) for key, unit, name in _FIGURES.values()),
                reach(m), "y" if m["up"][1] > 0.0 else "z"] for m in raw["models"]]
    return {"device-figures": table(["name", "device", *_FIGURES, "workspace, x y z", "up"], figures),
            "device-stability": table(
                "device | delay and lag | codegen's limit, N/m | rings from, at 0.5 m/s | over codegen's | the same in "
                "a soft hand | in a stiff hand | rings from, at a step a tick | 2 f_c / D | Colgate and Schenkel, "
                "2 b / T | Abbott and Okamura", map(stability, raw["stability"]))}


def devices(out: Path) -> None:
    """What the device models are, and from which stiffness each rings."""
    write_topics(out, device_tables(told("haptable-bench-devices")))


# ---- the inversion -------------------------------------------------------------------------------------------------

_GROWTH = [("factor, operations", "factor_flops", "2"), ("factor, CPU s", "factor_s", "2"),
           ("inversion, operations", "inversion_flops", "2"), ("inversion in double, CPU s", "double_s", "2"),
           ("inversion in float, CPU s", "float_s", "2"), ("factor, bytes", "factor_bytes", "4/3"),
           ("peak memory of the inversion in float", "float_peak", "4/3")]


def growth(cubes: list[Raw]) -> Topic:
    """Exponents over the number of nodes: slopes of logarithms, by least squares."""
    nodes = [cube["nodes"] for cube in cubes]

    def slope(key: str) -> float:
        return float(np.polyfit(np.log(nodes), np.log([cube[key] for cube in cubes]), 1)[0])
    return table([f"exponent over nodes, {nodes[0]:,.0f} to {nodes[-1]:,.0f}", "measured",
                  "nested dissection of a solid"],
                 [[what, number(slope(key), "{:.2f}"), theory] for what, key, theory in _GROWTH
                  if all(cube[key] for cube in cubes)])


def inversion_tables(raw: Raw) -> Topics:
    """raw: of haptable-bench-inversion."""
    bodies = [defaultdict(lambda: None, body) for body in raw["bodies"]]  # what was not measured is not there
    times = [[b["name"], count(round(b["nodes"])), *map(_three, (
        b["analysis_s"], b["factor_bytes"] / 1e9, b["factor_s"], b["factor_flops"] / b["factor_s"] / 1e9, b["double_s"],
        _over(b["double_s"], b["factor_s"]), b["float_s"], b["float_s"] / b["factor_s"],
        *(_over(b[peak], 1e9) for peak in ("factor_peak", "double_peak", "float_peak"))))] for b in bodies]
    solves = [[b["name"], count(round(b["blocks"])), _three(b["solves_s"]), percent(b["sampled"], "{:.3g} %"),
               _three(_over(b["solves_s"], b["double_s"])), _three(b["solves_s"] / b["float_s"]),
               _error(b["double_error"]), _error(b["float_error"])] for b in bodies]
    columns = [[b["name"], *map(_three, (b["columns_bytes"] / 1e9, b["columns_double_s"], b["columns_float_s"])),
                _error(b["columns_error"]), *(_three(b["solves_s"] / b[key])
                                              for key in ("columns_double_s", "columns_float_s")),
                *(seconds(float(np.median(b[key]))) for key in ("frame_s", "plain_frame_s"))]
               for b in bodies if b["columns_float_s"] is not None]
    topics = {
        "inversion-times": table(
            "body | nodes | METIS, analysis s | factor GB | factor s | GF/s | inversion double s | / factor | "
            "float s | / factor | peak GB: factor | double | float", times),
        "inversion-solves": table(
            f"body | blocks | by solves, {raw['block_nodes']} nodes at a time, s | of these run | / inversion double | "
            "/ float | error double | error float", solves),
        "inversion-columns": table(
            "body | columns GB | pruned, double s | float s | float against double | blocked solves / pruned, double | "
            "float | one frame, pruned, float | by CHOLMOD", columns)}
    if "accuracy" in raw:
        topics["inversion-accuracy"] = table(
            f"cube of {raw['accuracy']['side']} nodes a side | inversion, double | inversion, float | solves | "
            "inversion, double, against solves",
            [[case["name"], *(error_of(case[key]) for key in ("double", "float", "solves", "against_solves"))]
             for case in raw["accuracy"]["cases"]])
    cubes = [b for b in bodies if b["is_cube"]]
    return {**topics, **({"inversion-growth": growth(cubes)} if len(cubes) > 1 else {})}


def inversion(out: Path) -> None:
    """How the inversion grows, and its errors."""
    write_topics(out, inversion_tables(told("haptable-bench-inversion", "--sides", "12,20,25,32,40", "--scene",
                                            "meshes/mouse.toml")))


# ---- instructions on the microcontrollers --------------------------------------------------------------------------

_KINDS = [("sliding", "unlimited", "sliding"), ("first contact", "unlimited", "first_contact"),
          ("free", "unlimited", "free"), ("leaving", "unlimited", "leaving"), ("a jump", "unlimited", "jump"),
          ("sliding, with its limits", "limited", "sliding"), ("free, with its limits", "limited", "free")]


def instruction_tables(raw: list[Raw], estimates: Sequence[Sequence[Any]] = ()) -> Topics:
    """raw: of haptable-count. A cell: median / 99.9 % / worst. estimates: a scene and target, and cycles of its median
    sliding tick and of the worst."""
    rows = []
    for scene in raw:
        for what, limits, kind in _KINDS:
            cells = [[of[limits][kind][key] for key in ("median", "p999", "worst")] for of in scene["targets"].values()]
            rows.append([f"{scene['name']}, {what}", *(number(cell, "{:,} / {:,} / {:,}") for cell in cells),
                         percent(max(worst for *_, worst in cells) / MILLISECOND, "{:.1f} %")])
    topics = {"instructions": table(["tick", *raw[0]["targets"], "worst, of 1 ms at 168 MHz"], rows)}
    if estimates:
        topics["cycles"] = table("sliding | median | worst", [[what, *map(count, of)] for what, *of in estimates])
    return topics


def instructions(folders: list[Path], out: Path | None = None) -> None:
    """Instructions of a tick on the emulated microcontrollers. Prints the tables, or writes them to `out`."""
    raw = told("haptable-count", *folders)
    topics = instruction_tables(raw, [
        [f"{scene['name']}, {target}", *of] for folder, scene in zip(folders, raw)
        for target, counted in scene["targets"].items()
        if None not in (of := [cycles.estimate(folder, target, tick) for tick in counted["sliding_at"]])])
    if out:
        write_topics(out, topics, "make instructions")
    else:
        print("".join(f"{name}: {to_markdown(topic)}\n" for name, topic in topics.items()), end="")
