# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of what the measuring programs of host/bench tell as JSON: speed and error of the servo, ticks beside peers,
devices, the inversion. `make bench` calls each."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab import binding, told
from lab.contact import Bodies, contact_cube, mouse
from lab.error import FORCES
from lab.numbers import Topics, count, error_of, number, seconds, to_markdown, write_topics

Cells = list[Any]


def three(value: float | None) -> Any:
    """Three digits; "-" where it was not measured."""
    return "-" if value is None else number(value, f"{value:.3g}")


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


def speed_tables(raw: dict[str, Any]) -> dict[str, Any]:
    """raw: of haptable-bench."""
    scenes, names = raw["scenes"], list(raw["scenes"])

    def median(row: str, name: str, of: str = "cpu") -> float:
        return float(np.median(raw["times_s"][row][name][of]))

    def row(what: str, cell: Callable[[str], Any], *beside: str) -> Cells:
        return [what, *map(cell, names), *beside]

    def errors(key: str) -> Callable[[str], Any]:
        return lambda name: error_of(scenes[name][key])
    speed = [row(what, lambda name, r=measured: seconds(median(r, name)), beside) for what, measured, beside in _SPEEDS]
    speed.append(row("the same, elapsed", lambda name: seconds(median("draw", name, "elapsed")), ""))
    speed.append(row("speed of the sliding finger", lambda name: number(
        scenes[name]["speed_m_s"], f"{1e3 * scenes[name]['speed_m_s']:.0f} mm/s"), ""))
    ratios = []

    def wanted(what: str, value: float, kept: bool, words: str) -> None:
        ratios.append([what, three(value), words + (": kept" if kept else ": MISSED")])
    step = {name: median("force step, sliding", name) for name in names}
    for name in names:
        solve = median("one solve", name) / step[name]
        wanted(f"{name}: one solve over a force step", solve, solve >= 30.0, "at least 30")
    if len(names) == 2:
        grown = step[names[1]] / step[names[0]]
        wanted(f"force step, {names[1]} over {names[0]}", grown, grown <= 1.3, "at most 1.3")

    def stored(precision: str) -> Callable[[str], Any]:
        def cell(name: str) -> Any:
            found = scenes[name]["precisions"][precision]
            return {"value": [found["bytes"], found["worst"]], "text": f"{found['bytes']:,}, {found['worst']:.1e}"}
        return cell
    return {
        "speed": {"columns": ["", *names, "the paper (Pentium Pro, 200 MHz)"], "rows": speed},
        "error": {"columns": ["", *names, "against"], "rows": [
            row("force in float32, sliding 2 mm deep, worst", errors("force_error"), "equations 9 to 12 in double"),
            row("displacement, float32 columns, worst", errors("displacement_error"), "a solve in double")]},
        "ratio": {"columns": ["", "value", "wanted"], "rows": ratios},
        "precision": {"columns": ["", *names],
                      "rows": [row(p, stored(p)) for p in scenes[names[0]]["precisions"]]}}


def speed(build: Path, out: Path, repetitions: int = 9) -> None:
    """Speed of tick and picture."""
    write_topics(out,
                 speed_tables(told(build / "bin/haptable-bench", "meshes/cube.toml", "meshes/mouse.toml", "--build",
                                        build, "--repetitions", repetitions)))


# ---- ticks beside peers ------------------------------------------------------------------------------------------

def times_of(fastest_s: Sequence[float], clock_s: float) -> list[float]:
    """Mean, median and 99.9 % of ticks without the clock's own time. A proxy's ticks alternate between short and long
    searches: its median is not its mean."""
    s = np.sort(np.array(fastest_s) - clock_s)
    return [float(s.mean()), *(float(s[int(share * (len(s) - 1))]) for share in (0.5, 0.999))]


