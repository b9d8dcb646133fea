"""Numbers as people write them: SI, or a text with a unit. Knows no key and no file."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from drysim.quantity.block import Block as Block
from drysim.quantity.block import Misfit as Misfit
from drysim.quantity.block import texts_of as texts_of
from drysim.quantity.kinds import KINDS as KINDS
from drysim.quantity.units import NUMBER as NUMBER
from drysim.quantity.units import convert as convert
from drysim.quantity.units import factor as factor
from drysim.quantity.units import unit_behind as unit_behind
from drysim.quantity.units import usual as usual
from drysim.quantity.words import meant as meant
from drysim.quantity.words import meant_or_known as meant_or_known
from drysim.quantity.words import near as near
from drysim.quantity.words import short as short
from drysim.quantity.words import shown as shown

LEAST, GREATEST = 1e-30, 1e30
"""Sizes of a number, 0 apart, whose squares and cubes keep clear of the ends of doubles."""


@dataclass(frozen=True)
class Quantity:
    """What a field accepts: a number in `unit`, or a text with a unit, within bounds."""

    unit: str
    at_least: float | None = None
    above: float | None = None
    below: float | None = None
    at_most: float | None = None

    def read(self, given: object) -> float:
        """Give the number [unit]; a ValueError is a sentence without its subject."""
        if isinstance(given, str):
            value = convert(given, self.unit)
        elif isinstance(given, bool) or not isinstance(given, int | float):
            raise ValueError(f"must be a number{self._in}, not {shown(given)}")
        else:
            value = float(given) if abs(given) < 1e308 or given != given else math.inf
        if not math.isfinite(value):
            raise ValueError(f"must be a finite number{self._in}, not {shown(given)}")
        for limit, words, holds in (
            (self.at_least, "at least", operator.ge),
            (self.above, "above", operator.gt),
            (self.below, "below", operator.lt),
            (self.at_most, "at most", operator.le),
        ):
            if limit is not None and not holds(value, limit):
                bound = f"{limit:g} {self.unit}".strip()
                raise ValueError(f"must be {words} {bound}, not {shown(given)}")
        if value and not LEAST <= abs(value) <= GREATEST:
            span = f"{LEAST:g} and {GREATEST:g} {self.unit}".strip()
            raise ValueError(f"must lie between {span} in size, or be 0, not {shown(given)}")
        return value

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest value that it accepts; infinite without a bound."""
        low, high = self.at_least, self.at_most
        if low is None:
            low = -math.inf if self.above is None else _beyond(self.above, math.inf)
        if high is None:
            high = math.inf if self.below is None else _beyond(self.below, -math.inf)
        return low, high

    @property
    def _in(self) -> str:
        return f" [{self.unit}]" if self.unit else ""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Hand `read` to pydantic."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema of the field."""
        bounds = {
            "minimum": self.at_least,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number"} | {k: v for k, v in bounds.items() if v is not None}
        return {"anyOf": [number, {"type": "string", "pattern": r"^\s*[-+−]?[.0-9]"}]}


def _beyond(bound: float, towards: float) -> float:
    """Give the accepted number next to a bound that is none itself."""
    return math.nextafter(bound, towards) if bound else math.copysign(LEAST, towards)


Mass = Annotated[float, Quantity("kg", above=0)]
Stiffness = Annotated[float, Quantity("N/m", at_least=0)]
Damping = Annotated[float, Quantity("N·s/m", at_least=0)]
Force = Annotated[float, Quantity("N", at_least=0)]
Length = Annotated[float, Quantity("m")]
Velocity = Annotated[float, Quantity("m/s")]
Acceleration = Annotated[float, Quantity("m/s²")]
Time = Annotated[float, Quantity("s")]
Frequency = Annotated[float, Quantity("Hz", above=0)]
Angle = Annotated[float, Quantity("rad")]
Plain = Annotated[float, Quantity("")]
