# SPDX-License-Identifier: GPL-2.0-or-later
"""A session as one HTML page with plots, which needs nothing else."""
from __future__ import annotations

import html
import os
from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

_WIDTH, _HEIGHT, _MARGIN, _MOST_POINTS = 760, 180, 50, 2000


def _thin(x: NDArray[Any], y: NDArray[Any]) -> Tuple[NDArray[Any], NDArray[Any]]:
    """At most so many points: of each stretch the least and the greatest, so that no peak is lost."""
    stretch = -(-len(y) // (_MOST_POINTS // 2))
    if stretch <= 2:
        return x, y
    begins = np.arange(0, len(y), stretch)
    parts = [slice(b, min(b + stretch, len(y))) for b in begins]
    at = np.array(sorted({b.start + int(pick(y[b])) for b in parts for pick in (np.argmin, np.argmax)}))
    return x[at], y[at]


def _ticks(low: float, high: float, most: int) -> NDArray[Any]:
    """Round values in [low, high], at most so many and two more: of steps of 1, 2 or 5 times a power of ten.

    >>> _ticks(0.0, 0.323, 5).round(6).tolist()
    [0.0, 0.1, 0.2, 0.3]
    """
    least = (high - low) / most
    power = 10.0 ** np.floor(np.log10(least))
    step = power * next(m for m in (1, 2, 5, 10) if m * power >= 0.999 * least)
    ticks: NDArray[Any] = step * np.arange(np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6) + 1) + 0.0  # no -0
    return ticks


def plot(title: str, unit: str, time: NDArray[Any], value: NDArray[Any]) -> str:
    """One curve against time, as SVG. time: [n] s, ascending; value: [n] in `unit`, finite or left out.

    >>> plot("force", "N", np.array([0.0, 1.0]), np.array([0.0, 2.0])).startswith("<svg")
    True
    """
    known = np.isfinite(value)
    time, value = _thin(np.asarray(time, float)[known], np.asarray(value, float)[known])
    if len(value) == 0:
        return f"<p>{html.escape(title)}: no values</p>"
    low, high = min(0.0, value.min()), max(0.0, value.max())
    high = high if high > low else low + 1.0
    end = max(time[-1], time[0] + 1e-9)
    right, bottom = _WIDTH - 20, _HEIGHT - 25

    def across(t: NDArray[Any]) -> Any:
        return _MARGIN + (t - time[0]) / (end - time[0]) * (right - _MARGIN)

    def down(v: NDArray[Any]) -> Any:
        return 20 + (high - v) / (high - low) * (bottom - 20)
    parts = [f'<text x="{_MARGIN}" y="12">{html.escape(title)}, {html.escape(unit)}</text>']
    for v in _ticks(low, high, 5):
        y = down(v)
        parts.append(f'<line x1="{_MARGIN}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}"/>'
                     f'<text x="{_MARGIN - 6}" y="{y + 4:.1f}" text-anchor="end">{v:.4g}</text>')
    for t in _ticks(time[0], end, 8):
        x = across(t)
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="20" y2="{bottom}"/>'
                     f'<text x="{x:.1f}" y="{_HEIGHT - 8}" text-anchor="middle">{t:.4g} s</text>')
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across(time), down(value)))
    parts.append(f'<polyline points="{points}"/>')
    return f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{html.escape(title)}">{"".join(parts)}</svg>'


def report(file: Union[str, "os.PathLike[str]"], positions: NDArray[Any], contacts: NDArray[Any],
           latency_us: Optional[NDArray[Any]] = None, title: str = "haptable", tick: float = 1e-3) -> None:
    """Writes a page: force, depth, stored energy and, where it is given, latency against time.

    positions: [n, 3] m; contacts: [n] of dtype haptable.CONTACT, as Servo.replay gives them; latency_us: [n]; tick: s.
    The page is written beside `file` and then renamed. Raises ValueError for lengths that differ."""
    n = len(contacts)
    u = np.asarray(positions, float) - contacts["god_object"]
    if u.shape != (n, 3) or (latency_us is not None and len(latency_us) != n):
        raise ValueError(f"positions: [{n}, 3] in m, latency_us: [{n}]")
    touches = np.isin(contacts["state"], (2, 4))
    force = np.linalg.norm(contacts["force"].astype(float), axis=1)
    load = contacts["nodal_forces"].astype(float).sum(axis=1)
    stored = np.where(touches, 0.5 * np.einsum("ij,ij->i", np.where(touches[:, None], u, 0.0), load), 0.0)
    depth = np.where(touches, np.linalg.norm(np.where(touches[:, None], u, 0.0), axis=1), 0.0)
    curves: Sequence[Tuple[str, str, NDArray[Any]]] = [("force", "N", force), ("depth", "mm", 1e3 * depth),
                                                  ("stored energy", "mJ", 1e3 * stored)]
    if latency_us is not None:
        curves = [*curves, ("latency", "us", np.asarray(latency_us, float))]
    time = tick * np.arange(n)
    body = "".join(plot(name, unit, time, values) for name, unit, values in curves)
    name = html.escape(title)
    page = (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{name}</title><style>'
            "body{font:14px sans-serif;max-width:800px;margin:2em auto}svg{width:100%;margin:.5em 0}"
            "polyline{fill:none;stroke:#1a6faf;stroke-width:1.2}line{stroke:#ddd}text{font-size:11px;fill:#444}</style>"
            f"<h1>{name}</h1><p>{n:,} ticks, {int(touches.sum()):,} with contact; largest force "
            f"{force.max() if n else 0.0:.4g} N.</p>{body}</html>\n")
    beside = os.fspath(file) + f".partial-{os.getpid()}"
    with open(beside, "w", encoding="utf-8") as out:
        out.write(page)
    os.replace(beside, file)
