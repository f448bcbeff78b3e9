# SPDX-License-Identifier: GPL-2.0-or-later
"""The installed package, from the project's root: python python/tests/test_haptable.py

HAPTABLE_LOG: a log with known messages (tests/packaging/test_python.py makes it)."""
import doctest
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import threading
import time
import unittest

import numpy as np

import haptable
from haptable import _files, _report, _servo

BUILD = pathlib.Path(os.environ.get("BUILD", "build")).resolve()
CUBE = BUILD / "cube"
PROGRAM = BUILD / "bin/haptable-precompute"


def press(ticks: int = 60) -> np.ndarray:
    """A path down into the cube's top and aside, and then at rest."""
    t = np.minimum(np.arange(ticks, dtype=np.float32), 60)[:, None]
    return np.float32([0.015, 0.015, 0.032]) + t * np.float32([2e-5, -1e-5, -1e-4])


class Package(unittest.TestCase):
    def setUp(self):
        self.body = haptable.load(CUBE)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def refused(self, error, said, call):
        """An error that says that, a regular expression."""
        with self.assertRaisesRegex(error, said):
            call()

    def made(self, scene):
        """The body of a scene's file, by this tree's program."""
        return haptable.load(haptable.precompute(scene, self.path / "made", program=PROGRAM))

    def replay_of_the_servo(self, positions):
        with open(self.path / "in.csv", "w") as out:
            out.write("x,y,z\n" + "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in positions))
        subprocess.run([CUBE / "servo", "--quiet", "--replay", self.path / "in.csv", "--out", self.path / "out.csv"],
                       check=True)
        return haptable.read_csv(self.path / "out.csv")

    def test_otherwise_than_the_scene_says(self):
        positions = press(200)
        felt = self.body.servo().replay(positions)
        other = {name: haptable.load(CUBE, **options).servo().replay(positions) for name, options in {
            "int16": {"precision": "int16"}, "least": {"god_object": "least-energy"}, "bare": {"bare": True}}.items()}
        off = np.linalg.norm(other["int16"]["force"][-1] - felt["force"][-1]) / np.linalg.norm(felt["force"][-1])
        self.assertTrue(0 < off < 1e-3)  # of numbers of 15 bits, with room for a block's condition
        self.assertGreater(np.linalg.norm(other["least"]["god_object"][-1] - felt["god_object"][-1]), 1e-5)
        jump = np.float32([[0.015, 0.015, 0.04], [0.015, 0.015, -0.05]])  # no hand moves so
        self.assertEqual(haptable.load(CUBE).servo().replay(jump)["state"][-1], haptable.State.REJECTED)
        self.assertNotEqual(haptable.load(CUBE, bare=True).servo().replay(jump)["state"][-1], haptable.State.REJECTED)
        with self.assertRaisesRegex(haptable.HaptableError, "float8: is none of float32, float16, int16"):
            haptable.load(CUBE, precision="float8")
        self.refused(ValueError, "", lambda: haptable.load(CUBE, self.body.tables_hash, bare=True))

    def test_bits_of_the_servo(self):
        positions = press(200)
        felt = self.body.servo().replay(positions)
        table = self.replay_of_the_servo(positions)
        for i, axis in enumerate("xyz"):
            self.assertTrue(np.array_equal(felt["force"][:, i], table[f"force_{axis}"].astype(np.float32)))
            self.assertTrue(np.array_equal(felt["god_object"][:, i], table[f"god_{axis}"].astype(np.float32)))
        for i, corner in enumerate("ijk"):
            self.assertTrue(np.array_equal(felt["nodes"][:, i], table[f"node_{corner}"]))
        self.assertTrue(np.array_equal(felt["state"], table["state"]))
        self.assertGreater(np.count_nonzero(felt["force"]), 100)

    def test_step_is_replay(self):
        servo, positions = self.body.servo(), press()
        felt = self.body.servo().replay(positions)
        for row, position in zip(felt, positions):
            contact = servo.step(position)
            self.assertEqual(bool(contact), row["state"] in (2, 4))
            for name in ("state", "faults", "force", "god_object", "nodes", "alpha", "nodal_forces"):
                self.assertTrue(np.array_equal(getattr(contact, name), row[name]), name)
        self.assertEqual(servo.counters["ticks"], 60)
        self.assertGreater(servo.energy["stored_j"], 0.0)
        # float64, a list and a strided view are the same positions.
        for same in (positions[-1].astype(float), positions[-1].tolist(), np.repeat(positions[-1], 2)[::2]):
            self.assertTrue(np.array_equal(servo.step(same).force, contact.force))

    def test_arrays_are_the_memory(self):
        for array in (self.body.rest, self.body.surface, self.body.patches, self.body.row_nodes):
            self.assertFalse(array.flags.writeable)
            self.assertFalse(array.flags.owndata)
        self.assertTrue(np.array_equal(self.body.rest, np.load(CUBE / "position.npy")))
        self.assertTrue(np.array_equal(self.body.patches, np.load(CUBE / "patch.npy")))
        self.assertTrue(np.array_equal(self.body.row_nodes, np.load(CUBE / "row_id.npy")))
        out = np.empty(60, haptable.CONTACT)
        self.assertIs(self.body.servo().replay(press(), out), out)
        contact = self.body.servo().step([0, 0, 1])
        self.assertFalse(contact.force.flags.owndata)
        rest = self.body.rest
        del self.body
        self.assertTrue(np.array_equal(rest, np.load(CUBE / "position.npy")))  # alive without its body

    def test_deforms_by_equation_8(self):
        felt = self.body.servo().replay(press())[-1]
        columns, node_id = np.load(CUBE / "columns.npy"), np.load(CUBE / "node_id.npy").tolist()
        expected = sum(columns[node_id.index(n)].astype(float) @ f.astype(float)
                       for n, f in zip(felt["nodes"], felt["nodal_forces"]) if n in node_id)
        u = self.body.deform(felt)
        largest = np.abs(expected).max()
        self.assertGreater(largest, 1e-3)
        # 9 products and sums a row, each rounded once to float32, of terms at most three times the sum.
        self.assertLess(np.abs(u - expected).max(), 9 * 3 * 2.0**-24 * largest)
        self.assertTrue(np.array_equal(self.body.deform(felt, rows=[5, 3]), u[[5, 3]]))
        self.refused(haptable.HaptableError, "there is no row", lambda: self.body.deform(felt, rows=[len(u)]))

    def test_refusals_name_what_to_do(self):
        with self.assertRaisesRegex(haptable.HaptableError, "tables.json: is not there: make the tables"):
            haptable.load(self.path)
        self.refused(ValueError, "README.md: is no CSV", lambda: haptable.read_csv("README.md"))
        self.refused(haptable.HaptableError, "that are wanted", lambda: haptable.load(CUBE, "1"))
        self.refused(ValueError, r"\[3\] in m", lambda: self.body.servo().step([0.0, 1.0]))
        self.refused(ValueError, r"\[n, 3\]", lambda: self.body.servo().replay([[0.0, 1.0]]))
        self.refused(ValueError, "", lambda: self.body.servo().replay(press(), np.empty(59, haptable.CONTACT)))

    def test_errors_are_the_documented_ones(self):
        servo = self.body.servo()
        for time in (float("nan"), float("inf")):
            self.refused(ValueError, "time: finite", lambda: servo.step([0, 0, 1], time))
        for wrong in ("word", "-1", "1" + 16 * "0"):
            self.refused(ValueError, "tables_hash: 16 hex digits", lambda: haptable.load(CUBE, wrong))
        self.assertEqual(haptable.HaptableError.__module__, "haptable")
        self.refused(TypeError, "", lambda: self.body.deform(np.zeros(3)))

    def test_a_state_has_one_name(self):
        # Inside without having come in, and a jump: what each is called, and counted as.
        servo = self.body.servo()
        inside = servo.step((0.015, 0.015, 0.015))
        self.assertEqual((inside.state, bool(inside)), (haptable.State.FREE, False))
        positions = np.vstack([press(), [[0.015, 0.015, 0.5]], [[np.nan, 0, 0]]]).astype(np.float32)
        felt, servo = self.body.servo().replay(positions), self.body.servo()
        states = [servo.step(x).state for x in positions]
        self.assertEqual(states, felt["state"].tolist())
        self.assertEqual(states[-2:], [haptable.State.REJECTED] * 2)
        self.assertEqual((servo.counters["implausible"], servo.counters["rejected_positions"]), (1, 1))
        self.assertEqual(haptable.State(felt["state"][59]).name, "CONTACT")

    def test_a_poke_is_the_servos(self):
        felt = self.body.poke((0.012, 0.014, 0.03), 0.003, (0, 0, -2.0))
        said = subprocess.run([CUBE / "servo", "--poke", "0.012,0.014,0.03", "--depth", "0.003", "--json"], check=True,
                              capture_output=True, text=True).stdout
        self.assertEqual(" ".join(f"{float(x):.6g}" for x in felt["force"]), json.loads(said)["force_n"])
        # By the surface's normal, and many at once.
        nodes = np.unique(self.body.patches)
        nodes = nodes[np.abs(self.body.rest[nodes, 2] - 0.03) < 1e-9]
        normals = self.body.normals
        inside = np.setdiff1d(np.arange(len(normals)), np.unique(self.body.surface))
        self.assertTrue(np.allclose(np.linalg.norm(normals[np.unique(self.body.surface)], axis=1), 1.0))
        self.assertEqual(np.count_nonzero(normals[inside]), 0)
        outwards = ((self.body.rest - 0.015) * normals).sum(axis=1)
        self.assertTrue((outwards[np.unique(self.body.surface)] > 0).all())
        many = self.body.poke(self.body.rest[nodes], 1e-3)
        self.assertEqual(many.shape, nodes.shape)
        one = self.body.poke(self.body.rest[nodes[3]], 1e-3, -normals[nodes[3]])
        self.assertTrue(np.array_equal(one["force"], many[3]["force"]))
        self.assertEqual(self.body.poke((0.5, 0.5, 0.5), 0.001, (0, 0, -1))["state"], haptable.State.FREE)
        for wrong in (((0, 0), 1, (0, 0, 1)), ((0, 0, 0), 1, (0, 0)), ((0, 0, 0), np.nan, (0, 0, 1)),
                      ((0, 0, 0), 1, (0, 0, 0)), ((0, 0, np.inf), 1, (0, 0, 1)), ((0, 0, 0), 1e9, (0, 0, 1)),
                      ((0, 0, 0), [1, 2], np.ones((3, 3)))):
            self.refused(ValueError, "", lambda: self.body.poke(*wrong))

    def test_arrays_that_do_not_fit_are_refused(self):
        felt = self.body.servo().replay(press())[-1]
        out = np.empty((len(self.body.row_nodes), 3), np.float32)
        out.flags.writeable = False
        self.refused(ValueError, "writeable", lambda: self.body.deform(felt, out=out))
        self.refused(ValueError, r"rows: \[k\]", lambda: self.body.deform(felt, rows=[[0, 1]]))
        self.refused(TypeError, "whole", lambda: self.body.deform(felt, rows=[0.5]))
        for rows in ([-1], [2**32]):
            self.refused(ValueError, "from 0", lambda: self.body.deform(felt, rows=rows))
        self.assertEqual(self.body.deform(felt, rows=[]).shape, (0, 3))

    def test_csv_of_large_numbers_stays_float(self):
        file = self.path / "large.csv"
        file.write_text("a,b,c,d\n1e400,1e300,36028797018963968,3\n-1e400,1,0,4\n")
        table = haptable.read_csv(file)
        self.assertEqual([table.dtype[name].kind for name in "abcd"], ["f", "f", "f", "i"])
        self.assertEqual(table["a"].tolist(), [np.inf, -np.inf])
        self.assertEqual(table["b"].tolist(), [1e300, 1.0])

    def test_logs_that_are_damaged_are_told(self):
        def event(channel, data, channel_length=None, length=None):
            header = (0xEDA1DA01, 0, 1, len(channel) if channel_length is None else channel_length,
                      len(data) if length is None else length)
            return struct.pack(">IqqII", *header) + channel + data
        log = self.path / "a.lcmlog"

        def read(*events):
            log.write_bytes(b"".join(events))
            return list(haptable.read_log(log))
        good = event(b"OTHER", b"bytes")
        self.assertEqual(len(read(good, good)), 2)
        # Cut off: 2^32 - 1 bytes are neither read nor made room for.
        self.assertEqual(len(read(good, event(b"OTHER", b"bytes", length=0xFFFFFFFF))), 1)
        for bad in (event(b"OTHER", b"", channel_length=0xFFFFFFFF), event(b"\xff\xfe", b"")):
            self.refused(ValueError, "byte 38", lambda: read(good, bad))
        from haptable.messages.contact import contact
        from haptable.messages.servo_status import servo_status
        for channel, message in ((b"HAPTABLE_CONTACT", contact()), (b"HAPTABLE_STATUS", servo_status())):
            data = message.encode()
            self.assertEqual(len(read(event(channel, data))), 1)
            for count in (0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 5):
                with self.assertRaisesRegex(ValueError, "byte 0: no whole message"):
                    read(event(channel, data[:-4] + struct.pack(">I", count)))
            for end in range(len(data)):
                self.refused(ValueError, "byte 0: no whole message", lambda: read(event(channel, data[:end])))

    def test_a_replay_lets_other_threads_run(self):
        positions = np.tile(press(), (30000, 1))
        servo, when = self.body.servo(), []

        def work():
            begin = time.monotonic()
            servo.replay(positions)
            when.extend((begin, time.monotonic()))
        thread = threading.Thread(target=work)
        thread.start()
        seen = []
        while thread.is_alive():
            seen.append(time.monotonic())
        begin, end = when
        inside = [t for t in seen if begin + 0.1 * (end - begin) < t < begin + 0.9 * (end - begin)]
        self.assertTrue(inside, "no other thread ran in the middle of it")

    def test_two_fingers(self):
        self.refused(haptable.HaptableError, "fingers = 2", lambda: self.body.hands())
        body = self.made("meshes/cube-two.toml")
        self.assertEqual((self.body.fingers, body.fingers), (1, 2))
        first, second = press() - np.float32([0.005, 0, 0]), press() + np.float32([0.005, 0, 0])
        felt = body.hands().replay(first, second)
        self.assertEqual(felt.shape, (60, 2))
        pair = body.hands()
        for row, x, y in zip(felt, first, second):
            for contact, one in zip(pair.step(x, y), row):
                self.assertTrue(np.array_equal(contact.force, one["force"]))
        self.assertEqual(felt["state"][-1].tolist(), [2, 2])
        self.assertEqual(pair.counters(1)["ticks"], 60)
        for call in (pair.counters, pair.energy, pair.buttons):
            for finger in (2, -1):
                self.refused(IndexError, "0 to 1", lambda: call(finger))
        self.assertGreater(pair.energy(0)["stored_j"], 0.0)
        # The other's dent takes the surface away; who is away makes none.
        alone, half = body.servo().replay(first), body.hands()
        self.assertLess(felt["force"][-1, 0, 2], 0.99 * alone["force"][-1, 2])
        for row, x in zip(alone, first):
            contact, away = half.step(x, None)
            self.assertTrue(np.array_equal(contact.force, row["force"]))
            self.assertEqual(away.state, haptable.State.SILENT)
        self.refused(ValueError, "of each finger", lambda: pair.replay(first, second[1:]))
        self.refused(ValueError, "of each of the 2", lambda: pair.step(first[0]))

    def test_five_fingers(self):
        body = self.made("meshes/cube-hand.toml")
        self.assertEqual(body.fingers, 5)
        angle = 2 * np.pi * np.arange(5) / 5
        out = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
        reach = np.linspace(0.016, 0.0135, 100)[:, None] / np.abs(out[:, :2]).max(1)
        path = np.float32([0.015, 0.015, 0.02] + reach[:, :, None] * out)
        felt = body.hands().replay(*path.transpose(1, 0, 2))
        self.assertEqual(felt["state"][-1].tolist(), [2] * 5)
        # Each is pushed outwards, out of the body; all together hardly push it aside.
        push = np.einsum("ij,ij->i", felt["force"][-1], out)
        self.assertGreater(push.min(), 0.01)
        self.assertLess(np.linalg.norm(felt["force"][-1, :, :2].sum(0)), 0.2 * push.sum())

    def test_a_tool(self):
        self.refused(haptable.HaptableError, "has no tool", lambda: self.body.tool())
        text = pathlib.Path("meshes/cube.toml").read_text().split("[contact]")[0]
        (self.path / "disc.toml").write_text(
            text + '[contact]\nforce = "pressure-mask"\nmask_radius = 0.004\n'
            '[tool]\nshape = "disc"\nradius = 0.006\npoints = 5\n')
        body = self.made(self.path / "disc.toml")
        self.assertEqual((self.body.points, body.points, body.tool_points.shape), (0, 5, (5, 3)))
        tool, held = body.tool(), np.tile(np.float32([1, 0, 0, 0]), (400, 1))
        lower = np.float32([0.015, 0.015, 0.031]) - np.outer(np.arange(400), np.float32([0, 0, 1e-5]))
        felt = tool.replay(lower, held)
        self.assertEqual(felt["state"][-1], haptable.State.CONTACT)
        self.assertGreater(felt["force"][-1, 2], 0.1)
        # The hand's force is that of its points, its torque that of their forces about the handle.
        points = tool.points
        self.assertTrue(np.allclose(points["force"].sum(0), felt["force"][-1], atol=1e-5))
        about = np.cross(body.tool_points, points["force"]).sum(0)
        self.assertTrue(np.allclose(about, felt["torque"][-1], atol=1e-6))
        # Tilted about x by 0.05 rad, it is turned back.
        for angle in np.linspace(0, 0.05, 200):
            tilted = tool.step(lower[-1], (np.cos(angle / 2), np.sin(angle / 2), 0, 0))
        self.assertLess(tilted["torque"][0], -1e-4)
        self.assertEqual(tool.step(lower[-1], (2, 0, 0, 0))["state"], haptable.State.REJECTED)
        self.assertEqual(tool.counters["ticks"], 601)
        self.refused(ValueError, r"turns: \[n, 4\]", lambda: tool.replay(lower, held[1:]))

    def test_a_body_that_nothing_holds(self):
        self.assertFalse(self.body.free)
        self.assertIsNone(self.body.servo().pose)
        body = self.made("meshes/grasp-cube.toml")
        self.assertTrue(body.free)
        self.refused(ValueError, "nothing holds it", lambda: body.poke((0, 0.015, 0.015), 0.001, (1, 0, 0)))
        pair, held = body.hands(), 0.0
        for tick in range(2500):  # squeezed from two sides, lifted by 16 mm, and held
            inwards, up = 4e-6 * min(tick, 400) - 1e-4, 2e-5 * min(max(tick - 500, 0), 800)
            felt = pair.step((inwards, 0.015, 0.015 + up), (0.03 - inwards, 0.015, 0.015 + up))
            held -= (felt[0].force[2] + felt[1].force[2]) * (tick >= 1500)
        pose = pair.pose
        self.assertGreater(pose.centre[2] - pose.rest_centre[2], 0.01)
        self.assertTrue(np.allclose(pose.matrix @ pose.matrix.T, np.eye(3), atol=1e-5))
        # God-objects are the body's, a millimetre and a half from the fingers, which are the world's.
        for contact, x in zip(felt, (inwards, 0.03 - inwards)):
            self.assertLess(np.linalg.norm(pose.to_world(contact.god_object) - (x, 0.015, 0.015 + up)), 0.003)
        # It swings between them: held in the mean, as its momentum changes by no more than that of 16 mm in 0.8 s.
        weight = 9.81 * 27e-3
        self.assertLess(abs(held / 1000 - weight), 2 * 27e-3 * 0.02 / 1.0)

    def test_a_body_that_rings(self):
        self.assertEqual(self.body.modes, 0)
        self.assertEqual(self.body.servo().swung.shape, (0,))
        body = self.made("tests/firmware/modes.toml")
        self.assertEqual(body.modes, 8)
        servo, side = body.servo(), np.float32([0, 0.015, 0.02])
        for x in np.linspace(-0.001, 0.004, 100):  # pressed at its side, and let go
            contact = servo.step(side + np.float32([x, 0, 0]))
        self.assertTrue(contact)
        free = [(servo.step(side - np.float32([0.01, 0, 0])), servo.swung) for _ in range(300)]
        self.assertEqual(free[-1][0].state, haptable.State.FREE)
        moved = np.array([body.deform(felt, swung=swung)[:, 0] for felt, swung in free])
        at = int(np.argmax(np.abs(moved).max(axis=0)))
        self.assertGreater(moved[:, at].max(), 1e-5)
        self.assertLess(moved[:, at].min(), -1e-5)  # it swings to both sides
        self.assertEqual(body.deform(free[0][0], [at], swung=free[0][1])[0, 0], moved[0, at])
        self.refused(ValueError, r"swung: \[8\]", lambda: body.deform(contact))

    def test_precompute_by_the_program(self):
        folder = haptable.precompute("meshes/cube.toml", self.path / "cube", program=PROGRAM)
        self.assertEqual(haptable.load(folder).tables_hash, self.body.tables_hash)
        with self.assertRaisesRegex(FileNotFoundError, "is not on the PATH"):
            haptable.precompute("meshes/cube.toml", program="haptable-nowhere")
        with self.assertRaises(subprocess.CalledProcessError) as caught:
            haptable.precompute(self.path / "none.toml", self.path, program=PROGRAM)
        self.assertIn("none.toml", caught.exception.stderr)

    @unittest.skipUnless("HAPTABLE_LOG" in os.environ, "no HAPTABLE_LOG")
    def test_reads_logs(self):
        from haptable import messages
        events = list(haptable.read_log(os.environ["HAPTABLE_LOG"]))
        self.assertEqual([e.channel for e in events], [*messages.CHANNELS, "OTHER"])
        self.assertEqual([e.utime for e in events], list(range(1, len(events) + 1)))
        for event in events[:-1]:  # each has its channel's type, and its time again
            self.assertIs(type(event.message), messages.CHANNELS[event.channel])
            self.assertEqual(event.message.utime, event.utime)
        by = {e.channel: e.message for e in events}
        self.assertEqual(tuple(by["HAPTABLE_STATE"].position_m), (0.25, -0.5, 1.0))
        self.assertEqual(tuple(by["HAPTABLE_FORCE_2"].force_n), (0.0, 0.0, 1.5))
        contact = by["HAPTABLE_CONTACT_2"]
        self.assertEqual((list(contact.node), [list(f) for f in contact.force_n]), ([3, 5], [[1, 2, 3], [4, 5, 6]]))
        self.assertEqual(tuple(by["HAPTABLE_BODY"].centre_m), (0.0, 0.5, 0.0))
        self.assertEqual((by["HAPTABLE_MODES"].count, by["HAPTABLE_MODES"].swung[1]), (2, 0.75))
        self.assertEqual((list(by["HAPTABLE_STATUS"].name), list(by["HAPTABLE_STATUS"].value)), (["ticks"], [9]))
        self.assertEqual(tuple(by["HAPTABLE_POSE"].turn), (0.5, 0.5, 0.5, 0.5))
        wrench = by["HAPTABLE_WRENCH"]
        self.assertEqual((tuple(wrench.torque_n_m), [list(f) for f in wrench.force_n]), ((0.0, 0.25, 0.0), [[4, 5, 6]]))
        self.assertEqual(by["OTHER"], b"bytes")
        cut = self.path / "cut.lcmlog"
        cut.write_bytes(pathlib.Path(os.environ["HAPTABLE_LOG"]).read_bytes()[:-3])
        self.assertEqual(len(list(haptable.read_log(cut))), len(events) - 1)
        self.refused(ValueError, "no event of an LCM log", lambda: list(haptable.read_log("README.md")))

    def test_a_report_is_one_page(self):
        positions = press(500)
        felt = self.body.servo().replay(positions)
        haptable.report(self.path / "page.html", positions, felt, latency_us=np.full(500, 80.0), title="a <b>")
        page = (self.path / "page.html").read_text()
        self.assertEqual(page.count("<svg"), 4)
        self.assertIn("a &lt;b&gt;", page)
        largest = np.linalg.norm(felt["force"].astype(float), axis=1).max()
        self.assertIn(f"largest force {largest:.4g} N", page)
        self.refused(ValueError, "", lambda: haptable.report(self.path / "page.html", positions[:3], felt))

    def test_doctests(self):
        for module in (haptable, _servo, _files, _report):
            result = doctest.testmod(module)
            self.assertEqual(result.failed, 0, module.__name__)
            self.assertGreater(result.attempted, 0, module.__name__)


if __name__ == "__main__":
    unittest.main()
