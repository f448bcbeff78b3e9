# SPDX-License-Identifier: GPL-2.0-or-later
"""What pyproject.toml cannot say: the version, and that make builds the library that the package holds."""
import os
import pathlib
import re
import shutil
import subprocess

from setuptools import setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).parent.resolve()
BUILD = ROOT / os.environ.get("BUILD", "build") / "package"
PARTS = BUILD / "python"


class Build(build_ext):
    """make python-parts, then the cffi module beside what that made."""

    def run(self):
        subprocess.run(["make", "--no-print-directory", "python-parts"], cwd=ROOT, check=True)
        super().run()
        folder = pathlib.Path(self.build_lib) / "haptable"
        shutil.copytree(PARTS / "messages", folder / "messages", dirs_exist_ok=True)
        shutil.copy(PARTS / "libhaptable.so.1", folder)


version = re.search(r'kVersion = "([^"]*)"', (ROOT / "host/base/program.hpp").read_text()).group(1)
BUILD.mkdir(parents=True, exist_ok=True)
# setuptools takes over the files that it listed before, by absolute paths: of a folder that was copied or moved since
# they are another's, which it refuses.
(BUILD / "haptable.egg-info" / "SOURCES.txt").unlink(missing_ok=True)
setup(version=version, cmdclass={"build_ext": Build}, cffi_modules=["python/build_library.py:ffi"],
      options={"build": {"build_base": str(BUILD / "setuptools")}, "egg_info": {"egg_base": str(BUILD)}})
