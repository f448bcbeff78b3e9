# SPDX-License-Identifier: GPL-2.0-or-later
"""The product's displacements of all nodes against CalculiX, another program, on the same elements."""

import shutil

import numpy as np
import pytest

from lab import scenes
from lab.calculix import Deck, displacements
from lab.figure import ROOT
from lab.known import against_calculix
from lab.specimens import cube_scene

#: Each component that CalculiX prints is off by 5e-7 of itself at most, and columns.npy is float32.
PRINTED = 1e-6

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="no ccx: sh scripts/setup.sh lab")


def quadratic(scene, poisson):
    return {**scene, "mesh": {**scene["mesh"], "element": "quadratic"},
            "material": {**scene["material"], "poisson": poisson}}


CUBE = cube_scene(5, 0.49, top=False)
MOUSE = {key: scenes.read(ROOT / "meshes/mouse.toml")[key] for key in ("name", "mesh", "material", "fixed")}


@pytest.mark.parametrize("scene", [CUBE, quadratic(CUBE, 0.0), quadratic(CUBE, 0.16), quadratic(MOUSE, 0.16)],
                         ids=["linear", "quadratic of 0", "quadratic of a sixth", "quadratic mouse"])
def test_tetrahedra_that_do_not_average_are_calculixs(tmp_path, build, scene):
    assert against_calculix(scene, tmp_path / "t") < PRINTED


def test_quadratic_tetrahedra_that_average_above_a_sixth_are_softer(tmp_path, build):
    assert against_calculix(quadratic(CUBE, 0.49), tmp_path / "t") > 100 * PRINTED


# ---- fibres, skin, bed and weight in one body ----------------------------------------------------------------------

FIBRES = {"law": "fibre", "young_along": 6e4, "young_across": 8e3, "poisson": 0.35, "poisson_across": 0.45,
          "shear": 5e3, "direction": [0.48, 0.6, 0.64]}


def whole_scene():
    """A cube held at its bottom, with fibres in half of it, a skin on its top, a bed at one side, and its weight."""
    return {**cube_scene(5, 0.4, top=False),
            "region": [{"box": [-1.0, -1.0, -1.0, 1.0, 0.015, 1.0], **FIBRES, "density": 1300.0}],
            "membrane": [{"box": [-1.0, -1.0, 0.0299, 1.0, 1.0, 1.0], "thickness": 1e-4, "young": 3e6, "poisson": 0.3}],
            "bed": [{"box": [-1.0, -1.0, -1.0, 1e-9, 1.0, 1.0], "normal": 2e6, "tangential": 7e5}],
            "gravity": {"density": 1100.0}}


def solids(mesh):
    """The tetrahedra by their regions, in mm, N and tonnes."""
    inside = (mesh.x[mesh.tets, 1] <= 0.015).all(1)
    sets = "".join(f"*ELSET, ELSET=R{r}\n" + "".join(f"{t + 1},\n" for t in np.flatnonzero(inside == bool(r)))
                   for r in (0, 1))
    e, across, nu, nu_across, g = (FIBRES[k]
                                   for k in ("young_along", "young_across", "poisson", "poisson_across", "shear"))
    values = [1e-6 * e, 1e-6 * across, 1e-6 * across, nu, nu, nu_across, 1e-6 * g, 1e-6 * g]
    along = FIBRES["direction"]
    return (sets + "*MATERIAL, NAME=FIBRES\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
            + ",".join(f"{v:.13g}" for v in values)
            + f",\n{1e-6 * across / (2 * (1 + nu_across)):.13g}\n*DENSITY\n1.3e-9\n"
            + f"*ORIENTATION, NAME=ALONG\n{along[0]},{along[1]},{along[2]},0.8,-0.64,0.\n"
            + "*SOLID SECTION, ELSET=R1, MATERIAL=FIBRES, ORIENTATION=ALONG\n"
            + "*MATERIAL, NAME=BODY\n*ELASTIC\n0.01,0.4\n*DENSITY\n1.1e-9\n*SOLID SECTION, ELSET=R0, MATERIAL=BODY\n")


def skin(mesh):
    top = mesh.surface[(mesh.x[mesh.surface, 2] > 0.0299).all(1)] + 1
    elements = "".join(f"{50000 + i},{a},{b},{c}\n" for i, (a, b, c) in enumerate(top.tolist()))
    return (f"*ELEMENT, TYPE=M3D3, ELSET=SKIN\n{elements}*MATERIAL, NAME=SKIN\n*ELASTIC\n3.,0.3\n"
            "*MEMBRANE SECTION, ELSET=SKIN, MATERIAL=SKIN\n0.1\n")


def bed(mesh):
    """A spring for every pair of nodes and direction. int N_a N_b dA is A / 12 of two corners, A / 6 of one with
    itself; the bed's faces are normal to x."""
    side = mesh.surface[(mesh.x[mesh.surface, 0] < 1e-9).all(1)]
    corner = 1e3 * mesh.x[side]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    coupled = np.zeros((len(mesh.x), len(mesh.x)))
    for face, a in zip(side, area):
        coupled[np.ix_(face, face)] += a / 12 * (np.ones((3, 3)) + np.eye(3))
    text, number = "", 100000
    for axis, stiffness in enumerate((2e6, 7e5, 7e5)):
        for a, b in np.argwhere(np.triu(coupled)):
            k = 1e-9 * stiffness * (coupled[a].sum() if a == b else -coupled[a, b])
            ends = f"{a + 1}" if a == b else f"{a + 1},{b + 1}"
            axes = f"{axis + 1}" if a == b else f"{axis + 1},{axis + 1}"
            text += (f"*ELEMENT, TYPE=SPRING{1 if a == b else 2}, ELSET=S{number}\n{number},{ends}\n"
                     f"*SPRING, ELSET=S{number}\n{axes}\n{k:.13g}\n")
            number += 1
    return text


def test_fibres_skin_bed_and_weight_in_one_body(tmp_path, build):
    weight = "*DLOAD\nR0,GRAV,9810.,0.,0.,-1.\nR1,GRAV,9810.,0.,0.,-1.\n"
    assert against_calculix(whole_scene(), tmp_path / "t",
                             lambda mesh: (solids(mesh) + skin(mesh) + bed(mesh), weight)) < PRINTED


def test_a_deck_that_ccx_cannot_solve_is_an_error(tmp_path):
    from lab import LabError
    deck = Deck(np.zeros((4, 3)), np.array([[0, 1, 2, 3]]), np.array([0]), 1e4, 0.3)
    with pytest.raises(LabError, match="0 of 1 results; see .*job.log"):
        displacements(deck, [np.ones((4, 3))], tmp_path)
    assert (tmp_path / "job.inp").read_text().startswith("*NODE")


def test_curved_tetrahedra_as_their_file_has_them(tmp_path, build):
    file = ROOT.parent / "shared/meshes/sphere_p2_1310.msh"
    if not file.exists():
        pytest.skip("no ../shared/meshes")
    scene = {"name": "ball", "mesh": {"file": str(file), "element": "quadratic"},
             "material": {"young": 1e4, "poisson": 0.16}, "fixed": [{"box": [-1e3, -1e3, -1e3, 1e3, 1e3, -0.4]}]}
    assert against_calculix(scene, tmp_path / "t") < PRINTED
