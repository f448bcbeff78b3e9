# SPDX-License-Identifier: GPL-2.0-or-later
"""A session in real time beside one with a servo that does nothing, on a quiet machine and on a busy one: what the loop
adds to what LCM and the kernel take. `make bench-realtime`."""

import os
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lab import LabError, build, say, scenes, told
from lab.numbers import Topics, count, number, percent, table, write_topics
from lab.reference import Array

_BEGUN = 100  # ticks: the first state waits for the servo's start
_SHARES = (0.5, 0.99, 0.999, 1.0)


@dataclass
class Times:
    """us, but for unheard: states that the ear missed."""

    period: Array  #: from state to state
    latency: Array  #: from state to answer
    age: Array  #: when a state is sent, how long ago that one was sent which the newest answer until then belongs to
    unheard: int = 0


def times_of(sent: Sequence[int], answered: Sequence[int]) -> Times:
    """sent, answered: us by sequence number; 0 where it was not heard."""
    begun, end = np.array(sent, float), np.array(answered, float)
    now, before, answer = begun[_BEGUN:], begun[_BEGUN - 1:-1], end[_BEGUN:]
    heard = (now > 0) & (before > 0)
    # Whose answer acts as a state is sent: the newest state's that was answered until then.
    order = np.flatnonzero(end)[np.argsort(end[end > 0], kind="stable")]
    newest = np.maximum.accumulate(np.append(_BEGUN - 1, order))[np.searchsorted(end[order], now, "right")]
    return Times((now - before)[heard], (answer - now)[heard & (answer > 0)],
                 (now - begun[newest])[heard & (begun[newest] > 0)], int((~heard).sum()))


def _processor_time() -> tuple[float, float, float]:
    """s of all processors; busy, a virtual machine's stolen time too; of this program and its children that ended."""
    user, nice, system, idle, wait, *rest = map(int, Path("/proc/stat").read_text().split("\n")[0].split()[1:9])
    tick, busy = 1.0 / os.sysconf("SC_CLK_TCK"), user + nice + system + sum(rest)
    return (busy + idle + wait) * tick, busy * tick, sum(os.times()[:4])


@dataclass
class Session:
    times: Times
    device: dict[str, Any]  #: what haptable-device counted
    others: float  #: share of the processors' time that other programs took


def _end(program: subprocess.Popen[bytes], what: str) -> None:
    if program.poll() is not None:
        raise LabError(f"{what}: ended before the session, with status {program.returncode}")
    program.send_signal(signal.SIGINT)
    try:
        program.wait(10)
    except subprocess.TimeoutExpired as error:
        raise LabError(f"{what}: does not end") from error


def _kill(*programs: subprocess.Popen[bytes]) -> None:
    for program in programs:
        program.kill()
        program.wait()


def session(partner: Sequence[object], scene: Path, seconds: float) -> Session:
    """Of the simulated device with that servo."""
    before = _processor_time()
    with tempfile.TemporaryFile() as heard:
        ear = subprocess.Popen([build() / "bin/haptable-bench-realtime"], stdout=heard)
        servo = subprocess.Popen([str(word) for word in partner], stdout=subprocess.DEVNULL)
        try:
            device = told("haptable-device", scene, "--path", "poke,drag,circle", "--seconds", seconds, "--json",
                          "--quiet")
            _end(servo, "servo")
            _end(ear, "haptable-bench-realtime")
        finally:
            _kill(servo, ear)
        heard.seek(0)
        wire = np.loadtxt(heard, dtype=np.int64, delimiter=",", skiprows=1, ndmin=2).reshape(-1, 2)
    whole, busy, ours = (b - a for a, b in zip(before, _processor_time()))
    others = min(max((busy - ours) / max(whole, 1e-3), 0.0), 1.0)
    return Session(times_of(*wire.T.tolist()), device, others)


def tables(measured: dict[str, dict[str, Session]]) -> Topics:
    """By machine and partner (servo, echo)."""
    times, counts = [], []
    for machine, of in measured.items():
        for what, name in (("from state to state", "period"), ("from state to answer", "latency"),
                           ("age of the force", "age")):
            us = {partner: np.quantile(getattr(of[partner].times, name), _SHARES, method="higher")
                  for partner in ("servo", "echo")}
            times += [[machine, what, partner, *(number(1e-6 * v, f"{v:.0f} us") for v in us[partner])]
                      for partner in us]
            times.append([machine, what, "ratio", *(number(r, "{:.2f}") for r in us["servo"] / us["echo"])])
        counts += [[machine, partner,
                    *(count(of[partner].device[name]) for name in ("ticks", "missed", "late_ticks", "silences")),
                    count(of[partner].times.unheard), percent(of[partner].others)] for partner in ("servo", "echo")]
    return {"realtime": table("machine | what | with | median | 99 % | 99.9 % | worst", times),
            "realtime-counts": table("machine | with | ticks | without an answer in time | begun more than 1 ms late | "
                                     "silences | not heard by the bench | processors' time that others took", counts)}


def make(scene: Path, out: Path, seconds: float = 60.0) -> None:
    """The loop in real time beside one whose servo does nothing: four sessions of so many seconds. Busy: as many
    programs that never rest as there are processors, niced: who asks for real time does not feel the difference, and
    others on this machine do."""
    partners = {"echo": [build() / "bin/haptable-bench-realtime", "--echo"],
                "servo": [build() / scenes.read(scene)["name"] / "servo", "--lcm", "--quiet"]}
    measured: dict[str, dict[str, Session]] = {}
    for machine in ("quiet", "busy"):
        load = [subprocess.Popen(["nice", "-n", "19", "sh", "-c", "while :; do :; done"])
                for _ in range((os.cpu_count() or 1) if machine == "busy" else 0)]
        try:
            for partner, command in partners.items():
                say(f"real time: {machine}, {partner}")
                measured.setdefault(machine, {})[partner] = session(command, scene, seconds)
        finally:
            _kill(*load)
    write_topics(out, tables(measured), "make bench-realtime")
