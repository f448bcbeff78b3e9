#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""stack.py FOLDER MODEL [ENTRY | --names]: worst-case stack, bytes, of the functions that a board's program calls, all
of haptable.h, or of ENTRY alone: the deepest path through the call graph that gcc wrote beside each object of FOLDER.
--names: every function on the way instead.

A call through a pointer is one of the functions that this member of this struct may hold. By their relocations these
are what the scene in MODEL (an object), FOLDER/display.o and const structs of the firmware have there; for a struct
that code writes also what code puts there. A call through another pointer is an error, and so are recursion and a frame
of unknown size. CROSS is the prefix of the compiler's tools. Run where firmware/ is."""

import functools
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

CROSS = os.environ.get("CROSS", "")
# What gcc needs to lay out structs as the objects do.
CORE = {"elf32-littleriscv": ["-march=rv32imafc", "-mabi=ilp32f"]}
CALLS = re.compile(r"R_(ARM_THM_(CALL|JUMP\d+)|RISCV_(CALL|CALL_PLT|JAL|RVC_JUMP)|X86_64_PLT32|AARCH64_(CALL|JUMP)26)$")


def fail(why: str) -> None:
    sys.exit(f"stack.py: {why}")


def output(*command: str) -> str:
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        fail(f"{' '.join(command[:2])}: {ran.stderr.strip()}")
    return ran.stdout


# ---- the sources ---------------------------------------------------------------------------------------------------


@functools.cache
def source(file: str) -> list:
    return Path(file).read_text(encoding="utf-8").splitlines() if Path(file).exists() else []


headers = {path.name: path.read_text(encoding="utf-8") for path in sorted(Path("firmware").glob("*.h"))}
everything = "\n".join(headers.values())
# By struct and member: the type of the function that it points to. Of a struct's member: the struct that it points to.
pointers, parts, homes = {}, {}, {}
for name, text in headers.items():
    for struct, body in re.findall(r"^struct (\w+) \{\n(.*?)^\}", text, re.M | re.S):
        for fields in re.findall(r"HAPTABLE_\w+_FIELDS", body):
            body += re.search(rf"#define {fields}.*?(?=\n\n)", text, re.S)[0]
        for kind, member in re.findall(r"(?:FUNCTION\(|\b)(\w+_fn)(?:\*|,) (\w+)[;,]", body):
            pointers[struct, member], homes[struct] = kind, name
        for member in re.findall(r"\(\*(\w+)\)\(", body):
            pointers[struct, member], homes[struct] = "", name
        parts.update((member, part) for part, member in re.findall(r"struct (\w+)(?:\*|,) (\w+)[;)]", body))
kind_of = {function: kind for kind, function in re.findall(r"^(\w+_fn) (haptable_\w+);", everything, re.M)}
struct_of = {name: struct for struct, name in re.findall(r"^extern const struct (\w+) (\w+);", everything, re.M)}
# Structs that code writes, and those of flash alone.
sources = {str(path): path.read_text(encoding="utf-8") for path in sorted(Path("firmware").glob("*.c"))}
code = "\n".join(sources.values())
written = set(re.findall(r"^\s*struct (\w+) \w+(?:\[[^\]]*\])?(?: = .*)?;", everything + code, re.M))
copies = {}  # by member of a struct that code writes: the members of others that it is copied from
for to, of in re.findall(r"(?:->|\.)(\w+) = \w+(?:(?:->|\.)\w+)*(?:->|\.)(\w+);", code):
    copies.setdefault(to, set()).add(of)
flash = set(re.findall(r"\bconst struct (\w+)\*", everything)) - written
public = re.findall(r"^(?!static|extern|typedef)\w[\w* ]*?(haptable_\w+)\(", headers.get("haptable.h", ""), re.M)


@functools.cache
def layout(form: str) -> dict:
    """By struct and byte: the member that points to a function, as the compiler of such objects lays it out."""
    text = "#include <stddef.h>\n" + "".join(f'#include "{home}"\n' for home in sorted(set(homes.values())))
    text += "".join(f"char at__{s}__{m}[offsetof(struct {s}, {m}) + 1];\n" for s, m in pointers)
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder, "at.c")
        at.write_text(text, encoding="utf-8")
        options = [*CORE.get(form, []), "-std=c99", "-ffreestanding", "-Ifirmware"]
        output(f"{CROSS}gcc", *options, "-c", str(at), "-o", f"{at}.o")
        sizes = output(f"{CROSS}nm", "-S", f"{at}.o")
    found = re.findall(r"^\w+ (\w+) \w at__(\w+)__(\w+)$", sizes, re.M)
    return {(struct, int(size, 16) - 1): member for size, struct, member in found}


