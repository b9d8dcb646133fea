"""Leaps under sines: scenes with known answers, and what must not change an answer."""

from __future__ import annotations

import itertools
import math
from itertools import pairwise

import numpy as np
import pytest
from scenes import PAPER, log_of, march, march_modes, march_sines, piecewise, waves_of

PAIR = [(1.4, 1.1, 0.4), (0.9, 3.7, 1.0)]


def test_free_decay_turns_and_stops_where_coulomb_says(kernel):
    # m = k = F = 1 from x = 12, v = 6: amplitude falls by 2 F/k each half cycle.
    found = march_sines(kernel, [], (1.0, 1.0), 30.0, plant=(1.0, 1.0, 0.0), start=(12.0, 6.0))
    assert found.t[0] == pytest.approx(0.432408, abs=5e-7)
    turns = np.abs(found.x[:-1])
    assert turns[0] == pytest.approx(13.317821, abs=5e-7)
    assert np.abs(np.diff(turns) + 2.0).max() < 1e-13
    assert found.t[-1] == pytest.approx(22.42355635, abs=5e-9)
    assert found.x[-1] == pytest.approx(0.68217894, abs=5e-9)
    assert found.kind[-1] == 0
    assert found.end[1:] == (found.x[-1], 0.0, 0)


def test_more_damping_never_lengthens_a_free_stop(kernel):
    stops = [
        march_sines(
            kernel, [], (15.0, 15.0), 60.0, plant=(75.0, 7500.0, b), start=(0.05, 0.3)
        ).t[-1]
        for b in (0.0, 5.0, 50.0, 500.0)
    ]
    assert all(later <= sooner + 1e-12 for sooner, later in pairwise(stops))


@pytest.mark.parametrize(
    ("x_r", "moves"), [(0.00199, False), (0.002, False), (0.0020001, True)]
)
def test_start_inside_on_and_outside_the_stuck_zone(kernel, x_r, moves):
    found = march_sines(kernel, [], (15.0, 15.0), 2.0, start=(x_r, 0.0))
    assert (found.mode != 0) == moves
    assert (found.end[1] != x_r) == moves


def test_force_that_just_reaches_the_limit_never_moves_the_mass(kernel):
    # F_fs = m A to the last bit: equality sticks.
    for phase in (0.0, 0.3, math.pi / 2):
        found = march_sines(kernel, [(0.6, 1.3, phase)], (45.0, 45.0), 50.0)
        assert len(found.t) == 0
    assert len(march_sines(kernel, [(0.6 * (1 + 1e-13), 1.3, 0.0)], (45.0, 45.0), 50.0).t) > 0


def test_mirrored_sines_give_the_mirrored_answer_bit_for_bit(kernel):
    one = march_sines(kernel, PAIR, (30.0, 36.0), 20.0)
    other = march_sines(kernel, [(-A, f, phase) for A, f, phase in PAIR], (30.0, 36.0), 20.0)
    assert np.array_equal(one.t, other.t)
    assert np.array_equal(one.x, -other.x)


def test_finely_sampled_sine_comes_close_to_the_sine_at_second_order(kernel):
    A, f, phase = 1.2, 2.0, 0.3
    exact = march_sines(kernel, [(A, f, phase)], (30.0, 36.0), 4.0)
    errors = []
    for dt in (2e-3, 1e-3):
        t = np.arange(round(4.0 / dt) + 1) * dt
        found = march(kernel, A * np.sin(2 * math.pi * f * t + phase), dt, (30.0, 36.0))
        assert len(found.t) == len(exact.t)
        errors.append(np.abs(found.t - exact.t)[3:].max())
    assert errors[0] < 1e-5
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_resonance_without_damping_grows_as_the_formula_says(kernel):
    # x" + ω² x = -A sin(ω t): x = A (t cos(ω t)/(2ω) - sin(ω t)/(2ω²)).
    omega, A, t = 10.0, 0.7, 40.3
    x = march_sines(
        kernel, [(A, omega / (2 * math.pi), 0.0)], (0.0, 0.0), t, plant=(75.0, 7500.0, 0.0)
    ).end[1]
    want = A * (t * math.cos(omega * t) / (2 * omega) - math.sin(omega * t) / (2 * omega**2))
    assert x == pytest.approx(want, rel=1e-11)


