# SPDX-License-Identifier: GPL-2.0-or-later
"""python3 -m lab COMMAND, from the project's root."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from lab import LabError


def _figures(o: argparse.Namespace) -> None:
    from lab import figures
    figures.make(o.names, o.build, o.pictures)


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


def _report(o: argparse.Namespace) -> None:
    from lab import report
    report.make(o.docs, o.build, o.out)


def _large(o: argparse.Namespace) -> None:
    from lab import large
    large.make(o.parts, o.build)


def _sizes(o: argparse.Namespace) -> None:
    from lab import sizes
    sizes.make(o.build, o.out)


def _liver(o: argparse.Namespace) -> None:
    from lab import liver
    liver.make(o.build, o.out)


def _error(o: argparse.Namespace) -> None:
    from lab import error
    error.make(o.build, o.numbers, o.out, o.quick)


def _contact(o: argparse.Namespace) -> None:
    from lab import contact
    contact.make(o.build, o.out, o.repetitions, o.loops)


def _target(o: argparse.Namespace) -> None:
    from lab import target
    target.make(o.build, o.out)


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab", description="What compares, plots and writes the pages.")
    parser.add_argument("--build", type=Path, default=Path(os.environ.get("BUILD", "build")), metavar="DIR",
                        help="where programs and scenes are made (default: $BUILD, else build)")
    commands = parser.add_subparsers(dest="command", required=True)

    figures = commands.add_parser("figures", help="remake pictures of README and docs: these, or all")
    figures.add_argument("names", nargs="*", metavar="NAME")
    figures.add_argument("--pictures", type=Path, default=Path("docs/pictures"), metavar="DIR", help="where they go")
    figures.set_defaults(run=_figures)

    take = commands.add_parser("take", help="topics of a folder's .json into numbers.json, and from there into pages")
    take.add_argument("folder", type=Path, metavar="DIR")
    check = commands.add_parser("check", help="tell what is wrong with the numbers of these pages")
    for command, run in ((take, _take), (check, _check)):
        command.add_argument("--numbers", type=Path, default=Path("docs/numbers.json"), metavar="FILE")
        command.add_argument("pages", nargs="*", type=Path, metavar="PAGE.md")
        command.set_defaults(run=run)

    report = commands.add_parser("report", help="build/report: index.html, configurations.html, CSV files, figures")
    report.add_argument("--docs", type=Path, default=Path("docs"), metavar="DIR", help="pages and numbers.json")
    report.add_argument("out", type=Path, metavar="OUT")
    report.set_defaults(run=_report)

    large = commands.add_parser("bench-large", help="what large bodies take: parts, one after the other")
    large.add_argument("parts", nargs="+", metavar="PART")
    large.set_defaults(run=_large)

    for command, run, what in (("sizes", _sizes, "bytes of the servo on the microcontrollers, and of a page"),
                               ("target", _target, "instructions of a tick on the microcontrollers, in every mode"),
                               ("liver", _liver, "what each part of meshes/liver-capsule.toml is worth")):
        measure = commands.add_parser(command, help=what)
        measure.add_argument("out", type=Path, metavar="OUT.json")
        measure.set_defaults(run=run)

    error = commands.add_parser("error", help="error against the body of every configuration, and what it costs")
    error.add_argument("--numbers", type=Path, default=Path("docs/numbers.json"), metavar="FILE", help="where the truth is")
    error.add_argument("--quick", action="store_true", help="coarse meshes only")
    error.add_argument("out", type=Path, metavar="OUT.json")
    error.set_defaults(run=_error)

    contact = commands.add_parser("contact", help="what the contact modes feel like and cost, and curves for plots")
    contact.add_argument("--repetitions", type=int, default=15, metavar="N", help="of each timing; the median counts")
    contact.add_argument("--loops", type=int, default=1000, metavar="N", help="random closed loops a body and mode")
    contact.add_argument("out", type=Path, metavar="OUT.json")
    contact.set_defaults(run=_contact)

    options = parser.parse_args()
    sys.path.append(str((options.build / "lab/site").resolve()))  # scikit-fem: make lab
    try:
        options.run(options)
    except LabError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
