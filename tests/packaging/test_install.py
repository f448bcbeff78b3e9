# SPDX-License-Identifier: GPL-2.0-or-later
"""make install into an empty root, and then without the source tree: scene, servo, page, manuals, exit codes, and away."""

import json
import os
import re
import shutil

import pytest
from programs import BUILD, BUILT, PRESS, ROOT, done, make, read_csv, run


def files_of(folder) -> list:
    """Files of a folder, and of those below it."""
    return [path for path in folder.rglob("*") if not path.is_dir() or path.is_symlink()]


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    root = tmp_path_factory.mktemp("root")
    outcome = make(f"install DESTDIR={root} PREFIX=/usr")
    assert outcome.status == 0, outcome.err
    return root


class Shell:
    """The shell in a folder with a scene, with the installed programs on the PATH."""

    def __init__(self, root, folder) -> None:
        self.usr, self.folder = root / "usr", folder
        (folder / "my scenes").mkdir()
        shutil.copy("meshes/cube.toml", folder / "my scenes/a cube.toml")

    def __call__(self, command: str):
        return run(command, self.folder, PATH=f"{self.usr}/bin:{os.environ['PATH']}")

    def well(self, command: str) -> str:
        outcome = self(command)
        assert outcome.status == 0, outcome.err
        return outcome.out


@pytest.fixture
def shell(root, tmp_path):
    return Shell(root, tmp_path)


def test_builds_a_servo_with_the_bits_of_the_source_trees(shell, need):
    ours, made = need("cube/servo"), shell.folder / "build/cube/servo"
    shell.well("haptable-build 'my scenes/a cube.toml'")
    (shell.folder / "path.csv").write_text("x,y,z\n0.015,0.015,0.031\n0.0151,0.0152,0.028\n0.017,0.012,0.026\n")
    shell.well("build/cube/servo --quiet --replay path.csv --out felt.csv")
    shell.well(f"{ours} --quiet --replay path.csv --out expected.csv")
    assert (shell.folder / "felt.csv").read_bytes() == (shell.folder / "expected.csv").read_bytes()
    (shell.folder / "leap.csv").write_text("x,y,z\n0.015,0.015,0.05\n0.015,0.015,0.02\n")
    assert "1 of its positions leap" in shell("build/cube/servo --replay leap.csv --out nothing-felt.csv").err
    before = made.stat().st_mtime_ns
    shell.well("haptable-build 'my scenes/a cube.toml'")
    assert made.stat().st_mtime_ns == before, "made twice"


def test_has_as_many_files_as_the_page_says(root):
    """docs/INSTALL.md says how much is installed in a bare Debian: files within a twentieth; bytes, which are a linker's
    and a compiler's besides, within a tenth."""
    said = re.search(r"\| `make install`, all built: (\d+) files \| ([\d.]+) MB", (ROOT / "docs/INSTALL.md").read_text())
    files = files_of(root)
    megabytes = 1e-6 * sum(file.stat().st_size for file in files if not file.is_symlink())
    assert len(files) == pytest.approx(int(said[1]), rel=0.05), "write it into docs/numbers.json"
    assert megabytes == pytest.approx(float(said[2]), rel=0.1), "write it into docs/numbers.json"


def test_finds_its_modules_and_the_parts_of_a_page(shell):
    shell.well(f"haptable-precompute --check --quiet {shell.usr}/share/haptable/meshes/mouse.toml")
    shell.well("haptable-precompute --quiet 'my scenes/a cube.toml' -o cube")
    shell.well("haptable-view cube --page touch.html --quiet")
    assert (shell.folder / "touch.html").read_text().startswith("<!")


def test_runs_a_session_without_the_source_tree(shell, lcm_url):
    """Its servo is made where it is missing, by haptable-build, in build/ of the current folder, where the device finds
    it."""
    session = shell.well("haptable-run 'my scenes/a cube.toml' --path poke --lockstep --draw nothing --json -o session")
    assert (shell.folder / "build/cube/servo").exists()
    assert json.loads(session)["contact_ticks"] > 0


@pytest.mark.parametrize("name", ["build", "precompute", "codegen", "device", "view", "bridge", "run", "fit"])
def test_status_tells_who_is_wrong(shell, name):
    command = f"haptable-{name}"
    assert shell.well(command + " --version").startswith(command + " ")
    assert shell(command + " --no-such-option").status == 2
    status = shell(command + " none.toml -o out").status
    assert status == 1 or (status == 2 and name not in ("build", "precompute"))
    assert '.SH "EXIT STATUS"' in shell.well(f"zcat {shell.usr}/share/man/man1/{command}.1.gz")


