# SPDX-License-Identifier: GPL-2.0-or-later
"""Every element from its scene over a session to its picture, by the programs and the package that a user runs."""

import json
import re
import shutil
import signal

import numpy as np
import pytest
from programs import BUILT, done, ends, finger_path, forces, haptable_package, program, read_csv, run, servo_of

# The paper's cube, or one with as many nodes.
SCENE = """name = "test-{element}"
[mesh]
element = "{element}"
generate = "cube"
nodes_per_side = {side}
[material]
young = 1e4
poisson = 0.49
[[fixed]]
box = [-1, -1, -1, 1, 1, 1e-9]
[contact]
"""
MASK = 'force = "pressure-mask"\nmask_radius = 0.006\n'


def write_scene(folder, element: str, contact: str):
    scene = folder / "scene.toml"
    scene.write_text(SCENE.format(element=element, side=4 if element == "quadratic" else 7) + contact)
    return scene


@pytest.fixture(scope="module", params=["linear", "average-nodal-pressure", "quadratic"])
def made(request, tmp_path_factory):
    """A scene's file and its servo, of one element, under a mask with least energy."""
    element, folder = request.param, tmp_path_factory.mktemp(request.param)
    scene = write_scene(folder, element, MASK + 'god_object = "least-energy"\n')
    yield scene, servo_of(scene, f"test-{element}")
    shutil.rmtree(folder)
    shutil.rmtree(BUILT / f"test-{element}", ignore_errors=True)


def test_a_session_with_least_energy_from_first_touch_to_the_picture(made, tmp_path, lcm_url):
    scene, servo = made
    felt, out = tmp_path / "out/servo.csv", tmp_path / "out"
    # 1. Servo and device in lockstep.
    summary = json.loads(done([program("haptable-run"), scene, "-o", out, "--no-realtime", "--lockstep", "--path",
                               "poke,drag,circle", "--draw", "nothing", "--json"]))
    assert (summary["trouble"], summary["unanswered"]) == ("none", 0)
    assert summary["contact_ticks"] > 800
    # 2. What the finger gave on its way in and got on its way out: a passive body keeps some or none.
    rows = read_csv(felt)
    assert rows["contact"][0] == rows["contact"][-1] == 0
    force = np.stack([rows[f"force_{axis}"] for axis in "xyz"], axis=1)
    place = np.stack([rows[axis] for axis in "xyz"], axis=1)
    given = np.cumsum(-0.5 * ((force[1:] + force[:-1]) * np.diff(place, axis=0)).sum(axis=1))
    assert np.linalg.norm(force, axis=1).max() > 0.1
    assert given[-1] > -1e-3 * max(given.max(), 0)
    # 3. The picture and the meshes for ParaView.
    view = f"{program('haptable-view')} {servo.parent} --csv {felt} --ticks {np.argmax(rows['force_z'])} --quiet"
    done(f"{view} -o {tmp_path}/cube.png")
    assert (tmp_path / "cube.png").stat().st_size > 20_000
    done(f"{view} --vtu -o {tmp_path}/vtu")
    numbers = re.search(r'Name="displacement_m"[^>]*>([^<]*)<', (tmp_path / "vtu/frame_000000.vtu").read_text())[1]
    assert np.abs(np.array(numbers.split(), float)).max() > 0.001


def test_servo_device_and_viewer_as_processes_over_udp(made, tmp_path, lcm_url, start):
    """The session goes on until the viewer has its pictures."""
    scene, servo = made
    serving = start([servo, "--lcm", "--no-realtime", "--quiet", "--csv", tmp_path / "servo.csv"])
    device = start([program("haptable-device"), scene, "--tables", servo.parent, "--lockstep", "--path", "poke,drag",
                    "--seconds", "86400", "--no-realtime", "--quiet", "--csv", tmp_path / "device.csv"])
    viewer = run([program("haptable-view"), servo.parent, "--lcm", "--frames", "40", "--seconds", "60", "--size", "320x240",
                  "--json", "--quiet", "-o", tmp_path / "out"])
    assert ends(device, by=signal.SIGTERM) == ends(serving, by=signal.SIGTERM) == 0
    # 1. What was seen is the session's: none of its messages left out, a body that was pressed.
    assert viewer.status == 0, viewer.err
    seen = json.loads(viewer.out)
    assert (seen["frames"], seen["left_out_messages"]) == (40, 0)
    assert (tmp_path / "out/frame_000039.png").exists()
    rows, felt = read_csv(tmp_path / "servo.csv"), read_csv(tmp_path / "device.csv")
    largest_n = np.linalg.norm(forces(rows).astype(float), axis=1).max()
    assert 0.02 < seen["largest_force_n"] <= largest_n * (1 + 4 * 2.0**-24)
    assert seen["largest_displacement_mm"] > 0.2
    # 2. What the device got is what the servo gave, but for the tick that its end cut short.
    assert len(felt) > 1000 and len(rows) + 1 >= len(felt)
    np.testing.assert_array_equal(forces(rows)[:len(felt) - 1], forces(felt)[:-1])
    # 3. And what the same path gives without any session.
    finger_path(tmp_path / "servo.csv", tmp_path / "path.csv")
    done([servo, "--quiet", "--replay", tmp_path / "path.csv", "--out", tmp_path / "replay.csv"])
    assert (tmp_path / "replay.csv").read_bytes() == (tmp_path / "servo.csv").read_bytes()


@pytest.mark.parametrize("element", ["linear", "average-nodal-pressure", "quadratic"])
def test_the_drawn_surface_meets_the_finger(element, need, tmp_path):
    """With the consistent force the surface as it is drawn, flat between its nodes, meets the finger."""
    need("lib/libhaptable.so.1")
    scene = write_scene(tmp_path, element, 'force = "consistent"\n')
    done([program("haptable-precompute"), scene, "-o", tmp_path / "tables", "--quiet"])
    body = haptable_package().load(tmp_path / "tables")
    servo, checked = body.servo(), 0
    row_of = {int(node): row for row, node in enumerate(body.row_nodes)}
    for tick in range(400):
        x = np.float32([0.009 + 3e-5 * tick, 0.011 + 1e-5 * tick, 0.0305 if tick == 0 else 0.029])
        touch = servo.step(x)
        if not touch or tick % 20 != 19:
            continue
        displaced = body.deform(touch)[[row_of[int(node)] for node in touch.nodes]]
        wanted = x.astype(float) - touch.god_object
        # 64 roundings to float, which the blocks magnify by 10.
        assert np.linalg.norm(touch.alpha @ displaced - wanted) < 64 * 2.0**-24 * 10 * np.linalg.norm(wanted)
        checked += 1
    assert checked > 10
