# SPDX-License-Identifier: GPL-2.0-or-later
"""Plots of what was measured: of docs/numbers.json, of lab.contact's curves, of a servo's CSV."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from lab import figure
from lab.figure import BLACK, BLUE, GREEN, GREY, INK, ORANGE, PINK, VERMILION, Figure
from lab.numbers import Topics, frame

PLAIN = FuncFormatter(lambda v, _: f"{v:g}")
BODIES = ("cube, nu 0.3", "cube, nu 0.49", "mouse", "liver")

# name in numbers.json: how it is told, colour, symbol, line
FORCES = {
    "interpolated": ("interpolated (the paper's)", BLUE, "o", "-"),
    "consistent": ("consistent", GREEN, "^", "-"),
    "pressure-mask": ("pressure mask", VERMILION, "s", "-"),
    "dense inverse": ("instead: dense inverse", ORANGE, "P", ":"),
    "sparse solve": ("instead: sparse solve", BLACK, "X", ":"),
    "conjugate gradients": ("instead: conjugate gradients", GREY, "D", ":"),
    "the paper, 1998": ("the paper's own times, 1998", PINK, "*", ""),
}

# axis: column of the topic "points", how it is told, factor
COSTS = {
    "time": ("tick", "CPU time of a tick, µs", 1e6),
    "flash": ("flash", "tables, kB", 1e-3),
    "precompute": ("precompute", "CPU time to precompute, s", 1.0),
}


def fronts(points: pd.DataFrame, column: str) -> pd.DataFrame:
    """Rows of `points` that no other of the same body and force beats in both its error and `column`."""
    rows = points[points[column] > 0].sort_values(["body", "force", column, "error, RMS"], kind="stable")
    least = rows.groupby(["body", "force"])["error, RMS"].cummin()
    before = least.groupby([rows["body"], rows["force"]]).shift(fill_value=1e9)
    return rows[rows["error, RMS"] < 0.98 * before]


def _name(row: pd.Series) -> str:
    mesh = row["mesh"].removesuffix(" a side").removesuffix(" nodes")
    element = row["element"].replace("average-nodal-pressure", "nodal pressure")
    return mesh if element in ("linear", "") else f"{mesh} {element}"


def error(topics: Topics, axis: str) -> Figure:
    """Error of the force against what it costs, a panel a body: of each force the configurations that none beats."""
    this = Figure(f"error-{axis}")
    column, unit, scale = COSTS[axis]
    points = frame(topics["points"])
    meshes = points.groupby("body")["mesh"].nunique()
    best = fronts(points, column)
    panels = this.axes(2, 2, width=10, height=8.4, sharey=True)
    x_all = scale * best[column]
    for body, axes in zip(BODIES, panels.flat):
        of_body = best[best["body"] == body]
        percent = {force: 100 * rows["error, RMS"] for force, rows in of_body.groupby("force")}
        mask = percent.get("pressure-mask", pd.Series(dtype=float))
        # QUICK=1 has one mesh of a body that is read from a file: there is nothing to fall with.
        this.must(len(mask) > 0 and (meshes[body] == 1 or mask.max() > 2 * mask.min()),
                  f"an error of the mask that falls, {body}")
        this.must(mask.min() < percent["interpolated"].min(), f"the mask nearer to the body than a point, {body}")
        axes.set_title(body)
        axes.set(xscale="log", yscale="log", ylim=(0.05, 200), xlim=(x_all.min() / 2, x_all.max() * 30))
        axes.yaxis.set_major_locator(FixedLocator([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100]))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(PLAIN)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"
                                                     if 1e-4 < v < 1e4 else f"$10^{{{np.log10(v):.0f}}}$"))
        axes.set_xlabel(unit)
    for axes in panels[:, 0]:
        axes.set_ylabel("RMS error of the force, %")
    this.legend([figure.key(told, color=color, marker=marker, linestyle=line)
                 for force, (told, color, marker, line) in FORCES.items()
                 if force != "the paper, 1998" or axis == "time"], 4, 0.93)
    this.figure.canvas.draw()
    for body, axes in zip(BODIES, panels.flat):
        _draw_fronts(axes, best[best["body"] == body], column, scale)
    return this


def _draw_fronts(axes, rows: pd.DataFrame, column: str, scale: float) -> None:
    """Lines through all, symbols where they have room, names at those of the mask that have room beside all symbols."""
    taken: list[tuple[float, float]] = []
    named: list[tuple[str, float, float]] = []
    # What has fewest points first, so that it has its symbols.
    order = sorted(FORCES, key=lambda f: (f != "pressure-mask", (rows["force"] == f).sum()))
    for force in order:
        of_force = rows[rows["force"] == force]
        if of_force.empty:
            continue
        _, color, marker, line = FORCES[force]
        x, y = (scale * of_force[column]).to_numpy(), (100 * of_force["error, RMS"]).to_numpy()
        axes.plot(x, y, color=color, linestyle=line or "none", zorder=2)
        kept = figure.thinned(axes, x, y, 9.0, taken)
        axes.plot(x[kept], y[kept], color=color, linestyle="none", marker=marker, zorder=3,
                  markersize=9 if force == "the paper, 1998" else 5.5, markeredgecolor="white", markeredgewidth=0.6)
        if force == "pressure-mask":
            named = [(_name(of_force.iloc[k]), x[k], y[k]) for k in kept]
    figure.name_points(axes, named, taken, fontsize=7.5, color=FORCES["pressure-mask"][1])


def accuracy(topics: Topics) -> Figure:
    """CPU time of one tick, and of what else there is to do."""
    this = Figure("accuracy")
    rows = frame(topics["speed"])
    sliding, every, solve = (1e6 * rows["cube"][k] for k in (0, 2, 4))
    this.must(sliding < 1000, "a force within a tick of 1 ms")
    this.must(min(every, solve) > 5 * sliding, "a tick that costs less than what one would do instead")
    what = ["force,\nsliding", "force,\n2 mm above", "instead: nearest\nof every patch", "displacement,\nequation 8",
            "instead: a solve\nby the factor", "a picture,\n960 x 720"]
    axes = this.axes(width=9, height=4.4)
    for k, (body, color) in enumerate((("cube", BLUE), ("mouse", ORANGE))):
        at = np.arange(len(what)) + 0.4 * (k - 0.5)
        microseconds = 1e6 * rows[body][: len(what)]
        bars = axes.bar(at, microseconds, 0.38, label=body, color=color, edgecolor=INK, linewidth=0.5,
                        hatch="//" if k else None)
        axes.bar_label(bars, [f"{v:.2g}" if v < 100 else f"{v:,.0f}" for v in microseconds], fontsize=8, padding=1)
    axes.axhline(1000, color=INK, linestyle="--", linewidth=1)
    axes.text(-0.42, 1150, "a tick of the servo: 1 ms", fontsize=9, color=INK)
    axes.set(yscale="log", ylim=(0.01, 40000), ylabel="CPU time, µs", xticks=range(len(what)), xticklabels=what)
    axes.tick_params(axis="x", labelsize=8.5, length=0)
    axes.grid(axis="x", visible=False)
    axes.yaxis.set_major_formatter(PLAIN)
    axes.legend(loc="upper left", ncol=2)
    return this


def _ways(this: Figure, rows: pd.DataFrame, bodies: Sequence[str], height: float, **more: Any) -> Iterator[Any]:
    """A panel a body (column) and a way of moving (row): axes, way, body, its rows."""
    panels = this.axes(3, len(bodies), width=10, height=height, sharex="col", **more)
    for row, way in enumerate(("pressing", "sideways", "pulling")):
        for column, body in enumerate(bodies):
            axes = panels[row, column]
            if row == 0:
                axes.set_title(body)
            if row == 2:
                axes.set_xlabel("displacement, mm")
            yield axes, way, body, rows[(rows["body"] == body) & (rows["way"] == way)]


def large_strain(topics: Topics) -> Figure:
    """Where the linear body's force leaves that of a neo-Hookean one: a column a body, a row a way of moving."""
    this = Figure("large-strain")
    colors = {"pressing": BLUE, "sideways": GREEN, "pulling": VERMILION}
    for axes, way, body, of in _ways(this, frame(topics["large-strain-curve"]), BODIES, 6.4, sharey=True):
        bend = (of["force over the linear one"] - 1).abs()
        this.must(len(of) > 2 and bend.min() < 0.1 and bend.max() > 0.05,
                  f"a force that leaves the linear one, {body} {way}")
        mm = 1e3 * of["displacement"]
        axes.axhspan(0.9, 1.1, color="#E4E8EE", zorder=0)
        axes.plot(mm, of["expected"], color=colors[way])
        axes.plot(mm, of["force over the linear one"], "o", color=colors[way], markersize=4)
        axes.set(xlim=(0, 16 if body.startswith("cube") else 30), ylim=(0.6, 1.2))
        if body == BODIES[0]:
            axes.set_ylabel(f"{way}:\nF / F linear, 1")
    this.legend([figure.key("CalculiX", color=INK, marker="o", linestyle="none", markersize=4),
                 figure.key("expected by haptable-precompute", color=INK),
                 figure.key("within 10 % of linear", color="#E4E8EE", linewidth=8)], 3)
    return this


