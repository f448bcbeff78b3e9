# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable-keys | python3 -m lab.scene_keys PAGE SCHEMA: the keys of a scene for people (docs/SCENE.md) and for editors
(docs/scene.schema.json, JSON Schema draft 7), as host/scene/keys.cpp has them."""

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from lab import LabError

Json = dict[str, Any]


class Keys(SimpleNamespace):
    """The table of keys, as haptable-keys prints it: sections, keys, rules, defaults, modulus."""

    def section(self, name: str) -> Json:
        """Raises LabError where there is none."""
        found = next((section for section in self.sections if section["name"] == name), None)
        if found is None:
            raise LabError(f"there is no section {name} in a scene")
        return found

    def header(self, name: str) -> str:
        return f"[[{name}]]" if self.section(name)["is_list"] else f"[{name}]"

    def of(self, section: str) -> list[Json]:
        """The keys of a section, in order."""
        return [key for key in self.keys if key["section"] == section]


# ---- the page -------------------------------------------------------------------------------------------------------

def _range_text(key: Json) -> str:
    least, most = key["least"], key["most"]
    if least is None:
        return ""
    if key["above"]:
        return f"above {least:g}" + ("" if most is None else f", at most {most:g}")
    return f"{least:g} or more" if most is None else f"{least:g} to {'below ' if key['below'] else ''}{most:g}"


def _default_text(key: Json) -> str:
    value = key["fallback"]
    if key["required"]:
        return "required"
    if key["fallback_text"] or value is None:
        return key["fallback_text"]
    if isinstance(value, (bool, str)):
        return f"`{json.dumps(value)}`"
    return f"[{', '.join(f'{one:g}' for one in value)}]" if isinstance(value, list) else f"{value:.9g}"


def _meaning(key: Json) -> str:
    if key["type"] == "flag" and not key["means"].startswith("`"):
        return "`true`: " + key["means"]
    words = ", ".join(f'`"{word}"`' for word in key["words"]) if key["name"] != "model" else ""
    facts = ", ".join(filter(None, (key["unit"], _range_text(key), words)))
    return f"{facts}; {key['means']}" if facts else key["means"]


def _row(keys: Keys, key: Json) -> str:
    """One row of what sections have in common; empty but for the first of them."""
    def told(one: Json) -> tuple[str, str, str]:
        return one["name"], _default_text(one), _meaning(one)
    alike = [other for other in keys.keys if told(other) == told(key)]
    if alike[0] is not key:
        return ""
    name, default, meaning = told(key)
    cell = f"`{keys.header(key['section'])} {name}`" if key["section"] else f"`{name}`"
    if len(alike) > 1:
        cell = f"`{name}` of " + ", ".join(f"`{keys.header(other['section'])}`" for other in alike)
    return f"| {cell} | {default} | {meaning} |\n"


def _table(keys: Keys, sections: list[str]) -> str:
    text = "| key | default | meaning |\n|---|---|---|\n"
    for given in sections:
        section = keys.section("" if given == "scene" else given)
        if section["name"]:
            required = "required" if section["required"] else ""
            text += f"| `{keys.header(given)}` | {required} | {section['means']} |\n"
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


def _either(*schemas: Json) -> Json:
    return {"anyOf": [*schemas]}


def _number(key: Json) -> Json:
    is_whole = key["type"] == "integer"
    limits = {"exclusiveMinimum" if key["above"] else "minimum": key["least"],
              "exclusiveMaximum" if key["below"] else "maximum": key["most"]}
    return {"type": "integer" if is_whole else "number",
            **{name: int(limit) if is_whole else limit for name, limit in limits.items() if limit is not None}}


_ANY, _TEXT = {"type": "number"}, {"type": "string", "minLength": 1}
_THREE = _list(_ANY, 3)
_POSITIVE: Json = {"type": "number", "exclusiveMinimum": 0}


def _law(keys: dict[str, Json], *optional: str) -> Json:
    """A table of these keys and no other."""
    return {"type": "object", "properties": keys, "required": [key for key in keys if key not in optional],
            "additionalProperties": False}


_STIFFENING = _either(_law({"yeoh": {**_list({"type": "number", "minimum": 0, "maximum": 1e4}, 2), "minItems": 1}}),
                      _law({"fung": {**_POSITIVE, "maximum": 1e4}}),
                      _law({"curve": _THREE, "energy": _POSITIVE}),
                      _law({"curve": _TEXT, "at": _THREE, "radius": _POSITIVE}, "radius"))
#: A material's keys, whatever its law; the others are a number or three.
_BY_LAW = {"axes": _list(_THREE, 2), "around": _list(_THREE, 2), "axes_field": _list(_TEXT, 2), "direction": _THREE,
           "direction_field": _TEXT, "stiffening": _STIFFENING}
#: Of types that have no range.
_OF_TYPE = {"flag": {"type": "boolean"}, "text": _TEXT,
            "nodes": {"type": "array", "items": {"type": "integer", "minimum": 0}, "uniqueItems": True,
                      "maxItems": 1000},
            "points": _either({"type": "integer", "minimum": 2, "maximum": 32},
                              {"type": "array", "items": _THREE, "minItems": 2, "maxItems": 32})}


def _value(key: Json) -> Json:
    number, words = _number(key), {"enum": key["words"]}
    of_range = {"number": _either(number, words) if key["words"] else number, "integer": number, "word": words,
                "three": _list(number, 3), "direction": {**_list(number, 3), "not": {"items": {"const": 0}}},
                "one-or-three": _either(number, _list(number, 3)), "six": _list(number, 6), "box": _list(number, 6),
                "by-law": _BY_LAW.get(key["name"], _either(_ANY, _THREE))}
    return {**_OF_TYPE, **of_range}[key["type"]]


def _plain(text: str) -> str:
    """Without a page's marks: of a link its text, of code what it says."""
    return re.sub(r"\[([^\[\]]*)\]\([^)]*\)", r"\1", text).replace("`", "")


def _key(key: Json) -> Json:
    means = _plain(f"{key['unit']}; {key['means']}" if key["unit"] else key["means"])
    return {**_value(key), "description": means, **({} if key["fallback"] is None else {"default": key["fallback"]})}


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
            holds = {"type": "number", "exclusiveMinimum": wanted} if sign == ">" else {"const": wanted}
            table["properties"] = {name: holds}
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
    wanted = {"excludes": {"not": others[0]}, "one-of": {"oneOf": others}, "needs": _either(*others)}[rule["kind"]]
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
    rules = [_rule(keys, rule, section["name"]) for rule in keys.rules if _place_of(rule) == section["name"]]
    if "law" in properties:
        rules.append(_isotropic(keys))
    lists = {"required": [key["name"] for key in own if key["required"]], "allOf": rules}
    return {"type": "object", "description": _plain(section["means"]), "additionalProperties": False,
            "properties": properties, **{name: entries for name, entries in lists.items() if entries}}


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
    keys = Keys(**json.load(sys.stdin))
    page.write_text(with_keys(keys, page.read_text(encoding="utf-8")), encoding="utf-8")
    schema.write_text(schema_text(keys), encoding="utf-8")


if __name__ == "__main__":
    main()
