# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawings: how a force is made, the servo's states, frames of the device and of the body, one tick of contact."""

from typing import Any

import numpy as np
import pandas as pd

from lab import figure
from lab.figure import BLUE, GREY, INK, VERMILION, Figure
from lab.plots import force_size

# Colour-blind safe on white, and apart in grey.
_HOST, _TICK, _VIEW, _PLACE, _WHITE = "#DBE7F3", "#FDE6D3", "#DFF0E0", "#F4F1EA", "#FFFFFF"


_GROUND = {"facecolor": _PLACE, "edgecolor": "none", "alpha": 0.85, "pad": 1}  # of a text over a mesh's lines


def _sheet(name: str, width: float, height: float) -> tuple[Figure, Any]:
    """A sheet of `width` x `height` points, y upwards, without axes."""
    this = Figure(name)
    axes = this.axes(width=width / 72, height=height / 72)
    axes.set(xlim=(0, width), ylim=(0, height))
    axes.axis("off")
    this.figure.get_layout_engine().set(w_pad=0, h_pad=0)
    return this, axes


def _box(axes: Any, x: float, y: float, width: float, height: float, text: str, color: str) -> None:
    """Around its middle."""
    axes.add_patch(figure.plt.Rectangle((x - width / 2, y - height / 2), width, height, facecolor=color, edgecolor=GREY,
                                        linewidth=1, zorder=3))
    axes.text(x, y, text, ha="center", va="center", fontsize=10, zorder=4, linespacing=1.35)


def _path(axes: Any, color: str, *places: tuple[float, float]) -> None:
    """A line through places, with an arrow's head at the last."""
    x, y = zip(*places)
    axes.plot(x[:-1], y[:-1], color=color, linewidth=1.3, zorder=2)
    axes.annotate("", places[-1], xytext=places[-2], zorder=2,
                  arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0})


def signal_path() -> Figure:
    """How a scene becomes a force and a picture."""
    this, axes = _sheet("signal-path", 780, 400)
    for left, bottom, right, top, text in (
            (8, 280, 772, 392, "once, on the host: haptable-precompute"),
            (112, 138, 668, 256, "every millisecond, on the microcontroller: haptable_step"),
            (112, 8, 668, 112, "beside it, at its own rate: haptable-view")):
        axes.add_patch(figure.plt.Rectangle((left, bottom), right - left, top - bottom, facecolor=_PLACE,
                                            edgecolor="#D6D0C4", zorder=1))
        axes.text(left + 8, top - 13, text, fontsize=9, color="#5B5648", va="center", zorder=4)
    host = ("scene, mesh", "stiffness K", "factor of K", "blocks of\nL = K⁻¹", "tables (.npy)", "model.c")
    for k, text in enumerate(host):
        _box(axes, 66 + 130 * k, 322, 100, 48, text, _HOST)
        if k > 0:
            _path(axes, INK, (130 * k - 14, 322), (130 * k + 16, 322))
    tick = ("contact:\ngod-object g,\nfriction", "force:\nu = x − g\nF = −S(α) u", "gate:\nfinite, at most\nmax_force",
            "where named:\nrelease,\npassivity")
    for k, text in enumerate(tick):
        _box(axes, 180 + 138 * k, 188, 112, 66, text, _TICK)
        if k > 0:
            _path(axes, INK, (138 * k + 98, 188), (138 * k + 124, 188))
    _box(axes, 54, 188, 84, 66, "device\nor its\nsimulation", _WHITE)
    _box(axes, 255, 52, 200, 54, "equation 8:\nu_r = Σ L_ri F_i", _VIEW)
    _box(axes, 500, 52, 190, 54, "picture:\nPNG, film, ParaView", _VIEW)
    _path(axes, INK, (355, 52), (405, 52))
    _path(axes, INK, (716, 298), (716, 267), (596, 267), (596, 256))
    _path(axes, VERMILION, (96, 188), (124, 188))
    _path(axes, VERMILION, (594, 155), (594, 130), (54, 130), (54, 155))
    _path(axes, BLUE, (318, 155), (318, 79))
    _path(axes, BLUE, (750, 298), (750, 52), (595, 52))
    for x, y, text in ((500, 267, "the servo's tables"), (62, 118, "force F"), (102, 198, "x"),
                       (326, 120, "nodal forces F_i"), (674, 63, "columns of L")):
        axes.text(x, y, text, fontsize=9, color=INK, va="center", zorder=5)
    return this


