"""The search of a design study: minima, fronts, limits and failures of known functions."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.study.search import (
    Evaluations,
    added_area,
    dominated_area,
    interpolate,
    pareto,
    search,
)


def functions(objective, *constraints):
    """Return the evaluation of an objective, or a list of two, and of constraints."""

    def evaluate(points):
        values = objective(points)
        several = values if values.ndim == 2 else values[:, None]
        limits = [constraint(points) for constraint in constraints]
        columns = np.stack(limits, axis=1) if limits else np.empty((len(points), 0))
        return Evaluations(points, several, columns)

    return evaluate


def branin(points):
    """Three equal minima, 0.397887."""
    x, y = 15.0 * points[:, 0] - 5.0, 15.0 * points[:, 1]
    valley = (y - 5.1 / (4.0 * np.pi**2) * x**2 + 5.0 / np.pi * x - 6.0) ** 2
    return valley + 10.0 * (1.0 - 1.0 / (8.0 * np.pi)) * np.cos(x) + 10.0


def ring(points):
    """The circle of radius 0.25 around (0.5, 0.5) is admissible."""
    return np.hypot(*(points - 0.5).T) / 0.25 - 1.0


def rms_acceleration(points):
    """RMS acceleration under white noise over ζ from 0.05 to 5, least at ζ = 1/2."""
    zeta = 0.05 * 100.0 ** points[:, 0]
    return np.sqrt((1.0 + 4.0 * zeta**2) / (2.0 * zeta))


@pytest.mark.parametrize(
    ("objective", "dimensions", "least", "tolerance"),
    [
        (branin, 2, 0.397887, 1e-3),
        (rms_acceleration, 1, np.sqrt(2.0), 1e-6),
        (lambda u: 1.0 + ((u - 0.3) ** 2).sum(axis=1), 4, 1.0, 1e-3),
        (lambda u: 2.0 - u[:, 0] + abs(u[:, 1] - 0.4), 2, 1.0, 1e-3),  # a kink, at a bound
    ],
    ids=["three minima", "white noise", "four keys", "kink at a bound"],
)
def test_least_value_is_found_within_100_evaluations(objective, dimensions, least, tolerance):
    found, converged = search(functions(objective), dimensions, [0.0], 100)
    assert converged
    assert found.objectives[found.best, 0] == pytest.approx(least, rel=tolerance)


def test_best_point_lies_within_the_limit_and_next_to_it():
    found, converged = search(functions(lambda u: 3.0 + u.sum(axis=1), ring), 2, [-np.inf], 100)
    corner = 0.5 - 0.25 / np.sqrt(2.0)
    assert converged
    assert found.constraints[found.best, 0] <= 0.0
    assert found.objectives[found.best, 0] == pytest.approx(3.0 + 2.0 * corner, rel=1e-3)


def test_least_excess_is_found_where_no_point_is_admissible():
    found, converged = search(
        functions(branin, lambda u: 0.5 + u[:, 0] + u[:, 1]), 2, [-np.inf], 100
    )
    assert converged
    assert not found.admissible.any()
    assert found.excess.min() == pytest.approx(0.5, abs=1e-3)


def test_failed_evaluations_are_passed_over():
    def fails_left(points):
        return np.where(points[:, 0] < 0.3, np.nan, branin(points))

    found, _ = search(functions(fails_left), 2, [-np.inf], 120)
    assert found.objectives[found.best, 0] == pytest.approx(0.397887, rel=1e-3)


def test_search_of_failures_only_uses_up_its_evaluations():
    found, converged = search(functions(lambda u: np.full(len(u), np.nan)), 2, [-np.inf], 30)
    assert len(found.points) == 30
    assert not converged


@pytest.mark.parametrize("limit", [1, 5, 18])
def test_no_more_points_are_evaluated_than_allowed(limit):
    found, converged = search(functions(branin), 2, [-np.inf], limit)
    assert len(found.points) == limit
    assert not converged


def two_distances(points):
    """Squared distances from two points: the front is the straight line between them."""
    ends = ([0.2, 0.3], [0.8, 0.7])
    return np.stack([((points - end) ** 2).sum(axis=1) for end in ends], axis=1)


def test_front_of_two_squared_distances_covers_its_closed_form():
    # On the line at share s: s² D and (1 - s)² D with D the squared distance of the ends.
    found, converged = search(functions(two_distances), 2, [0.0, 0.0], 300)
    front, square = found.objectives[found.front], 0.6**2 + 0.4**2
    share = np.linspace(0.0, 1.0, 20_001)
    exact = np.stack([share**2, (1.0 - share) ** 2], axis=1) * square
    corner = np.array([1.1, 1.1]) * square
    assert converged
    assert dominated_area(front, corner) > 0.995 * dominated_area(exact, corner)
    assert np.sqrt(front / square).sum(axis=1).max() < 1.02  # near the line


def test_front_keeps_the_limits():
    found, _ = search(functions(two_distances, lambda u: 0.5 - u[:, 1]), 2, [0.0, 0.0], 150)
    assert (found.points[found.front, 1] >= 0.5).all()


def test_pareto_points_are_those_that_no_other_dominates():
    values = np.random.default_rng(3).random((200, 2))
    dominated = [any((b <= a).all() and (b < a).any() for b in values) for a in values]
    assert sorted(pareto(values).tolist()) == np.flatnonzero(~np.array(dominated)).tolist()


def test_added_area_is_the_growth_of_the_dominated_area():
    random = np.random.default_rng(4)
    values, corner = random.random((30, 2)), np.array([1.2, 1.1])
    front = values[pareto(values)]
    points = random.random((50, 2)) * 1.5
    for point, added in zip(points, added_area(points, front, corner), strict=True):
        several = np.vstack([front, point])
        grown = dominated_area(several[pareto(several)], corner)
        assert added == pytest.approx(grown - dominated_area(front, corner), abs=1e-12)


def test_search_ends_at_the_least_possible_value():
    found, converged = search(
        functions(lambda u: np.maximum(u[:, 0] - 0.5, 0.0)), 2, [0.0], 200
    )
    assert converged
    assert found.objectives[found.best, 0] == 0.0
    assert len(found.points) < 60


def test_points_on_a_line_are_no_error():
    def rounded(points):
        on_line = points.copy()
        on_line[:, 1] = 0.5
        return Evaluations(on_line, on_line[:, :1], np.empty((len(points), 0)))

    found, _ = search(rounded, 2, [0.0], 40)
    assert len(found.points) == 40


def test_interpolation_matrix_times_values_is_their_interpolant():
    random = np.random.default_rng(1)
    points, others = random.random((30, 2)), random.random((50, 2))
    points[7] = points[3]
    values = random.normal(size=(30, 4))
    values[7] = values[3]
    matrix, found = (interpolate(points, one, others) for one in (np.eye(30), values))
    assert matrix @ values == pytest.approx(found, abs=1e-9)
    assert interpolate(points[:3], values[:3], others) is None


@pytest.mark.parametrize("dimensions", [1, 3])
def test_interpolant_is_that_of_scipy(dimensions):
    from scipy.interpolate import RBFInterpolator

    random = np.random.default_rng(2)
    layers = np.stack([random.permutation(40) for _ in range(dimensions)], axis=1)
    points, others = (layers + 0.5) / 40, random.random((50, dimensions))
    values = random.normal(size=(40, 2))
    expected = RBFInterpolator(points, values, kernel="cubic")(others)
    assert interpolate(points, values, others) == pytest.approx(expected, abs=1e-9)
