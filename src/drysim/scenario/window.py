"""Time window of the metrics: its default, and times in seconds or periods.

Excitation and friction may be periodic; the steady state repeats after their common period.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import gcd, lcm
from typing import Any

from drysim.block import InvalidValue
from drysim.excitation import Excitation
from drysim.friction import Friction
from drysim.messages import format_value
from drysim.units import NUMBER_PATTERN

MAX_PERIODS = 10_000
"""Maximum number of periods of the slowest sine in a common period; a motion with a longer
common period is treated as not periodic."""

_PERIODS_PATTERN = re.compile(rf"\s*({NUMBER_PATTERN.pattern})\s*periods?\s*")


def common_period(frequencies: Iterable[float]) -> float | None:
    """Return the common period [s] of frequencies [Hz], or None.

    Notes
    -----
    Frequencies are taken as the decimal numbers they are written as, so the result is exact:
    1.6 Hz and 0.7 Hz have the period 10 s.
    """
    frequencies = tuple(frequencies)
    if len(frequencies) == 1:
        return 1.0 / frequencies[0]
    decimals = {Fraction(repr(frequency)) for frequency in frequencies}
    if not decimals:
        return None
    denominator = lcm(*(decimal.denominator for decimal in decimals))
    base = Fraction(gcd(*(int(decimal * denominator) for decimal in decimals)), denominator)
    return float(1 / base) if min(decimals) / base <= MAX_PERIODS else None


def scene_frequencies(
    excitation: Excitation | None, friction: Friction | None
) -> tuple[float, ...]:
    """Return all frequencies [Hz] of a periodic base motion and the normal force."""
    frequencies = excitation.frequencies if excitation else ()
    return (*frequencies, *friction.frequencies) if frequencies and friction else frequencies


def is_steady_by_default(excitation: Excitation | None, friction: Friction | None) -> bool:
    """Return whether a measure block without times means the steady state."""
    by_default = excitation is not None and excitation.steady_by_default
    return by_default and not has_recorded_normal_force(friction)


def counts_in_periods(measure: Mapping[str, Any]) -> bool:
    """Return whether a measure block has a time in periods."""
    times = (measure.get("settle"), measure.get("duration"))
    return any(isinstance(time, str) and _PERIODS_PATTERN.fullmatch(time) for time in times)


def times_in_seconds(
    measure: Mapping[str, Any], frequencies: tuple[float, ...] | None, steady: bool
) -> dict[str, Any]:
    """Return the measure block with its default and with times in seconds.

    Parameters
    ----------
    measure : mapping
        Block as in the scenario.
    frequencies : tuple of float or None
        Frequencies of the motion [Hz]; None if another fault leaves them unknown.
    steady : bool
        Whether a block without times means the steady state.

    Raises
    ------
    InvalidValue
        If a common period is needed and there is none.
    """
    times = dict(measure)
    times.setdefault("steady", steady and not {"settle", "duration"} & times.keys())
    period = None if frequencies is None else common_period(frequencies)
    for key in ("settle", "duration"):
        count = (
            _PERIODS_PATTERN.fullmatch(times[key]) if isinstance(times.get(key), str) else None
        )
        if count and period is None and frequencies is not None:
            sentence = f"{format_value(times[key])} needs a periodic base motion; give seconds"
            raise InvalidValue(sentence, key)
        if count:
            times[key] = float(count[1]) * (period or 1.0)
    if times["steady"] is True and period is None and frequencies:
        listed = " and ".join(f"{frequency:.12g} Hz" for frequency in frequencies[-2:])
        raise InvalidValue(
            f"needs a common period, and {listed} have none within {MAX_PERIODS} periods; "
            "give measure.settle and measure.duration",
            "steady",
        )
    return times


def has_recorded_normal_force(friction: Friction | None) -> bool:
    """Return whether the normal force is a record."""
    return getattr(friction, "normal_record", None) is not None
