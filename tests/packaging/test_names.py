# SPDX-License-Identifier: GPL-2.0-or-later
"""Names of files that a shell, make or gnuplot would execute, given to every program and script that takes one: none is
executed, and where a name can be used the work is done."""

import shutil
from pathlib import Path
from shlex import quote

import pytest
from programs import BUILD, BUILT, ROOT, make, program, run, write_program

# Stems of names. What one executes makes a file `pwned` in the current folder.
NAMES = [
    "$(shell touch pwned)", "${shell touch pwned}", "$$(touch pwned)", "$(touch pwned)", "`touch pwned`",
    "a`touch pwned`b", "';touch pwned;'", "'; touch pwned; echo '", '";touch pwned;"', '"; touch pwned; echo "',
    ";touch pwned", ";touch pwned;", "& touch pwned &", "&& touch pwned", "|| touch pwned", "| touch pwned",
    "a\ntouch pwned\n", "a\n\ttouch pwned", "a\r\ntouch pwned", "#\ntouch pwned", "a:;touch pwned", "a: ; touch pwned",
    "a = $(shell touch pwned)", "a := $(shell touch pwned)", "$(eval x:=$(shell touch pwned))",
    "$(call shell,touch pwned)", "$(if $(shell touch pwned),a,b)", "$(error pwned)", "$(SCENE)", "$(value SCENE)",
    "'$(shell touch pwned)'", "\\'; touch pwned; \\'", "\\", "a\\", "'", '"', "''", "'.system(\"touch pwned\").'",
    "';system(\"touch pwned\");'", "';!touch pwned;'", "'\nsystem(\"touch pwned\")\n'", ">pwned", "a>pwned", "*",
    "?[a-z]*", "~", "%", "-o pwned", "--depfile=pwned", "a b  c"]


class Named:
    """A scene of that name in a folder."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.folder = name, folder
        scene = (ROOT / "meshes/cube.toml").read_text()
        scene = scene.replace('name = "cube"', 'name = "evil-names"', 1)
        self.file(".toml").write_text(scene.replace("nodes_per_side = 5", "nodes_per_side = 3", 1))

    def file(self, suffix: str) -> Path:
        return self.folder / (self.name + suffix)

    def word(self, suffix: str) -> str:
        """A word of the shell, which no program takes for an option."""
        return quote(("./" if self.name.startswith("-") else "") + self.name + suffix)

    def execute(self, command: str, where=None, by=run):
        """There, whatever it does; nothing of the name is executed."""
        outcome = by(command, where or self.folder)
        for folder in (where or self.folder, self.folder):
            assert not (folder / "pwned").exists(), f"{command}\n{outcome.err}"
        return outcome

    def well(self, command: str) -> None:
        outcome = self.execute(command)
        assert outcome.status == 0, f"{command}\n{outcome.err}"


@pytest.fixture(params=NAMES, ids=[f"{number:02}" for number in range(len(NAMES))])
def named(request, tmp_path, need):
    need("bin/haptable-precompute")
    yield Named(request.param, tmp_path)
    for folder in (tmp_path, ROOT):
        (folder / "pwned").unlink(missing_ok=True)
    shutil.rmtree(BUILT / "evil-names", ignore_errors=True)


def test_of_programs_files(named):
    scene, tables = named.word(".toml"), named.word("")
    precompute, view = program("haptable-precompute"), f"{program('haptable-view')} {tables} --mesh --quiet --size 160x160"
    named.well(f"{precompute} {scene} --quiet -o {tables}")
    assert (named.file("") / "summary.json").exists()
    named.execute(f"{precompute} {scene} --quiet -o again --depfile {named.word('.d')}")
    if named.file(".d").exists():  # a name that make can read
        (named.folder / "Makefile").write_text("again/summary.json:\n\techo made >$@\ninclude the.d\n")
        shutil.copy(named.file(".d"), named.folder / "the.d")
        named.well("make -s && ! grep -q made again/summary.json")
        named.well(f"touch {scene} && sleep 0.01 && make -s && grep -q made again/summary.json")
    named.well(f"{program('haptable-codegen')} {tables} --export cmake -o {named.word('.project')}")
    for suffix in (".png", ".svg", ".pictures"):
        named.well(f"{view} -o {named.word(suffix)}")
    named.file(".csv").write_text("time_s,depth_m,force_n\n" + "".join(
        f"{0.01 * i},{1e-5 * i},{1e-3 * i}\n" for i in range(40)) + "0.5,0,0\n")
    fitted = named.execute(f"{program('haptable-fit')} {named.word('.csv')} {scene} --quiet --tables {tables} --terms 0 "
                           f"--plot {named.word('.fit.svg')}")
    assert fitted.status == 0 or not shutil.which("gnuplot"), fitted.err
    named.execute(f"{program('haptable-count')} {tables}")
    named.execute(f"{program('haptable-bridge')} {tables} --port {named.word('.port')} --seconds 0.01 --patience 0.01")
    named.execute(f"{program('haptable-device')} {scene} --tables {tables} --seconds 0.01 --patience 0.01 --quiet --csv "
                  f"{named.word('.device.csv')}")


def test_of_a_scene(named):
    """In haptable's folder haptable-run calls make, as people do."""
    scene = quote(str(named.file(".toml")))
    made = named.execute(f"scene-alone SCENE_MAKES= SCENE={scene}", ROOT, make)
    assert made.status == 0, made.err
    assert (BUILT / "evil-names/summary.json").exists()
    named.execute(f"SCENE={scene} make -s scene-alone SCENE_MAKES= BUILD={BUILD}", ROOT)
    for other in ("TARGET", "NAME", "BUILD"):
        refused = named.execute(f"make -s help {other}={quote(named.name)}", ROOT)
        assert refused.status != 0 or named.name == "~", other
    named.execute(f"make -n install uninstall PREFIX={quote(named.name)} DESTDIR={quote(named.name)} BUILD={BUILD}", ROOT)


def test_of_scripts(named):
    name = named.word("")
    named.file("").mkdir()
    for folder in ("scripts", "packaging"):
        (named.folder / folder).symlink_to(ROOT / folder)
    for command in (f"sh scripts/clean.sh {name}", f"sh scripts/qemu.sh cortex-m7 {name} {name}",
                    f"CROSS= sh scripts/size.sh {name} {name}", f"CROSS= python3 scripts/stack.py {name} {name}",
                    f"BUILD={name} LINE={name} BAUD=1 SECONDS_=0.01 sh scripts/loop.sh {name} {name} rv32",
                    f"BUILD={name} sh scripts/demo.sh", f"sh packaging/install.sh {name} /{name} /{name}"):
        named.execute(command)


def test_of_an_installed_scene(named):
    bin_ = named.folder / "bin"
    (named.folder / "lib").mkdir()
    bin_.mkdir()
    shutil.copy(ROOT / "packaging/haptable-build", bin_)
    (bin_ / "haptable-precompute").symlink_to(program("haptable-precompute"))
    # A compiler that makes what -o names.
    write_program(bin_ / "cc", 'while [ "$1" != -o ]; do shift; done; : >"$2"\n')
    cc = quote(str(bin_ / "cc"))
    named.well(f"CC={cc} CXX={cc} {quote(str(bin_ / 'haptable-build'))} {named.word('.toml')} -o {quote(named.name)}")
    assert (named.file("") / "servo").exists()
