# SPDX-License-Identifier: GPL-2.0-or-later
"""The microcontroller in the loop: the loop image under QEMU, the bridge, the simulated device. The forces are those of
the host's servo, bit for bit, over pipes, the board's UART and a serial port."""

import contextlib
import os
import pty
import random
import signal
import threading
import tty

import numpy as np
import pytest
from programs import BUILT, Listener, done, ends, forces, program, read_csv

TARGETS = ["cortex-m4", "cortex-m7", "cortex-m33", "rv32"]
ANSWER_BYTES = 93  # of one finger: firmware/haptable.h, HAPTABLE_LINE_ANSWER_BYTES


class Line:
    """A target behind a line, a bridge to it, a device, and the host's servo."""

    def __init__(self, folder, start) -> None:
        self.folder, self.start, self.images = folder, start, 0

    def pipes(self, target: str, scene: str = "cube") -> list:
        """Both ends of a new image's line."""
        self.images += 1
        ends_of = [self.folder / f"{name}{self.images}" for name in ("to", "from")]
        for end in ends_of:
            os.mkfifo(end)
        self.start(["sh", "scripts/qemu.sh", target, BUILT / f"{scene}/firmware/{target}/loop.elf", *ends_of])
        return ends_of

    def over(self, by: str, target: str, scene: str = "cube") -> list:
        """The bridge's words for it: by "pipes", or "uart", that of the board."""
        image = f"{BUILT}/{scene}/firmware/{target}/uart.elf"
        return (["--pipes", *self.pipes(target, scene)] if by == "pipes" else
                ["--run", f"env QEMU_SERIAL=stdio sh scripts/qemu.sh {target} {image}"])

    def bridge(self, line: list, scene: str = "cube", record: str = "bridge.csv", **where):
        return self.start([program("haptable-bridge"), BUILT / scene, "--quiet", "--no-realtime", "--csv",
                           self.folder / record, *line], **where)

    def device(self, *words: str, scene: str = "meshes/cube.toml"):
        return self.start([program("haptable-device"), scene, "--quiet", "--lockstep", *words])

    def replayed(self, scene: str = "cube"):
        """The bridge's record, which has the bytes of the host's servo on its path."""
        record, again = self.folder / "bridge.csv", self.folder / "host.csv"
        done([BUILT / scene / "servo", "--quiet", "--replay", record, "--out", again])
        assert again.read_bytes() == record.read_bytes()
        return read_csv(record)

    def session(self, line: list, *words: str, scene: str = "cube", file: str = "meshes/cube.toml") -> tuple:
        """That record of a session in lockstep, and what its device felt."""
        bridge = self.bridge(line, scene)
        device = self.device(*words, "--csv", self.folder / "device.csv", scene=file)
        assert ends(device) == 0 and ends(bridge, by=signal.SIGTERM) == 0
        return self.replayed(scene), read_csv(self.folder / "device.csv")

    def expect_forces_of_the_host(self, line: list, seconds: float) -> None:
        rows, felt = self.session(line, "--path", "drag,poke", "--seconds", str(seconds))
        assert len(rows) == len(felt) == round(seconds * 1000)
        np.testing.assert_array_equal(felt["answered_tick"], np.arange(len(felt)))
        np.testing.assert_array_equal(forces(felt), forces(rows))
        assert rows["contact"].sum() > 50

    def expect_forces_of_all(self, line: list, scene: str, file: str,
                             path: tuple = ("drag,poke", "--seconds", "0.5"), fingers: int = 2):
        """The same of two hands, or three."""
        rows, _ = self.session(line, "--fingers", str(fingers), "--path", *path, scene=scene, file=file)
        assert len(rows) >= 500
        assert (rows["contact"] * rows["contact2"] * rows[f"contact{fingers}"]).sum() > 50
        return rows

    def expect_wrench_of_the_host(self, line: list, seconds: float) -> None:
        """The same of a tool, which turns."""
        rows, felt = self.session(line, "--path", "roll,tilt", "--depth", "0.002", "--seconds", str(seconds),
                                  scene="pressed-disc", file="tests/firmware/tool.toml")
        assert len(rows) >= round(seconds * 1000) and rows["contact"].sum() > 50
        np.testing.assert_array_equal(forces(felt), forces(rows))
        for torque in ("torque_x", "torque_y", "torque_z"):
            np.testing.assert_array_equal(felt[torque].astype(np.float32), rows[torque].astype(np.float32))
        assert np.abs(rows["torque_x"]).max() > 1e-4 and rows["contact_p5"].sum() > 50

    def expect_motion_of_the_host(self, line: list, scene: str, file: str, channel: str, columns: list, field: str,
                                  url: str) -> None:
        """The same of how the body moves, in the bridge's record and over LCM."""
        with contextlib.closing(Listener(url)) as listener:
            bridge = self.bridge(line, scene)
            device = self.device("--path", "drag", "--seconds", "0.5", scene=file)
            heard = listener.heard(channel, 60)
            motion = np.float32([getattr(next(heard), field)[:3] for _ in range(500)])
        assert ends(device) == 0 and ends(bridge, by=signal.SIGTERM) == 0
        rows = self.replayed(scene)
        moved = np.stack([rows[name] for name in columns], axis=1).astype(np.float32)
        np.testing.assert_array_equal(motion, moved)
        assert moved[-1, 0] != moved[0, 0], "it is pushed"


@pytest.fixture
def line(tmp_path, start, need, lcm_url):
    need("cube/servo", "bin/haptable-device", "bin/haptable-bridge",
         *(f"{scene}/firmware/cortex-m7/loop.elf" for scene in ("cube", "pressed-disc", "three-hands")))
    return Line(tmp_path, start)


