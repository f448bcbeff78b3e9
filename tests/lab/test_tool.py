# SPDX-License-Identifier: GPL-2.0-or-later
"""Rigid tools pressed into a cube: a sampled sphere beside CalculiX's contact on the same tetrahedra, kept in
sphere.csv, and beside Hertz; a sampled flat punch and its tilt beside closed forms."""

import shutil

import numpy as np
import pytest
from scipy.spatial import Delaunay

from lab import binding, scenes
from lab.calculix import Deck, pressing
from lab.figure import ROOT
from lab.reference import Bricks, Footprint, graded, uniform
from lab.specimens import cube_scene, read_elements

KEPT = np.genfromtxt(ROOT / "tests/lab/sphere.csv", delimiter=",", names=True)
RADIUS, SIDE = 0.01, 0.03
YOUNG, POISSON = 1e4, 0.3  # of cube_scene
MODULUS = YOUNG / (1.0 - POISSON**2)
GAP = 1e-5  # that the sphere stands above the cube before it is pressed: CalculiX begins without contact


def loaded(folder, nodes_per_side, mask_radius, **tool):
    """The body of a cube that is held below, touched from above by this tool about its handle."""
    cube = scenes.touched(cube_scene(nodes_per_side, POISSON), "pressure-mask", mask_radius)
    scenes.precompute(scenes.vary(cube, name=f"tool-{nodes_per_side}", tool=tool,
                                  device={"max_force": 100.0, "mean_force": "off"}), folder)
    return binding.load().load(folder)


def above_the_middle(z):
    """Places of a handle, and that it is not turned."""
    return np.column_stack([np.full((len(z), 2), 0.5 * SIDE), z]), np.tile([1.0, 0.0, 0.0, 0.0], (len(z), 1))


# ---- a sphere ------------------------------------------------------------------------------------------------------

@pytest.fixture
def sphere(tmp_path, build):
    """19 points, 2.6 mm apart, under masks of 0.8 of that; the body, and the folder of its tables."""
    folder = tmp_path / "sphere"
    return loaded(folder, 19, 0.0021, shape="sphere", radius=RADIUS, points=19, angle=35.0), folder


def test_the_kept_forces_are_hertz_to_the_mesh():
    """19 nodes a side: edges of 1.7 mm under a contact of 2.2 to 5.5 mm, on a cube that is held 30 mm below."""
    hertz = 4.0 / 3.0 * MODULUS * np.sqrt(RADIUS) * KEPT["depth_m"]**1.5
    assert np.abs(KEPT["force_n"] / hertz - 1.0).max() < 0.1


def test_a_sampled_sphere_feels_what_calculix_finds(sphere):
    """Pressed by 20 um a tick from above, and at rest for 60 ticks at each depth. From 1 mm on seven points and more
    touch; at 0.5 mm three do, which a contact of 2.2 mm does not know."""
    depth, rest = [-1e-3], []
    for until in KEPT["depth_m"].tolist():
        steps = int(np.ceil((until - depth[-1]) / 2e-5))
        depth += np.linspace(depth[-1], until, steps + 1)[1:].tolist() + 60 * [until]
        rest.append(len(depth) - 1)
    felt = sphere[0].tool().replay(*above_the_middle(SIDE + RADIUS - np.array(depth)))
    off = np.abs(felt["force"][rest, 2] / KEPT["force_n"] - 1.0)
    assert off[1:].max() < 0.05 and off[0] < 0.15


def cap(angle, rings, around):
    """Of the sphere about the origin, what lies within an angle of -z, rad: points, and triangles counter-clockwise
    from outside."""
    ring, step = np.mgrid[1:rings + 1, 0:around]
    polar, azimuth = (angle / rings * ring).ravel(), (2.0 * np.pi / around * step).ravel()
    flat = np.vstack([[0.0, 0.0], np.column_stack([polar * np.cos(azimuth), polar * np.sin(azimuth)])])
    polar = np.append(0.0, polar)
    aside = flat * np.sinc(polar / np.pi)[:, None]
    return RADIUS * np.column_stack([aside, -np.cos(polar)]), Delaunay(flat).simplices[:, ::-1]  # from below


@pytest.mark.skipif(shutil.which("ccx") is None, reason="no ccx: sh scripts/setup.sh lab")
def test_calculix_gives_the_kept_forces_at_two_depths(sphere):
    x, elements = read_elements(sphere[1] / "mesh.vtu")
    deck = Deck(x, elements, np.flatnonzero(x[:, 2] < 1e-9), YOUNG, POISSON)
    points, triangles = cap(np.radians(60.0), 14, 32)
    points += [0.5 * SIDE, 0.5 * SIDE, SIDE + RADIUS + GAP]
    moves, top = np.outer(KEPT["depth_m"][:2] + GAP, [0.0, 0.0, -1.0]), np.flatnonzero(x[:, 2] > SIDE - 1e-9)
    force = pressing(deck, points, triangles, top, moves, sphere[1].with_suffix(".ccx"))[:, 2]
    assert np.abs(force / KEPT["force_n"][:2] - 1.0).max() < 1e-3


# ---- a flat punch --------------------------------------------------------------------------------------------------

def stiffening(radius):
    """Of the cube beside a half-space, under a punch: what its size changes of the displacement under an even pressure
    on the same disc, it changes under the punch, whose load is the same from afar."""
    width, height = 0.5 * SIDE / radius, SIDE / radius
    across, down = graded(0.0, width, 0.0, 1.5, 3, 3), graded(0.0, height, height - 1.5, height, 3, 3)
    body = Bricks([across, across, down], 1.0, POISSON, quarter=True)
    disc = Footprint(np.array([0.0, 0.0, height]), 1.0, uniform)
    compliance = float(np.ravel(body.compliances([body.shares(disc)]))[-1]) / (1.0 - POISSON**2)
    return 0.5 / (0.5 + compliance - 16.0 / (3.0 * np.pi**2))


def test_a_sampled_punch_and_its_tilt(tmp_path, build):
    """12 points under a mask of 2.3 mm, 0.7 of the spacing, edges of 1.25 mm; the cube is 3.5 % stiffer than a
    half-space: force over 2 a E* d, and the torque of a tilt about x and about y over 4/3 a^3 E* theta."""
    radius, points = 0.006, 12
    mask = 0.7 * float(np.sqrt(2.0 * np.pi / np.sqrt(3.0) / points)) * radius
    tool = loaded(tmp_path / "punch", 25, mask, shape="disc", radius=radius, points=points).tool()
    deep, tilt = 0.15 * radius, 0.05
    depth = np.append(np.linspace(-5e-4, deep, int((deep + 5e-4) / 2e-5)), np.full(60, deep))
    flat = tool.replay(*above_the_middle(SIDE - depth))[-1]
    assert flat["force"][2] / (2.0 * radius * MODULUS * deep) / stiffening(radius) == pytest.approx(1.0, abs=0.05)
    half, rest = 0.5 * np.linspace(0.0, tilt, 200), above_the_middle(np.full(200, SIDE - deep))[0]
    for axis in (0, 1):
        turn = np.column_stack([np.cos(half), np.zeros((200, 3))])
        turn[:, 1 + axis] = np.sin(half)
        torque = flat["torque"][axis] - tool.replay(rest, turn)["torque"][-1, axis]
        assert torque / (4.0 / 3.0 * radius**3 * MODULUS * tilt) == pytest.approx(1.0, abs=0.05)
        tool.replay(rest, turn[::-1])
