# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with a key changed; what each part of the liver is worth."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from lab import LabError, binding, liver, scenes
from lab.figure import ROOT


@pytest.mark.parametrize("file", sorted((ROOT / "meshes").rglob("*.toml")), ids=lambda file: file.stem)
def test_a_scene_is_read_without_columns_and_with_its_mesh(file):
    scene = scenes.read(file)
    assert tomllib.loads(tomli_w.dumps(scene)) == scene
    assert scene["tables"]["columns"] == "none", "nobody draws what is measured"
    if "file" in scene["mesh"]:
        assert Path(scene["mesh"]["file"]).is_absolute() and Path(scene["mesh"]["file"]).exists()


def test_each_part_is_added_to_those_before_it():
    meshes = ROOT / "meshes"
    whole = scenes.read(meshes / "liver-capsule.toml")
    made = [(name, set(scene) - {"name", "mesh", "material", "touch", "contact", "tables", "device"},
             scene.get("gravity", {}).get("prestress"))
            for name, scene in liver.parts(whole, scenes.read(meshes / "liver.toml"))]
    assert [(keys, prestress) for _, keys, prestress in made] == [
        ({"fixed"}, None), ({"fixed", "membrane"}, None), ({"bed", "membrane"}, None),
        ({"bed", "membrane", "gravity"}, False), ({"bed", "membrane", "gravity"}, True),
        ({"bed", "membrane", "gravity", "relaxation"}, True)]
    assert "bed" in whole and "fixed" not in whole, "the scene that was given stays"


class Spring:
    """A body whose top at z = 0 gives 100 N/m, where it is there."""

    def __init__(self, is_there: bool = True) -> None:
        self.name, self.rest, self.patches = "spring", np.array([[0, 0, -0.02], [1, 0, 0],
                                                                 [0, 1, 0]]), np.array([[0, 1, 2]])
        self.ticks, self.is_there = np.zeros(0), is_there

    def servo(self):
        return self

    def replay(self, path):
        z = np.asarray(path)[:, 2]
        self.ticks, touches = z, self.is_there & (z < 0)
        felt = np.zeros(len(z), [("state", int), ("god_object", float, 3), ("force", np.float32, 3)])
        felt["state"], felt["force"][:, 2] = np.where(touches, 2, 1), np.where(touches, -100 * z, 0)
        return felt


def test_a_press_goes_down_at_20_mm_a_second_and_rests():
    body = Spring()
    assert liver.press(body) == pytest.approx(0.5, rel=1e-6)
    ticks = body.ticks
    assert ticks[0] == pytest.approx(0.001) and np.diff(ticks).min() >= -2.001e-5
    assert (ticks[-100:] == ticks[-1]).all() and ticks[-1] == pytest.approx(-0.005)
    with pytest.raises(LabError, match="spring: the bench's finger met no surface"):
        liver.press(Spring(is_there=False))


def test_the_binding_feels_a_scene(tmp_path, need):
    need("lib/libhaptable.so.1")
    scenes.precompute(scenes.touched(scenes.read("cube"), "pressure-mask", 0.012), tmp_path / "tables")
    felt = binding.load().load(tmp_path / "tables").poke((0.015, 0.015, 0.03), [1e-3, 2e-3])["force"][:, 2]
    assert felt[1] == pytest.approx(2 * felt[0], rel=1e-5) and felt[0] > 0.01, "a linear body"


def test_without_a_library_the_binding_says_what_to_make(tmp_path):
    with pytest.raises(LabError, match="libhaptable.so.1: is not there; run make library"):
        binding.load(tmp_path)
