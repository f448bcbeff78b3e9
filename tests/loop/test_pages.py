# SPDX-License-Identifier: GPL-2.0-or-later
"""What pages tell their readers to run, as it stands there: docs/FIRST.md, docs/LOOP.md, README.md; a liver by other
people from its mesh to its picture; and what programs refuse."""

import contextlib
import json
import shutil
import signal
from collections import Counter

import numpy as np
import pytest
from programs import (BUILD, BUILT, ROOT, done, ends, forces, one_make, program, read_csv, read_log, run, servo_of,
                      wait_until)


def code_of(page: str, language: str) -> str:
    """The first block of the page in that language."""
    return (ROOT / page).read_text().split(f"```{language}\n", 1)[1].split("```", 1)[0]


def test_a_liver_from_mesh_to_picture(shared, tmp_path):
    # 1. The scene: a liver of 19 cm, held on the side of its lowest y.
    scene = tmp_path / "liver.toml"
    scene.write_text(
        f'name = "test-liver"\n[mesh]\nfile = "{shared}/meshes/liver_181.msh"\nscale = 0.03\n[material]\nyoung = 3000.0\n'
        "poisson = 0.45\n[[fixed]]\nbox = [-9, -9, -9, 9, 0.03, 9]\n")
    servo = servo_of(scene, "test-liver")
    # 2. The servo, pressed 10 mm into the node that lies highest.
    position = np.load(servo.parent / "position.npy")
    x, y, z = position[np.argmax(position[:, 1])]
    (tmp_path / "path.csv").write_text(
        "x,y,z\n" + "".join(f"{x},{y + 0.005 - 0.00015 * tick},{z}\n" for tick in range(101)))
    done([servo, "--quiet", "--replay", "path.csv", "--out", "felt.csv"], tmp_path)
    rows = read_csv(tmp_path / "felt.csv")
    assert rows["contact"].sum() > 50
    assert np.linalg.norm(forces(rows), axis=1).max() > 0.01
    # 3. The picture: the body, its colours by displacement.
    done([program("haptable-view"), servo.parent, "--csv", "felt.csv", "--ticks", "100", "-o", "liver.png", "--quiet"],
         tmp_path)
    assert (tmp_path / "liver.png").stat().st_size > 20_000, "a picture of one colour takes a few hundred bytes"
    shutil.rmtree(servo.parent)


def test_the_lines_of_first_md_touch_the_liver(need, lcm_url):
    """As a reader copies them, with this build's folder for `build`."""
    need("bin/haptable-device")
    commands = code_of("docs/FIRST.md", "sh").splitlines()
    assert len(commands) == 6
    made = BUILT / "liver-capsule"
    for old in ("sag.png", "touched.gif", "touch.html"):
        (made / old).unlink(missing_ok=True)
    shutil.rmtree(made / "session", ignore_errors=True)
    said = ""
    for command in commands:
        here = command.replace("build/", f"{BUILD}/")
        makes = here.startswith("make ")
        with one_make() if makes else contextlib.nullcontext():
            said += done(here + (f" BUILD={BUILD}" if makes else ""))
    assert "force_size_n       0.65" in said
    for file in ("sag.png", "touched.gif", "session/report.html", "touch.html"):
        assert (made / file).stat().st_size > 20_000, file
    session = json.loads((made / "session/summary.json").read_text())
    assert session["ticks"] == 6000 and session["contact_ticks"] > 2000
    assert len(json.loads((made / "summary.json").read_text())["relaxation"]) == 2
    assert (made / "sag.npy").exists()


@pytest.fixture
def cube_servo(need, lcm_url) -> str:
    return str(need("cube/servo", "python/ready"))


def python_of(page: str, folder) -> list:
    """The command that runs a page's program, with PyPI's lcm."""
    (folder / "program.py").write_text(code_of(page, "python"))
    return ["env", f"PYTHONPATH={BUILT}/python/types", BUILT / "python/bin/python", "-u", folder / "program.py"]


