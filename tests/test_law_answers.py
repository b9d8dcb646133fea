"""Laws against what is known without a march: free decay, the belt, the loss a cycle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp  # noqa: TID253 - the independent solution
from scipy.optimize import brentq  # noqa: TID253

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    Dynamic,
    Law,
    Plant,
    Samples,
    Sines,
    Slider,
    State,
)
from drysim.metrics import measure
from law_scenes import PAPER, REST, STEP, noise, sine, solved
from reference import RTOL, assert_agrees

STILL = Sines((), (), ())
PLAIN = Plant(1.0, 1.0, 0.0)

DAHL = Dynamic(1.0, 1.0, BRISTLE, sigma_0=20.0)
LEUVEN_1 = DAHL._replace(kind=LEUVEN, F_h=2.0)
YIELDING = {
    "jenkins": Slider(1.0, 20.0),
    "dahl": DAHL,
    "leuven-1": LEUVEN_1,
    "leuven-1.5": LEUVEN_1._replace(power=1.5),
    "leuven-2": LEUVEN_1._replace(power=2.0),
}
"""Laws that give way before they slide; LuGre's with one limit and no damping is Dahl's."""

yielding = pytest.mark.parametrize("law", YIELDING.values(), ids=YIELDING)


def scaled(law, force, stiffness):
    """Give a law at another force [N] and another stiffness of its contact [N/m]."""
    if isinstance(law, Slider):
        return law._replace(F_fk=force, k_t=stiffness)
    return law._replace(F_fk=force, F_fs=force, F_h=2.0 * force, sigma_0=stiffness)


def half_cycle(law, f_0, way, span=2.0, rtol=RTOL):
    """Give force [N] and loss [J] on a way from a turn, told by the way and not by time.

    `span` is 1 on the virgin curve of bristles and 2 behind a turn.
    """
    if isinstance(law, Slider):
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

    def turns(self, law, x, count, rtol):
        """Give where a mass on a spring of 1 N/m turns, let go at x [m]."""
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
        track = StickSlip().track(PLAIN, law, STILL, State(9.0, 0.0), STEP, 13.0)
        found = np.abs(track.turns.x_r[1:5])
        assert_agrees([found], lambda rtol: [self.turns(law, 9.0, 4, rtol)], [1e-9])

    def test_spring_contact_turns_in_closed_form(self):
        law, x = YIELDING["jenkins"], 9.0
        track = StickSlip().track(PLAIN, law, STILL, State(x, 0.0), STEP, 13.0)
        shifts = [1.0 / law.k_t, *[4.0 / law.k_t] * 3]
        for turn, shift in zip(track.turns.x_r[1:5], shifts, strict=True):
            x = math.sqrt((x - 1.0) ** 2 + shift) - 1.0
            assert abs(turn) == pytest.approx(x, abs=1e-13)

    @yielding
    def test_stiff_contact_loses_as_much_each_half_cycle_as_coulomb(self, law):
        """Amplitude falls by 2 F_fk/k_x; what a soft contact gives back is as its softness."""
        known = 13.317821 - 2.0 * np.arange(7)
        errors = []
        for stiffness in (1e3, 1e4):
            stiff = scaled(law, 1.0, stiffness)
            track = StickSlip().track(PLAIN, stiff, STILL, State(12.0, 6.0), STEP, 22.0)
            errors.append(np.abs(np.abs(track.turns.x_r[1:8]) - known).max())
        assert errors[1] < 4e-4
        assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.02)

    @pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
    @pytest.mark.parametrize(("v_s", "F"), [(1e-7, 1.0), (1e13, 1.5)], ids=["fast", "slow"])
    def test_stribecks_decay_is_coulombs_at_either_end_of_its_curve(self, exponent, v_s, F):
        law = Dynamic(1.0, 1.5, STRIBECK, v_s=v_s, exponent=exponent)
        turns = StickSlip().track(PLAIN, law, STILL, State(12.0, 6.0), STEP, 40.0).turns
        first = math.hypot(12.0 + F, 6.0) - F
        known = first - 2.0 * F * np.arange(len(turns) - 1)
        assert np.abs(turns.x_r[1:]) == pytest.approx(known, abs=1e-5)
        assert turns.kind[-1] == 0
        assert abs(turns.x_r[-1]) <= law.F_fs < abs(turns.x_r[-2])

    @pytest.mark.parametrize("b", [0.0, 0.1, 0.6])
    @pytest.mark.parametrize(
        "law", [Law(1.0, 1.0), Dynamic(1.0, 1.0, STRIBECK), Slider(1.0, 1e9)],
        ids=["coulomb", "stribeck", "jenkins"],
    )  # fmt: skip
    def test_damping_shrinks_each_turn_as_the_closed_form_says(self, law, b):
        turns = (
            StickSlip()
            .track(Plant(1.0, 1.0, b), law, STILL, State(30.0, 0.0), STEP, 12.0)
            .turns
        )
        d = math.exp(-math.pi * 0.5 * b / math.sqrt(1.0 - 0.25 * b * b))
        x = 30.0
        for turn in turns.x_r[1:4]:
            x = x * d - (1.0 + d)
            if x < 1.0:
                break
            assert abs(turn) == pytest.approx(x, abs=1e-11 if law.sticks else 1e-8)

    @pytest.mark.parametrize("exponent", [1.0, 2.0])
    def test_damping_never_lengthens_a_stop_under_stribeck(self, exponent):
        law = Dynamic(1.0, 1.5, STRIBECK, v_s=0.3, exponent=exponent)
        stops = [
            StickSlip()
            .track(Plant(1.0, 0.0, b), law, STILL, State(0.0, 5.0), STEP, 40.0)
            .turns.t[-1]
            for b in (0.0, 0.1, 1.0, 10.0)
        ]
        assert (np.diff(stops) < 0.0).all()


class TestBelt:
    """A belt at speed V under a mass on a spring is a base whose acceleration is a ramp."""

    V = 0.2
    RAMP = Samples(np.arange(4001) * 0.01 * V, 0.01)
    PERIOD, STICK = 8.902605, 5.0

    def periods(self, law):
        """Give how long stick or hold, and slip, last from the second time on [s]."""
        events = solved(law, self.RAMP, plant=PLAIN).events
        stick, slip = (events.t[np.abs(events.kind) == kind] for kind in (0, 1))
        return np.diff(stick[1:]), slip[1:4] - stick[1:4]

    def test_coulomb_sticks_and_slips_as_long_as_the_closed_form_says(self):
        whole, stuck = self.periods(Law(0.5, 1.0))
        assert whole == pytest.approx(self.PERIOD, abs=5e-7)
        assert stuck == pytest.approx(self.STICK, abs=1e-12)

    def test_stribeck_comes_there_as_its_speed_falls(self):
        """The time in which it gains speed is as the power 2/3 of v_s."""
        errors = []
        for v_s in (1e-5, 1e-6, 1e-7):
            whole, stuck = self.periods(Dynamic(0.5, 1.0, STRIBECK, v_s=v_s))
            errors.append(np.abs(whole - self.PERIOD).max())
            assert stuck == pytest.approx(self.STICK, abs=errors[-1])
        assert errors[2] < 2e-4
        assert errors[0] / errors[1] == pytest.approx(10.0 ** (2 / 3), rel=0.02)
        assert errors[1] / errors[2] == pytest.approx(10.0 ** (2 / 3), rel=0.02)

    @pytest.mark.parametrize("kind", [BRISTLE, LEUVEN], ids=["lugre", "leuven"])
    def test_stiff_bristles_stick_and_slip_as_long(self, kind):
        errors = []
        for sigma_0 in (1e4, 1e6):
            law = Dynamic(
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
            (Law(0.5, 0.5), 1e-12), (Dynamic(0.5, 0.5, STRIBECK), 1e-12),
            (Slider(0.5, 1e5), 1e-5), (scaled(DAHL, 0.5, 1e5), 5e-4),
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
    """Give the loss a cycle [J] of a symmetric loop between turns at +-x_max [m]."""
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
    orbit = StickSlip().orbit(PAPER, law, motion, REST, T)
    metrics = measure(solved(law, motion, orbit.state, T).track, (0.0, T), None)
    x_max, found = metrics["x_r_peak"], metrics["energy_friction"]
    assert_agrees([found], lambda rtol: [loss_of(law, x_max, rtol)], [1e-8 * found])
    if isinstance(law, Slider):
        assert loss_of(law, x_max) == pytest.approx(
            180.0 * (metrics["x_r_peak"] - 45.0 / 4e4), rel=1e-12
        )


@pytest.mark.parametrize(
    "law", [Law(45.0, 45.0), Dynamic(45.0, 45.0, STRIBECK)], ids=["coulomb", "stribeck"]
)
def test_orbit_of_a_constant_force_loses_four_times_force_times_stroke(law):
    motion, T = sine(1.0, 1.6), 1 / 1.6
    orbit = StickSlip().orbit(PAPER, law, motion, REST, T)
    metrics = measure(solved(law, motion, orbit.state, T).track, (0.0, T), None)
    assert metrics["energy_friction"] == pytest.approx(180.0 * metrics["x_r_peak"], rel=1e-10)


SCALED = {
    "stribeck": Dynamic(15.0, 18.0, STRIBECK, v_s=5e-3),
    "dahl": Dynamic(45.0, 45.0, BRISTLE, sigma_0=1e5),
    "lugre": Dynamic(45.0, 54.0, BRISTLE, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4),
    "leuven": Dynamic(45.0, 54.0, LEUVEN, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, F_h=80.0),
}


@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(1200, 0.8)], ids=["sine", "noise"])
@pytest.mark.parametrize("law", SCALED.values(), ids=SCALED)
def test_twice_the_motion_and_the_forces_is_twice_the_answer(law, motion):
    """The speed at which friction falls is part of the motion; stiffness and damping stay."""
    double = law._replace(
        F_fk=2.0 * law.F_fk, F_fs=2.0 * law.F_fs, v_s=2.0 * law.v_s, F_h=2.0 * law.F_h
    )
    twice = (
        Sines(tuple(2.0 * A for A in motion.A), motion.f, motion.phase)
        if isinstance(motion, Sines)
        else Samples(2.0 * motion.u_dd, motion.dt)
    )
    one, two = solved(law, motion, duration=2.0), solved(double, twice, duration=2.0)
    assert (two.x_r == 2.0 * one.x_r).all()
    assert (two.F_f == 2.0 * one.F_f).all()
