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


def _plots(o: argparse.Namespace) -> None:
    from lab import numbers, plots
    plots.measured(numbers.read_numbers(o.numbers), o.build / "contact", o.out)


def main() -> int:
    parser = argparse.ArgumentParser(prog="lab", description="What compares, plots and writes the pages.")
    parser.add_argument("--build", type=Path, default=Path(os.environ.get("BUILD", "build")), metavar="DIR",
                        help="where programs and scenes are made (default: $BUILD, else build)")
    commands = parser.add_subparsers(dest="command", required=True)

    figures = commands.add_parser("figures", help="remake pictures of README and docs: these, or all")
    figures.add_argument("names", nargs="*", metavar="NAME")
    figures.add_argument("--pictures", type=Path, default=Path("docs/pictures"), metavar="DIR", help="where they go")
    figures.set_defaults(run=_figures)

    plots = commands.add_parser("plots", help="plots of what was measured, as SVG and PDF")
    plots.add_argument("numbers", type=Path, metavar="NUMBERS.json")
    plots.add_argument("out", type=Path, metavar="DIR")
    plots.set_defaults(run=_plots)

    options = parser.parse_args()
    try:
        options.run(options)
    except LabError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
