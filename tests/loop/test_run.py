# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable-run as a user starts it: a session in one command, and every way in which it can end before its time."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from programs import BUILT, done, ends, program, read_csv, read_log, run, wait_until

QUIET = ["--draw", "nothing", "--quiet"]
LONG = ["--seconds", "60", *QUIET]


def is_running(pid: int) -> bool:
    """A zombie that nobody reaps in this namespace has ended, too."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


class Session:
    """haptable-run on the cube, into out/ of a folder."""

    def __init__(self, folder, start) -> None:
        self.folder, self._start = folder, start

    def command(self, *words: str, scene: str = "meshes/cube.toml") -> list:
        return [program("haptable-run"), scene, "-o", f"{self.folder}/out", "--no-realtime", *words]

    def start(self, words: list) -> subprocess.Popen:
        return self._start(words, out=self.folder / "stdout", err=self.folder / "stderr")

    def begun(self, *words: str) -> subprocess.Popen:
        """One that has been recorded for a while."""
        process = self.start(self.command(*words))
        self.wait_for_record()
        return process

    def ended(self, *words: str, **scene) -> dict:
        """The summary of one that ends well."""
        assert ends(self.start(self.command(*words, **scene))) == 0, self.said()
        return self.json("summary")

    def wait_for_record(self, size: int = 200_000) -> None:
        log = self.folder / "out/session.lcmlog"
        assert wait_until(lambda: log.exists() and log.stat().st_size >= size), self.said()

    def said(self) -> str:
        return (self.folder / "stderr").read_text()

    def json(self, name: str) -> dict:
        return json.loads((self.folder / f"out/{name}.json").read_text())

    def csv(self, name: str):
        return read_csv(self.folder / f"out/{name}.csv")

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def log(self) -> list:
        return list(read_log(self.folder / "out/session.lcmlog"))

    def expect_whole_record(self) -> None:
        """One that other programs read: no half event, no half line."""
        assert len(self.log()) > 100
        for name in ("servo", "device", "session"):
            text = self.read(f"out/{name}.csv")
            assert text.endswith(b"\n") and text.count(b"\n") > 20, name
        assert b"</html>" in self.read("out/report.html")

    def child_of(self, process, words: str) -> int:
        """The id of the program with these words in its command line that a process started."""
        for entry in Path("/proc").iterdir():
            try:
                line = (entry / "cmdline").read_bytes().decode()
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue
            if parent == process.pid and words in line:
                return int(entry.name)
        raise AssertionError(f"{words} is not there")


@pytest.fixture
def session(tmp_path, start, need, lcm_url):
    need("bin/haptable-run", "cube/servo", "bin/haptable-device")
    return Session(tmp_path, start)


def test_leaves_a_folder_with_all_of_a_session(session):
    # A busy machine may keep the logger from its socket until that is full. What it lacks then is told; here a session
    # counts whose record is whole.
    for _ in range(5):
        summary = session.ended("--path", "poke", "--draw", "nothing", "--lockstep", "--json")
        assert session.read("stdout") == session.read("out/summary.json")
        assert session.json("device")["ticks"] == session.json("servo")["ticks"]
        if summary["unrecorded_ticks"] == 0:
            break
    assert summary["unrecorded_ticks"] == 0
    session.expect_whole_record()
    assert (summary["trouble"], summary["unanswered"]) == ("none", 0)
    assert summary["contact_ticks"] > 300
    assert len(session.csv("servo")) == summary["ticks"] == session.json("device")["ticks"]
    # The log is a regression test: the servo gives the same again.
    done([BUILT / "cube/servo", "--quiet", "--check", "--replay", session.folder / "out/session.lcmlog", "--out",
          session.folder / "again.csv"])
    assert session.read("again.csv") == session.read("out/servo.csv")
    page = session.read("out/report.html").decode()
    for title in ("Force on the finger", "Depth", "Energy", "Faults so far"):
        assert title in page


def test_its_log_is_read_in_python(session, need):
    """Every message but a tool's, of two fingers and of a body that moves and rings, as Python reads what C++ wrote."""
    need("wobbling/servo")
    session.ended("--path", "lift", "--fingers", "2", "--lockstep", "--seconds", "0.6", *QUIET,
                  scene="tests/firmware/wobble.toml")
    from haptable.messages import CHANNELS
    heard = {channel: [event.message for event in session.log() if event.channel == channel] for channel in CHANNELS}
    silent = {channel for channel, messages in heard.items() if not messages and channel[-1] not in "345678"}
    assert silent == {"HAPTABLE_POSE", "HAPTABLE_WRENCH"}
    forces = np.float32([message.force_n for message in heard["HAPTABLE_FORCE_2"]])
    rows = session.csv("servo")
    assert forces.any() and np.isin(forces[:, 2], rows["force_z2"].astype(np.float32)).all()
    assert any(message.count for message in heard["HAPTABLE_CONTACT_2"])
    assert heard["HAPTABLE_MODES"][-1].count > 0


