# SPDX-License-Identifier: GPL-2.0-or-later
"""The Python package from nothing: a clean venv, pip install ., and its own tests, with a log of every message.
Skipped where PyPI could not be reached (make test makes build/python)."""

import os
import shutil
import struct

from programs import BUILD, done, write_program

PIP = "bin/pip install --quiet --disable-pip-version-check"
#: What a type of message is known by again.
FILLED = {"device_state": {"position_m": [0.25, -0.5, 1.0]}, "servo_force": {"force_n": [0.0, 0.0, 1.5]},
          "body_pose": {"centre_m": [0.0, 0.5, 0.0]}, "body_modes": {"count": 2, "swung": [0.0, 0.75]},
          "contact": {"count": 2, "node": [3, 5], "force_n": [[1, 2, 3], [4, 5, 6]]},
          "servo_status": {"count": 1, "name": ["ticks"], "value": [9]}, "hand_pose": {"turn": [0.5, 0.5, 0.5, 0.5]},
          "tool_wrench": {"torque_n_m": [0.0, 0.25, 0.0], "count": 1, "touches": [1], "point_m": [[1, 2, 4]],
                          "god_object_m": [[1, 2, 3]], "force_n": [[4, 5, 6]]}}


def write_log(file) -> None:
    """A message of every channel, in the order of the list, and one of nobody's."""
    from haptable.messages import CHANNELS
    events = []
    for utime, (channel, message_type) in enumerate(CHANNELS.items(), 1):
        message = message_type()
        message.utime = utime
        for field, value in FILLED[message_type.__name__].items():
            here = getattr(message, field)
            setattr(message, field, value + here[len(value):] if isinstance(value, list) and here else value)
        events.append((channel, message.encode()))
    events.append(("OTHER", b"bytes"))
    file.write_bytes(b"".join(struct.pack(">IqqII", 0xEDA1DA01, number, number + 1, len(channel), len(data)) +
                              channel.encode() + data for number, (channel, data) in enumerate(events)))


def test_passes_its_tests_in_a_clean_venv(tmp_path, need, wheels):
    cube, venv, log = need("cube/servo").parent, tmp_path / "venv", tmp_path / "session.lcmlog"
    done(f"python3 -m venv {venv} && {venv}/{PIP} .", **wheels)
    write_log(log)
    done(f"{venv}/bin/python python/tests/test_haptable.py 2>&1 | tee {tmp_path}/said; ! grep -E 'skipped|FAILED' "
         f"{tmp_path}/said && grep -q '^OK' {tmp_path}/said", HAPTABLE_LOG=str(log), BUILD=str(BUILD))
    # What pip installs of a page's program that hears a session.
    done(f"{venv}/bin/python -c 'from haptable.messages import contact, device_state, servo_force'", tmp_path)
    # The notebook, in a folder with these tables, so that its page does not come into the source tree.
    (tmp_path / "work/build").mkdir(parents=True)
    (tmp_path / "work/build/cube").symlink_to(cube)
    said = done(f"{venv}/{PIP} nbclient ipykernel && {venv}/bin/python python/tests/run_notebook.py "
                f"python/examples/touch.ipynb {tmp_path}/work", **wheels)
    assert said == "5 cells ran\n"
    assert (tmp_path / "work/press.html").exists()


# What make would build is nothing here.
NO_MAKE = """parts=build/package/python
mkdir -p $parts/messages && touch $parts/messages/__init__.py
echo 'int nothing;' | gcc -shared -fPIC -x c - -o $parts/libhaptable.so.1 && ln -sf libhaptable.so.1 $parts/libhaptable.so
"""


def test_installs_in_a_folder_that_was_copied_after_a_build(tmp_path, wheels):
    """setuptools keeps a list of files by their absolute paths."""
    first, copy = tmp_path / "first", tmp_path / "copy"
    write_program(tmp_path / "bin/make", NO_MAKE)
    first.mkdir()
    done("tar cf - python setup.py pyproject.toml docs/PYTHON.md host/base/program.hpp host/library/haptable_library.h "
         f"| tar xf - -C {first} && python3 -m venv {tmp_path}/venv")

    def install(folder) -> None:
        done(f"unset BUILD; {tmp_path}/venv/{PIP} --no-deps .", folder, **wheels,
             PATH=f"{tmp_path}/bin:{os.environ['PATH']}")

    install(first)
    shutil.copytree(first, copy, symlinks=True)
    install(copy)
    shutil.rmtree(first)
    install(copy)