def stiffening(topics: Topics) -> Figure:
    """Force against depth of dents that stiffen: a column a body, a row a way of moving."""
    this = Figure("stiffening")
    rows = frame(topics["stiffening-curve"])
    bodies = list(rows["body"].unique())
    for axes, way, body, both in _ways(this, rows, bodies, 7.2):
        of = both[both["place"] == "0"]
        this.must(len(of) > 2 and of["CalculiX"].iloc[-1] > 1.05 * of["linear"].iloc[-1],
                  f"a force that grows beyond the linear one, {body} {way}")
        mm = np.append(0.0, 1e3 * of["depth"])
        for name, color, line in (("linear", GREY, "--"), ("stiffened", BLUE, "-")):
            axes.plot(mm, np.append(0.0, of[name]), line, color=color)
        axes.plot(mm[1:], of["CalculiX"], "o", color=VERMILION, markersize=4)
        axes.set(xlim=(0, 1.04e3 * rows[rows["body"] == body]["depth"].max()), ylim=(0, None),
                 ylabel=f"{way}:\nforce, N" if body == bodies[0] else "force, N")
    this.legend([figure.key("CalculiX, Yeoh's material", color=VERMILION, marker="o", linestyle="none", markersize=4),
                 figure.key("stiffened", color=BLUE), figure.key("linear", color=GREY, linestyle="--")], 3)
    return this


