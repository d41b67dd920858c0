"""The JSON Schema of scenario files, made from the models; `docs/scenario.schema.json` is this text."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from .descriptions import descriptions
from .scenario import Scenario


def text() -> str:
    schema = Scenario.model_json_schema(schema_generator=_Described)
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


class _Described(GenerateJsonSchema):
    """With what each field means."""

    def model_schema(self, schema: Any) -> dict[str, Any]:
        made = super().model_schema(schema)
        for name, meaning in descriptions(schema["cls"]).items():
            made["properties"][name]["description"] = meaning
        return made