def test_five_fingers_press_are_drawn_and_give_the_same_again(session, need):
    need("cube-hand/servo", "bin/haptable-view")
    summary = session.ended("--path", "poke", "--lockstep", "--draw", "pictures", "--json", scene="meshes/cube-hand.toml")
    assert summary["trouble"] == "none" and summary["unanswered_5"] == 0
    for finger in ("", "_2", "_3", "_4", "_5"):
        assert summary["contact_ticks" + finger] > 300 and summary["largest_force_n" + finger] > 0.1
    rows = session.csv("servo")
    assert rows["force_y5"].max() > 0.1 and len(session.csv("device_5")) == summary["ticks_5"]
    assert len(list((session.folder / "out/pictures").glob("*.png"))) == 8
    # Its log, and its own record as a path, give the same forces again.
    servo = [BUILT / "cube-hand/servo", "--quiet", "--replay"]
    done([*servo, session.folder / "out/session.lcmlog", "--check", "--out", session.folder / "again.csv"])
    done([*servo, session.folder / "out/servo.csv", "--out", session.folder / "path.csv"])
    for name in ("again", "path"):
        same = read_csv(session.folder / f"{name}.csv")
        assert all((same[f"force_{axis}{n}"] == rows[f"force_{axis}{n}"]).all() for axis in "xyz" for n in ("", "2", "5"))
    # A path of two fingers is felt there too; one of more than the scene has is told.
    (session.folder / "six.csv").write_text(",".join(f"{axis}{n}" for n in ("", *"23456") for axis in "xyz") + "\n"
                                         + ",".join(["0.1"] * 18) + "\n")
    refused = run([*servo, session.folder / "six.csv", "--out", session.folder / "no.csv"])
    assert refused.status != 0 and "fingers = 6" in refused.err


def test_a_tool_is_turned_drawn_and_read_in_python(session, need):
    need("liver-spatula/servo", "bin/haptable-view")
    summary = session.ended("--path", "roll", "--lockstep", "--draw", "pictures", "--json",
                            scene="meshes/liver-spatula.toml")
    assert summary["trouble"] == "none" and summary["contact_ticks"] > 500 and summary["largest_depth_m"] > 0.002
    log = list(session.log())
    poses, wrenches = ([event.message for event in log if event.channel == channel]
                       for channel in ("HAPTABLE_POSE", "HAPTABLE_WRENCH"))
    assert min(len(poses), len(wrenches)) > 0.9 * summary["ticks"] and wrenches[0].count == 12
    assert session.json("device")["largest_torque_n_m"] > 1e-3
    assert np.ptp([pose.turn[1] for pose in poses]) > 0.1  # turned about x, to both sides
    rows = session.csv("servo")
    assert np.isin(np.float32([wrench.torque_n_m[0] for wrench in wrenches]), rows["torque_x"].astype(np.float32)).all()
    assert max(sum(wrench.touches) for wrench in wrenches) > 6
    assert len(list((session.folder / "out/pictures").glob("*.png"))) > 20


def test_counts_the_ticks_that_its_record_lacks(session):
    """A logger that is kept from its socket loses ticks, and the summary says how many."""
    process = session.begun("--seconds", "600", "--draw", "nothing", "--lockstep")
    process.send_signal(signal.SIGSTOP)
    time.sleep(1)  # servo and device go on, by thousands of ticks
    process.send_signal(signal.SIGCONT)
    session.wait_for_record(10_000_000)
    assert ends(process, by=signal.SIGINT) == 130
    summary = session.json("summary")
    assert summary["unrecorded_ticks"] > 0
    assert summary["ticks"] == len(session.csv("session"))
    assert summary["unrecorded_ticks"] == session.json("servo")["ticks"] - summary["ticks"] + summary["unanswered"]


@pytest.mark.parametrize("at, misses", [("0.1,0.1,0.1", True), ("0.015,0.015,0.03", False)])
def test_says_that_the_finger_never_met_the_body(session, at, misses):
    """The summary says where the body is that the finger never met."""
    summary = session.ended("--path", "poke", "--lockstep", *QUIET, "--", "--at", at)
    where = "the touchable surface lies in (0 0 0) to (0.03 0.03 0.03) m"
    assert summary.get("never_met", "") == (where if misses else "")
    assert (summary["contact_ticks"] == 0) == misses


