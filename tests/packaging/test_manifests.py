# SPDX-License-Identifier: GPL-2.0-or-later
"""The firmware as a library of other people's projects: the manifests that are checked in are those of the files that
there are, and a project that has nothing but one line for it and a scene's model.c feels the servo's force."""

import shutil

from programs import LOOK, PRESS, ROOT, done, read_csv

# 60 ticks down into the cube, as in docs/INSTALL.md; the last force as bits.
MAIN = """#include <stdio.h>
#include "haptable.h"
#include "model.h"
int main(void) {
    static HAPTABLE_MODEL_STATE state;
    struct haptable_output out;
    uint32_t tick;
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    for (tick = 0; tick < 60; ++tick) {
        const struct haptable_input in = {{0.015f, 0.015f, 0.032f - 1e-4f * (float)tick}, 0, 1};
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, &in, 1000u * tick, &out);
    }
    printf("%.9g,%.9g,%.9g\\n", (double)out.force_n[0], (double)out.force_n[1], (double)out.force_n[2]);
    return 0;
}
"""


def test_are_those_of_the_files_that_there_are(tmp_path):
    done(f"sh packaging/manifests.sh {tmp_path}")
    files = sorted(str(file.relative_to(tmp_path)) for file in tmp_path.rglob("*") if file.is_file())
    assert files == ["firmware/CMakeLists.txt", "firmware/haptable.haptable.pdsc", "firmware/idf_component.yml",
                     "firmware/library.json", "firmware/library.properties", "firmware/zephyr/CMakeLists.txt",
                     "firmware/zephyr/Kconfig", "firmware/zephyr/module.yml", "library.json", "zephyr/module.yml"]
    for file in files:
        assert (ROOT / file).read_bytes() == (tmp_path / file).read_bytes(), f"{file}: run make manifests"


def test_of_zephyr_and_esp_idf_name_every_file(tmp_path):
    (tmp_path / "lists.cmake").write_text(
        LOOK + "set(CONFIG_HAPTABLE y)\nset(ESP_PLATFORM y)\n"
        "include(${HAPTABLE}/firmware/zephyr/CMakeLists.txt)\ninclude(${HAPTABLE}/firmware/CMakeLists.txt)\n")
    looked = done(f"cmake -DHAPTABLE={ROOT} -P lists.cmake", tmp_path)
    files = f"-- {len(list((ROOT / 'firmware').glob('*.c')))} files\n"
    assert looked == files + "-- 1 files\n" + files


def test_one_line_of_cmake_feels_the_servos_force(tmp_path, need):
    servo = need("cube/servo")
    (tmp_path / "main.c").write_text(MAIN)
    for file in ("model.c", "model.h"):
        shutil.copy(servo.parent / file, tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(app C)\nadd_subdirectory(${HAPTABLE}/firmware haptable)\n"
        "add_executable(app main.c model.c)\ntarget_compile_options(app PRIVATE -ffp-contract=off)\n"
        "target_link_libraries(app PRIVATE haptable::firmware)\n")
    felt = done(f"cmake -S . -B out -DHAPTABLE={ROOT} >/dev/null && cmake --build out >/dev/null && out/app", tmp_path)
    (tmp_path / "path.csv").write_text(PRESS)
    done(f"{servo} --quiet --replay path.csv --out felt.csv", tmp_path)
    last = read_csv(tmp_path / "felt.csv")[-1]
    assert felt == "{:.9g},{:.9g},{:.9g}\n".format(*last[["force_x", "force_y", "force_z"]])
    assert last["force_z"] != 0
