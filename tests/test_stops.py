"""End stops, bumpers and rigid ones: against a state machine, closed forms, invariants."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from contacts import at
from law_scenes import PAPER, REST, STEP, mirrored, noise, sine, solved, stopped_law
from reference import assert_agrees
from seat import fields_of, load_text, rows_of
from stops import march_stops

import drysim
from drysim.approach.stick_slip import StickSlip, Viscous
from drysim.core.model import (
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
)
from drysim.errors import SolverError, UsageError
from drysim.metrics.stroke import impacts
from drysim.metrics.table import measure
from drysim.orbits import search
from drysim.orbits.search import find_orbit
from drysim.plots.response import curve_with_events, stop_impacts
from drysim.scenario.axes import iter_points
from drysim.scenario.text import describe_stops

LIMIT = 0.004
STILL = Sines((), (), ())
NOISE = noise(1200, 4.0, seed=3)
STOPS = {
    "undamped bumper": stopped_law(45.0, 54.0, LIMIT, k_s=2e5),
    "damped bumper": stopped_law(45.0, 54.0, LIMIT, k_s=2e5, b_s=300.0),
    "dead bumper": stopped_law(45.0, 45.0, LIMIT, k_s=5e4, b_s=8e3),
    "rebound": stopped_law(45.0, 54.0, LIMIT, e=0.6),
    "no rebound": stopped_law(45.0, 54.0, LIMIT),
    "no friction": stopped_law(0.0, 0.0, LIMIT, e=0.8),
    "varying": stopped_law(30.0, 36.0, LIMIT, 2e5, 300.0, wave=(0.5, 2 * math.pi * 2.3, 0.4)),
}


def drawn(seed: int) -> tuple[Plant, PiecewiseLaw, State]:
    """Return a scene of either kind of stop, the start inside the stroke or beyond a bumper."""
    draw = np.random.default_rng(seed)
    plant = Plant(75.0, float(draw.choice([0.0, 2e3, 7.5e3])), float(draw.choice([0.0, 400.0])))
    F_fk = float(draw.uniform(0.0, 60.0))
    forces = F_fk, F_fk * float(draw.choice([1.0, 1.3]))
    if seed % 2:
        law = stopped_law(*forces, LIMIT, 2e5, float(draw.choice([0.0, 300.0, 3e3, 8e3])))
    else:
        law = stopped_law(*forces, LIMIT, e=float(draw.choice([0.0, draw.uniform(0.2, 0.9)])))
    reach = 1.5 * LIMIT if seed % 2 else 0.9 * LIMIT
    return plant, law, State(float(draw.uniform(-reach, reach)), float(draw.uniform(-0.3, 0.3)))


def test_a_mass_that_just_reaches_a_stop_counts_at_that_stop():
    # Free swings whose amplitude is the limit to within rounding: some arrive with v_r = 0.
    draw = np.random.default_rng(1)
    for _ in range(100):
        omega, v_0 = draw.uniform(1.0, 30.0), draw.uniform(0.01, 1.0)
        side = draw.choice([-1, 1])
        law = stopped_law(0.0, 0.0, float(np.nextafter(v_0 / omega, 0.0)), e=0.5)
        still, start = Samples(np.zeros(10), math.pi / omega / 10), State(0.0, side * v_0)
        plant = Plant(1.0, omega**2, 0.0)
        trajectory = solved(law, still, start, plant=plant).trajectory
        found = impacts(trajectory, (0.0, trajectory.end), repeats=False)
        assert (found.up, found.down) in ((0, 0), (1, 0) if side > 0 else (0, 1))


@pytest.mark.parametrize("seed", range(8))
def test_sines_agree_with_a_state_machine(seed):
    plant, law, start = drawn(seed)
    A, f, phase = (3.0, 1.0), (1.6, 2.9), (0.3, 1.0)

    def base(t):
        return sum(
            a * math.sin(2 * math.pi * g * t + p) for a, g, p in zip(A, f, phase, strict=True)
        )

    response = StickSlip().solve(plant, law, Sines(A, f, phase), start, 2e-3, 0.8)
    agrees(response, lambda rtol: march_stops(plant, law, base, 0.8, start, rtol=rtol))


@pytest.mark.parametrize("seed", range(8, 14))
def test_samples_agree_with_a_state_machine(seed):
    plant, law, start = drawn(seed)
    dt, u_dd = 0.01, noise(61, 4.0, seed).u_dd
    knots = [n * dt for n in range(61)]

    def base(t):
        return float(np.interp(t, knots, u_dd))

    response = StickSlip().solve(plant, law, Samples(u_dd, dt), start, dt)
    agrees(response, lambda rtol: march_stops(plant, law, base, 0.6, start, knots, rtol))


def agrees(response, march):
    """Compare x_r, v_r, and every hit that is more than a chatter's last."""

    def known(rtol):
        pieces, hits = march(rtol)
        hits = np.array([(t, v) for t, v in hits if abs(v) > 1e-6])
        return *at(pieces, response.t[:-1]), *hits.T

    t, v = response.trajectory.hits()
    t, v = t[np.abs(v) > 1e-6], v[np.abs(v) > 1e-6]
    own = 1e-12, 1e-10, 1e-11, 1e-6 * np.abs(v)
    assert_agrees([response.x_r[:-1], response.v_r[:-1], t, v], known, own)


