"""When a contact that holds yields, by steps that a bound proves safe."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import piecewise, waves_of

LENGTH = 0.7
STIFFNESSES = 2e4, 1e6, 1e7


def scene(kernel, seed, k_t, b=500.0):
    """Return a segment of a holding contact under two sines, and its law."""
    random = np.random.default_rng(seed)
    plant = kernel.model.Plant(75.0, 7500.0, b)
    swing = 0.4 * (seed % 2), float(random.uniform(3.0, 15.0)), float(random.uniform(0.0, 6.0))
    # The greater wave pulls with some 75 N on the contact, which gives so much to it.
    limit, slack = 75.0 * float(random.uniform(0.4, 3.0)), 75.0 / k_t
    law = piecewise(kernel, (limit, limit), b=b, k_t=k_t, wave=swing)
    phases = random.uniform(0.0, 6.0, 2).tolist()
    waves = waves_of(kernel, [(0.9, 1.6, phases[0]), (0.2, 5.0, phases[1])], law)
    return stretch_of(kernel, plant, law, waves, slack * random.uniform(-0.4, 0.4, 2))


def stretch_of(kernel, plant, law, waves, start):
    """Return the segment of a contact with a deflection and a velocity over omega [m]."""
    equation = hold_equation(kernel, plant, law, waves)
    x_r, v_r = float(start[0]), float(start[1]) * math.sqrt(equation.w)
    return kernel.forcing.start_segment(equation, waves, x_r, v_r), waves, law


def hold_equation(kernel, plant, law, waves, x_0=0.0):
    """Return the equation of motion of a contact that holds."""
    modes = kernel.modes
    mode = modes.mode_of(modes.HOLD, 1, modes.APART, 0)
    base = modes.SegmentBase(0.0, 0.0, 0.0)
    return modes.mode_equation(plant, law, waves, mode, x_0, base)[0]


def hold(kernel, segment, waves, law, x_0=0.0):
    """Return a holding segment for `guard_hold`."""
    return kernel.modes.Hold(segment, waves, law, kernel.modes.load_ramp_at(law, 0.0), x_0, 0)


def with_limit(law, F):
    """Return an elastic contact with another limit [N]."""
    side = law.up._replace(F_fk=F, F_fs=F)
    return law._replace(up=side, down=side)


def deflection(kernel, stretch, waves, t):
    """Return x_r and v_r at times of a segment [s]."""
    scene = stretch.equation, waves, stretch.x_r, stretch.v_r
    return np.array([kernel.forcing.motion_at(*scene, at)[:2] for at in t.tolist()]).T


def half_swing(kernel, stretch, waves, law):
    """Return the direction of motion, and the time for which it is kept within LENGTH [s]."""
    d = kernel.events.motion_direction(stretch.v_r, stretch.a, stretch.j)
    return d, min(kernel.roots.first_stop(stretch, waves, law, d, LENGTH)[0], LENGTH)


def first_of_both(kernel, stretch, waves, law, h):
    """Return the result of `guard_hold`, by a search on both sides."""
    sides = [
        (*kernel.modes.guard_hold_side(hold(kernel, stretch, waves, law), side, h), side)
        for side in (-1, 1)
    ]
    s, x_r, v_r, side = min(sides)
    return s, side, x_r, v_r


@pytest.mark.parametrize("b", [0.0, 500.0, 2000.0])
@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_contact_yields_when_a_search_on_both_sides_finds_it(fast, k_t, b):
    yielded = 0
    for seed in range(40):
        stretch, waves, law = scene(fast, seed, k_t, b)
        d, h = half_swing(fast, stretch, waves, law)
        found = fast.modes.guard_hold(hold(fast, stretch, waves, law), d, h)
        known = first_of_both(fast, stretch, waves, law, h)
        assert found[0] == known[0]
        if found[0] < math.inf:
            yielded += 1
            assert found == known
    assert 2 < yielded < 40


@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_peak_that_just_reaches_the_limit_is_found_and_one_below_it_is_not(fast, k_t):
    tried = 0
    for seed in range(0, 20, 2):  # a constant normal force
        stretch, waves, law = scene(fast, seed, k_t)
        d, h = half_swing(fast, stretch, waves, law)
        peak = d * deflection(fast, stretch, waves, np.array([h]))[0, 0]
        if h == LENGTH or not peak > 0.0:
            continue
        low, high = (with_limit(law, k_t * peak * (1.0 + e)) for e in (-1e-10, 1e-10))
        s, side, x_r, _ = fast.modes.guard_hold(hold(fast, stretch, waves, low), d, h)
        assert s == pytest.approx(h, abs=1e-4 / math.sqrt(stretch.equation.w))
        assert (side, side * x_r) == (d, pytest.approx(peak, rel=1e-9))
        assert fast.modes.guard_hold(hold(fast, stretch, waves, high), d, h)[0] == math.inf
        tried += 1
    assert tried > 5


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_engines_and_mirror_agree_bit_for_bit(plain, fast, seed, k_t):
    found = []
    for kernel, turned in ((plain, 1.0), (fast, 1.0), (fast, -1.0)):
        stretch, waves, law = scene(kernel, seed, k_t)
        for i in range(waves.base):
            waves.values[kernel.forcing.WAVE_COLUMNS * i + kernel.forcing.A] *= turned
        plant = kernel.model.Plant(75.0, 7500.0, 500.0)
        start = turned * stretch.x_r, turned * stretch.v_r
        equation = hold_equation(kernel, plant, law, waves)
        stretch = kernel.forcing.start_segment(equation, waves, *start)
        d, h = half_swing(kernel, stretch, waves, law)
        s, side, x_r, v_r = kernel.modes.guard_hold(hold(kernel, stretch, waves, law), d, h)
        found.append((s, side * turned, x_r * turned, v_r * turned))
    assert found[0] == found[1] == found[2] or found[0][0] == found[1][0] == math.inf
