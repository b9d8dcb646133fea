"""The level of a sensor at rest: an offset or gravity, as opposed to the mean of a motion.

The mean of a vibration is the offset of its sensor. That of a shock, a braking or a lift
belongs to the motion: it begins or ends at rest, where the sensor shows its offset alone. A
record that is quiet at 0 has none, whatever its mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from drysim.core.model import Signal, blocks, max_abs, mean_and_std
from drysim.records.columns import Floats
from drysim.records.options import LARGE_MEAN

GRAVITY = 9.81
"""Gravitational acceleration as rounded in the paper [m/s²]."""

GRAVITY_TOLERANCE = 0.05
"""Relative tolerance for gravity: an accelerometer may be tilted slightly."""

QUIET_SHARE, MIN_QUIET_SAMPLES = 0.02, 4
"""Share of a record at either end that may be quiet, and the samples that it must contain."""

QUIET_RATIO = 0.1
"""Ratio of the RMS about the mean of a quiet end to that of the whole record, at most."""

MIN_TURNS = 0.3
"""Share of the samples of noise that are larger or smaller than both neighbours, at least; two
thirds of those of white noise are."""

ZERO_RATIO, MAX_CROSSINGS = 1e-3, 3
"""A sample below this share of the peak is 0; a single event crosses its mean this often."""


class Level(NamedTuple):
    """Mean of a signal, RMS about it, and the level that its sensor shows at rest."""

    mean: float
    spread: float
    rest: float

    def scaled(self, factor: float) -> Level:
        """Return the level in another unit."""
        return Level(self.mean * factor, self.spread * abs(factor), self.rest * factor)

    @property
    def has_offset(self) -> bool:
        """Whether mean and level at rest are large compared with the motion."""
        return min(abs(self.mean), abs(self.rest)) > LARGE_MEAN * self.spread

    @property
    def mean_is_offset(self) -> bool:
        """Whether the mean is that of the sensor at rest, and contains no motion."""
        return abs(self.mean - self.rest) <= LARGE_MEAN * self.spread

    @property
    def has_gravity(self) -> bool:
        """Whether an acceleration [m/s²] at rest may be gravity."""
        return is_gravity(self.rest)


def is_gravity(mean: float) -> bool:
    """Whether a mean of ü [m/s²] may be that of a sensor at rest."""
    return abs(abs(mean) - GRAVITY) <= GRAVITY_TOLERANCE * GRAVITY


def measure_level(values: Signal, whole: Signal | None = None) -> Level:
    """Return the level of a signal.

    Parameters
    ----------
    values : ndarray or other sequence of samples, shape (n,)
        Without gaps.
    whole : the same, optional
        The record of which `values` are a part, if it is longer: it may begin or end at rest
        outside them.

    Notes
    -----
    Of two quiet ends the one closer to 0 counts: after a step the acceleration stays at another
    level. Without any, rest is the mean.
    """
    mean, spread = mean_and_std(values)
    quiet = [*_quiet_levels(values, mean, spread)]
    if whole is not None and len(whole) > len(values):
        quiet += _quiet_levels(whole, *mean_and_std(whole))
    return Level(mean, spread, min(quiet, key=abs, default=mean))


def _quiet_levels(values: Signal, mean: float, spread: float) -> Iterator[float]:
    """Yield the levels of the ends of a signal that are quiet."""
    count = max(MIN_QUIET_SAMPLES, int(QUIET_SHARE * len(values)))
    ends = (values[:count], values[len(values) - count :]) if len(values) >= 2 * count else ()
    for end in ends:
        level, width = mean_and_std(end)
        # At another level than 0 a slow motion may pause; a sensor shows noise, or one value.
        at_zero = abs(level) <= QUIET_RATIO * abs(mean)
        if width <= QUIET_RATIO * spread and (at_zero or _is_noise(end)):
            yield level
    zero = ZERO_RATIO * max_abs(values)
    for end in (values[:1], values[len(values) - 1 :]):
        # A motion without a pause may begin at 0 exactly: a ramp or a single pulse does.
        if abs(float(end[0])) <= zero and _crossings(values, mean) <= MAX_CROSSINGS:
            yield float(end[0])


def _is_noise(values: Floats) -> bool:
    """Whether samples are all equal, or turn as often as noise does."""
    steps = np.diff(values)
    turns = int(np.count_nonzero(steps[1:] * steps[:-1] < 0))
    return not steps.any() or turns >= MIN_TURNS * (len(steps) - 1)


def _crossings(values: Signal, level: float) -> int:
    """Return how often a signal crosses a level."""
    return sum(int(np.count_nonzero(np.diff(part > level))) for part in blocks(values))
