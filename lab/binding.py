# SPDX-License-Identifier: GPL-2.0-or-later
"""The project's own Python package on this tree's library, without a compiler, for this Python and this process."""

import functools
import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import cffi

from lab import LabError, build


@functools.cache
def load(folder: Path | None = None) -> ModuleType:
    """The module haptable, of the library that `make library` has left in this folder, or in the build's."""
    file = (folder or build()) / "lib/libhaptable.so.1"
    if not file.exists():
        raise LabError(f"{file}: is not there; run make library")
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
    from build_library import HEADER, declarations
    library: Any = ModuleType("haptable._library")
    library.ffi = cffi.FFI()
    library.ffi.cdef(declarations(HEADER.read_text(encoding="utf-8")))
    library.lib = library.ffi.dlopen(str(file.resolve()))
    sys.modules["haptable._library"] = library
    return importlib.import_module("haptable")