@pytest.mark.parametrize(
    ("phi", "grows"), [(math.pi / 4 - 0.02, True), (math.pi / 4 + 0.02, False)]
)
def test_coulomb_friction_bounds_resonance_above_a_quarter_of_pi_only(kernel, phi, grows):
    A, omega = 1.0, 10.0
    F = phi * 75.0 * A
    found = march_sines(
        kernel, [(A, omega / (2 * math.pi), 0.0)], (F, F), 200.0, plant=(75.0, 7500.0, 0.0)
    )
    x = np.abs(found.x)
    assert (x[-20:].max() > 1.5 * x[len(x) // 2 - 10 : len(x) // 2].max()) == grows


@pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-7, 5.0])
@pytest.mark.parametrize(
    "plant", [PAPER, (75.0, 0.0, 0.0), (75.0, 0.0, 90.0), (75.0, 7500.0, 75000.0)]
)
def test_events_follow_each_other_by_the_rules(kernel, ratio, plant):
    found = march_sines(kernel, PAIR, (20.0, 20.0 * ratio), 10.0, plant=plant)
    mode = found.mode
    assert (np.diff(found.t) >= 0).all()
    for kind in found.kind.tolist():
        if abs(kind) == 1:
            assert mode == 0
        else:
            assert mode != 0
            assert kind == 0 or np.sign(kind) == -mode
        mode = int(np.sign(kind))


def test_solution_restarted_at_any_time_goes_on_as_before(kernel):
    plant, law = kernel.model.Plant(*PAPER), kernel.model.CoulombLaw(30.0, 36.0)
    whole = march_sines(kernel, PAIR, (30.0, 36.0), 10.0)
    core, events = kernel.march, []
    state = core.SlipState(0, 0.0, 0.0, 0.0, whole.mode, math.nan, 0, math.inf)
    for end in (0.3, 3.1, 3.1000001, 10.0):
        log = log_of(kernel)
        interval, waves = core.Interval(0, 0.0, end, 0.0, 0.0), waves_of(kernel, PAIR, law)
        state = core.march_sines(plant, law, waves, interval, state, log)
        events += log.s[: state.events].tolist()
        state = state._replace(events=0)
    assert len(events) == len(whole.t)
    assert np.abs(np.array(events) - whole.t).max() < 1e-11
    assert state.x_r == pytest.approx(whole.end[1], abs=1e-13)


def test_varying_limits_over_samples_equal_those_under_sines(kernel):
    # A base at rest, sampled or not, under limits that vary: both roads lead to one answer.
    plant, law = kernel.model.Plant(*PAPER), kernel.model.CoulombLaw(30.0, 40.0, 0.5, 20.0, 0.3)
    whole = march_sines(kernel, [], tuple(law), 2.0, start=(0.05, 0.2))
    n = 401
    columns = [np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64)]
    log = log_of(kernel)
    core, waves = kernel.march, waves_of(kernel, [], law)
    scene = kernel.forcing.Scene(plant, law, waves, np.zeros(n), 5e-3)
    state = core.SlipState(0, 0.0, 0.05, 0.2, 1, math.nan, 0, math.inf)
    state = core.march_varying_limits(scene, 0, n - 1, state, tuple(columns), log)
    t = log.n[: state.events] * 5e-3 + log.s[: state.events]
    assert len(t) == len(whole.t)
    assert np.abs(t - whole.t).max() < 1e-12
    assert state.x_r == pytest.approx(whole.end[1], abs=1e-14)


def test_block_without_spring_and_damper_breaks_away_under_a_ramp(kernel):
    # Nothing bounds the third rate of its motion: it is zero.
    plant, law = kernel.model.Plant(2.0, 0.0, 0.0), kernel.model.CoulombLaw(1.0, 1.0)
    log = log_of(kernel)
    core, waves = kernel.march, waves_of(kernel, [], law)
    interval = core.Interval(0, 0.0, 2.0, 0.0, 1.0)
    state = core.SlipState(0, 0.0, 0.0, 0.0, 0, math.nan, 0, math.inf)
    out = core.march_sines(plant, law, waves, interval, state, log)
    assert out.events == 1
    assert log.s[0] == pytest.approx(0.5, rel=1e-14)
    assert out.x_r == pytest.approx(-(1.5**3) / 6, rel=1e-13)


def test_limit_that_falls_to_the_very_force_of_the_spring_holds_at_any_scale(kernel):
    found = []
    for scale in (1.0, 2.0**-40, 2.0**40):
        plant = kernel.model.Plant(scale, scale, 0.0)
        law = kernel.model.CoulombLaw(scale, scale, 0.5, 3.0)
        waves = waves_of(kernel, [], law)
        kernel.forcing.set_phases(waves, plant, law, 0.0, 0)
        at = [0.99, *(0.5 + n * 2.0**-53 for n in range(24))]
        limit, swing = (law.F_fs, 0.0), (law.variation, law.omega)
        found.append([])
        for x_r in at:
            stuck = kernel.roots.Stuck(scale, scale * x_r, 0.0, limit, limit, *swing)
            found[-1].append(kernel.roots.stick_exit_time(stuck, waves, 1, 0.0, 9.0)[0])
    assert found[0] == found[1] == found[2]
    assert found[0][0] == pytest.approx((math.pi + math.asin(0.02)) / 3.0, rel=1e-9)
    assert found[0][1] == math.inf
    assert found[0][-1] == pytest.approx(0.5 * math.pi, abs=1e-6)


