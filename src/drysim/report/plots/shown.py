"""What panels show of many cases: metrics, in words, symbols and scales."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from drysim import wording
from drysim.study.sweeps.table import OK

if TYPE_CHECKING:
    from drysim.study.sweeps.table import Row


STROKE = "x_r_peak"
"""The metric whose unit is chosen for its size."""


class Shown(NamedTuple):
    """What a panel shows: symbol, metric, scale, what it is called, and the unit of that."""

    symbol: str
    metric: str
    scale: float = 1.0
    title: str = ""
    unit: str = ""

    def of(self, row: Row) -> float | None:
        """Give the value of a row; None where it is not known."""
        found = row.metrics.get(self.metric) if row.status == OK else None
        return None if found is None else found * self.scale

    def width(self, row: Row) -> float | None:
        """Give half the interval of a mean over many seeds; None where there is none."""
        found = row.half_widths.get(self.metric)
        return None if found is None else found * self.scale

    @property
    def words(self) -> str:
        """The title of a panel that has no other."""
        return f"{self.title} {self.symbol}"


T_X = Shown("$T_x$ [–]", "T_x", title="relative displacement transmissibility")
T_A = Shown("$T_a$ [–]", "T_a", title="acceleration transmissibility")
SEAT = Shown("SEAT [–]", "SEAT")
HIT = Shown("impact speed [m/s]", "impact_speed", title="end stops:")
FORCE = Shown("peak force [N]", "stop_force_peak", title="end stops:")


def peak(greatest: float) -> Shown:
    """Give the peak of |x_r| in the unit in which the greatest of them [m] reads well."""
    unit = wording.length_unit(greatest)
    symbol = f"peak |$x_r$| [{unit.sign}]"
    return Shown(symbol, STROKE, unit.per_metre, "stroke:", unit.sign)
