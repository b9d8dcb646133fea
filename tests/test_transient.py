"""Sine sweeps: the right frequency at every instant, the right level, and what is refused."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Plant, State
from drysim.errors import ScenarioError
from drysim.excitation.harmonic import Chirp, Shock
from drysim.study.ensemble import run

STEP = 1e-3
SCALES = ("linear", "log")


def chirp(scale="linear", **words):
    """Return a sweep from 1 to 20 Hz in 100 s, amplitude 1 m/s²."""
    level = {} if "rms" in words else {"amplitude": 1}
    words = {"kind": "sweep", "from": 1, "to": 20, "duration": 100, "scale": scale, **words}
    return Chirp.model_validate({**level, **words})


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(("first", "last"), [(1.0, 20.0), (20.0, 1.0), (5.0, 5.0)])
def test_phase_is_the_integral_of_the_frequency(scale, first, last):
    share = np.linspace(0, 1, 100_001)
    log = scale == "log"
    f = first * (last / first) ** share if log else first + (last - first) * share
    steps = 0.5 * (f[1:] + f[:-1]) * 100 / 100_000
    found = chirp(scale, **{"from": first, "to": last}).cycles(share)
    assert found == pytest.approx(np.concatenate([[0], np.cumsum(steps)]), abs=1e-5)


@pytest.mark.parametrize("scale", SCALES)
def test_frequency_is_the_one_that_was_asked_for_at_every_zero(scale):
    u_dd = chirp(scale).motion(STEP).u_dd
    rising = np.flatnonzero((u_dd[:-1] < 0) & (u_dd[1:] >= 0))
    zeros = (rising - u_dd[rising] / (u_dd[rising + 1] - u_dd[rising])) * STEP
    middles = 0.5 * (zeros[1:] + zeros[:-1])
    asked = 20 ** (middles / 100) if scale == "log" else 1 + 19 * middles / 100
    assert 1 / np.diff(zeros) == pytest.approx(asked, rel=2e-3)


def test_equal_scales_are_equal_sweeps_when_nothing_changes():
    one, other = (chirp(scale, to=1).motion(STEP).u_dd for scale in SCALES)
    assert np.abs(one - other).max() < 1e-9
    assert one == pytest.approx(np.sin(2 * pi * np.arange(100_001) * STEP), abs=1e-9)


def test_a_nearly_constant_frequency_loses_no_digits():
    share = np.linspace(0, 1, 11)
    assert chirp("log", to=1 + 1e-14).cycles(share) == pytest.approx(100 * share, rel=1e-12)


def test_finer_steps_sample_the_same_sweep():
    coarse, fine = (chirp("log").motion(step).u_dd for step in (STEP, STEP / 4))
    assert np.abs(fine[::4] - coarse).max() < 1e-9


@pytest.mark.parametrize("scale", SCALES)
def test_rms_is_that_of_the_sine(scale):
    realised = chirp(scale, rms=0.5).motion(STEP).realised
    assert realised["rms_asked"] == pytest.approx(0.5)
    assert realised["rms"] == pytest.approx(0.5, rel=5e-3)
    assert np.abs(chirp(scale, rms=0.5).motion(STEP).u_dd).max() == pytest.approx(sqrt(0.5))


def test_cycles_are_counted():
    assert chirp().motion(STEP).realised["cycles"] == pytest.approx(1050)
    assert chirp("log").motion(STEP).realised["cycles"] == pytest.approx(1900 / np.log(20))


def test_a_slow_sweep_finds_the_resonance():
    plant = Plant(1.0, (2 * pi * 5) ** 2, 2 * 0.05 * 2 * pi * 5)
    motion = chirp(**{"from": 4, "to": 6}, duration=400).motion(STEP)
    response = StickSlip().solve(
        plant, CoulombLaw(0.0, 0.0), motion, State(0.0, 0.0), STEP, 400.0
    )
    peak = np.abs(response.x_r).max() * plant.k_x
    assert peak == pytest.approx(1 / (2 * 0.05 * sqrt(1 - 0.05**2)), rel=5e-3)


def test_coarse_grid_is_said_at_the_highest_frequency():
    (caution,) = chirp(**{"from": 20, "to": 1}).motion(0.005).warnings
    assert caution.slug == "coarse-step"
    assert "at 20 Hz" in caution.sentence
    assert chirp().motion(0.0025).warnings == ()


@pytest.fixture
def loaded(scenario):
    """Return the scenario of a sweep or a shock."""

    def load(words, step=1e-3, more=""):
        return scenario(
            "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
            f"excitation: {{{words}}}\nsolver: {{step: {step}}}\n{more}"
        )

    return load


def test_run_is_as_long_as_the_sweep(loaded):
    words = "kind: sweep, from: 1, to: 10 Hz, rms: 1, duration: 20, scale: log"
    outcome = run(loaded(words))
    assert len(outcome.response.x_r) == 20_001
    assert outcome.metrics["a_u"] == pytest.approx(outcome.response.motion.realised["rms"])
    assert outcome.metrics["T_x"] is None


FULL = "from: 1, to: 10, rms: 1"
WORDS = {
    FULL: "excitation.duration is required",
    "from: 1, to: 10, duration: 10": "excitation needs rms or amplitude",
    f"{FULL}, duration: 10, amplitude: 1": "excitation has rms already",
    "from: 0, to: 10, rms: 1, duration: 10": "excitation.from must be above 0 Hz",
    "to: 10, rms: 1, duration: 10": "excitation.from is required",
    f"{FULL}, duration: 10, scale: logarithm": "excitation.scale must be linear or log",
    "from: 1, to: 500, rms: 1, duration: 10": "solver.step must be below 0.001 s",
    f"{FULL}, duration: 10.0005": "solver.step must divide excitation.duration",
    f"{FULL}, duration: 10, seed: 1": "unknown key `seed` in excitation of kind sweep",
}


@pytest.mark.parametrize(("words", "sentence"), WORDS.items(), ids=WORDS)
def test_faulty_sweeps_are_refused(loaded, words, sentence):
    with pytest.raises(ScenarioError) as fault:
        loaded(f"kind: sweep, {words}")
    (problem,) = fault.value.problems
    assert problem.sentence.startswith(sentence)


# Shock pulses: their shape, their velocity change, and what a grid makes of them.


SHOCK_STEP = 1e-4
PULSES = ("half-sine", "haversine", "sawtooth", "trapezoid")


def shock(pulse, **words):
    """Return a pulse of 30 m/s² and 11 ms."""
    words = {"kind": "shock", "pulse": pulse, "amplitude": 30, "duration": 0.011, **words}
    return Shock.model_validate(words)


@pytest.mark.parametrize("pulse", PULSES)
def test_pulse_has_its_peak_its_corners_and_nothing_outside(pulse):
    u_dd = shock(pulse, start=0.02).motion(SHOCK_STEP, 0.05).u_dd
    assert len(u_dd) == 501
    assert u_dd.max() == 30
    assert np.flatnonzero(u_dd)[[0, -1]].tolist() == [201, 310 if pulse == "sawtooth" else 309]
    assert u_dd.min() == 0


@pytest.mark.parametrize(
    ("pulse", "change"),
    [("half-sine", 2 / pi), ("haversine", 0.5), ("sawtooth", 0.5), ("trapezoid", 0.9)],
)
def test_velocity_change_is_the_known_one(pulse, change):
    realised = shock(pulse).motion(SHOCK_STEP).realised
    assert realised["velocity_change_asked"] == pytest.approx(change * 30 * 0.011)
    coarse, fine = (
        abs(shock(pulse).motion(step).realised["velocity_change"] / (change * 0.33) - 1)
        for step in (SHOCK_STEP, SHOCK_STEP / 2)
    )
    order = {"half-sine": 4, "sawtooth": 2}.get(pulse)  # how a halved step mends the error
    assert coarse < 1e-13 if order is None else coarse / fine == pytest.approx(order, rel=0.01)


def test_shapes_are_what_their_names_say():
    half, haversine, sawtooth, trapezoid = (
        shock(p).motion(SHOCK_STEP).u_dd / 30 for p in PULSES
    )
    share = np.arange(111) / 110
    assert half[:111] == pytest.approx(np.sin(pi * share), abs=1e-15)
    assert haversine[:111] == pytest.approx((1 - np.cos(2 * pi * share)) / 2, abs=1e-15)
    assert sawtooth[:111] == pytest.approx(share)
    assert trapezoid[[0, 5, 11, 55, 99, 110]] == pytest.approx([0, 5 / 11, 1, 1, 1, 0])


@pytest.mark.parametrize("pulse", ["half-sine", "haversine", "trapezoid"])
def test_a_symmetric_pulse_is_symmetric_to_the_bit(pulse):
    u_dd = shock(pulse).motion(SHOCK_STEP).u_dd[:111]
    assert (u_dd == u_dd[::-1]).all()


def test_a_trapezoid_takes_its_rise():
    u_dd = shock("trapezoid", rise=0.0055).motion(SHOCK_STEP).u_dd
    assert u_dd[:111] == pytest.approx(30 * (1 - np.abs(np.arange(111) - 55) / 55))
    assert shock("trapezoid", rise=0.0055).velocity_change == pytest.approx(30 * 0.0055)


def test_long_name_of_the_sawtooth_is_understood():
    assert shock("terminal-peak sawtooth") == shock("terminal-peak-sawtooth")
    assert shock("terminal-peak sawtooth").pulse == "sawtooth"


def test_slow_isolator_is_left_with_the_velocity_change():
    plant, motion = Plant(75.0, 75.0, 0.0), shock("haversine").motion(SHOCK_STEP, 4.0)
    response = StickSlip().solve(
        plant, CoulombLaw(0.0, 0.0), motion, State(0.0, 0.0), SHOCK_STEP, 4.0
    )
    v = 30 * 0.011 / 2  # rad/s is 1: the stroke is the velocity change
    assert np.abs(response.x_r).max() == pytest.approx(v, rel=1e-4)


def test_half_sine_response_is_the_closed_form():
    omega, D = 2 * pi * 30, 0.011
    plant, motion = Plant(1.0, omega**2, 0.0), shock("half-sine").motion(1e-5, D)
    response = StickSlip().solve(plant, CoulombLaw(0.0, 0.0), motion, State(0.0, 0.0), 1e-5, D)
    t, p = 1e-5 * np.arange(1101), pi / D
    exact = -30 / (omega**2 - p**2) * (np.sin(p * t) - p / omega * np.sin(omega * t))
    assert np.abs(response.x_r - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("pulse", PULSES[:3])
def test_coarse_grid_is_said_with_one_that_is_not(pulse):
    pulsed = shock(pulse, duration=0.01)
    (caution,) = pulsed.motion(1e-3).warnings
    assert caution.slug == "coarse-step"
    assert pulsed.motion(1e-4).warnings == ()


def test_straight_lines_leave_the_pulse_by_no_more_than_is_said():
    for pulse in ("half-sine", "haversine"):
        pulsed = shock(pulse, duration=0.01)
        coarse = pulsed.motion(1e-3)
        fine = pulsed.motion(1e-6).u_dd[:10_001]
        lines = np.interp(np.arange(10_001), 1000 * np.arange(11), coarse.u_dd[:11])
        off = np.abs(lines - fine).max() / 30
        assert 0.8 * coarse.warnings[0].numbers["off"] < off
        assert off < 1.001 * coarse.warnings[0].numbers["off"]


HALF_SINE = "kind: shock, pulse: half-sine, amplitude: 3 g, duration: 11 ms, start: 5 ms"


def test_run_goes_on_for_a_free_period_after_a_shock(loaded):
    outcome = run(loaded(HALF_SINE, 1e-4, "measure: {duration: 0.1}"))
    # ω_0 = 10 rad/s, ξ = 1/3; the shock ends at 16 ms.
    assert outcome.response.t[-1] == pytest.approx(0.016 + 0.2 * pi / sqrt(8 / 9), abs=1e-3)
    assert outcome.metrics["a_u"] == pytest.approx(3 * 9.80665 * sqrt(0.011 / 0.2), rel=1e-3)
    assert outcome.metrics["T_x"] is None
    assert outcome.warnings == ()


def test_a_pulse_that_is_cut_off_is_said(loaded):
    (caution,) = run(loaded(HALF_SINE, 1e-4, "measure: {duration: 0.01}")).warnings
    assert caution.slug == "pulse-cut"


PULSE = "pulse: half-sine, amplitude: 30"
SHOCK_WORDS = {
    f"{PULSE}": "excitation.duration is required",
    f"{PULSE}, duration: 0": "excitation.duration must be above 0 s",
    f"{PULSE}, duration: 1 mm": "excitation.duration: `mm` is a unit of length",
    f"{PULSE}, duration: 0.01, start: -1": "excitation.start must be at least 0 s",
    f"{PULSE}, duration: 0.01, rise: 0.001": "excitation.rise is not used for a half-sine",
    f"{PULSE}, duration: 0.01234": "solver.step must divide excitation.duration = 0.01234 s",
    f"{PULSE}, duration: 0.01, start: 0.00055": "solver.step must divide excitation.start",
    "pulse: square, amplitude: 30, duration: 0.01": "excitation.pulse must be half-sine, hav",
    "pulse: trapezoid, amplitude: 30, duration: 0.01, rise: 6 ms": "excitation.rise must be at",
    "pulse: trapezoid, amplitude: 3, duration: 10.5 ms": "solver.step must divide",
}


@pytest.mark.parametrize(("words", "sentence"), SHOCK_WORDS.items(), ids=SHOCK_WORDS)
def test_faulty_shocks_are_refused(loaded, words, sentence):
    with pytest.raises(ScenarioError) as fault:
        loaded(f"kind: shock, {words}", 1e-4, "measure: {duration: 0.1}")
    (problem,) = fault.value.problems
    assert problem.sentence.startswith(sentence)