def test_strong_damper_does_not_make_steps_tiny(plain, monkeypatch):
    """It leaves a jerk next to nothing, which proves next to nothing: a million steps."""
    steps = []

    def counted(*stretch):
        steps.append(stretch[-1])
        return motion_at(*stretch)

    motion_at = plain.forcing.motion_at
    monkeypatch.setattr(plain.roots, "motion_at", counted)
    plant, law = plain.model.Plant(0.04, 7500.0, 1e8), plain.model.CoulombLaw(5.0, 5.0)
    waves, log = waves_of(plain, [(1.0, 0.33, 0.0)], law), log_of(plain)
    interval = plain.march.Interval(0, 0.0, 1 / 0.33, 0.0, 0.0)
    start = plain.march.SlipState(0, 0.0, 0.038, 0.0, -1, math.nan, 0, math.inf)
    out = plain.march.march_sines(plant, law, waves, interval, start, log)
    assert out.events == 0
    assert len(steps) < 200
    slow = 7500.0 / 1e8
    assert out.x_r == pytest.approx(
        5 / 7500 + (0.038 - 5 / 7500) * math.exp(-slow / 0.33), rel=1e-8
    )


@pytest.mark.parametrize("side", [1, -1])
def test_side_that_never_breaks_away_is_not_followed_to_the_end_each_time(
    plain, monkeypatch, side
):
    """It creeps one way under two sines: work grows with the time, not with its square."""
    looks = []

    def counted(*given):
        looks.append(given[-1])
        return break_away_margin(*given)

    break_away_margin = plain.roots.break_away_margin
    monkeypatch.setattr(plain.roots, "break_away_margin", counted)
    sines = [(side * 1.0, 1.0, 0.0), (side * 0.9, 2.0, 0.7)]
    found = march_sines(plain, sines, (1.5, 1.5), 200.0, plant=(1.0, 0.0, 1.0))
    assert 390 < len(found.t) < 410
    assert len(looks) < 100 * len(found.t)


@pytest.mark.parametrize("bend", [1e-12, 1e-6, 1.0, 1e3])
@pytest.mark.parametrize("growth", [1e-12, 1e-3, 1.0, 1e6])
def test_safe_step_takes_a_good_part_of_what_its_bound_allows(kernel, bend, growth):
    # A wave of 1e-6 Hz drags the mass along for days: steps of half a second had each been
    # proven, where the bound allows thousands.
    v, a, j, snap, cap = 1.0, -bend, -bend, 1e-3 * growth, 1e9
    step = kernel.roots.safe_step(v, a, j, snap, growth, cap)

    def lowest(h: float) -> float:
        return v + a * h + j * h**2 / 2 - snap * h**3 / 6 - growth * h**4 / 24

    assert lowest(step) >= -1e-15
    assert lowest(2.5 * step) < 0.0


def test_wave_of_days_is_solved_in_few_steps(fast):
    # The mass is dragged to where its spring balances its inertia and friction.
    period = 1e9
    found = march_sines(fast, [(2.0, 1 / period, 0.0)], (45.0, 45.0), 2.4 * period, plant=PAPER)
    reached = found.x[np.abs(found.x) > 1e-4]
    m, k_x, _ = PAPER
    assert np.abs(reached[1:]) == pytest.approx((2.0 * m - 45.0) / k_x, rel=1e-6)


# The march between end stops: both engines, the code of its modes, rest after a chatter.


N, DT = 300, 5e-3
U_DD = 2.0 * np.convolve(np.random.default_rng(4).standard_normal(N), np.ones(8), "same")
LAWS = {
    "bumper": (45.0, 54.0, 0.004, 2e5, 300.0, 0.0),
    "dead bumper": (20.0, 20.0, 0.002, 5e4, 8e3, 0.0),
    "rigid": (45.0, 54.0, 0.004, 0.0, 0.0, 0.6),
}


def follow(kernel, law, plant=(75.0, 7500.0, 300.0), u_dd=U_DD, start=(0.0, 0.05)):
    """March from sample to sample; return numbers of segments and events, and all columns."""
    plant, law = kernel.model.Plant(*plant), stop_law(kernel, law, plant[2])
    waves = kernel.forcing.Waves(np.zeros(0), 0, 0)
    slope = (u_dd[1] - u_dd[0]) / DT
    base = kernel.modes.SegmentBase(0.0, u_dd[0], slope)
    (mode, xi, _, x_0), _ = kernel.modes.initial_piecewise_state(
        plant, law, waves, base, *start, start[0]
    )
    scene = kernel.forcing.Scene(plant, law, waves, u_dd, DT)
    state = kernel.march.MarchState(0, 0.0, xi, start[1], math.nan, x_0, mode, 0, 0, math.inf)
    at, count, out = march_modes(kernel, scene, state, 20 * len(u_dd))
    written = [column[:at] for column in out.segments] + [
        column[:count] for column in out.events
    ]
    return at, count, [*written, *out.samples]


