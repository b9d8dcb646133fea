"""The stroke: how often and how long |x_r| is beyond its limit, Eq. (5), and what would do.

`excursions` cover the whole run and `impact_metrics` the end stops in a window; `stroke_statistics`
counts crossings, and extrapolates to what an hour of the same motion would need. All of it is
taken from the path of the continuous solution, which tells every passage and every peak.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from drysim.approach.solution import Floats, Path, Trajectory
from drysim.core.model import AnyLaw, AnyState, EndStopLaw

if TYPE_CHECKING:
    from drysim.approach.end_stops import EndStopTrajectory, UnreachedStopsTrajectory

Values = dict[str, float | int | None]
"""Metrics by name; None for one that is not known."""

MAX_NEWTON_STEPS = 100
"""Newton needs about 5 rounds; a halved bracket is down to one float after 60."""


HOUR = 3600.0

MIN_HALF_CYCLES = 150
"""Half cycles below which nothing is extrapolated."""

MIN_TAIL_PEAKS, TAIL_SHARE = 30, 0.1
"""Peaks in the tail: that many at least, and that share of all."""


class Excursions(NamedTuple):
    """Stretches of time with |x_r| at or beyond the limit.

    Attributes
    ----------
    times : int
        Number of stretches.
    t_first : float or None
        Beginning of the first [s].
    t_beyond : float
        Time beyond the limit in all [s].
    """

    times: int
    t_first: float | None
    t_beyond: float


def excursions(
    trajectory: Trajectory, path: Path, x_rM: float, repeats: bool = False
) -> Excursions:
    """Give the excursions of a whole run, settling included; reaching the limit is one.

    Parameters
    ----------
    track : Track
    path : Path
        Of the track, up to its end and for this limit.
    x_rM : float
        Stroke limit [m], above 0.
    repeats : bool
        Whether the end goes on at the start, as on a periodic orbit.

    Notes
    -----
    Between two points of the path the limit is passed once at most: nothing hides there.
    """
    t = np.append(path.t, trajectory.end)
    x_r = np.append(path.x_r, trajectory.state(trajectory.end).x_r)
    side = np.where(np.abs(x_r) >= x_rM, np.sign(x_r), 0.0)
    enters = [0.0] if side[0] else []
    leaves = []
    for i in np.flatnonzero(side[1:] != side[:-1]).tolist():
        bracket = float(t[i]), float(t[i + 1])
        # A rigid stop is met at the limit itself: there is nothing to search for then.
        if side[i]:
            at = abs(x_r[i]) == x_rM
            leaves.append(
                bracket[0] if at else level_crossing_time(trajectory, side[i] * x_rM, *bracket)
            )
        if side[i + 1]:
            at = abs(x_r[i + 1]) == x_rM
            enters.append(
                bracket[1]
                if at
                else level_crossing_time(trajectory, side[i + 1] * x_rM, *bracket)
            )
    if len(leaves) < len(enters):
        leaves.append(trajectory.end)
    # An excursion across the seam of an orbit is one, unless there is nothing else.
    joined = bool(repeats and side[0] and side[-1] == side[0] and len(enters) > 1)
    beyond = max(float(sum(leaves) - sum(enters)), 0.0)
    return Excursions(len(enters) - joined, min(enters, default=None), beyond)


def level_crossing_time(trajectory: Trajectory, level: float, lo: float, hi: float) -> float:
    """Give the time at which x_r, from lo to hi, passes a level [m] in between."""
    rising = trajectory.state(hi).x_r > trajectory.state(lo).x_r
    t = 0.5 * (lo + hi)
    for _ in range(MAX_NEWTON_STEPS):
        x_r, v_r = trajectory.state(t)[:2]
        if x_r == level:
            return t
        lo, hi = (t, hi) if (x_r < level) == rising else (lo, t)
        before = t
        t = t + (level - x_r) / v_r if v_r else lo
        if not lo < t < hi:
            t = 0.5 * (lo + hi)
        if t in (before, lo, hi):
            return hi
    return t


def impact_metrics(
    trajectory: Trajectory, window: tuple[float, float], repeats: bool
) -> Values:
    """Give how often and how hard the mass came to its end stops in a window.

    Parameters
    ----------
    track : Track
        Of a scene with end stops.
    window : tuple of float
        Begin and end [s].
    repeats : bool
        Whether the end goes on at the start, as on a periodic orbit.
    """
    law = trajectory.law
    assert isinstance(law, EndStopLaw), "asked where there are stops only"
    solution = cast("EndStopTrajectory | UnreachedStopsTrajectory", trajectory)
    begin, end = window
    t, v_r = solution.hits()
    inside = (t > begin) & (t <= end)
    if begin == 0.0 and not repeats:
        inside |= t == 0.0
    fastest = float(np.abs(v_r[inside]).max(initial=0.0))
    return {
        "contacts": int(inside.sum()),
        "impact_speed": fastest,
        "impulse_peak": trajectory.plant.m * (1.0 + law.e) * fastest if law.rigid else None,
        "stop_force_peak": None if law.rigid else solution.peak_bumper_force(begin, end),
    }


def bumper_energy(law: AnyLaw, state: AnyState) -> float:
    """Give the energy that a bumper holds in a state [J]; 0 where there is none."""
    if not isinstance(law, EndStopLaw) or abs(state.x_r) < law.x_rM:
        return 0.0
    from drysim.core.modes import TOUCHING, stop_coordinates

    _, xi, touch = stop_coordinates(law, state.x_r, state.v_r)
    return 0.5 * law.k_s * float(xi) ** 2 if abs(touch) == TOUCHING else 0.0


def stroke_statistics(
    path: Floats, length: float, x_rM: float | None, stationary: bool
) -> Values:
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
    """
    values: Values = {"crossing_rate": count_upcrossings(path) / length}
    if x_rM is not None:
        values["limit_rate"] = count_limit_entries(path, x_rM) / length
    if stationary:
        values["stroke_once_an_hour"] = hourly_stroke(half_cycle_peaks(path), length)
    return values


