"""Profile likelihood: intervals of fitted parameters from the rise of the sum of squares.

One parameter is fixed and the others are fitted again. The interval ends where the sum of
squares has risen by 3.84 noise variances (likelihood ratio, 95 %). Where the noise of the base
colours the residuals, the rise is divided by the ratio of the variance of the parameter to that
under white residuals: the adjustment of a composite likelihood (Pace, Salvan and Sartori 2011,
Statistica Sinica 21, 129).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drysim.core.model import Floats
from drysim.scenario.model import STATIC_PATHS
from drysim.study.fit_least_squares import (
    DIFFERENCE,
    ROUNDING,
    SCAN,
    Solution,
    minimise,
    perturbed,
    sizes,
)
from drysim.study.statistics import NORMAL_95

PROFILE_CALLS = 6
"""Limit of the evaluations of a fit at one value of a profile, without those for
derivatives."""

CHI_SQUARE_95 = NORMAL_95**2
"""Quantile of chi-square for a 95 % interval of one parameter."""

PROFILE_POINTS = 12
"""Number of fits for one end of a profile interval, once a value beyond it is known."""

PROFILE_GROWTH = 10.0
"""Largest ratio of the distances of two such fits from the solution, and of the part that one
of them takes from what is left."""

FARTHEST = 1e3
"""Distance, in sizes of a parameter, within which a profile looks for the end."""

STATIC_RATIOS = np.geomspace(1.0, 1e3, 25).tolist()
"""Ratios of static to kinetic friction tried for the interval of a static limit."""

BISECTIONS = 6
"""Number of halvings of the scan at each end of the interval of a static limit."""

PROFILE_TOLERANCE = 0.05
"""Accuracy of the rise of the sum of squares at an end of a profile interval; where the rise
jumps, that of the distance of the end."""


class ProfilePoint(NamedTuple):
    """Value of one scaled parameter, rise of the sum of squares, and all parameters there.

    The rise is in noise variances, adjusted for the noise of the base.
    """

    value: float
    rise: float
    x: Floats


class ParameterProfile(NamedTuple):
    """Both ends of the profile interval of a scaled parameter, and its points in order."""

    low: float | None
    high: float | None
    points: Sequence[ProfilePoint]


def profile_of(solution: Solution, determined: Sequence[int], j: int) -> ParameterProfile:
    """Return the profile of a parameter.

    The other parameters are fitted again, as far as the record determines them.
    """
    others = [i for i in determined if i != j]
    points = [ProfilePoint(float(solution.x[j]), 0.0, solution.x)]
    size, deviation = float(sizes(solution.x)[j]), solution.deviation(j)
    step = 0.1 * size
    if deviation > 0.0:
        step = float(np.clip(NORMAL_95 * deviation, ROUNDING * size, size))
    is_static = solution.squares.model.parameters[j].key.startswith(STATIC_PATHS)
    least = 0.0 if is_static else NORMAL_95 * deviation  # events decide over a static limit
    ends = []
    for sign in (-1.0, 1.0):
        end, tried = _profile_end(solution, others, j, sign * step, least)
        ends.append(end)
        points += tried
    profile = ParameterProfile(ends[0], ends[1], sorted(points, key=lambda point: point[:2]))
    if is_static and solution.squares.leaves_out_events:
        return _over_all_samples(solution, j, profile)
    return profile


def _over_all_samples(
    solution: Solution, j: int, selected: ParameterProfile
) -> ParameterProfile:
    """Return the profile of a static limit over all samples, given that of the selected ones.

    A static limit decides at the events themselves, next to which no sample is selected. Over
    all samples the sum of squares has several minima, one for each order of events. The
    interval spans all values that are as good as the best one, and those that the selected
    samples do not exclude. The other parameters are as fitted, or as refitted to the latter.
    """
    squares = solution.squares
    least = squares.cost(solution.x)

    def point(x: Floats) -> ProfilePoint:
        rise = (squares.cost(x) - least) / solution.inflation(j)
        return ProfilePoint(float(x[j]), rise, x)

    starts = [
        *(point.x for point in selected.points),
        *perturbed(squares, solution.x, j, SCAN),
        *perturbed(squares, solution.x, j, _static_changes(solution, j)),
    ]
    points = sorted(map(point, starts), key=lambda point: point[:2])
    ends: list[float | None] = []
    for sign, selected_end in ((1, selected.low), (-1, selected.high)):
        for _ in range(BISECTIONS):
            ordered = points[::sign]
            first = _first_within(ordered)
            if first == 0:
                break
            x = solution.x.copy()
            x[j] = 0.5 * (ordered[first].value + ordered[first - 1].value)
            points = sorted([*points, point(x)], key=lambda point: point[:2])
        ordered = points[::sign]
        first = _first_within(ordered)
        # The interval is rather too wide than too narrow.
        if first == 0 or selected_end is None:
            ends.append(None)
        else:
            ends.append(sign * min(sign * ordered[first - 1].value, sign * selected_end))
    return ParameterProfile(ends[0], ends[1], points)


def _static_changes(solution: Solution, j: int) -> list[float]:
    """Return the relative changes of a static limit to all multiples of kinetic friction.

    They reach values that few motions survive, wherever the fit has left the static limit.
    """
    x, scale = solution.x, solution.squares.scale
    law = solution.squares.model.scene(np.clip(x * scale, *solution.squares.model.bounds)).law
    kinetic = float(x[j]) * law.F_fk / (law.F_fs or 1.0)
    return [(kinetic * ratio - float(x[j])) / float(sizes(x)[j]) for ratio in STATIC_RATIOS]


def _first_within(points: Sequence[ProfilePoint]) -> int:
    """Return the index of the first point that is as good as the best one, at 95 %."""
    limit = min(point.rise for point in points) + CHI_SQUARE_95
    return next(i for i, point in enumerate(points) if point.rise <= limit)


def _profile_end(
    solution: Solution, others: list[int], j: int, step: float, least: float = 0.0
) -> tuple[float | None, list[ProfilePoint]]:
    """Return one end of a profile interval by the secant rule on the root of the rise.

    An end is a value that the record excludes: None where there is none up to the bound of the
    parameter, or far beyond its size. The signed `step` leads to the first point; where the
    rise jumps, the end is no nearer than the distance `least`.
    """
    start, sign = float(solution.x[j]), float(np.sign(step))
    limit = solution.squares.bounds[0 if sign < 0 else 1][j]
    farthest = FARTHEST * float(sizes(solution.x)[j])
    wanted, inner, outer = abs(step), (0.0, 0.0), np.inf
    points: list[ProfilePoint] = []
    while np.isinf(outer) or len(points) < PROFILE_POINTS:
        value = start + sign * wanted
        bounded = (value - limit) * sign >= 0.0
        value = float(limit) if bounded else value
        points.append(_profile_point(solution, others, j, value))
        rise, step = points[-1].rise, abs(value - start)
        if abs(rise - CHI_SQUARE_95) < PROFILE_TOLERANCE * CHI_SQUARE_95:
            return value, points
        if rise < CHI_SQUARE_95 and (bounded or step >= farthest):
            return None, points
        root = float(np.sqrt(max(rise, 0.0)))
        slope = (root - inner[1]) / (step - inner[0])
        if rise < CHI_SQUARE_95:
            inner = step, root
        else:
            outer = step
        if outer - inner[0] < PROFILE_TOLERANCE * outer:
            break
        near, far = inner[0], min(outer, PROFILE_GROWTH * step)
        wanted = near + (NORMAL_95 - inner[1]) / slope if slope > 0.0 else far
        if np.isinf(outer):
            wanted = min(wanted, far)
        elif not near + (far - near) / PROFILE_GROWTH < wanted < far or len(points) % 3 == 0:
            wanted = 0.5 * (near + far)  # secants alone may approach from one side, slowly
    # The rise jumps where a stop is just made or just missed, perhaps next to the solution:
    # rather too wide than too narrow, and no narrower than by the covariance.
    end = start + sign * max(outer, least)
    return float(min(end, limit) if sign > 0 else max(end, limit)), points


def _profile_point(solution: Solution, others: list[int], j: int, value: float) -> ProfilePoint:
    """Return the point of a profile at a value of one parameter, the others fitted."""
    squares, x = solution.squares, solution.x.copy()
    x[j] = value

    residuals = squares.over(solution.mask).of(x, others)
    best = x[others]
    if others:
        bounds = squares.bounds[0][others], squares.bounds[1][others]
        slopes = solution.jacobian
        change = -np.linalg.lstsq(slopes[:, others], slopes[:, j], rcond=None)[0]
        # Where the motion jumps, the derivatives are rounding.
        starts = [best, np.clip(best + change * (value - solution.x[j]), *bounds)]
        best = min(starts, key=lambda start: float(np.sum(residuals.value(start) ** 2)))
        best = minimise(residuals, best, DIFFERENCE, bounds, PROFILE_CALLS)
    rise = float(np.sum(residuals.value(best) ** 2)) - solution.sum_of_squares
    x[others] = best
    return ProfilePoint(value, rise / solution.inflation(j), x)
