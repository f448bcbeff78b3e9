# SPDX-License-Identifier: GPL-2.0-or-later
"""Programs that tests run, and what these write: none outlives its test, and one that hangs fails it."""

from __future__ import annotations

import contextlib
import fcntl
import functools
import importlib.util
import os
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("BUILD") or "build")  # as make has it: from the root
BUILT = ROOT / BUILD
SHARED = ROOT.parent / "shared"
PATIENCE_S = 600.0
#: 60 ticks straight down into the top of meshes/cube.toml, 3.9 mm deep.
PRESS = "x,y,z\n" + "".join(f"0.015,0.015,{np.float32(0.032) - np.float32(1e-4) * np.float32(tick):.9g}\n"
                            for tick in range(60))
TABLE_BYTES, MOST_CODE_BYTES = 6752, 21100  # of the cube
# What the reader of a board's example has to bring.
BOARD = """#include <stdint.h>
int device_read(float x[3]) { x[0] = x[1] = x[2] = 0.0f; return 1; }
volatile float motor;
void device_write(const float f[3]) { motor = f[0]; }
"""
# Zephyr's and ESP-IDF's own functions are not here: in their place ones that look at every file.
LOOK = """
function(look)
foreach(file ${ARGN})
if(NOT EXISTS ${file})
message(FATAL_ERROR "no ${file}")
endif()
math(EXPR n "${n} + 1")
endforeach()
message(STATUS "${n} files")
endfunction()
foreach(name zephyr_library_named zephyr_library_compile_options target_compile_options)
function(${name})
endfunction()
endforeach()
foreach(name zephyr_include_directories zephyr_library_sources)
function(${name})
look(${ARGV})
endfunction()
endforeach()
function(idf_component_register)
cmake_parse_arguments(A "" "" "SRCS;INCLUDE_DIRS" ${ARGN})
list(TRANSFORM A_SRCS PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
look(${A_SRCS})
endfunction()
"""

sys.path.insert(0, str(BUILT / "python/types"))  # haptable.messages
_files = importlib.util.spec_from_file_location("haptable_files", ROOT / "python/haptable/_files.py")
_module = importlib.util.module_from_spec(_files)
_files.loader.exec_module(_module)
read_csv, read_log = _module.read_csv, _module.read_log


def program(name: str) -> str:
    return str(BUILT / "bin" / name)


class Outcome(NamedTuple):
    """How a program ended; a negative status is the signal that ended it."""

    status: int
    out: str
    err: str


def _end(process: subprocess.Popen) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def run(command, folder=ROOT, patience_s: float = PATIENCE_S, **env) -> Outcome:
    """A command of the shell, or a list of words. Killed after its patience, with all that it started: then it fails."""
    words = ["sh", "-c", command] if isinstance(command, str) else [str(word) for word in command]
    process = subprocess.Popen(words, cwd=folder, env={**os.environ, **env}, text=True, errors="surrogateescape",
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    try:
        out, err = process.communicate(timeout=patience_s)
    except subprocess.TimeoutExpired:
        _end(process)
        raise AssertionError(f"killed, it had not ended after {patience_s:g} s: {command}") from None
    except BaseException:
        _end(process)
        raise
    return Outcome(process.returncode, out, err)


def done(command, folder=ROOT, **how) -> str:
    """The output of a command that must succeed."""
    outcome = run(command, folder, **how)
    assert outcome.status == 0, f"{command}\n{outcome.out}{outcome.err}"
    return outcome.out


@contextlib.contextmanager
def one_make():
    """make of this tree, one at a time: two would make the same file."""
    (BUILT / "tests").mkdir(parents=True, exist_ok=True)
    with open(BUILT / "tests/make.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def make(words: str, folder=ROOT) -> Outcome:
    with one_make():
        return run(f"make -s {words} BUILD={BUILD}", folder)


@functools.cache
def haptable_package():
    """The Python package on this tree's library, with the messages that tests read by the same name."""
    from lab import binding
    for name in [name for name in sys.modules if name.split(".")[0] == "haptable"]:  # its messages, without the package
        del sys.modules[name]
    package = binding.load(BUILT)
    package.__path__.append(str(BUILT / "python/types/haptable"))
    return package


def servo_of(scene: Path, name: str) -> Path:
    """The servo of a scene of that name, as make scene leaves it in the build's folder."""
    made = make(f"scene-alone SCENE={scene}")
    assert made.status == 0, made.out + made.err
    return BUILT / name / "servo"


class Programs:
    """Programs beside a test; the fixture `start` ends those that are left."""

    def __init__(self) -> None:
        self._all = []

    def __call__(self, words, folder=ROOT, out=os.devnull, err=None) -> subprocess.Popen:
        with open(out, "wb") as to, open(err, "wb") if err else contextlib.nullcontext() as complaints:
            process = subprocess.Popen([str(word) for word in words], cwd=folder, stdout=to, stderr=complaints,
                                       start_new_session=True)
        self._all.append(process)
        return process

    def end(self) -> None:
        for process in self._all:
            if process.poll() is None:
                _end(process)


def ends(process: subprocess.Popen, by: int = 0) -> int:
    """Its exit status, where it ends by itself or `by` a signal."""
    if by:
        process.send_signal(by)
    return process.wait(PATIENCE_S)


def wait_until(condition, patience_s: float = 60.0) -> bool:
    give_up = time.monotonic() + patience_s
    while not (met := condition()) and time.monotonic() < give_up:
        time.sleep(0.02)
    return bool(met)


class Listener:
    """What is said on LCM's UDP multicast, in messages that fit a packet (the format: lcm/lcm_internal.h, "LC02")."""

    def __init__(self, url: str) -> None:
        group, port = url.split("//")[1].split("?")[0].split(":")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self._socket.bind((group, int(port)))
        member = struct.pack("=4sl", socket.inet_aton(group), socket.INADDR_ANY)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)

    def close(self) -> None:
        self._socket.close()

    def heard(self, channel: str, patience_s: float = 30.0):
        """The messages of a channel, as they come, until none has come for so long."""
        from haptable.messages import CHANNELS
        self._socket.settimeout(patience_s)
        while True:
            packet = self._socket.recv(65536)
            name, _, data = packet[8:].partition(b"\0")
            if packet[:4] == b"LC02" and name == channel.encode():
                yield CHANNELS[channel].decode(data)


def forces(rows) -> np.ndarray:
    """float32 [ticks, 3], N, of the CSV of a servo, a bridge or a device."""
    return np.stack([rows[f"force_{axis}"] for axis in "xyz"], axis=1).astype(np.float32)


def write_program(file: Path, text: str) -> None:
    """A script of the shell."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("#!/bin/sh\n" + text)
    file.chmod(0o700)


def expect_flash(folder: Path, elf: str, more: float = 1.0) -> None:
    """The cube's tables and servo are in a linked program, as the cross tools count it, and nothing that it does not
    name, 3,700 bytes and more."""
    size = int(done(f"arm-none-eabi-size {elf}", folder).splitlines()[1].split()[0])
    assert TABLE_BYTES + 4000 < size < TABLE_BYTES + more * MOST_CODE_BYTES


def finger_path(servo_csv: Path, to: Path) -> None:
    """The finger's path in a servo's CSV, as a replay reads it: the same digits."""
    header, *lines = servo_csv.read_text().splitlines()
    first = header.split(",").index("x")
    to.write_text("x,y,z\n" + "".join(",".join(line.split(",")[first:first + 3]) + "\n" for line in lines))