PIPES = [("pipes", target) for target in TARGETS]
BOTH = [*PIPES, ("uart", "cortex-m7"), ("uart", "rv32")]


@pytest.mark.parametrize("by, target", BOTH)
def test_it_gives_the_forces_of_the_host(line, by, target):
    line.expect_forces_of_the_host(line.over(by, target), 1 if by == "pipes" else 0.3)


@pytest.mark.parametrize("by, target, scene, file", [*((*both, "cube-two", "meshes/cube-two.toml") for both in BOTH),
                                                     ("pipes", "cortex-m4", "squeezed", "tests/firmware/squeeze.toml")])
def test_two_fingers_have_the_forces_of_the_host(line, by, target, scene, file):
    """Two hands of one device: what the target felt, through the host's servo again. On a body that rings, too."""
    line.expect_forces_of_all(line.over(by, target, scene), scene, file)


@pytest.mark.parametrize("by, target", [*PIPES, ("uart", "rv32")])
def test_three_hands_have_the_forces_of_the_host(line, by, target):
    seconds, scene = 1 if by == "pipes" else 0.6, "three-hands"
    rows = line.expect_forces_of_all(line.over(by, target, scene), scene, "tests/firmware/hands.toml",
                                     ("drag,poke", "--seconds", str(seconds)), 3)
    assert len(rows) >= 1000 * seconds


@pytest.mark.parametrize("by, target", [*PIPES, ("uart", "cortex-m7")])
def test_a_tool_has_force_and_torque_of_the_host(line, by, target):
    line.expect_wrench_of_the_host(line.over(by, target, "pressed-disc"), 1 if by == "pipes" else 0.6)


@pytest.mark.parametrize("target, scene, file, channel, columns, field", [
    (target, *body) for targets, body in (
        (("cortex-m4", "rv32"), ("free-cube", "meshes/free-cube.toml", "HAPTABLE_BODY", ["body_x", "body_y", "body_z"],
                                 "centre_m")),
        (("cortex-m7", "rv32"), ("ringing", "tests/firmware/modes.toml", "HAPTABLE_MODES", ["mode_1", "mode_2", "mode_3"],
                                 "swung"))) for target in targets])
def test_a_body_that_moves_is_where_the_host_has_it(line, lcm_url, target, scene, file, channel, columns, field):
    """A body that nothing holds, pushed by one hand, or one that rings; over LCM too."""
    line.expect_motion_of_the_host(line.over("pipes", target, scene), scene, file, channel, columns, field, lcm_url)


@pytest.mark.parametrize("target, scene, file", [("cortex-m7", "grasped", "tests/firmware/grasp.toml"),
                                                 ("cortex-m33", "wobbling", "tests/firmware/wobble.toml")])
def test_a_body_that_two_hands_lift_is_where_the_host_has_it(line, target, scene, file):
    """With modes besides, and without."""
    rows = line.expect_forces_of_all(line.over("pipes", target, scene), scene, file, ("lift", "--hold", "0.1"))
    assert rows["body_z"].max() > rows["body_z"][0] + 0.01, "it is lifted"


class Port:
    """A target at the other end of a serial port, which is pulled out after so many bytes of answers. Garbage, rich in
    false begins, comes before all that is said."""

    GARBAGE = bytes(random.Random(1).choices([0xA5, 0x5A, 0, 20, *range(256)], [*4 * [128], *256 * [1]], k=600))

    def __init__(self, pipes: list, left: int = 1 << 30) -> None:
        self._controller, port = pty.openpty()
        tty.setraw(port)
        self.name, self._left, self._held = os.ttyname(port), left, [port]
        threading.Thread(target=self._serve, args=pipes, daemon=True).start()

    def _serve(self, to, from_) -> None:
        with open(to, "wb", buffering=0) as to, open(from_, "rb", buffering=0) as from_:
            threading.Thread(target=self._states, args=[to], daemon=True).start()
            while self._left > 0 and (data := from_.read(4096)):
                os.write(self._controller, self.GARBAGE + data)
                self._left -= len(data)
            for end in (*self._held, self._controller):
                os.close(end)

    def _states(self, to) -> None:
        with contextlib.suppress(OSError, ValueError):
            while data := os.read(self._controller, 4096):
                to.write(self.GARBAGE + data)


def test_over_a_serial_port_it_gives_the_forces_of_the_host(line):
    """With a million bytes of garbage, both ways."""
    port = Port(line.pipes("cortex-m7"))
    line.expect_forces_of_the_host(["--port", port.name, "--baud", "2000000"], 1)


def test_a_port_that_vanishes_ends_the_bridge_and_another_goes_on(line):
    """The cable is pulled out in the middle of a session: one line that says so, and a record up to there; plugged in
    again, under whatever name, a new bridge goes on with the same device."""
    pulled, said = Port(line.pipes("cortex-m7"), left=100 * ANSWER_BYTES), line.folder / "first.txt"
    first = line.bridge(["--port", pulled.name], record="first.csv", err=said)
    device = line.device("--path", "poke", "--seconds", "0.3")
    assert ends(first) == 1
    assert f"{pulled.name}: the port has gone: plug" in said.read_text() and said.read_text().count("\n") == 1
    assert len(read_csv(line.folder / "first.csv")) > 50, "its record is there, up to the end"
    second = line.bridge(["--port", Port(line.pipes("cortex-m7")).name], record="second.csv")
    assert ends(device) == 0 and ends(second, by=signal.SIGTERM) == 0
    assert len(read_csv(line.folder / "second.csv")) > 190
