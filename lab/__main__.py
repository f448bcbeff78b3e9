# SPDX-License-Identifier: GPL-2.0-or-later
"""python3 -m lab COMMAND, from the project's root."""

from __future__ import annotations

import argparse
import importlib
import inspect
import os
import sys
import typing
from pathlib import Path

from lab import LabError

#: Commands that are not lab.COMMAND.make, by their module. A function's arguments are its command's: `build` is the
#: folder that all have, what has a default is an option, a list as often as there is any.
MODULES = {"take": "numbers", "check": "numbers",
           **dict.fromkeys(("speed", "beside", "devices", "inversion", "instructions"), "programs")}
COMMANDS = (*MODULES, "figures", "report", "large", "hard", "sizes", "target", "liver", "strokes", "realtime", "error",
            "contact")


def function_of(command: str) -> typing.Any:
    return getattr(importlib.import_module(f"lab.{MODULES.get(command, command)}"),
                   command if command in MODULES else "make")


def add_arguments(parser: argparse.ArgumentParser, function: typing.Any) -> None:
    """Of a function's signature."""
    types = typing.get_type_hints(function)
    for name, one in inspect.signature(function).parameters.items():
        kind = types[name]
        of = (typing.get_args(kind) or (kind,))[0]  # list[Path]: Path
        if name == "build":
            continue
        if one.default is inspect.Parameter.empty:
            many = {"nargs": "*"} if typing.get_origin(kind) is list else {}
            parser.add_argument(name, type=of, metavar=name.upper(), **many)
        elif kind is bool:
            parser.add_argument(f"--{name}", action="store_true")
        else:
            parser.add_argument(f"--{name}", type=of, default=one.default, metavar=name.upper(),
                                help=f"default: {one.default}")


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab", description="What compares, plots and writes the pages.",
                                     epilog=f"COMMAND is one of {', '.join(COMMANDS)}; COMMAND --help tells more.")
    parser.add_argument("--build", type=Path, default=Path(os.environ.get("BUILD", "build")), metavar="DIR",
                        help="where programs and scenes are made (default: $BUILD, else build)")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    sys.path.append(str((options.build / "lab/site").resolve()))  # scikit-fem: make lab
    function = function_of(options.command)
    of_command = argparse.ArgumentParser(prog=f"lab {options.command}", description=inspect.getdoc(function))
    add_arguments(of_command, function)
    given = vars(of_command.parse_args(options.arguments))
    if "build" in inspect.signature(function).parameters:
        given["build"] = options.build
    try:
        function(**given)
    except LabError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
