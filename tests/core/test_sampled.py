"""The march over samples: the rules of stick and slip, and what must not change its answer."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scenes import PAPER, log_of, march, waves_of

DT = 2.5e-3


def noise(n: int, seed: int = 5, rms: float = 0.67) -> np.ndarray:
    """Return smooth noise of a few hertz."""
    rng = np.random.Generator(np.random.PCG64(seed))
    rough = np.convolve(rng.normal(size=n + 200), np.hanning(41), mode="same")[100 : n + 100]
    return rough * (rms / np.sqrt(np.mean(rough**2)))


@pytest.mark.parametrize("F", [(15.0, 15.0), (45.0, 54.0), (12.0, 60.0), (1e-9, 1.2e-9)])
def test_stuck_means_no_velocity_at_all_and_a_bearable_force(kernel, F):
    u_dd = noise(4000)
    found = march(kernel, u_dd, DT, F)
    stuck = found.d == 0
    assert (found.v_r[stuck] == 0.0).all()
    F_L = PAPER[0] * u_dd[stuck] + PAPER[1] * found.x_r[stuck]
    assert (np.abs(F_L) <= F[1]).all()
    assert (np.sign(found.v_r[~stuck]) * found.d[~stuck] >= 0).all()


@pytest.mark.parametrize("F", [(15.0, 15.0), (45.0, 54.0), (0.5, 0.5)])
def test_mirrored_motion_gives_the_mirrored_answer_bit_for_bit(kernel, F):
    u_dd = noise(4000)
    one = march(kernel, u_dd, DT, F, start=(0.002, -0.01))
    other = march(kernel, -u_dd, DT, F, start=(-0.002, 0.01))
    assert np.array_equal(one.x_r, -other.x_r)
    assert np.array_equal(one.v_r, -other.v_r)
    assert np.array_equal(one.t, other.t)


def test_scaled_motion_and_friction_give_the_scaled_answer(kernel):
    u_dd = noise(4000)
    one = march(kernel, u_dd, DT, (30.0, 36.0))
    for scale in (1e-12, 3.7, 1e12):
        other = march(kernel, scale * u_dd, DT, (scale * 30.0, scale * 36.0))
        assert len(other.t) == len(one.t)
        assert np.abs(other.x_r / scale - one.x_r).max() <= 1e-12 * np.abs(one.x_r).max()


def in_parts(kernel: SimpleNamespace, u_dd: np.ndarray, ends: tuple[int, ...]) -> np.ndarray:
    """March from one end to the next; gives x_r and v_r."""
    plant, law = kernel.model.Plant(*PAPER), kernel.model.CoulombLaw(45.0, 54.0)
    columns = [np.zeros(3000), np.zeros(3000), np.zeros(3000, dtype=np.int64)]
    columns[2][0] = kernel.events.initial_direction(plant, law, 0.0, 0.0, u_dd[0])[0]
    sampled = kernel.sampled
    scene = kernel.forcing.Scene(plant, law, waves_of(kernel, [], law), u_dd, DT)
    out, base_sums = sampled.SampledMotion(*columns), sampled.empty_base_sums()
    state = sampled.SlipState(0, 0.0, 0.0, 0.0, int(columns[2][0]), math.nan, 0, math.inf)
    for end in ends:
        state = sampled.march(
            scene, state._replace(events=0), out, log_of(kernel), end, base_sums
        )
    return np.array(columns[:2])


def test_march_handed_over_between_stretches_goes_on_to_the_last_bit(kernel):
    u_dd, stretch = noise(3000), kernel.sampled.CHUNK
    whole = in_parts(kernel, u_dd, (2999,))
    parts = in_parts(kernel, u_dd, (stretch, 4 * stretch, 9 * stretch, 2999))
    assert np.array_equal(parts, whole)


def test_march_interrupted_anywhere_goes_on_to_rounding(kernel):
    u_dd = noise(3000)
    whole = in_parts(kernel, u_dd, (2999,))
    parts = in_parts(kernel, u_dd, (1, 700, 701, 1703, 2999))
    for one, other in zip(parts, whole, strict=True):
        assert np.abs(one - other).max() <= 1e-14 * np.abs(other).max()


def test_march_interrupted_by_a_full_log_goes_on_to_the_last_bit(kernel):
    u_dd = noise(3000)
    whole = march(kernel, u_dd, DT, (30.0, 36.0))
    plant, law = kernel.model.Plant(*PAPER), kernel.model.CoulombLaw(30.0, 36.0)
    columns = [np.zeros(3000), np.zeros(3000), np.zeros(3000, dtype=np.int64)]
    sampled = kernel.sampled
    scene = kernel.forcing.Scene(plant, law, waves_of(kernel, [], law), u_dd, DT)
    out, base_sums = sampled.SampledMotion(*columns), sampled.empty_base_sums()
    state = sampled.SlipState(0, 0.0, 0.0, 0.0, int(whole.d[0]), math.nan, 0, math.inf)
    handed = 0
    while state.n < 2999:
        log = log_of(kernel, kernel.events.MAX_EVENTS_PER_STEP + 2)
        state = sampled.march(scene, state._replace(events=0), out, log, 2999, base_sums)
        handed += 1
    assert handed > 5
    assert np.array_equal(columns[0][1:], whole.x_r[1:])
    assert np.array_equal(columns[1][1:], whole.v_r[1:])


def test_sampling_the_same_lines_more_finely_changes_nothing(kernel):
    u_dd = noise(800)
    fine = np.interp(np.arange(799 * 5 + 1) / 5, np.arange(800), u_dd)
    one = march(kernel, u_dd, DT, (30.0, 36.0))
    other = march(kernel, fine, DT / 5, (30.0, 36.0))
    assert len(one.t) == len(other.t)
    assert np.abs(one.t - other.t).max() <= 1e-12
    assert np.abs(one.x_r - other.x_r[::5]).max() <= 1e-13 * np.abs(one.x_r).max()


def test_record_with_flat_tops_rests_exactly_on_the_limit(kernel):
    # 75 kg times 0.6 m/s² is the limit of 45 N to the last bit.
    u_dd = np.repeat([0.0, 0.6, -0.6, 0.6, 0.0], 50)
    found = march(kernel, u_dd, DT, (45.0, 45.0))
    assert (found.x_r == 0.0).all()
    assert (found.d == 0).all()
    moved = march(kernel, u_dd * (1 + 1e-14), DT, (45.0, 45.0))
    assert len(moved.t) > 0


def test_break_away_without_a_drop_in_friction_does_not_restick_at_once(kernel):
    u_dd = np.linspace(0.0, 2.0, 200)
    found = march(kernel, u_dd, DT, (45.0, 45.0))
    assert found.events[2].tolist() == [-1]
    assert found.t[0] == pytest.approx(0.6 / 2.0 * 199 * DT, rel=1e-14)


def test_two_reversals_inside_one_step_are_both_found(kernel):
    # Without spring and damper a long triangle turns the block twice within one interval.
    plant = (1.0, 0.0, 0.0)
    u_dd = np.array([30.0, -30.0, 30.0])
    found = march(kernel, u_dd, 1.0, (1.0, 1.0), plant=plant, start=(0.0, 5.0))
    per_step = np.bincount(found.events[0])
    assert per_step.max() >= 2
    assert (np.diff(found.t) > 0).all()


@pytest.mark.parametrize("stretch", [5.0, 50.0, 1000.0])
def test_step_far_longer_than_the_natural_period_is_solved_exactly(kernel, stretch):
    # ω_0 Δt = stretch: the same lines on a grid fine enough for the oscillator.
    w = (stretch / DT) ** 2
    plant = (75.0, 75.0 * w, 2 * 0.05 * 75.0 * np.sqrt(w))
    u_dd = noise(12)
    pieces = int(20 * stretch)
    fine = np.interp(np.arange(11 * pieces + 1) / pieces, np.arange(12), u_dd)
    one = march(kernel, u_dd, DT, (15.0, 18.0), plant=plant)
    other = march(kernel, fine, DT / pieces, (15.0, 18.0), plant=plant)
    assert len(one.t) == len(other.t)
    assert np.abs(one.x_r - other.x_r[::pieces]).max() <= 1e-10 * np.abs(other.x_r).max()


def test_recursion_without_friction_is_the_march_without_friction(kernel):
    u_dd = noise(4000)
    x_r, v_r = np.zeros(4000), np.zeros(4000)
    kernel.oscillator.linear_recursion(
        kernel.model.Plant(*PAPER), u_dd, DT, 0.001, 0.02, x_r, v_r
    )
    found = march(kernel, u_dd, DT, (0.0, 0.0), start=(0.001, 0.02))
    assert np.abs(x_r - found.x_r).max() <= 1e-14 * np.abs(x_r).max()


def test_quick_dip_below_zero_in_a_stiff_critical_step_is_not_missed(kernel):
    # The acceleration that turns the dip round has died away at the end of the step.
    stiff = (1.0, 2500.0, 100.0 * (1 + 1e-8))
    u_dd = np.array([0.0, -40.0, -80.0])
    found = march(kernel, u_dd, 1.0, (0.1, 0.1), plant=stiff, start=(0.01, 0.05))
    fine = np.interp(np.arange(2001) / 1000, np.arange(3), u_dd)
    other = march(kernel, fine, 1e-3, (0.1, 0.1), plant=stiff, start=(0.01, 0.05))
    assert found.events[2].tolist() == other.events[2].tolist()
    assert len(found.t) >= 2
    assert np.abs(found.t - other.t).max() < 1e-11


@pytest.mark.parametrize("ahead", range(8, 12))
def test_stop_between_two_sound_samples_four_apart_is_found(kernel, ahead):
    # The base turns over: four samples on, the block is faster than before.
    u, f, v = 2.0, 0.2, 2.0 * DT
    u_dd = np.array([u] * (ahead + 2) + [-u] * 8)
    start = (0.0, v + (u + f) * ahead * DT)
    found = march(kernel, u_dd, DT, (f, f), (1.0, 0.0, 0.0), start)
    assert found.t[0] == pytest.approx(start[1] / (u + f), rel=1e-13)


# The march against the leap, which finds its events another way: random scenes, no misses.


SAMPLES = 600


def scene(rng: Any) -> tuple[np.ndarray, float, tuple[float, ...], tuple[float, float], Any]:
    """Draw a record, its step, a plant, friction and a start."""
    dt = 10.0 ** rng.uniform(-4.0, -1.7)
    radians = 10.0 ** rng.uniform(-3.0, 0.7)
    omega = radians / dt * rng.choice([1.0, 1.0, 1.0, 0.0])
    damping = 2.0 * rng.choice([0.0, 0.03, 0.3, 1.0, 3.0]) * max(omega, 0.1 * radians / dt)
    width = int(rng.choice([1, 4, 15, 60]))
    rough = np.convolve(
        rng.normal(size=SAMPLES + 2 * width), np.hanning(width + 2), mode="same"
    )
    u_dd = rough[:SAMPLES] / np.std(rough)
    limit = 10.0 ** rng.uniform(-1.5, 0.3)
    friction = (limit, limit * rng.choice([1.0, 1.0, 1.2, 3.0]))
    start = (0.0, 0.0) if rng.random() < 0.5 else (0.0, rng.normal() * dt * width)
    return u_dd, dt, (1.0, omega**2, damping), friction, start


def leap(
    kernel: SimpleNamespace, u_dd: np.ndarray, dt: float, F: Any, plant: Any, start: Any
) -> SimpleNamespace:
    """Leap over samples, step by step; gives x_r, v_r and the events."""
    core_plant, law = kernel.model.Plant(*plant), kernel.model.CoulombLaw(*F)
    x_r, v_r, d = np.zeros(len(u_dd)), np.zeros(len(u_dd)), np.zeros(len(u_dd), dtype=np.int64)
    mode = kernel.events.initial_direction(core_plant, law, *start, u_dd[0])[0]
    x_r[0], v_r[0] = start
    log = log_of(kernel)
    scene = kernel.forcing.Scene(core_plant, law, waves_of(kernel, [], law), u_dd, dt)
    state = kernel.march.SlipState(0, 0.0, *start, mode, math.nan, 0, math.inf)
    end = kernel.march.march_varying_limits(scene, 0, len(u_dd) - 1, state, (x_r, v_r, d), log)
    events = [column[: end.events].copy() for column in log]
    return SimpleNamespace(
        x_r=x_r, v_r=v_r, kinds=events[2], t=events[0] * dt + events[1], closest=end.closest
    )


def differ(kernel: SimpleNamespace, seed: int) -> tuple[int, float]:
    """Solve one random scene both ways; gives its events and how far the answers differ."""
    u_dd, dt, plant, F, start = scene(np.random.Generator(np.random.PCG64(seed)))
    one = march(kernel, u_dd, dt, F, plant, start)
    other = leap(kernel, u_dd, dt, F, plant, start)
    if not np.array_equal(one.events[2], other.kinds):
        return len(other.t), math.inf
    x, v = np.abs(other.x_r).max() or 1.0, np.abs(other.v_r).max() or 1.0
    return len(other.t), max(
        np.abs(one.x_r - other.x_r).max() / x, np.abs(one.v_r - other.v_r).max() / v
    )


def test_march_finds_what_the_leap_finds(fast):
    found = [differ(fast, seed) for seed in range(60)]
    assert sum(events for events, _ in found) > 2000
    assert max(error for _, error in found) < 1e-10


@pytest.mark.slow
def test_march_finds_what_the_leap_finds_in_thousands_of_scenes(fast):
    # Undamped stiff scenes turn some hundred times, and each turn multiplies a rounding.
    assert max(differ(fast, seed)[1] for seed in range(1000, 4000)) < 1e-8
