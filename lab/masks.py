# SPDX-License-Identifier: GPL-2.0-or-later
"""What a pressure mask adds to a run of haptable-precompute, beside a dense product of as many operations: `make
bench-large PART=masks`."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from lab import say, scenes
from lab.cholmod import one_thread
from lab.numbers import Topics, count, number, seconds, table
from lab.scenes import Scene, touched, vary
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


def row(name: str, scene: Scene, radius: float, folder: Path, rate: float) -> list[Any]:
    """rate: of dense_rate(). The pairs are planned with the factor's pattern; files are written and checked, as numbers
    and as C."""
    masked = scenes.precompute(touched(scene, "pressure-mask", radius), folder / "with", "--threads", "1")
    plain = scenes.precompute({**scene, "contact": {}}, folder / "without", "--threads", "1")["cpu_s"]
    cost, mask = masked["cpu_s"], masked["contact"]["mask"]

    def more(*stages: str) -> float:
        return max(0.0, sum(cost[stage] - plain[stage] for stage in stages))
    parts = [cost["masks"], more("analysis"), cost["mask_blocks"], cost["mask_products"], more("write", "codegen")]
    flops = mask["flops"] + mask["product_flops"]
    dense_s = flops / rate
    return [f"{name}, {1e3 * radius:g} mm", f"{masked['counts']['nodes']:,}",
            *(count(mask[key]) for key in ("places", "most_nodes", "pairs")), number(flops, "{:.2g}"),
            *map(seconds, (*parts, sum(parts), dense_s)), number(sum(parts) / dense_s, "{:.1f}")]


def costs(folder: Path, sides: tuple[int, ...] = (12, 20, 28, 40)) -> Topics:
    """Cubes of so many nodes a side, and the mouse of meshes/mouse-mask.toml in two elements."""
    mouse = scenes.read("mouse-mask")
    radius = mouse["contact"]["mask_radius"]
    bodies = [("cube", cube_scene(side, 0.3, top=False), _RADIUS) for side in sides]
    bodies += [(f"{mouse['name']}, {element}", vary(mouse, mesh={"element": element}), radius)
               for element in ("linear", "quadratic")]
    rate, rows = dense_rate(), []
    for name, scene, radius in bodies:
        say("masks:", name, scene["mesh"].get("nodes_per_side", ""))
        rows.append(row(name, scene, radius, folder / "masks", rate))
    return {"mask-costs": table(COLUMNS, rows)}