@pytest.mark.parametrize("law", STOPS.values(), ids=STOPS)
@pytest.mark.parametrize("motion", [sine(2.5, 1.6), NOISE], ids=["sine", "noise"])
class TestInvariants:
    def test_energy_closes(self, law, motion):
        metrics = measure(
            solved(law, motion, duration=2.9).trajectory, (0.7, 2.9), StrokeLimits(LIMIT, LIMIT)
        )
        assert metrics["energy_residual"] < 1e-13
        assert metrics["contacts"] > 1
        assert metrics["energy_stops"] > -1e-12

    def test_mirrored_base_motion_gives_the_mirrored_response_bit_for_bit(self, law, motion):
        one, two = (solved(law, each, duration=2.0) for each in (motion, mirrored(motion)))
        assert (one.x_r == -two.x_r).all()
        assert (one.F_stop == -two.F_stop).all()

    def test_stops_push_and_never_pull(self, law, motion):
        response = solved(law, motion, duration=2.9)
        assert (response.F_stop * response.x_r >= 0.0).all()
        within = np.abs(response.x_r) < LIMIT
        assert (response.F_stop[within] == 0.0).all()
        if law.stops.rigid:
            assert np.abs(response.x_r).max() <= LIMIT

    def test_friction_holds_and_rubs_as_ever(self, law, motion):
        response = solved(law, motion, duration=2.9)
        load = 1.0 + law.variation * np.sin(law.omega * response.t + law.phase)
        stuck = response.stuck
        assert (response.v_r[stuck] == 0.0).all()
        assert (np.abs(response.F_f) <= law.F_fs * load * (1 + 1e-9) + 1e-12).all()
        assert (response.F_f * response.v_r >= 0.0).all()
        assert (response.x_dd[stuck] == response.u_dd[stuck]).all()

    def test_acceleration_is_what_the_forces_give(self, law, motion):
        response = solved(law, motion, duration=2.9)
        m, k_x, b = PAPER
        pull = k_x * response.x_r + b * response.v_r + response.F_f + response.F_stop
        assert np.abs(m * response.x_dd + pull).max() < 1e-11 * np.abs(pull).max()

    def test_split_run_equals_the_whole(self, law, motion):
        if isinstance(motion, Sines) or law.variation:
            pytest.skip("only samples begin anew at any of them")
        whole = solved(law, motion)
        rest = Samples(motion.u_dd[400:], motion.dt)
        part = solved(law, rest, start=whole.trajectory.state(400 * STEP))
        assert np.abs(part.x_r - whole.x_r[400:]).max() < 1e-12


def test_stops_beyond_reach_leave_every_bit_of_a_motion_under_sines_as_it_is():
    motion = sine(2.5, 1.6)
    bare = solved(CoulombLaw(45.0, 54.0), motion, duration=2.9)
    law = stopped_law(45.0, 54.0, 1.01 * float(np.abs(bare.x_r).max()), e=0.5)
    far = solved(law, motion, duration=2.9)
    assert (far.x_r == bare.x_r).all()
    assert (far.x_dd == bare.x_dd).all()
    assert far.numerics.core == bare.numerics.core
    assert "never reached" in far.numerics.why
    assert not far.F_stop.any()
    assert measure(far.trajectory, (0.0, 2.9), far.law.stops.limits)["contacts"] == 0


@pytest.mark.parametrize("law", [{"e": 0.5}, {"k_s": 3e4, "b_s": 40.0}], ids=["rigid", "soft"])
def test_stops_beyond_reach_change_a_motion_over_samples_by_rounding_only(law):
    bare = solved(CoulombLaw(45.0, 54.0), NOISE)
    peak = float(np.abs(bare.x_r).max())
    far = solved(stopped_law(45.0, 54.0, 1.01 * peak, **law), NOISE)
    assert np.abs(far.x_r - bare.x_r).max() < 1e-14 * peak
    assert np.abs(far.x_dd - bare.x_dd).max() < 1e-12 * float(np.abs(bare.x_dd).max())
    assert (far.events.kind == bare.events.kind).all()
    assert np.abs(far.events.t - bare.events.t).max() < 1e-11
    assert not far.F_stop.any()
    assert measure(far.trajectory, (0.0, 2.9), far.law.stops.limits)["contacts"] == 0


def test_orbit_that_never_reaches_its_stops_is_the_orbit_without_them():
    scene = sine(1.0, 1.6), REST, 1 / 1.6
    bare = find_orbit(PAPER, CoulombLaw(45.0, 54.0), *scene)
    assert find_orbit(PAPER, stopped_law(45.0, 54.0, 0.5, e=0.5), *scene) == bare


@pytest.mark.parametrize("name", ["damped bumper", "undamped bumper", "rebound", "no rebound"])
def test_orbit_between_stops_closes(name):
    motion, period = sine(2.5, 1.6), 1 / 1.6
    orbit = find_orbit(PAPER, STOPS[name], motion, REST, period)
    assert orbit.settled
    length = orbit.periods * period
    trajectory = StickSlip().trajectory(PAPER, STOPS[name], motion, orbit.state, length)
    end = trajectory.state(length)
    assert end.x_r == pytest.approx(orbit.state.x_r, abs=1e-13)
    assert end.v_r == pytest.approx(orbit.state.v_r, abs=1e-11)
    assert len(trajectory.hits().t) >= 2 * orbit.periods


