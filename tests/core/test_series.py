"""The series of a short stretch against the general way."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest


def flown(
    kernel: SimpleNamespace, c: float, w: float, v: float, a: float, r: float, s: float
) -> tuple[float, float]:
    """Give distance and velocity after a time s in closed form."""
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    p = a + c * v
    return v * y + p * Y + r * YY, v * y_d + p * y + r * Y


@pytest.mark.parametrize("radians", [0.099, 0.499])
@pytest.mark.parametrize(
    ("c", "w"),
    [(0.0, 100.0), (6.7, 100.0), (20.0, 100.0), (900.0, 100.0), (0.0, 0.0), (9.0, 0.0)],
)
def test_short_way_and_long_way_are_one(
    kernel: SimpleNamespace, c: float, w: float, radians: float
) -> None:
    rng = np.random.Generator(np.random.PCG64(5))
    h = radians / (c + math.sqrt(w)) if c + w else 1.0
    plant, law = kernel.model.Plant(1.0, w, c), kernel.model.Law(0.0, 0.0)
    short_way = kernel.oscillator.steps_of(plant, law, h)
    assert short_way.short
    assert short_way.brief == (radians < 0.1 or c + w == 0.0)
    stops = 0
    for _ in range(300):
        v, a, r = abs(rng.normal()), rng.normal() * 2 / h, rng.normal() * 4 / h**2
        scale = v + abs(a) * h + abs(r) * h * h
        one, other = (
            kernel.sampled.coast(short_way, v, a, r, h),
            flown(kernel, c, w, v, a, r, h),
        )
        assert one[0] == pytest.approx(other[0], abs=1e-14 * scale * h)
        assert one[1] == pytest.approx(other[1], abs=1e-14 * scale)
        short = kernel.sampled.stop_within(short_way, v, a, r, other[1], h)
        long = kernel.sampled.stop_by_flow(c, w, v, a, r, other[1], h)
        if math.inf in (short[0], long[0]):
            assert short[0] == long[0]
        else:
            stops += 1
            assert short[0] == pytest.approx(long[0], rel=1e-12)
        assert short[1] == pytest.approx(long[1], abs=1e-14 * scale * h)
    assert stops > 50


def test_graze_is_left_to_the_long_way(kernel: SimpleNamespace) -> None:
    # v = (s - 1)² touches zero and does not cross it: Newton on a series has no slope to go by.
    q = (1.0, -2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert kernel.oscillator.fall(q, 1.0)[0] == -1.0
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -2.0, 2.0, 3.0) == pytest.approx(1.0)


def test_series_is_the_flow_to_the_last_digit(kernel: SimpleNamespace) -> None:
    c, w, s = 6.7, 100.0, 3.5e-3
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    tail = kernel.oscillator.tail_of(c, w)
    for v, a, r in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.3, -70.0, 900.0)):
        q = kernel.oscillator.series(tail, v, a, r - c * a - w * v)
        p = a + c * v
        assert kernel.oscillator.distance(q, s) == pytest.approx(
            v * y + p * Y + r * YY, rel=1e-15
        )
        assert kernel.oscillator.speed(q, s) == pytest.approx(
            v * y_d + p * y + r * Y, rel=1e-14
        )
        assert kernel.oscillator.rate(q, s) == pytest.approx(
            a * y_d + (r - w * v) * y, rel=1e-14
        )


def test_six_terms_more_carry_the_series_on_to_the_last_digit(kernel: SimpleNamespace) -> None:
    c, w, s = 6.7, 900.0, 0.0136
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    tail = kernel.oscillator.tail_of(c, w)
    more = kernel.oscillator.more_of(tail, c, w)
    for v, a, r in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.3, -70.0, 900.0)):
        j = r - c * a - w * v
        brief = kernel.oscillator.series(tail, v, a, j)
        longer = kernel.oscillator.longer_series(tail, more, v, a, j)
        p = a + c * v
        way = v * y + p * Y + r * YY
        assert kernel.oscillator.distance(longer, s) == pytest.approx(way, rel=3e-15, abs=0.0)
        assert kernel.oscillator.distance(brief, s) != pytest.approx(way, rel=1e-14, abs=0.0)
        assert kernel.oscillator.speed(longer, s) == pytest.approx(
            v * y_d + p * y + r * Y, rel=1e-14, abs=0.0
        )
        assert kernel.oscillator.rate(longer, s) == pytest.approx(
            a * y_d + (r - w * v) * y, rel=1e-14, abs=0.0
        )


def test_what_a_damper_alone_brings_to_rest_has_every_digit_of_a_longer_series(
    kernel: SimpleNamespace,
) -> None:
    c, s = 500.0, 1e-3
    tail = kernel.oscillator.tail_of(c, 0.0)
    q = kernel.oscillator.longer_series(
        tail, kernel.oscillator.more_of(tail, c, 0.0), 0.0, 1.0, -c
    )
    assert kernel.oscillator.speed(q, s) == pytest.approx(-math.expm1(-c * s) / c, rel=5e-16)


def test_mass_that_only_the_end_of_a_step_shows_at_rest_stops_there(
    kernel: SimpleNamespace,
) -> None:
    c, w, h = 600.0, 9e4, 2.5e-3
    y, y_d, Y, _ = kernel.oscillator.flow(c, w, h)
    v, a = 1.0, -400.0
    r = -(v * y_d + (a + c * v) * y) / Y * (1.0 - 1e-12)
    assert kernel.roots.locate_stop(c, w, v, a, r, h) == math.inf
    stop, way = kernel.sampled.stop_by_flow(c, w, v, a, r, -1e-17, h)
    assert stop == h
    assert way == pytest.approx(flown(kernel, c, w, v, a, r, h)[0], rel=1e-14)
