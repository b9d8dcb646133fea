"""From printed times to where samples lie: on an even grid, with holes in it, or unevenly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drysim.errors import RecordError
from drysim.excitation.record.columns import Columns, Floats

JITTER = 1e-3
"""Share of a step by which any sample may leave the even grid: ü hardly changes within it."""

LARGEST_SLACK = 0.02
"""Share of a step that the rounding of printed times may take: enough for 256 Hz to 1e-4 s."""

LAST_DIGIT = 0.6
"""Units of the last printed digit: rounding takes a half, the rest is binary."""

SINGLE = 2.0**-23
"""Relative rounding of times that once were single precision."""

SHORTEST = 1e-300
"""Below this step [s] its rate would overflow."""

HOLE = 1.5
"""From this many usual steps on, a step is a hole in which samples are missing."""

POOR = "give `rate` or `step` in place of `time` where only the printed times are poor"
"""What to say of times that samples cannot have had."""


class Grid(NamedTuple):
    """Where samples lie.

    Attributes
    ----------
    dt : float
        Their distance; of uneven times the mean one, holes left out [s].
    first : float
        Time of the first [s].
    at : ndarray, shape (n,), or None
        Steps of `dt` from the first sample to each; None where none is missing.
    spread : tuple of float, or None
        Least and greatest step [s] of uneven times; None where all lie on the grid.
    """

    dt: float
    first: float
    at: Floats | None = None
    spread: tuple[float, float] | None = None


def grid_of(
    t: Floats, second: float, columns: Columns, index: int, may_jitter: bool = False
) -> Grid:
    """Give where the samples of printed times lie.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times as printed.
    second : float
        The unit of `t` [s].
    columns : Columns
    index : int
        0-based column of the times.
    may_jitter : bool
        Whether uneven times may stand, because the record is to be resampled.

    Raises
    ------
    RecordError
        When time stands still, runs backwards, or its steps are uneven; the row is named.

    Notes
    -----
    The times may be rounded: a whole number of samples in a unit of time is preferred where the
    printed digits allow it, else the mean step counts.
    """
    steps = np.diff(t)
    halt = np.flatnonzero(steps <= 0)
    if halt.size:
        row = int(halt[0]) + 1
        what = "runs backwards" if steps[row - 1] < 0 else "stands still"
        sentence = f"time {what}: from {t[row - 1]:.12g} to {t[row]:.12g}"
        raise columns.at(row, index, sentence + ("" if steps[row - 1] < 0 else f"; {POOR}"))
    digit, first = columns.last_digit(index), float(t[0]) * second
    dt = _even(t, np.arange(float(len(t))), digit, second)
    if dt is not None:
        return Grid(dt, first)
    usual = float(np.median(steps))
    at = np.concatenate(([0.0], np.cumsum(np.rint(steps / usual))))
    dt = _even(t, at, digit, second) if at[-1] >= len(t) else None
    if dt is not None:
        return Grid(dt, first, at)
    if not may_jitter:
        raise _uneven(steps, usual, columns, index)
    short = steps[steps <= HOLE * usual]
    # Of uneven steps the mean tells the rate, where the median may lie off it by chance.
    mean, spread = float(short.mean()), (float(short.min()), float(short.max()))
    return Grid(
        mean * second, first, (t - t[0]) / mean, (spread[0] * second, spread[1] * second)
    )


def _even(t: Floats, at: Floats, digit: float, second: float) -> float | None:
    """Give the step [s] of times that lie at whole numbers of it; None where they do not.

    `digit` is the unit of the last one that they are printed with.
    """
    dt = float(t[-1] - t[0]) / float(at[-1])
    largest = float(np.abs(t[[0, -1]]).max())
    rounding = LAST_DIGIT * digit + 4 * np.spacing(largest)
    slack = max(rounding, JITTER * dt, SINGLE * largest)
    rate = round(1 / max(dt * second, SHORTEST))
    if rate and _leaves(t, at, 1 / rate / second) <= min(rounding, LARGEST_SLACK * dt):
        return 1 / rate
    if _leaves(t, at, neat := _neat(dt, t, at[-1])) <= min(slack, LARGEST_SLACK * dt):
        return neat * second
    return None


def _neat(dt: float, t: Floats, steps: float) -> float:
    """The step with 12 digits where the last time cannot tell the difference."""
    neat = float(f"{dt:.12g}")
    return neat if abs(neat - dt) * (steps + 1) <= 4 * np.spacing(abs(t[-1])) else dt


def _leaves(t: Floats, at: Floats, dt: float) -> float:
    """Half the width of the band around the even grid that holds all times."""
    off = at * -dt
    off += t
    return float(off.max() - off.min()) / 2


def _uneven(steps: Floats, usual: float, columns: Columns, index: int) -> RecordError:
    row = int(np.argmax(np.abs(steps - usual) > LARGEST_SLACK * usual)) + 1
    if abs(steps[row - 1] - usual) <= LARGEST_SLACK * usual:
        row = int(np.argmax(np.abs(steps - usual))) + 1
    sentence = (
        f"the time steps are uneven: {steps[row - 1]:.6g} to this row, {usual:.6g} as a rule, "
        f"{steps.min():.6g} to {steps.max():.6g} in all; `resample` puts the record onto an "
        f"even grid; or {POOR}"
    )
    return columns.at(row, index, sentence)