def test_mass_that_bounces_without_loss_is_on_one_orbit_of_a_continuum():
    """There and back in a period; a little faster, it is back a little sooner for ever."""
    free, elastic = Plant(75.0, 0.0, 0.0), stopped_law(0.0, 0.0, 0.01, e=1.0)
    orbit = search.find_orbit(free, elastic, sine(0.0, 1.0), State(0.0, 0.04), 1.0)
    assert orbit.settled
    assert not orbit.unique


def test_orbit_of_lossy_rebounds_without_a_damper_draws_its_neighbours():
    undamped = Plant(75.0, 7500.0, 0.0)
    orbit = find_orbit(undamped, STOPS["rebound"], sine(2.5, 1.3), REST, 1 / 1.3)
    assert orbit.settled
    assert orbit.unique


class TestClosedForms:
    def test_free_mass_between_two_rigid_stops_conserves_its_energy(self):
        """1e5 impacts of a mass that nothing but the stops acts on."""
        law, v = stopped_law(0.0, 0.0, 0.01, e=1.0), 1.0
        trajectory = StickSlip().trajectory(
            Plant(1.0, 0.0, 0.0), law, STILL, State(0.0, v), 0.02 * 100_000 - 0.005
        )
        t, v_r = trajectory.hits()
        assert len(t) == 100_000
        assert (np.abs(v_r) == 1.0).all()
        assert t == pytest.approx(0.01 + 0.02 * np.arange(len(t)), rel=1e-11)

    def test_sprung_mass_between_rigid_stops_conserves_its_energy(self):
        plant, law = Plant(1.0, 100.0, 0.0), stopped_law(0.0, 0.0, 0.01, e=1.0)
        trajectory = StickSlip().trajectory(plant, law, STILL, State(0.003, 0.4), 5_500.0)
        held = 100.0 * 0.003**2 + 0.4**2
        _, v_r = trajectory.hits()
        assert len(v_r) > 100_000
        assert np.abs(np.square(v_r) + 100.0 * 0.01**2 - held).max() < 1e-10 * held

    def test_ball_comes_to_rest_when_the_series_of_its_bounces_ends(self):
        """Thrown up from the stop by v against a steady pull g: 2 v/(g (1 - e)) in all."""
        g, v, e = 2.0, 0.3, 0.6
        law = stopped_law(0.0, 0.0, 0.1, e=e)
        pull = Samples(np.full(200, -g), 0.01)
        trajectory = StickSlip().trajectory(
            Plant(3.0, 0.0, 0.0), law, pull, State(0.1, -v), None
        )
        t, v_r = trajectory.hits()
        flights = 2 * v / g * e ** np.arange(len(t))
        assert t == pytest.approx(np.cumsum(flights), abs=1e-14)
        assert v_r == pytest.approx(v * e ** np.arange(len(t)), rel=1e-9)
        rests = trajectory.events.t[trajectory.events.kind == 0]
        assert rests == pytest.approx([2 * v / (g * (1 - e))], abs=1e-13)
        assert 20 < len(t) < 60
        assert trajectory.state(1.0) == State(0.1, 0.0)
        assert trajectory.totals(0.0, 1.99).stop_work == pytest.approx(
            0.5 * 3.0 * v**2, rel=1e-14
        )

    @pytest.mark.parametrize(("limit", "F"), [(0.05, 0.0), (0.05, 0.3), (500.0, 0.3)])
    def test_rebounds_too_small_to_be_seen_are_flight_and_not_rest(self, limit, F):
        """Times and x"² of the whole chatter are a geometric series; then the mass is stuck."""
        e, end, pull = 0.9, 400.0, Samples(np.full(401, 1.0), 1.0)
        law = stopped_law(F, F, limit, e=e)
        trajectory = StickSlip().trajectory(Plant(1.0, 0.0, 0.0), law, pull, REST, None)
        q, p = 1.0 - F, 1.0 + F
        first = math.sqrt(2.0 * q * limit)
        flight = e * first * (1.0 / p + 1.0 / math.sqrt(p * q))
        rest = first / q + flight / (1.0 - e * math.sqrt(q / p))
        totals = trajectory.totals(0.0, end)
        assert trajectory.events.t[-1] == pytest.approx(rest, rel=1e-14)
        assert totals.stuck == pytest.approx(end - rest, rel=1e-14)
        assert totals.x_dd2 == pytest.approx(F * F * rest + end - rest, rel=1e-13)

    def test_rest_of_a_chatter_may_be_longer_than_a_step(self):
        g, v, e, limit = 1.0, 2e-3, 0.999, 1e6
        pull = Samples(np.full(501, -g), 0.01)
        law = stopped_law(0.0, 0.0, limit, e=e)
        trajectory = StickSlip().trajectory(
            Plant(1.0, 0.0, 0.0), law, pull, State(limit, -v), None
        )
        rest = 2.0 * v / (g * (1.0 - e))
        assert trajectory.hits().t[-1] < rest - 0.02
        assert trajectory.events.t[-1] == pytest.approx(rest, rel=1e-12)
        assert trajectory.totals(0.0, 5.0).stuck == pytest.approx(5.0 - rest, rel=1e-12)
        assert trajectory.state(rest - 0.005) == State(limit, 0.0)

    def test_mass_at_rest_leaves_its_stop_as_the_force_turns(self):
        """Pressed, then pulled away: it leaves as |F_L| exceeds F_fs on that side."""
        u_dd = np.interp(np.arange(201) * 0.01, [0.0, 1.0, 2.0], [-3.0, 0.0, 3.0])
        law = stopped_law(30.0, 60.0, 0.1, e=0.4)
        trajectory = StickSlip().trajectory(
            Plant(75.0, 0.0, 100.0), law, Samples(u_dd, 0.01), State(0.1, 0.0)
        )
        leaves = trajectory.events.t[trajectory.events.kind == -1]
        assert leaves == pytest.approx([1.0 + 60.0 / 75.0 / 3.0], rel=1e-14)
        pressed = trajectory.at(np.array([0.2]))
        assert pressed.F_stop == pytest.approx(75.0 * 2.4 - 60.0)
        assert pressed.F_f == pytest.approx(60.0)

    def test_bumper_catches_a_mass_for_half_a_swing(self):
        plant, law = Plant(2.0, 0.0, 0.0), stopped_law(0.0, 0.0, 0.01, k_s=5e3)
        trajectory = StickSlip().trajectory(plant, law, STILL, State(0.0, 0.5), 0.2)
        omega = 50.0
        metrics = measure(trajectory, (0.0, 0.1), StrokeLimits(0.01, 0.01))
        assert metrics["stop_force_peak"] == pytest.approx(5e3 * 0.5 / omega, rel=1e-13)
        assert metrics["contacts"] == 1
        ends = trajectory.events.t[trajectory.events.kind == -5]
        assert ends[0] == pytest.approx(0.02 + math.pi / omega, rel=1e-13)

    def test_damped_bumper_gives_the_restitution_of_its_closed_form(self):
        m, k_s, b_s, v = 2.0, 5e3, 40.0, 0.5
        law = stopped_law(0.0, 0.0, 0.01, k_s=k_s, b_s=b_s)
        trajectory = StickSlip().trajectory(Plant(m, 0.0, 0.0), law, STILL, State(0.01, v), 0.2)
        omega, xi = math.sqrt(k_s / m), b_s / (2 * math.sqrt(k_s * m))
        q = math.sqrt(1 - xi**2)
        ends = release_angle(xi) / (omega * q)
        released = trajectory.events.t[trajectory.events.kind == -5][0]
        assert released == pytest.approx(ends, rel=1e-12)
        after = -v * restitution_of(xi)
        assert trajectory.state(ends + 1e-4).v_r == pytest.approx(after, rel=1e-12)


