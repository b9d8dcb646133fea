"""Sampled motion between its samples: integrals over windows, however they cut its steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from drysim.core.model import (
    Samples,
    blocks,
    integrate_base_squares,
    interpolate_displacement,
    max_abs,
)

# Sampled motion between its samples: integrals over windows, however they cut its steps.


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
def test_blocks_of_a_signal_make_the_whole(length: int) -> None:
    signal = np.arange(length) - 3.0
    parts = list(blocks(signal, 8))
    assert max(map(len, parts)) <= 8
    assert np.concatenate(parts).tolist() == signal.tolist()
    assert max_abs(signal) == max(3.0, length - 4.0)


def test_nothing_has_no_magnitude() -> None:
    assert max_abs(np.zeros(0)) == 0.0
