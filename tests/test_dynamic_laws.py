"""Dynamic laws: against independent solutions, in their limits, and by their invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp  # noqa: TID253 - the independent solution

from drysim.approach import taylor
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import BRISTLE, LEUVEN, STRIBECK, Dynamic, Law, Samples, Sines
from drysim.metrics import measure
from drysim.plots.response import stuck_stretches
from invariants import Invariants
from law_scenes import PAPER, REST, STEP, halved, mirrored, noise, sine, solved, sparse
from reference import assert_agrees, peak

DAHL = Dynamic(45.0, 45.0, BRISTLE, sigma_0=1e5)
LUGRE = Dynamic(
    45.0, 54.0, BRISTLE, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4
)  # fmt: skip
SMOOTH_STRIBECK = Dynamic(15.0, 18.0, STRIBECK, v_s=5e-3)
SHARP_STRIBECK = Dynamic(15.0, 24.0, STRIBECK, v_s=2e-2, exponent=1.0)
MEMORY = LUGRE._replace(kind=LEUVEN, F_h=80.0)
LAWS = {
    "dahl": DAHL,
    "lugre": LUGRE,
    "stribeck": SMOOTH_STRIBECK,
    "stribeck-1": SHARP_STRIBECK,
    "stribeck-1.5": SHARP_STRIBECK._replace(exponent=1.5),
}


def bristle_rates(law, plant, base):
    """Give the right-hand side as the paper of the law writes it."""

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
    assert measure(right.track, (0.0, 599 * STEP), None)["energy_residual"] < 1e-11


def test_limits_of_a_dynamic_law_are_constant_for_all_who_ask():
    assert not DAHL.variation
    assert not SMOOTH_STRIBECK.variation


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_event_tells_the_direction_of_the_motion_that_follows(law):
    response = solved(law, sine(1.0, 1.6), duration=2.0)
    t, kind = response.events.t, response.events.kind
    assert len(t) > 6
    v_r = response.track.at(0.5 * (t[1:] + t[:-1]))[1]
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
        response.track.state(t) for *_, span in slides for t in (sum(span) / 2.0, span[1])
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
    flat = solved(Dynamic(45.0, 45.0, STRIBECK, v_s=1e-3), motion, duration=duration)
    coulomb = solved(Law(45.0, 45.0), motion, duration=duration)
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
    coulomb = solved(Law(45.0, 45.0), motion, duration=3.0).x_r
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
        part = solved(law, rest, start=whole.track.state(2.0), duration=2.0)
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
    orbit = StickSlip().orbit(PAPER, law, motion, REST, 1 / 1.6)
    assert orbit.settled
    assert orbit.closure <= 1e-9
    response = solved(law, motion, start=orbit.state, duration=2 / 1.6)
    half = len(response.x_r) // 2
    assert np.abs(response.x_r[half:] - response.x_r[: len(response.x_r) - half]).max() < 1e-9


@pytest.mark.parametrize("law", [LUGRE, SMOOTH_STRIBECK], ids=["lugre", "stribeck"])
@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(2000, 0.8)], ids=["sine", "noise"])
def test_a_long_motion_is_followed_anew_leg_by_leg_to_the_last_bit(law, motion, monkeypatch):
    monkeypatch.setattr(taylor, "FIRST_LEG", 50)
    monkeypatch.setattr(taylor, "LEG", 70)
    t = np.linspace(0.0, 4.0, 1601)

    def seen(kept):
        monkeypatch.setattr(taylor, "MOST_KEPT", kept)
        track = StickSlip().track(PAPER, law, motion, REST, STEP, 4.0)
        found = track.at(t), track.totals(0.3, 3.7), track.state(1.234), len(track.course.marks)
        assert len(track.course.kept) <= kept
        return found

    few, all_of_them = seen(2), seen(1000)
    assert few[3] > 5
    for one, two in zip(few[0], all_of_them[0], strict=True):
        assert (one == two).all()
    assert few[1:] == all_of_them[1:]
    monkeypatch.undo()
    whole = StickSlip().track(PAPER, law, motion, REST, STEP, 4.0)
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
        assert measure(response.track, (0.0, 20.0), None)["stuck_share"] == 0.0
        assert stuck_stretches(response, 0.0, 20.0) == []
    still = solved(law, Samples(np.zeros(11), 0.1))
    assert measure(still.track, (0.0, 1.0), None)["stuck_share"] == 0.0
    assert stuck_stretches(still, 0.0, 1.0) == []


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