def release_angle(xi: float) -> float:
    """Return ω_d t as k_s x + b_s v_r is zero: tan ω_d t = 2 ξ q/(2 ξ² - 1)."""
    return math.atan2(2 * xi * math.sqrt(1 - xi**2), 2 * xi**2 - 1) % math.pi


def restitution_of(xi: float) -> float:
    """Return the restitution of a bumper of damping ratio xi that does not pull."""
    q, angle = math.sqrt(1 - xi**2), release_angle(xi)
    return -math.exp(-xi / q * angle) * (math.cos(angle) - xi / q * math.sin(angle))


def test_stiff_bumpers_come_to_restitution_as_one_over_the_root_of_their_stiffness():
    xi, motion = 0.3, sine(2.5, 1.6)
    rigid = stopped_law(20.0, 20.0, LIMIT, e=restitution_of(xi))
    exact = solved(rigid, motion, duration=0.5).x_r
    errors = []
    for k_s in (1e9, 1e11, 1e13):
        law = stopped_law(20.0, 20.0, LIMIT, k_s, 2 * xi * math.sqrt(k_s * PAPER.m))
        errors.append(np.abs(solved(law, motion, duration=0.5).x_r - exact).max())
    assert errors[2] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.1)


class TestStarts:
    @pytest.mark.parametrize("side", [1, -1])
    def test_on_a_rigid_stop_and_moving_out_the_mass_is_thrown_back_at_once(self, side):
        law = stopped_law(0.0, 0.0, LIMIT, e=0.5)
        start = State(side * LIMIT, side * 0.2)
        trajectory = StickSlip().trajectory(PAPER, law, STILL, start, 0.02)
        assert trajectory.state(0.0) == State(side * LIMIT, -side * 0.1)
        assert measure(trajectory, (0.0, 0.02), StrokeLimits(LIMIT, LIMIT))["contacts"] == 1

    def test_on_a_rigid_stop_at_rest_the_spring_pulls_the_mass_away(self):
        law = stopped_law(10.0, 10.0, LIMIT, e=0.5)
        response = solved(law, STILL, State(LIMIT, 0.0), 1.0)
        free = solved(CoulombLaw(10.0, 10.0), STILL, State(LIMIT, 0.0), 1.0)
        assert np.abs(response.x_r - free.x_r).max() < 1e-16

    @pytest.mark.parametrize("v_r", [0.5, 0.0, -0.05, -2.0])
    def test_beyond_a_bumper_the_mass_is_pressed_or_apart_as_its_speed_says(self, v_r):
        law = STOPS["dead bumper"]
        response = solved(law, STILL, State(1.5 * LIMIT, v_r), 0.1)
        push = law.stops.stages[0][1] * 0.5 * LIMIT + law.stops.b_s * v_r
        assert response.F_stop[0] == pytest.approx(max(push, 0.0), rel=1e-12)

    def test_bumper_is_felt_again_where_the_mass_slows_down_beyond_the_limit(self):
        """A dead bumper, and friction that brakes harder than the bumper relaxes."""
        law = stopped_law(3000.0, 3000.0, LIMIT, k_s=5e4, b_s=8e3)
        response = solved(law, STILL, State(3 * LIMIT, -0.3), 0.1)
        assert response.events.names[:2] == ["slip-", "contact-"]

        def known(rtol):
            pieces, _ = march_stops(
                PAPER, law, lambda t: 0.0, 0.1, (3 * LIMIT, -0.3), rtol=rtol
            )
            return at(pieces, response.t[:-1])[:1]

        assert_agrees([response.x_r[:-1]], known, [1e-12])


