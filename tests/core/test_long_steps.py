"""Steps of many radians: what is found in them against a brute force that knows no bound."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import march

OMEGA = 40.0
GRID = 1000


def motions(c: float, w: float, start: tuple[float, float, float], s: np.ndarray) -> np.ndarray:
    """Give way, velocity and acceleration on a grid of times, by powers of one matrix."""
    from scipy.linalg import expm

    v, a, r = start
    rates = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, -w, -c, r], [0, 0, 0, 0]], dtype=float)
    step, rows = expm(rates * (s[1] - s[0])), [np.array([0.0, v, a, 1.0])]
    while len(rows) < len(s):
        rows.append(step @ rows[-1])
    return np.array(rows).T[:3]


def starts(seed: int, count: int, rate: float = OMEGA) -> list[tuple[float, float, float]]:
    """Draw v, a and r of stretches of sliding, some from rest and some that only dip."""
    rng = np.random.Generator(np.random.PCG64(seed))
    drawn = []
    for _ in range(count):
        v, a, r = abs(rng.normal()), rng.normal() * rate, rng.normal() * rate**2
        v, a = rng.choice([(v, a), (0.0, abs(a)), (abs(r) / rate**2, 0.95 * a)])
        drawn.append((float(v), float(a), float(r)))
    return drawn


@pytest.mark.parametrize("xi", [0.0, 0.03, 0.33, 1.0, 3.0])
@pytest.mark.parametrize("radians", [0.2, 0.6, 2.9, 3.1, 20.0, 150.0, 400.0])
def test_first_stop_of_a_long_step_is_that_of_a_scan(
    fast: SimpleNamespace, xi: float, radians: float
) -> None:
    c, w, h = 2.0 * xi * OMEGA, OMEGA**2, radians / OMEGA
    plant, law = fast.model.Plant(1.0, w, c), fast.model.Law(0.0, 0.0)
    steps = fast.oscillator.steps_of(plant, law, h)
    parts = fast.sampled.parts_of(steps)
    stops = 0
    for start in starts(3, 60, max(OMEGA, 4.0 / h)):
        stop, way, v_end, _ = fast.sampled.slide_on(steps, parts, *start, h)
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
    assert 10 <= stops <= 50


@pytest.mark.parametrize("xi", [0.0, 0.03, 0.33, 1.0, 3.0])
def test_mass_of_too_little_energy_never_stops(kernel: SimpleNamespace, xi: float) -> None:
    c, w, s = 2.0 * xi * OMEGA, OMEGA**2, np.linspace(0.0, 12.0 / OMEGA, 200)
    told = {True: 0, False: 0}
    for start in starts(5, 100):
        never = kernel.roots.never_stops(c, w, *start)
        least = motions(c, w, start, s)[1][1:].min()
        told[bool(never)] += 1
        assert least > 0.0 or not never
        # Without a damper it is a law, not a bound.
        assert never or xi > 0.0 or least < 1e-3
    assert min(told.values()) > 10


def test_both_ways_through_a_short_step_find_one_stop(kernel: SimpleNamespace) -> None:
    plant, law = kernel.model.Plant(1.0, OMEGA**2, 20.0), kernel.model.Law(0.0, 0.0)
    steps = kernel.oscillator.steps_of(plant, law, 0.3 / OMEGA)
    assert steps.short
    parts = kernel.sampled.parts_of(steps)
    for v, a, r in starts(9, 200, 4.0 / steps.dt):
        v_end = kernel.sampled.coast(steps, v, a, r, steps.dt)[1]
        stop, way = kernel.sampled.stop_within(steps, v, a, r, v_end, steps.dt)
        other, far, _, _ = kernel.sampled.slide_on(steps, parts, v, a, r, steps.dt)
        assert (stop == math.inf) == (other == math.inf)
        if stop < math.inf:
            assert other == pytest.approx(stop, rel=1e-12)
            assert far == pytest.approx(way, rel=1e-12)


def test_stop_of_a_creep_far_beyond_the_parts_that_are_walked_is_found(
    kernel: SimpleNamespace,
) -> None:
    # What a strong damper leaves falls as exp(-w s/c) from 1 towards -1/2.
    c, w, h = 1000.0, 1.0, 2000.0
    plant, law = kernel.model.Plant(1.0, w, c), kernel.model.Law(0.0, 0.0)
    steps = kernel.oscillator.steps_of(plant, law, h)
    slow = 2.0 * w / (c + math.sqrt(c * c - 4.0 * w))
    start = 1.0, -1.5 * slow, -0.5 * w
    stop, way, v_end, _ = kernel.sampled.slide_on(
        steps, kernel.sampled.parts_of(steps), *start, h
    )
    # The flow over two million decays is doubled up from half of one.
    assert stop == pytest.approx(math.log(3.0) / slow, rel=1e-10)
    assert way == pytest.approx(1.0 / slow - 0.5 * stop, rel=1e-9)
    assert v_end == 0.0


def brute_force(
    plant: tuple[float, float, float], F: tuple[float, float], u_dd: np.ndarray, dt: float
) -> list[tuple[float, int]]:
    """Give times and kinds of events: thousands of steps where the march takes one."""
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
def test_events_of_long_steps_are_those_of_a_brute_force(
    fast: SimpleNamespace, xi: float, F: tuple[float, float], radians: float
) -> None:
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
def test_mirrored_motion_in_long_steps_gives_the_mirrored_answer_bit_for_bit(
    kernel: SimpleNamespace, radians: float
) -> None:
    plant, dt = (1.0, OMEGA**2, 0.1 * OMEGA), radians / OMEGA
    u_dd = np.random.Generator(np.random.PCG64(6)).normal(size=60)
    one = march(kernel, u_dd, dt, (0.3, 0.4), plant, (0.01, -0.2))
    other = march(kernel, -u_dd, dt, (0.3, 0.4), plant, (-0.01, 0.2))
    assert len(one.t) > 10
    assert np.array_equal(one.x_r, -other.x_r)
    assert np.array_equal(one.v_r, -other.v_r)
    assert np.array_equal(one.t, other.t)