def test_the_device_of_loop_md_feels_the_servo(cube_servo, tmp_path, start):
    servo = start([cube_servo, "--lcm", "--quiet", "--no-realtime", "--csv", tmp_path / "servo.csv"])
    said = done(python_of("docs/LOOP.md", tmp_path), patience_s=120)
    assert ends(servo, by=signal.SIGTERM) == 0
    rows, felt = read_csv(tmp_path / "servo.csv"), np.array([line.split()[:3] for line in said.splitlines()], float)
    assert len(rows) == len(felt) == 1000
    np.testing.assert_array_equal(felt.astype(np.float32), forces(rows))
    assert felt.max() > 0.1


DEVICE = f"{program('haptable-device')} meshes/cube.toml --quiet --no-realtime"


def test_the_listener_of_the_readme_hears_a_session(cube_servo, tmp_path, start):
    """Without being told where it is: every line is a tick of the servo's record."""
    heard = tmp_path / "heard"
    listener = start(python_of("README.md", tmp_path), out=heard, err=tmp_path / "complaints")
    servo = start([cube_servo, "--lcm", "--quiet", "--no-realtime", "--csv", tmp_path / "servo.csv"])

    def enough() -> bool:  # Python takes a moment to listen, and may come in at a session's end
        done(DEVICE + " --lockstep --seconds 0.3")
        return heard.read_text().count("\n") > 10

    assert wait_until(enough), (tmp_path / "complaints").read_text()
    ends(listener, by=signal.SIGKILL)
    assert ends(servo, by=signal.SIGTERM) == 0
    z = read_csv(tmp_path / "servo.csv")["z"].astype(np.float32)
    for line in heard.read_text().splitlines()[:-1]:  # the last one may be half
        seq, finger_z = line.split()[:2]
        assert np.float32(finger_z) == z[int(seq)], line


def test_lcm_logger_hears_a_session_of_the_default_url(cube_servo, tmp_path, monkeypatch):
    """A user's lcm-logger, which knows nothing of haptable, records a session that was told no URL either."""
    monkeypatch.delenv("LCM_DEFAULT_URL")
    log = tmp_path / "session.lcmlog"
    (tmp_path / "session.sh").write_text(
        f"lcm-logger -q -f {log} & logger=$!\n{cube_servo} --lcm --quiet --no-realtime & servo=$!\n"
        f"for try in $(seq 50); do\n{DEVICE} --seconds 0.3 || exit 1\n[ -s {log} ] && break; done\n"  # until it listens
        "kill $logger $servo; wait $logger; wait $servo\n")
    done(f"sh scripts/loopback.sh sh {tmp_path}/session.sh")
    heard = Counter(event.channel for event in read_log(log))  # on a busy machine not all
    for channel in ("HAPTABLE_STATE", "HAPTABLE_FORCE", "HAPTABLE_CONTACT"):
        assert heard[channel] > 0, channel


def test_a_fit_that_holds_the_body_still_refuses_one_that_moves(need, tmp_path):
    """One line that names the folder and the key, instead of another body's forces."""
    need("bin/haptable-fit")
    (tmp_path / "loose.toml").write_text('name = "loose"\n[mesh]\ngenerate = "cube"\nnodes_per_side = 3\n[material]\n'
                                         "young = 1e4\npoisson = 0.3\n[body]\nfree = true\ndensity = 1000\n")
    done([program("haptable-precompute"), "--quiet", "loose.toml"], tmp_path)
    (tmp_path / "press.csv").write_text("time_s,depth_m,force_n\n0,0.001,0.1\n1,0.001,0.1\n")
    outcome = run([program("haptable-fit"), "press.csv", "loose.toml"], tmp_path)
    assert outcome.status == 1 and outcome.err.count("\n") == 1
    assert "build/loose: " in outcome.err and "remove free = true from [body]" in outcome.err


def test_a_poke_leads_to_a_finger_with_a_size(need):
    """The paper's point is not what most people want to feel."""
    advice, poke = 'contact = { force = "pressure-mask", mask_radius = 0.005', [need("cube/servo"), "--poke", "top"]
    assert advice in done(poke)
    assert advice not in done([*poke, "--json"])
