# SPDX-License-Identifier: GPL-2.0-or-later
"""Bytes: of the servo on the microcontrollers (docs/MICROCONTROLLER.md), of a page (docs/TOUCH.md). `make bench` calls
this when images and pages' parts are made."""

import re
from pathlib import Path
from typing import Any

from lab import LabError, build, output_of, scenes
from lab.numbers import Topic, count, error_of, number, table, write_topics
from lab.scenes import touched
from lab.target import TARGETS, stacks_of


# ---- the servo -----------------------------------------------------------------------------------------------------

def _size_of(scene: str, row: str) -> Topic:
    """What `make firmware` prints of an image for a Cortex-M7."""
    file = build() / scene / "firmware/cortex-m7/size.txt"
    for line in file.read_text(encoding="utf-8").splitlines():
        if row in line:
            return count(int(re.search(r"\d+", line)[0]))
    raise LabError(f"{file}: has no row '{row}'; make images makes it")


def sizes() -> Topic:
    return table("-O2, Cortex-M7, bytes | cube | mouse", [
        [what, *(_size_of(scene, row) for scene in ("cube", "mouse"))]
        for what, row in (("code of the servo", "code of the servo"), ("state of the servo", "the servo's state"))])


def stacks() -> Topic:
    """Stack of what a board calls, bytes: all in the paper's mode, a step in others."""
    folder = build() / "modes/stack/tables"
    rows: dict[str, list[Any]] = {}
    for what, force, god_object, friction in (
            ("the paper's mode", "interpolated", "nearest", 0.0),
            ("mask, nearest", "pressure-mask", "nearest", 0.0),
            ("interpolated, least energy", "interpolated", "least-energy", 0.0),
            ("consistent, least energy", "consistent", "least-energy", 0.0),
            ("mask, least energy", "pressure-mask", "least-energy", 0.0),
            ("mask, least energy, friction", "pressure-mask", "least-energy", 0.5)):
        scene = touched(scenes.read("cube"), force, 0.012, god_object=god_object, friction=friction)
        scenes.precompute(scene, folder)
        for target in TARGETS:
            for entry, stack in stacks_of(folder, target).items():
                if stack > 0 and (entry == "haptable_step" or what == "the paper's mode"):
                    rows.setdefault(f"{entry}, {what}", []).append(count(stack))
    return table(["stack, bytes", *TARGETS], [[what, *row] for what, row in rows.items() if len(row) == len(TARGETS)])


# ---- a page --------------------------------------------------------------------------------------------------------

def page(tables: Path) -> Topic:
    """What the page of a folder of tables holds."""
    file = build() / "report/page.html"
    file.parent.mkdir(parents=True, exist_ok=True)
    output_of(build() / "bin/haptable-view", tables, "--page", file, "--quiet")
    text = file.read_text(encoding="utf-8")
    file.unlink()

    def in_base64(n: int) -> int:
        return 4 * ((n + 2) // 3)

    def after(what: str) -> str:
        found = re.search(what, text)
        if found is None:
            raise LabError(f"{file}: has no {what}; lab/sizes.py reads the page by it")
        return found[1]
    servo = in_base64((build() / "lib/page/servo.wasm").stat().st_size)
    everything = in_base64(int(after(r'id="scene">\{"bytes":(\d+)')))
    columns = in_base64(int(after(r'"tables":\{"columns":\{"bytes":(\d+)')))
    modes = len(re.findall(r'"model \d+":', text))
    bytes_of = {"the page itself and three.js": len(text.encode()) - servo - everything,
                "the servo, all modes in one WebAssembly module": servo,
                f"tables of {modes} modes, and the surface": everything - columns,
                "columns": columns}
    error = float(after(r'"columns":\{"columns":[^}]*"error":([0-9.e-]+)'))
    return table(" | of the mouse", [*([what, number(n, "{:.2g} MB", 1e-6)] for what, n in bytes_of.items()),
                                     ["its worst column is off by, of its size", error_of(error)]])


def make(out: Path) -> None:
    """Bytes of the servo on the microcontrollers, and of a page."""
    write_topics(out, {"size": sizes(), "stack": stacks(), "page": page(build() / "mouse")})
