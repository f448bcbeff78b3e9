# SPDX-License-Identifier: GPL-2.0-or-later
"""The project's own Python package on this tree's library, for this Python and this process: others load it beside."""

import atexit
import functools
import importlib
import shutil
import sys
import tempfile
from pathlib import Path
from types import ModuleType

from lab import LabError, build

_LIBRARY = """# Made by lab/binding.py: libhaptable without a compiler.
import pathlib
import cffi
ffi = cffi.FFI()
ffi.cdef({declarations!r})
lib = ffi.dlopen(str(pathlib.Path(__file__).with_name("libhaptable.so.1")))
"""


@functools.cache
def load(folder: Path | None = None) -> ModuleType:
    """The module haptable, of the library that `make library` has left in this folder, or in the build's."""
    library = (folder or build()) / "lib/libhaptable.so.1"
    if not library.exists():
        raise LabError(f"{library}: is not there; run make library")
    home = tempfile.mkdtemp(prefix="haptable-lab-")
    atexit.register(shutil.rmtree, home, ignore_errors=True)
    package = Path(home) / "haptable"
    sys.path[:0] = [home, "python"]
    from build_library import HEADER, declarations
    shutil.copytree("python/haptable", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(library, package)
    declared = declarations(HEADER.read_text(encoding="utf-8"))
    (package / "_library.py").write_text(_LIBRARY.format(declarations=declared), encoding="utf-8")
    sys.path.remove("python")
    importlib.invalidate_caches()
    return importlib.import_module("haptable")
