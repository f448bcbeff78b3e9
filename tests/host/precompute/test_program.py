# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable-precompute as a user runs it: what is printed where, the exit status, and what is left on the disk."""

import json
import re
import signal

import numpy as np
import pytest
from programs import ROOT, Outcome, ends, program, run, wait_until

SCENE = """name = "small"
[mesh]
generate = "cube"
nodes_per_side = 3
[material]
young = 1e4
poisson = 0.3
[[fixed]]
box = [-1, -1, -1, 1, 1, 0]
"""
CUBE, HELD = 'generate = "cube"\nnodes_per_side = 3', "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 0]\n"
BOX = "box = [-1, -1, -1, 1, 1, 0]"


class Runner:
    """haptable-precompute in a folder with a scene."""

    def __init__(self, folder) -> None:
        self.folder = folder
        self.write()

    def write(self, *changes, name: str = "scene.toml") -> None:
        """The scene with parts replaced: pairs of old and new text."""
        text = SCENE
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (self.folder / name).write_text(text)

    def __call__(self, words: str, **env) -> Outcome:
        return run(f"'{program('haptable-precompute')}' {words}", self.folder, **env)

    def well(self, words: str) -> Outcome:
        outcome = self(words)
        assert outcome.status == 0, outcome.err
        return outcome

    def summary(self, words: str) -> dict:
        return json.loads(self.well(words + " --json").out)

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def files(self) -> int:
        return len(list(self.folder.iterdir()))

    def drawn(self) -> dict:
        """What a page of --check draws."""
        page = self.read("a/check.html").decode()
        assert page.endswith("</html>\n")
        return json.loads(page.split("const data = ", 1)[1].split(";\n", 1)[0])


@pytest.fixture
def precompute(tmp_path, need):
    need("bin/haptable-precompute")
    return Runner(tmp_path)


def test_writes_into_build_name_and_tells_in_a_table(precompute):
    outcome = precompute.well("scene.toml")
    assert outcome.err == ""
    assert precompute.read("build/small/summary.json") and precompute.read("build/small/model.c")
    for part in ("nodes 27", "patches 48", "||K x - b||", "columns.npy", "factor"):
        assert part in outcome.out


KERNELS = {"Nehalem": (), "Sandybridge": ("avx",), "Haswell": ("avx2", "fma"), "SkylakeX": ("avx512bw", "avx512vl")}


@pytest.mark.parametrize("name", ["cube-consistent", "cube-two", "jelly"])
def test_makes_the_same_model_under_every_kernel(precompute, name):
    """Kernels of OpenBLAS add in other orders. Where symmetry gives 0 each leaves noise of its own, and of two modes of
    one frequency each finds another mixture."""
    with open("/proc/cpuinfo") as info:
        flags = set(next(line for line in info if line.startswith("flags")).split())
    kernels = [kernel for kernel, wants in KERNELS.items() if flags.issuperset(wants)]
    if len(kernels) < 2:
        pytest.skip("this processor runs one kernel alone")
    for kernel in kernels:
        outcome = precompute(f"{ROOT}/meshes/{name}.toml -o {kernel} --quiet", OPENBLAS_CORETYPE=kernel)
        assert outcome.status == 0, outcome.err
    assert len({precompute.read(f"{kernel}/model.c") for kernel in kernels}) == 1


def test_warns_of_linear_tetrahedra_that_lock(precompute):
    precompute.write(("0.3\n", "0.49\n"))
    for how in ("-o a", "--check"):
        linear = precompute.well("scene.toml " + how)
        assert "warning: scene.toml: linear tetrahedra lock at Poisson's ratio 0.49" in linear.err
    precompute.write(("0.3\n", "0.49\n"), ("generate", 'element = "average-nodal-pressure"\ngenerate'))
    averaged = precompute.well("scene.toml -o a --json")
    assert averaged.err == ""
    summary = json.loads(averaged.out)
    assert summary["reused"] is False, "the tables of the other element do not stand in for these"
    assert summary["element"]["name"] == "average-nodal-pressure" and summary["element"]["expected_locking"] == 0