def beside_tables(cube: dict[str, Any], mouse_: dict[str, Any]) -> dict[str, Any]:
    """How many times as fast as a peer a whole tick of each mode is, with friction as the peer's with friction; first
    the peer's own times; the paper's mode above the surface, where all modes do the same. A table a peer. Each: of
    haptable-contact, of one body."""
    def times(kind: str) -> list[dict[str, list[float]]]:
        return [{name: times_of(s, times_of(body[kind]["clock"], 0.0)[1]) for name, s in body[kind].items()}
                for body in (cube, mouse_)]
    contact, above = times("contact"), times("above")
    names = list(contact[0])
    modes = [name for name in names if name.split()[0] in FORCES]

    def taken(what: str, of: list[dict[str, list[float]]], name: str) -> Cells:
        return [what, *(seconds(s) for body in of for s in body[name])]

    def faster(what: str, of: list[dict[str, list[float]]], mode: str, peer: str) -> Cells:
        peer += " friction" * mode.endswith(" friction")
        return [what, *(number(p / m, f"{p / m:.2f}") for body in of for p, m in zip(body[peer], body[mode]))]
    return {f"modes-beside-{peer}": {
        "columns": ["", "cube, mean", "median", "99.9 %", "mouse, mean", "median", "99.9 %"],
        "rows": [taken("it takes", contact, peer), taken("with friction", contact, f"{peer} friction"),
                 taken("2 mm above", above, peer), *(faster(mode, contact, mode, peer) for mode in modes),
                 faster("2 mm above", above, modes[0], peer)]}
            for peer in names if f"{peer} friction" in names and peer not in modes}


def tool_tables(cube: dict[str, Any], mouse_: dict[str, Any]) -> dict[str, Any]:
    """What a tick of a tool takes, and what as many proxies of each peer take on the same path. Each: of
    haptable-contact, of one body."""
    bodies = (cube["tool"], mouse_["tool"])

    def row(what: str, name: str) -> Cells:
        return [what, *(seconds(s) for body in bodies
                        for s in times_of(body["ticks"][name], times_of(body["ticks"]["clock"], 0.0)[1]))]
    count = bodies[0]["points"]
    said = {"nearest": f"{count} points, nearest", "least-energy": f"{count} points, least energy"}
    rows = [row(said.get(name, f"{count} proxies of {name}"), name) for name in bodies[0]["ticks"] if name != "clock"]
    pressing = [number(body["pressing"], f"{body['pressing']:.1f}") for body in bodies]
    return {"tool-beside-proxies": {
        "columns": ["", "cube, mean", "median", "99.9 %", "mouse, mean", "median", "99.9 %"],
        "rows": [*rows, ["points that press", pressing[0], "", "", pressing[1], "", ""]]}}


def beside(build: Path, out: Path, rounds: int = 30) -> None:
    """Ticks of the contact modes beside peers. Writes nothing where no peer could be had (make peers)."""
    bodies, peers = Bodies(build, binding.load(build)), sorted((build / "peers").glob("*.so"))
    if peers:
        times = [told(build / "bin/haptable-contact", *(bodies.folder(scene, force, radius) for force in FORCES),
                      "--tool", bodies.with_tool(scene, radius),
                      *(word for peer in peers for word in ("--peer", peer)), "--rounds", rounds)
                 for scene, radius in ((contact_cube(5), 0.012), (mouse(), 0.006))]
        write_topics(out, {**beside_tables(*times), **tool_tables(*times)})


# ---- devices -------------------------------------------------------------------------------------------------------

def _of_thousands(value: float) -> str:
    return f"{value:.3g}" if value < 1000.0 else f"{round(value):,}"


def _stiffness(n_per_m: float | None) -> Any:
    return "none to 1e6" if n_per_m is None else number(n_per_m, _of_thousands(n_per_m))