def test_without_friction_turning_points_are_no_events():
    response = Viscous().solve(PAPER, STOPS["damped bumper"], sine(2.5, 1.6), REST, STEP, 2.0)
    assert response.numerics.approach == "viscous"
    assert not response.F_f.any()
    assert {name[:-1] for name in response.events.names[1:]} == {"contact", "release"}


def test_elastic_chatter_without_end_is_an_error_that_names_its_time(monkeypatch):
    """Pressed for long and braked by nothing but the damper, it hits the stop ever faster."""
    from drysim.approach import progress

    monkeypatch.setattr(progress, "MAX_EVENTS", 2_000)
    law = stopped_law(0.0, 0.0, 0.01, e=1.0)
    pressed = Samples(np.full(101, -5.0), 1.0)
    with pytest.raises(SolverError, match="too many events: "):
        StickSlip().trajectory(Plant(1.0, 0.0, 1.0), law, pressed, State(0.01, -0.1))


SEAT = {**PAPER._asdict(), "u_dd": NOISE.u_dd, "dt": STEP}


class TestSimulate:
    def test_arrays_in_give_the_motion_between_stops(self):
        response = drysim.simulate(**SEAT, F_fk=45.0, F_fs=54.0, x_rM=LIMIT, e=0.6)
        assert (response.x_r == solved(STOPS["rebound"], NOISE).x_r).all()
        bumper = drysim.simulate(**SEAT, x_rM=LIMIT, k_s=2e5, b_s=300.0)
        assert bumper.F_stop.max() > 0.0
        assert not bumper.F_f.any()

    @pytest.mark.parametrize(
        ("words", "sentence"),
        [
            ({"x_rM": 0.01}, "either k_s"),
            ({"k_s": 1e5}, "either k_s"),
            ({"x_rM": 0.01, "k_s": 1e5, "e": 0.5}, "either k_s"),
            ({"x_rM": 0.0, "e": 0.5}, "x_rM must be"),
            ({"x_rM": 0.01, "k_s": 0.0}, "k_s must be"),
            ({"x_rM": 0.01, "k_s": math.nan}, "k_s must be"),
            ({"x_rM": 0.01, "k_s": 1e5, "b_s": -1.0}, "b_s must be"),
            ({"x_rM": 0.01, "e": 0.5, "b_s": 1.0}, "b_s must be"),
            ({"x_rM": 0.01, "e": 1.5}, "e must lie"),
            ({"x_rM": 1e150, "e": 0.5}, "x_rM must lie between 1e-30 and 1e\\+30"),
            ({"x_rM": 0.01, "k_s": 1e-31}, "k_s must lie between"),
            ({"x_rM": 0.01, "k_s": 1e5, "b_s": 1e31}, "b_s must lie between"),
            ({"x_rM": 0.01, "e": 0.5, "u_dd": [0.0, -1e156]}, r"u_dd\[1\] must be at most"),
            ({"x_rM": "10 mm", "e": 0.5}, "x_rM must be a number in SI, not '10 mm'"),
            ({"x_rM": 0.01, "e": 0.5, "x_r": 0.02}, "beyond the rigid stops"),
            ({"x_rM": 0.01, "e": 0.5, "approach": "signum"}, "does not model end stops"),
        ],
    )
    def test_stops_that_make_no_sense_are_told(self, words, sentence):
        with pytest.raises(UsageError, match=sentence):
            drysim.simulate(**{**SEAT, **words})


def test_force_that_only_touches_zero_on_a_sample_does_not_pull_the_mass_away():
    """A record of few levels presses the mass to its stop, lets go and presses, on samples."""
    levels = np.random.default_rng(7).integers(-2, 3, 2000) * 2.0
    law, dt = stopped_law(0.0, 0.0, 0.002, e=0.3), 0.004544964648018394
    trajectory = StickSlip().trajectory(Plant(1.0, 0.0, 0.5), law, Samples(levels, dt), REST)
    assert len(trajectory.events) > 100
    assert (np.diff(trajectory.events.t) >= 0.0).all()
    assert (trajectory.hits().v_r != 0.0).all()


# End stops from the scenario to its files: words, columns, metrics, warnings, comparisons.


