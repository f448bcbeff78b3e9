# SPDX-License-Identifier: GPL-2.0-or-later
"""What all tests of programs share. They run from the root: scripts/test.sh, or pytest tests/FOLDER."""

import os
import shutil
import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(folder) for folder in Path(__file__).resolve().parents[:2]]  # programs, lab
from lab import browser as browsers  # noqa: E402
from programs import BUILD, BUILT, ROOT, SHARED, Listener, Programs  # noqa: E402


@pytest.fixture(autouse=True)
def _at_the_root(monkeypatch):
    monkeypatch.chdir(ROOT)


@pytest.fixture
def tmp_path(tmp_path):
    """pytest keeps those of three runs: some hold an installed haptable."""
    yield tmp_path
    shutil.rmtree(tmp_path, ignore_errors=True)


@pytest.fixture(scope="module")
def browser():
    """One for all tests of a file that do not need their own: it takes longer to start than most of them."""
    if why := browsers.missing():
        pytest.skip(why)
    one = browsers.Browser()
    yield one
    one.close()


@pytest.fixture
def start():
    """start(words, folder, out, err): a program beside the test, which it does not outlive."""
    programs = Programs()
    yield programs
    programs.end()


@pytest.fixture
def shared() -> Path:
    """Meshes of other people, which no clone has."""
    if not (SHARED / "meshes").exists():
        pytest.skip("no ../shared/meshes")
    return SHARED


def made(*names: str) -> Path:
    """Files of the build's folder; a test that wants one which is not there is skipped. The first one's path."""
    for name in names:
        if not (BUILT / name).exists():
            pytest.skip(f"{BUILD / name} is not built: make test, or make test-lab for tests/lab")
    return BUILT / names[0]


@pytest.fixture
def need():
    return made


@pytest.fixture
def wheels() -> dict:
    """Variables by which pip finds packages of PyPI here, and nowhere else (scripts/python.sh brought them)."""
    if not (BUILT / "python/wheels/ready").exists():
        pytest.skip("the packages of PyPI are not there: make test-all brings them")
    return {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(BUILT / "python/wheels")}


@pytest.fixture
def lcm_url(monkeypatch) -> str:
    """An LCM URL on a port of this process's own: another run on this machine does not hear it."""
    url = f"udpm://239.255.72.84:{20000 + os.getpid() % 20000}?ttl=0"
    try:
        Listener(url).close()
    except OSError as error:
        pytest.skip(f"LCM has no multicast route ({error}): sh scripts/loopback.sh runs tests where it has")
    monkeypatch.setenv("LCM_DEFAULT_URL", url)
    return url
