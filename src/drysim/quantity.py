"""Quantities: the pydantic types of the numbers with a unit in a scenario.

`Quantity` reads a number in SI, or text with a unit, and checks its bounds. `Mass`, `Force` and
the others are floats of such a type.
"""

import math
import operator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from drysim.messages import format_value
from drysim.units import convert

MIN_MAGNITUDE, MAX_MAGNITUDE = 1e-30, 1e30
"""Bounds of the magnitude of a nonzero number: squares and cubes stay within double range."""


@dataclass(frozen=True)
class Quantity:
    """Pydantic type of a number with a unit, within bounds.

    Accepts a number in `unit`, or text with a unit.
    """

    unit: str
    """A key of `QUANTITY_NAMES`."""
    at_least: float | None = None
    above: float | None = None
    below: float | None = None
    at_most: float | None = None
    """Bounds [unit]; `above` and `below` exclude the bound itself."""

    def read(self, value_in: object) -> float:
        """Return the validated number [unit].

        Raises
        ------
        ValueError
            With a sentence that lacks its subject, e.g. `must be above 0 kg, not -1`.
        """
        if isinstance(value_in, str):
            value = convert(value_in, self.unit)
        elif isinstance(value_in, bool) or not isinstance(value_in, int | float):
            raise ValueError(f"must be a number{self._in}, not {format_value(value_in)}")
        else:
            value = (
                float(value_in) if abs(value_in) < 1e308 or value_in != value_in else math.inf
            )
        if not math.isfinite(value):
            raise ValueError(f"must be a finite number{self._in}, not {format_value(value_in)}")
        for limit, relation, holds in (
            (self.at_least, "at least", operator.ge),
            (self.above, "above", operator.gt),
            (self.below, "below", operator.lt),
            (self.at_most, "at most", operator.le),
        ):
            if limit is not None and not holds(value, limit):
                bound = f"{limit:g} {self.unit}".strip()
                raise ValueError(f"must be {relation} {bound}, not {format_value(value_in)}")
        if value and not MIN_MAGNITUDE <= abs(value) <= MAX_MAGNITUDE:
            span = f"{MIN_MAGNITUDE:g} and {MAX_MAGNITUDE:g} {self.unit}".strip()
            raise ValueError(
                f"must be 0 or between {span} in magnitude, not {format_value(value_in)}"
            )
        return value

    @property
    def ends(self) -> tuple[float, float]:
        """The smallest and the largest accepted value; infinite where there is no bound."""
        low, high = self.at_least, self.at_most
        if low is None:
            low = -math.inf if self.above is None else _next_accepted(self.above, math.inf)
        if high is None:
            high = math.inf if self.below is None else _next_accepted(self.below, -math.inf)
        return low, high

    @property
    def _in(self) -> str:
        return f" [{self.unit}]" if self.unit else ""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Validate with `read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema of the field."""
        bounds = {
            "minimum": self.at_least,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number"} | {k: v for k, v in bounds.items() if v is not None}
        return {"anyOf": [number, {"type": "string", "pattern": r"^\s*[-+−]?[.0-9]"}]}


def _next_accepted(bound: float, towards: float) -> float:
    """Return the accepted number next to an excluded bound."""
    return math.nextafter(bound, towards) if bound else math.copysign(MIN_MAGNITUDE, towards)


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
Dimensionless = Annotated[float, Quantity("")]