def test_quadratic_tetrahedra_have_their_middles_in_every_table(precompute):
    precompute.well("scene.toml -o a --quiet")
    quadratic = ("generate", 'element = "quadratic"\ngenerate')
    precompute.write(quadratic)
    summary = precompute.summary("scene.toml -o a")
    assert summary["reused"] is False, "the tables of the other element do not stand in for these"
    assert summary["element"]["name"] == "quadratic"
    counts = summary["counts"]
    assert (counts["nodes"], counts["surface_patches"]) == (27 + 90, 4 * 48)
    assert (counts["surface_nodes"], counts["touchable_nodes"]) == (98, 98 - 25)
    vtu = precompute.read("a/mesh.vtu").decode()
    assert 'NumberOfPoints="117"' in vtu
    assert "\n10\n20\n30\n" in vtu, "ten nodes a tetrahedron"
    assert "\n24\n24\n" in vtu, "VTK_QUADRATIC_TETRA"
    # What was written is read again as it is, with the same tables.
    precompute.write(quadratic, (CUBE, 'file = "a/mesh.vtu"'), name="again.toml")
    precompute.well("again.toml -o b --quiet")
    for file in ("stiffness.npy", "columns.npy", "patch.npy", "node_id.npy", "position.npy", "mesh.vtu"):
        assert precompute.read("a/" + file) == precompute.read("b/" + file), file
    assert "nodes in the middle of edges 90; curved tetrahedra 0" in precompute.well("scene.toml --check").out
    assert "is unchanged in a" in precompute("scene.toml -o a").out


def test_json_is_the_summary_and_quiet_is_silent(precompute):
    said = precompute("scene.toml -o a --json").out
    assert said == precompute.read("a/summary.json").decode()
    assert json.loads(said)["counts"]["nodes"] == 27
    quiet = precompute.well("scene.toml -o b/ --quiet")
    assert quiet.out + quiet.err == ""
    assert precompute.read("b/summary.json")


def test_check_draws_what_it_found(precompute):
    """The page has the surface's patches, each held or touchable, and where the body is loose its nodes."""
    precompute.well("scene.toml --check -o a")
    data = precompute.drawn()
    assert len(data["patch"]) == 48, "3 x 3 x 3 nodes: six sides of 8"
    assert data["kind"].count(1) == 8, "the bottom is held"
    assert data["kind"].count(0) == 40
    assert (len(data["worst"]), len(data["loose"])) == (5, 0)
    precompute.write((BOX, "box = [-1.0, -1.0, -1.0, 1e-9, 1e-9, 1e-9]"))  # one node alone is held
    assert precompute("scene.toml --check -o a --quiet").status == 1
    assert len(precompute.drawn()["loose"]) == 26


def test_check_draws_how_far_a_wrap_is_from_its_scan(precompute):
    """A box without its top: what closes it is far from the scan, and the page says how far."""
    (precompute.folder / "box.off").write_text(
        "OFF\n8 10 0\n0 0 0\n30 0 0\n0 30 0\n30 30 0\n0 0 30\n30 0 30\n0 30 30\n30 30 30\n"
        "3 0 2 1\n3 1 2 3\n3 0 1 5\n3 0 5 4\n3 1 3 7\n3 1 7 5\n3 3 2 6\n3 3 6 7\n3 2 0 4\n3 2 4 6\n")
    precompute.write((CUBE, 'file = "box.off"\nscale = 0.001\nnode_count = 1000'), (BOX, "below = 0.001"))
    check = precompute.well("scene.toml --check -o a --json")
    assert "wrapped before it was filled (the surface does not bound a body: 4 open" in check.err
    assert "1 holes closed" in check.err
    assert json.loads(check.out)["volume_m3"] == pytest.approx(0.03**3, rel=0.02)
    data = precompute.drawn()
    away, height = np.array(data["away"]), np.reshape(data["point"], (-1, 3))[:, 2]
    assert len(away) == len(height)
    assert data["farthest"] == pytest.approx(0.015, abs=0.06 * 0.03), "the middle of the top, to its nearest side"
    assert away[height < 0.9 * 0.03].max() < 0.05 * 0.03, "half an edge"
    assert b"far from the scan (at most 1" in precompute.read("a/check.html")


def test_check_takes_a_body_that_is_free(precompute):
    """A body that nothing holds is not under-constrained."""
    free = (HELD, "[gravity]\ndensity = 1000\n[body]\nfree = true\nfloor = 0\n")
    precompute.write(free)
    out = precompute.well("scene.toml --check").out
    assert "0 nodes fixed, free: nothing holds it" in out and "UNDER-CONSTRAINED" not in out
    precompute.write(free, (CUBE, 'file = "hinge.node"'))
    (precompute.folder / "hinge.node").write_text(
        "8 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 2\n6 1 0 2\n7 0 1 2\n8 0 0 3\n")
    (precompute.folder / "hinge.ele").write_text("2 4 0\n1 1 2 3 4\n2 5 6 7 8\n")
    assert precompute("scene.toml --check").status == 1, "two parts that touch nowhere are no free body"


