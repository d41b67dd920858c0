"""The JSON Schema of scenario files, made from the models; `docs/scenario.schema.json` is this text."""

from __future__ import annotations

import json

from .scenario import Scenario


def text() -> str:
    schema = Scenario.model_json_schema()
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