def device_tables(raw: dict[str, Any]) -> dict[str, Any]:
    """raw: of haptable-bench-devices."""
    units = {"peak force": ("max_force_n", 1.0, "N"), "continuous": ("continuous_force_n", 1.0, "N"),
             "mass": ("mass_kg", 1e-3, "g"), "friction": ("friction_n", 1.0, "N"),
             "damping": ("damping_n_s_per_m", 1.0, "N s/m"), "encoder step": ("encoder_step_m", 1e-3, "mm"),
             "motors' bandwidth": ("bandwidth_hz", 1.0, "Hz"), "delay": ("delay_s", 1e-3, "ms"),
             "weight that nothing balances": ("unbalanced", 0.01, "%")}

    def figure(found: dict[str, Any], unit: float, name: str) -> Any:
        if found["source"] == "none" and found["value"] == 0.0:
            return "none"
        return number(found["value"], f"{_of_thousands(found['value'] / unit)} {name} ({found['source']})")

    def reach(model: dict[str, Any]) -> str:
        if model["reach_m"][0] == 0.0:
            return "endless"
        return " x ".join(f"{1e3 * r:.0f}" for r in model["reach_m"]) + f" mm ({model['reach_source']})"
    figures = [[f"`{m['name']}`", m["title"], *(figure(m[key], unit, name) for key, unit, name in units.values()),
                reach(m),
                "y" if m["up"][1] > 0.0 else "z"] for m in raw["models"]]
    stability = []
    for s in raw["stability"]:
        over = s["alone"] / s["promised"] if s["promised"] > 0.0 and s["alone"] is not None else None
        stability.append([f"`{s['name']}`" + (", a tick later" if s["later"] else ""),
                          number(s["delay_s"], f"{1e3 * s['delay_s']:.2f} ms"), _stiffness(s["promised"]),
                          _stiffness(s["alone"]), "-" if over is None else number(over, f"{over:.2f}"),
                          *(_stiffness(s[key]) for key in ("soft", "stiff", "slow", "held", "passive")),
                          _stiffness(min(s["passive"], s["held"]))])
    return {"device-figures": {"columns": ["name", "device", *units, "workspace, x y z", "up"], "rows": figures},
            "device-stability": {"columns": [
                "device", "delay and lag", "codegen's limit, N/m", "rings from, at 0.5 m/s", "over codegen's",
                "the same in a soft hand", "in a stiff hand", "rings from, at a step a tick", "2 f_c / D",
                "Colgate and Schenkel, 2 b / T", "Abbott and Okamura"], "rows": stability}}


def devices(build: Path, out: Path) -> None:
    """What the device models are, and from which stiffness each rings."""
    write_topics(out, device_tables(told(build / "bin/haptable-bench-devices")))


# ---- the inversion -------------------------------------------------------------------------------------------------

_GROWTH = [("factor, operations", "factor_flops", "2"), ("factor, CPU s", "factor_s", "2"),
           ("inversion, operations", "inversion_flops", "2"), ("inversion in double, CPU s", "double_s", "2"),
           ("inversion in float, CPU s", "float_s", "2"), ("factor, bytes", "factor_bytes", "4/3"),
           ("peak memory of the inversion in float", "float_peak", "4/3")]


def _error(value: float | None) -> Any:
    return "-" if value is None else error_of(value)


def growth(cubes: list[dict[str, Any]]) -> dict[str, Any]:
    """Exponents over the number of nodes: slopes of logarithms, by least squares."""
    nodes = np.log([cube["nodes"] for cube in cubes])
    rows = []
    for what, key, theory in _GROWTH:
        if all(cube[key] for cube in cubes):
            slope = float(np.polyfit(nodes, np.log([cube[key] for cube in cubes]), 1)[0])
            rows.append([what, number(slope, f"{slope:.2f}"), theory])
    return {"columns": [f"exponent over nodes, {cubes[0]['nodes']:,.0f} to {cubes[-1]['nodes']:,.0f}", "measured",
                        "nested dissection of a solid"], "rows": rows}


