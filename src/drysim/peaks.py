"""Statistics of the stroke: crossings, and what an hour of the same motion would need."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.track import Path, Track

HOUR = 3600.0

FEWEST = 150
"""Half cycles below which nothing is extrapolated."""

TOP, SHARE = 30, 0.1
"""Peaks in the tail: that many at least, and that share of all."""

Values = dict[str, float | int | None]
"""Metrics by name; None for one that is not known."""


def stroke_statistics(path: Floats, length: float, x_rM: float | None, goes_on: bool) -> Values:
    """Give crossing_rate, limit_rate and stroke_once_an_hour; None where unknown.

    Parameters
    ----------
    path : ndarray
        x_r [m] at both ends of the window and where it came by in it, in order.
    length : float
        Of the window [s].
    x_rM : float or None
        Stroke limit [m].
    goes_on : bool
        Whether the motion may be taken to go on as in the window, as noise and records are.

    Notes
    -----
    Counted in the continuous solution: its path tells every passage and every peak.
    """
    values: Values = {"crossing_rate": upcrossings(path) / length}
    if x_rM is not None:
        values["limit_rate"] = entries(path, x_rM) / length
    if goes_on:
        values["stroke_once_an_hour"] = once_an_hour(half_cycles(path), length)
    return values


def path_of(track: Track, path: Path, window: tuple[float, float]) -> Floats:
    """Give x_r [m] at the ends of a window and where its path comes by in it, in order."""
    begin, end = window
    inside = path.x_r[(path.t > begin) & (path.t < end)]
    ends = track.state(begin).x_r, track.state(end).x_r
    return np.concatenate(([ends[0]], inside, [ends[1]]))


def upcrossings(path: Floats) -> int:
    """Give how often x_r passes zero upwards."""
    sides = np.sign(path[path != 0.0])
    return int(np.count_nonzero((sides[1:] > 0) & (sides[:-1] < 0)))


def entries(path: Floats, x_rM: float) -> int:
    """Give how often |x_r| reaches a limit [m] from below, on either side."""
    sides = np.where(np.abs(path) >= x_rM, np.sign(path), 0.0)
    return int(np.count_nonzero((sides[1:] != 0) & (sides[1:] != sides[:-1])))


def half_cycles(path: Floats) -> Floats:
    """Give the greatest |x_r| [m] between every two passages of zero, in order."""
    moved: Floats = path[path != 0.0]
    if not len(moved):
        return moved
    changes = np.flatnonzero(np.sign(moved[1:]) != np.sign(moved[:-1])) + 1
    first = np.concatenate(([0], changes))
    return np.asarray(np.maximum.reduceat(np.abs(moved), first), dtype=np.float64)


def once_an_hour(heights: Floats, length: float) -> float | None:
    """Give the stroke that is met once an hour on average, extrapolated [m].

    Parameters
    ----------
    heights : ndarray
        Peaks of the half cycles [m].
    length : float
        Time in which they were seen [s].

    Returns
    -------
    float or None
        None with fewer than `FEWEST` peaks.

    Notes
    -----
    Peaks over threshold: the squares of the greatest tenth of all peaks (30 at least), less
    that of the next lower one, are taken as exponential, with their mean. That is a Weibull
    tail of exponent 2, exact for the peaks of narrow-band Gaussian motion (Rice), here fitted
    to the tail that friction has left and not to its RMS. With n peaks in the tail and s their
    mean excess, the standard error of the squared stroke is s ln(n HOUR/length)/√n, more where
    peaks come in clusters. Coles, An Introduction to Statistical Modeling of Extreme Values
    (2001), chapter 4. It is an extrapolation, not a bound.
    """
    if len(heights) < FEWEST:
        return None
    count = max(TOP, int(SHARE * len(heights)))
    squares = np.square(np.sort(heights)[-count - 1 :])
    excess = float(np.mean(squares[1:] - squares[0]))
    often = max(math.log(count * HOUR / length), 0.0)
    return math.sqrt(float(squares[0]) + excess * often)