SCENARIO_SEAT = """\
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 150}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
stroke: {limit: 15 mm, stops: STOPS}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.5}
solver: {step: 2.5e-3}
"""
BUMPERS = "{stiffness: 2e5, damping: 300}"
RIGID = "{restitution: 0.4}"


def loaded(folder, stops, *overrides):
    """Return the seat between some stops, from a file."""
    return load_text(folder, SCENARIO_SEAT.replace("STOPS", stops), overrides)


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_stops_go_with_surfaces_that_lift_off_and_with_elastic_contacts(tmp_path, stops):
    words = "{law: coulomb, mu_kinetic: 0.1, normal: 400 N, normal_variation: VARIED}"
    varied = "{amplitude: %s, frequency: 3 Hz}"
    pressed = loaded(tmp_path, stops, "friction=" + words.replace("VARIED", varied % 0.9))
    assert pressed.law().stops is not None
    lifted = loaded(tmp_path, stops, "friction=" + words.replace("VARIED", varied % 1.3))
    assert lifted.law().may_separate
    jenkins = "{law: jenkins, kinetic: 30, tangential_stiffness: 1e5}"
    for scenario in (lifted, loaded(tmp_path, stops, f"friction={jenkins}")):
        metrics = drysim.run(scenario).metrics
        assert metrics["contacts"] is not None
        assert metrics["energy_residual"] < 1e-11


def test_stages_of_a_bumper_are_read_described_and_swept(tmp_path):
    stages = "{stages: [{from: 0 mm, stiffness: 20 kN/m}, {from: 5 mm, stiffness: 2e5}]}"
    scenario = loaded(tmp_path, stages)
    assert scenario.law().stops.stages == ((0.0, 2e4), (0.005, 1.8e5))
    assert "20000 N/m, 200000 N/m from 5 mm" in describe_stops(scenario.law())
    swept = loaded(tmp_path, stages, "sweep={stroke.stops.stages.1.from: [2 mm, 4 mm]}")
    begins = [case.law().stops.stages[1][0] for case in map(swept.at, iter_points(swept.sweep))]
    assert begins == [0.002, 0.004]


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_run_tells_its_stops_in_every_file(tmp_path, drysim, stops):
    (tmp_path / "seat.yaml").write_text(SCENARIO_SEAT.replace("STOPS", stops))
    answer = drysim("run", "seat.yaml")
    assert answer.code == 0
    assert "end stops   at ±15 mm" in answer.out
    assert "stops hit   2 times" in answer.out
    assert "the mass hits its end stops" in answer.err
    out = tmp_path / "out/seat"
    told = fields_of(out)
    assert told["numerics"]["core"] == "end-stops"
    assert told["metrics"]["contacts"] == 2
    header, *rows = (out / "response.csv").read_text().splitlines()
    assert header.endswith("stuck [-],F_stop [N]")
    forces = np.array([float(row.rpartition(",")[2]) for row in rows])
    assert (np.abs(forces).max() > 0) == (stops == BUMPERS)
    words = {row.split(",")[1] for row in (out / "events.csv").read_text().splitlines()[1:]}
    own = {"contact+", "contact-", "release+", "release-"}
    assert words >= (own if stops == BUMPERS else {"impact+", "impact-"})
    assert drysim("run", out / "scenario.yaml", "-o", "again").code == 0
    assert fields_of(tmp_path / "again")["metrics"] == told["metrics"]


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
@pytest.mark.parametrize("words", [("run",), ("compare", "signum", "vs", "stick-slip", "-s")])
def test_mass_that_rests_on_its_stop_is_drawn(tmp_path, drysim, stops, words):
    text = SCENARIO_SEAT.replace("STOPS", stops).replace("rms: 1.5", "rms: 1e-3")
    (tmp_path / "seat.yaml").write_text(f"{text}start: {{x_r: 4 mm}}\n")
    answer = drysim(*words, "seat.yaml", "--set", "stroke.limit=4 mm")
    assert answer.code == 0, answer.err


def test_no_hour_goes_beyond_rigid_stops(tmp_path, drysim):
    base = "excitation={kind: standard, class: EM1, duration: 80, seed: 1}"
    (tmp_path / "seat.yaml").write_text(SCENARIO_SEAT.replace("STOPS", RIGID))
    words = ("run", "seat.yaml", "--no-plots", "--set", base)
    near, far = (drysim(*words, "--set", f"stroke.limit={limit} mm") for limit in (15, 500))
    assert "hourly peak 15 mm        limited by the rigid stops\n" in near.out
    assert "reached once an hour, extrapolated from the largest peaks" in far.out
    free = drysim(*words, "--set", "stroke=null", "--json").out
    assert json.loads(free)["metrics"]["stroke_once_an_hour"] > 0.015


def test_scene_without_stops_has_none_of_it(tmp_path, drysim):
    (tmp_path / "seat.yaml").write_text(SCENARIO_SEAT.replace(", stops: STOPS", ""))
    answer = drysim("run", "seat.yaml", "--json")
    told = json.loads(answer.out)
    assert told["numerics"]["core"] == "event-to-event"
    assert told["metrics"]["contacts"] is None
    header = (tmp_path / "out/seat/response.csv").read_text().splitlines()[0]
    assert header.endswith("stuck [-]")