@pytest.mark.parametrize("quiet", [False, True])
def test_shows_what_the_programs_tell(session, quiet):
    """What servo and device tell their user is beside the status lines, with its time, and in the report."""
    told = "m rejected, no force: it is not a number"
    session.ended("--path", "poke", "--draw", "nothing", "--lockstep", "--fault", "nan=0.01", "--seed", "2",
                  *(["--quiet"] if quiet else []))
    lines = session.said().splitlines()
    assert any(" s  servo: position " in line and line.endswith(told) for line in lines) != quiet
    assert (not lines) == quiet
    # Its closing lines: the paper's point is not what most people want to feel.
    assert (b'contact = { force = "pressure-mask"' not in session.read("stdout")) == quiet
    page = session.read("out/report.html").decode()
    assert " s</th><td>servo: position " in page and told + "</td>" in page


@pytest.mark.parametrize("lockstep", [True, False])
def test_draws_while_it_runs(session, lockstep):
    """Live, the viewer listens before the device begins: a session in lockstep, over in some 50 ms, has a picture too."""
    summary = session.ended("--path", "poke", "--seconds", "1", "--draw", "live", "--every", "400",
                            *(["--lockstep"] if lockstep else []))
    session.expect_whole_record()
    assert summary["trouble"] == "none"
    pictures = [file for file in (session.folder / "out/pictures").iterdir() if file.name != ".haptable"]
    assert all(file.read_bytes()[1:4] == b"PNG" for file in pictures)
    # One each 400 ms of the session's time, which a busy machine may stretch; not one each 33.
    assert 1 <= len(pictures) <= summary["wall_s"] / 0.4 + 2


def test_shows_faults_that_were_asked_for(session):
    """In real time, between programs: the report shows what the device was made to do."""
    session.ended("--seconds", "1", "--draw", "nothing", "--fault", "drop=0.2,gone=0.01:30ms", "--seed", "5")
    session.expect_whole_record()
    # How many ticks a device in real time has is the machine's matter; that some were lost is the faults'. What is
    # published is answered: they lose messages within the device.
    servo = session.json("servo")
    assert servo["lost_states"] > 0 and servo["silences"] > 0
    assert b"lost_states" in session.read("out/report.html")


def test_a_servo_that_dies_is_named_and_leaves_a_valid_record(session):
    process = session.begun(*LONG)
    os.kill(session.child_of(process, "cube/servo"), signal.SIGKILL)
    assert ends(process) == 1
    assert session.said().count("\n") == 1 and "servo was ended by signal 9 (Killed)" in session.said()
    session.expect_whole_record()


def test_a_device_that_refuses_has_the_last_word(session):
    """What it said before its end is the reason that the user reads."""
    assert ends(session.start(session.command("--path", "no-such-path", *QUIET))) == 1
    assert '"no-such-path" is not known' in session.said()


@pytest.mark.parametrize("words", [
    *(f"device meshes/cube.toml --{option} none" for option in ("path", "hand", "device", "driver", "fault")),
    "run meshes/cube.toml -o a --draw none", *(f"view build/cube --mesh -o none.png --{o} none" for o in ("up", "color"))])
def test_what_an_options_reader_refuses_is_a_bad_command_line(words):
    outcome = run([program("haptable-" + words.split()[0]), *words.split()[1:], "--quiet"])
    assert outcome.status == 2 and outcome.err.count("\n") == 1, outcome


def test_a_full_disk_is_said_and_leaves_a_valid_record(session):
    """RLIMIT_FSIZE stands for the full disk: a write takes a part, and then none."""
    words = " ".join(session.command(*LONG))
    assert ends(session.start(["bash", "-c", f"trap '' XFSZ; ulimit -f 500; exec {words}"])) == 1
    assert "session.lcmlog: cannot be written" in session.said()
    session.expect_whole_record()


