"""Samples that were not measured: codes of missing values, frozen stretches, clipped peaks.

Each is told from what a motion or its quantisation does, too: a value that repeats is no fault
as such.

- A code such as -9999 is a number that loggers write in place of a sample, far outside the
  range of all others.
- A frozen stretch is one value amid a motion, repeated much longer than elsewhere.
- A clipped peak is cut off: the signal runs into its limit at full slope. At the peak of a
  quantised signal, neighbours differ by one digit; the plateau of a synthetic pulse is reached
  by a line, a step or a rounded corner.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import BLOCK_SIZE, Floats, Signal, blocks

CODE = re.compile(r"9{3,}|99925|327678?|32768|65535|214748364[78]|10{9,}")
"""Digits of numbers that stand for missing samples: nines, limits of integers, 1e9 and more."""

MIN_CODE, MIN_DISTANCE = 99.9, 3.0
"""Magnitude of a code, and its distance from all samples in units of half their range."""

MIN_FROZEN, FROZEN_RATIO, MIN_TURNS = 16, 10, 3
"""Samples of a frozen stretch, its length in units of those of other repetitions, and how often
the signal turns before and after it at least."""

MIN_CLIPPED_SAMPLES, MIN_LEVELS = 4, 16
"""Equal consecutive samples of a clipped peak, and different values of a signal that can be
judged, at least."""

OFTEN = 3
"""A signal reaches a limit that cuts it off this many times as often as the values beside."""

SLOW_RATIO = 6.0
"""A quantised parabola stays 4.8 times longer on its last level than on the one below."""

APPROACH, SMALL_STEP, LINE_RATIO = 10, 0.2, 1e-2
"""Samples beside a limit that show how the signal comes to it; ratio of a step to the largest
of them from which the corner is rounded, and relative change of step within a line."""

MIN_REPETITION = 3
"""How often each level occurs on average in a signal whose samples repeat."""

MIN_LINE, MAX_JUMP = 10.0, 1.5
"""Digits of a step of a line that differs from a motion, at least; ratio of the first
step of a ramp to the others, at most; a frozen sensor wakes up with a larger one."""

ROUNDED_LINE = 1.25
"""Digits by which the steps of a rounded line vary: 1, and a margin for binary rounding."""

MIN_SIDE = 3
"""Samples beside a limit from which its approach can be judged, more than this many."""

ROUNDING = 1e-9
"""Ratio of a difference of values to their range that is rounding."""

PIECE = 1 << 18
"""Samples that are examined at a time."""


class Stretch(NamedTuple):
    """Consecutive samples of one value: the 0-based first one, and their number."""

    first: int
    length: int
    value: float


# Codes.


def missing_code(values: Signal) -> float | None:
    """Return the number that stands for missing samples, None if there is none."""
    low, high = extremes(values)
    codes = [x for x in (low, high) if _looks_like_code(x)]
    if not codes:
        return None
    others = [np.where(np.isin(part, codes), np.nan, part) for part in blocks(values)]
    rest_low, rest_high = extremes(np.concatenate(others))
    middle, half = (rest_high + rest_low) / 2, (rest_high - rest_low) / 2
    far = [x for x in codes if half > 0 and abs(x - middle) > MIN_DISTANCE * half]
    return max(far, key=abs, default=None)


def _looks_like_code(x: float) -> bool:
    digits = f"{abs(x):.12g}".split("e")[0].replace(".", "")
    return abs(x) >= MIN_CODE and (1e30 <= abs(x) <= 1e38 or CODE.fullmatch(digits) is not None)


def extremes(values: Signal) -> tuple[float, float]:
    """Return the smallest and the largest sample, ignoring NaN."""
    ends = [(np.fmin.reduce(part), np.fmax.reduce(part)) for part in blocks(values)]
    low, high = zip(*ends, strict=True)
    return float(np.fmin.reduce(low)), float(np.fmax.reduce(high))


def indices_of(values: Signal, wanted: float) -> NDArray[np.intp]:
    """Return the 0-based indices of the samples that equal a value."""
    indices = [np.flatnonzero(part == wanted) for part in blocks(values)]
    return np.concatenate(
        [places + number * BLOCK_SIZE for number, places in enumerate(indices)]
    )


# Repeated values.


def repetitions(values: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first sample and number of samples of every stretch of equal samples."""
    first = np.flatnonzero(np.concatenate(([True], values[1:] != values[:-1])))
    return first, np.diff(first, append=len(values))


def frozen_stretches(values: Signal) -> list[Stretch]:
    """Return the stretches in which a moving signal repeats one value.

    At its smallest or largest value it is clipped; 0 is that of a lost signal.
    """
    stretches, limits = list[Stretch](), {x for x in extremes(values) if x}
    for begin in range(0, len(values), PIECE):
        part = values[begin : begin + PIECE]
        first, counts = repetitions(part)
        longest = int(counts.max())
        if longest < MIN_FROZEN:
            continue
        others = counts[counts < longest / 2]
        usual = float(np.quantile(others, 0.99, method="higher")) if len(others) else longest
        level = part[first]
        # A pause between two events shows the same value as the rest before or after them.
        at_rest = {float(level[k]) for k in (0, -1) if counts[k] >= MIN_FROZEN}
        rising = level[1:] > level[:-1]
        turned = np.concatenate(([0], np.cumsum(rising[1:] != rising[:-1]), [0]))
        long = np.flatnonzero(counts >= max(MIN_FROZEN, FROZEN_RATIO * usual))
        long = long[~np.isin(level[long], [*at_rest, *limits])]
        digit = _digit(np.unique(part[np.isfinite(part)]), len(part)) if len(long) else 0.0
        for k in long.tolist():
            turns = turned[max(k - 1, 0)], turned[-2] - turned[min(k, len(turned) - 2)]
            stretch = Stretch(int(first[k]), int(counts[k]), float(level[k]) or 0.0)  # never -0
            if min(turns) >= MIN_TURNS and not _is_plateau(part, *stretch[:2], digit):
                stretches.append(stretch._replace(first=begin + stretch.first))
    return stretches