@pytest.mark.parametrize("keys, why", [
    ("[body]\nfree = true\nmass = 0.01\nsuspension = [4e3, 0, 0, 0, 0, 0]\n", "9: body.suspension: entry 0 swings"),
    ("[body]\nfree = true\ndensity = 1e-3\n", "9: body.density: the body has 2.7e-08 kg, and a servo moves 1e-06 to"),
    (HELD + "[tables]\nflash_budget = 300\n", "take 1664 bytes and tables.flash_budget is 300:"),
    (HELD + "[tables]\ndisplay_rows = [27]\n", "tables.display_rows: node 27 is none of the mesh's 27 nodes"),
    (HELD + "[tables]\ndisplay_rows = [0]\n", "scene.toml: tables.display_rows: node 0 has no columns: it is fixed"),
    (HELD + "[body]\nmass = 1\nmodes = 14\n", "scene.toml:12: body.modes: 14 of a body that has 18 free nodes: ask"),
    ("[gravity]\ndensity = 1e6\n" + HELD, "gravity: the body's weight turns 36 of its 40 tetrahedra inside out: make")],
                         ids=["swings", "light", "large", "row", "fixed row", "modes", "weight"])
def test_what_no_servo_takes_is_refused_before_it_is_computed(precompute, keys, why):
    precompute.write((HELD, keys))
    check, whole = (precompute("scene.toml " + how) for how in ("--check", "-o a"))
    assert (check.status, whole.status) == (1, 1)
    assert "nodes 27," in check.out and why in check.err
    assert check.err.splitlines()[-1] == whole.err.splitlines()[-1]


@pytest.mark.parametrize("holds", [HELD, "[body]\nfree = true\nmass = 0.1\n",
                                   HELD + '[contact]\nforce = "pressure-mask"\nmask_radius = 0.006\n'],
                         ids=["held", "free", "mask"])
def test_check_and_run_tell_the_same_locking(precompute, holds):
    """As "feels this mesh 40 % stiffer than" or "5.1 times as stiff as"."""
    precompute.write((HELD, holds), ("0.3\n", "0.49\n"), ("side = 3", "side = 5"))
    check, whole = (re.search("linear tetrahedra lock.*", precompute("scene.toml " + how).err)
                    for how in ("--check", "-o a --force"))
    assert "by nodal pressures (the most of" in check[0]
    assert check[0] == whole[0]


def test_much_that_is_held_is_told(precompute):
    precompute.write(("side = 3", "side = 5"))
    assert "holds" not in precompute("scene.toml --check").err, "a fifth, one side of it"
    precompute.write(("side = 3", "side = 5"), (BOX, "box = [-1, -1, -1, 1, 1, 0.008]"))
    for how in ("--check", "-o a"):
        assert "fixed: holds 50 of 125 nodes (40 %)" in precompute("scene.toml " + how).err


@pytest.mark.parametrize("keys, held", [("below = 0.001", 9), ("below = 0.0151", 18), ('below = 0\naxis = "-x"', 9)])
def test_a_layer_holds_the_lowest_nodes(precompute, keys, held):
    """A layer from the lowest node on, wherever the body stands."""
    precompute.write((BOX, keys))
    assert precompute.summary("scene.toml -o a")["counts"]["fixed_nodes"] == held


def test_two_scenes_of_one_name_keep_their_tables(precompute):
    precompute.well("scene.toml --quiet")
    tables = precompute.read("build/small/stiffness.npy")
    precompute.write(("1e4", "2e4"), name="other.toml")
    for how in ("other.toml", "other.toml --build build"):
        outcome = precompute(how)
        assert outcome.status == 1
        assert ('other.toml: name: "small" is the name of scene.toml too, whose tables are in build/small: give one of '
                "them another name") in outcome.err
    assert precompute.read("build/small/stiffness.npy") == tables
    precompute.well("./scene.toml --quiet")  # the same file by another path
    precompute.well("other.toml -o mine --quiet")  # a folder that was named
    (precompute.folder / "scene.toml").rename(precompute.folder / "moved.toml")
    precompute.well("moved.toml --quiet")  # the first one has gone


def test_leads_to_a_finger_with_a_size(precompute):
    """Who left [contact] out is told what else there is; who chose is not."""
    line = 'contact = { force = "pressure-mask", mask_radius = 0.005, god_object = "least-energy" }'
    assert line in precompute("scene.toml -o a").out
    precompute.write(("[mesh]", line + "\n[mesh]"))
    assert "contact = {" not in precompute.well("scene.toml -o a").out


def test_print_name_writes_nothing(precompute):
    assert precompute("scene.toml --print-name").out == "small\n"
    assert precompute.files() == 1


