# SPDX-License-Identifier: GPL-2.0-or-later
"""How every figure of the project is drawn: one style, SVG and PDF, and refused where it cannot be read."""

import itertools
import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  after use()
from matplotlib.lines import Line2D  # noqa: E402

from lab import LabError  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
plt.style.use(Path(__file__).with_name("haptable.mplstyle"))

#: Okabe and Ito's, by name.
BLUE, VERMILION, GREEN, PINK, ORANGE, SKY, BLACK = plt.rcParams["axes.prop_cycle"].by_key()["color"]
GREY, INK = "#7A828E", "#2D3748"


def thing_colors() -> dict[str, str]:
    """Colours on a light ground of what pictures, pages and plots share (host/base/colors.inc), by thing."""
    text = (ROOT / "host/base/colors.inc").read_text(encoding="utf-8")
    return {name: "#" + color for name, color in re.findall(r"^COLOR\((\w+), 0x([0-9a-f]{6}),", text, re.M)}


class Figure:
    """A figure by its name. `must` refuses it; `save` writes NAME.svg and NAME.pdf into a folder, or neither."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.figure: Any = None

    def must(self, condition: bool, what: str) -> None:
        """Raises LabError, "NAME: is to show WHAT", unless `condition`. A comparison with NaN is no."""
        if not condition:
            raise LabError(f"{self.name}: is to show {what}")

    def axes(self, rows: int = 1, columns: int = 1, *, width: float, height: float, **more: Any) -> Any:
        """Axes of a new figure of `width` x `height` inches: one, or an array."""
        self.figure, axes = plt.subplots(rows, columns, figsize=(width, height), **more)
        return axes

    def legend(self, handles: Any, columns: int, below: float = 0.95) -> None:
        """Above all axes, which end at this share of the height."""
        self.figure.legend(handles=handles, loc="upper center", ncol=columns)
        self.figure.get_layout_engine().set(rect=(0, 0, 1, below))

    def save(self, folder: Path) -> None:
        try:
            self.figure.canvas.draw()
            self._require_units()
            self._require_clear()
            files = {ending: folder / f"{self.name}.{ending}" for ending in ("svg", "pdf")}
            for ending, file in files.items():
                # No clock in a file: the same figure has the same bytes.
                about = {"Date": None, "Creator": None} if ending == "svg" else {"CreationDate": None}
                self.figure.savefig(file.with_suffix(f".{ending}.beside"), format=ending, metadata=about)
            for ending, file in files.items():
                os.replace(file.with_suffix(f".{ending}.beside"), file)
        finally:
            plt.close(self.figure)

    def _require_units(self) -> None:
        """Every scale that is drawn is named, and a quantity has its unit behind a comma."""
        for axes in (axes for axes in self.figure.axes if axes.axison):
            for x in "xy":
                labels = (t.get_text() for t in getattr(axes, f"get_{x}ticklabels")() if t.get_visible())
                sharing = getattr(axes, f"get_shared_{x}_axes")().get_siblings(axes)
                whole = getattr(self.figure, f"_sup{x}label")
                names = [getattr(one, f"get_{x}label")() for one in [axes, *sharing]]
                names += [whole.get_text()] if whole else []
                self.must(not any(re.fullmatch(r"\S*\d\S*", label) for label in labels)
                          or any(", " in name for name in names), "the unit of every axis")

    def _marked(self) -> Iterator[tuple[float, float, float]]:
        """Places and diameters of all symbols, pixels."""
        for axes in self.figure.axes:
            for line in axes.get_lines():
                if line.get_marker() not in (None, "None", "", " "):
                    for x, y in line.get_transform().transform(line.get_xydata()):
                        if math.isfinite(x) and math.isfinite(y) and axes.bbox.contains(x, y):
                            yield x, y, line.get_markersize() * self.figure.dpi / 72.0

    def _texts(self) -> list[Any]:
        """All but names of scales and axes."""
        legends = [*self.figure.legends, *filter(None, (axes.get_legend() for axes in self.figure.axes))]
        texts = [text for axes in self.figure.axes for text in [axes.title, *axes.texts]]
        texts += [text for legend in legends for text in legend.get_texts()] + self.figure.texts
        return [text for text in texts if text.get_visible() and text.get_text()]

    def _require_clear(self) -> None:
        """No symbol lies on another or on a text, no text on another or on a line, and all text is in the picture."""
        whole, symbols = self.figure.bbox.padded(1), list(self._marked())
        for (x, y, size), (x2, y2, size2) in itertools.combinations(symbols, 2):
            self.must(math.hypot(x - x2, y - y2) >= 0.4 * (size + size2), "no symbols on top of each other")
        for axes in self.figure.axes:
            for text in filter(lambda text: text.get_text(), axes.texts):
                box = text.get_window_extent()
                self.must(not any(box.padded(0.25 * size).contains(x, y) for x, y, size in symbols),
                          f"'{text.get_text()}' beside every symbol")
                self.must(not axes.axison or not _crossed(axes, box), f"'{text.get_text()}' beside every line")
        boxes = [(text.get_text(), text.get_window_extent()) for text in self._texts()]
        for text, box in boxes:
            self.must(whole.contains(*box.min) and whole.contains(*box.max), f"all of '{text}'")
        for (text, box), (text2, box2) in itertools.combinations(boxes, 2):
            over = min(box.x1, box2.x1) - max(box.x0, box2.x0), min(box.y1, box2.y1) - max(box.y0, box2.y0)
            self.must(min(over) <= 1, f"'{text}' beside '{text2}', not on it")


def thinned(axes: Any, x: Any, y: Any, apart: float, taken: list[tuple[float, float]]) -> list[int]:
    """Which points of a curve have room for a symbol: `apart` points or more from one another and from `taken`, which
    grows by theirs. Limits and scales of `axes` are set."""
    scale = 72.0 / axes.figure.dpi
    kept = []
    for k, (px, py) in enumerate(axes.transData.transform(list(zip(x, y))) * scale):
        if all(math.hypot(px - qx, py - qy) >= apart for qx, qy in taken):
            taken.append((px, py))
            kept.append(k)
    return kept


def _crossed(axes: Any, box: Any) -> bool:
    """Whether a drawn line goes through the box."""
    return any(line.get_path().transformed(line.get_transform()).intersects_bbox(box, filled=False)
               for line in axes.get_lines() if line.get_linestyle() != "None")


def name_points(axes: Any, points: list[tuple[str, float, float]], symbols: list[tuple[float, float]],
                **look: Any) -> None:
    """Writes names of points (name, x, y) right of them, left, above or below: where no line, no symbol and no other
    name is, and the frame is not crossed. A name without such a place is left out. symbols: places in points, as of
    `thinned`."""
    scale, renderer, boxes = axes.figure.dpi / 72.0, axes.figure.canvas.get_renderer(), []
    for name, x, y in points:
        for dx, dy in ((7, 0), (-7, 0), (0, 6), (0, -6), (6, 6), (-6, -6), (6, -6), (-6, 6)):
            text = axes.annotate(name, (x, y), xytext=(dx, dy), textcoords="offset points",
                                 ha=("center", "left", "right")[np.sign(dx)],
                                 va=("center", "bottom", "top")[np.sign(dy)], **look)
            box = text.get_window_extent(renderer)
            taken = any(box.padded(2.5 * scale).contains(px * scale, py * scale) for px, py in symbols)
            if (axes.bbox.contains(*box.min) and axes.bbox.contains(*box.max) and not taken and not _crossed(axes, box)
                    and not any(box.overlaps(other) for other in boxes)):
                boxes.append(box)
                break
            text.remove()


def key(label: str, **look: Any) -> Line2D:
    """An entry of a legend."""
    return Line2D([], [], label=label, **look)
