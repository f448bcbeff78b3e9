# SPDX-License-Identifier: GPL-2.0-or-later
"""What Python costs beside C, in one run: a call of step, and a replay against the same loop in C.

python python/tests/measure.py OUT.json [REPETITIONS]: the medians, on build/cube, as numbers for docs/PYTHON.md; from the
project's root, `make library` done. `make bench-ways` calls it."""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import haptable

BUILD = pathlib.Path(os.environ.get("BUILD", "build")).resolve()
LOOP = r"""
#include <haptable_library.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char** argv) {
    const size_t n = (size_t)atol(argv[3]);
    float (*x)[3] = malloc(n * sizeof *x);
    struct haptable_touch* touch = calloc(n, sizeof *touch);
    FILE* in = fopen(argv[2], "rb");
    struct haptable_object* object = haptable_object_load(argv[1], 0);
    struct timespec a, b;
    size_t i;
    if (argc < 4 || fread(x, sizeof *x, n, in) != n) return 1;
    haptable_finger_replay(haptable_finger_new(object), x, n, 0, touch); /* its memory is there */
    struct haptable_finger* finger = haptable_finger_new(object);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
    for (i = 0; i < n; ++i) haptable_finger_step(finger, x[i], 1000 * (uint32_t)i, &touch[i]);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
    printf("%.9g\n", (1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec)) / (double)n);
    return 0;
}
"""


def main() -> None:
    repetitions = int(sys.argv[2]) if len(sys.argv) > 2 else 15
    body = haptable.load(BUILD / "cube")
    phase = np.arange(20000, dtype=np.float32)
    path = np.stack([0.015 + 0.005 * np.sin(1e-3 * phase), 0.015 + 0.005 * np.cos(1e-3 * phase),
                     0.029 + 0.003 * np.sin(7e-3 * phase)], axis=1).astype(np.float32)
    out = np.zeros(len(path), haptable.CONTACT)
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        (work / "loop.c").write_text(LOOP)
        path.tofile(work / "path")
        subprocess.run(["gcc", "-O2", "loop.c", f"-I{pathlib.Path('host/library').resolve()}", f"-L{BUILD / 'lib'}",
                        "-lhaptable", f"-Wl,-rpath,{BUILD / 'lib'}", "-o", "loop"], cwd=work, check=True)
        in_c, replay, step = [], [], []
        for _ in range(repetitions):  # one after the other, so that a busy machine is as busy for all
            in_c.append(float(subprocess.run([work / "loop", BUILD / "cube", work / "path", str(len(path))], check=True,
                                             capture_output=True, text=True).stdout))
            body.servo().replay(path, out)
            servo = body.servo()
            begin = time.process_time_ns()
            servo.replay(path, out)
            replay.append((time.process_time_ns() - begin) / len(path))
            servo, rows = body.servo(), list(path)
            begin = time.process_time_ns()
            for row in rows:
                servo.step(row)
            step.append((time.process_time_ns() - begin) / len(path))
    c, r, s = (statistics.median(ns) for ns in (in_c, replay, step))
    rows = [["`haptable_finger_step` in a C loop", tick_of(c), ""], ["`Servo.replay`", tick_of(r), ratio(r / c)],
            ["`Servo.step`", tick_of(s), ratio(s / c)]]
    topic = {"command": "make bench-ways", "machine": machine(), "columns": ["a tick", "processor time", "of C's"],
             "rows": rows}
    pathlib.Path(sys.argv[1]).write_text(json.dumps({"python": topic}, indent=1) + "\n")


def tick_of(ns: float) -> dict:
    return {"value": 1e-9 * ns, "text": f"{ns:.0f} ns" if ns < 1000 else f"{1e-3 * ns:.2g} us"}


def ratio(value: float) -> dict:
    return {"value": value, "text": f"{value:.2f}" if value < 10 else f"{value:.0f}"}


def machine() -> str:
    with open("/proc/cpuinfo") as cpu:
        model = next((line.split(": ", 1)[1].strip() for line in cpu if line.startswith("model name")), "unknown")
    return f"{os.cpu_count()} x {model}"


main()
