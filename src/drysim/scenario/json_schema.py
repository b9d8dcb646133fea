"""The JSON schema of scenario files."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from drysim.approach import SHELF
from drysim.metrics.table import UNITS
from drysim.scenario.blocks import FORMAT
from drysim.scenario.options import with_options
from drysim.scenario.reading import BY_NAME, DEFAULT_LAW, LAWS

DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _Words(GenerateJsonSchema):
    """A key is there or it is not: no file says nothing by the word null."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        """Give the schema of the value that is there."""
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Leave the default out where it is that there is nothing."""
        if schema.get("default") is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Keep the titles away, which only repeat the keys."""
        return False


def describe() -> dict[str, Any]:
    """Give the JSON schema; the shelves and what a default depends on are filled in."""
    words = with_options().model_json_schema(schema_generator=_Words)
    words["title"] = "drysim scenario"
    words["properties"]["drysim"]["const"] = FORMAT
    words["$defs"]["Solver"]["properties"]["approach"]["enum"] = list(SHELF)
    for member in SHELF.values():
        options = words["$defs"].get(member.__name__, {"properties": {}})
        options["properties"].pop("approach", None)  # the block's own name says it
    for law in LAWS.values():
        words["$defs"][f"{law.__name__}Options"]["properties"].pop(BY_NAME)
    words["$defs"][LAWS[DEFAULT_LAW].__name__]["required"].remove(BY_NAME)
    words["$defs"]["Until"]["properties"]["metric"]["enum"] = [
        name for name in UNITS if name != "closure"
    ]
    del words["$defs"]["Measure"]["properties"]["steady"]["default"]
    del words["properties"]["sweep"]["default"]  # no sweep is no block
    return {"$schema": DIALECT} | words