def path_in_window(trajectory: Trajectory, path: Path, window: tuple[float, float]) -> Floats:
    """Give x_r [m] at the ends of a window and where its path comes by in it, in order."""
    begin, end = window
    inside = path.x_r[(path.t > begin) & (path.t < end)]
    ends = trajectory.state(begin).x_r, trajectory.state(end).x_r
    return np.concatenate(([ends[0]], inside, [ends[1]]))


def count_upcrossings(path: Floats) -> int:
    """Give how often x_r passes zero upwards."""
    sides = np.sign(path[path != 0.0])
    return int(np.count_nonzero((sides[1:] > 0) & (sides[:-1] < 0)))


def count_limit_entries(path: Floats, x_rM: float) -> int:
    """Give how often |x_r| reaches a limit [m] from below, on either side."""
    sides = np.where(np.abs(path) >= x_rM, np.sign(path), 0.0)
    return int(np.count_nonzero((sides[1:] != 0) & (sides[1:] != sides[:-1])))


def half_cycle_peaks(path: Floats) -> Floats:
    """Give the greatest |x_r| [m] between every two passages of zero, in order."""
    moved: Floats = path[path != 0.0]
    if not len(moved):
        return moved
    changes = np.flatnonzero(np.sign(moved[1:]) != np.sign(moved[:-1])) + 1
    first = np.concatenate(([0], changes))
    return np.asarray(np.maximum.reduceat(np.abs(moved), first), dtype=np.float64)


def hourly_stroke(heights: Floats, length: float) -> float | None:
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
        None with fewer than `MIN_HALF_CYCLES` peaks.

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
    if len(heights) < MIN_HALF_CYCLES:
        return None
    count = max(MIN_TAIL_PEAKS, int(TAIL_SHARE * len(heights)))
    squares = np.square(np.sort(heights)[-count - 1 :])
    excess = float(np.mean(squares[1:] - squares[0]))
    often = max(math.log(count * HOUR / length), 0.0)
    return math.sqrt(float(squares[0]) + excess * often)
