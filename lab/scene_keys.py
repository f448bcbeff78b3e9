# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable-keys | python3 -m lab.scene_keys PAGE SCHEMA: the keys of a scene for people (docs/SCENE.md) and for editors
(docs/scene.schema.json, JSON Schema draft 7), as host/scene/keys.cpp has them."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from lab import LabError

Json = dict[str, Any]


class Keys:
    """The table of keys, as haptable-keys prints it."""

    def __init__(self, table: Json):
        self.sections, self.keys, self.rules = table["sections"], table["keys"], table["rules"]
        self.defaults, self.modulus = table["defaults"], table["modulus"]

    def section(self, name: str) -> Json:
        """Raises LabError where there is none."""
        for section in self.sections:
            if section["name"] == name:
                return section
        raise LabError(f"there is no section {name} in a scene")

    def of(self, section: str) -> list[Json]:
        """The keys of a section, in order."""
        return [key for key in self.keys if key["section"] == section]


# ---- the page -------------------------------------------------------------------------------------------------------

def _range_text(key: Json) -> str:
    least, most = key["least"], key["most"]
    if least is None:
        return ""
    if most is None:
        return f"above {least:g}" if key["above"] else f"{least:g} or more"
    if key["above"]:
        return f"above {least:g}, at most {most:g}"
    return f"{least:g} to {'below ' if key['below'] else ''}{most:g}"


def _default_text(key: Json) -> str:
    value = key["fallback"]
    if key["required"]:
        return "required"
    if key["fallback_text"] or value is None:
        return key["fallback_text"]
    if isinstance(value, list):
        return f"[{', '.join(f'{one:g}' for one in value)}]"
    if isinstance(value, (bool, str)):
        return f"`{json.dumps(value)}`"
    return str(value) if isinstance(value, int) else f"{value:g}"


def _meaning(key: Json) -> str:
    if key["type"] == "flag" and not key["means"].startswith("`"):
        return "`true`: " + key["means"]
    words = ", ".join(f'`"{word}"`' for word in key["words"]) if key["name"] != "model" else ""
    facts = ", ".join(fact for fact in (key["unit"], _range_text(key), words) if fact)
    return f"{facts}; {key['means']}" if facts else key["means"]


def _row(keys: Keys, key: Json) -> str:
    """One row of what sections have in common; empty but for the first of them."""
    def header(section: str) -> str:
        return f"[[{section}]]" if keys.section(section)["is_list"] else f"[{section}]"

    def told(one: Json) -> tuple[str, str, str]:
        return one["name"], _default_text(one), _meaning(one)

    alike = [other for other in keys.keys if told(other) == told(key)]
    if alike[0] is not key:
        return ""
    cell = f"`{header(key['section'])} {key['name']}`" if key["section"] else f"`{key['name']}`"
    if len(alike) > 1:
        cell = f"`{key['name']}` of " + ", ".join(f"`{header(other['section'])}`" for other in alike)
    return f"| {cell} | {_default_text(key)} | {_meaning(key)} |\n"


def _table(keys: Keys, sections: list[str]) -> str:
    text = "| key | default | meaning |\n|---|---|---|\n"
    for given in sections:
        section = keys.section("" if given == "scene" else given)
        if section["name"]:
            header = f"[[{given}]]" if section["is_list"] else f"[{given}]"
            text += f"| `{header}` | {'required' if section['required'] else ''} | {section['means']} |\n"
        text += "".join(_row(keys, key) for key in keys.of(section["name"]))
    return text


def with_keys(keys: Keys, page: str) -> str:
    """The page with its tables made anew: what stands between "<!-- keys: SECTION... -->" and "<!-- end -->", where
    "scene" is what stands outside of all sections. Raises LabError where a mark has no end or names no section."""
    whole = re.compile(r"<!-- keys: (.*) -->\n((?:(?!<!-- keys: )[\s\S])*?)<!-- end -->")
    if len(whole.findall(page)) != page.count("<!-- keys: "):
        raise LabError('a table of keys has no "<!-- end -->"')
    return whole.sub(lambda at: f"<!-- keys: {at[1]} -->\n\n{_table(keys, at[1].split())}\n<!-- end -->", page)


# ---- the schema -----------------------------------------------------------------------------------------------------

def _list(items: Json, count: int) -> Json:
    return {"type": "array", "items": items, "minItems": count, "maxItems": count}


def _either(a: Json, b: Json) -> Json:
    return {"anyOf": [a, b]}


def _number(key: Json) -> Json:
    is_whole = key["type"] == "integer"
    schema: Json = {"type": "integer" if is_whole else "number"}
    for end, name in (("least", "exclusiveMinimum" if key["above"] else "minimum"),
                      ("most", "exclusiveMaximum" if key["below"] else "maximum")):
        if key[end] is not None:
            schema[name] = int(key[end]) if is_whole else key[end]
    return schema


def _by_law(name: str) -> Json:
    """A material's key, whatever its law."""
    number, text = {"type": "number"}, {"type": "string", "minLength": 1}
    three = _list(number, 3)
    known = {"axes": _list(three, 2), "around": _list(three, 2), "axes_field": _list(text, 2), "direction": three,
             "direction_field": text,
             "stiffening": {"type": "object", "minProperties": 1, "maxProperties": 3}}
    return known.get(name, _either(number, three))