def test_rigid_impacts_are_told_to_stand_in_no_acceleration(tmp_path):
    outcome = drysim.run(loaded(tmp_path, RIGID))
    assert "impacts-left-out" in {warning.slug for warning in outcome.warnings}
    assert outcome.metrics["stop_force_peak"] is None
    speed = outcome.metrics["impact_speed"]
    assert outcome.metrics["impulse_peak"] == pytest.approx(75 * 1.4 * speed, rel=1e-15)


def test_bumper_tells_its_greatest_force(tmp_path):
    outcome = drysim.run(loaded(tmp_path, BUMPERS, "solver.step=1e-5"))
    peak = outcome.metrics["stop_force_peak"]
    assert np.abs(outcome.response.F_stop).max() == pytest.approx(peak, rel=1e-6)
    assert np.abs(outcome.response.F_stop).max() <= peak * (1 + 1e-14)
    assert outcome.metrics["impulse_peak"] is None


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_energies_of_an_orbit_add_up(tmp_path, stops):
    metrics = drysim.run(loaded(tmp_path, stops)).metrics
    lost = sum(metrics[f"energy_{way}"] for way in ("friction", "viscous", "stops"))
    assert metrics["energy_stops"] > 0
    assert metrics["energy_input"] == pytest.approx(lost, rel=1e-9)


def test_sweep_over_the_stops_has_their_columns(tmp_path, drysim):
    loaded(tmp_path, RIGID)
    swept = "sweep={stroke.stops.restitution: [0.2, 0.8]}"
    assert drysim("sweep", "seat.yaml", "--no-plots", "--set", swept).code == 0
    less, more = rows_of(tmp_path / "out/seat/transmissibility.csv")
    assert float(less["energy_stops [J]"]) > float(more["energy_stops [J]"]) > 0


@pytest.mark.parametrize("words", ["{stroke.limit: [10 mm, 15 mm]}", "{stroke.limit: [1 m]}"])
def test_sweep_that_meets_rigid_stops_says_that_T_a_leaves_the_impacts_out(tmp_path, words):
    """An orbit between close rigid stops has a T_a of 0.4 that reads like good isolation."""
    for stops in (RIGID, BUMPERS):
        table = drysim.sweep(loaded(tmp_path, stops, f"sweep={words}"))
        slugs = [warning.slug for warning in table.warnings]
        met = any(row.metrics["contacts"] for row in table)
        assert ("impacts-left-out" in slugs) == (met and stops == RIGID)
        assert met == (words != "{stroke.limit: [1 m]}")


def test_sweep_of_a_start_beyond_rigid_stops_is_a_fault_at_its_value(tmp_path):
    with pytest.raises(drysim.ScenarioError) as fault:
        loaded(tmp_path, RIGID, "sweep={start.x_r: [0, 0.02]}")
    (problem,) = fault.value.problems
    assert "with rigid stops, not 0.02" in problem.sentence


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("signum", "stick-slip"), "signum ignores end stops"),
        (("lugre", "coulomb"), "lugre ignores end stops"),
    ],
)
def test_compare_says_who_knows_no_stops(tmp_path, words, sentence):
    lugre = (
        "friction.lugre={bristle_stiffness: 1e5, bristle_damping: 300, stribeck_velocity: 0.01}"
    )
    scenario = loaded(tmp_path, BUMPERS, "friction.static_ratio=1", lugre)
    found = drysim.compare(scenario, words)
    told = [warning.sentence for warning in found.table.warnings if warning.slug == "left-out"]
    assert any(one.startswith(sentence) for one in told)
    others = "stick-slip", "coulomb", "viscous ignores end"
    assert not any(one.startswith(others) for one in told)
    peaks = {row.approach: row.metrics["x_r_peak"] for row in found.table.rows}
    assert peaks[words[1]] < 0.02 < peaks[words[0]]
    assert peaks["viscous"] < 0.02


def test_seeds_count_their_contacts(tmp_path, drysim):
    noise = "excitation: {kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, seeds: 3}"
    old = "excitation: {kind: harmonic, frequency: 1.6, rms: 1.5}"
    load_text(tmp_path, SCENARIO_SEAT.replace("STOPS", BUMPERS).replace(old, noise))
    answer = drysim("run", "seat.yaml", "--no-plots")
    assert answer.code == 0
    rows = rows_of(tmp_path / "out/seat/ensemble.csv")
    assert all(float(row["contacts [-]"]) > 0 for row in rows)
    names = "impact_speed [m/s]", "stop_force_peak [N]"
    fastest, force = (max(float(row[name]) for row in rows) for name in names)
    assert f"3 of 3 seeds          at up to {fastest:.4g} m/s with seed" in answer.out
    assert f"force up to {force:.4g} N with seed" in " ".join(answer.out.split())
    assert f"end stops for 3 of 3 seeds, at up to {fastest:.4g} m/s for seed" in answer.err
    assert "all 3 seeds: " in answer.out
    assert "90 % of seeds" not in answer.out


def test_speed_that_is_met_while_settling_is_said_to_be(tmp_path):
    times = "measure={settle: 4 s, duration: 4 s}"
    for settle, told in ((times, True), (times.replace("settle: 4 s, ", ""), False)):
        made = drysim.run(loaded(tmp_path, BUMPERS, settle))
        (warning,) = [one for one in made.warnings if one.slug == "stroke-violated"]
        assert warning.sentence.endswith("(settling included)") == told


