"""The flow against arbitrary precision, in every damping regime."""

from __future__ import annotations

import math
from functools import cache
from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from scenes import march

REGIMES = {
    "light": (0.5, 100.0),
    "paper": (500 / 75, 100.0),
    "critical": (20.0, 100.0),
    "just above critical": (20.0 * (1 + 1e-8), 100.0),
    "heavy": (1000.0, 100.0),
    "no damper": (0.0, 100.0),
    "no spring": (2.0, 0.0),
    "free block": (0.0, 0.0),
    "nearly no spring": (1e3, 1e-10),
}

LENGTHS = (1e-6, 2.5e-3, 0.1, 1.0, 30.0)


@cache
def reference(c: float, w: float, omega: float, s: float) -> list[mp.mpf]:
    """Return y, y_d, Y, YY, R, P by the exponential of a matrix in 60 digits."""
    with mp.workdps(60):
        step = mp.matrix(
            [[0, 1, 0, 0], [-mp.mpf(w), -mp.mpf(c), 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
        )
        ramp = mp.expm(step * mp.mpf(s))
        step[3, 2] = -(mp.mpf(omega) ** 2)
        sine_response = mp.expm(step * mp.mpf(s))
        return [
            ramp[0, 1],
            ramp[1, 1],
            ramp[0, 2],
            ramp[0, 3],
            sine_response[0, 3],
            sine_response[0, 2],
        ]


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("s", LENGTHS)
def test_flow_and_wave_are_right_to_rounding_in_every_regime(kernel, regime, s):
    c, w = REGIMES[regime]
    if (c + math.sqrt(w)) * s > 2e3:
        pytest.skip("the reference itself would take minutes")
    omega = math.sqrt(w) or 3.0  # at resonance where there is one
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    R, P, _, sine, cosine = kernel.oscillator.sine_response(c, w, omega, s, y, y_d)
    want = reference(c, w, omega, s)
    turns = max(1.0, (c + math.sqrt(w) + omega) * s)
    # A value that crosses zero is measured against its swing: a tenth of that is enough.
    swing = min(s, 1 / c if c else s, s * s * s) / (10 * max(omega, 1 / s) ** 2)
    floors = (min(s, 1 / (omega + c)), 1.0, swing, swing, swing, swing * omega)
    for got, exact, floor in zip((y, y_d, Y, YY, R, P), want, floors, strict=True):
        assert abs(got - float(exact)) <= 2e-15 * turns * max(abs(float(exact)), floor)
    assert sine == pytest.approx(math.sin(omega * s) / omega, abs=1e-15 * turns / omega)
    assert cosine == pytest.approx(math.cos(omega * s), abs=1e-15 * turns)


def derivative_of_exponential(A: mp.matrix, E: mp.matrix) -> mp.matrix:
    """Return the derivative of exp(A) in direction E: a block of a larger exponential."""
    n = A.rows
    both = mp.matrix(2 * n)
    for i in range(n):
        for j in range(n):
            both[i, j] = both[n + i, n + j] = A[i, j]
            both[i, n + j] = E[i, j]
    return mp.expm(both)[:n, n:]


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("s", LENGTHS)
def test_derivatives_of_flow_and_wave_are_right_in_every_regime(kernel, regime, s):
    c, w = REGIMES[regime]
    if (c + math.sqrt(w)) * s > 300.0:
        pytest.skip("the reference itself would take minutes")
    omega = math.sqrt(w) or 3.0
    *flow, z, z_d, Z, ZZ = kernel.oscillator.flow_and_slope(c, w, s)
    assert tuple(flow) == kernel.oscillator.flow(c, w, s)
    found = kernel.oscillator.wave_response(c, w, omega, s)
    sizes = [s**3, s**2, s**4, s**5, s**2, s, s**4, s**3, s**3, s**2]
    expected = reference_derivatives(c, w, omega, s)
    for value, right, size in zip((z, z_d, Z, ZZ, *found), expected, sizes, strict=True):
        error = abs(complex(value) - complex(right))
        assert error <= 1e-11 * abs(complex(right)) + 1e-15 * size


@cache
def reference_derivatives(c: float, w: float, omega: float, s: float) -> list[mp.mpc]:
    """Return the derivatives of the flow by w, and those of the wave, in 40 digits."""
    with mp.workdps(40):
        A, by_w = mp.matrix(4), mp.matrix(4)
        A[0, 1], A[1, 0], A[1, 1], A[1, 2], A[2, 3] = s, -w * s, -c * s, s, s
        by_w[1, 0] = -s
        slope = derivative_of_exponential(A, by_w)
        expected = [slope[0, 1], slope[1, 1], slope[0, 2], slope[0, 3]]
        A[2, 3], A[2, 2] = 0, mp.mpc(0, omega * s)
        by_omega = mp.matrix(4)
        by_omega[2, 2] = mp.mpc(0, s)
        for matrix in (
            mp.expm(A),
            derivative_of_exponential(A, by_w),
            derivative_of_exponential(A, by_omega),
        ):
            expected += [matrix[0, 2], matrix[1, 2]]
    return expected


def test_doubling_a_stretch_is_two_stretches(kernel):
    c, w, s = 6.7, 100.0, 0.37
    y, y_d, Y, _ = kernel.oscillator.flow(c, w, s)
    y_2, y_d_2, _, _ = kernel.oscillator.flow(c, w, 2 * s)
    assert y_2 == pytest.approx(y * (1 - w * Y + y_d), rel=1e-13)
    assert y_d_2 == pytest.approx(y_d * y_d - w * y * y, rel=1e-13)


@pytest.mark.parametrize("c", [1e3, 1e5, 1e10, 1e15])
@pytest.mark.parametrize("w", [1e-10, 100.0, 1e8])
def test_flow_keeps_its_digits_however_strong_the_damper(kernel, c, w):
    # Each doubling had doubled the rounding of y: at c = 1e15 not a digit was left after 1 s.
    if 0.25 * c * c < w:
        pytest.skip("no strong damper")
    with mp.workdps(100):
        kappa = mp.sqrt(mp.mpf(c) ** 2 / 4 - mp.mpf(w))
        slow, fast = mp.mpf(c) / 2 - kappa, mp.mpf(c) / 2 + kappa
        y = (mp.exp(-slow) - mp.exp(-fast)) / (fast - slow)
        y_d = (fast * mp.exp(-fast) - slow * mp.exp(-slow)) / (fast - slow)
        Y = (1 - y_d - mp.mpf(c) * y) / mp.mpf(w)
        YY = (1 - y - mp.mpf(c) * Y) / mp.mpf(w)
        want = [float(exact) for exact in (y, y_d, Y, YY)]
    digits = 1e-14 * max(1.0, float(slow))
    assert kernel.oscillator.flow(c, w, 1.0) == pytest.approx(want, rel=digits, abs=0.0)


@pytest.mark.parametrize("turns", [1e2, 1e4, 1e6])
def test_long_slide_without_spring_and_damper_keeps_its_digits(kernel, turns):
    omega, s = 10.0, turns / 10.0
    found = kernel.oscillator.sine_response(
        0.0, 0.0, omega, s, *kernel.oscillator.flow(0.0, 0.0, s)[:2]
    )[:3]
    want = (
        (s - math.sin(turns) / omega) / omega**2,
        (1.0 - math.cos(turns)) / omega**2,
        math.sin(turns) / omega,
    )
    for value, exact, swing in zip(found, want, (s / omega**2, 1e-2, 0.1), strict=True):
        assert value == pytest.approx(exact, abs=1e-15 * swing)


# The series of a short stretch against the general way.


def flown(
    kernel: SimpleNamespace, c: float, w: float, v: float, a: float, r: float, s: float
) -> tuple[float, float]:
    """Return distance and velocity after a time s in closed form."""
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    p = a + c * v
    return v * y + p * Y + r * YY, v * y_d + p * y + r * Y


@pytest.mark.parametrize("radians", [0.099, 0.199])
@pytest.mark.parametrize(
    ("c", "w"),
    [(0.0, 100.0), (6.7, 100.0), (20.0, 100.0), (900.0, 100.0), (0.0, 0.0), (9.0, 0.0)],
)
def test_short_way_and_long_way_are_one(kernel, c, w, radians):
    rng = np.random.Generator(np.random.PCG64(5))
    h = radians / (c + math.sqrt(w)) if c + w else 1.0
    steps = kernel.oscillator.discretise_slip(c, w, h)
    assert steps.short
    stops = 0
    for _ in range(300):
        v, a, r = abs(rng.normal()), rng.normal() * 2 / h, rng.normal() * 4 / h**2
        scale = v + abs(a) * h + abs(r) * h * h
        q = kernel.oscillator.velocity_series(steps.factors, v, a, r - c * a - w * v)
        one = kernel.oscillator.series_distance(q, h), kernel.oscillator.series_velocity(q, h)
        other = flown(kernel, c, w, v, a, r, h)
        assert one[0] == pytest.approx(other[0], abs=1e-14 * scale * h)
        assert one[1] == pytest.approx(other[1], abs=1e-14 * scale)
        short = kernel.sampled.slide(steps, v, a, r, h, 0.0)
        long = kernel.sampled.slide_by_flow(c, w, v, a, r, h)
        if math.inf in (short[0], long[0]):
            assert short[0] == long[0]
        else:
            stops += 1
            assert short[0] == pytest.approx(long[0], rel=1e-12)
        assert short[1] == pytest.approx(long[1], abs=1e-14 * scale * h)
        assert short[2] == pytest.approx(long[2], abs=1e-14 * scale)
    assert stops > 50


def test_graze_is_left_to_the_long_way(kernel):
    # v = (s - 1)² touches zero and does not cross it: Newton on a series has no slope to go by.
    q = (1.0, -2.0, 1.0, *[0.0] * 9)
    assert kernel.oscillator.chebyshev_stop(q, 1.0)[0] == -1.0
    assert kernel.roots.locate_stop(0.0, 0.0, 1.0, -2.0, 2.0, 3.0) == pytest.approx(1.0)


def test_series_is_the_flow_to_the_last_digit(kernel):
    c, w, s = 6.7, 100.0, 3.5e-3
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    factors = kernel.oscillator.series_factors(c, w)
    for v, a, r in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.3, -70.0, 900.0)):
        q = kernel.oscillator.velocity_series(factors, v, a, r - c * a - w * v)
        p = a + c * v
        assert kernel.oscillator.series_distance(q, s) == pytest.approx(
            v * y + p * Y + r * YY, rel=1e-15
        )
        assert kernel.oscillator.series_velocity(q, s) == pytest.approx(
            v * y_d + p * y + r * Y, rel=1e-14
        )
        assert kernel.oscillator.series_acceleration(q, s) == pytest.approx(
            a * y_d + (r - w * v) * y, rel=1e-14
        )