def member_called(place: str) -> tuple:
    """The struct (or "" where the text does not say) and the member through which the call at FILE:LINE:COLUMN goes,
    and whether what has the struct lies in flash."""
    file, line, column = place.rsplit(":", 2)
    text = source(file)
    if int(line) > len(text):
        fail(f"{place}: is not there any more: build again")
    call = re.match(r"([\w.>\[\]-]*?)(?:->|\.)(\w+)\(", text[int(line) - 1][int(column) - 1:])
    if not call:
        return "", "", False
    holder = re.split(r"->|\.", re.sub(r"\[\w+\]", "", call[1]))
    before = "\n".join(text[:int(line)])
    declared = re.findall(rf"struct (\w+)\*? (?:const )?\*?{holder[0]}\b", before)
    struct = declared[-1] if declared else ""
    if len(holder) == 1:
        return struct, call[2], False
    owner = parts.get(holder[-2], "") if len(holder) > 2 else struct
    return parts.get(holder[-1], ""), call[2], owner in flash


# ---- the objects ---------------------------------------------------------------------------------------------------


class Object:
    """Where an object's data and code hold addresses."""

    def __init__(self, path: Path):
        dump = output(f"{CROSS}objdump", "-tr", str(path))
        self.form = re.search(r"file format (\S+)", dump)[1]
        self.symbols, self.named = {}, set()
        local = set()
        for value, flags, section, name in re.findall(r"^(\w+) (.{7}) (\S+)\t\w+(?: \S+)? (\w\S*)$", dump, re.M):
            if section == "*UND*":
                self.named.add(name)
            elif "F" in flags or "O" in flags:
                self.symbols[section, int(value, 16)] = name
                if flags.startswith("l"):
                    local.add(name)
        self.local = local
        self.file = f"firmware/{path.stem}.c"
        self.data, self.code = {}, {}  # by the symbol that holds it: (byte, name)
        for section, rows in re.findall(r"^RELOCATION RECORDS FOR \[(\S+)\]:\n.*\n((?:\w+ R_\S+ .*\n?)*)", dump, re.M):
            if section.startswith((".debug", ".ARM", ".eh_frame", ".riscv", ".comment", ".note")):
                continue
            starts = sorted(value for held_in, value in self.symbols if held_in == section)
            for place, kind, to in re.findall(r"^(\w+) +(R_\S+) +(\S+)", rows, re.M):
                start = max((s for s in starts if s <= int(place, 16)), default=None)
                if start is None or CALLS.match(kind):
                    continue
                to = self.called(re.sub(r"[-+]0x\w+$", "", to))
                holder = self.called(self.symbols[section, start])
                table = self.code if section.startswith(".text") else self.data
                table.setdefault(holder, set()).add((int(place, 16) - start, to))

    def called(self, name: str) -> str:
        """As call graphs call it: a static one with its file."""
        name = re.sub(r"^\.(text|rodata|data\.rel\.ro(\.local)?|srodata)\.", "", name)
        return f"{self.file}:{name}" if name in self.local else name


