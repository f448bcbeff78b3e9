# SPDX-License-Identifier: GPL-2.0-or-later
"""Sessions in real time: what is made of the times on the wire, and a session from end to end."""

import os
import subprocess

import numpy as np
import pytest
from lab import LabError, realtime
from lab.numbers import texts

BEGIN = 1_000_000  # us


def _wire(ticks, answer_us=30):
    """States a millisecond apart, each answered after answer_us."""
    sent = [BEGIN + 1000 * k for k in range(ticks)]
    return sent, [t + answer_us for t in sent]


def test_a_force_is_as_old_as_the_state_that_it_answers():
    times = realtime.times_of(*_wire(200))
    assert set(times.period) == {1000.0}
    assert set(times.latency) == {30.0}
    assert set(times.age) == {1000.0}
    assert (len(times.age), times.unheard) == (100, 0), "the first ticks wait for the servo's start"


def test_a_late_answer_leaves_the_one_before_in_force():
    sent, answered = _wire(200)
    answered[150] = sent[152] + 10
    ages = dict(zip(range(100, 200), realtime.times_of(sent, answered).age))
    assert [ages[k] for k in (150, 151, 152, 153)] == [1000.0, 2000.0, 1000.0, 1000.0]


def test_what_the_ear_missed_is_counted_and_not_measured():
    sent, answered = _wire(200)
    sent[150] = 0
    answered[160] = 0
    times = realtime.times_of(sent, answered)
    assert times.unheard == 2, "no period from it, none to it"
    assert len(times.latency) == 100 - 2 - 1
    assert max(times.period) == 1000.0


def test_tables_tell_the_ratio_of_servo_and_echo():
    def session(answer_us):
        device = {"ticks": 200, "missed": 1, "late_ticks": 0, "silences": 0}
        return realtime.Session(realtime.times_of(*_wire(200, answer_us)), device, 0.25)
    tables = realtime.tables({"quiet": {"servo": session(60), "echo": session(30)}})
    rows = texts(tables["realtime"])
    assert ["quiet", "from state to answer", "servo", *["60 us"] * 4] in rows
    assert ["quiet", "from state to answer", "ratio", *["2.00"] * 4] in rows
    assert texts(tables["realtime-counts"])[0][-1] == "25 %"


# A device believes an answer of its own model alone: an echo without one is never heard.
def test_a_session_with_an_echo_ends_well_and_is_heard(need, build):
    need("bin/haptable-bench-realtime", "cube/servo")
    bench = build / "bin/haptable-bench-realtime"
    code = ("import sys; from pathlib import Path; from lab import realtime; "
            f"s = realtime.session(['{bench}', '--echo'], Path('meshes/cube.toml'), 0.5); "
            "print(s.device['ticks'], len(s.times.latency))")
    ended = subprocess.run(["sh", "scripts/loopback.sh", "/usr/bin/env", "python3", "-c", code], capture_output=True,
                           text=True, check=False, env={**os.environ, "PATH": f"/usr/bin:{os.environ['PATH']}"})
    if ended.returncode == 77:
        pytest.skip(ended.stderr)
    assert ended.returncode == 0, ended.stderr
    ticks, answered = map(int, ended.stdout.split())
    assert 0 < answered <= ticks


def test_a_partner_that_ends_before_the_session_is_an_error_that_names_it():
    program = subprocess.Popen(["false"])
    program.wait()
    with pytest.raises(LabError, match="servo: ended before the session, with status 1"):
        realtime._end(program, "servo")


def test_processor_time_of_others_is_no_negative_share():
    whole, busy, ours = realtime._processor_time()
    assert whole >= busy > 0.0
    assert ours > 0.0
    assert np.isfinite([whole, busy, ours]).all()