def states() -> Figure:
    """The servo's states."""
    this, axes = _sheet("states", 800, 330)
    for x, y, text, color in (
            (90, 215, "0 silent\nno force", _HOST), (280, 215, "1 free\nno force", _HOST),
            (300, 50, "3 rejected\nno force", _HOST), (90, 50, "5 faulted\nno force, latched", _HOST),
            (515, 215, "2 contact\nthe body's force", _TICK), (720, 215, "4 limited\ngain below 1", _TICK)):
        _box(axes, x, y, 124, 58, text, color)
    up, down, back = BLUE, VERMILION, GREY
    for color, *places in (
            (up, (152, 224), (218, 224)), (up, (342, 224), (453, 224)), (up, (658, 206), (577, 206)),
            (down, (453, 206), (342, 206)), (down, (577, 224), (658, 224)), (down, (515, 186), (362, 66)),
            (down, (720, 186), (362, 42)), (back, (218, 206), (152, 206)), (back, (300, 79), (300, 186)),
            (back, (238, 50), (152, 50)), (back, (110, 79), (245, 186))):
        _path(axes, color, *places)
    for x, y, text in ((185, 238, "a position"), (185, 193, "20 ms"), (397, 238, "through the surface"),
                       (397, 193, "outside, seen"), (618, 238, "a limit acts"), (618, 193, "ramp, gain is 1"),
                       (600, 92, "no position, or one that no\nfinger reaches in time"), (350, 132, "20 good ticks"),
                       (195, 63, "repeated"), (92, 132, "acknowledged")):
        axes.text(x, y, text, fontsize=9, color=INK, ha="center", va="center", zorder=4)
    axes.text(400, 290, "From every state: 20 ms without a position → silent. Damaged tables, or a force that is no "
              "number → faulted.\nA red line may lower the force in one tick. A blue line begins at the present force; "
              "from there\nthe force rises with the body, max_force_rate and the ramp alone.",
              fontsize=9, color=INK, ha="center", va="center", linespacing=1.4)
    return this


def device_frames() -> Figure:
    """From the hand's coordinates to the body's."""
    this, axes = _sheet("device-frames", 720, 300)
    for x, text in ((24, "device (one whose y is up)"), (480, "body")):
        axes.text(x, 284, text, fontweight="bold", va="center")
    for origin, ends in (((105, 95), {"x": (205, 95), "y": (105, 200), "z, to the user": (52, 48)}),
                         ((520, 95), {"x": (620, 95), "z": (520, 200), "y": (580, 145)})):
        for name, end in ends.items():
            _path(axes, INK, origin, end)
            beside = (end[0], end[1] + 10) if end[0] == origin[0] else (end[0] + 10, end[1])
            axes.text(*((38, 34) if end[0] < origin[0] else beside), name, ha="center", va="center")
    axes.text(114, 84, "O", va="center")
    axes.text(470, 80, "p = position", va="center", bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})
    _box(axes, 626, 55, 164, 40, "the mesh, its own place", _HOST)
    for x, y, head, place, force in ((165, 160, 212, "x_device", "F_device = s_f (R M)ᵀ F"),
                                     (648, 130, 172, "x = p + s_x R M x_device", "F")):
        axes.plot([x], [y], "o", color=VERMILION, markersize=9)
        _path(axes, VERMILION, (x, y), (x, head))
        side = "left" if force != "F" else "center"
        axes.text(x + (12 if side == "left" else 0), y if side == "left" else head + 34, place, ha=side, va="center")
        axes.text(x - (10 if side == "left" else 0) + (12 if side == "center" else 0), head + 12 if side == "left" else
                  (y + head) / 2, force, ha="left", va="center")
    _path(axes, BLUE, (290, 160), (455, 160))
    _path(axes, BLUE, (455, 132), (290, 132))
    axes.text(372, 174, "motion: scale s_x, turn R, mirror M", ha="center", va="center", fontsize=9)
    axes.text(372, 118, "force: scale s_f, transposed", ha="center", va="center", fontsize=9)
    return this


# Seen from the front and above, without perspective; millimetres.
_TURN, _TILT = np.radians(-15.0), np.radians(42.0)


def _seen(place: Any) -> np.ndarray:
    """(..., 3) mm of the body to (..., 2) mm of the picture."""
    x, y, z = np.moveaxis(np.asarray(place, float), -1, 0)
    x, y = x - 11.25, y - 20.0
    up = (x * np.sin(_TURN) + y * np.cos(_TURN)) * np.sin(_TILT) + (z - 30) * np.cos(_TILT)
    return np.stack([x * np.cos(_TURN) - y * np.sin(_TURN), up], axis=-1)


