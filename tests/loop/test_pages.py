# SPDX-License-Identifier: GPL-2.0-or-later
"""What pages tell their readers to run, as it stands there: docs/FIRST.md, docs/LOOP.md, README.md; and a liver by other
people from its mesh to its picture."""

import json
import shutil
import signal

import numpy as np
import pytest
from programs import BUILD, BUILT, ROOT, done, ends, forces, program, read_csv, read_log, wait_until


def code_of(page: str, language: str) -> str:
    """The first block of the page in that language."""
    return (ROOT / page).read_text().split(f"```{language}\n", 1)[1].split("```", 1)[0]


def test_a_liver_from_mesh_to_picture(shared, tmp_path):
    # 1. The scene: a liver of 19 cm, held on the side of its lowest y.
    (tmp_path / "liver.toml").write_text(
        f'name = "liver"\n[mesh]\nfile = "{shared}/meshes/liver_181.msh"\nscale = 0.03\n[material]\nyoung = 3000.0\n'
        "poisson = 0.45\n[[fixed]]\nbox = [-9, -9, -9, 9, 0.03, 9]\n")
    done([program("haptable-precompute"), "liver.toml", "-o", "liver", "--quiet"], tmp_path)
    # 2. The servo, pressed 10 mm into the place that lies highest.
    done(f"make -s {BUILD}/host/servo/none 2>/dev/null; CXX=g++ HAPTABLE= sh {ROOT}/scripts/none.sh", tmp_path)
