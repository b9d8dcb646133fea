"""Mean squares of the base over any window, against forty digits."""

from __future__ import annotations

import math
from random import Random

import mpmath
import numpy as np
import pytest
from scenes import waves_of

AGREES = 1e-11
"""Relative: an angle of thousands of radians is known to 1e-12."""


def exact(sines: list[tuple[float, float, float]], begin: float, end: float) -> float:
    """Return the mean of ü² in forty digits."""
    with mpmath.workdps(40):
        waves = [(A, 2 * mpmath.pi * mpmath.mpf(f), mpmath.mpf(p)) for A, f, p in sines]
        total = mpmath.mpf(0)
        for A, v, p in waves:
            for B, w, q in waves:
                apart = along(v - w, p - q, begin, end)
                total += A * B * (apart - along(v + w, p + q, begin, end))
        return float(total / 2)


def along(omega, phase, begin, end):
    """Return the mean of a cosine over a window."""
    if not omega:
        return mpmath.cos(phase)
    rise = mpmath.sin(omega * end + phase) - mpmath.sin(omega * begin + phase)
    return rise / omega / (mpmath.mpf(end) - mpmath.mpf(begin))


@pytest.mark.parametrize("begin", [0.0, 1.3])
def test_mean_square_is_right_over_windows_of_any_length(kernel, begin):
    for number in range(60):
        dice = Random(number)
        sines = [
            (dice.choice((0.1, 1.0, 1e3)), 10.0 ** dice.uniform(-3, 3), dice.choice((0.0, 0.4)))
            for _ in range(dice.choice((1, 2, 3)))
        ]
        end = begin + 10.0 ** dice.uniform(-9, 2)
        waves = waves_of(kernel, sines, kernel.model.CoulombLaw(0.0, 0.0))
        found, _ = kernel.forcing.mean_squares(waves, begin, end)
        assert found == pytest.approx(exact(sines, begin, end), rel=AGREES), number


# Sliding under waves: velocity, acceleration and jerk are the rates of each other.


H = 1e-6
"""Half the step of the differences [s]: right to 3e-8 where the damper is strongest."""


@pytest.mark.parametrize("s", [0.001, 0.02, 0.3, 2.0])
@pytest.mark.parametrize("slope", [0.0, 3.0])
@pytest.mark.parametrize(("c", "w"), [(6.7, 100.0), (0.0, 100.0), (400.0, 100.0), (0.0, 0.0)])
def test_each_rate_of_sliding_is_the_slope_of_the_one_before(kernel, c, w, slope, s):
    plant, law = kernel.model.Plant(1.0, w, c), kernel.model.CoulombLaw(0.3, 0.4, 0.5, 9.0, 0.2)
    waves = waves_of(kernel, [(1.4, 1.1, 0.4), (0.9, 3.7, 1.0)], law)
    kernel.forcing.set_phases(waves, plant, law, 0.35, 1)
    equation = kernel.forcing.Equation(c, w, -0.3, slope)
    before, now, after = (
        np.array(kernel.forcing.motion_at(equation, waves, 0.01, 0.2, s + h))
        for h in (-H, 0.0, H)
    )
    assert (after - before)[:3] / (2 * H) == pytest.approx(now[1:4], rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("c", [1e8, 1e10, 1e13])
@pytest.mark.parametrize("s", [1e-5, 1e-3, 0.05])
def test_every_rate_of_a_creep_under_a_strong_damper_has_its_digits(kernel, c, s):
    # What is left of the start dies out within 1/c; then v_r = -ü/c, and so are its rates. The
    # snap once was the rounding of ü times c², and steps were of a decay where it bounds them.
    plant, law = kernel.model.Plant(1.0, 100.0, c), kernel.model.CoulombLaw(0.0, 0.0)
    waves = waves_of(kernel, [(1.4, 1.1, 0.4)], law)
    kernel.forcing.set_phases(waves, plant, law, 0.0, 1)
    equation = kernel.forcing.Equation(c, 100.0, 0.0, 0.0)
    _, *rates = kernel.forcing.motion_at(equation, waves, 0.0, 0.0, s)
    omega = 2 * np.pi * 1.1
    u_dd = [1.4 * omega**n * np.sin(omega * s + 0.4 + 0.5 * np.pi * n) for n in range(4)]
    assert rates == pytest.approx(np.array(u_dd) / -c, rel=1e-6)


def test_bounds_of_the_rates_of_a_force_are_what_its_sines_reach_together(kernel):
    waves = waves_of(
        kernel, [(1.4, 1.1, 0.4), (-0.9, 0.1, 1.0)], kernel.model.CoulombLaw(1.0, 1.0)
    )
    one, other = 2.0 * math.pi * 1.1, 2.0 * math.pi * 0.1
    rates = [1.4 * one**n + 0.9 * other**n for n in (1, 2, 3)]
    rates[0] += 7.0
    assert kernel.forcing.force_rate_bounds(waves, -7.0) == pytest.approx(
        (*rates, one), rel=1e-14
    )


@pytest.mark.parametrize("side", [1, -1])
def test_each_rate_of_the_force_left_to_break_away_is_the_slope_of_the_one_before(kernel, side):
    plant, law = (
        kernel.model.Plant(2.0, 90.0, 3.0),
        kernel.model.CoulombLaw(7.0, 8.0, 0.5, 9.0, 0.2),
    )
    waves = waves_of(kernel, [(1.4, 1.1, 0.4), (0.9, 3.7, 1.0)], law)
    kernel.forcing.set_phases(waves, plant, law, 0.35, 0)
    limit, swing = (law.F_fs, -0.7), (law.variation, law.omega)
    stuck = kernel.roots.Stuck(plant.m, plant.k_x * 0.01, 0.4, limit, limit, *swing)
    before, now, after = (
        np.array(kernel.roots.break_away_margin(stuck, waves, side, 0.2 + h))
        for h in (-H, 0.0, H)
    )
    assert (after - before)[:2] / (2 * H) == pytest.approx(now[1:], rel=1e-6)


@pytest.mark.parametrize("s", [0.0, 0.3, 1.0])
def test_base_and_normal_force_at_any_time_are_their_sines(kernel, s):
    law = kernel.model.CoulombLaw(10.0, 12.0, 0.4, 3.0, 0.2)
    waves = waves_of(kernel, [(2.0, 0.7, 0.1)], law)
    kernel.forcing.set_phases(waves, kernel.model.Plant(1.0, 1.0, 0.1), law, 0.0, 0)
    omega = 2.0 * math.pi * 0.7
    sine, cosine = math.sin(omega * s + 0.1), math.cos(omega * s + 0.1)
    assert kernel.forcing.base_motion(waves, 0.5, 0.3, s) == pytest.approx(
        (0.5 + 0.3 * s + 2.0 * sine, 0.3 + 2.0 * omega * cosine, -2.0 * omega**2 * sine)
    )
    sine, cosine = math.sin(3.0 * s + 0.2), math.cos(3.0 * s + 0.2)
    assert kernel.forcing.relative_normal_force(law, waves, s) == pytest.approx(
        (1.0 + 0.4 * sine, 1.2 * cosine, -3.6 * sine)
    )
