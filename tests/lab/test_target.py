# SPDX-License-Identifier: GPL-2.0-or-later
"""Instructions of ticks on microcontrollers, as tables."""

import shutil

import pytest

from lab import LabError, scenes, target, told
from lab.figure import ROOT
from lab.target import Ticks, in_time, parts_in_time


def counted(*ticks):
    """Of (instructions, state): what haptable-count tells."""
    return {"instructions": [n for n, _ in ticks], "states": [[state] for _, state in ticks]}


def test_ticks_slide_with_contact_before_and_after():
    ticks = Ticks(counted((9, 1), (50, 2), (60, 2), (70, 4), (80, 1), (90, 3)))
    assert ticks.sliding == [60, 70] and ticks.all == [50, 60, 70, 80], "what is rejected does not count"
    assert (ticks.median, ticks.most, ticks.worst) == (60, 70, 80)
    assert Ticks(counted((9, 2), (5, 2), (9, 3)), skip_rejected=False).all == [5, 9]
    with pytest.raises(LabError, match="touched nothing"):
        Ticks(counted((9, 1), (9, 1)))
    with pytest.raises(LabError, match="mode: a tick is above its bound"):
        ticks.require_below(79, "mode")
    ticks.require_below(80, "mode")


def test_parts_are_told_by_their_bound_or_by_what_was_counted():
    assert parts_in_time(100, 10) == "M33 150 MHz, M4F 168 MHz, rv32 400 MHz, M7 600 MHz"
    assert parts_in_time(400_000, 140_000) == "M7 600 MHz; counted: M4F 168 MHz, rv32 400 MHz"
    assert parts_in_time(10**9, 10**9) == "none"
    ticks = Ticks(counted(*[(10, 2)] * 2000, (100, 2)))
    assert [in_time(most, ticks, 1000) for most in (1000, 100, 99, 9)] == ["bound", "counted", "99.9 %", "no"]


def test_every_variant_is_a_scene_that_the_product_reads(tmp_path, build):
    plain = tmp_path / "plain"
    scenes.precompute(target.plain_scene("cube"), plain)
    for what, change in {**target.variants(0.012, plain), **target.OF_ANY_MESH}.items():
        assert change or what.startswith("the paper's force"), what
        scenes.precompute(scenes.vary(target.plain_scene("cube"), **change), tmp_path / "t")


@pytest.fixture
def counting(need) -> None:
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("no emulator: sh scripts/setup.sh test")
    need("bin/haptable-count", "cube/firmware/cortex-m7/measure.elf")


def test_the_images_tell_every_tick(counting, build):
    one, two = (target.count_ticks(build / "cube", "--target", "cortex-m7", "--strokes", "5", *more)
                for more in ((), ("--every-mode",)))
    assert len(one) == 1 and len(one[0]["instructions"]) == len(one[0]["states"]) == 100
    assert [mode["mode"] for mode in two] == [*(f"interpolated {g}{m}" for m in ("", " friction", " passivity")
                                                for g in ("nearest", "least-energy")),
                                              "interpolated nearest stiffening"]
    assert one[0]["instructions"] == two[0]["instructions"], "counts are the same each time"
    assert max(two[1]["instructions"]) <= two[1]["bound"] and two[1]["bound"] > two[0]["bound"]


def test_what_is_no_path_is_an_error(need, build, capfd):
    need("bin/haptable-count")
    with pytest.raises(LabError, match="ended with status"):
        target.count_ticks(build / "cube", path="round")
    assert "round: is no path: hard, strokes, tip" in capfd.readouterr().err


def test_scenes_of_bodies_are_there():
    assert all((ROOT / f"meshes/{file}.toml").exists() for file, _ in target.BODIES.values())


def test_a_tool_is_counted_in_the_modes_that_it_has(counting, tmp_path, capfd):
    scene = scenes.vary(target.plain_scene("cube"), **target.OF_ANY_MESH["`[tool]`, four points, consistent"])
    scenes.precompute(scene, tmp_path / "t")
    modes = target.count_ticks(tmp_path / "t", "--target", "cortex-m7", "--strokes", "10", "--every-mode",
                               path="strokes")
    assert [mode["mode"] for mode in modes] == [
        f"consistent {god_object}{more}" for more in ("", " friction") for god_object in ("nearest", "least-energy")]
    for mode in modes:
        assert any(state == [2] for state in mode["states"]), mode["mode"]
        assert max(mode["instructions"]) < mode["bound"]
    with pytest.raises(LabError):
        told("haptable-count", tmp_path / "t")
    assert "its scene has a tool, or three fingers and more: give --path" in capfd.readouterr().err
