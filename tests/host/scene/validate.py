# SPDX-License-Identifier: GPL-2.0-or-later
# validate.py SCHEMA SCENE...: prints each scene that a public validator of JSON Schema refuses, and why.
import json
import sys
import tomllib
from pathlib import Path

import jsonschema

schema = json.loads(Path(sys.argv[1]).read_text())
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
for scene in sys.argv[2:]:
    for error in validator.iter_errors(tomllib.loads(Path(scene).read_text())):
        print(f"{scene}: {error.json_path}: {error.message}")
