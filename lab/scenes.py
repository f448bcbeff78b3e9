# SPDX-License-Identifier: GPL-2.0-or-later
"""Scene files as dictionaries, for measurements that change a key or two."""

from __future__ import annotations

import json
import subprocess
import tomllib
from pathlib import Path
from typing import Any

from lab import LabError
from lab.numbers import write_file

Scene = dict[str, Any]


def read(file: Path) -> Scene:
    """Its mesh file's path as it leads from anywhere."""
    scene = tomllib.loads(file.read_text(encoding="utf-8"))
    if "file" in scene["mesh"]:
        scene["mesh"]["file"] = str((file.parent / scene["mesh"]["file"]).resolve())
    return scene


def to_toml(scene: Scene) -> str:
    """Keys of one level of tables, or of lists of tables, and what stands in braces: all that a scene has."""
    def inline(value: Any) -> str:
        if isinstance(value, dict):
            return "{ " + ", ".join(f"{key} = {inline(entry)}" for key, entry in value.items()) + " }"
        return json.dumps(value)

    def line(key: str, value: Any) -> str:
        return f"{key} = {inline(value)}\n"
    text = "".join(line(key, value) for key, value in scene.items() if not isinstance(value, (dict, list)))
    for key, value in scene.items():
        for table in value if isinstance(value, list) else [value] if isinstance(value, dict) else []:
            head = f"[[{key}]]\n" if isinstance(value, list) else f"[{key}]\n"
            text += "\n" + head + "".join(line(*item) for item in table.items())
    return text


def precompute(scene: Scene, folder: Path, build: Path, *options: str) -> dict[str, Any]:
    """Tables of the scene in `folder`, made anew; its summary. The scene's file stands beside it. Raises LabError with
    what the program says."""
    file = folder.with_suffix(".toml")
    write_file(file, to_toml(scene))
    ended = subprocess.run([str(build / "bin/haptable-precompute"), str(file), "-o", str(folder), "--force", "--quiet",
                            *options], stderr=subprocess.PIPE, text=True, check=False)
    if ended.returncode != 0:
        raise LabError(f"{ended.stderr.strip()} (haptable-precompute ended with status {ended.returncode})")
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return summary
