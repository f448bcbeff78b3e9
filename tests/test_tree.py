# SPDX-License-Identifier: GPL-2.0-or-later
"""Files about this tree's files, and what runs the tests."""

import json
import re
from collections import defaultdict

import pytest
from programs import ROOT, done, run


def test_compile_commands_have_every_source_of_host_codegen_and_firmware():
    entries = json.loads(done("make -nB --no-print-directory PRECOMPILED= sources 2>/dev/null | sh scripts/compile_commands.sh"))
    files = [entry["file"] for entry in entries]
    assert len(files) == len(set(files))
    for entry in entries:
        assert f" -c {entry['file']} -o " in entry["command"] and entry["directory"] == str(ROOT)
    for folder in ("host/scene", "host/precompute", "host/session", "host/view", "codegen", "firmware"):
        for file in (ROOT / folder).iterdir():
            assert file.suffix not in (".c", ".cpp") or str(file.relative_to(ROOT)) in files


def test_compile_commands_are_json_whatever_a_flag_holds():
    """Quotes and backslashes of a flag stay what they are; what is no command is left out; without one it is an error."""
    command = r'''g++ -DNAME="\"a\"" -c a.cpp -o b/a.o'''
    entry, = json.loads(done(f"printf '%s\\n' 'echo a' 'ccache {command}' 'gcc a.o -o a' | sh scripts/compile_commands.sh"))
    assert entry["command"] == command
    assert run("echo nothing | sh scripts/compile_commands.sh").status != 0


def test_a_program_that_hangs_fails_its_test_and_ends_with_all_that_it_started(tmp_path):
    with pytest.raises(AssertionError, match="killed"):
        run(f"sleep 60 & echo $! >{tmp_path}/child; sleep 60", patience_s=1)
    child = (tmp_path / "child").read_text().strip()
    # It is gone too, or a zombie that nobody has asked for.
    run(f"while read -r _ _ state _ </proc/{child}/stat && [ $state != Z ]; do sleep 0.01; done", patience_s=10)


def test_no_two_files_make_tables_of_one_name():
    """Files run side by side (scripts/test.sh): what one makes in the build's folder, no other makes or removes."""
    makers = defaultdict(set)
    for file in ROOT.glob("tests/**/test_*.py"):
        for name in re.findall(r'(?:servo_of\([^)]*?, |rmtree\(BUILT / |\b(?:made|tables) = BUILT / )f?"([^"{]+)',
                               file.read_text()):
            makers[name].add(file.name)
    assert {"test-", "test-liver", "liver-capsule", "evil-names"} <= makers.keys()
    assert [names for names in makers.items() if len(names[1]) > 1] == []
