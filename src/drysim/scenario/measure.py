"""Measure: the window of the metrics, its times counted in seconds or in periods."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import StrictBool, model_validator

from drysim.quantity import NUMBER, Block, Misfit, Quantity, shown
from drysim.weighting import DIRECTIONS

if TYPE_CHECKING:
    from drysim.excitation import Excitation
    from drysim.friction import Friction
    from drysim.scenario.model import Scenario

MOST_PERIODS = 10_000
"""Periods of the slowest sine in a common period; beyond it nothing repeats in practice."""

_PERIODS = re.compile(rf"\s*({NUMBER.pattern})\s*periods?\s*")


class Measure(Block):
    """The window of the metrics."""

    steady: StrictBool = False
    """Whether the metrics cover exactly one repetition of the periodic orbit that the start
    leads to; default: true for harmonic excitation without settle and duration."""
    settle: Annotated[float, Quantity("s", at_least=0)] = 0.0
    """Time before the window [s], or `20 periods`."""
    duration: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of the window [s], or `20 periods`; default: to the end of the record."""
    direction: Literal["vertical", "horizontal"] | None = None
    """How the mass moves under a person who sits on it; chooses the weighting of ISO 2631-1 and
    its factor: vertical Wk with k = 1, horizontal Wd with k = 1.4 (recalled, not checked
    against the text of the standard). Asks for a_w, SEAT, VDV, SEAT_VDV, MTVV and
    crest_factor."""
    weighting: Literal["Wk", "Wd", "Wc"] | None = None
    """Frequency weighting of ISO 2631-1: alone it has k = 1; beside `direction` it must be that
    of the direction."""
    spectra: StrictBool = False
    """Whether a run gives the spectra of base and mass and the transmissibility H1 between
    them; for random base motion and records."""
    segment: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of a segment of the spectra [s], whose lines are 1/segment apart; default: 8
    natural periods, but 5 s at least (longer where nothing rubs and the resonance is narrower
    than that resolves), and an eighth of the window at most."""

    @model_validator(mode="after")
    def _agree(self) -> Self:
        usual = DIRECTIONS[self.direction][0] if self.direction else self.weighting
        if self.weighting != usual and self.weighting:
            raise Misfit(
                f"must be {usual} beside `direction: {self.direction}`, not {self.weighting}; "
                "take one of both away",
                "weighting",
            )
        if self.segment is not None and not self.spectra:
            raise Misfit("has a meaning only beside `spectra: true`", "segment")
        return self

    @property
    def weights(self) -> tuple[str, float] | None:
        """Weighting and multiplying factor k [-] that are asked for."""
        if self.direction:
            return DIRECTIONS[self.direction]
        return (self.weighting, 1.0) if self.weighting else None


def steady_by_default(excitation: Excitation | None, friction: Friction | None) -> bool:
    """Tell whether a block without times means the steady state; a record never repeats."""
    recorded = getattr(friction, "normal_record", None) is not None
    return excitation is not None and excitation.steady_by_default and not recorded


def in_periods(given: Mapping[str, Any]) -> bool:
    """Whether the words of the block count any time in periods."""
    times = (given.get("settle"), given.get("duration"))
    return any(isinstance(time, str) and _PERIODS.fullmatch(time) for time in times)


def in_seconds(
    given: Mapping[str, Any], frequencies: tuple[float, ...] | None, steady: bool
) -> dict[str, Any]:
    """Give the words of the block with its default and with every time in seconds.

    Parameters
    ----------
    given : mapping
        As the scenario says it.
    frequencies : tuple of float or None
        What repeats [Hz]; None when a fault elsewhere keeps it unknown.
    steady : bool
        Whether a block without times means the steady state.

    Raises
    ------
    Misfit
        When there is no period to count with or to measure over.
    """
    words = dict(given)
    words.setdefault("steady", steady and not {"settle", "duration"} & words.keys())
    period = None if frequencies is None else common_period(frequencies)
    for key in ("settle", "duration"):
        count = _PERIODS.fullmatch(words[key]) if isinstance(words.get(key), str) else None
        if count and period is None and frequencies is not None:
            sentence = f"{shown(words[key])} needs a periodic base motion; give seconds"
            raise Misfit(sentence, key)
        if count:
            words[key] = float(count[1]) * (period or 1.0)
    if words["steady"] is True and period is None and frequencies:
        listed = " and ".join(f"{frequency:.12g} Hz" for frequency in frequencies[-2:])
        raise Misfit(
            f"needs a common period, and {listed} have none within {MOST_PERIODS} periods; "
            "give measure.settle and measure.duration",
            "steady",
        )
    return words


def common_period(frequencies: Iterable[float]) -> float | None:
    """Give the exact common period [s] of frequencies [Hz]; None when there is none.

    Notes
    -----
    A frequency beside others is taken as the decimal number that it is written as: 1.6 Hz and
    0.7 Hz repeat after 10 s exactly.
    """
    frequencies = tuple(frequencies)
    if len(frequencies) == 1:
        return 1.0 / frequencies[0]
    decimals = {Fraction(repr(frequency)) for frequency in frequencies}
    if not decimals:
        return None
    denominator = lcm(*(decimal.denominator for decimal in decimals))
    base = Fraction(gcd(*(int(decimal * denominator) for decimal in decimals)), denominator)
    return float(1 / base) if min(decimals) / base <= MOST_PERIODS else None


def period(scenario: Scenario) -> float | None:
    """Give the common period of base motion and normal force [s]; None when nothing repeats."""
    return common_period(scenario.frequencies)


def frequencies(excitation: Excitation | None, friction: Friction | None) -> tuple[float, ...]:
    """Give every frequency [Hz] of a scene whose base moves periodically."""
    found = excitation.frequencies if excitation else ()
    return (*found, *friction.frequencies) if found and friction else found