def test_compiles_the_examples_by_pkg_config_and_by_cmake(shell, root, need):
    """What a user types for an example, the library found by its prefix alone."""
    servo, usr = need("cube/servo"), shell.usr
    shell.well("haptable-precompute --quiet 'my scenes/a cube.toml' -o cube")
    found = (f"export PKG_CONFIG_SYSROOT_DIR={root} PKG_CONFIG_PATH={usr}/lib/pkgconfig LD_LIBRARY_PATH={usr}/lib "
             f"CMAKE_PREFIX_PATH={usr}; cp -r {usr}/share/doc/haptable/examples .; ")
    flags = "$(pkg-config --cflags --libs haptable)"
    c = shell.well(f"{found}gcc -Wall -Werror -pedantic examples/touch.c {flags} -o c && ./c cube")
    cpp = shell.well(f"{found}g++ -std=c++17 -Wall -Werror examples/touch.cpp {flags} -o cpp && ./cpp cube")
    (shell.folder / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(touch C)\nfind_package(haptable 0.1 REQUIRED)\n"
        "add_executable(touch examples/touch.c)\ntarget_link_libraries(touch PRIVATE haptable::haptable)\n")
    assert shell.well(found + "cmake -S . -B out >/dev/null && cmake --build out >/dev/null && out/touch cube") == c
    # 3.9 mm below the top: what the servo of the source tree says of that path.
    (shell.folder / "path.csv").write_text(PRESS)
    shell.well(f"{servo} --quiet --replay path.csv --out felt.csv")
    last = read_csv(shell.folder / "felt.csv")[-1]
    assert "{:.4g} N on nodes {} {} {}".format(*last[["force_z", "node_i", "node_j", "node_k"]]) in c
    assert cpp.startswith("node ")


def test_bash_completes_options(shell):
    script = f"{shell.usr}/share/bash-completion/completions/haptable-view"
    said = shell(f"bash -c '. {script}; COMP_WORDS=(haptable-view --v); COMP_CWORD=1; _haptable haptable-view; "
                 "echo ${COMPREPLY[@]}'").out
    assert said == "--vtu --version\n"


def test_goes_without_a_residue(tmp_path):
    where = f"DESTDIR={tmp_path} PREFIX=/opt"
    assert make("install " + where).status == 0
    assert len(files_of(tmp_path)) > 100
    (tmp_path / "opt/share/haptable/mine").write_text("not haptable's\n")
    assert make("uninstall " + where).status == 0
    assert files_of(tmp_path) == [tmp_path / "opt/share/haptable/mine"]
    assert not (tmp_path / "opt/bin").exists()


def test_refuses_a_prefix_of_the_current_folder():
    outcome = run("sh packaging/install.sh '' some/where some/where/lib", BUILD=str(BUILD))
    assert outcome.status == 1
    assert "PREFIX=some/where: give it from the root" in outcome.err
    assert not (ROOT / "some").exists()


def test_clean_keeps_tables_and_finished_columns(tmp_path):
    build = tmp_path / "build"
    kept = ["cube/summary.json", "cube/node_id.npy", "cube/model.c", "liver/columns.unfinished/columns.npy"]
    for name in (*kept, "bin/haptable-view", "cube/servo", "cube/model.c.o", "cube/firmware/rv32/loop.elf",
                 "report/bench.json"):
        (build / name).parent.mkdir(parents=True, exist_ok=True)
        (build / name).write_text(name)
    for how in ("", " all"):  # a folder that is not make's
        assert run(f"sh scripts/clean.sh {build}{how}").status == 1
        assert len(files_of(build)) == 9
    (build / "setup.stamp").touch()
    done(f"sh scripts/clean.sh {build}")
    assert {str(file.relative_to(build)) for file in files_of(build)} == {*kept, "setup.stamp"}
    for scene in ("cube", "liver"):
        shutil.rmtree(build / scene)
    done(f"sh scripts/clean.sh {build}")
    assert not build.exists()


@pytest.mark.parametrize("name, made", [("build", "build"), ("build/", "build"), ("./build", "build"),
                                        (f"{ROOT}/build", "build"), (f"{ROOT}/build//", "build"),
                                        ("/elsewhere/", "/elsewhere")])
def test_the_build_folder_has_one_name_however_it_is_given(name, made):
    """Dependencies are written with a folder's name: by another name they would not be read, and old objects be linked."""
    assert run(f"make -pn help BUILD={name} | grep '^BUILD :='").out == f"BUILD := {made}\n"


def test_make_scene_takes_a_path_with_blanks(tmp_path):
    scene, tables = tmp_path / "my scenes/a b.toml", BUILT / "path-with-blanks"
    scene.parent.mkdir()
    scene.write_text((ROOT / "meshes/cube.toml").read_text().replace('"cube"', '"path-with-blanks"', 1))
    made = []
    for _ in range(2):
        outcome = make(f"scene-alone SCENE_MAKES=summary.json 'SCENE={scene}'")
        assert outcome.status == 0, outcome.err
        made.append((tables / "summary.json").stat().st_mtime_ns)
    shutil.rmtree(tables)
    assert made[0] == made[1], "made twice"
