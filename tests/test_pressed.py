"""Coulomb under a normal force that lifts off or was recorded: a state machine, invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contacts import at
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import Law, Pressed, Pressure, Samples, Sines, State
from invariants import Invariants, TouchingZero
from law_scenes import PAPER, REST, STEP, doubled, noise, sine, solved
from pressing import march_pressed
from reference import assert_agrees, peak

NOISE = noise(1200, 1.0, seed=3)


def recorded(n, step, swing, seed=2):
    """Give a normal force of band-limited noise about 1, of mean 1."""
    values = np.random.default_rng(seed).standard_normal(n)
    values = np.convolve(values, np.hanning(9), mode="same")
    values *= swing / np.std(values)
    return Pressure(1.0 + values - values.mean(), step, 100.0)


FORCES = {
    "touching": Pressed(30.0, 36.0, 1.0, 2 * math.pi * 2.3, 0.4),
    "lifting": Pressed(30.0, 30.0, 1.6, 2 * math.pi * 0.7, 0.4),
    "hammering": Pressed(30.0, 45.0, 1.3, 2 * math.pi * 5.7, 0.0),
    "recorded": Pressed(30.0, 36.0, pressure=recorded(400, 0.0107, 0.2)),
    "record that lifts": Pressed(30.0, 36.0, pressure=recorded(400, 0.0107, 0.9)),
    "record of the same step": Pressed(30.0, 30.0, pressure=recorded(1300, STEP, 0.9)),
}
each_force = pytest.mark.parametrize("law", FORCES.values(), ids=FORCES)
each_base = pytest.mark.parametrize("motion", [sine(1.0, 1.6), NOISE], ids=["sine", "noise"])


def load_of(law):
    """Give the normal force, below zero where the surfaces have parted."""
    if law.pressure is None:
        return lambda t: 1.0 + law.variation * math.sin(law.omega * t + law.phase)
    t, values = np.arange(len(law.pressure.relative)) * law.pressure.step, law.pressure.relative
    return lambda now: np.interp(now, t, values)


def kinks_of(law, motion, end):
    """Give the times at which a force or ü has a kink."""
    kinks = [np.arange(0.0, end, motion.dt)] if isinstance(motion, Samples) else []
    if law.pressure is not None:
        kinks.append(np.arange(0.0, end, law.pressure.step))
    return np.unique(np.concatenate(kinks).round(12)) if kinks else ()


def base_of(motion):
    if isinstance(motion, Samples):
        t = np.arange(len(motion.u_dd)) * motion.dt
        return lambda now: np.interp(now, t, motion.u_dd)
    return lambda now: motion.A[0] * math.sin(2 * math.pi * motion.f[0] * now)


@each_force
@each_base
def test_motion_agrees_with_a_state_machine(law, motion):
    end = 0.9
    response = solved(law, motion, duration=end)
    kinks = kinks_of(law, motion, end)
    scene = PAPER, law.F_fk, law.F_fs, load_of(law), base_of(motion), end

    def known(rtol):
        pieces = march_pressed(*scene, kinks=kinks, rtol=rtol)
        modes = {piece[3] for piece in pieces}
        assert {"free", 1, -1} <= modes or "lift" not in response.events.names
        return at(pieces, response.t)

    x_r, v_r = response.x_r, response.v_r
    assert_agrees([x_r, v_r], known, [1e-8 * peak(x_r), 1e-8 * peak(v_r)])


@each_force
@each_base
class TestInvariants(Invariants):
    def test_twice_the_forces_under_twice_the_base_motion_move_twice_as_far(self, law, motion):
        one = solved(law, motion, duration=2.9)
        twice = law._replace(F_fk=2 * law.F_fk, F_fs=2 * law.F_fs)
        two = solved(twice, doubled(motion), duration=2.9)
        assert (two.x_r == 2 * one.x_r).all()

    def test_friction_is_within_its_limits_and_nothing_where_the_surfaces_are_apart(
        self, law, motion
    ):
        response = solved(law, motion, duration=2.9)
        load = law.load(response.t)
        assert (np.abs(response.F_f) <= law.F_fs * load * (1.0 + 1e-12) + 1e-9).all()
        assert (response.F_f[load == 0.0] == 0.0).all()
        assert (response.F_f * response.v_r >= 0.0).all()
        assert (response.v_r[response.stuck] == 0.0).all()
        sliding = (response.v_r != 0.0) & (load > 1e-9)
        F_f = law.F_fk * load * np.sign(response.v_r)
        assert np.abs(response.F_f - F_f)[sliding].max() < 1e-9


@each_base
def test_constant_record_is_a_constant_force(motion):
    flat = Pressure(np.ones(1000), 0.0071, 100.0)
    one = solved(Pressed(30.0, 40.0, pressure=flat), motion, duration=2.9)
    other = solved(Law(30.0, 40.0), motion, duration=2.9)
    assert np.abs(one.x_r - other.x_r).max() < 1e-12 * np.abs(other.x_r).max()
    assert one.events.kind.tolist() == other.events.kind.tolist()
    assert np.abs(one.events.t - other.events.t).max() < 1e-11
    totals, others = one.track.totals(0.4, 2.8), other.track.totals(0.4, 2.8)
    assert totals[:7] == pytest.approx(others[:7], rel=1e-11)


def test_constant_record_is_a_constant_force_over_steps_that_hold_many_events():
    motion = Samples(noise(8000, 1.0, seed=3).u_dd[::160], 160 * STEP)
    flat = Pressure(np.ones(3), 50.0, 100.0)
    one = solved(Pressed(30.0, 40.0, pressure=flat), motion)
    other = solved(Law(30.0, 40.0), motion)
    assert one.events.kind.tolist() == other.events.kind.tolist()
    assert np.abs(one.events.t - other.events.t).max() < 1e-11
    assert np.abs(one.x_r - other.x_r).max() < 1e-12 * np.abs(other.x_r).max()


@each_force
@each_base
def test_motion_that_ends_within_a_step_is_the_beginning_of_a_longer_one(law, motion):
    short, long = (solved(law, motion, duration=end).track for end in (0.4013, 0.9))
    assert short.state(0.4013)[:2] == pytest.approx(long.state(0.4013)[:2], rel=1e-9)
    one, other = short.totals(0.1, 0.4013), long.totals(0.1, 0.4013)
    assert one[:7] == pytest.approx(other[:7], rel=1e-9)


@each_base
def test_force_that_stays_above_zero_is_that_of_a_varying_limit(motion):
    """The two ways to the same limits: by a wave among the others, and by modes."""
    words = (30.0, 40.0, 0.6, 2 * math.pi * 1.7, 0.3)
    one, other = (solved(law, motion, duration=2.9) for law in (Pressed(*words), Law(*words)))
    assert np.abs(one.x_r - other.x_r).max() < 1e-11 * np.abs(other.x_r).max()


class TestTouchingZero(TouchingZero):
    law = Pressed(30.0, 36.0, 1.0, 2 * math.pi * 2.3)


def test_mass_that_is_never_touched_moves_freely():
    apart = Pressure(np.array([1.0, -1.0, -1.0]), 1e-9, 1.0)
    motion = sine(1.0, 1.6)
    response = solved(Pressed(30.0, 40.0, pressure=apart), motion, duration=2.0)
    free = solved(Law(0.0, 0.0), motion, duration=2.0)
    assert "lift" in response.events.names[:4]
    assert np.abs(response.x_r - free.x_r).max() < 1e-9 * np.abs(free.x_r).max()


def test_mass_at_rest_stays_at_rest_through_lift_and_landing():
    response = solved(FORCES["lifting"], Sines((), (), ()), duration=3.0)
    assert (response.x_r == 0.0).all()
    assert {"lift", "stick"} <= set(response.events.names)


def test_split_run_equals_the_whole():
    law = FORCES["record that lifts"]
    whole, cut = solved(law, NOISE), 428 * STEP  # the hundredth sample of the force
    force = law.pressure.relative[100:]
    rest = Samples(NOISE.u_dd[428:], STEP)
    later = law._replace(pressure=Pressure(force, law.pressure.step, 100.0))
    part = solved(later, rest, start=State(*whole.track.state(cut)[:2]))
    assert np.abs(part.x_r - whole.x_r[428:]).max() < 1e-12


def test_orbit_of_a_lifting_force_closes():
    law = Pressed(30.0, 36.0, 1.4, 2 * math.pi * 0.8, 0.3)
    orbit = StickSlip().orbit(PAPER, law, sine(1.0, 1.6), REST, 1 / 0.8)
    assert orbit.settled
    assert orbit.closure <= 1e-12
    track = solved(law, sine(1.0, 1.6), start=State(*orbit.state[:2]), duration=1 / 0.8).track
    assert track.state(1 / 0.8)[:2] == pytest.approx(orbit.state[:2], rel=1e-10)
