"""Sampled motion between its samples: integrals over windows, however they cut its steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from drysim.core.model import (
    Samples,
    _kept_values,
    blocks,
    integrate_base_squares,
    interpolate_displacement,
    keep_values,
    max_abs,
    recall_for,
)

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Exact for the square of a cubic."""


@pytest.mark.parametrize(
    ("begin", "end"), [(0.0, 1.1), (0.2, 0.9), (0.23, 0.87), (0.31, 0.38), (0.25, 0.31)]
)
def test_squares_over_a_window_are_those_of_lines_and_of_the_cubics_that_they_bend(begin, end):
    # Steps so long that ü bends u between two samples as much as u itself is.
    dt, random = 0.1, np.random.default_rng(4)
    u_dd, u = 100.0 * random.normal(size=12), random.normal(size=12)
    motion = Samples(u_dd, dt, u)
    edges = np.unique([begin, *(n * dt for n in range(12) if begin < n * dt < end), end])
    u_dd2 = u2 = 0.0
    for lo, hi in pairwise(edges.tolist()):
        t = 0.5 * (lo + hi) + 0.5 * (hi - lo) * NODES
        n = np.full(4, int(0.5 * (lo + hi) / dt))
        q = t / dt - n
        path = interpolate_displacement(motion, n, q)
        u_dd2 += 0.5 * (hi - lo) * WEIGHTS @ ((1.0 - q) * u_dd[n] + q * u_dd[n + 1]) ** 2
        u2 += 0.5 * (hi - lo) * WEIGHTS @ path**2
    assert integrate_base_squares(motion, begin, end) == pytest.approx((u_dd2, u2), rel=1e-12)


# Numbers had by parts: the same whatever the parts are.


@pytest.mark.parametrize("length", [1, 7, 8, 9, 24])
def test_blocks_of_a_signal_make_the_whole(length):
    signal = np.arange(length) - 3.0
    parts = list(blocks(signal, 8))
    assert max(map(len, parts)) <= 8
    assert np.concatenate(parts).tolist() == signal.tolist()
    assert max_abs(signal) == max(3.0, length - 4.0)


def test_nothing_has_no_magnitude():
    assert max_abs(np.zeros(0)) == 0.0


def squares(motion: Samples, power: int) -> float:
    """Return a value that depends on samples, their step, u and a number."""
    u = 0.0 if motion.u is None else float(np.sum(motion.u[:]))
    return float(np.sum(motion.u_dd[:] ** power)) * motion.dt + u


def test_values_that_are_kept_for_a_motion_are_its_own_whatever_came_and_went_before():
    random, living = np.random.default_rng(4), list[Samples]()
    before = len(_kept_values)
    for _ in range(400):
        if living and random.random() < 0.5:
            del living[random.integers(len(living))]
        motion = Samples(random.normal(size=5), 0.01, random.normal(size=5))
        if random.random() < 0.8:
            keep_values(motion)
        living.append(motion)
        for one in living:
            for other in (one, one._replace(u=None), one._replace(dt=0.02)):
                power = int(random.integers(1, 30))
                assert recall_for(other, squares, power) == squares(other, power)
    del living, motion, one, other
    assert len(_kept_values) == before


def test_values_are_computed_once_for_a_motion_that_is_kept_and_else_each_time():
    calls = []

    def count(motion: Samples) -> float:
        calls.append(motion)
        return float(motion.u_dd[0])

    motion = Samples(np.ones(3), 0.01)
    assert recall_for(motion, count) == 1.0
    motion.u_dd[0] = 2.0  # as a caller of `simulate` may
    assert recall_for(motion, count) == 2.0
    keep_values(motion)
    assert [recall_for(motion, count) for _ in range(3)] == [2.0] * 3
    assert len(calls) == 3