def test_damped_series_has_every_digit_at_its_greatest_length(kernel):
    c, s = 200.0, 1e-3
    factors = kernel.oscillator.series_factors(c, 0.0)
    q = kernel.oscillator.velocity_series(factors, 0.0, 1.0, -c)
    assert kernel.oscillator.series_velocity(q, s) == pytest.approx(
        -math.expm1(-c * s) / c, rel=5e-16
    )


# Steps of many radians: what is found in them against a brute force that knows no bound.


OMEGA = 40.0
GRID = 1000


def motions(c: float, w: float, start: tuple[float, float, float], s: np.ndarray) -> np.ndarray:
    """Return path, velocity and acceleration on a grid of times, by powers of one matrix."""
    from scipy.linalg import expm

    v, a, r = start
    rates = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, -w, -c, r], [0, 0, 0, 0]], dtype=float)
    step, rows = expm(rates * (s[1] - s[0])), [np.array([0.0, v, a, 1.0])]
    while len(rows) < len(s):
        rows.append(step @ rows[-1])
    return np.array(rows).T[:3]


def starts(
    seed: int, count: int, series_acceleration: float = OMEGA
) -> list[tuple[float, float, float]]:
    """Draw v, a and r of stretches of sliding, some from rest and some that only dip."""
    rng = np.random.Generator(np.random.PCG64(seed))
    drawn = []
    for _ in range(count):
        v, a, r = (
            abs(rng.normal()),
            rng.normal() * series_acceleration,
            rng.normal() * series_acceleration**2,
        )
        v, a = rng.choice([(v, a), (0.0, abs(a)), (abs(r) / series_acceleration**2, 0.95 * a)])
        drawn.append((float(v), float(a), float(r)))
    return drawn


