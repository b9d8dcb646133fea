"""Stops under linearly changing force: none is missed, none is invented."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest


def first_zero_by_scan(
    kernel: SimpleNamespace, c: float, w: float, v: float, a: float, j: float, h: float
) -> float:
    """Find the first zero on a grid of 20,000 points."""
    s = np.linspace(0.0, h, 20_001)[1:]
    values = np.array([kernel.roots.velocity(c, w, v, a, j, each)[0] for each in s])
    below = np.flatnonzero(values <= 0.0)
    return float(s[below[0]]) if len(below) else math.inf


@pytest.mark.parametrize(
    ("c", "w"),
    [
        (0.0, 100.0),
        (6.7, 100.0),
        (20.0, 100.0),
        (400.0, 100.0),
        (0.0, 0.0),
        (3.0, 0.0),
        (2.0, 4e6),
    ],
)
def test_stop_agrees_with_a_fine_scan(plain: SimpleNamespace, c: float, w: float) -> None:
    rng = np.random.Generator(np.random.PCG64(7))
    h = 20.0 / (1.0 + math.sqrt(w) + c)
    for _ in range(4):
        v, a, j = abs(rng.normal()), rng.normal() * 3, rng.normal() * 9
        found = plain.roots.locate_stop(c, w, v, a, j, h)
        scanned = first_zero_by_scan(plain, c, w, v, a, j, h)
        assert (found == scanned == math.inf) or abs(found - scanned) <= h / 20_000


def test_dip_below_zero_between_two_positive_ends_is_a_stop(kernel: SimpleNamespace) -> None:
    # v = 1 - 3 s + 2 s² without spring and damper: positive at both ends of [0, 2].
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -3.0, 4.0, 2.0) == pytest.approx(
        0.5, rel=1e-15
    )


def test_near_miss_is_not_a_stop_and_a_touch_is(kernel: SimpleNamespace) -> None:
    # v = d² + (s - 1)²: the least speed is d².
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0 + 1e-12, -2.0, 2.0, 3.0) == math.inf
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -2.0, 2.0, 3.0) == pytest.approx(
        1.0, rel=1e-7
    )


def test_start_at_rest_that_accelerates_is_not_a_stop_at_zero(kernel: SimpleNamespace) -> None:
    assert kernel.roots.locate_stop(0.0, 0.0, 0.0, 0.0, 1.0, 5.0) == math.inf
    assert kernel.roots.locate_stop(0.0, 0.0, 0.0, 1.0, -1.0, 5.0) == pytest.approx(2.0)


def test_swing_that_starts_at_its_top_is_followed_down(kernel: SimpleNamespace) -> None:
    w = (2 * math.pi) ** 2
    v, a, j = 3.0, 0.0, -w
    found = kernel.roots.locate_stop(0.0, w, v, a, j + w * v, 40.0)
    assert found == math.inf  # v = 3 - (1 - cos) stays above 1
    assert kernel.roots.locate_stop(0.0, w, 1.9, a, j + w * 1.9, 40.0) == pytest.approx(
        math.acos(-0.9) / (2 * math.pi), rel=1e-14
    )


@pytest.mark.parametrize("square", [-1.0, -1e-12, 0.0, 1e-12, 1.0])
def test_first_extremum_is_smooth_through_critical_damping(
    kernel: SimpleNamespace, square: float
) -> None:
    c = 20.0
    w = 0.25 * c * c + square
    s = kernel.roots.first_extremum(c, w, -1.0, 30.0)
    y, y_d, _, _ = kernel.oscillator.flow(c, w, s)
    assert -1.0 * (y_d + c * y) + 30.0 * y == pytest.approx(0.0, abs=1e-15)


def test_velocity_a_rounding_below_zero_is_not_taken_for_one_that_never_stops(
    kernel: SimpleNamespace,
) -> None:
    assert kernel.roots.locate_stop(0.1, 1.0, -1e-18, 1e-10, -1.0, 1e-2) <= 1e-9
