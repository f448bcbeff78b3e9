# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene as a library for other people's projects: one list of files, each kind taken in as its own tools would."""

import shutil
import xml.etree.ElementTree as tree

import pytest
from programs import BOARD, BUILT, LOOK, ROOT, done, expect_flash, program, run

KINDS = ["arduino", "cmake", "cmsis-pack", "esp-idf", "platformio", "zephyr"]
STM32 = "-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard"
RP2350 = "-mthumb -mcpu=cortex-m33 -mfpu=fpv5-sp-d16 -mfloat-abi=hard"
MORE_BY_O3 = 1.15  # where functions are inlined whatever they weigh
MEMORY = ROOT / "firmware/port/haptable_memory.c"


def export(folder, kind: str, out: str):
    return run([program("haptable-codegen"), "tables", "--export", kind, "-o", out], folder)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    if not (BUILT / "cube/model.c").exists():
        pytest.skip("build/cube is not made: make scene")
    root = tmp_path_factory.mktemp("export")
    shutil.copytree(BUILT / "cube", root / "tables")
    for kind in KINDS:
        outcome = export(root, kind, kind)
        assert outcome.status == 0, f"{kind}: {outcome.err}"
    return root


@pytest.fixture
def cross():
    if not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("arm-none-eabi-gcc is not installed")


def sources(root) -> list:
    return sorted(file.name for file in (root / "cmake/src").glob("*.c"))


def expect_size(root, elf: str, more: float = 1.0) -> None:
    expect_flash(root, elf, more)
    others = run(f"arm-none-eabi-nm {elf} | grep -E 'haptable_(part|pair|modes|moving|rows|relax)'", root)
    assert others.out == "", "nothing that the cube does not name is in it"


@pytest.mark.parametrize("kind", KINDS)
def test_has_the_same_files_for_every_kind(root, kind):
    assert len(sources(root)) > 20
    written = {file.name: file.read_bytes() for file in (root / kind / "src").iterdir()}
    assert written.keys() == {file.name for file in (root / "cmake/src").iterdir()}
    for name, text in written.items():
        own = root / "tables" / name if name.startswith("model.") else ROOT / "firmware" / name
        assert text == own.read_bytes(), name
    for file in (root / kind).rglob("*"):
        if file.is_file() and file.parent.name != "src":
            text = file.read_text()
            for mark in ("name", "NAME", "scene", "version", "sources", "tables_hash", "component_files"):
                assert f"@{mark}@" not in text, file


def test_refuses_kinds_and_folders_that_it_cannot_take(root):
    kind = export(root, "avr", "none")
    assert kind.status == 1
    assert '"avr" is none of arduino, cmake, cmsis-pack, esp-idf, platformio, zephyr' in kind.err
    assert not (root / "none").exists()
    again = export(root, "cmake", "cmake")
    assert again.status == 1 and "cmake: is there already" in again.err
    assert run([program("haptable-codegen"), "tables", "--export", "cmake"], root).status == 2


@pytest.mark.parametrize("example, core", [("stm32f4", STM32), ("rp2350", RP2350)])
def test_examples_compile_and_link_for_their_cores(root, cross, example, core):
    (root / "device.c").write_text(BOARD)
    done(f"arm-none-eabi-gcc {core} -std=c99 -ffreestanding -O2 -ffp-contract=off -fno-math-errno "
         "-fno-tree-loop-distribute-patterns -ffunction-sections -fdata-sections -Wall -Wextra -Werror "
         f"-Iplatformio/src platformio/examples/{example}.c platformio/src/*.c device.c {MEMORY} -nostdlib "
         f"-Wl,--gc-sections -Wl,-e,main -lgcc -o {example}.elf", root)
    expect_size(root, f"{example}.elf")


def test_arduinos_sketch_compiles(root, cross):
    (root / "main.cpp").write_text(
        '#include <stdint.h>\nuint32_t micros() { return 0; }\n#include "arduino/examples/Touch/Touch.ino"\n'
        "int main() { setup(); for (;;) loop(); }\n")
    (root / "ino").mkdir()
    flags = f"{STM32} -O2 -ffunction-sections -fdata-sections -Wall -Wextra -Werror -I../arduino/src"
    done(f"arm-none-eabi-gcc {flags} -ffreestanding -fno-tree-loop-distribute-patterns -c ../arduino/src/*.c {MEMORY} && "
         f"arm-none-eabi-g++ {flags} -I.. -ffreestanding -fno-exceptions -fno-rtti -fno-threadsafe-statics -c ../main.cpp "
         f"&& arm-none-eabi-g++ {flags} *.o -nostdlib -Wl,--gc-sections -Wl,-e,main -lgcc -o ../ino.elf", root / "ino")
    expect_size(root, "ino.elf")


def test_cmake_takes_it_as_a_subdirectory(root, cross):
    app = root / "app"
    app.mkdir()
    (app / "device.c").write_text(BOARD)
    shutil.copy(MEMORY, app)
    (app / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(app C)\nadd_subdirectory(../cmake body)\n"
        "add_executable(app.elf ../cmake/examples/rp2350.c device.c haptable_memory.c)\n"
        "target_compile_options(app.elf PRIVATE -fno-tree-loop-distribute-patterns)\n"
        "target_link_libraries(app.elf PRIVATE haptable::cube gcc)\n"
        "target_link_options(app.elf PRIVATE -nostdlib -Wl,--gc-sections -Wl,-e,main)\n")
    done("cmake -S app -B out -DCMAKE_SYSTEM_NAME=Generic -DCMAKE_C_COMPILER=arm-none-eabi-gcc "
         "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY -DCMAKE_BUILD_TYPE=Release "
         f"'-DCMAKE_C_FLAGS={RP2350} -ffreestanding' >/dev/null && cmake --build out >/dev/null", root)
    expect_size(root, "out/app.elf", MORE_BY_O3)


def test_zephyrs_and_esp_idfs_lists_name_every_file(root):
    (root / "lists.cmake").write_text(LOOK + "set(CONFIG_HAPTABLE_CUBE y)\ninclude(zephyr/zephyr/CMakeLists.txt)\n"
                                      "include(esp-idf/CMakeLists.txt)\n")
    files = f"-- {len(sources(root))} files\n"
    assert done("cmake -P lists.cmake", root) == files + "-- 1 files\n" + files


def test_the_pack_names_its_files(root):
    """What packchk looks at first: it can be read, and every file of it is there. Its own schema is not here."""
    pack = root / "cmsis-pack"
    files = tree.parse(pack / "haptable.haptable_cube.pdsc").getroot().findall("components/component/files/file")
    assert all((pack / file.get("name")).exists() for file in files)
    assert sum(file.get("category") == "sourceC" for file in files) == len(sources(root))


def test_their_own_tools_take_them(root, wheels):
    """And the firmware alone, whose manifests are checked in."""
    done(f"sh packaging/validate.sh {root} {root}/venv", **wheels)
