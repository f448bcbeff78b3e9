# SPDX-License-Identifier: GPL-2.0-or-later
"""The laboratory: what compares, plots and writes the pages. Not a part of the product.

Run from the project's root as ``python3 -m lab COMMAND``; ``python3 -m lab --help`` lists the commands. It needs the
packages of lab/requirements.txt, which ``sh scripts/setup.sh lab`` installs from Debian.
"""


class LabError(Exception):
    """What a person mends: names the file, the topic or the figure, and says what to do."""