def test_depfile_is_a_rule_for_make(precompute):
    precompute.well("scene.toml -o a --quiet --depfile a.d")
    assert precompute.read("a.d") == b"a/summary.json: scene.toml\n\nscene.toml:\n"


def test_a_record_stands_beside_its_scene_and_is_an_input(precompute):
    (precompute.folder / "press.csv").write_text("depth_m,force_n\n" + "".join(
        f"{d},{50.0 * d * (1.0 + d / 0.004)}\n" for d in (0.001, 0.002, 0.003, 0.004)))
    stiffening = 'stiffening = { curve = "press.csv", at = [0.015, 0.015, 0.03] }'
    precompute.write(("poisson = 0.3", "poisson = 0.3\n" + stiffening))
    said = precompute.well("scene.toml -o a --depfile a.d")
    assert "stiffening: of a press to 0.004 m" in said.out
    assert "a small dent of the record has 50 N/m" in said.err and "young = " in said.err
    assert precompute.read("a.d").startswith(b"a/summary.json: scene.toml press.csv\n")


@pytest.mark.parametrize("old, new, part", [
    ("1e4", "-1e4", "scene.toml:6: material.young"),
    (HELD, "", "scene.toml: fixed: 27 of 27 nodes are under-constrained"),
    (CUBE, 'file = "no.msh"', "no.msh: mesh file cannot be read"),
    ("[[fixed]]", "[[touch]]\nbox = [5, 5, 5, 6, 6, 6]\n[[fixed]]", "scene.toml:8: touch.box"),
    (BOX, 'below = 1\naxis = "y"', "all nodes of its patches are fixed"),
    ("name = ", "name ", "scene.toml:1: ")], ids=range(6))
def test_bad_input_is_one_line_a_status_and_nothing_written(precompute, old, new, part):
    precompute.write((old, new))
    outcome = precompute("scene.toml -o a")
    assert (outcome.status, outcome.out, outcome.err.count("\n")) == (1, "", 1)
    assert part in outcome.err
    assert precompute.files() == 1
    assert precompute("scene.toml --check").status == 1


def test_a_killed_run_leaves_nothing_that_the_next_one_keeps(precompute, start):
    precompute.write(("side = 3", "side = 24"), name="large.toml")  # seconds of work
    long = start([program("haptable-precompute"), "large.toml", "-o", "a", "--quiet"], precompute.folder)
    assert wait_until((precompute.folder / f"a/tables.haptable-{long.pid}").exists)
    ends(long, by=signal.SIGKILL)
    assert precompute.files() == 3, "two scenes and a folder"
    assert not (precompute.folder / "a/summary.json").exists()
    precompute.well("scene.toml -o a --quiet")
    assert not list((precompute.folder / "a").glob("tables.haptable-*"))


def test_files_of_others_stay(precompute):
    """A build system's lock file, a folder of pages, a link: each stays as it is, and the error says what to do."""
    kept = ["Cargo.lock", "victim", "docs/summary.json"]
    (precompute.folder / "docs").mkdir()
    for name in kept:
        (precompute.folder / name).write_text("the user's")
    (precompute.folder / "out.lock").symlink_to("victim")
    precompute.well("scene.toml -o Cargo --quiet")
    precompute.well("scene.toml -o out --quiet")
    for how in ("-o docs", "-o .", "-o docs --force"):
        refused = precompute("scene.toml " + how)
        assert refused.status == 1, how
        assert "holds files that haptable did not write" in refused.err
        assert "give a new or an empty folder" in refused.err
    assert ("warning: docs: holds files that haptable did not write"
            in precompute("scene.toml --check -o docs").err)
    assert [precompute.read(name) for name in kept] == 3 * [b"the user's"]
    assert (precompute.folder / "out.lock").is_symlink()
    assert len(list((precompute.folder / "docs").iterdir())) == 1


def test_a_missing_scene_and_a_bad_command_line_fail(precompute):
    missing = precompute("none.toml -o a")
    assert missing.status == 1 and "none.toml: cannot be read" in missing.err
    assert precompute("").status == precompute("scene.toml --no-such-option").status == 2
    assert precompute.files() == 1


@pytest.mark.parametrize("megabytes", [150, 200, 250])
def test_too_little_room_for_openblas_is_an_error_in_one_line(precompute, megabytes):
    """OpenBLAS asks for memory that there is not without end, and no signal is seen meanwhile."""
    outcome = run(["prlimit", f"--as={megabytes}000000", program("haptable-precompute"), "meshes/cube.toml", "-o",
                   "/none", "--quiet"], patience_s=60, OPENBLAS_NUM_THREADS="2")
    assert outcome.status == 1
    assert "of 2 threads of OpenBLAS" in outcome.err and outcome.err.count("\n") == 1
