# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests of lab/: sh scripts/setup.sh lab, then python3 -m pytest tests/lab."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import os

import pytest

BUILD = Path(os.environ.get("BUILD", "build")).resolve()
sys.path.append(str(BUILD / "lab/site"))  # scikit-fem: make lab


@pytest.fixture
def build():
    """Where make has left the programs."""
    if not (BUILD / "bin/haptable-precompute").exists():
        pytest.skip("no build/bin/haptable-precompute: run make")
    return BUILD