@pytest.mark.parametrize("xi", [0.0, 0.03, 0.33, 1.0, 3.0])
@pytest.mark.parametrize("radians", [0.2, 0.6, 2.9, 3.1, 20.0, 150.0, 400.0])
def test_first_stop_of_a_long_step_is_that_of_a_scan(fast, xi, radians):
    c, w, h = 2.0 * xi * OMEGA, OMEGA**2, radians / OMEGA
    steps = fast.oscillator.discretise_slip(c, w, h)
    stops = 0
    for start in starts(3, 24, max(OMEGA, 4.0 / h)):
        stop, way, v_end, _ = fast.sampled.slide(steps, *start, h, 0.0)
        end = min(stop, h)
        s = np.linspace(0.0, end, GRID)
        x, v, _ = motions(c, w, start, s)
        size = np.abs(v).max()
        stops += stop < math.inf
        # An undamped scan of hundreds of radians has errors of its own.
        near = 1e-12 * max(1.0, radians) * size
        assert v.min() >= -near
        assert v[-1] == pytest.approx(0.0 if stop < math.inf else v_end, abs=near)
        assert way == pytest.approx(x[-1], abs=near * h)
    assert 3 <= stops < 24


@pytest.mark.parametrize("xi", [0.0, 0.03, 0.33, 1.0, 3.0])
def test_mass_of_too_little_energy_never_stops(kernel, xi):
    c, w, s = 2.0 * xi * OMEGA, OMEGA**2, np.linspace(0.0, 12.0 / OMEGA, 200)
    told = {True: 0, False: 0}
    for start in starts(5, 60):
        never = kernel.roots.never_stops(c, w, *start)
        least = motions(c, w, start, s)[1][1:].min()
        told[bool(never)] += 1
        assert least > 0.0 or not never
        # Without a damper it is a law, not a bound.
        assert never or xi > 0.0 or least < 1e-3
    assert min(told.values()) > 5