def test_rigid_stops_of_any_seed_leave_impacts_out(tmp_path):
    noise = "excitation={kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, seeds: 3}"
    made = drysim.run(loaded(tmp_path, RIGID, noise))
    assert [one.slug for one in made.warnings].count("impacts-left-out") == 1


def test_picture_marks_every_hit(tmp_path):
    response = drysim.run(loaded(tmp_path, BUMPERS)).response
    assert [x_r for _, x_r in stop_impacts(response)] == [-0.015, 0.015]
    shown = curve_with_events(response, slice(None))
    assert (np.diff(shown.t) >= 0).all()
    jumps = np.abs(np.diff(shown.x_dd))[np.diff(shown.t) < 1e-12]
    assert jumps.max() > 0.5


@pytest.mark.parametrize(
    ("name", "needs"), [("contacts", "give stroke.stops"), ("stop_force_peak", "end stops")]
)
def test_until_cannot_ask_for_stops_that_are_not_there(tmp_path, name, needs):
    noise = (
        "excitation={kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, "
        f"until: {{metric: {name}, half_width: 5 %}}}}"
    )
    with pytest.raises(drysim.ScenarioError) as fault:
        loaded(tmp_path, BUMPERS, "stroke.stops=null", noise)
    assert needs in fault.value.problems[0].sentence


def test_mass_that_a_squeezed_bumper_drives_is_not_said_to_stay(tmp_path):
    rest = "excitation={kind: rest}", "measure.duration=1", "friction.kinetic=200"
    inside = drysim.run(loaded(tmp_path, BUMPERS, *rest, "start.x_r=14 mm"))
    beyond = drysim.run(loaded(tmp_path, BUMPERS, *rest, "start.x_r=20 mm"))
    slugs = [{warning.slug for warning in made.warnings} for made in (inside, beyond)]
    assert "will-not-move" in slugs[0]
    assert "will-not-move" not in slugs[1]
    assert len(beyond.events) > 1


FORCES = ("oscillator.mass", "oscillator.stiffness", "oscillator.damping", "friction.kinetic")
SHAKEN = """
oscillator: {mass: 64, stiffness: 8192, damping: 256}
friction: {law: LAW, kinetic: 32, CONTACT}
stroke: {limit: 3 mm, stops: {STOPS}}
excitation: {kind: shock, pulse: trapezoid, amplitude: -24, duration: 0.5, rise: 0.05}
measure: {duration: 1 s}
solver: {step: 2.5e-3}
"""


@pytest.mark.parametrize("stops", ["restitution: 0.5", "stiffness: 1e5, damping: 64"])
@pytest.mark.parametrize("law", ["coulomb", "jenkins"])
def test_smaller_unit_of_force_gives_the_same_motion_bit_for_bit(tmp_path, law, stops):
    tiny = 2.0**-24
    contact = "tangential_stiffness: 65536" if law == "jenkins" else "static: 48"
    text = SHAKEN.replace("LAW", law).replace("CONTACT", contact).replace("STOPS", stops)
    heavy = load_text(tmp_path, text)
    keys = [*FORCES, f"friction.{contact.partition(':')[0]}"]
    keys += [f"stroke.stops.{key}" for key in ("stiffness", "damping") if key in stops]
    blocks = heavy.resolved()

    def value(key):
        found = blocks
        for step in key.split("."):
            found = found[step]
        return found

    light = load_text(tmp_path, text, {key: tiny * value(key) for key in keys})
    one, other = (drysim.run(scenario).response for scenario in (heavy, light))
    assert len(one.events) > 10
    assert np.array_equal(one.events.t, other.events.t)
    assert np.array_equal(one.events.kind, other.events.kind)
    assert np.array_equal(one.x_r, other.x_r)
    assert np.array_equal(tiny * one.F_f, other.F_f)


@pytest.mark.parametrize("seed", range(8))
def test_rest_against_a_rigid_stop_is_stuck_under_every_contact(seed):
    """A mass pushed against a stop rests there from the same time on, whatever the contact."""
    draw = np.random.default_rng(seed)
    plant = Plant(5.0, float(draw.choice([0.0, 2e3])), 40.0)
    # Nothing slides back: the push is far above spring and friction.
    side, e = float(draw.choice([-1.0, 1.0])), float(draw.choice([0.0, 0.3]))
    push = Samples(np.full(101, -side * draw.uniform(20.0, 40.0)), 0.01)
    shares = []
    for law in (
        stopped_law(0.0, 0.0, LIMIT, e=e),
        stopped_law(1e-9, 1e-9, LIMIT, e=e),
        stopped_law(1e-9, 1e-9, LIMIT, e=e)._replace(k_t=1e-6),
        stopped_law(1e-9, 1e-9, LIMIT, e=e)._replace(variation=1.5, omega=30.0),
    ):
        response = solved(law, push, plant=plant)
        trajectory = response.trajectory
        share = measure(trajectory, (0.0, trajectory.end), law.stops.limits)["stuck_share"]
        shares.append(share)
        assert response.stuck.mean() == pytest.approx(share, abs=0.02)
    assert min(shares) > 0.8
    assert shares == pytest.approx(shares[:1] * 4, abs=1e-9)
