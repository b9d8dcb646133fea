"""The level of a sensor at rest: an offset or gravity, as opposed to the mean of a motion.

The mean of a vibration is the offset of its sensor. That of a shock, a braking or a lift
belongs to the motion: it begins or ends at rest, where the sensor shows its offset alone. A
record that is quiet at 0 has none, whatever its mean. Zeros with which a logger or a program
pads a vibration about another level are no rest.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drysim.core.model import BLOCK_SIZE, Floats, Signal, blocks, max_abs, mean_and_std
from drysim.records.columns import slice_signal
from drysim.records.options import LARGE_MEAN
from drysim.wording import join_words

GRAVITY = 9.81
"""Gravitational acceleration as rounded in the paper [m/s²]."""

GRAVITY_TOLERANCE = 0.05
"""Relative tolerance for gravity: an accelerometer may be tilted slightly."""

QUIET_SHARE, MIN_QUIET_SAMPLES = 0.02, 4
"""Share of a record at either end that may be quiet, and the samples that it must contain."""

QUIET_RATIO = 0.1
"""Ratio of the RMS about the mean of a quiet end to that of the whole record, at most."""

MIN_SILENT = 32
"""Samples of a pause that proves that a long record begins or ends at 0."""

MIN_TURNS = 0.3
"""Share of the samples of noise that are larger or smaller than both neighbours, at least; two
thirds of those of white noise are."""

ZERO_RATIO, MAX_CROSSINGS = 1e-3, 3
"""A sample below this share of the peak is 0; a single event crosses its mean this often."""

PARTS, MAX_DEVIATION = 8, 0.5
"""Parts of a vibration about a level whose means deviate from it by at most this share."""

MIN_CROSSINGS = 8, 30
"""Crossings of its level by a signal that is padded with zeros at one end, or at both, at
least: the plateau of a braking with silence before and after it has a ripple, too."""

MAX_PADDING = 0.2
"""Share of a record that may be zeros at both ends together; more are the silence of an
event."""


class Level(NamedTuple):
    """Mean of a signal, RMS about it, and the level that its sensor shows at rest."""

    mean: float
    spread: float
    rest: float
    is_at_rest: bool = False
    """Whether an end of the signal is quiet and shows the level at rest."""
    is_event: bool = False
    """Whether the signal begins and ends at rest, at the same level."""
    padding: tuple[int, int] = (0, 0)
    """Zeros before and after a vibration about another level; rest is that of the vibration."""

    def scaled(self, factor: float) -> Level:
        """Return the level in another unit."""
        mean, rest = self.mean * factor, self.rest * factor
        return self._replace(mean=mean, spread=self.spread * abs(factor), rest=rest)

    @property
    def has_offset(self) -> bool:
        """Whether mean and level at rest are large compared with the motion."""
        return min(abs(self.mean), abs(self.rest)) > LARGE_MEAN * self.spread

    @property
    def mean_is_offset(self) -> bool:
        """Whether the mean is the best estimate of the level of the sensor at rest."""
        return not any(self.padding) and not self.is_at_rest

    @property
    def padding_text(self) -> str:
        """Where zeros pad the signal, such as `the last 50 samples are 0`; empty without."""
        ends = zip(("first", "last"), self.padding, strict=True)
        listed = [f"the {name} {count}" for name, count in ends if count]
        return f"{join_words(listed)} samples are 0" if listed else ""

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
    level. Without any, rest is the mean, that between zeros with which the signal is padded.
    """
    mean, spread = mean_and_std(values)
    padding = _padding(values)
    body = slice_signal(values, padding[0], len(values) - padding[1])
    level, _ = mean_and_std(body)
    ends = _levels_of_ends(body)
    outermost = values[:MIN_SILENT], values[max(len(values) - MIN_SILENT, 0) :]
    quiet = [end for end in ends if end is not None]
    offset = min(quiet, key=abs, default=0.0)
    is_event = all(
        (end is not None and abs(end - offset) <= LARGE_MEAN * spread)
        or _is_silent(samples, spread)
        for end, samples in zip(ends, outermost, strict=True)
    )
    if whole is not None and len(whole) > len(values):
        before, after = _padding(whole)
        ends += _levels_of_ends(slice_signal(whole, before, len(whole) - after))
    quiet = [end for end in ends if end is not None]
    rest = min(quiet, key=abs, default=level)
    return Level(mean, spread, rest, bool(quiet), is_event, padding)


