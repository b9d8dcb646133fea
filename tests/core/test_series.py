"""The series of a short stretch against the general way."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest


@pytest.mark.parametrize(
    ("c", "w"),
    [(0.0, 100.0), (6.7, 100.0), (20.0, 100.0), (900.0, 100.0), (0.0, 0.0), (9.0, 0.0)],
)
def test_short_way_and_long_way_are_one(kernel: SimpleNamespace, c: float, w: float) -> None:
    rng = np.random.Generator(np.random.PCG64(5))
    h = 0.06 / (c + math.sqrt(w)) if c + w else 1.0
    stops = 0
    for _ in range(300):
        v, a, r = abs(rng.normal()), rng.normal() * 2 / h, rng.normal() * 4 / h**2
        short = kernel.stop.coast(c, w, v, a, r, h, True)
        long = kernel.stop.coast(c, w, v, a, r, h, False)
        scale = v + abs(a) * h + abs(r) * h * h
        if math.inf in (short[0], long[0]):
            assert short[0] == long[0]
        else:
            stops += 1
            assert short[0] == pytest.approx(long[0], rel=1e-12)
        assert short[1] == pytest.approx(long[1], abs=1e-14 * scale * h)
        assert short[2] == pytest.approx(long[2], abs=1e-14 * scale)
    assert stops > 50


def test_graze_is_left_to_the_long_way(kernel: SimpleNamespace) -> None:
    # v = (s - 1)² touches zero and does not cross it: Newton on a series has no slope to go by.
    q = kernel.series.series(0.0, 0.0, 1.0, -2.0, 2.0)
    assert kernel.series.fall(q, 1.0) == -1.0
    assert kernel.stop.coast(0.0, 0.0, 1.0, -2.0, 2.0, 3.0, True)[0] == pytest.approx(1.0)
