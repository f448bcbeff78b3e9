#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""rooms.py BUILD FILE...: writes translation units BUILD/tidy/UnifiedSource-*.cpp that include many .cpp files each, so
that clang-tidy reads and matches their headers once a room and not once a file, and prints their names.

Files of a room (host/view, host/bench, codegen, ...) stand in one unit, but for those whose names meet: a name of an
unnamed namespace, of a macro or of a static function that another file has too, or that a header declares which the other
file includes. These stand in units of several rooms. A unit that is as it was keeps its time."""

import functools
import re
import subprocess
import sys
from pathlib import Path

# Clang's analyzer follows the paths of what a unit includes only where the unit has this name.
PREFIX = "UnifiedSource-"
# Rooms whose files stand in no other unit: the compiler's options are others, or the headers take a minute.
ALONE = ("host/inverse/mpi", "host/precompute/mpi", "host/library/examples", "host/mesh/cgal", "host/mesh/gmsh")

build = Path(sys.argv[1])
files = sorted(sys.argv[2:])


@functools.cache
def included(file: str) -> frozenset:
    """Paths of our headers that FILE includes, and of those that they include."""
    found = set()
    for name in re.findall(r'^ *# *include "([^"]+)"', Path(file).read_text(), re.M):
        places = (folder / name for folder in (Path(file).parent, Path(), build, build / "lcm"))
        header = next((str(place) for place in places if place.exists()), None)
        if header:
            found |= {header} | included(header)
    return frozenset(found)


def names_of(paths: list) -> tuple:
    """By path: the names that no other file of its unit may have, and all names outside of classes and functions."""
    own, every = {path: set() for path in paths}, {path: set() for path in paths}
    ctags = ["ctags", "--languages=C++", "--langmap=C++:.cpp.hpp.h", "--c++-kinds=cdefgstuvp", "--fields=sZ", "--sort=no"]
    tags = subprocess.run([*ctags, "-f", "-", *paths], check=True, capture_output=True, text=True).stdout
    for tag in tags.splitlines():
        name, path = tag.split("\t")[:2]
        scope = re.search(r"\tscope:(\w+):(.*)$", tag)
        if not scope or scope[1] in ("namespace", "enum"):
            every[path].add(name)
            # main is another name in each (below), and what another program calls by its name is there once.
            if name != "main" and not name.startswith("haptable_") and (not scope or re.search(r"__anon\w*$", scope[2])):
                own[path].add(name)
    return own, every


own, _ = names_of(files)
_, declared = names_of(sorted(set().union(*map(included, files))))
seen = {file: set().union(*(declared[header] for header in included(file))) for file in files}


def meet(a: str, b: str) -> bool:
    """Whether the names of files A and B meet."""
    return bool(own[a] & own[b] or own[a] & seen[b] or own[b] & seen[a])


def room_of(file: str) -> str:
    text = Path(file).read_text()
    if "<CGAL/" in text:
        return "host/mesh/cgal"
    if "<asm/" in text:  # the kernel's headers and libc's each define a struct termios
        return file.removesuffix(".cpp")
    alone = next((room for room in ALONE if file.startswith(room + "/")), None)
    return alone or re.match(r"host/[^/]*|[^/]*", file)[0]


# What meets least first: the largest set of files then stands in the room's unit.
units = {}
for file in sorted(files, key=lambda file: sum(meet(file, other) for other in files)):
    room = room_of(file)
    more = room if room in ALONE else "rooms"
    number = 1
    while any(meet(file, other) for other in units.setdefault(room if number == 1 else f"{more}-{number}", [])):
        number += 1
    units[room if number == 1 else f"{more}-{number}"].append(file)

folder = build / "tidy"
folder.mkdir(parents=True, exist_ok=True)
paths = {folder / f"{PREFIX}{unit.replace('/', '-')}.cpp": members for unit, members in units.items()}
for stale in set(folder.glob(f"{PREFIX}*.cpp")) - set(paths):
    stale.unlink()
for path, members in sorted(paths.items()):
    lines = [f'#define main main_{i}\n#include "{file}"\n#undef main\n' for i, file in enumerate(members)]
    text = "".join(["// NOLINTBEGIN(bugprone-suspicious-include)\n", *lines, "// NOLINTEND(bugprone-suspicious-include)\n"])
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    print(path)
