# SPDX-License-Identifier: GPL-2.0-or-later
"""A tool and three hands on a microcontroller in the loop: force and torque are the host's, bit for bit."""

import os
import signal

import numpy as np
import pytest
from programs import BUILT, done, ends, forces, program, read_csv

SCENES = {"pressed-disc": ("tests/firmware/tool.toml", ("--path", "roll,tilt", "--depth", "0.002")),
          "three-hands": ("tests/firmware/hands.toml", ("--path", "drag,poke", "--fingers", "3"))}


class Session:
    """A loop image behind a line, a bridge and a device in lockstep; then the host's servo on the bridge's record."""

    def __init__(self, folder, start) -> None:
        self.folder, self.start = folder, start

    def pipes(self, target: str, scene: str) -> list:
        to_and_from = [self.folder / name for name in ("to", "from")]
        for end in to_and_from:
            os.mkfifo(end)
        self.start(["sh", "scripts/qemu.sh", target, BUILT / f"{scene}/firmware/{target}/loop.elf", *to_and_from])
        return ["--pipes", *to_and_from]

    def uart(self, target: str, scene: str) -> list:
        image = BUILT / f"{scene}/firmware/{target}/uart.elf"
        return ["--run", f"env QEMU_SERIAL=stdio sh scripts/qemu.sh {target} {image}"]

    def run(self, line: list, scene: str, seconds: float):
        """What the device felt, and the bridge's record, which the host's servo makes again."""
        file, path = SCENES[scene]
        bridge = self.start([program("haptable-bridge"), BUILT / scene, "--quiet", "--no-realtime", "--csv",
                             self.folder / "bridge.csv", *line])
        device = self.start([program("haptable-device"), file, "--quiet", "--lockstep", *path,
                             "--seconds", str(seconds), "--csv", self.folder / "device.csv"])
        assert ends(device) == 0 and ends(bridge, by=signal.SIGTERM) == 0
        record, again = self.folder / "bridge.csv", self.folder / "host.csv"
        done([BUILT / scene / "servo", "--quiet", "--replay", record, "--out", again])
        assert again.read_bytes() == record.read_bytes()
        return read_csv(self.folder / "device.csv"), read_csv(self.folder / "bridge.csv")

    def expect(self, line: list, scene: str, seconds: float) -> None:
        felt, rows = self.run(line, scene, seconds)
        assert len(rows) >= round(seconds * 1000) and rows["contact"].sum() > 50
        if scene == "three-hands":
            assert (rows["contact"] * rows["contact2"] * rows["contact3"]).sum() > 50
            return
        np.testing.assert_array_equal(forces(felt), forces(rows))
        for axis in "xyz":
            torque = f"torque_{axis}"
            np.testing.assert_array_equal(felt[torque].astype(np.float32), rows[torque].astype(np.float32))
        assert np.abs(rows["torque_x"]).max() > 1e-4 and rows["contact_p5"].sum() > 50


@pytest.fixture
def session(tmp_path, start, need, lcm_url):
    need("bin/haptable-device", "bin/haptable-bridge", *(f"{scene}/firmware/cortex-m7/loop.elf" for scene in SCENES))
    return Session(tmp_path, start)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("target", ["cortex-m4", "cortex-m7", "cortex-m33", "rv32"])
def test_over_pipes_it_gives_the_forces_of_the_host(session, target, scene):
    session.expect(session.pipes(target, scene), scene, 1.0)


@pytest.mark.parametrize("target, scene", [("cortex-m7", "pressed-disc"), ("rv32", "three-hands")])
def test_over_the_uart_it_gives_the_forces_of_the_host(session, target, scene):
    session.expect(session.uart(target, scene), scene, 0.6)
