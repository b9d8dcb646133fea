"""Constrained minimisation of costly functions with few evaluations, by a surrogate model.

Problem
    Minimise one objective, or find the Pareto front of two, over a box, where constraints
    g <= 0 hold. An evaluation solves one or many motions and has no derivatives; objectives are
    continuous, with kinks where an extreme passes from one event to another.

Method
    1. The points of a Latin hypercube fill the box.
    2. Cubic radial basis functions interpolate every objective and every constraint.
    3. One objective: the next points minimise the interpolant where the interpolated
       constraints hold and where they keep a distance from all earlier points. The distance is
       a share of the largest gap, from half (which explores) to nothing (which refines). With
       distances that keep coming back to half of the gap the points become dense in the box,
       so that no minimum is missed for good (Regis and Shoemaker, J. Global Optim. 31 (2005)
       153).
       Two objectives: the next points add most to the area that the front dominates.
    4. The search ends when the interpolants promise no gain in several rounds in a row.

Points are chosen and evaluated in rounds of fixed size, so the result does not depend on how
many are evaluated in parallel. Local methods for one objective (COBYQA, COBYLA) need as many
evaluations for smooth functions, one after another, and give neither a front nor a map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.scenario.sampling import Design as Points

SEED = 1
"""Seed of the Latin hypercube and of the candidates."""

STARTS_PER_KEY = 8
"""Starting points per dimension."""

GAP_SHARES = (0.5, 0.1, 0.02, 0.0)
"""Distance of each new point of a round from all others, as a share of the largest gap."""

FRONT_POINTS = 7
"""New points of a round on a front; one more explores."""

SPREAD, SPREAD_PER_CENTRE = 4096, 512
"""Candidates in the whole box, and around each of the best points."""

WIDTHS = (0.1, 0.02, 0.004)
"""Standard deviations of the candidates around a point, as shares of the box."""

MAX_CENTRES = 24
"""Points of a front around which candidates are placed."""

MIN_DISTANCE = 1e-4
"""Least distance between points, as a share of the box."""

MARGIN = 1e-5
"""Distance of interpolated constraints from their limits, relative to the limits."""

GAIN = 1e-4
"""Relative gain below which a round gains nothing."""

ROUNDS = 3
"""Rounds without gain after which the search ends."""

FRONT_REACH = 1.1
"""Reference point of dominated areas, as a multiple of the span of the front."""

MIN_OBJECTIVE = 1e-12
"""Objective below which gains are absolute."""

MAX_DISTANCES = 1 << 14
"""Most distances between points that are computed together: they stay in the cache."""


class Evaluations(NamedTuple):
    """Evaluated points."""

    points: Floats
    """Points of the unit cube, shape (n, dimensions)."""
    objectives: Floats
    """Shape (n, 1) or (n, 2); NaN where the evaluation failed."""
    constraints: Floats
    """Shape (n, constraints); at most 0 where they hold."""

    def at(self, chosen: NDArray[np.int64]) -> Evaluations:
        """Return some of the evaluations."""
        return Evaluations(*(column[chosen] for column in self))

    def with_more(self, more: Evaluations) -> Evaluations:
        """Return these and more evaluations."""
        return Evaluations(*(np.concatenate(pair) for pair in zip(self, more, strict=True)))

    @property
    def has_numbers(self) -> NDArray[np.bool_]:
        """Which evaluations have numbers."""
        finite = np.isfinite(self.objectives).all(axis=1)
        return np.asarray(finite & np.isfinite(self.constraints).all(axis=1))

    @property
    def excess(self) -> Floats:
        """Largest constraint of each point, at least 0; infinite where it is not known."""
        worst = np.maximum(self.constraints, 0.0).max(axis=1, initial=0.0)
        return np.where(self.has_numbers, worst, np.inf)

    @property
    def admissible(self) -> NDArray[np.bool_]:
        """Which points satisfy all constraints."""
        return np.asarray(self.excess <= 0.0)

    @property
    def best(self) -> int:
        """Index of the admissible point with the least first objective, or of least excess."""
        first = np.where(self.admissible, self.objectives[:, 0], np.inf)
        return int(np.argmin(first if self.admissible.any() else self.excess))

    @property
    def front(self) -> NDArray[np.int64]:
        """Indices of the admissible points that no other dominates, by the first objective."""
        return np.flatnonzero(self.admissible)[pareto(self.objectives[self.admissible])]


Evaluate = Callable[[Floats], Evaluations]
"""Function that evaluates points of shape (n, dimensions) in the unit cube.