def inversion_tables(raw: dict[str, Any]) -> dict[str, Any]:
    """raw: of haptable-bench-inversion."""
    bodies = [defaultdict(lambda: None, body) for body in raw["bodies"]]  # what was not measured is not there
    times = [[b["name"], count(round(b["nodes"])), three(b["analysis_s"]), three(b["factor_bytes"] / 1e9),
              three(b["factor_s"]), three(b["factor_flops"] / b["factor_s"] / 1e9), three(b["double_s"]),
              three(_over(b["double_s"], b["factor_s"])), three(b["float_s"]), three(b["float_s"] / b["factor_s"]),
              *(three(_over(b[peak], 1e9)) for peak in ("factor_peak", "double_peak", "float_peak"))] for b in bodies]
    solves = [[b["name"], count(round(b["blocks"])), three(b["solves_s"]),
               number(b["sampled"], f"{100 * b['sampled']:.3g} %"), three(_over(b["solves_s"], b["double_s"])),
               three(b["solves_s"] / b["float_s"]), _error(b["double_error"]), _error(b["float_error"])]
               for b in bodies]
    columns = [[b["name"], three(b["columns_bytes"] / 1e9), three(b["columns_double_s"]), three(b["columns_float_s"]),
                _error(b["columns_error"]), three(b["solves_s"] / b["columns_double_s"]),
                three(b["solves_s"] / b["columns_float_s"]),
                *(seconds(float(np.median(b[key]))) for key in ("frame_s", "plain_frame_s"))]
               for b in bodies if b["columns_float_s"] is not None]
    topics = {
        "inversion-times": {"columns": [
            "body", "nodes", "METIS, analysis s", "factor GB", "factor s", "GF/s", "inversion double s", "/ factor",
            "float s",
            "/ factor", "peak GB: factor", "double", "float"], "rows": times},
        "inversion-solves": {"columns": [
            "body", "blocks", f"by solves, {raw['block_nodes']} nodes at a time, s", "of these run",
            "/ inversion double",
            "/ float", "error double", "error float"], "rows": solves},
        "inversion-columns": {"columns": [
            "body", "columns GB", "pruned, double s", "float s", "float against double",
            "blocked solves / pruned, double", "float", "one frame, pruned, float", "by CHOLMOD"], "rows": columns}}
    if "accuracy" in raw:
        topics["inversion-accuracy"] = {
            "columns": [f"cube of {raw['accuracy']['side']} nodes a side", "inversion, double", "inversion, float",
                        "solves", "inversion, double, against solves"],
            "rows": [[case["name"], *(error_of(case[key]) for key in ("double", "float", "solves", "against_solves"))]
                     for case in raw["accuracy"]["cases"]]}
    cubes = [b for b in bodies if b["is_cube"]]
    return {**topics, **({"inversion-growth": growth(cubes)} if len(cubes) > 1 else {})}


def inversion(build: Path, out: Path, sides: str = "12,20,25,32,40") -> None:
    """How the inversion grows, and its errors. sides: cubes of so many nodes a side."""
    write_topics(out, inversion_tables(told(build / "bin/haptable-bench-inversion", "--sides", sides, "--scene",
                                            "meshes/mouse.toml")))


# ---- instructions on the microcontrollers --------------------------------------------------------------------------

_MILLISECOND = 168e3  # instructions, at 168 MHz and one a clock
_KINDS = [(kind.replace("_", " ") if kind != "jump" else "a jump", "unlimited", kind)
          for kind in ("sliding", "first_contact", "free", "leaving", "jump")] + [
              ("sliding, with its limits", "limited", "sliding"), ("free, with its limits", "limited", "free")]


def instruction_tables(raw: list[dict[str, Any]]) -> Topics:
    """raw: of haptable-count. A cell: median / 99.9 % / worst."""
    rows, cycles = [], []
    for scene in raw:
        for what, limits, kind in _KINDS:
            found = [of[limits][kind] for of in scene["targets"].values()]
            worst = max(counts["worst"] for counts in found)
            cells = [[counts[key] for key in ("median", "p999", "worst")] for counts in found]
            rows.append([f"{scene['name']}, {what}",
                         *({"value": cell, "text": " / ".join(f"{n:,}" for n in cell)} for cell in cells),
                         number(worst / _MILLISECOND, f"{100 * worst / _MILLISECOND:.1f} %")])
        cycles += [[f"{scene['name']}, {target}", *map(count, of["cycles"])] for target, of in scene["targets"].items()
                   if "cycles" in of]
    topics: Topics = {"instructions": {"columns": ["tick", *raw[0]["targets"], "worst, of 1 ms at 168 MHz"],
                                       "rows": rows}}
    return {**topics, **({"cycles": {"columns": ["sliding", "median", "worst"], "rows": cycles}} if cycles else {})}


def instructions(build: Path, folders: list[Path], out: Path | None = None) -> None:
    """Instructions of a tick on the emulated microcontrollers. Prints the tables, or writes them to `out`."""
    topics = instruction_tables(told(build / "bin/haptable-count", *folders))
    if out:
        write_topics(out, topics, "make instructions")
    else:
        print("".join(f"{name}: {to_markdown(topic)}\n" for name, topic in topics.items()), end="")
