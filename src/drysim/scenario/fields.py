"""The types of fields that are derived from the shelves, and that of a check."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import CoreSchema

from drysim.approach import SHELF
from drysim.checks import Check
from drysim.excitation import EXCITATIONS
from drysim.friction import FRICTIONS
from drysim.quantity import Block, shown
from drysim.scenario.blocks import on_the_shelf, with_options
from drysim.scenario.sweep.axis import KEY, Axis, Range, spelled
from drysim.scenario.sweep.sample import Draw, Sample

TOGETHER = "Keys that take their values side by side, as many each: one case for each place."

MOST_CHECKS = 1000
"""Checks of a scenario: more are no promises that anybody made."""


def shelf(members: tuple[type, ...], tag: str) -> Any:
    """Give the type that takes any member of a shelf, told apart by its tag."""
    union: Any = Union.__getitem__(members)
    return Annotated[union, Field(discriminator=tag)] if len(members) > 1 else union


if TYPE_CHECKING:
    from drysim.excitation import Excitation as Excitation
    from drysim.friction import Friction as Friction
    from drysim.scenario.blocks import Solver

    SolverBlock = Solver
else:
    Excitation = shelf(EXCITATIONS, "kind")
    Friction = shelf(FRICTIONS, "law")
    Solver = SolverBlock = with_options(SHELF)


def _parse(given: object) -> Check:
    """Give a check from its text."""
    if not isinstance(given, str | Check):
        raise ValueError(f"write `metric < value`, such as `T_a < 1.5`, not {shown(given)}")
    return given if isinstance(given, Check) else Check.parse(given)


CheckWords = Annotated[
    Check,
    PlainValidator(_parse),
    PlainSerializer(str),
    WithJsonSchema({"type": "string", "pattern": "^.*[<>=].*$", "examples": ["T_a < 1.5"]}),
]


def _few(given: object) -> object:
    """Refuse an endless list before any of it is read."""
    if isinstance(given, list | tuple) and len(given) > MOST_CHECKS:
        raise ValueError(f"must have {MOST_CHECKS} entries at most, not {len(given)}")
    return given


Checks = Annotated[tuple[CheckWords, ...], BeforeValidator(_few), Field(max_length=MOST_CHECKS)]


def _read_before(given: object) -> tuple[Axis, ...]:
    """Give the axes, which the loading has made: it knows every key of the scenario."""
    if not isinstance(given, tuple) or not all(isinstance(axis, Axis) for axis in given):
        raise ValueError("must be read from a file, whose keys it is about")
    return given


class _SweepSchema:
    """What the sweep block looks like to an editor."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema: dotted keys, each with a list or a range."""

        def part(model: type[Block]) -> dict[str, Any]:
            return model.__get_pydantic_json_schema__(model.__pydantic_core_schema__, handler)

        values = {"type": "array", "minItems": 1, "items": {"type": ["number", "string"]}}
        axis = {"anyOf": [values, part(Range)]}
        walk = {"type": "object", "minProperties": 2, "patternProperties": {KEY: axis}}
        walk |= {"additionalProperties": False}
        several = {"type": "array", "minItems": 1, "items": walk}
        beside = {"description": TOGETHER, "anyOf": [walk, several]}
        sample = part(Sample)
        sample["properties"]["over"]["additionalProperties"] = part(Draw)
        return {
            "type": "object",
            "minProperties": 1,
            "properties": {"zip": beside, "sample": sample},
            "patternProperties": {KEY: axis},
            "additionalProperties": False,
            "examples": [{"excitation.frequency": {"from": 0.5, "to": 10, "step": 0.1}}],
        }


Sweep = Annotated[
    tuple[Axis, ...],
    PlainValidator(_read_before),
    PlainSerializer(spelled),
    _SweepSchema(),
]

ApproachName = Annotated[
    str, AfterValidator(on_the_shelf), WithJsonSchema({"enum": list(SHELF)})
]
