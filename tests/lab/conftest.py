# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests of lab/: sh scripts/setup.sh lab, then python3 -m pytest tests/lab."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import os

import pytest

BUILD = Path(os.environ.get("BUILD", "build")).resolve()
os.environ["BUILD"] = str(BUILD)
sys.path.append(str(BUILD / "lab/site"))  # scikit-fem: make lab


@pytest.fixture
def build():
    """Where make has left the programs."""
    if not (BUILD / "bin/haptable-precompute").exists():
        pytest.skip("no build/bin/haptable-precompute: run make")
    return BUILD


@pytest.fixture
def needed(build):
    """needed("haptable-count", ...): programs of build/bin and other files of the build. Without one the test skips."""
    def need(*names):
        for name in names:
            if not (build / ("bin" if "/" not in name else "") / name).exists():
                pytest.skip(f"no {name} in the build's folder: make test-lab")
    return need