def test_stop_of_a_creep_after_very_many_decays_is_found(kernel):
    # What a strong damper leaves falls as exp(-w s/c) from 1 towards -1/2.
    c, w, h = 1000.0, 1.0, 2000.0
    steps = kernel.oscillator.discretise_slip(c, w, h)
    slow = 2.0 * w / (c + math.sqrt(c * c - 4.0 * w))
    start = 1.0, -1.5 * slow, -0.5 * w
    stop, way, v_end, _ = kernel.sampled.slide(steps, *start, h, 0.0)
    # The flow over two million decays is doubled up from half of one.
    assert stop == pytest.approx(math.log(3.0) / slow, rel=1e-10)
    assert way == pytest.approx(1.0 / slow - 0.5 * stop, rel=1e-9)
    assert v_end == 0.0


def brute_force(
    plant: tuple[float, float, float], F: tuple[float, float], u_dd: np.ndarray, dt: float
) -> list[tuple[float, int]]:
    """Return times and kinds of events: thousands of steps where the march takes one."""
    from scipy.linalg import expm

    (m, k_x, b), (F_fk, F_fs) = plant, F
    h = dt / GRID
    rates = np.array(
        [[0, 1, 0, 0], [-k_x / m, -b / m, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float
    )
    xx, xv, xu, xr, vx, vv, vu, vr = expm(rates * h)[:2].ravel().tolist()
    x, v, d, found = 0.0, 0.0, 0, []
    for n in range(len(u_dd) - 1):
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        for i in range(GRID):
            t, u = n * dt + i * h, u_dd[n] + slope * i * h
            if d == 0:
                F_0, F_1 = m * u + k_x * x, m * (u + slope * h) + k_x * x
                if abs(F_1) <= F_fs:
                    continue
                d = -1 if F_1 > 0.0 else 1
                share = (-d * F_fs - F_0) / (F_1 - F_0)
                found.append((t + share * h, d))
            else:
                g = u + d * F_fk / m
                x_1 = xx * x + xv * v + xu * g + xr * slope
                v_1 = vx * x + vv * v + vu * g + vr * slope
                if d * v_1 > 0.0:
                    x, v = x_1, v_1
                    continue
                share = v / (v - v_1)
                x += 0.5 * share * h * v
                F_L = m * (u + slope * share * h) + k_x * x
                d = 0 if abs(F_L) <= F_fs else (-1 if F_L > 0.0 else 1)
                found.append((t + share * h, 2 * d))
            left = (1.0 - share) * h
            a = -(u + slope * share * h + k_x / m * x + d * F_fk / m) if d != 0 else 0.0
            x, v = x + 0.5 * a * left * left, a * left
    return found


@pytest.mark.parametrize("radians", [0.6, 1.0, 3.0, 7.0, 20.0])
@pytest.mark.parametrize(
    ("xi", "F"), [(0.33, (0.2, 0.24)), (0.05, (0.3, 0.4)), (1.5, (0.1, 0.1))]
)
def test_events_of_long_steps_are_those_of_a_brute_force(fast, xi, F, radians):
    dt = radians / OMEGA
    plant = (1.0, OMEGA**2, 2.0 * xi * OMEGA)
    rough = np.random.Generator(np.random.PCG64(2)).normal(size=40)
    u_dd = np.convolve(rough, [0.25, 0.5, 0.25], mode="same")
    u_dd[0] = 0.0
    found, other = march(fast, u_dd, dt, F, plant), brute_force(plant, F, u_dd, dt)
    assert found.events[2].tolist() == [kind for _, kind in other]
    assert len(other) >= 10
    assert np.abs(found.t - [t for t, _ in other]).max() < 2.0 * dt / GRID


@pytest.mark.parametrize("radians", [0.6, 3.0, 20.0, 400.0])
def test_mirrored_motion_in_long_steps_gives_the_mirrored_answer_bit_for_bit(kernel, radians):
    plant, dt = (1.0, OMEGA**2, 0.1 * OMEGA), radians / OMEGA
    u_dd = np.random.Generator(np.random.PCG64(6)).normal(size=60)
    one = march(kernel, u_dd, dt, (0.3, 0.4), plant, (0.01, -0.2))
    other = march(kernel, -u_dd, dt, (0.3, 0.4), plant, (-0.01, 0.2))
    assert len(one.t) > 10
    assert np.array_equal(one.x_r, -other.x_r)
    assert np.array_equal(one.v_r, -other.v_r)
    assert np.array_equal(one.t, other.t)
