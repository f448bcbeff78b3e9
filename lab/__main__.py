# SPDX-License-Identifier: GPL-2.0-or-later
"""python3 -m lab COMMAND, from the project's root."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path
from typing import Any

from lab import LabError


def _pages(files: list[Path]) -> dict[str, str]:
    return {str(file): file.read_text(encoding="utf-8") for file in files}


def _take(o: argparse.Namespace) -> None:
    from lab import numbers, points
    topics = numbers.read_numbers(o.numbers)
    before = numbers.to_text(topics)
    numbers.take_folder(o.folder, topics)
    points.derive(topics)
    filled = {path: numbers.fill(path, text, topics) for path, text in _pages(o.pages).items()}
    after = numbers.to_text(topics)
    if after != before:
        numbers.write_file(o.numbers, after)
    for file in o.pages:
        if filled[str(file)] != file.read_text(encoding="utf-8"):
            numbers.write_file(file, filled[str(file)])


def _check(o: argparse.Namespace) -> None:
    from lab import numbers
    faults = numbers.find_faults(_pages(o.pages), numbers.read_numbers(o.numbers))
    if faults:
        raise LabError("\n".join(faults))


#: Of measurements whose only argument is the file that they write.
_PLAIN = {"hard": "the hard cases, each against a dense reference in long double",
          "sizes": "bytes of the servo on the microcontrollers, and of a page",
          "target": "instructions of a tick on the microcontrollers, in every mode",
          "liver": "what each part of meshes/liver-capsule.toml is worth"}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="lab", description="What compares, plots and writes the pages.")
    parser.add_argument("--build", type=Path, default=Path(os.environ.get("BUILD", "build")), metavar="DIR",
                        help="where programs and scenes are made (default: $BUILD, else build)")
    commands = parser.add_subparsers(dest="command", required=True)

    def measure(command: str, what: str, *arguments: tuple[str, dict[str, Any]], module: str = "",
                function: str = "make") -> None:
        """A command that calls a function of its module with its arguments by their names, and the build folder."""
        it = commands.add_parser(command, help=what)
        for name, options in arguments:
            it.add_argument(name, **options)
        it.set_defaults(module=f"lab.{module or command}", function=function)

    def file(metavar: str, **more: Any) -> dict[str, Any]:
        return {"type": Path, "metavar": metavar, **more}
    out = ("out", file("OUT.json"))

    for command, run, what in (("take", _take,
                                "topics of a folder's .json into numbers.json, and from there into pages"),
                               ("check", _check, "tell what is wrong with the numbers of these pages")):
        pages = commands.add_parser(command, help=what)
        if run is _take:
            pages.add_argument("folder", **file("DIR"))
        pages.add_argument("--numbers", **file("FILE", default=Path("docs/numbers.json")))
        pages.add_argument("pages", nargs="*", **file("PAGE.md"))
        pages.set_defaults(run=run)

    measure("figures", "remake pictures of README and docs: these, or all",
            ("names", {"nargs": "*", "metavar": "NAME"}),
            ("--pictures", file("DIR", default=Path("docs/pictures"), help="where they go")))
    measure("report", "build/report: index.html, configurations.html, CSV files, figures",
            ("--docs", file("DIR", default=Path("docs"), help="pages and numbers.json")), ("out", file("OUT")))
    measure("bench-large", "what large bodies take: parts, one after the other",
            ("parts", {"nargs": "+", "metavar": "PART"}),
            module="large")
    for command, what in _PLAIN.items():
        measure(command, what, out)
    measure("strokes", "tables of what haptable-strokes counted", ("counts", file("COUNTS.json")), out)
    for command, what, more in (
            ("speed", "speed of tick and picture", [("--repetitions", {"type": int, "default": 9, "metavar": "N"})]),
            ("beside", "ticks of the contact modes beside peers",
             [("--rounds", {"type": int, "default": 30, "metavar": "N"})]),
            ("devices", "what the device models are, and from which stiffness each rings", []),
            ("inversion", "how the inversion grows, and its errors",
             [("--sides", {"default": "12,20,25,32,40", "metavar": "N,N", "help": "cubes of so many nodes a side"})])):
        measure(command, what, *more, out, module="programs", function=command)
    measure("instructions", "instructions of a tick on the emulated microcontrollers",
            ("folders", {"nargs": "+", "type": Path, "metavar": "DIR"}), ("-o", file("OUT.json", dest="out")),
            module="programs", function="instructions")
    measure("realtime", "the loop in real time beside one whose servo does nothing", ("scene", file("SCENE")),
            ("--seconds", {"type": float, "default": 60.0, "metavar": "S", "help": "of each of the four sessions"}),
            out)
    measure("error", "error against the body of every configuration, and what it costs",
            ("--numbers", file("FILE", default=Path("docs/numbers.json"), help="where the truth is")),
            ("--quick", {"action": "store_true", "help": "coarse meshes only"}), out)
    measure("contact", "what the contact modes feel like and cost, and curves for plots",
            ("--repetitions",
             {"type": int, "default": 15, "metavar": "N", "help": "of each timing; the median counts"}),
            ("--loops", {"type": int, "default": 1000, "metavar": "N", "help": "random closed loops a body and mode"}),
            out)
    return parser


def main() -> int:
    options = vars(_parser().parse_args())
    sys.path.append(str((options["build"] / "lab/site").resolve()))  # scikit-fem: make lab
    _, module, function, run = (options.pop(name, None) for name in ("command", "module", "function", "run"))
    try:
        if run:
            run(argparse.Namespace(**options))
        else:
            getattr(importlib.import_module(module), function)(**options)
    except LabError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
