"""Dynamic laws: against independent solutions, in their limits, and by their invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from invariants import Invariants
from law_scenes import (
    PAPER,
    REST,
    STEP,
    doubled,
    elastic_law,
    halved,
    mirrored,
    noise,
    sine,
    solved,
    sparse,
)
from reference import RTOL, assert_agrees, peak
from scipy.integrate import solve_ivp  # noqa: TID253 - the independent solution
from scipy.optimize import brentq  # noqa: TID253

from drysim.approach import taylor
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    CoulombLaw,
    DynamicLaw,
    Plant,
    Samples,
    Sines,
    State,
)
from drysim.core.taylor import QUASI_STEADY
from drysim.metrics.table import measure
from drysim.orbits.search import find_orbit
from drysim.plots.response import stuck_intervals

DAHL = DynamicLaw(45.0, 45.0, BRISTLE, sigma_0=1e5)
LUGRE = DynamicLaw(45.0, 54.0, BRISTLE, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4)
SMOOTH_STRIBECK = DynamicLaw(15.0, 18.0, STRIBECK, v_s=5e-3)
SHARP_STRIBECK = DynamicLaw(15.0, 24.0, STRIBECK, v_s=2e-2, exponent=1.0)
MEMORY = LUGRE._replace(kind=LEUVEN, F_h=80.0)
LAWS = {
    "dahl": DAHL,
    "lugre": LUGRE,
    "stribeck": SMOOTH_STRIBECK,
    "stribeck-1": SHARP_STRIBECK,
    "stribeck-1.5": SHARP_STRIBECK._replace(exponent=1.5),
}


def bristle_rates(law, plant, base):
    """Return the right-hand side as the paper of the law writes it."""

    def rates(t, state):
        x, v, z = state
        g = law.F_fk + (law.F_fs - law.F_fk) * math.exp(-((v / law.v_s) ** 2))
        z_d = v - law.sigma_0 * abs(v) * z / g
        F = law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v
        return [v, -base(t) - (plant.k_x * x + plant.b * v + F) / plant.m, z_d]

    return rates


@pytest.mark.parametrize("law", [DAHL, LUGRE], ids=["dahl", "lugre"])
def test_bristles_under_a_sine_agree_with_an_integrator_that_knows_no_events(law):
    motion = sine(1.0, 1.6)
    response = solved(law, motion, duration=2.0)
    rates = bristle_rates(law, PAPER, lambda t: motion.A[0] * math.sin(2 * math.pi * 1.6 * t))

    def known(rtol):
        return solve_ivp(
            rates, (0.0, 2.0), [0.0] * 3, "DOP853", response.t, rtol=rtol, atol=1e-3 * rtol
        ).y[:2]

    x_r, v_r = response.x_r, response.v_r
    assert_agrees([x_r, v_r], known, [1e-10 * peak(x_r), 1e-9 * peak(v_r)])
    assert response.numerics.error < 1e-8


@pytest.mark.parametrize("law", [DAHL, LUGRE, MEMORY], ids=["dahl", "lugre", "leuven"])
def test_bristles_at_rest_set_out_to_either_side_alike(law):
    # They had been taken to set out to the right: who went left lost the speed of a sample,
    # and a record that begins with silence came to a stroke four per cent too small.
    u_dd = noise(600, 1.0).u_dd * (np.arange(600) >= 100)
    assert u_dd[100] != 0.0
    right, left = (solved(law, Samples(side * u_dd, STEP)) for side in (1.0, -1.0))
    assert np.array_equal(right.x_r, -left.x_r)
    silent = solved(law, Samples(u_dd[99:], STEP))
    np.testing.assert_allclose(right.x_r[99:], silent.x_r, rtol=0.0, atol=1e-12 * 1e-2)
    assert measure(right.trajectory, (0.0, 599 * STEP), None)["energy_residual"] < 1e-11


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_event_tells_the_direction_of_the_motion_that_follows(law):
    response = solved(law, sine(1.0, 1.6), duration=2.0)
    t, kind = response.events.t, response.events.kind
    assert len(t) > 6
    v_r = response.trajectory.at(0.5 * (t[1:] + t[:-1]))[1]
    assert (np.sign(v_r) == np.sign(kind[:-1])).all()


def test_stuck_mass_is_pushed_as_the_base_moves_however_slowly():
    motion = sine(0.1, 0.02)
    response = solved(SMOOTH_STRIBECK, motion, duration=50.0)
    push = PAPER.m * motion.A[0] * np.sin(2 * math.pi * 0.02 * response.t)
    assert response.stuck.all()
    assert np.abs(response.F_f + push).max() < 1e-14 * np.abs(push).max()


@pytest.mark.parametrize("law", [DAHL, LUGRE], ids=["dahl", "lugre"])
def test_bristles_over_samples_agree_with_an_integrator_restarted_at_each(law):
    motion = noise(200, 1.0)
    response = solved(law, motion)

    def known(rtol):
        state, path = np.zeros(3), [0.0]
        accuracy = {"rtol": rtol, "atol": 1e-4 * rtol}
        for n in range(199):
            u_0, u_1 = motion.u_dd[n : n + 2]
            rates = bristle_rates(law, PAPER, lambda t, a=u_0, b=u_1: a + (b - a) * t / STEP)
            state = solve_ivp(rates, (0.0, STEP), state, "DOP853", **accuracy).y[:, -1]
            path.append(state[0])
        return [path]

    assert_agrees([response.x_r], known, [1e-9 * peak(response.x_r)])


@pytest.mark.parametrize("exponent", [0.75, 1.0, 1.5, 2.0, 3.0, 7.0])
@pytest.mark.parametrize(("a_u", "f"), [(1.0, 1.6), (0.5, 0.7)])
def test_stribeck_agrees_with_an_integrator_restarted_at_its_events(exponent, a_u, f):
    motion, law = sine(a_u, f), SHARP_STRIBECK._replace(exponent=exponent)
    response = solved(law, motion, duration=6.0)
    m, k_x, b = PAPER
    events = response.events
    slides = [
        (np.sign(events.kind[i]), events.x_r[i], (events.t[i], end))
        for i, end in enumerate([*events.t[1:], 6.0])
        if events.kind[i] != 0
    ]

    def known(rtol):
        paths = []
        for d, x, span in slides:

            def rates(t, state, d=d):
                F = law.F_fk + (law.F_fs - law.F_fk) * math.exp(
                    -((abs(state[1]) / law.v_s) ** law.exponent)
                )
                u_dd = motion.A[0] * math.sin(2 * math.pi * f * t)
                return [state[1], -u_dd - (k_x * state[0] + b * state[1] + d * F) / m]

            t = [sum(span) / 2.0, span[1]]
            found = solve_ivp(rates, span, [x, 0.0], "DOP853", t, rtol=rtol, atol=1e-4 * rtol)
            paths.append(found.y)
        return np.abs(np.concatenate(paths, axis=1))

    states = [
        response.trajectory.state(t) for *_, span in slides for t in (sum(span) / 2.0, span[1])
    ]
    x_r, v_r = np.abs([state[:2] for state in states]).T
    assert_agrees([x_r, v_r], known, [1e-10, 1e-9])
    assert len(events) > 6


@pytest.mark.parametrize("exponent", [0.5, 0.75, 1.25, 5.0, 19.0])
@pytest.mark.parametrize("motion", [sine(0.5, 0.7), noise(1601, 0.8)], ids=["sine", "noise"])
def test_error_that_a_fractional_exponent_states_is_the_error(exponent, motion):
    law = SHARP_STRIBECK._replace(exponent=exponent)
    fine = solved(law, motion, duration=4.0)
    coarse = solved(law._replace(tolerance=1e-9), motion, duration=4.0)
    off = np.abs(fine.x_r - coarse.x_r).max() / np.abs(fine.x_r).max()
    assert fine.numerics.error < 1e-6
    assert off < 2.0 * fine.numerics.error + 1e-12
    assert off < 2.0 * coarse.numerics.error


@pytest.mark.parametrize("motion", [sine(0.75, 2.0), noise(4000, 0.67)], ids=["sine", "noise"])
def test_stribeck_without_a_fall_is_coulomb(motion):
    duration = 10.0 if isinstance(motion, Sines) else None
    flat = solved(DynamicLaw(45.0, 45.0, STRIBECK, v_s=1e-3), motion, duration=duration)
    coulomb = solved(CoulombLaw(45.0, 45.0), motion, duration=duration)
    assert np.abs(flat.x_r - coulomb.x_r).max() < 1e-10 * np.abs(coulomb.x_r).max()
    assert flat.events.kind.tolist() == coulomb.events.kind.tolist()
    assert flat.events.t == pytest.approx(coulomb.events.t, abs=1e-9)


@pytest.mark.parametrize(
    "law",
    [DAHL, *(law._replace(F_fs=45.0, sigma_1=0.0, sigma_2=0.0) for law in (LUGRE, MEMORY))],
    ids=["dahl", "lugre", "leuven"],
)
def test_stiff_bristles_come_to_coulomb_as_the_root_of_their_softness(law):
    """A reversal takes the way 2 F_fk/σ_0, so the time in which it errs falls as its root."""
    motion = sine(1.0, 1.6)
    coulomb = solved(CoulombLaw(45.0, 45.0), motion, duration=3.0).x_r
    errors = [
        np.abs(solved(law._replace(sigma_0=s), motion, duration=3.0).x_r - coulomb).max()
        for s in (1e5, 1e6, 1e7)
    ]
    assert errors[2] < 5e-4
    assert errors[0] / errors[1] == pytest.approx(math.sqrt(10.0), rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(math.sqrt(10.0), rel=0.05)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(2000, 0.8)], ids=["sine", "noise"])
class TestInvariants(Invariants):
    residual = 1e-10

    def test_split_run_equals_the_whole(self, law, motion):
        if isinstance(motion, Sines):
            pytest.skip("a sine starts anew at t = 0")
        whole = solved(law, motion, duration=4.0)
        rest = Samples(motion.u_dd[800:], motion.dt)
        part = solved(law, rest, start=whole.trajectory.state(2.0), duration=2.0)
        assert np.abs(part.x_r - whole.x_r[800:]).max() < 1e-9 * np.abs(whole.x_r).max()


def test_force_law_and_motion_agree_at_every_sample():
    response = solved(LUGRE, sine(1.0, 1.6), duration=2.0)
    m, k_x, b = PAPER
    x_dd = -(k_x * response.x_r + b * response.v_r + response.F_f) / m
    assert (response.x_dd == x_dd).all()
    assert not response.stuck.any()


@pytest.mark.parametrize(("law", "a_u"), [(LUGRE, 1.0), (MEMORY, 0.6)], ids=["lugre", "leuven"])
def test_steady_orbit_of_bristles_closes_and_repeats(law, a_u):
    motion = sine(a_u, 1.6)
    orbit = find_orbit(PAPER, law, motion, REST, 1 / 1.6)
    assert orbit.settled
    assert orbit.closure <= 1e-9
    response = solved(law, motion, start=orbit.state, duration=2 / 1.6)
    half = len(response.x_r) // 2
    assert np.abs(response.x_r[half:] - response.x_r[: len(response.x_r) - half]).max() < 1e-9


@pytest.mark.parametrize("law", [LUGRE, SMOOTH_STRIBECK], ids=["lugre", "stribeck"])
@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(2000, 0.8)], ids=["sine", "noise"])
def test_a_long_motion_is_followed_anew_leg_by_leg_to_the_last_bit(law, motion, monkeypatch):
    monkeypatch.setattr(taylor, "FIRST_BLOCK_STEPS", 50)
    monkeypatch.setattr(taylor, "BLOCK_STEPS", 70)
    t = np.linspace(0.0, 4.0, 1601)

    def seen(cached):
        monkeypatch.setattr(taylor, "MAX_CACHED_BLOCKS", cached)
        trajectory = StickSlip().trajectory(PAPER, law, motion, REST, 4.0)
        assert len(trajectory.march.cached) <= cached
        blocks = len(trajectory.march.checkpoints)
        return trajectory.at(t), trajectory.totals(0.3, 3.7), trajectory.state(1.234), blocks

    few, all_of_them = seen(2), seen(1000)
    assert few[3] > 5
    for one, two in zip(few[0], all_of_them[0], strict=True):
        assert (one == two).all()
    assert few[1:] == all_of_them[1:]
    monkeypatch.undo()
    whole = StickSlip().trajectory(PAPER, law, motion, REST, 4.0)
    assert np.abs(few[0][0] - whole.at(t)[0]).max() < 1e-11 * np.abs(few[0][0]).max()


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", ["stribeck", "dahl", "lugre", "leuven"])
def test_pulses_after_silence_move_the_mass_alike_mirrored_and_at_half_the_step(name, seed):
    plant, law, motion = sparse(name, seed)
    whole = solved(law, motion, plant=plant)
    scale = np.abs(whole.x_r).max()
    assert (solved(law, mirrored(motion), plant=plant).x_r == -whole.x_r).all()
    half = solved(law, halved(motion), plant=plant)
    assert np.abs(half.x_r[::2] - whole.x_r).max() <= 1e-9 * scale


@pytest.mark.parametrize("law", [DAHL, LUGRE, MEMORY], ids=["dahl", "lugre", "leuven"])
def test_mass_on_bristles_never_sticks_however_long_it_rests(law):
    u_dd = np.zeros(401)
    u_dd[[100, 300]] = 1.5, -1.0
    motion = Samples(u_dd, 0.05)
    whole = solved(law, motion)
    for response in (whole, solved(law, halved(motion)), solved(law, mirrored(motion))):
        assert not response.stuck.any()
        assert "stick" not in response.events.names
        assert measure(response.trajectory, (0.0, 20.0), None)["stuck_share"] == 0.0
        assert stuck_intervals(response, 0.0, 20.0) == []
    still = solved(law, Samples(np.zeros(11), 0.1))
    assert measure(still.trajectory, (0.0, 1.0), None)["stuck_share"] == 0.0
    assert stuck_intervals(still, 0.0, 1.0) == []


@pytest.mark.parametrize("law", [DAHL, LUGRE, MEMORY], ids=["dahl", "lugre", "leuven"])
def test_swing_on_bristles_that_has_died_away_turns_no_more(law):
    """Rounding would turn it again and again, at other times with every step."""
    u_dd = np.zeros(101)
    u_dd[1] = 1.5
    motion, counts = Samples(u_dd, 0.2), []
    for _ in range(3):
        counts.append(len(solved(law, motion).events))
        motion = halved(motion)
    assert counts == counts[:1] * 3


# Laws against what is known without a march: free decay, the belt, the loss a cycle.


STILL = Sines((), (), ())
PLAIN = Plant(1.0, 1.0, 0.0)

ANSWERS_DAHL = DynamicLaw(1.0, 1.0, BRISTLE, sigma_0=20.0)
LEUVEN_1 = ANSWERS_DAHL._replace(kind=LEUVEN, F_h=2.0)
YIELDING = {
    "jenkins": elastic_law(1.0, 20.0),
    "dahl": ANSWERS_DAHL,
    "leuven-1": LEUVEN_1,
    "leuven-1.5": LEUVEN_1._replace(power=1.5),
    "leuven-2": LEUVEN_1._replace(power=2.0),
}
"""Laws that give way before they slide; LuGre's with one limit and no damping is Dahl's."""

yielding = pytest.mark.parametrize("law", YIELDING.values(), ids=YIELDING)


def scaled(law, force, stiffness):
    """Return a law at another force [N] and another stiffness of its contact [N/m]."""
    if law.is_elastic:
        return law._replace(F_fk=force, k_t=stiffness)
    return law._replace(F_fk=force, F_fs=force, F_h=2.0 * force, sigma_0=stiffness)


def half_cycle(law, f_0, way, span=2.0, rtol=RTOL):
    """Return force [N] and loss [J] on a path from a reversal, as functions of the path.

    `span` is 1 on the virgin curve of bristles and 2 behind a turn.
    """
    if law.is_elastic:
        bends = min((law.F_fk - f_0) / law.k_t, way)
        f = f_0 + law.k_t * bends
        return f, 0.5 * (f_0 + f) * bends + law.F_fk * (way - bends)

    def rise(_, y):
        share = y[0] / law.F_fk
        if law.kind == BRISTLE:
            return [law.sigma_0 * (1.0 - share), y[0]]
        bent = 1.0 - (y[0] - f_0) / (span * law.F_h)
        left = 1.0 - math.copysign(abs(share) ** law.power, share)
        return [law.sigma_0 * bent * left, y[0]]

    start, accuracy = [f_0, 0.0], {"rtol": rtol, "atol": 0.1 * rtol}
    return solve_ivp(rise, (0.0, way), start, "DOP853", **accuracy).y[:, -1]


class TestFreeDecay:
    """A mass that is let go turns where its spring has given what its contact has taken."""

    def turning_points(self, law, x, count, rtol):
        """Return the turning point of a mass on a spring of 1 N/m, released at x [m]."""
        found, f, span = [], 0.0, 1.0
        for _ in range(count):

            def left(y, x=x, f=f, span=span):
                return 0.5 * (x * x - y * y) - half_cycle(law, f, x + y, span, rtol)[1]

            y = brentq(left, 0.0, x, xtol=1e-12)
            f = -half_cycle(law, f, x + y, span, rtol)[0]
            x, span = y, 2.0
            found.append(y)
        return found

    @yielding
    def test_contact_that_yields_turns_where_its_loop_says(self, law):
        trajectory = StickSlip().trajectory(PLAIN, law, STILL, State(9.0, 0.0), 13.0)
        found = np.abs(trajectory.path.x_r[1:5])
        assert_agrees([found], lambda rtol: [self.turning_points(law, 9.0, 4, rtol)], [1e-9])

    def test_spring_contact_turns_in_closed_form(self):
        law, x = YIELDING["jenkins"], 9.0
        trajectory = StickSlip().trajectory(PLAIN, law, STILL, State(x, 0.0), 13.0)
        shifts = [1.0 / law.k_t, *[4.0 / law.k_t] * 3]
        for turn, shift in zip(trajectory.path.x_r[1:5], shifts, strict=True):
            x = math.sqrt((x - 1.0) ** 2 + shift) - 1.0
            assert abs(turn) == pytest.approx(x, abs=1e-13)

    @yielding
    def test_stiff_contact_loses_as_much_each_half_cycle_as_coulomb(self, law):
        """Amplitude falls by 2 F_fk/k_x; what a soft contact gives back is as its softness."""
        known = 13.317821 - 2.0 * np.arange(7)
        errors = []
        for stiffness in (1e3, 1e4):
            stiff = scaled(law, 1.0, stiffness)
            trajectory = StickSlip().trajectory(PLAIN, stiff, STILL, State(12.0, 6.0), 22.0)
            errors.append(np.abs(np.abs(trajectory.path.x_r[1:8]) - known).max())
        assert errors[1] < 4e-4
        assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.02)

    @pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
    @pytest.mark.parametrize(("v_s", "F"), [(1e-7, 1.0), (1e13, 1.5)], ids=["fast", "slow"])
    def test_stribecks_decay_is_coulombs_at_either_end_of_its_curve(self, exponent, v_s, F):
        law = DynamicLaw(1.0, 1.5, STRIBECK, v_s=v_s, exponent=exponent)
        turns = StickSlip().trajectory(PLAIN, law, STILL, State(12.0, 6.0), 40.0).events
        first = math.hypot(12.0 + F, 6.0) - F
        known = first - 2.0 * F * np.arange(len(turns) - 1)
        assert np.abs(turns.x_r[1:]) == pytest.approx(known, abs=1e-5)
        assert turns.kind[-1] == 0
        assert abs(turns.x_r[-1]) <= law.F_fs < abs(turns.x_r[-2])

    @pytest.mark.parametrize("b", [0.0, 0.1, 0.6])
    @pytest.mark.parametrize(
        "law",
        [CoulombLaw(1.0, 1.0), DynamicLaw(1.0, 1.0, STRIBECK), elastic_law(1.0, 1e9)],
        ids=["coulomb", "stribeck", "jenkins"],
    )
    def test_damping_shrinks_each_turn_as_the_closed_form_says(self, law, b):
        plant = Plant(1.0, 1.0, b)
        path = StickSlip().trajectory(plant, law, STILL, State(30.0, 0.0), 12.0).path
        d = math.exp(-math.pi * 0.5 * b / math.sqrt(1.0 - 0.25 * b * b))
        x = 30.0
        for turn in path.x_r[1:4]:
            x = x * d - (1.0 + d)
            if x < 1.0:
                break
            assert abs(turn) == pytest.approx(x, abs=1e-11 if law.can_stick else 1e-8)

    @pytest.mark.parametrize("exponent", [1.0, 2.0])
    def test_damping_never_lengthens_a_stop_under_stribeck(self, exponent):
        law = DynamicLaw(1.0, 1.5, STRIBECK, v_s=0.3, exponent=exponent)
        stops = [
            StickSlip()
            .trajectory(Plant(1.0, 0.0, b), law, STILL, State(0.0, 5.0), 40.0)
            .events.t[-1]
            for b in (0.0, 0.1, 1.0, 10.0)
        ]
        assert (np.diff(stops) < 0.0).all()


class TestBelt:
    """A belt at speed V under a mass on a spring is a base whose acceleration is a ramp."""

    V = 0.2
    RAMP = Samples(np.arange(4001) * 0.01 * V, 0.01)
    PERIOD, STICK = 8.902605, 5.0

    def periods(self, law):
        """Return the durations of stick (or hold) and of slip from the second on [s]."""
        events = solved(law, self.RAMP, plant=PLAIN).events
        stick, slip = (events.t[np.abs(events.kind) == kind] for kind in (0, 1))
        return np.diff(stick[1:]), slip[1:4] - stick[1:4]

    def test_coulomb_sticks_and_slips_as_long_as_the_closed_form_says(self):
        whole, stuck = self.periods(CoulombLaw(0.5, 1.0))
        assert whole == pytest.approx(self.PERIOD, abs=5e-7)
        assert stuck == pytest.approx(self.STICK, abs=1e-12)

    def test_stribeck_comes_there_as_its_speed_falls(self):
        """The time in which it gains speed is as the power 2/3 of v_s."""
        errors = []
        for v_s in (1e-5, 1e-6, 1e-7):
            whole, stuck = self.periods(DynamicLaw(0.5, 1.0, STRIBECK, v_s=v_s))
            errors.append(np.abs(whole - self.PERIOD).max())
            assert stuck == pytest.approx(self.STICK, abs=errors[-1])
        assert errors[2] < 2e-4
        assert errors[0] / errors[1] == pytest.approx(10.0 ** (2 / 3), rel=0.02)
        assert errors[1] / errors[2] == pytest.approx(10.0 ** (2 / 3), rel=0.02)

    @pytest.mark.parametrize("kind", [BRISTLE, LEUVEN], ids=["lugre", "leuven"])
    def test_stiff_bristles_stick_and_slip_as_long(self, kind):
        errors = []
        for sigma_0 in (1e4, 1e6):
            law = DynamicLaw(
                0.5, 1.0, kind, v_s=1e-3, sigma_0=sigma_0, sigma_1=math.sqrt(sigma_0), F_h=2.0
            )
            response = solved(law, self.RAMP, plant=PLAIN)
            y = response.x_r + self.V * response.t  # what the floor sees
            inner = y[1:-1]
            top = np.flatnonzero((inner > y[:-2]) & (inner >= y[2:]) & (inner > 0.8)) + 1
            errors.append(np.abs(np.diff(response.t[top]) / self.PERIOD - 1.0).max())
        assert errors[1] < 0.01
        assert errors[1] < 0.1 * errors[0]

    @pytest.mark.parametrize(
        ("law", "off"),
        [
            (CoulombLaw(0.5, 0.5), 1e-12), (DynamicLaw(0.5, 0.5, STRIBECK), 1e-12),
            (elastic_law(0.5, 1e5), 1e-5), (scaled(ANSWERS_DAHL, 0.5, 1e5), 5e-4),
            (scaled(LEUVEN_1, 0.5, 1e5), 5e-4),
        ],
        ids=["coulomb", "stribeck", "jenkins", "dahl", "leuven"],
    )  # fmt: skip
    def test_one_limit_ends_in_a_swing_that_just_touches_the_belt(self, law, off):
        response = solved(law, self.RAMP, plant=PLAIN)
        y = response.x_r + self.V * response.t
        slides = response.t > 2.5
        known = 0.5 + self.V * np.sin(response.t[slides] - 2.5)
        assert np.abs(y[slides] - known).max() < off


def loss_of(law, x_max, rtol=RTOL):
    """Return the loss per cycle [J] of a symmetric loop between reversals at ±x_max [m]."""
    f = -law.F_fk
    for _ in range(200):  # a loop has closed where the force comes to what it began with
        before, f = f, -half_cycle(law, f, 2.0 * x_max, rtol=rtol)[0]
        if abs(f - before) < 1e-13 * law.F_fk:
            break
    return 2.0 * half_cycle(law, f, 2.0 * x_max, rtol=rtol)[1]


@yielding
def test_orbit_loses_the_area_of_the_loop_in_each_cycle(law):
    law, T = scaled(law, 45.0, 4e4), 1 / 1.6
    motion = sine(1.0, 1.6)
    orbit = find_orbit(PAPER, law, motion, REST, T)
    metrics = measure(solved(law, motion, orbit.state, T).trajectory, (0.0, T), None)
    x_max, found = metrics["x_r_peak"], metrics["energy_friction"]
    assert_agrees([found], lambda rtol: [loss_of(law, x_max, rtol)], [1e-8 * found])
    if law.is_elastic:
        assert loss_of(law, x_max) == pytest.approx(
            180.0 * (metrics["x_r_peak"] - 45.0 / 4e4), rel=1e-12
        )


CONSTANT = {"coulomb": CoulombLaw(45.0, 45.0), "stribeck": DynamicLaw(45.0, 45.0, STRIBECK)}


@pytest.mark.parametrize("law", CONSTANT.values(), ids=CONSTANT)
def test_orbit_of_a_constant_force_loses_four_times_force_times_stroke(law):
    motion, T = sine(1.0, 1.6), 1 / 1.6
    orbit = find_orbit(PAPER, law, motion, REST, T)
    metrics = measure(solved(law, motion, orbit.state, T).trajectory, (0.0, T), None)
    assert metrics["energy_friction"] == pytest.approx(180.0 * metrics["x_r_peak"], rel=1e-10)


@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(1200, 0.8)], ids=["sine", "noise"])
@pytest.mark.parametrize("law", [*LAWS.values(), MEMORY], ids=[*LAWS, "leuven"])
def test_twice_the_motion_and_the_forces_is_twice_the_answer(law, motion):
    """The speed at which friction falls is part of the motion; stiffness and damping stay."""
    twice = law._replace(
        F_fk=2.0 * law.F_fk, F_fs=2.0 * law.F_fs, v_s=2.0 * law.v_s, F_h=2.0 * law.F_h
    )
    one, two = solved(law, motion, duration=2.0), solved(twice, doubled(motion), duration=2.0)
    assert (two.x_r == 2.0 * one.x_r).all()
    assert (two.F_f == 2.0 * one.F_f).all()


# Bristles so stiff that they settle in no time: the same answer, at a cost that stays.


STIFF_LAWS = {
    "dahl": DAHL,
    "lugre": LUGRE,
    **{f"leuven-{power}": MEMORY._replace(power=power) for power in (1.0, 1.5, 2.0, 3.0)},
}
every_law = pytest.mark.parametrize("law", STIFF_LAWS.values(), ids=STIFF_LAWS)


def followed(law, motion, sigma_0, end=2.0):
    law = law._replace(sigma_0=sigma_0)
    return StickSlip().trajectory(PAPER, law, motion, REST, end)


def directions(trajectory):
    """Return the direction of each segment."""
    march = trajectory.march
    return np.concatenate(
        [march.block(i).solution.segments.d for i in range(len(march.checkpoints) - 1)]
    )


@pytest.mark.parametrize("law", [DAHL, LUGRE], ids=["dahl", "lugre"])
def test_settled_bristles_move_as_those_resolved_by_an_integrator(law):
    motion, law = sine(1.0, 1.6), law._replace(sigma_0=1e7)
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, 0.6)
    assert (np.abs(directions(trajectory)) > QUASI_STEADY).any()
    rates = bristle_rates(law, PAPER, lambda t: motion.A[0] * math.sin(2 * math.pi * 1.6 * t))
    t = np.linspace(0.0, 0.6, 200)

    def known(rtol):
        # Longer steps are unstable with such bristles: they tremble by more than the tolerance.
        return solve_ivp(
            rates, (0.0, 0.6), [0.0] * 3, "DOP853", t, rtol=rtol, atol=1e-5 * rtol,
            max_step=2e-4,
        ).y  # fmt: skip

    x_r, v_r, *_, z = trajectory.at(t)
    own = 1e-11 * peak(x_r), 1e-10 * peak(v_r), 1e-9 * peak(z)
    assert_agrees([x_r, v_r, z], known, own)


@every_law
@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(801, 1.0)], ids=["sine", "noise"])
def test_steps_grow_far_less_than_stiffness(law, motion):
    """A step that resolves the bristles is as short as they are stiff; a mass at rest on them
    still vibrates with the root of the stiffness."""
    soft, stiff = (len(directions(followed(law, motion, s))) for s in (1e6, 1e10))
    assert stiff < 30 * soft


@every_law
@pytest.mark.parametrize("sigma_0", [1e7, 1e9, 1e11])
def test_settled_bristles_do_not_depend_on_the_tolerance(law, sigma_0):
    motion, t = sine(1.0, 1.6), np.linspace(0.0, 2.0, 801)
    fine, coarse = (
        followed(law._replace(tolerance=tolerance), motion, sigma_0)
        for tolerance in (1e-12, 1e-8)
    )
    assert np.abs(fine.at(t)[0] - coarse.at(t)[0]).max() < 1e-9 * np.abs(fine.at(t)[0]).max()
    assert measure(fine, (0.5, 2.0), None)["energy_residual"] < 1e-10


@every_law
def test_the_stiffest_bristles_come_to_coulomb_at_the_same_rate(law):
    motion = sine(1.0, 1.6)
    law = law._replace(F_fs=45.0, sigma_1=0.0, sigma_2=0.0)
    coulomb = solved(CoulombLaw(45.0, 45.0), motion, duration=2.0).x_r
    errors = [
        np.abs(solved(law._replace(sigma_0=s), motion, duration=2.0).x_r - coulomb).max()
        for s in (1e8, 1e10)
    ]
    assert errors[1] < 2e-3 * np.abs(coulomb).max()
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)
