"""When a contact that holds yields: by its envelope, and by steps that a bound proves safe."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from law_scenes import elastic_law
from scenes import piecewise, waves_of

from drysim.core.forcing import Equation, Waves, motion_at, set_phases, set_wave, start_segment
from drysim.core.model import Plant
from drysim.core.modes import transient_response

# When a contact that holds yields: by its envelope, and by steps that a bound proves safe.


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
    mode = modes.mode_of(modes.HOLD, modes.UNKNOWN, modes.APART, 0)
    base = modes.SegmentBase(0.0, 0.0, 0.0)
    return modes.mode_equation(plant, law, waves, mode, x_0, base)[0]


def hold(kernel, segment, waves, law, x_0=0.0):
    """Return a holding segment for `end_of_hold`."""
    return kernel.modes.Hold(segment, waves, law, kernel.modes.load_ramp_at(law, 0.0), x_0, 0)


def with_limit(law, F):
    """Return an elastic contact with another limit [N]."""
    side = law.up._replace(F_fk=F, F_fs=F)
    return law._replace(up=side, down=side)


def deflection(kernel, stretch, waves, t):
    """Return x_r and v_r at times of a segment [s]."""
    scene = stretch.equation, waves, stretch.x_r, stretch.v_r
    return np.array([kernel.forcing.motion_at(*scene, at)[:2] for at in t.tolist()]).T


@pytest.mark.parametrize("sign", [-1, 1])
def test_side_that_never_yields_is_not_followed_to_the_end_each_time(plain, monkeypatch, sign):
    """A contact that a damper stills yields to one side soon, and to the other one never."""
    looks = []

    def counted(*given):
        looks.append(given[-1])
        return motion_at(*given)

    motion_at = plain.roots.motion_at
    monkeypatch.setattr(plain.roots, "motion_at", counted)
    plant = plain.model.Plant(75.0, 7500.0, 5e5)
    law = piecewise(plain, (40.0, 40.0), b=5e5, k_t=2e4)
    waves, x_0 = waves_of(plain, [(sign * 20.0, 1.6, -0.5)], law), sign * 1.9e-3
    equation = hold_equation(plain, plant, law, waves, x_0)
    stretch = plain.forcing.start_segment(equation, waves, 0.0, 0.0)
    s, side, _, _ = plain.modes.end_of_hold(hold(plain, stretch, waves, law, x_0), 2000.0)
    assert side == -sign
    assert s < 1.0
    assert len(looks) < 1000


def first_of_both(kernel, stretch, waves, law, h):
    """Return the result of `end_of_hold`, by a search of the whole segment on both sides."""
    sides = [
        (*kernel.modes.hold_exit_time(hold(kernel, stretch, waves, law), side, 0.0, h), side)
        for side in (-1, 1)
    ]
    s, x_r, v_r, side = min(sides)
    return s, side, x_r, v_r


@pytest.mark.parametrize("b", [0.0, 500.0, 2000.0])
@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_contact_yields_when_a_search_swing_by_swing_finds_it(fast, k_t, b):
    yielded = 0
    for seed in range(40):
        stretch, waves, law = scene(fast, seed, k_t, b)
        s, side, x_r, v_r = fast.modes.end_of_hold(hold(fast, stretch, waves, law), LENGTH)
        known = first_of_both(fast, stretch, waves, law, LENGTH)
        assert (s == math.inf) == (known[0] == math.inf)
        if s < math.inf:
            yielded += 1
            assert side == known[1]
            assert s == pytest.approx(known[0], rel=1e-12)
            assert x_r == pytest.approx(known[2], rel=1e-12)
            assert v_r == pytest.approx(
                known[3], abs=1e-9 * abs(x_r) * math.sqrt(stretch.equation.w)
            )
    assert 5 < yielded < 40


@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_peak_that_hardly_reaches_the_limit_is_not_missed_and_one_below_it_not_invented(
    fast, k_t
):
    tried = 0
    for seed in range(0, 20, 2):
        stretch, waves, law = scene(fast, seed, k_t)
        t = np.linspace(0.0, LENGTH, 4000)
        x_r, v_r = np.abs(deflection(fast, stretch, waves, t))
        highest = np.maximum.accumulate(x_r)
        peaks = np.flatnonzero((x_r[1:-1] >= highest[2:]) & (x_r[1:-1] > highest[:-2])) + 1
        for at in t[peaks].tolist():
            for _ in range(5):
                _, v_r, a, _, _ = fast.forcing.motion_at(
                    stretch.equation, waves, stretch.x_r, stretch.v_r, at
                )
                at -= v_r / a
            peak = float(np.abs(deflection(fast, stretch, waves, np.array([at]))[0, 0]))
            low, high = (with_limit(law, k_t * peak * (1.0 + e)) for e in (-1e-10, 1e-10))
            s, side, x_r, _ = fast.modes.end_of_hold(hold(fast, stretch, waves, low), LENGTH)
            assert s == pytest.approx(at, abs=1e-4 / math.sqrt(stretch.equation.w))
            assert side * x_r == pytest.approx(peak, rel=1e-9)
            assert fast.modes.end_of_hold(hold(fast, stretch, waves, high), LENGTH)[0] > at
            tried += 1
    assert tried > 15


@pytest.mark.parametrize("k_t", STIFFNESSES)
@pytest.mark.parametrize("loaded", [False, True])
def test_motion_stays_where_its_envelope_says_so(fast, k_t, loaded):
    led = 0
    for seed in range(30):
        stretch, waves, law = scene(fast, seed, k_t)
        own = fast.modes.transient_response(stretch, waves)
        middle, reach, begin = 1e-3 / k_t, law.up.F_fk / k_t, 0.01
        band = fast.modes.Band(middle, reach, loaded * law.variation, law.omega)
        until = fast.modes.safe_until(own, stretch, waves, band, begin, LENGTH)
        assert begin <= until <= LENGTH
        t = np.linspace(begin, until, 2000)
        load = 1.0 + loaded * law.variation * np.sin(law.omega * t + law.phase)
        if until > begin:
            led += 1
            room = reach * load - np.abs(deflection(fast, stretch, waves, t)[0] - middle)
            assert (room >= -1e-12 * reach).all()
    assert led > 5


def test_envelope_that_fades_below_the_limit_leads_on_to_the_end(fast):
    """Without waves a contact that once holds, holds: nothing is left to look at."""
    plant, law = fast.model.Plant(75.0, 7500.0, 500.0), piecewise(fast, (45.0, 45.0), k_t=1e7)
    stretch, waves, _ = stretch_of(fast, plant, law, waves_of(fast, [], law), (4e-6, 0.0))
    own = fast.modes.transient_response(stretch, waves)
    band = fast.modes.Band(0.0, 45.0 / 1e7, law.variation, law.omega)
    within = own, stretch, waves, band, 0.0
    assert fast.modes.safe_until(*within, 1e6) == 1e6
    assert fast.modes.end_of_hold(hold(fast, stretch, waves, law), 1e6)[0] == math.inf


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
        s, side, x_r, v_r = kernel.modes.end_of_hold(hold(kernel, stretch, waves, law), LENGTH)
        found.append((s, side * turned, x_r * turned, v_r * turned))
    assert found[0] == found[1] == found[2] or found[0][0] == found[1][0] == math.inf


# What a contact that holds has of its own besides the response to the base.


SINES = (1.0, 1.6, 0.2), (0.1, 0.9, 1.0)
LAW = elastic_law(1500.0, 1e6)


def ring_stretch_of(v_r, r):
    """Return a holding contact just after an impact, under two sines, and its waves."""
    plant = Plant(75.0, 7500.0 + LAW.k_t, 500.0)
    waves = Waves(np.zeros(24), 2, 2)
    for i, (A, f, phase) in enumerate(SINES):
        set_wave(waves.values, i, A, f, phase)
    set_phases(waves, plant, LAW, 0.0, 0)
    equation = Equation(plant.b / plant.m, plant.k_x / plant.m, 0.3, r)
    return waves, start_segment(equation, waves, 1e-4, v_r)


def responses(stretch):
    """Return the steady response to every sine, as a rotating length [m], and how it turns."""
    c, w, _, _ = stretch.equation
    for A, f, phase in SINES:
        turn = 2j * math.pi * f
        answer = -A / (turn * turn + c * turn + w)
        yield turn, answer * cmath.exp(1j * phase)


@pytest.mark.parametrize("v_r", [0.1, -0.1])
@pytest.mark.parametrize("r", [0.0, 30.0])
def test_ringing_and_steady_response_make_the_motion(v_r, r):
    waves, stretch = ring_stretch_of(v_r, r)
    own, (c, w, g, _) = transient_response(stretch, waves), stretch.equation
    assert abs(own.phase) <= 0.5 * math.pi
    for s in np.linspace(0.0, 0.1, 23).tolist():
        x_r = (
            own.side * own.size * math.exp(-own.decay * s) * math.cos(own.omega * s - own.phase)
        )
        x_r += (g + r * (s - c / w)) / w
        x_r += sum((each * cmath.exp(turn * s)).imag for turn, each in responses(stretch))
        found = motion_at(stretch.equation, waves, stretch.x_r, stretch.v_r, s).x_r
        assert found == pytest.approx(x_r, abs=1e-15)


def test_steady_response_bends_by_no_more_than_all_sines_together():
    waves, stretch = ring_stretch_of(0.1, 0.0)
    most = sum(abs(turn * turn * each) for turn, each in responses(stretch))
    assert transient_response(stretch, waves).max_acceleration == pytest.approx(most, rel=1e-12)
