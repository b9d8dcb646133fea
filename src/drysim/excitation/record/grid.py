"""From printed times to an even grid: the distance of the samples, or the row against it."""

from __future__ import annotations

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


def spacing(t: Floats, second: float, columns: Columns, index: int) -> float:
    """Give the distance of the samples that printed times tell.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times as printed.
    second : float
        The unit of `t` [s].
    columns : Columns
    index : int
        0-based column of the times.

    Returns
    -------
    float
        Distance [s].

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
        raise columns.at(row, index, f"time {what}: from {t[row - 1]:.12g} to {t[row]:.12g}")
    dt = float(steps.mean())
    largest = float(np.abs(t[[0, -1]]).max())
    rounding = LAST_DIGIT * columns.last_digit(index) + 4 * np.spacing(largest)
    slack = max(rounding, JITTER * dt, SINGLE * largest)
    rate = round(1 / max(dt * second, SHORTEST))
    if rate and _leaves(t, 1 / rate / second) <= min(rounding, LARGEST_SLACK * dt):
        return 1 / rate
    if _leaves(t, neat := _neat(dt, t)) <= min(slack, LARGEST_SLACK * dt):
        return neat * second
    raise _uneven(t, steps, columns, index)


def _neat(dt: float, t: Floats) -> float:
    """The step with 12 digits where the last time cannot tell the difference."""
    neat = float(f"{dt:.12g}")
    return neat if abs(neat - dt) * len(t) <= 4 * np.spacing(abs(t[-1])) else dt


def _leaves(t: Floats, dt: float) -> float:
    """Half the width of the band around the even grid that holds all times."""
    off = np.arange(len(t)) * -dt
    off += t
    return float(off.max() - off.min()) / 2


def _uneven(t: Floats, steps: Floats, columns: Columns, index: int) -> RecordError:
    usual = float(np.median(steps))
    row = int(np.argmax(np.abs(steps - usual) > LARGEST_SLACK * usual)) + 1
    if abs(steps[row - 1] - usual) <= LARGEST_SLACK * usual:
        row = int(np.argmax(np.abs(steps - usual))) + 1
    sentence = (
        f"the time steps are uneven: {steps[row - 1]:.6g} to this row, {usual:.6g} as a rule; "
        "resample the record, or give `rate` or `step` in place of `time` where only the "
        "printed times are poor"
    )
    return columns.at(row, index, sentence)