# ---- curves of lab.contact ------------------------------------------------------------------------------------------

def contact_line(data: Path) -> Figure:
    """Normal stiffness along a line over the cube's top: a panel a force, a curve a mesh."""
    this = Figure("contact-line")
    table = np.loadtxt(data)
    stiffness = table[:, 1:].reshape(len(table), 4, 3)  # nodes a side 9, 13, 17, 25; then the force
    mean, (_, consistent, mask) = stiffness.mean(0), stiffness[:, 3].T
    this.must(mean[3, 0] < 0.5 * mean[0, 0], "a point of force that softens with the mesh")
    this.must(consistent.max() > 1.2 * consistent.min(), "the ripple of the consistent force")
    this.must(abs(mean[3, 2] / mean[0, 2] - 1) < 0.1 and mask.max() < 1.1 * mask.min(),
              "a mask that does not change with the mesh")
    panels = this.axes(3, 1, width=8, height=7, sharex=True)
    for f, title in enumerate(("interpolated (the paper's)", "consistent", "pressure mask of 5 mm")):
        for m, (nodes, line) in enumerate(((9, ":"), (13, "-."), (17, "--"), (25, "-"))):
            panels[f].plot(table[:, 0], stiffness[:, m, f], linestyle=line, label=f"{nodes} nodes a side")
        panels[f].set_title(title)
        panels[f].set(xlim=(-3.6, 3.6), ylim=(0, None), ylabel="stiffness, N/m")
    panels[2].set_xlabel("position along the line, mm")
    this.legend(panels[0].get_lines(), 4)
    return this


def contact_loop(data: Path) -> Figure:
    """Energy given to the user around a loop over the cube's top."""
    this = Figure("contact-loop")
    place, *energy = np.loadtxt(data).T
    last = np.array([curve[-1] for curve in energy])
    this.must(all(curve.min() < -100 for curve in energy), "energy that is stored, every curve")
    this.must((last[:3] > 0).all(), "loops of the nearest god-object that give energy")
    this.must((last[3:] <= 0).all(), "loops of least energy that give none")
    axes = this.axes(width=8, height=4.6)
    looks = (("interpolated", BLUE), ("consistent", GREEN), ("mask", VERMILION))
    for (force, color), nearest, least in zip(looks, energy[:3], energy[3:]):
        axes.plot(place, nearest, color=color, label=f"{force}, nearest")
        axes.plot(place, least, "--", color=color, label=f"{force}, least energy")
    axes.set(ylabel="energy given to the user, µJ", xlabel="place on the loop", xticks=range(5),
             xticklabels=["start", "5 mm in", "8 mm aside", "out", "back"])
    axes.margins(x=0.01)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3)
    return this


def contact_edge(data: Path) -> Figure:
    """Force while a finger slides out over a convex edge."""
    this = Figure("contact-edge")
    ms, *forces = np.loadtxt(data).T
    modes = (("nearest", "-"), ("nearest, release 0.01 N/ms", "--"), ("least energy, release 0.01 N/ms", "-."))
    axes = this.axes(width=8, height=3.8)
    for (mode, line), force in zip(modes, forces):
        this.must(force.max() > 0.05, f"a force of the edge, {mode}")
        this.must(force[ms.argmax()] == 0, f"the finger leaving, {mode}")
        axes.plot(ms, force, linestyle=line, label=mode)
    axes.set(xlabel="time from the press's end, ms", ylabel="size of the force, N", ylim=(0, None))
    axes.margins(x=0.01)
    axes.legend()
    return this


