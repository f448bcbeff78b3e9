# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests of lab/: sh scripts/setup.sh lab, then python3 -m pytest tests/lab."""

import os
import sys
from pathlib import Path

import pytest
from programs import BUILT

os.environ["BUILD"] = str(BUILT)
sys.path.append(str(BUILT / "lab/site"))  # scikit-fem: make lab


@pytest.fixture
def build(need) -> Path:
    """Where make has left the programs."""
    return need("bin/haptable-precompute").parents[1]