def contact(felt: pd.DataFrame) -> Figure:
    """One tick of the servo on the paper's cube: nodes, area coordinates, god-object and force of the last tick."""
    this = Figure("contact")
    tick = felt.iloc[-1]
    finger = 1e3 * tick[["x", "y", "z"]].to_numpy(float)
    god = 1e3 * tick[["god_x", "god_y", "god_z"]].to_numpy(float)
    force = tick[["force_x", "force_y", "force_z"]].to_numpy(float)
    alpha = tick[["alpha_i", "alpha_j", "alpha_k"]].to_numpy(float)
    size = float(force_size(felt).iloc[-1])
    this.must(tick["contact"] == 1, "a contact")
    this.must(abs(god[2] - 30) < 0.01, "the god-object on the surface")
    this.must(abs(alpha.sum() - 1) < 1e-3, "the patch and its area coordinates")
    this.must(np.linalg.norm(finger - god) > 3, "u, 3 mm long")
    this.must(size > 0.3, "F, 0.3 N or more")
    at_god, at_finger = _seen(god), _seen(finger)
    newton = 9.0  # mm of the picture
    end = at_god + newton * (_seen(finger + force) - at_finger)
    for place in (at_god, at_finger, end):
        this.must(abs(place[0]) < 13 and abs(place[1]) < 9, "finger, god-object and force in its frame")

    axes = this.axes(width=8, height=5.6)
    axes.set(xlim=(-14, 14), ylim=(-9.9, 9.7), aspect="equal")
    axes.axis("off")
    colors = figure.thing_colors()

    def fill(places: Any, color: str, edge: str, zorder: int) -> None:
        axes.fill(*_seen(places).T, facecolor=color, edgecolor=edge, linewidth=1, zorder=zorder)

    # The generator's cube: 5 nodes a side, 7.5 mm between them, x fastest; the common edge of a cell's two patches
    # alternates from cell to cell. The body is cut along a mesh line, so that the finger in it is seen.
    for i in range(3):
        for j in range(2, 4):
            for half in range(2):
                corners = [((i + j) % 2 + 1 + 2 * half + k) % 4 for k in range(3)]
                fill([(7.5 * (i + (c in (1, 2))), 7.5 * (j + (c > 1)), 30) for c in corners], _PLACE, "#9A958A", 1)
    fill([(0, 15, 30), (22.5, 15, 30), (22.5, 15, 24), (0, 15, 24)], "#E7E2D6", "#9A958A", 3)
    nodes = [int(tick[f"node_{k}"]) for k in "ijk"]
    places = np.array([(7.5 * (n % 5), 7.5 * (n // 5 % 5), 30.0) for n in nodes])
    fill(places, _TICK, colors["finger"], 2)
    for k, place in enumerate(_seen(places)):
        axes.plot(*zip(at_god, place), ":", color=GREY, linewidth=1, zorder=4)
        axes.plot(*place, "o", color=GREY, markersize=6, zorder=5)
        out = (place - at_god) / np.linalg.norm(place - at_god)
        offset = out * 12 + (np.array([0, 16]) if place[0] > at_god[0] and place[1] < at_god[1] else 0)
        letter = "ijk"[k]
        axes.annotate(f"V_{letter}, α_{letter} = {alpha[k]:.2f}", place, xytext=offset, textcoords="offset points",
                      ha="right" if place[0] < at_god[0] else "left", va="center", color=INK, bbox=_GROUND, zorder=8)
    for to, color in ((at_finger, BLUE), (end, colors["force"])):
        axes.annotate("", to, xytext=at_god, zorder=6,
                      arrowprops={"arrowstyle": "-|>,head_width=0.3,head_length=0.6", "color": color, "linewidth": 2.4,
                                  "shrinkA": 0, "shrinkB": 6 if color == BLUE else 0})
    axes.plot(*at_god, "o", color=colors["god_object"], markersize=9, zorder=7)
    axes.plot(*at_finger, "o", color=colors["finger"], markersize=13, zorder=7)
    for text, place, offset, side, color in (
            ("u = x − g", 0.35 * at_god + 0.65 * at_finger, (10, 0), "left", BLUE),
            (f"F, the force on the finger: {size:.2f} N", end, (12, 0), "left", colors["force"]),
            ("x, the finger", at_finger, (14, -4), "left", INK), ("g, the god-object", at_god, (-12, 12), "right", INK),
            ("the surface at rest", _seen((0.6, 29, 30)), (8, -14), "left", GREY)):
        axes.annotate(text, place, xytext=offset, textcoords="offset points", ha=side, va="center", color=color,
                      bbox=_GROUND, zorder=8)
    return this