def _is_silent(end: Floats, spread: float) -> bool:
    """Whether an end is 0, or noise of a sensor about it, beside a motion of a given RMS."""
    level, width = mean_and_std(end)
    is_small = max(abs(level), width) <= QUIET_RATIO * spread
    return len(end) == MIN_SILENT and is_small and _is_noise(end)


def _levels_of_ends(values: Signal) -> list[float | None]:
    """Return the levels of both ends of a signal, None for one that is not quiet."""
    mean, spread = mean_and_std(values)
    count = max(MIN_QUIET_SAMPLES, int(QUIET_SHARE * len(values)))
    zero, ends = ZERO_RATIO * max_abs(values), list[float | None]()
    for is_last in (False, True):
        quiet, n = [], len(values)
        if n >= 2 * count:
            end = values[n - count :] if is_last else values[:count]
            level, width = mean_and_std(end)
            # At another level than 0 a slow motion may pause; a sensor has noise or one value.
            at_zero = abs(level) <= QUIET_RATIO * abs(mean)
            if width <= QUIET_RATIO * spread and (at_zero or _is_noise(end)):
                quiet.append(level)
        outermost = float(values[n - 1 :][0] if is_last else values[:1][0])
        # A motion without a pause may begin at 0 exactly: a ramp or a single pulse does.
        if abs(outermost) <= zero and _crossings(values, mean) <= MAX_CROSSINGS:
            quiet.append(outermost)
        ends.append(min(quiet, key=abs, default=None))
    return ends


def _padding(values: Signal) -> tuple[int, int]:
    """Return the numbers of zeros before and after a vibration about another level.

    Both are 0 if there are none, or if the motion begins or ends at 0: an event grows from
    its silence, or is a plateau. A vibration oscillates about one level from end to end.
    """
    n = len(values)
    before, after = _zeros_before(values), _zeros_after(values)
    if not before | after or before + after >= n - PARTS:
        return 0, 0
    body = slice_signal(values, before, n - after)
    level, spread = mean_and_std(body)
    edges = [len(body) * k // PARTS for k in range(PARTS + 1)]
    means = [mean_and_std(slice_signal(body, *ends))[0] for ends in pairwise(edges)]
    is_steady = max(abs(mean - level) for mean in means) <= MAX_DEVIATION * abs(level)
    is_short = not (before and after) or before + after <= MAX_PADDING * n
    enough = MIN_CROSSINGS[bool(before and after)]
    if (
        abs(level) > LARGE_MEAN * spread
        and is_steady
        and is_short
        and _crossings(body, level) >= enough
    ):
        return before, after
    return 0, 0


def _zeros_before(values: Signal) -> int:
    """Return how many zeros a signal begins with; 0 if they are fewer than a quiet end has."""
    count = 0
    for part in blocks(values):
        moving = np.flatnonzero(part)
        count += int(moving[0]) if len(moving) else len(part)
        if len(moving):
            break
    return count if count >= MIN_QUIET_SAMPLES else 0


def _zeros_after(values: Signal) -> int:
    """Return how many zeros a signal ends with; 0 if they are fewer than a quiet end has."""
    count, n = 0, len(values)
    while count < n:
        moving = np.flatnonzero(values[max(n - count - BLOCK_SIZE, 0) : n - count][::-1])
        count = min(count + BLOCK_SIZE, n) if not len(moving) else count + int(moving[0])
        if len(moving):
            break
    return count if count >= MIN_QUIET_SAMPLES else 0


def _is_noise(values: Floats) -> bool:
    """Whether samples are all equal, or turn as often as noise does."""
    steps = np.diff(values)
    turns = int(np.count_nonzero(steps[1:] * steps[:-1] < 0))
    return not steps.any() or turns >= MIN_TURNS * (len(steps) - 1)


def _crossings(values: Signal, level: float) -> int:
    """Return how often a signal crosses a level."""
    return sum(int(np.count_nonzero(np.diff(part > level))) for part in blocks(values))