def test_a_full_tmpfs_is_said_and_leaves_a_valid_record(session):
    """The same on a disk that is full, all files at once: a megabyte of memory, in a mount namespace."""
    if run("unshare -rm mount -t tmpfs none /mnt").status != 0:
        pytest.skip("no mount namespaces for this user: a disk of a megabyte cannot be tried")
    disk = session.folder / "disk"
    disk.mkdir()
    process = session.start(["unshare", "-rm", "sh", "-c", f"mount -t tmpfs -o size=1m none {disk}; "
                             f"{program('haptable-run')} meshes/cube.toml -o {disk}/out --no-realtime --lockstep "
                             f"{' '.join(LONG)}; status=$?; cp -r {disk}/out {session.folder}; exit $status"])
    assert ends(process) == 1
    assert session.said().count("\n") == 1 and "cannot be written" in session.said()
    assert len(session.log()) > 100
    for name in ("servo", "device"):
        assert session.read(f"out/{name}.csv").endswith(b"\n")


def test_killed_it_leaves_no_program_a_valid_log_and_a_folder_that_is_written_again(session):
    """It leaves no lock, and files that are half are replaced."""
    process = session.begun(*LONG)
    children = [session.child_of(process, name) for name in ("cube/servo", "haptable-device")]
    ends(process, by=signal.SIGKILL)
    assert wait_until(lambda: not any(map(is_running, children)))
    assert len(session.log()) > 100
    left = session.folder / "out/servo.csv.haptable-999999999"
    left.write_text("half")
    session.ended("--seconds", "0.3", "--lockstep", *QUIET)
    assert session.json("device")["ticks"] == 300
    assert not left.exists()


def test_the_second_into_a_folder_is_told_and_ctrl_c_leaves_a_valid_record(session):
    first = session.begun(*LONG)
    second = run(session.command("--seconds", "0.1", "--draw", "nothing"))
    assert second.status == 1
    assert f"out: process {first.pid} is writing it" in second.err
    assert ends(first, by=signal.SIGINT) == 130, session.said()
    session.expect_whole_record()
    assert session.json("summary")["trouble"] == "ended by Ctrl-C"


def test_files_of_others_stay(session):
    """A folder of pages with pictures, and one of tables: neither is a session's."""
    picture, tables = session.folder / "out/pictures/a.png", session.folder / "tables"
    picture.parent.mkdir(parents=True)
    picture.write_text("the user's")

    def refused(out) -> str:
        outcome = run([program("haptable-run"), "meshes/cube.toml", "--seconds", "0.1", "--draw", "nothing", "-o", out])
        assert outcome.status == 1
        return outcome.err

    assert "out: holds files that haptable did not write" in refused(session.folder / "out")
    assert picture.read_text() == "the user's"
    done([program("haptable-precompute"), "meshes/cube.toml", "--quiet", "-o", tables])
    before = session.read("tables/summary.json")
    assert "tables: holds haptable's tables, not session" in refused(tables)
    assert session.read("tables/summary.json") == before


def test_serves_a_target_in_qemu(session, need):
    need("cube/firmware/cortex-m7/loop.elf")
    summary = session.ended("--path", "poke", "--target", "cortex-m7", "--lockstep", "--seconds", "0.3", *QUIET)
    session.expect_whole_record()
    assert (summary["servo_on"], summary["ticks"], summary["unanswered"]) == ("cortex-m7", 300, 0)
    assert not (session.folder / "out/to-target").exists()


@pytest.mark.parametrize("words, option", [
    ([program("haptable-device"), "meshes/cube.toml", "--path", "{path}", "--csv", "{path}"], "--path"),
    ([program("haptable-run"), "meshes/cube.toml", "-o", "{folder}", "--path", "{path}"], "--path"),
    ([BUILT / "cube/servo", "--replay", "{path}", "--out", "{folder}/../out/device.csv"], "--replay")],
    ids=["device", "run", "servo"])
def test_a_path_that_would_be_replaced_is_an_error(session, words, option):
    """The record of a session is the path of the next, but not in the folder where it is, by whatever name."""
    path = session.folder / "out/device.csv"
    path.parent.mkdir()
    path.write_text("x,y,z\n0,0,1\n")
    outcome = run([str(word).format(path=path, folder=path.parent) for word in words])
    assert outcome.status == 1 and f"device.csv: is what {option} reads" in outcome.err
    assert path.read_text() == "x,y,z\n0,0,1\n"


def test_a_scene_without_a_servo_names_the_command(session):
    """Away from haptable's folder there is no make: the command is said."""
    (session.folder / "a.toml").write_text(
        'name = "not-built"\n[mesh]\ngenerate = "cube"\n[material]\nyoung = 1e4\npoisson = 0.3\n'
        "[[fixed]]\nbox = [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]\n")
    outcome = run([program("haptable-run"), "a.toml", "-o", "out"], session.folder)
    assert outcome.status == 1 and "make scene SCENE=a.toml" in outcome.err
    assert not (session.folder / "out").exists()