The points that it returns may be moved a little, such as to round values.
"""


@dataclass(frozen=True)
class Surrogate:
    """Interpolants of the objectives and the constraints.

    Cubic radial basis functions of the distances from the points, and a linear function. The
    import of `scipy.interpolate` alone would take as long as a hundred motions of a minute.
    """

    points: Floats
    """Where the values are known, shape (n, dimensions); no two are equal."""
    weights: Floats
    """Factors of the radial functions, and of the linear one, shape (n + 1 + dimensions,
    objectives + constraints)."""
    objectives: int
    """Number of objectives, which come first."""
    least: Sequence[float] = ()
    """Least possible value of each objective; none without."""

    @classmethod
    def of(cls, evaluated: Evaluations, least: Sequence[float] = ()) -> Surrogate | None:
        """Return the interpolants of evaluations; None if there are too few."""
        points, first = np.unique(
            evaluated.points[evaluated.has_numbers], axis=0, return_index=True
        )
        count, dimensions = points.shape
        if count < dimensions + 2:
            return None
        if np.linalg.matrix_rank(points - points[0]) < dimensions:
            return None  # the points are on a line or in a plane
        values = np.hstack(evaluated[1:])[evaluated.has_numbers][first]
        # The radial functions together hold no linear function: their sum and first moments
        # are zero.
        system = np.zeros((count + 1 + dimensions,) * 2)
        system[:count] = basis(points, points)
        system[count:, :count] = system[:count, count:].T
        padded = np.zeros((len(system), values.shape[1]))
        padded[:count] = values
        weights = np.asarray(np.linalg.solve(system, padded), dtype=np.float64)
        return cls(points, weights, evaluated.objectives.shape[1], least)

    def at(self, points: Floats) -> Evaluations:
        """Return the interpolated values at points."""
        parts = np.array_split(points, 1 + len(points) * len(self.points) // MAX_DISTANCES)
        values = np.concatenate([basis(part, self.points) @ self.weights for part in parts])
        objectives, constraints = np.split(values, [self.objectives], axis=1)
        if self.least:
            objectives = np.maximum(objectives, self.least)
        return Evaluations(points, objectives, constraints)


def basis(points: Floats, centres: Floats) -> Floats:
    """Return the cubes of the distances of points from centres, a one and the coordinates."""
    squares = squared_distances(points, centres)
    return np.hstack([squares * np.sqrt(squares), np.ones((len(points), 1)), points])


def squared_distances(points: Floats, others: Floats) -> Floats:
    """Return the squared distance of each point from each of others, shape (n, m)."""
    squares = np.zeros((len(points), len(others)))
    for coordinates, other in zip(points.T, others.T, strict=True):
        squares += np.square(coordinates[:, None] - other)
    return squares


def interpolate(points: Floats, values: Floats, others: Floats) -> Floats | None:
    """Return interpolated values at other points; None if there are too few points.

    Parameters
    ----------
    points : ndarray, shape (n, dimensions)
        Where the values are known.
    values : ndarray, shape (n, ...)
    others : ndarray, shape (m, dimensions)

    Returns
    -------
    ndarray, shape (m, ...), or None
    """
    if not (count := len(points)):
        return None
    columns = values.reshape(count, -1)
    surrogate = Surrogate.of(Evaluations(points, columns, np.empty((count, 0))))
    if surrogate is None:
        return None
    return surrogate.at(others).objectives.reshape(len(others), *values.shape[1:])


def search(
    evaluate: Evaluate, dimensions: int, least: Sequence[float], limit: int
) -> tuple[Evaluations, bool]:
    """Return the evaluations of a search, and whether it ended because nothing can be gained.

    Parameters
    ----------
    evaluate : callable
        Evaluates new points.
    dimensions : int
    least : sequence of float
        Least possible value of each objective: one, or two for a Pareto front.
    limit : int
        Largest number of evaluations.
    """
    random, objectives = np.random.default_rng(SEED), len(least)
    starts = STARTS_PER_KEY * dimensions
    points = Points("latin", starts, dimensions, SEED).take(np.arange(starts))
    # The first few fill the box as well, if there are to be no more.
    order = spread_points(points, np.full(starts, np.inf), starts)
    evaluated = evaluate(points[order[:limit]])
    rounds = 0
    while len(evaluated.points) < limit:
        surrogate = Surrogate.of(evaluated, least)
        points = candidates(random, evaluated, objectives)
        distances = nearest(points, evaluated.points)
        promised = np.inf
        if surrogate is None:
            chosen = spread_points(points, distances, len(GAP_SHARES))
        else:
            predicted = surrogate.at(points)
            choose = next_points if objectives == 1 else next_of_front
            chosen = choose(predicted, distances, evaluated)
            promised = gain(evaluated, evaluated.with_more(predicted.at(chosen)))
        chosen = chosen[: limit - len(evaluated.points)]
        if not len(chosen):
            return evaluated, True
        before, evaluated = evaluated, evaluated.with_more(evaluate(points[chosen]))
        rounds = rounds + 1 if max(promised, gain(before, evaluated)) <= GAIN else 0
        if rounds == ROUNDS:
            return evaluated, True
    return evaluated, False


def gain(before: Evaluations, after: Evaluations) -> float:
    """Return the gain of further evaluations, relative to the objective or to the limits.

    That of a front is the relative growth of the area which it dominates.
    """
    if not before.has_numbers.any() or (after.admissible.any() and not before.admissible.any()):
        return np.inf
    if not after.admissible.any():
        return float(before.excess.min() - after.excess.min())
    if after.objectives.shape[1] == 1:
        first, last = before.objectives[before.best, 0], after.objectives[after.best, 0]
        return float((first - last) / max(abs(first), MIN_OBJECTIVE))
    corner = reference_corner(after.objectives[after.front])
    first, last = (
        dominated_area(evaluated.objectives[evaluated.front], corner)
        for evaluated in (before, after)
    )
    return (last - first) / last


def reference_corner(front: Floats) -> Floats:
    """Return the point up to which the area dominated by a front counts."""
    low, high = front.min(axis=0), front.max(axis=0)
    span = np.where(high > low, high - low, np.maximum(np.abs(high), MIN_OBJECTIVE))
    return np.asarray(low + FRONT_REACH * span)


def candidates(random: np.random.Generator, evaluated: Evaluations, objectives: int) -> Floats:
    """Return points from which the next ones are chosen, shape (n, dimensions)."""
    dimensions = evaluated.points.shape[1]
    spread = random.random((SPREAD, dimensions))
    # Optima often lie at a bound: half as many points again have one coordinate there.
    edges = random.random((SPREAD // 2, dimensions))
    which = random.integers(dimensions, size=len(edges))
    edges[np.arange(len(edges)), which] = random.integers(2, size=len(edges))
    centres = evaluated.points[[evaluated.best]]
    if objectives > 1 and evaluated.admissible.any():
        front = evaluated.front
        places = np.linspace(0, len(front) - 1, min(len(front), MAX_CENTRES)).astype(int)
        centres = evaluated.points[front[places]]
    count = max(1, SPREAD_PER_CENTRE * 4 // (3 + len(centres)))
    near = [
        np.clip(centre + width * random.normal(size=(count, dimensions)), 0.0, 1.0)
        for width in WIDTHS
        for centre in centres
    ]
    return np.concatenate([spread, edges, *near])


def nearest(points: Floats, others: Floats) -> Floats:
    """Return the distance of each point from the nearest of others."""
    parts = np.array_split(points, 1 + len(points) * len(others) // MAX_DISTANCES)
    least = [squared_distances(part, others).min(axis=1) for part in parts]
    return np.asarray(np.sqrt(np.concatenate(least)))


def spread_points(points: Floats, distances: Floats, count: int) -> NDArray[np.int64]:
    """Return `count` points, each as far as possible from all others before it."""
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(int(np.argmax(distances)))
        distances = distances_with(distances, points, chosen[-1])
    return np.array(chosen)


def distances_with(distances: Floats, points: Floats, chosen: int) -> Floats:
    """Return the distances from the nearest point after another one was chosen."""
    return np.asarray(np.minimum(distances, np.linalg.norm(points - points[chosen], axis=1)))


def next_points(
    predicted: Evaluations, distances: Floats, evaluated: Evaluations
) -> NDArray[np.int64]:
    """Return the candidates of least objective that keep their distances."""
    chosen: list[int] = []
    largest, value = distances.max(), predicted.objectives[:, 0]
    holds = (predicted.constraints <= -MARGIN).all(axis=1)
    for share in GAP_SHARES:
        far = distances >= max(share * largest, MIN_DISTANCE)
        if not far.any():
            continue
        inside = far & holds
        usable, ranked = (inside, value) if inside.any() else (far, predicted.excess)
        chosen.append(int(np.argmin(np.where(usable, ranked, np.inf))))
        distances = distances_with(distances, predicted.points, chosen[-1])
    return np.array(chosen, dtype=int)


def next_of_front(
    predicted: Evaluations, distances: Floats, evaluated: Evaluations
) -> NDArray[np.int64]:
    """Return the candidates that together add most to the front, after one that explores."""
    holds = (predicted.constraints <= -MARGIN).all(axis=1)
    if not holds.any() or not evaluated.admissible.any():
        return next_points(predicted, distances, evaluated)
    front = evaluated.objectives[evaluated.front]
    chosen = [int(np.argmax(distances))]
    for _ in range(FRONT_POINTS):
        distances = distances_with(distances, predicted.points, chosen[-1])
        usable = holds & (distances >= MIN_DISTANCE)
        corner = reference_corner(np.vstack([front, predicted.objectives[usable]]))
        added = np.where(usable, added_area(predicted.objectives, front, corner), 0.0)
        chosen.append(int(np.argmax(added)))
        front = np.vstack([front, predicted.objectives[chosen[-1]]])
        front = front[pareto(front)]
    return np.unique(chosen)


def pareto(objectives: Floats) -> NDArray[np.int64]:
    """Return the indices of the points that no other dominates, by the first objective."""
    order = np.lexsort(objectives.T[::-1])
    second = objectives[order, -1]
    least = np.minimum.accumulate(np.concatenate([[np.inf], second]))[:-1]
    return np.asarray(order[second < least])


def dominated_area(front: Floats, corner: Floats) -> float:
    """Return the area between a front, sorted by its first objective, and a corner."""
    widths = np.maximum(corner[0] - front[:, 0], 0.0)
    upper = np.concatenate([[corner[1]], front[:-1, 1]])
    heights = np.maximum(np.minimum(upper, corner[1]) - front[:, 1], 0.0)
    return float((widths * heights).sum())


def added_area(objectives: Floats, front: Floats, corner: Floats) -> Floats:
    """Return by how much each point alone would enlarge the area that a front dominates."""
    # The region below the front is a staircase: of each of its columns the point adds a part.
    left = np.concatenate([[-np.inf], front[:, 0]])
    right = np.concatenate([front[:, 0], [corner[0]]])
    top = np.concatenate([[corner[1]], np.minimum(front[:, 1], corner[1])])
    widths = np.minimum(right, corner[0]) - np.maximum(left, objectives[:, :1])
    heights = top - objectives[:, 1:]
    return np.asarray((np.maximum(widths, 0.0) * np.maximum(heights, 0.0)).sum(axis=1))
