# SPDX-License-Identifier: GPL-2.0-or-later
"""The laboratory: what compares, plots and writes the pages. Not a part of the product.

Run from the project's root as ``python3 -m lab COMMAND``; ``python3 -m lab --help`` lists the commands. It needs the
packages of lab/requirements.txt, which ``sh scripts/setup.sh lab`` installs from Debian.
"""

import json
import os
import subprocess
from pathlib import Path
from typing import Any


class LabError(Exception):
    """What a person mends: names the file, the topic or the figure, and says what to do."""


def build() -> Path:
    """Where programs and scenes are made: $BUILD, as make has it."""
    return Path(os.environ.get("BUILD", "build"))


def output_of(*command: object, **environment: str) -> str:
    """What a command prints; what it says beside, on standard error, is passed on. Raises LabError where it fails."""
    ended = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True, check=False,
                           env={**os.environ, **environment})
    if ended.returncode != 0:
        raise LabError(f"{command[0]}: ended with status {ended.returncode}")
    return ended.stdout


def told(program: str, *options: object) -> Any:
    """The JSON that a program of build/bin prints."""
    return json.loads(output_of(build() / "bin" / program, *options))


def say(*what: object) -> None:
    """What a bench does now."""
    print("bench:", *what, flush=True)


def own(folder: Path, holds: str) -> None:
    """Makes the folder with its mark .haptable. Raises LabError where it holds files without that mark. The programs
    have the same rule (host/base/own_folder.hpp)."""
    mark, text = folder / ".haptable", f"haptable {holds}\n"
    if mark.is_file() and not mark.is_symlink() and mark.read_text(encoding="utf-8").startswith(text):
        return
    if mark.exists() or mark.is_symlink() or (folder.exists() and any(folder.iterdir())):
        raise LabError(f"{folder}: holds files that are not haptable's {holds} (by its .haptable): move them away, "
                       "or give another BUILD")
    folder.mkdir(parents=True, exist_ok=True)
    mark.write_text(f"{text}.\n", encoding="utf-8")