def _value(key: Json) -> Json:
    number, words = _number(key), {"enum": key["words"]}
    nodes = {"type": "array", "items": {"type": "integer", "minimum": 0}, "uniqueItems": True, "maxItems": 1000}
    points = {"type": "array", "items": _list({"type": "number"}, 3), "minItems": 2, "maxItems": 32}
    return {"number": _either(number, words) if key["words"] else number,
            "integer": number,
            "flag": {"type": "boolean"},
            "text": {"type": "string", "minLength": 1},
            "word": words,
            "three": _list(number, 3),
            "direction": _list(number, 3),
            "one-or-three": _either(number, _list(number, 3)),
            "six": _list(number, 6),
            "box": _list(number, 6),
            "nodes": nodes,
            "points": _either({"type": "integer", "minimum": 2, "maximum": 32}, points),
            "by-law": _by_law(key["name"])}[key["type"]]


def _plain(text: str) -> str:
    """Without a page's marks: of a link its text, of code what it says."""
    return re.sub(r"\[([^\[\]]*)\]\([^)]*\)", r"\1", text).replace("`", "")


def _key(key: Json) -> Json:
    schema = _value(key)
    schema["description"] = _plain(f"{key['unit']}; {key['means']}" if key["unit"] else key["means"])
    if key["fallback"] is not None:
        schema["default"] = key["fallback"]
    return schema


def _condition(keys: Keys, text: str, inside: str) -> Json:
    """What the table `inside` must have so that the condition holds: of another section, what the scene must have."""
    section, name, sign, value = re.fullmatch(r"([^.=>]*)(?:\.([^=>]*))?(?:([=>])(.*))?", text).groups()
    table: Json = {}
    holds_without = False
    if name:
        if sign:
            wanted = value == "true" or (int(value) if value.isdecimal() else value)
            default = keys.defaults.get(section, {}).get(name)
            is_number = isinstance(default, (int, float)) and not isinstance(default, bool)
            holds_without = is_number and default > wanted if sign == ">" else default == wanted
            table["properties"] = {name: {"type": "number", "exclusiveMinimum": wanted} if sign == ">" else {"const": wanted}}
        if not holds_without:
            table["required"] = [name]
    if section == inside:
        return table
    if keys.section(section)["is_list"]:
        table = {"contains": table}
    scene: Json = {"properties": {section: table}}
    if not holds_without:
        scene["required"] = [section]
    return scene


def _section_in(condition: str) -> str:
    return re.split("[.=>]", condition)[0]


def _place_of(rule: Json) -> str:
    """A rule of one section's tables stands there, another at the scene."""
    section = _section_in(rule["subject"])
    return section if all(_section_in(one) == section for one in rule["other"].split("|")) else ""


def _rule(keys: Keys, rule: Json, inside: str) -> Json:
    others = [_condition(keys, one, inside) for one in rule["other"].split("|")]
    wanted: Json = {"excludes": {"not": others[0]}, "one-of": {"oneOf": others}, "needs": {"anyOf": others}}[rule["kind"]]
    if rule["subject"] == inside:
        return wanted
    return {"if": _condition(keys, rule["subject"], inside), "then": wanted}


def _isotropic(keys: Keys) -> Json:
    """The schema of the law that most scenes have; a material's reader judges the others."""
    young = _number({"type": "number", **keys.modulus})
    poisson = _number({"type": "number", "least": -1.0, "most": 0.5, "above": True, "below": True})
    return {"if": {"properties": {"law": {"const": "isotropic"}}},
            "then": {"properties": {"young": young, "poisson": poisson}, "required": ["young", "poisson"]}}


def _table_schema(keys: Keys, section: Json) -> Json:
    own = keys.of(section["name"])
    properties = {key["name"]: _key(key) for key in own}
    if "name" in properties:
        properties["name"]["pattern"] = "^[A-Za-z][A-Za-z0-9_-]{0,63}$"
    schema = {"type": "object", "description": _plain(section["means"]), "additionalProperties": False,
              "properties": properties}
    required = [key["name"] for key in own if key["required"]]
    rules = [_rule(keys, rule, section["name"]) for rule in keys.rules if _place_of(rule) == section["name"]]
    if "law" in properties:
        rules.append(_isotropic(keys))
    if required:
        schema["required"] = required
    if rules:
        schema["allOf"] = rules
    return schema


def schema_text(keys: Keys) -> str:
    """JSON Schema of a scene file: types, ranges, words, and which keys need or exclude each other."""
    schema = _table_schema(keys, keys.section(""))
    for section in keys.sections:
        if section["name"]:
            table = _table_schema(keys, section)
            schema["properties"][section["name"]] = {"type": "array", "items": table} if section["is_list"] else table
            if section["required"]:
                schema.setdefault("required", []).append(section["name"])
    whole = {"$schema": "http://json-schema.org/draft-07/schema#", "title": "A scene of haptable", **schema}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    page, schema = (Path(name) for name in sys.argv[1:])
    keys = Keys(json.load(sys.stdin))
    page.write_text(with_keys(keys, page.read_text(encoding="utf-8")), encoding="utf-8")
    schema.write_text(schema_text(keys), encoding="utf-8")


if __name__ == "__main__":
    main()
