"""Stroke metrics: excursions beyond the stroke limit, Eq. (5), contacts and extremes.

`excursions` covers the whole run and `impacts` the end stops in a window; the others count
crossings and extrapolate to the largest stroke in an hour. All of them use the path of the
continuous solution, which contains every crossing and every peak.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from drysim.approach.solution import Floats, Trajectory
from drysim.core.model import StrokeLimits

if TYPE_CHECKING:
    from drysim.approach.exact import UnreachedStopsTrajectory
    from drysim.approach.piecewise import PiecewiseTrajectory

HOUR = 3600.0

MIN_HALF_CYCLES = 150
"""Fewest half cycles for an extrapolation."""

MIN_TAIL_PEAKS, TAIL_SHARE = 30, 0.1
"""Peaks in the tail: at least this many, and at least this share of all."""


class Excursions(NamedTuple):
    """Intervals of time with x_r at or beyond a limit; or columns of those of many cases."""

    up: Any
    down: Any
    """Number of intervals on either side."""
    t_first: Any
    """Beginning of the first [s]."""
    t_beyond: Any
    """Total length [s]."""


def excursions(
    trajectory: Trajectory, limits: StrokeLimits, repeats: bool = False
) -> Excursions:
    """Return the excursions in a whole run, settling time and touching included.

    Parameters
    ----------
    trajectory : Trajectory
    limits : StrokeLimits
    repeats : bool
        Whether the end continues at the start, as on a periodic orbit.

    Notes
    -----
    Between two turning points a limit is passed at most once, so that no excursion is missed.
    """
    path = trajectory.path
    t = np.append(path.t, trajectory.end)
    x_r = np.append(path.x_r, trajectory.state(trajectory.end).x_r)
    side = limits.side(x_r)
    changes = np.flatnonzero(side[1:] != side[:-1]).tolist()
    sides = [one for one in side[[0, *(i + 1 for i in changes)]].tolist() if one]
    enters: list[float] = [0.0] if side[0] else []
    leaves: list[float] = []
    for i in changes:
        bracket = float(t[i]), float(t[i + 1]), bool(x_r[i + 1] > x_r[i])
        for at, times in ((i, leaves), (i + 1, enters)):
            if not side[at]:
                continue
            level = limits.up if side[at] > 0 else -limits.down
            # x_r equals the limit at a rigid stop: no root to find.
            times.append(
                float(t[at])
                if x_r[at] == level
                else level_crossing_time(trajectory, level, *bracket)
            )
    if len(leaves) < len(enters):
        leaves.append(trajectory.end)
    # On an orbit, an excursion at the end and one at the start are the same.
    if repeats and side[0] and side[-1] == side[0] and len(enters) > 1:
        sides.pop()
    beyond = max(float(sum(leaves) - sum(enters)), 0.0)
    return Excursions(sides.count(1), sides.count(-1), min(enters, default=None), beyond)


def level_crossing_time(
    trajectory: Trajectory, level: float, lo: float, hi: float, rising: bool
) -> float:
    """Return the time at which x_r passes a level once between two times.

    Parameters
    ----------
    trajectory : Trajectory
    level : float
        Level of x_r [m].
    lo, hi : float
        Times on either side of the crossing [s].
    rising : bool
        Whether x_r is larger at `hi`.

    Returns
    -------
    float
        Time [s], accurate to rounding.
    """
    from drysim.approach.coulomb import SampledTrajectory
    from drysim.core.roots import MAX_BISECTIONS, safeguarded_newton

    if isinstance(trajectory, SampledTrajectory) and not trajectory.law.variation:
        return trajectory.crossing_time(level, lo, hi, 1 if rising else -1)
    t, side = 0.5 * (lo + hi), 1.0 if rising else -1.0
    for _ in range(MAX_BISECTIONS):
        x_r, v_r = trajectory.state(t)[:2]
        lo, hi, t, done = safeguarded_newton(lo, hi, t, side * (level - x_r), -side * v_r)
        if done:
            break
    return float(t)


class StopLoads(NamedTuple):
    """Number and severity of the contacts with the end stops."""

    up: int
    down: int
    """Number of contacts with the upper and with the lower stop."""
    speed: float
    """Largest |v_r| at a contact [m/s]."""
    force: float | None
    """Largest force between mass and bumper [N]; None for rigid stops."""
    impulse: float | None
    """Largest impulse of an impact [N·s]; None for bumpers."""


def impacts(trajectory: Trajectory, window: tuple[float, float], repeats: bool) -> StopLoads:
    """Return number and severity of the contacts with the end stops in a window.

    Parameters
    ----------
    trajectory : Trajectory
        Of a scene with end stops.
    window : tuple of float
        Begin and end [s].
    repeats : bool
        Whether the end continues at the start, as on a periodic orbit.
    """
    stops = trajectory.law.stops
    assert stops is not None, "only called with end stops"
    solution = cast("PiecewiseTrajectory | UnreachedStopsTrajectory", trajectory)
    begin, end = window
    t, v_r = solution.hits()
    inside = (t > begin) & (t <= end)
    if begin == 0.0 and not repeats:
        inside |= t == 0.0
    fastest = float(np.abs(v_r[inside]).max(initial=0.0))
    up = int(np.count_nonzero(~np.signbit(v_r[inside])))
    return StopLoads(
        up,
        int(inside.sum()) - up,
        fastest,
        None if stops.rigid else solution.peak_bumper_force(begin, end),
        trajectory.plant.m * (1.0 + stops.e) * fastest if stops.rigid else None,
    )


def path_in_window(trajectory: Trajectory, window: tuple[float, float]) -> Floats:
    """Return x_r [m] at the ends of a window and at the turning points in it, in order."""
    (begin, end), path = window, trajectory.path
    inside = path.x_r[(path.t > begin) & (path.t < end)]
    ends = trajectory.state(begin).x_r, trajectory.state(end).x_r
    return np.concatenate(([ends[0]], inside, [ends[1]]))


def count_upcrossings(path: Floats) -> int:
    """Return the number of upward zero crossings of x_r."""
    sides = np.sign(path[path != 0.0])
    return int(np.count_nonzero((sides[1:] > 0) & (sides[:-1] < 0)))


def count_limit_entries(path: Floats, limits: StrokeLimits) -> int:
    """Return how often x_r reaches a limit, on either side."""
    sides = limits.side(path)
    return int(np.count_nonzero((sides[1:] != 0) & (sides[1:] != sides[:-1])))


def half_cycle_peaks(path: Floats) -> Floats:
    """Return x_r farthest from zero [m] between consecutive zero crossings, in order.

    `path` has the extreme points of x_r in order [m].
    """
    moved: Floats = path[path != 0.0]
    if not len(moved):
        return moved
    changes = np.flatnonzero((moved[1:] > 0.0) != (moved[:-1] > 0.0)) + 1
    first = np.concatenate(([0], changes))
    heights = np.maximum.reduceat(np.abs(moved), first)
    return np.asarray(np.copysign(heights, moved[first]), dtype=np.float64)


def hourly_stroke(heights: Floats, length: float, sides: int = 2) -> float | None:
    """Return the stroke exceeded once an hour on average, extrapolated [m].

    Parameters
    ----------
    heights : ndarray
        Peaks of the half cycles [m].
    length : float
        Time in which they were observed [s].
    sides : {1, 2}, optional
        1 if the peaks are those of one side: half as many are needed, and make a tail.

    Returns
    -------
    float or None
        None with fewer than `MIN_HALF_CYCLES` peaks on both sides.

    Notes
    -----
    Peaks over threshold: the threshold is the next peak below the largest tenth (at least 30
    peaks). The excess of the squared peaks over the squared threshold is taken as exponential
    with its mean s. This is a Weibull tail of exponent 2, exact for peaks of narrow-band
    Gaussian motion (Rice), fitted to the tail that friction leaves and not to its RMS. With n
    peaks in the tail the standard error of the squared stroke is s ln(n HOUR/length)/√n, and
    more where peaks cluster. Coles, An Introduction to Statistical Modeling of Extreme Values
    (2001), chapter 4. The result is an extrapolation, not a bound.
    """
    if len(heights) < MIN_HALF_CYCLES * sides // 2:
        return None
    count = max(MIN_TAIL_PEAKS * sides // 2, int(TAIL_SHARE * len(heights)))
    squares = np.square(np.sort(heights)[-count - 1 :])
    excess = float(np.mean(squares[1:] - squares[0]))
    often = max(math.log(count * HOUR / length), 0.0)
    return math.sqrt(float(squares[0]) + excess * often)
