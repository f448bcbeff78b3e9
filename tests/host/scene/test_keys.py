# SPDX-License-Identifier: GPL-2.0-or-later
"""The page, the schema and the program tell the same of every key."""

import json
import re

import pytest
from programs import BUILT, ROOT, done

from lab import LabError
from lab.scene_keys import Keys, schema_text, with_keys

ANEW = "differs from host/scene/keys.cpp: make scene-keys writes it anew"


@pytest.fixture(scope="module")
def keys():
    return Keys(**json.loads(done(str(BUILT / "bin/haptable-keys"))))


def test_the_page_has_them_all(keys):
    page = (ROOT / "docs/SCENE.md").read_text(encoding="utf-8")
    assert with_keys(keys, page) == page, ANEW
    for one in keys.keys + keys.sections:
        assert one["name"] in page
    for key in ("[body] suspension_damping", "[tables] coupling_bytes"):
        assert f"| `{key}` |" in page


@pytest.mark.parametrize("name", ["force", "god_object"])
def test_the_page_of_contact_has_each_law_in_the_lists_order(keys, name):
    """host/base/laws.inc is the one list."""
    rows = (ROOT / "docs/CONTACT.md").read_text().split(f"\n| `{name}` ", 1)[1].split("\n| `", 1)[0]
    one, = (key for key in keys.keys if (key["section"], key["name"]) == ("contact", name))
    assert re.findall(r'\| `"([a-z-]+)"`', rows) == one["words"]


def test_a_page_is_made_anew_between_its_marks(keys):
    page = with_keys(keys, "a\n<!-- keys: tables -->\nold\n<!-- end -->\nb\n")
    assert "old" not in page
    assert page.startswith("a\n<!-- keys: tables -->\n\n| key |") and page.endswith("|\n\n<!-- end -->\nb\n")
    for end in ("", "<!-- keys: mesh -->\n<!-- end -->"):
        with pytest.raises(LabError, match='^a table of keys has no "<!-- end -->"$'):
            with_keys(keys, "<!-- keys: tables -->\n" + end)
    with pytest.raises(LabError, match="^there is no section table in a scene$"):
        with_keys(keys, "<!-- keys: table -->\n<!-- end -->")


def test_the_schema_has_them_all(keys):
    text = schema_text(keys)
    assert text == (ROOT / "docs/scene.schema.json").read_text(encoding="utf-8"), ANEW
    schema = json.loads(text)
    for key in keys.keys:
        table = schema["properties"][key["section"]] if key["section"] else schema
        assert table.get("items", table)["properties"][key["name"]]["description"], key


def test_rules_speak_of_keys_that_there_are(keys):
    """A rule that speaks of a key that there is not would never hold."""
    known = {section["name"] for section in keys.sections} | {f"{key['section']}.{key['name']}" for key in keys.keys}
    for rule in keys.rules:
        for condition in (rule["subject"], *rule["other"].split("|"), *filter(None, [rule["at"]])):
            assert re.split("[=>]", condition)[0] in known, rule


def test_defaults_are_in_their_range(keys):
    """A default that the range refuses could not be written into a scene."""
    for key in keys.keys:
        value = keys.defaults.get(key["section"], {}).get(key["name"])
        if key["type"] == "number" and isinstance(value, (int, float)):
            assert key["least"] is None or value >= key["least"], key
            assert key["most"] is None or value <= key["most"], key
