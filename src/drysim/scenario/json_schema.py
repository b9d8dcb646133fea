"""JSON schema of scenario files, and models for options of several friction laws."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Literal, Union, cast

from pydantic import Field, create_model
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from drysim.approach import APPROACHES_BY_NAME
from drysim.block import Block
from drysim.metrics.table import METRICS
from drysim.scenario import model
from drysim.scenario.assess import ASSESS_KEY
from drysim.scenario.blocks import FORMAT_VERSION
from drysim.scenario.laws import DEFAULT_LAW, LAW_KEY, LAWS

# Options of friction laws other than that of the file, in blocks within the friction block
#
# They are used in comparisons. The models (a scenario, and each law with a block for each other
# law) are created on demand: for a file with such options, and for the schema.


def scenario_with_law_options() -> type[model.Scenario]:
    """Return the scenario model whose friction block may hold options of every law."""
    return cast(type[model.Scenario], _law_option_models()["Scenario"])


def __getattr__(name: str) -> type[Block]:
    """Return a dynamic model by name, for pickling."""
    if name.startswith("_") or name not in _law_option_models():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _law_option_models()[name]


@cache
def _law_option_models() -> dict[str, type[Block]]:
    """Return all dynamic models by name."""
    base = model.Scenario
    options = {name: _optional_keys(name, member) for name, member in LAWS.items()}
    members = tuple(_law_with_options(name, member, options) for name, member in LAWS.items())
    friction: Any = Union.__getitem__(members)
    scenario = create_model(
        base.__name__,
        __base__=base,
        __doc__=base.__doc__,
        friction=(friction | None, Field(None, discriminator=LAW_KEY)),
    )
    made: tuple[Any, ...] = (scenario, *members, *options.values())
    return {block.__name__: block for block in made}


def _law_with_options(
    name: str, member: type[Block], options: Mapping[str, type[Block]]
) -> type[Block]:
    """Return the model of a law with an options block for each other law."""
    about = "Options of law {} for comparisons; all keys are optional."
    fields: dict[str, Any] = {
        other: (block | None, Field(None, description=about.format(other)))
        for other, block in options.items()
        if other != name
    }
    return create_model(member.__name__, __base__=member, __doc__=member.__doc__, **fields)


def _optional_keys(name: str, member: type[Block]) -> type[Block]:
    """Return the model of a law with all keys optional."""
    fields: dict[str, Any] = {}
    for key, field in member.model_fields.items():
        if field.default is not None:
            kind: Any = field.annotation
            bounded = Annotated[(kind, *field.metadata)] if field.metadata else kind
            fields[key] = (bounded | None, None)
    fields[LAW_KEY] = (Literal[name], name)
    about = f"Options of law {name} for comparisons."
    made = create_model(f"{member.__name__}Options", __base__=member, __doc__=about, **fields)
    made.at_most_one_of = (*member.at_most_one_of, *member.one_of)
    made.one_of, made.needs = (), {}
    return made


# JSON schema of scenario files


DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _SchemaGenerator(GenerateJsonSchema):
    """Generate a schema without null: an optional key is absent or has a value."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        """Return the schema of the value if present."""
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Omit a default of None."""
        if schema.get("default") is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Omit titles, which would repeat the keys."""
        return False


def scenario_schema() -> dict[str, Any]:
    """Return the JSON schema, with the names of approaches and metrics filled in."""
    schema = scenario_with_law_options().model_json_schema(schema_generator=_SchemaGenerator)
    schema["title"] = "drysim scenario"
    schema["properties"]["drysim"]["const"] = FORMAT_VERSION
    schema["$defs"]["Solver"]["properties"]["approach"]["enum"] = list(APPROACHES_BY_NAME)
    for member in APPROACHES_BY_NAME.values():
        options = schema["$defs"].get(member.__name__, {"properties": {}})
        options["properties"].pop("approach", None)  # given by the key of the block
    for law in LAWS.values():
        schema["$defs"][f"{law.__name__}Options"]["properties"].pop(LAW_KEY)
    schema["$defs"][LAWS[DEFAULT_LAW].__name__]["required"].remove(LAW_KEY)
    schema["$defs"]["Until"]["properties"]["metric"]["enum"] = [
        metric.name for metric in METRICS if metric.name != "closure"
    ]
    del schema["$defs"]["Measure"]["properties"]["steady"]["default"]
    schema["allOf"] = [  # what an assessment alone leaves out
        {"anyOf": [{"required": [key]}, {"required": [ASSESS_KEY]}]}
        for key in schema.pop("required")
    ]
    del schema["properties"]["sweep"]["default"]  # no sweep: the block is absent
    return {"$schema": DIALECT} | schema