# ---- a servo's CSV -------------------------------------------------------------------------------------------------

def force_size(felt: pd.DataFrame) -> pd.Series:
    return np.sqrt(felt["force_x"] ** 2 + felt["force_y"] ** 2 + felt["force_z"] ** 2)


def fingers(felt: pd.DataFrame) -> Figure:
    """Two fingers on the cube: one holds still, the other presses and leaves."""
    this = Figure("fingers")
    first, second = felt["force_z"], felt["force_z2"]
    this.must(first.max() > 0.1 and first.min() == 0, "the first finger pressing and leaving")
    this.must(second.max() > 0.05, "the second finger in contact")
    this.must(second[first.idxmax()] < 0.8 * second.max(), "the second force falling as the first presses")
    force, depth = this.axes(2, 1, width=8, height=5, sharex=True)
    colors, seconds = figure.thing_colors(), felt["tick"] / 1000
    for name, end, color, line in (("first finger", "", colors["finger"], "-"),
                                   ("second finger", "2", colors["second_finger"], "--")):
        force.plot(seconds, felt["force_z" + end], line, color=color, label=name)
        depth.plot(seconds, 1e3 * (0.03 - felt["z" + end]), line, color=color)
    force.set(ylabel="normal force, N")
    force.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=2)
    depth.set(xlabel="time, s", ylabel="depth under the top, mm", xlim=(0, seconds.max()), ylim=(-0.5, 4.5))
    return this


def relaxation(felt: pd.DataFrame) -> Figure:
    """The liver pressed 10 mm deep, let go, and pressed again after 1 s."""
    this = Figure("relaxation")
    size, tick = force_size(felt), felt["tick"]
    held = size[(tick > 8300) & (tick < 8400)]
    again = size[tick > 9600].max()
    this.must(0 < held.min() and held.max() < 0.8 * size.max(), "a force that relaxes")
    this.must(tick[size.idxmax()] < 1000 and size.max() > 0.2, "a peak as the finger comes in")
    this.must(size[(tick > 8800) & (tick < 9500)].max() == 0, "the finger let go")
    this.must(held.max() < again < 0.95 * size.max(), "a second peak, lower than the first")
    force, depth = this.axes(2, 1, width=8, height=5, sharex=True)
    colors, seconds = figure.thing_colors(), tick / 1000
    away = np.sqrt(sum((felt[a] - felt[f"god_{a}"]) ** 2 for a in "xyz"))
    force.plot(seconds, size, color=colors["force"])
    force.set(ylabel="size of the force, N", ylim=(0, None))
    depth.plot(seconds, 1e3 * np.where(felt["contact"] == 1, away, 0), color=colors["finger"])
    depth.set(xlabel="time, s", ylabel="depth, mm", xlim=(0, 14.5), ylim=(0, 11))
    return this


def relaxation_sliding(rows: np.ndarray) -> Figure:
    """Error of a sliding contact that relaxes: speed times time over radius, after a long press, after a short one."""
    this = Figure("relaxation-sliding")
    this.must(len(rows) > 4 and rows[:, 1].min() < 0.01 and rows[:, 1].max() > 0.2,
              "an error that rises with the speed")
    this.must(rows[:, 2].argmax() < len(rows) - 1, "a peak after a short press")
    axes = this.axes(width=7, height=4)
    axes.plot(rows[:, 0], 100 * rows[:, 1], "-", color=BLUE, label="after 8 times of rest")
    axes.plot(rows[:, 0], 100 * rows[:, 2], "--", color=VERMILION, label="pressed in 20 ms")
    axes.axhline(5, color=GREY, linestyle=":", label="5 %")
    axes.set(xscale="log", yscale="log", ylim=(0.02, 100), xlabel="speed x relaxation time / mask's radius, 1",
             ylabel="error of the force, % of its size")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(PLAIN)
    axes.legend(loc="lower right")
    return this


def measured(topics: Topics, curves: Path, folder: Path) -> list[str]:
    """Every plot of what was measured, into `folder`; those of contact where lab.contact has left its curves. Their
    names."""
    plots = [accuracy(topics), *(error(topics, axis) for axis in COSTS), large_strain(topics), stiffening(topics)]
    plots += [draw(curves / f"{name}.dat") for draw, name in ((contact_line, "line"), (contact_loop, "loop"),
                                                              (contact_edge, "edge"))
              if (curves / f"{name}.dat").exists()]
    for plot in plots:
        plot.save(folder)
    return [plot.name for plot in plots]