def stop_law(kernel, law, b=0.0):
    """Return Coulomb friction between end stops."""
    F_fk, F_fs, *stops = law
    return piecewise(kernel, (F_fk, F_fs), b=b, stops=tuple(stops))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_engines_agree_bit_for_bit(plain, fast, law):
    slow, quick = follow(plain, law), follow(fast, law)
    assert slow[:2] == quick[:2]
    assert slow[1] > 30
    for one, other in zip(slow[2], quick[2], strict=True):
        assert (one == other).all()


def test_mode_is_one_number_from_which_it_is_read_again(kernel):
    core, codes = kernel.modes, set()
    for contact, direction in itertools.product((-1, 0, 1, core.FREE), (-1, 0, 1)):
        for stop, origin in itertools.product(range(-6, 7), (-1, 0, 1)):
            for poised, bumper in itertools.product((-1, 0, 1), range(4)):
                mode = core.Mode(contact, direction, stop, origin, poised, bumper)
                code = core.encode_mode(mode)
                assert tuple(core.decode_mode(code)) == tuple(mode)
                codes.add(code)
    assert len(codes) == 4 * 3 * 13 * 3 * 3 * 4
    assert core.ARRIVAL not in codes


@pytest.mark.parametrize(
    ("x_r", "v_r", "touch"),
    [(0.003, 9.0, 0), (0.004, 1.0, 0), (-0.005, 0.0, -1), (0.005, -1.0, 4), (0.005, 1.0, 1)],
)
def test_place_tells_how_a_mass_is_to_a_bumper(kernel, x_r, v_r, touch):
    F_fk, F_fs, _, *rest = LAWS["dead bumper"]
    law = stop_law(kernel, (F_fk, F_fs, 0.004, *rest))
    origin, xi, found = kernel.modes.end_stop_coordinates(law, x_r, v_r)
    assert kernel.modes.origin_of(law, origin) + xi == x_r
    assert found == touch


@pytest.mark.parametrize("e", [0.2, 0.9, 0.99])
def test_chatter_under_steady_pressure_ends_after_few_impacts(kernel, e):
    """Heights fall by e² from one to the next, from 1 to 2^-54 of the limit."""
    pressed = np.full(4000, -5.0)
    law = (0.0, 0.0, 0.01, 0.0, 0.0, e)
    *_, written = follow(kernel, law, (1.0, 0.0, 0.0), pressed, (0.01, -0.3))
    kinds = written[8]
    assert kinds[-1] == 0
    fewest = np.log(0.3 / np.sqrt(2 * 5.0 * 0.01 * 2.0**-54)) / -np.log(e)
    assert (kinds == -6).sum() == pytest.approx(fewest, rel=0.02, abs=2)
    assert written[2][-1] == 0.0
    assert written[4][-1] == 0.01


# Elastic contacts over samples: both engines agree to the last bit, also in several calls.


def contact_march(kernel, u_dd, k_t, calls=1):
    """March an elastic contact over samples; return segments, samples and events."""
    plant, law = kernel.model.Plant(*PAPER), piecewise(kernel, (30.0, 30.0), k_t=k_t)
    waves = kernel.forcing.Waves(np.zeros(0), 0, 0)
    base = kernel.modes.SegmentBase(0.0, u_dd[0], 0.0)
    (mode, xi, _, x_0), _ = kernel.modes.initial_piecewise_state(
        plant, law, waves, base, 0.0, 0.0, 0.0
    )
    scene = kernel.forcing.Scene(plant, law, waves, u_dd, DT)
    state = kernel.march.MarchState(0, 0.0, xi, 0.0, math.nan, x_0, mode, 0, 0, math.inf)
    _, count, out = march_modes(kernel, scene, state, 3 * len(u_dd), calls)
    return out.samples, [column[:count] for column in out.events]


@pytest.mark.parametrize("k_t", [1e4, 1e6, 1e8])
def test_engines_march_an_elastic_contact_alike_and_in_several_calls(plain, fast, k_t):
    u_dd = 4.0 * np.random.default_rng(4).standard_normal(800)
    one, events = contact_march(plain, u_dd, k_t)
    for kernel, calls in ((fast, 1), (fast, 7)):
        other, others = contact_march(kernel, u_dd, k_t, calls)
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
        assert all(np.array_equal(a, b) for a, b in zip(events, others, strict=True))
    assert len(events[0]) > 10
