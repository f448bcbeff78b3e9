# SPDX-License-Identifier: GPL-2.0-or-later
"""Cycles of a tick, estimated from below: what it executed, through LLVM's model of the core, as if flash answered at
once and every branch was foreseen."""

import re
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

from lab import LabError, output_of, told
from lab.numbers import write_file

#: Instructions as llvm-mca takes them, with the same cost. In a trace branches lead nowhere: a target of cbz, which
#: reaches 126 bytes, may be any; a call, for which llvm-mca assumes 100 cycles, is a branch, as what it calls follows.
#: LLVM 14's Cortex-M7 knows no comparison of floats: it gets another operation of the same unit.
_SAME = [(r"^(\tcbn?z\t.*)0x[0-9a-f]+", r"\1#4"), (r"^\tbl\t", r"\tb\t"), (r"^\tblx\t", r"\tbx\t"),
         (r"^\tbx\tlr", r"\tb\t#4"), (r"^\tvcmpe?\.f32\t(s[0-9]+),.*", r"\tvabs.f32\ts31, \1")]
_CONDITION = r"^\t([a-z]+)(eq|ne|hs|cs|lo|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)(?=[.\t])"


def for_mca(instructions: Iterable[str]) -> Iterator[str]:
    """Those of an IT block without their conditions, and the IT itself as a nop: LLVM 14's Cortex-M7 does not know it.
    In a trace each has run, or passed as a nop."""
    left = 0
    for text in instructions:
        if block := re.fullmatch(r"\tit([te]*)\t.*", text):
            left, text = 1 + len(block[1]), "\tnop"
        elif left > 0:
            left, text = left - 1, re.sub(_CONDITION, r"\t\1", text)
        for what, by in _SAME:
            text = re.sub(what, by, text)
        yield text


def estimate(folder: Path, target: str, tick: int) -> int | None:
    """Of a tick that haptable-count has counted; None where LLVM has no model of the core, or is not installed."""
    if target not in ("cortex-m4", "cortex-m7") or shutil.which("llvm-mca") is None:
        return None
    elf = folder / "firmware" / target / "replay.elf"
    listing = output_of("llvm-objdump", "-d", "--no-show-raw-insn", f"--mcpu={target}", elf)
    text = {int(at, 16): words for at, words in re.findall(r"^ *([0-9a-f]+):[^\t\n]*(\t[^<@\n]*)", listing, re.M)}
    ran = told("haptable-count", folder, "--trace", tick, "--target", target)
    if unknown := [at for at in ran if at not in text]:
        raise LabError(f"{elf}: llvm-objdump shows no instruction at {unknown[0]:x}")
    file = elf.with_name("tick.s")
    write_file(file, "\n".join(for_mca(text[at] for at in ran)) + "\n")
    report = output_of("llvm-mca", "-mtriple=thumbv7em-none-eabihf", f"-mcpu={target}", "-iterations=1", file)
    return int(re.search(r"Total Cycles: *(\d+)", report)[1])
