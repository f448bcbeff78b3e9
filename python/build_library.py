# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable._library: libhaptable for Python. The declarations are those of its header."""
import os
import pathlib
import re

import cffi

ROOT = pathlib.Path(__file__).parent.parent.resolve()
HEADER = ROOT / "host" / "library" / "haptable_library.h"
PARTS = ROOT / os.environ.get("BUILD", "build") / "package" / "python"


def declarations(text: str) -> str:
    """What cffi reads of the header: without comments, the preprocessor, C++ and attributes."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r'extern "C" \{|^\}$', "", text, flags=re.M)
    return re.sub(r"^#.*$|HAPTABLE_LIBRARY_API ", "", text, flags=re.M)


ffi = cffi.FFI()
ffi.cdef(declarations(HEADER.read_text()))
ffi.set_source(
    "haptable._library",
    '#include "haptable_library.h"',
    include_dirs=[str(HEADER.parent)],
    library_dirs=[str(PARTS)],
    libraries=["haptable"],
    extra_link_args=["-Wl,-rpath,$ORIGIN"],
)
