# SPDX-License-Identifier: GPL-2.0-or-later
"""What a pressure mask adds to a run of haptable-precompute, beside a dense product of as many operations: `make
bench-large PART=masks`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from lab import scenes
from lab.cholmod import one_thread
from lab.numbers import Topics, count, number, seconds
from lab.scenes import Scene
from lab.specimens import cube_scene

_RADIUS = 0.004  # m, on the cubes
COLUMNS = ["body, radius", "nodes", "places", "most nodes under one", "pairs", "operations", "masks", "planned",
           "blocks", "products", "files, C", "all", "dense product", "ratio"]


def dense_rate() -> float:
    """Operations a second of a large dense product, the fastest of three, one thread."""
    one_thread()
    n = 1000
    a, b, least_s = np.ones((n, n)), np.ones((n, n)), float("inf")
    for _ in range(3):
        begin = time.process_time()
        a @ b
        least_s = min(least_s, time.process_time() - begin)
    return 2.0 * n**3 / least_s


def row(name: str, scene: Scene, contact: dict[str, Any], folder: Path, build: Path, rate: float) -> list[Any]:
    """rate: of dense_rate(). The pairs are planned with the factor's pattern; files are written and checked, as numbers
    and as C."""
    ran = {how: scenes.precompute({**scene, "contact": c, "tables": {"columns": "none"}}, folder / how, build,
                                  "--threads", "1")
           for how, c in (("with", contact), ("without", {}))}
    cost, plain, mask = ran["with"]["cpu_s"], ran["without"]["cpu_s"], ran["with"]["contact"]["mask"]

    def more(*stages: str) -> float:
        return max(0.0, sum(cost[stage] - plain[stage] for stage in stages))
    parts = [cost["masks"], more("analysis"), cost["mask_blocks"], cost["mask_products"], more("write", "codegen")]
    flops = mask["flops"] + mask["product_flops"]
    dense_s = flops / rate
    return [name, f"{ran['with']['counts']['nodes']:,}", count(mask["places"]), count(mask["most_nodes"]),
            count(mask["pairs"]),
            number(flops, f"{flops:.2g}"), *map(seconds, parts), seconds(sum(parts)), seconds(dense_s),
            number(sum(parts) / dense_s, f"{sum(parts) / dense_s:.1f}")]


def costs(folder: Path, build: Path, sides: tuple[int, ...] = (12, 20, 28, 40)) -> Topics:
    """Cubes of so many nodes a side, and the mouse of meshes/mouse-mask.toml in two elements."""
    rate, rows = dense_rate(), []
    for side in sides:
        print(f"bench: masks: cube, {side} nodes a side", flush=True)
        rows.append(row(f"cube, {1e3 * _RADIUS:g} mm", cube_scene(side, 0.3, top=False),
                        {"force": "pressure-mask", "mask_radius": _RADIUS}, folder / "masks", build, rate))
    mouse = scenes.read(Path("meshes/mouse-mask.toml"))
    radius = mouse["contact"]["mask_radius"]
    for element in ("linear", "quadratic"):
        print(f"bench: masks: {mouse['name']}, {element}", flush=True)
        scene = {**mouse, "mesh": {**mouse["mesh"], "element": element}}
        rows.append(row(f"{mouse['name']}, {element}, {1e3 * radius:g} mm", scene,
                        {"force": "pressure-mask", "mask_radius": radius}, folder / "masks", build, rate))
    return {"mask-costs": {"columns": COLUMNS, "rows": rows}}
