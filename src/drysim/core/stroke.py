"""Extremes, crossings and excursions of x_r, from its turning points.

Problem
    How far the mass moves, how often x_r passes zero or reaches a limit, when, and for how
    long. A grid misses what happens between its points.

Method
    Every zero of v_r is known, so that x_r is monotone between two neighbouring points of its
    path. Its extremes are therefore points of the path, and a level is crossed at most once
    between two of them. Only the times of these crossings need the motion itself: they are
    roots bracketed by two turning points, sought first among the samples and then within one
    step, where the motion is in closed form.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, merged
from drysim.core.events import sign
from drysim.core.roots import MAX_BISECTIONS, safeguarded_newton
from drysim.core.trajectory import last_event_index, state_in_step


class PathMeasures(NamedTuple):
    """What follows from the path of a motion.

    Attributes
    ----------
    lowest, highest : float
        Extremes of x_r in the window and after it [m].
    run_lowest, run_highest : float
        Extremes from the start on [m].
    upcrossings, entries : int
        Number of zero crossings with positive slope, and of entries of x_r into the ranges at
        or beyond the limits, in the window.
    half_cycles : int
        Number of peaks between zero crossings in the window.
    """

    lowest: float
    highest: float
    run_lowest: float
    run_highest: float
    upcrossings: int
    entries: int
    half_cycles: int


@compiled
def measure_path(t, x_r, window, ends, limits, peaks):
    """Return the `PathMeasures` of a motion.

    Parameters
    ----------
    t, x_r : array, shape (n,)
        Times [s] and displacements [m] of the start and the turning points.
    window : (float, float, float)
        Begin and end of the window, and the time up to which the extremes count [s].
    ends : (float, float, float)
        x_r at these times [m].
    limits : StrokeLimits
        Infinite for none.
    peaks : array, shape (n + 2,)
        Written: x_r farthest from zero between zero crossings in the window, in order [m].
    """
    (begin, end, last), (x_begin, x_end, x_last) = window, ends
    # The start is no point of a window that begins later.
    first = last_event_index(t, begin) + int(t[0] <= begin)
    until = first
    while until < len(t) and t[until] < end:
        until += 1
    inside = x_r[first:until]
    lowest, highest, upcrossings, entries = extremes_and_crossings(
        t[first:until], inside, x_begin, x_end, end, limits
    )
    count = half_cycle_peaks(inside, x_begin, x_end, peaks)
    if last > end:
        lowest, highest = min(lowest, x_last), max(highest, x_last)
    for i in range(until, len(t)):
        if t[i] < last:
            lowest, highest = min(lowest, x_r[i]), max(highest, x_r[i])
    run_lowest, run_highest = lowest, highest
    for i in range(first):
        run_lowest, run_highest = min(run_lowest, x_r[i]), max(run_highest, x_r[i])
    return PathMeasures(lowest, highest, run_lowest, run_highest, upcrossings, entries, count)


@merged
def extremes_and_crossings(t, x_r, x_begin, x_end, end, limits):
    """Return the extremes of x_r and the counts of zero and limit crossings.

    Parameters
    ----------
    t, x_r : array, shape (events,)
        Time [s] and displacement [m] of the events; x_r is monotone between
        them.
    x_begin, x_end, end : float
        Displacement at both ends of the window [m], and its end [s].
    limits : StrokeLimits
        Stroke limits [m]; infinite for none.

    Returns
    -------
    lowest, highest : float
        Extremes of x_r [m].
    upcrossings, entries : int
        Number of zero crossings with positive slope, and of entries of x_r into the ranges at
        or beyond the limits.
    """
    lowest, highest = min(x_begin, x_end), max(x_begin, x_end)
    upcrossings, entries = 0, 0
    side = sign(x_begin)
    beyond = stroke_side(x_begin, limits)
    for i in range(len(t) + 1):
        x = x_r[i] if i < len(t) else x_end
        if i < len(t):
            lowest, highest = min(lowest, x), max(highest, x)
            if not 0.0 < t[i] < end:
                continue
        if x != 0.0:
            upcrossings += side < 0 and x > 0.0
            side = sign(x)
        now = stroke_side(x, limits)
        entries += now != 0 and now != beyond
        beyond = now
    return lowest, highest, upcrossings, entries


@compiled
def stroke_side(x_r, limits):
    """Return 1 at or beyond the upper stroke limit, -1 at or beyond the lower one, else 0."""
    if x_r >= limits.up:
        return 1
    return -1 if x_r <= -limits.down else 0


@compiled
def half_cycle_peaks(x_r, x_begin, x_end, peaks):
    """Write x_r farthest from zero between zero crossings, in order; return their number.

    Parameters
    ----------
    x_r : array, shape (n,)
        Extreme points of x_r in order [m].
    x_begin, x_end : float
        x_r before and after them [m].
    peaks : array, shape (n + 2,)
        Written [m].
    """
    count, peak = int(ZERO), 0.0
    for i in range(-1, len(x_r) + 1):
        x = x_begin if i < 0 else (x_r[i] if i < len(x_r) else x_end)
        if peak != 0.0 and x != 0.0 and (x > 0.0) != (peak > 0.0):
            peaks[count] = peak
            count, peak = count + 1, 0.0
        if abs(x) > abs(peak):
            peak = x
    if peak != 0.0:
        peaks[count] = peak
        count += 1
    return count


# Excursions to the limits.


class Crossings(NamedTuple):
    """Crossings of limits, in order of time; arrays of shape (n,).

    Attributes
    ----------
    low, high : array
        Times before and after the crossing, between which x_r is monotone [s]; equal where the
        time is known.
    level : array
        Level that is crossed [m].
    side : array
        1 where x_r grows, -1 where it falls.
    enters : array
        Whether an excursion begins, 1 or 0; else it ends.
    """

    low: Any
    high: Any
    level: Any
    side: Any
    enters: Any


@compiled
def limit_crossings(t, x_r, x_end, end, limits, crossings):
    """Write the crossings of the limits; return their number.

    Parameters
    ----------
    t, x_r : array, shape (n,)
        Times [s] and displacements [m] of the start and the turning points.
    x_end, end : float
        x_r at the end of the run [m], and that time [s].
    limits : StrokeLimits
    crossings : Crossings
        Arrays of shape (2 n,), written.
    """
    count, before = int(ZERO), stroke_side(x_r[0], limits)
    for i in range(len(t)):
        last = i + 1 == len(t)
        until, x = (end, x_end) if last else (t[i + 1], x_r[i + 1])
        now = stroke_side(x, limits)
        if now != before:
            for side, enters in ((before, 0), (now, 1)):
                if side != 0:
                    level = limits.up if side > 0 else -limits.down
                    # At a rigid stop x_r equals the limit: no root to find.
                    exact, position = (until, x) if enters == 1 else (t[i], x_r[i])
                    crossings.low[count] = exact if position == level else t[i]
                    crossings.high[count] = exact if position == level else until
                    crossings.level[count] = level
                    crossings.side[count] = 1.0 if x > x_r[i] else -1.0
                    crossings.enters[count] = enters
                    count += 1
        before = now
    return count


@compiled
def crossing_times(solution, crossings, times):
    """Write the times of crossings in a part of a motion over samples [s].

    Parameters
    ----------
    solution : SampledSolution
    crossings : Crossings
        Time counts from the first sample of the part.
    times : array, shape (n,)
        Written; NaN where a crossing is not in this part.
    """
    for i in range(len(times)):
        times[i] = crossings.low[i]
        if crossings.low[i] < crossings.high[i]:
            bracket = crossings.low[i], crossings.high[i]
            times[i] = crossing_time(solution, crossings.level[i], crossings.side[i], bracket)


@compiled
def crossing_time(solution, level, side, bracket):
    """Return the time at which x_r crosses a level in a direction, once in a bracket [s].

    NaN where it crosses the level after the last sample.
    """
    dt, last = solution.scene.dt, len(solution.scene.u_dd) - 2
    lo, hi = max(bracket[0], 0.0), min(bracket[1], (last + 1) * dt)
    # The first sample at which the level is passed ends the step of the crossing.
    n, after = min(int(lo / dt), last), min(int(hi / dt), last) + 1
    while after - n > 1:
        middle = (n + after) // 2
        x = state_in_step(solution, middle, middle * dt)[0]
        n, after = (middle, after) if side * (x - level) < 0.0 else (n, middle)
    lo, hi = max(lo, n * dt), min(hi, after * dt)
    if hi < bracket[1] and side * (state_in_step(solution, n, hi)[0] - level) < 0.0:
        return math.nan
    t = 0.5 * (lo + hi)
    for _ in range(MAX_BISECTIONS):
        x, v, _ = state_in_step(solution, n, t)
        lo, hi, t, done = safeguarded_newton(lo, hi, t, side * (level - x), -side * v)
        if done:
            break
    return t


@compiled
def sum_excursions(crossings, times, sides, end, repeats):
    """Return the numbers of excursions to the limits, the first time and the total time.

    Parameters
    ----------
    crossings, times : Crossings, array, shape (n,)
        Crossings of the limits, and their times [s].
    sides : (int, int)
        `stroke_side` at the start and at the end.
    end : float
        End of the motion [s].
    repeats : bool
        Whether the end continues at the start, as on a periodic orbit.

    Returns
    -------
    up, down : int
        Number of excursions to either limit.
    first : float
        Time of the first one [s]; negative if there is none.
    beyond : float
        Total time at or beyond the limits [s].
    """
    before, after = sides
    up, down = int(before > 0), int(before < 0)
    first = 0.0 if before != 0 else -1.0
    # The total time is the sum of the leaving times minus that of the entering times.
    entered, left = 0.0, end if after != 0 else 0.0
    for i in range(len(times)):
        if crossings.enters[i] == 0.0:
            left += times[i]
            continue
        entered += times[i]
        first = times[i] if up + down == 0 else first
        up, down = up + int(crossings.side[i] > 0.0), down + int(crossings.side[i] < 0.0)
    # On an orbit, an excursion across the end of the period counts once.
    if repeats and before != 0 and after == before and up + down > 1:
        up, down = up - int(after > 0), down - int(after < 0)
    return up, down, first, max(left - entered, 0.0)
