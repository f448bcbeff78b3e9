# SPDX-License-Identifier: GPL-2.0-or-later
"""docs/scene.schema.json as others read it: a public validator, and an editor's own server of TOML."""

import json
import tomllib

import jsonschema
from programs import ROOT, run

SCHEMA = ROOT / "docs/scene.schema.json"
SCENES = sorted((ROOT / "meshes").rglob("*.toml"))


def test_a_public_validator_takes_every_scene():
    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    for scene in (*SCENES, *(ROOT / "tests/firmware").glob("*.toml")):
        assert not [f"{error.json_path}: {error.message}" for error in
                    validator.iter_errors(tomllib.loads(scene.read_text()))], scene


def test_an_editors_server_reads_the_schema(need, tmp_path):
    taplo = need("python/bin/taplo")
    found = run([taplo, "check", *SCENES])
    assert found.status == 0 and ".taplo.toml" in found.err, found.err
    wrong = tmp_path / "scene.toml"
    wrong.write_text((ROOT / "meshes/cube.toml").read_text() + "[body]\nfre = true\n")
    refused = run([taplo, "check", "--schema", SCHEMA.as_uri(), wrong])
    assert refused.status != 0 and "'fre' was unexpected" in refused.err