def main() -> None:
    folder, model = Path(sys.argv[1]), Path(sys.argv[2])
    graphs = [*sorted(folder.glob("*.ci")), *sorted(folder.glob("port/haptable_memory.ci"))]
    frames, edges, files = {}, {}, {}
    for graph in graphs:
        for line in graph.read_text(encoding="utf-8").splitlines():
            quoted = re.findall(r'"([^"]*)"', line)
            if line.startswith("node:") and (size := re.search(r"(\d+) bytes \((\w+)", quoted[1])):
                if size[2] != "static":
                    fail(f"{quoted[0]}: its frame has no fixed size")
                frames[quoted[0]] = int(size[1])
                files[quoted[0]] = quoted[1].split("\\n")[1].split(":")[0]
            elif line.startswith("edge:"):
                edges.setdefault(quoted[0], set()).add((quoted[1], quoted[2] if len(quoted) > 2 else ""))
    if not frames:
        fail(f"no call graph beside the objects in {folder} (a compiler cache leaves it out): build without one")
    objects = [Object(path) for path in sorted(folder.glob("*.o")) if not path.samefile(model)]
    scenes = [Object(path) for path in (model, folder / "display.o") if path.exists()]
    holds, takes = {}, {}
    for one in objects:
        for name, found in one.data.items():
            holds.setdefault(name, set()).update((one.form, byte, to) for byte, to in found)
        for name, found in one.code.items():
            takes.setdefault(name, set()).update(to for _, to in found)

    # By struct and member: functions that const structs hold, and that code puts into others. New ones may take
    # addresses of more structs and functions.
    held, put, seen = {}, {}, set()

    def hold(form: str, struct: str, byte: int, to: str) -> None:
        places = [(s, layout(form).get((s, byte))) for s in ([struct] if struct else {s for s, _ in pointers})]
        known = [p for p in places if p[1] and (struct or pointers[p] == kind_of.get(to, ""))]
        if to in frames and not known:
            fail(f"{to} stands in a const struct where firmware/*.h have no pointer to such a function")
        for place in known:
            held.setdefault(place, set()).add(to)

    def see(name: str) -> None:
        """Takes what a const struct holds, and those that it points to."""
        if name in seen:
            return
        seen.add(name)
        for form, byte, to in holds.get(name, ()):
            if to in frames:
                hold(form, struct_of.get(name, ""), byte, to)
            else:
                see(to)

    for scene in scenes:
        for byte, to in set().union(*scene.data.values()):
            if to in frames:
                hold(scene.form, "", byte, to)
        for name in scene.named:
            see(name)

    def targets(caller: str, to: str, place: str) -> set:
        if to != "__indirect_call":
            return {to}
        struct, member, is_flash = member_called(place)
        if not any(m == member and struct in ("", s) for s, m in pointers):
            fail(f"{place}: {caller} calls through a pointer that is no member of a struct of firmware/*.h")
        places = {p for p in pointers if p[1] == member and struct in ("", p[0])}
        found = [held[p] for p in held if p in places]
        if not is_flash and any(p[0] in written for p in places):
            found += [put[p] for p in put if p in places]
            found += [held[p] for p in held if p[1] in copies.get(member, ())]
        return set().union(*found)

    def puts(holder: str, to: str) -> None:
        """Notes where code of the file of HOLDER may put a function whose address it takes."""
        name = to.rpartition(":")[2]
        text = sources.get(holder.rpartition(":")[0] or files.get(holder, ""), "")
        members = set(re.findall(rf"(?:\.|->)(\w+) = &?{name}\b", text))
        places = [p for p, kind in pointers.items()
                  if p[0] in written and (p[1] in members or kind and kind == kind_of.get(name))]
        if not places:
            fail(f"{holder} takes the address of {name}, and no struct of firmware/*.h may hold it")
        for place in places:
            put.setdefault(place, set()).add(to)

    def reach(root: str) -> set:
        reached, todo = set(), [root]
        while todo:
            name = todo.pop()
            if name in reached:
                continue
            reached.add(name)
            for to, place in edges.get(name, ()):
                todo.extend(targets(name, to, place))
        return reached

    entry = sys.argv[3] if len(sys.argv) > 3 else ""
    roots = [entry] if entry and entry != "--names" else [name for name in public if name in frames]
    if not all(root in frames for root in roots):
        fail(f"{roots[0]} is no function of the objects in {folder}")
    size = -1
    while size != (size := len(seen) + sum(map(len, [*held.values(), *put.values()]))):
        for name in set().union(*map(reach, roots)):
            for to in takes.get(name, ()):
                puts(name, to) if to in frames else see(to)

    path = []

    @functools.cache
    def depth(name: str) -> int:
        if name in path:
            fail(f"recursion: {' > '.join([*path[path.index(name):], name])}")
        if name not in frames:
            fail(f"{name}: no call graph tells its frame")
        path.append(name)
        below = [depth(to) for call in edges.get(name, ()) for to in targets(name, *call)]
        path.pop()
        return frames[name] + max(below, default=0)

    if entry == "--names":
        print("\n".join(sorted(set().union(*map(reach, roots)))))
        return
    for root in roots:
        print(depth(root) if entry else f"{root} {depth(root)}")


if __name__ == "__main__":
    main()