# Clipped peaks.


def clipped_peaks(values: Signal, limit: float) -> list[Stretch]:
    """Return the peaks that are cut off at the smallest or largest value of a signal."""
    peaks = []
    for begin in range(0, len(values), PIECE):
        part = values[begin : begin + PIECE]
        part = part[~np.isnan(part)] if np.isnan(part).any() else part
        first, counts = repetitions(part)
        at_limit = (part[first] == limit) & (counts >= MIN_CLIPPED_SAMPLES)
        at_limit[[0, -1]] = False  # what begins or ends at a value has no peak there
        if not at_limit.any():
            continue
        levels = np.unique(part)
        if len(levels) < MIN_LEVELS:
            continue
        digit, runs = _digit(levels, len(first)), np.flatnonzero(at_limit)
        near = levels[1:4] if limit == levels[0] else levels[-4:-1]
        if len(runs) >= OFTEN * max(int((part[first] == level).sum()) for level in near):
            # No peaks but cut ones reach one value again and again, and the plateaus of events.
            sides = [
                side
                for k in runs
                for side in _sides(part, int(first[k]), int(counts[k]))
                if len(side) > MIN_SIDE
            ]
            # Plateaus next to a limit differ if samples are held, but not between events.
            held = [side[1] for side in sides if side[1] == side[2]]
            is_event = len(np.unique(held)) <= max(1, len(held) // 2) and all(
                _is_ramp(np.abs(np.diff(side)), digit) for side in sides
            )
            cut = [] if is_event else list(runs)
        else:
            cut = [k for k in runs if _is_cut(part, int(first[k]), int(counts[k]), digit)]
        if not cut and len(runs) > 1:  # a slow signal of few digits, cut off again and again
            beside = part[first] == (levels[1] if limit == levels[0] else levels[-2])
            usual = int(counts[beside].max())
            if usual > 1:
                cut = [k for k in runs if counts[k] > SLOW_RATIO * usual]
        peaks += [Stretch(begin + int(first[k]), int(counts[k]), limit) for k in cut]
    return peaks


def _is_plateau(values: Floats, first: int, count: int, digit: float) -> bool:
    """Whether a stretch is the plateau of a synthetic pulse, between its ramps."""
    sides = [np.abs(np.diff(side)) for side in _sides(values, first, count)]
    return all(
        len(steps) >= MIN_SIDE
        and _is_ramp(steps, digit)
        and MIN_LINE * digit <= steps[0] <= MAX_JUMP * steps[1:].max()
        for steps in sides
    )


def _digit(levels: Floats, count: int) -> float:
    """Return the digit to which a signal that comes to its levels `count` times is rounded.

    Without repetition it is the smallest gap between levels; else it divides all gaps.
    If levels of a converter were printed to less than their distance, that distance is the
    digit: the gaps are its multiples to within one printed digit.
    """
    gaps = np.diff(levels)
    rounding = ROUNDING * float(gaps.sum())
    gaps = gaps[gaps > rounding]
    printed = float(gaps.min())
    if count < MIN_REPETITION * len(levels):
        return printed
    while printed > rounding:
        rest = np.abs(gaps - printed * np.rint(gaps / printed))
        rest = rest[rest > rounding]
        if not len(rest):
            break
        printed = float(rest.min())
    digit = float(gaps[gaps < 1.6 * gaps.min()].mean())
    for _ in range(3):
        multiples = np.rint(gaps / digit)
        digit = float(gaps @ multiples) / float(multiples @ multiples)
    off = np.abs(gaps - digit * np.rint(gaps / digit))
    return digit if off.max() <= ROUNDED_LINE * printed else printed


def _sides(values: Floats, first: int, count: int) -> tuple[Floats, Floats]:
    """Return the samples before and after a stretch with one of its own, nearest first."""
    before, after = values[max(first - APPROACH, 0) : first + 1], values[first + count - 1 :]
    return before[::-1], after[: APPROACH + 1]


def _is_cut(values: Floats, first: int, count: int, digit: float) -> bool:
    """Whether a signal runs into its limit, and off it, at full slope."""
    return all(_is_abrupt(side, count, digit) for side in _sides(values, first, count))


def _is_abrupt(side: Floats, count: int, digit: float) -> bool:
    """Whether the samples beside a limit, nearest first, are those of a peak that goes on.

    A quantised parabola that shows `count` equal samples at its peak is not steeper beside them
    than 4 (count + 1) / (count - 1)² digits a sample, and its rounding adds one.
    """
    steps = np.abs(np.diff(side))
    if len(side) <= MIN_SIDE:
        return False
    slope = (steps[0] + steps[1]) / 2
    if slope <= (4 * (count + 1) / (count - 1) ** 2 + 1) * digit:
        return False
    return not _is_ramp(steps, digit)


def _is_ramp(steps: Floats, digit: float) -> bool:
    """Whether steps beside a limit are those of a synthetic pulse.

    Its ramp is a line, or one step, or has a rounded corner.
    """
    rest = int(np.argmax(steps == 0)) if (steps == 0).any() else len(steps) + 1
    ramp = steps[1 : rest - 1]
    is_line = not len(ramp) or np.ptp(ramp) <= max(
        ROUNDED_LINE * digit, LINE_RATIO * ramp.max()
    )
    return bool(is_line or steps[:2].max() < SMALL_STEP * steps.max())
