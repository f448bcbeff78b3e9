# SPDX-License-Identifier: GPL-2.0-or-later
"""Bytes: of the servo on the microcontrollers (docs/MICROCONTROLLER.md), of a page (docs/TOUCH.md). `make bench` calls
this when images and pages' parts are made."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from lab import LabError, output_of, scenes
from lab.numbers import count, error_of, number, write_topics

TARGETS = ("cortex-m4", "cortex-m7", "cortex-m33", "rv32")


# ---- the servo -----------------------------------------------------------------------------------------------------

def _size_of(build: Path, scene: str, row: str) -> dict[str, Any]:
    """What `make firmware` prints of an image for a Cortex-M7."""
    file = build / scene / "firmware/cortex-m7/size.txt"
    for line in file.read_text(encoding="utf-8").splitlines():
        if row in line:
            return count(int(re.search(r"\d+", line)[0]))
    raise LabError(f"{file}: has no row '{row}'; make images makes it")


def sizes(build: Path) -> dict[str, Any]:
    return {"columns": ["-O2, Cortex-M7, bytes", "cube", "mouse"],
            "rows": [[what, *(_size_of(build, scene, row) for scene in ("cube", "mouse"))]
                     for what, row in (("code of the servo", "code of the servo"),
                                       ("state of the servo", "the servo's state"))]}


def stacks(build: Path) -> dict[str, Any]:
    """Stack of what a board calls, bytes: all in the paper's mode, a step in others. A mode's tables name the
    functions; the call graphs are those of the cube's images, which hold every function before the linker drops what
    no table names."""
    mask = {"force": "pressure-mask", "mask_radius": 0.012}
    modes = {"the paper's mode": {"force": "interpolated", "god_object": "nearest"},
             "mask, nearest": {**mask, "god_object": "nearest"},
             "interpolated, least energy": {"force": "interpolated", "god_object": "least-energy"},
             "consistent, least energy": {"force": "consistent", "god_object": "least-energy"},
             "mask, least energy": {**mask, "god_object": "least-energy"},
             "mask, least energy, friction": {**mask, "god_object": "least-energy", "friction": 0.5}}
    folder = build / "modes/stack"
    folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, list[Any]] = {}
    for what, contact in modes.items():
        scene = scenes.read(Path("meshes/cube.toml"))
        scene["contact"] = {**scene.get("contact", {}), **contact}
        scene["tables"] = {**scene.get("tables", {}), "columns": "none"}
        scenes.precompute(scene, folder / "tables", build)
        for target in TARGETS:
            cross = "riscv64-unknown-elf-" if target == "rv32" else "arm-none-eabi-"
            output_of(f"{cross}gcc", "-c", "-ffreestanding", "-Ifirmware", folder / "tables/model.c", "-o",
                      folder / "model.o")
            found = output_of("python3", "scripts/stack.py", build / "cube/firmware" / target, folder / "model.o",
                              CROSS=cross)
            for entry, stack in (line.split() for line in found.splitlines()):
                if int(stack) > 0 and (entry == "haptable_step" or what == "the paper's mode"):
                    rows.setdefault(f"{entry}, {what}", []).append(count(int(stack)))
    whole = [[what, *row] for what, row in rows.items() if len(row) == len(TARGETS)]
    return {"columns": ["stack, bytes", *TARGETS], "rows": whole}


# ---- a page --------------------------------------------------------------------------------------------------------

def page(build: Path, tables: Path) -> dict[str, Any]:
    """What the page of a folder of tables holds."""
    file = build / "report/page.html"
    file.parent.mkdir(parents=True, exist_ok=True)
    output_of(build / "bin/haptable-view", tables, "--page", file, "--quiet")
    text = file.read_text(encoding="utf-8")
    file.unlink()

    def in_base64(n: int) -> int:
        return 4 * ((n + 2) // 3)

    def after(what: str) -> str:
        found = re.search(what, text)
        if found is None:
            raise LabError(f"{file}: has no {what}; lab/sizes.py reads the page by it")
        return found[1]
    servo = in_base64((build / "lib/page/servo.wasm").stat().st_size)
    whole = len(text.encode())
    everything = in_base64(int(after(r'id="scene">\{"bytes":(\d+)')))
    columns = in_base64(int(after(r'"tables":\{"columns":\{"bytes":(\d+)')))
    error = float(after(r'"columns":\{"columns":[^}]*"error":([0-9.e-]+)'))
    modes = len(re.findall(r'"model \d+":', text))

    def megabytes(n: int) -> dict[str, Any]:
        return number(n, f"{n / 1e6:.2g} MB")
    return {"columns": ["", "of the mouse"],
            "rows": [["the page itself and three.js", megabytes(whole - servo - everything)],
                     ["the servo, all modes in one WebAssembly module", megabytes(servo)],
                     [f"tables of {modes} modes, and the surface", megabytes(everything - columns)],
                     ["columns", megabytes(columns)],
                     ["its worst column is off by, of its size", error_of(error)]]}


def make(build: Path, out: Path) -> None:
    """Bytes of the servo on the microcontrollers, and of a page."""
    write_topics(out, {"size": sizes(build), "stack": stacks(build), "page": page(build, build / "mouse")})
