# SPDX-License-Identifier: GPL-2.0-or-later
"""What each way of docs/INSTALL.md takes, from what `make` built to a force: python3 packaging/ways.py OUT.json

Processor time of all that a way runs, and what it leaves on the disk. Called by `make bench-ways` from the project's
root; works in BUILD/package/ways. PyPI's packages are those of `make build/python/wheels/ready`, so that no network is measured."""
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys

MAKE = f"make -s BUILD={shlex.quote(os.environ.get('BUILD', 'build'))}"  # the name of it that make's dependencies have
BUILD = pathlib.Path(os.environ.get("BUILD", "build")).resolve()
WORK = BUILD / "package/ways"
USR = WORK / "root/usr"
ENV = {"PATH": f"{USR}/bin:{os.environ['PATH']}", "PKG_CONFIG_PATH": f"{USR}/lib/pkgconfig",
       "PKG_CONFIG_SYSROOT_DIR": str(WORK / "root"), "CMAKE_PREFIX_PATH": str(USR), "LD_LIBRARY_PATH": f"{USR}/lib",
       "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(BUILD / "python/wheels"), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
CMAKE = """cmake_minimum_required(VERSION 3.16)
project(touch C)
find_package(haptable REQUIRED)
add_executable(touch touch.c)
target_link_libraries(touch PRIVATE haptable::haptable)
"""
PRESS = """import haptable
servo = haptable.load("cube").servo()
for tick in range(60): contact = servo.step((0.015, 0.015, 0.032 - 1e-4 * tick))
print(contact.force[2], "N")
"""
STM32F4 = ("-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -std=c99 -ffreestanding -O2 -ffp-contract=off "
           "-fno-math-errno -fno-tree-loop-distribute-patterns -ffunction-sections -fdata-sections -nostdlib "
           "-Wl,--gc-sections -Wl,-e,main")
DEVICE = """int device_read(float x[3]) { x[0] = x[1] = x[2] = 0.0f; return 1; }
volatile float motor;
void device_write(const float f[3]) { motor = f[0]; }
"""


def run(command, folder=WORK):
    """Its processor time in s, and what it printed."""
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    before = spent()
    ended = subprocess.run(command, shell=True, cwd=folder, env={**os.environ, **ENV}, capture_output=True, text=True)
    if ended.returncode:
        sys.exit(f"ways: {command}: {ended.stderr or ended.stdout}")
    return spent() - before, ended.stdout


def force(printed):
    """No way may end without one."""
    found = re.search(r"force_size_n +([0-9.]+)|([0-9.]+) N", printed)
    if not found or float(found.group(1) or found.group(2)) <= 0.01:
        sys.exit(f"ways: no force in: {printed}")


def bytes_of(*folders):
    files = {f for folder in folders for f in ([folder] if folder.is_file() else folder.rglob("*"))}
    return sum(f.lstat().st_size for f in files if f.is_file() and not f.is_symlink())


def seconds(value):
    return {"value": round(value, 3), "text": f"{value * 1e3:.2g} ms" if value < 0.1 else f"{value:.2g} s"}


def room(value):
    unit, name = (1e6, "MB") if value >= 1e6 else (1e3, "kB")
    return {"value": value, "text": f"{value / unit:.3g} {name}"}


def installed():
    time, _ = run(f"{MAKE} install DESTDIR={WORK}/root PREFIX=/usr", pathlib.Path.cwd())
    files = (USR / "share/haptable/installed.txt").read_text().count("\n")
    return [f"`make install`, all built: {files} files", room(bytes_of(USR)), seconds(time)]


def debian():
    time, _ = run(f"{MAKE} deb", pathlib.Path.cwd())
    packages = sorted((BUILD / "package/deb").glob("*.deb"))
    _, listed = run("for deb in " + " ".join(map(str, packages)) + "; do dpkg-deb --field $deb Installed-Size; done")
    return [f"`make deb`, all built: {len(packages)} packages, {1e-3 * sum(map(int, listed.split())):.3g} MB installed",
            room(bytes_of(*packages)), seconds(time)]


def built(scene):
    time, _ = run(f"haptable-build {USR}/share/haptable/meshes/{scene}.toml -o {scene} --quiet")
    _, printed = run(f"{scene}/servo --poke top")
    force(printed)
    return [f"`haptable-build`, the {scene}'s tables and servo", room(bytes_of(WORK / scene)), seconds(time)]


def pkg_config():
    shutil.copy(USR / "share/doc/haptable/examples/touch.c", WORK)
    time, printed = run("cc touch.c $(pkg-config --cflags --libs haptable) -o touch && ./touch cube")
    force(printed)
    return ["C by pkg-config: `touch.c` compiled, the cube loaded, 60 ticks",
            room(bytes_of((USR / "lib/libhaptable.so.1").resolve())), seconds(time)]


def cmake():
    (WORK / "CMakeLists.txt").write_text(CMAKE)
    time, printed = run("cmake -S . -B out && cmake --build out && out/touch cube")
    force(printed)
    return ["the same by CMake's `find_package`", room(bytes_of(WORK / "out/touch")), seconds(time)]


def pip():
    time, _ = run(f"python3 -m venv {WORK}/venv && {WORK}/venv/bin/pip install --quiet .", pathlib.Path.cwd())
    (WORK / "press.py").write_text(PRESS)
    _, printed = run("venv/bin/python press.py")
    force(printed)
    package = next((WORK / "venv/lib").glob("python3*/site-packages/haptable"))
    return ["`pip install .` into a new venv, with NumPy and cffi", room(bytes_of(package)), seconds(time)]


def exported():
    memory = shlex.quote(str(pathlib.Path("firmware/port/haptable_memory.c").resolve()))
    (WORK / "device.c").write_text(DEVICE)
    time, printed = run(f"haptable-codegen cube --export cmake -o haptable_cube && arm-none-eabi-gcc {STM32F4} "
                        f"-Ihaptable_cube/src haptable_cube/examples/stm32f4.c haptable_cube/src/*.c device.c {memory} "
                        "-lgcc -o stm32f4.elf && arm-none-eabi-size stm32f4.elf")
    text, data = map(int, printed.splitlines()[1].split()[:2])
    return [f"exported, and linked for an STM32F4: {text + data:,} bytes of flash", room(bytes_of(WORK / "haptable_cube")),
            seconds(time)]


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    rows = [installed(), debian(), built("cube"), built("mouse"), pkg_config(), cmake(), pip(), exported()]
    with open("/proc/cpuinfo") as cpu:
        model = next((line.split(": ", 1)[1].strip() for line in cpu if line.startswith("model name")), "unknown")
    topic = {"command": "make bench-ways", "machine": f"{os.cpu_count()} x {model}",
             "columns": ["way", "on the disk", "processor time"], "rows": rows}
    pathlib.Path(sys.argv[1]).write_text(json.dumps({"ways": topic}, indent=1) + "\n")


main()
