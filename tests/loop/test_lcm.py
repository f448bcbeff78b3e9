# SPDX-License-Identifier: GPL-2.0-or-later
"""The closed loop over real LCM: the servo of the paper's cube and the simulated device, as users start them."""

import contextlib
import signal
import time

import numpy as np
import pytest
from programs import BUILT, Listener, done, ends, finger_path, forces, program, read_csv

# Pokes for a minute: after a stall, which drops the contact, the next poke makes a new one.
POKES = ["--path", "poke", "--hold", "0.3", "--seconds", "60"]
PRESSED_N = 0.1


class Loop:
    def __init__(self, folder, start, url) -> None:
        self.folder, self._start, self.url = folder, start, url

    def servo(self, record: str = "servo.csv"):
        return self._start([BUILT / "cube/servo", "--lcm", "--quiet", "--no-realtime", "--csv", self.folder / record])

    def device(self, words: list, record: str = "device.csv"):
        return self._start([program("haptable-device"), "meshes/cube.toml", "--quiet", "--no-realtime", "--csv",
                            self.folder / record, *words])

    def in_lockstep(self, tag: str) -> None:
        """A session, recorded by both sides."""
        servo = self.servo(f"servo_{tag}.csv")
        assert ends(self.device(["--lockstep", "--path", "poke,drag"], f"device_{tag}.csv")) == 0
        assert ends(servo, by=signal.SIGTERM) == 0

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def csv(self, name: str):
        return read_csv(self.folder / name)


@pytest.fixture
def loop(tmp_path, start, need, lcm_url):
    need("cube/servo", "bin/haptable-device")
    return Loop(tmp_path, start, lcm_url)


@pytest.fixture
def answers(loop):
    with contextlib.closing(Listener(loop.url)) as listener:
        yield listener.heard("HAPTABLE_FORCE")


def wait_until_pressed(answers) -> None:
    """The servo has answered with a force for some time."""
    pressed = 0
    while pressed <= 50:
        pressed += abs(next(answers).force_n[2]) > PRESSED_N


def test_answers_every_tick_in_order_and_the_same_again(loop):
    """A poke and a drag: every tick answered in order, no message lost, contact reached and left. A second session, and
    the finger's path without any loop, give the same bytes."""
    for tag in "ab":
        loop.in_lockstep(tag)
    rows, felt = loop.csv("servo_a.csv"), loop.csv("device_a.csv")
    assert len(rows) > 1500
    np.testing.assert_array_equal(rows["tick"], np.arange(len(rows)))
    np.testing.assert_array_equal(felt["answered_tick"], rows["tick"])
    for name in ("x", "y", "z", "force_x", "force_y", "force_z"):  # of the device; of the servo
        np.testing.assert_array_equal(rows[name].astype(np.float32), felt[name].astype(np.float32))
    assert np.diff(rows["contact"])[np.diff(rows["contact"]) != 0].tolist() == [1, -1, 1, -1]
    assert rows["contact"].sum() > 500
    # A cube of 10 kPa and 30 mm under a hand 5 mm deep: tenths of a newton, less than the hand alone can press.
    assert PRESSED_N < np.linalg.norm(forces(rows), axis=1).max() < 200 * 0.005
    finger_path(loop.folder / "servo_a.csv", loop.folder / "path.csv")
    done([BUILT / "cube/servo", "--quiet", "--replay", loop.folder / "path.csv", "--out", loop.folder / "replay.csv"])
    assert loop.read("servo_a.csv") == loop.read("servo_b.csv") == loop.read("replay.csv")
    assert loop.read("device_a.csv") == loop.read("device_b.csv")


def test_the_device_gives_no_force_without_a_servo(loop, answers):
    """In real time: the servo dies in the middle of a press, and 20 ms later the device gives no force. On a busy
    machine the press may be over when the signal comes: then again."""
    for _ in range(10):
        servo, device = loop.servo(), loop.device(POKES)
        wait_until_pressed(answers)
        ends(servo, by=signal.SIGKILL)
        time.sleep(0.2)
        assert ends(device, by=signal.SIGTERM) == 0
        rows = loop.csv("device.csv")
        last = int(np.flatnonzero(np.diff(rows["answered_tick"]) > 0)[-1]) + 1
        if abs(rows["force_z"][last]) >= PRESSED_N and last + 50 <= len(rows):
            # A tick of the device takes a millisecond or, on a busy machine, more: never less.
            assert not rows["force_z"][last + 22:].any()
            return
    pytest.fail("the servo was never killed within a press")


def test_the_servo_gives_no_force_without_a_device(loop, answers):
    """In real time: the device dies in the middle of a press, and the servo says zero force once it has been silent."""
    servo, device = loop.servo(), loop.device(POKES)
    wait_until_pressed(answers)
    ends(device, by=signal.SIGKILL)
    silent = next(message for message in answers if message.servo_state == message.SILENT)
    assert not any(silent.force_n)
    assert ends(servo, by=signal.SIGTERM) == 0
    # The record of an ended servo is whole.
    assert len(loop.csv("servo.csv")) > 50
