# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests of lab/: sh scripts/setup.sh lab, then python3 -m pytest tests/lab."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
