# SPDX-License-Identifier: GPL-2.0-or-later
"""The firmware as its reader meets it: the example of its header, the program of its README, and the rooms of its files."""

import re
import shutil

import pytest
from programs import BOARD, ROOT, Outcome, done, expect_flash, run

FIRMWARE = ROOT / "firmware"

# What the reader of the header has to bring: 200 ticks down into the top of the cube; the last force is printed.
DEVICE = """#include <stdint.h>
#include <stdio.h>
static uint32_t tick;
static float last_n;
int device_read(int finger, float x[3]) {
    x[0] = 0.0131f; x[1] = 0.0172f; x[2] = 0.031f - 1e-5f * (float)tick;
    return finger == 0;
}
void device_write(int finger, const float f[3]) { (void)finger; last_n = f[2]; }
int device_wait(uint32_t* now_us) {
    *now_us = 1000u * ++tick;
    if (tick == 200) printf("%.9g\\n", (double)last_n);
    return tick < 200;
}
"""

# And of the README, besides.
TIMER = BOARD + """uint32_t clock_us(void) { return 0; }
void timer_interrupt(void);
void timer_start_1khz(void) { timer_interrupt(); }
void timer_clear(void) {}
"""


def test_the_headers_example_runs_as_it_stands(tmp_path, need):
    cube = need("cube/model.c").parent
    for file in ("model.c", "model.h"):
        shutil.copy(cube / file, tmp_path)
    # The lines of its first comment that are indented as code is.
    comment = (FIRMWARE / "haptable.h").read_text().split("*/")[0]
    (tmp_path / "main.c").write_text("\n".join(
        line[7:] for line in comment.splitlines() if line == " *" or line.startswith(" *     ")))
    (tmp_path / "device.c").write_text(DEVICE)
    done("gcc -std=c99 -O1 -pedantic -Wall -Wextra -Wno-maybe-uninitialized -Werror -ffp-contract=off "
         f"-I{FIRMWARE} -I. *.c {FIRMWARE}/*.c -o program", tmp_path)
    assert float(done("./program", tmp_path)) > 0.01, "it presses back"


def test_the_header_is_all_that_a_board_calls():
    code = "".join((FIRMWARE / file).read_text().split("*/", 1)[1] for file in ("haptable.h", "haptable_types.h"))
    functions = set(re.findall(r"\n(?:static inline )?[a-z][a-z0-9_ *]*[ *](haptable_[a-z_]+)\(", code))
    assert {"haptable_step", "haptable_line"} <= functions and len(functions) <= 12
    assert len(set(re.findall("struct (haptable_[a-z_]+)", code))) <= 10
    # The packages' and README's programs call nothing else.
    for file in ("firmware/README.md", "packaging/boards/arduino/examples/Touch/Touch.ino",
                 "packaging/boards/examples/stm32f4.c", "packaging/boards/examples/rp2350.c"):
        assert set(re.findall(r"\b(haptable_[a-z_]+)\(", (ROOT / file).read_text())) <= functions, file


def test_the_readmes_program_compiles_and_links_without_a_library(tmp_path, need):
    if not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("arm-none-eabi-gcc is not installed")
    cube, app, project = need("cube/model.c").parent, tmp_path / "app", tmp_path / "project"
    text = (FIRMWARE / "README.md").read_text()

    def block(language: str) -> str:
        return text.split(f"```{language}\n", 1)[1].split("```", 1)[0]

    app.mkdir()
    (app / "main.c").write_text(block("c"))
    (app / "device.c").write_text(TIMER)
    # The project's path: the folder of this source, with this build's tables.
    (project / "build").mkdir(parents=True)
    (project / "firmware").symlink_to(FIRMWARE)
    (project / "build/cube").symlink_to(cube)
    compiled = run(f"HAPTABLE='{project}'\nset -e\n{block('sh')}", app)
    assert compiled.status == 0 and compiled.err == "", compiled.err
    done("arm-none-eabi-gcc -mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard -nostdlib -Wl,--gc-sections "
         "-Wl,-e,main ./*.o -o app.elf", app)
    expect_flash(app, "app.elf")


def rooms(folder, more: dict) -> Outcome:
    """What rooms.sh says of a copy of the firmware with more text at the end of files."""
    copy = folder / "firmware"
    shutil.copytree(FIRMWARE, copy)
    for file, text in more.items():
        with open(copy / file, "a") as end:
            end.write(text)
    return run("sh scripts/rooms.sh", FIRMWARE=str(copy))


WORK = ("#ifndef HAPTABLE_WORK\n#define HAPTABLE_WORK\nstatic inline int work(int a) {\n    a += a;\n    return a;\n}\n"
        "#endif\n")
CALL = "int haptable_call(void);\nint haptable_call(void) { return work(1); }\n"
UP = ("void haptable_up(struct haptable_servo* servo);\n"
      "void haptable_up(struct haptable_servo* servo) { haptable_servo_init(servo); }\n")


@pytest.fixture(scope="module")
def not_kept(tmp_path_factory) -> Outcome:
    """Rooms with every fault but a circle, which an arrow up makes too."""
    return rooms(tmp_path_factory.mktemp("rooms"), {
        "haptable_hinge.c": '#include "haptable_contact.h"\n', "haptable_limit.c": UP, "haptable_contact.h": WORK,
        "haptable_servo.c": CALL, "haptable_new.h": "\n"})


@pytest.mark.parametrize("says", [
    "hinge (surface) includes contact, which is above it (contact)",
    "limit (guard) calls haptable_servo_init of servo, which is above it (step)",
    "servo (step) calls work() of a header of contact: move it into a .c file",
    "haptable_new.h is in no room of rooms.txt"], ids=["include_goes_up", "call_goes_up", "work_for_another", "no_room"])
def test_a_room_that_is_not_kept_is_told(not_kept, says):
    assert not_kept.status == 1 and says in not_kept.err


def test_files_that_include_each_other_are_told(tmp_path):
    found = rooms(tmp_path, {"haptable_surface.c": '#include "haptable_side.h"\n'})
    assert found.status == 1 and "a circle of files: surface side" in found.err


def test_rooms_are_kept_by_headers_that_work_for_their_own_and_by_those_with_a_star(tmp_path):
    found = rooms(tmp_path, {"haptable_contact.h": WORK, "haptable_friction.c": CALL,
                             "haptable_vector.h": WORK.replace("WORK", "MORE").replace("work", "more"),
                             "haptable_servo.c": CALL.replace("work", "more").replace("_call", "_more")})
    assert found.status == 0 and "\ncoupling " in found.out, found.err
