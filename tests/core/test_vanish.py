"""When a blend of motion and normal force vanishes: against a fine march along the stretch."""

from __future__ import annotations

import math

import numpy as np
import pytest

LENGTH, FINE = 0.4, 800


def scene(kernel, seed):
    """Give a stretch under two sines and a swinging normal force, and a blend above zero."""
    random = np.random.default_rng(seed)
    c, w = float(random.uniform(0.0, 10.0)), float(random.choice([100.0, 1400.0, 2e4]))
    law = kernel.model.Slider(30.0, 1e5, 0.6, float(random.uniform(3.0, 40.0)), 0.3)
    stride = kernel.forcing.STRIDE
    waves = kernel.forcing.Waves([0.0] * (3 * stride), 3, 2)
    for i, f in enumerate((*random.uniform(0.5, 10.0, 2).tolist(), law.omega / 2 / math.pi)):
        kernel.forcing.set_wave(waves.values, i, 1.0, f, float(random.uniform(0.0, 6.0)))
    kernel.forcing.anchor(waves, kernel.model.Plant(1.0, w, c), law, 0.0, 0)
    x_r, v_r, g = (float(each) for each in random.normal(0.0, (0.01, 0.1, 2.0)))
    stretch = kernel.forcing.starting(c, w, waves, x_r, v_r, g, 0.0)
    shares = (-law.k_t, 0.0, law.F_fk, 0.0), (0.0, 1.0, 0.0, -1e-3), (-1e4, -100.0, 0.0, 0.0)
    share = shares[seed % 3]
    blend = kernel.roots.Blend(0.0, *share)
    if value_at(kernel, stretch, waves, law, blend, 0.0) < 0.0:
        blend = kernel.roots.Blend(0.0, *(-each for each in share))
    return stretch, waves, law, blend


def value_at(kernel, stretch, waves, law, blend, s):
    """Give the blend at a time of a stretch."""
    state = stretch.x_r, stretch.v_r, stretch.g, stretch.r
    x, v, _, _ = kernel.forcing.slide(stretch.c, stretch.w, waves, *state, s)
    load, load_d, _ = kernel.forcing.normal_force(law, waves, s)
    return blend.x * (x - blend.x_0) + blend.v * v + blend.load * load + blend.rate * load_d


@pytest.mark.parametrize("seed", range(24))
def test_first_zero_is_neither_missed_nor_invented(plain, seed):
    stretch, waves, law, blend = scene(plain, seed)
    s, x_r, v_r = plain.roots.vanish(stretch, waves, law, blend, 0, 0.0, LENGTH)
    t = np.linspace(0.0, LENGTH, FINE)
    values = [value_at(plain, stretch, waves, law, blend, at) for at in t.tolist()]
    below = np.flatnonzero(np.array(values) < 0.0)
    scale = max(map(abs, values))
    if s == math.inf:
        assert not len(below)
        return
    assert abs(value_at(plain, stretch, waves, law, blend, s)) < 1e-13 * scale
    assert t[below[0] - 1] <= s <= t[below[0]]
    state = stretch.x_r, stretch.v_r, stretch.g, stretch.r
    found = plain.forcing.slide(stretch.c, stretch.w, waves, *state, s)[:2]
    assert (x_r, v_r) == pytest.approx(found, rel=1e-12, abs=1e-15)
    assert plain.roots.vanish(stretch, waves, law, blend, 0, 0.0, 0.999 * s)[0] == math.inf


def test_slow_blend_that_may_turn_above_zero_is_not_taken_to_fall(kernel):
    # 1 - s/2 + s³/30 is 1/4 at the least, after more than two seconds.
    blend = kernel.roots
    course = blend.Course(1.0, -0.5, 0.0, 0.2)
    for most, falls in ((0.2, False), (0.02, True)):
        assert kernel.roots.falls_surely(*course[:3], most, 0.0) == falls


@pytest.mark.parametrize("seed", range(4))
def test_no_safe_step_passes_the_first_zero_of_what_bounds_the_speed(kernel, seed):
    random = np.random.default_rng(seed)
    for _ in range(200):
        v, snap, growth = abs(random.normal(size=3) * 10.0 ** random.integers(-3, 3, 3))
        a, j = random.normal(size=2) * 10.0 ** random.integers(-3, 3, 2)
        each = (float(value) for value in (v, a, j, snap, growth))
        step = kernel.roots.safe_slip(*each, 10.0)
        assert step <= 10.0
        h = np.linspace(0.0, step, 50)
        terms = v, a * h, j * h**2 / 2.0, -snap * h**3 / 6.0, -growth * h**4 / 24.0
        assert (sum(terms) >= -1e-12 * sum(map(np.abs, terms))).all()


def test_speed_that_slow_waves_lift_before_zero_does_not_stop(kernel):
    # The first two rates of ü cancel: v is 0.45 - f s + G s⁴/24 first, 0.07 at the least.
    pair, f, v = ((1.0, 0.25, 0.0), (2.0, 0.125, math.pi)), 0.125, 0.45
    waves = kernel.forcing.Waves(np.zeros(2 * kernel.forcing.STRIDE), 2, 2)
    for i, (A, omega, phase) in enumerate(pair):
        kernel.forcing.set_wave(waves.values, i, A, omega / (2.0 * math.pi), phase)
    plant, law = kernel.model.Plant(1.0, 0.0, 0.0), kernel.model.Law(f, f)
    kernel.forcing.anchor(waves, plant, law, 0.0, 1)
    stretch = kernel.forcing.starting(0.0, 0.0, waves, 0.0, v, -f, 0.0)
    state = stretch.x_r, stretch.v_r
    speeds = [kernel.forcing.slide(0.0, 0.0, waves, *state, -f, 0.0, s)[1] for s in range(9)]
    assert 0.05 < min(speeds) < 0.08
    stop, _ = kernel.roots.leave_slip(
        0.0, 0.0, waves, *state, stretch.a, stretch.j, -f, 0.0, 1, 8.0
    )
    assert stop == math.inf
