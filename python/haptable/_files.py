# SPDX-License-Identifier: GPL-2.0-or-later
"""What haptable's programs read and write: scenes, CSV, LCM logs."""
from __future__ import annotations

import importlib
import os
import pathlib
import shutil
import struct
import subprocess
from typing import Any, Iterator, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

PathLike = Union[str, "os.PathLike[str]"]

_SYNC = 0xEDA1DA01
_LONGEST_CHANNEL = 63
_HEADER = struct.Struct(">IqqII")


def precompute(scene: PathLike, folder: Optional[PathLike] = None, program: str = "haptable-precompute") -> pathlib.Path:
    """Runs the installed haptable-precompute, which does nothing where the folder holds these tables already. Returns
    the folder, build/NAME where none is given. Raises CalledProcessError, whose stderr says what is wrong, and
    FileNotFoundError where the program is not there."""
    if shutil.which(program) is None:
        raise FileNotFoundError(f"{program}: is not on the PATH: install haptable, or name it by program=")

    def run(*words: str) -> str:
        return subprocess.run([program, os.fspath(scene), *words], check=True, capture_output=True, text=True).stdout
    where = pathlib.Path(folder) if folder is not None else pathlib.Path("build") / run("--print-name").strip()
    run("--quiet", "-o", os.fspath(where))
    return where


def read_csv(file: PathLike) -> NDArray[Any]:
    """A CSV of servo, bridge, device or haptable-run as a structured array, a field a column: int64 where every value
    is a whole number that float64 holds exactly (up to 2^53), otherwise float64. Raises ValueError where it is none.

    >>> import io, tempfile
    >>> with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
    ...     _ = file.write("tick,force_z\\n0,0.5\\n1,0.25\\n")
    ...     file.flush()
    ...     read_csv(file.name)["force_z"].tolist()
    [0.5, 0.25]
    """
    with open(file) as lines:
        names = lines.readline().strip().split(",")
        try:
            values = np.loadtxt(lines, delimiter=",", ndmin=2, converters=_number, encoding="utf-8")
        except ValueError as error:
            raise ValueError(f"{os.fspath(file)}: is no CSV of haptable's programs: {error}") from None
    if values.size == 0:
        values = values.reshape(0, len(names))
    if values.shape[1] != len(names):
        raise ValueError(f"{os.fspath(file)}: {values.shape[1]} columns under {len(names)} names")
    whole = [bool(len(values)) and bool(np.all((np.abs(column) <= 2.0**53) & (column == np.floor(column))))
             for column in values.T]
    table = np.empty(len(values), [(name, np.int64 if w else np.float64) for name, w in zip(names, whole)])
    for name, column in zip(names, values.T):
        table[name] = column
    return table


def _number(text: Union[str, bytes]) -> float:
    return float(text) if text.strip() else float("nan")


class LogEvent(NamedTuple):
    """One event of an LCM log."""

    utime: int  #: microseconds, when it was written
    channel: str
    message: Any  #: of haptable.messages for haptable's channels; otherwise bytes


def read_log(file: PathLike) -> Iterator[LogEvent]:
    """The events of an LCM log as lcm-logger and haptable-run write it, in its order. The messages of every channel of
    haptable.messages.CHANNELS are decoded, a second finger's, poses and modes too. Raises ValueError, which names the
    byte, where the file is none, and for a message that is damaged or of another version of its type; what a crash cut
    off at the end is left out."""
    with open(file, "rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        while len(header := stream.read(_HEADER.size)) == _HEADER.size:
            sync, _, utime, channel_length, length = _HEADER.unpack(header)
            begin = stream.tell()
            where = f"{os.fspath(file)}: byte {begin - _HEADER.size}"
            if sync != _SYNC:
                raise ValueError(f"{where} is no event of an LCM log")
            if channel_length > _LONGEST_CHANNEL:
                raise ValueError(f"{where} names a channel of {channel_length} characters: is the log damaged?")
            if begin + channel_length + length > size:
                return
            name, data = stream.read(channel_length), stream.read(length)
            try:
                channel = name.decode()
                message = _decode(channel, data)
            except (ValueError, struct.error, OverflowError, MemoryError) as error:
                raise ValueError(f"{where}: no whole message of this version: is the log damaged? ({error})") from None
            yield LogEvent(utime, channel, message)


def _decode(channel: str, data: bytes) -> Any:
    message = importlib.import_module("haptable.messages").CHANNELS.get(channel)
    return data if message is None else message.decode(data)
