# SPDX-License-Identifier: GPL-2.0-or-later
"""python3 -m lab COMMAND, from the project's root."""

import argparse
import importlib
import inspect
import sys
import typing

from lab import LabError, build

#: Commands that are not lab.COMMAND.make, by their module. A function's arguments are its command's: what has a default
#: is an option, a list as often as there is any.
MODULES = {"take": "numbers", "check": "numbers",
           **dict.fromkeys(("speed", "beside", "devices", "inversion", "instructions"), "programs")}
COMMANDS = (*MODULES, "figures", "report", "large", "hard", "sizes", "target", "liver", "strokes", "realtime", "error",
            "contact")


def add_arguments(parser: argparse.ArgumentParser, function: typing.Any) -> None:
    """Of a function's signature."""
    types = typing.get_type_hints(function)
    for name, one in inspect.signature(function).parameters.items():
        kind = types[name]
        of = (typing.get_args(kind) or (kind,))[0]  # list[Path]: Path
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
                                     epilog=f"COMMAND is one of {', '.join(COMMANDS)}; COMMAND --help tells more. "
                                            "$BUILD, or build, is where programs and scenes are made.")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    sys.path.append(str((build() / "lab/site").resolve()))  # scikit-fem: make lab
    module = importlib.import_module(f"lab.{MODULES.get(options.command, options.command)}")
    function = getattr(module, options.command if options.command in MODULES else "make")
    of_command = argparse.ArgumentParser(prog=f"lab {options.command}", description=inspect.getdoc(function))
    add_arguments(of_command, function)
    try:
        function(**vars(of_command.parse_args(options.arguments)))
    except LabError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
