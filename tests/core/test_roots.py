"""When a blend of motion and normal force vanishes: against a fine march along the stretch."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from drysim.core.roots import NEVER

LENGTH, FINE = 0.4, 800


def scene(kernel, seed):
    """Return a segment under two sines and a varying load, and an observable above zero."""
    random = np.random.default_rng(seed)
    c, w = float(random.uniform(0.0, 10.0)), float(random.choice([100.0, 1400.0, 2e4]))
    law = kernel.model.PiecewiseLaw(30.0, 30.0, 1e5, 0.6, float(random.uniform(3.0, 40.0)), 0.3)
    stride = kernel.forcing.WAVE_COLUMNS
    waves = kernel.forcing.Waves([0.0] * (3 * stride), 3, 2)
    for i, f in enumerate((*random.uniform(0.5, 10.0, 2).tolist(), law.omega / 2 / math.pi)):
        kernel.forcing.set_wave(waves.values, i, 1.0, f, float(random.uniform(0.0, 6.0)))
    kernel.forcing.set_phases(waves, kernel.model.Plant(1.0, w, c), law, 0.0, 0)
    x_r, v_r, g = (float(each) for each in random.normal(0.0, (0.01, 0.1, 2.0)))
    equation = kernel.forcing.Equation(c, w, g, 0.0)
    stretch = kernel.forcing.start_segment(equation, waves, x_r, v_r)
    shares = (
        (-law.k_t, 0.0, law.F_fk, 0.0, 2.0, -1.5),
        (0.0, 1.0, 0.0, -1e-3, 0.0, 0.0),
        (-1e4, -100.0, 0.0, 0.0, 3.0, 4.0),
    )
    share = shares[seed % 3]
    blend = kernel.roots.Observable(0.0, *share)
    if value_at(kernel, stretch, waves, law, blend, 0.0) < 0.0:
        blend = kernel.roots.Observable(0.0, *(-each for each in share))
    return stretch, waves, law, blend


def value_at(kernel, stretch, waves, law, blend, s):
    """Return the observable at a time of a segment."""
    x, v = kernel.forcing.motion_at(stretch.equation, waves, stretch.x_r, stretch.v_r, s)[:2]
    load, load_d, _ = kernel.forcing.relative_normal_force(law, waves, s)
    value = blend.x * (x - blend.x_0) + blend.v * v + blend.load * load + blend.rate * load_d
    return value + blend.constant + blend.slope * s


@pytest.mark.parametrize("seed", range(24))
def test_first_zero_is_neither_missed_nor_invented(plain, seed):
    stretch, waves, law, blend = scene(plain, seed)
    s, x_r, v_r, _ = plain.roots.first_root(stretch, waves, law, blend, 0, LENGTH)
    t = np.linspace(0.0, LENGTH, FINE)
    values = [value_at(plain, stretch, waves, law, blend, at) for at in t.tolist()]
    below = np.flatnonzero(np.array(values) < 0.0)
    scale = max(map(abs, values))
    if s == math.inf:
        assert not len(below)
        return
    assert abs(value_at(plain, stretch, waves, law, blend, s)) < 1e-13 * scale
    assert t[below[0] - 1] <= s <= t[below[0]]
    found = plain.forcing.motion_at(stretch.equation, waves, stretch.x_r, stretch.v_r, s)[:2]
    assert (x_r, v_r) == pytest.approx(found, rel=1e-12, abs=1e-15)
    assert plain.roots.first_root(stretch, waves, law, blend, 0, 0.999 * s)[0] == math.inf


@pytest.mark.parametrize("rounds", [0, 1])
def test_root_is_the_same_where_the_rounds_of_newtons_method_are_used_up(
    plain, monkeypatch, rounds
):
    found = 0
    for seed in range(24):
        stretch, waves, law, blend = scene(plain, seed)
        one = plain.roots.first_root(stretch, waves, law, blend, 0, LENGTH)
        with monkeypatch.context() as patch:
            patch.setattr(plain.roots, "MAX_NEWTON_ROUNDS", rounds)
            other = plain.roots.first_root(stretch, waves, law, blend, 0, LENGTH)
        assert other == pytest.approx(one, rel=1e-12, abs=1e-15)
        found += one[0] < math.inf
    assert found > 12


def test_slow_blend_that_may_turn_above_zero_is_not_taken_to_fall(kernel):
    # 1 - s/2 + s³/30 is 1/4 at the least, after more than two seconds.
    blend = kernel.roots
    course = blend.Derivatives(1.0, -0.5, 0.0, 0.2)
    for most, falls in ((0.2, False), (0.02, True)):
        assert kernel.roots.is_monotone_to_zero(*course[:3], most, 0.0) == falls


@pytest.mark.parametrize("seed", range(4))
def test_no_safe_step_passes_the_first_zero_of_what_bounds_the_speed(kernel, seed):
    random = np.random.default_rng(seed)
    for _ in range(200):
        v, snap, growth = abs(random.normal(size=3) * 10.0 ** random.integers(-3, 3, 3))
        a, j = random.normal(size=2) * 10.0 ** random.integers(-3, 3, 2)
        each = (float(value) for value in (v, a, j, snap, growth))
        step = kernel.roots.safe_step(*each, 10.0)
        assert step <= 10.0
        h = np.linspace(0.0, step, 50)
        terms = v, a * h, j * h**2 / 2.0, -snap * h**3 / 6.0, -growth * h**4 / 24.0
        assert (sum(terms) >= -1e-12 * sum(map(np.abs, terms))).all()


def test_speed_that_slow_waves_lift_before_zero_does_not_stop(kernel):
    # The first two rates of ü cancel: v is 0.45 - f s + G s⁴/24 first, 0.07 at the least.
    pair, f, v = ((1.0, 0.25, 0.0), (2.0, 0.125, math.pi)), 0.125, 0.45
    waves = kernel.forcing.Waves(np.zeros(2 * kernel.forcing.WAVE_COLUMNS), 2, 2)
    for i, (A, omega, phase) in enumerate(pair):
        kernel.forcing.set_wave(waves.values, i, A, omega / (2.0 * math.pi), phase)
    plant, law = kernel.model.Plant(1.0, 0.0, 0.0), kernel.model.CoulombLaw(f, f)
    kernel.forcing.set_phases(waves, plant, law, 0.0, 1)
    equation = kernel.forcing.Equation(0.0, 0.0, -f, 0.0)
    stretch = kernel.forcing.start_segment(equation, waves, 0.0, v)
    speeds = [kernel.forcing.motion_at(equation, waves, 0.0, v, s).v_r for s in range(9)]
    assert 0.05 < min(speeds) < 0.08
    stop = kernel.roots.first_stop(stretch, waves, law, 1, 8.0)[0]
    assert stop == math.inf


# Stops under linearly changing force: none is missed, none is invented.


def first_zero_by_scan(
    kernel: SimpleNamespace, c: float, w: float, v: float, a: float, j: float, h: float
) -> float:
    """Find the first zero on a grid of 20,000 points."""
    s = np.linspace(0.0, h, 20_001)[1:]
    values = np.array(
        [kernel.roots.velocity_and_acceleration(c, w, v, a, j, each)[0] for each in s]
    )
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
def test_stop_agrees_with_a_fine_scan(plain, c, w):
    rng = np.random.Generator(np.random.PCG64(7))
    h = 20.0 / (1.0 + math.sqrt(w) + c)
    for _ in range(4):
        v, a, j = abs(rng.normal()), rng.normal() * 3, rng.normal() * 9
        found = plain.roots.locate_stop(c, w, v, a, j, h)
        scanned = first_zero_by_scan(plain, c, w, v, a, j, h)
        assert (found == scanned == math.inf) or abs(found - scanned) <= h / 20_000


def test_dip_below_zero_between_two_positive_ends_is_a_stop(kernel):
    # v = 1 - 3 s + 2 s² without spring and damper: positive at both ends of [0, 2].
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -3.0, 4.0, 2.0) == pytest.approx(
        0.5, rel=1e-15
    )


def test_near_miss_is_not_a_stop_and_a_touch_is(kernel):
    # v = d² + (s - 1)²: the least speed is d².
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0 + 1e-12, -2.0, 2.0, 3.0) == math.inf
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -2.0, 2.0, 3.0) == pytest.approx(
        1.0, rel=1e-7
    )


def test_start_at_rest_that_accelerates_is_not_a_stop_at_zero(kernel):
    assert kernel.roots.locate_stop(0.0, 0.0, 0.0, 0.0, 1.0, 5.0) == math.inf
    assert kernel.roots.locate_stop(0.0, 0.0, 0.0, 1.0, -1.0, 5.0) == pytest.approx(2.0)


def test_swing_that_starts_at_its_top_is_followed_down(kernel):
    w = (2 * math.pi) ** 2
    v, a, j = 3.0, 0.0, -w
    found = kernel.roots.locate_stop(0.0, w, v, a, j + w * v, 40.0)
    assert found == math.inf  # v = 3 - (1 - cos) stays above 1
    assert kernel.roots.locate_stop(0.0, w, 1.9, a, j + w * 1.9, 40.0) == pytest.approx(
        math.acos(-0.9) / (2 * math.pi), rel=1e-14
    )


@pytest.mark.parametrize("square", [-1.0, -1e-12, 0.0, 1e-12, 1.0])
def test_first_extremum_is_smooth_through_critical_damping(kernel, square):
    c = 20.0
    w = 0.25 * c * c + square
    s = kernel.roots.first_extremum(c, w, -1.0, 30.0)
    y, y_d, _, _ = kernel.oscillator.flow(c, w, s)
    assert -1.0 * (y_d + c * y) + 30.0 * y == pytest.approx(0.0, abs=1e-15)


def test_velocity_a_rounding_below_zero_is_not_taken_for_one_that_never_stops(kernel):
    assert kernel.roots.locate_stop(0.1, 1.0, -1e-18, 1e-10, -1.0, 1e-2) <= 1e-9


# Where a guess of a root may be: between its bounds.


@pytest.mark.parametrize("guess", [3.0, 9.0, -7.0, math.inf, math.nan])
def test_guess_that_is_not_between_the_bounds_gives_way_to_their_middle(plain, guess):
    def improved(at: float) -> tuple[float, float, float, bool]:
        # From 1.5, where the value is above zero, a slope of -1 leads to `at`.
        return plain.roots.safeguarded_newton(1.0, 3.0, 1.5, at - 1.5, -1.0)

    closer = (1.5, 3.0) if guess > 1.5 else (1.0, 1.5)
    assert improved(guess) == (*closer, 0.5 * sum(closer), False)
    assert improved(2.5) == (1.5, 3.0, 2.5, False)


# Zeros of a Taylor series: what is divided out of it before they are looked for.


@pytest.mark.parametrize(
    ("series", "last", "zeros"),
    [([0.0, 0.0, 1.0, 2.0, 3.0], 2, 2), ([0.0, 0.0, 5.0], 0, 2), ([4.0, 0.0, 5.0], 2, 0)],
)
def test_zeros_at_the_beginning_of_a_series_are_divided_out(kernel, series, last, zeros):
    c = np.array(series)
    assert kernel.roots.deflate(c, len(series) - 1) == last
    assert c[: last + 1].tolist() == series[zeros:]


def test_series_of_zeros_alone_is_told_apart(kernel):
    assert kernel.roots.deflate(np.zeros(3), 2) < 0


@pytest.mark.parametrize(
    ("series", "at"),
    [
        ([1.0, -2.0], 0.5),
        ([1.0, -3.0, 2.0], 0.5),
        ([0.0, 3.0, -4.0], 0.75),
        ([1.0, -0.9], NEVER),
    ],
    ids=["line", "parabola", "from zero", "later"],
)
def test_first_zero_of_a_polynomial_is_found(kernel, series, at):
    assert kernel.roots.first_series_root(
        np.array(series), len(series) - 1, 1.0
    ) == pytest.approx(at)


def test_zero_nearer_by_many_powers_of_ten_is_come_to(kernel):
    # Bristles whose motion had died away to 1e-322 m closed a loop so: a search without end.
    series = np.array([1e-200, 0.0, 0.0, -1.0, 0.2])
    found = kernel.roots.first_series_root(series, 4, 1.0)
    assert found == pytest.approx(1e-200 ** (1.0 / 3.0), rel=1e-12, abs=0.0)
