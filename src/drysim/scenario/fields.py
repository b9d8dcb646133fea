"""The types of fields that are derived from the shelves, and that of a check."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Union

from pydantic import Field, PlainSerializer, PlainValidator, WithJsonSchema

from drysim.checks import Check
from drysim.excitation import EXCITATIONS
from drysim.friction import FRICTIONS
from drysim.quantity import shown
from drysim.scenario.blocks import SHELF, Solver, with_options

if TYPE_CHECKING:
    from drysim.excitation import Excitation as Excitation
    from drysim.friction import Friction as Friction

    SolverBlock = Solver
else:

    def _shelf(members: tuple[type, ...], tag: str) -> object:
        """Give the type that takes any member of a shelf, told apart by its tag."""
        many = len(members) > 1
        union = Union[members]  # noqa: UP007 - a shelf is a tuple, not types side by side
        return Annotated[union, Field(discriminator=tag)] if many else union

    Excitation = _shelf(EXCITATIONS, "kind")
    Friction = _shelf(FRICTIONS, "law")
    SolverBlock = with_options(SHELF)


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
