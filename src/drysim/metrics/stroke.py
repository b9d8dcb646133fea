"""Stroke metrics: excursions beyond the stroke limit, Eq. (5), contacts and extremes.

`excursions` covers the whole run and `impacts` the end stops in a window; the others count
crossings and extrapolate to the largest stroke in an hour. All of them use the path of the
continuous solution, which contains every crossing and every peak.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drysim.approach.solution import Path, Trajectory
from drysim.core.compile import as_engine_array
from drysim.core.model import Floats, StrokeLimits

if TYPE_CHECKING:
    from drysim.core.stroke import Crossings, PathMeasures

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
    from drysim.core.stroke import Crossings, sum_excursions

    path, end = trajectory.path, trajectory.end
    x_end = float(trajectory.state(end).x_r)
    if limits.up > max(path.x_r.max(), x_end) and -limits.down < min(path.x_r.min(), x_end):
        return Excursions(0, 0, None, 0.0)
    crossings = crossings_of(path, x_end, end, limits)
    times = as_engine_array(trajectory.crossing_times(crossings))
    sides = int(limits.side(path.x_r[0])), int(limits.side(x_end))
    columns = Crossings(*map(as_engine_array, crossings))
    up, down, first, beyond = sum_excursions(columns, times, sides, end, repeats)
    return Excursions(up, down, first, beyond)


def crossings_of(path: Path, x_end: float, end: float, limits: StrokeLimits) -> Crossings:
    """Return the crossings of the limits of a run that ends at x_end [m] and end [s]."""
    from drysim.core.stroke import Crossings, limit_crossings

    crossings = Crossings(*map(as_engine_array, np.empty((5, 2 * len(path.t)))))
    t, x_r = as_engine_array(path.t), as_engine_array(path.x_r)
    count = limit_crossings(t, x_r, x_end, end, limits, crossings)
    return Crossings(*(np.asarray(column[:count]) for column in crossings))


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
    begin, end = window
    t, v_r = trajectory.hits()
    inside = (t > begin) & (t <= end)
    if begin == 0.0 and not repeats:
        inside |= t == 0.0
    fastest = float(np.abs(v_r[inside]).max(initial=0.0))
    up = int(np.count_nonzero(~np.signbit(v_r[inside])))
    return StopLoads(
        up,
        int(inside.sum()) - up,
        fastest,
        None if stops.rigid else trajectory.peak_bumper_force(begin, end),
        trajectory.plant.m * (1.0 + stops.e) * fastest if stops.rigid else None,
    )


def path_measures(
    trajectory: Trajectory, window: tuple[float, float, float], limits: StrokeLimits
) -> tuple[PathMeasures, Floats]:
    """Return what follows from the path, and the peaks of the half cycles in a window.

    Parameters
    ----------
    trajectory : Trajectory
    window : tuple of float
        Begin, end, and the time up to which extremes count [s].
    limits : StrokeLimits

    Returns
    -------
    measures : PathMeasures
    peaks : ndarray
        x_r farthest from zero [m] between consecutive zero crossings, in order.
    """
    from drysim.core.stroke import measure_path

    path = trajectory.path
    ends = tuple(float(trajectory.state(t).x_r) for t in window)
    t, x_r, peaks = map(as_engine_array, (path.t, path.x_r, np.empty(len(path.t) + 2)))
    measures = measure_path(t, x_r, window, ends, limits, peaks)
    return measures, np.asarray(peaks[: measures.half_cycles])


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
    (2001), chapter 4. The result is an extrapolation, not a bound. A larger peak, as of a
    pothole, that was reached in less than an hour takes its place.
    """
    if len(heights) < MIN_HALF_CYCLES * sides // 2:
        return None
    count = max(MIN_TAIL_PEAKS * sides // 2, int(TAIL_SHARE * len(heights)))
    ascending = heights.copy()
    ascending.sort()
    squares = np.square(ascending[-count - 1 :])
    excess = float((squares[1:] - squares[0]).sum()) / count
    often = max(math.log(count * HOUR / length), 0.0)
    extrapolated = math.sqrt(float(squares[0]) + excess * often)
    return max(extrapolated, float(ascending[-1])) if length < HOUR else extrapolated
