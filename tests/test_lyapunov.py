"""Largest Lyapunov exponents of motions that do not become periodic."""

from __future__ import annotations

import json
from math import hypot, log, pi

import numpy as np
import pytest

from drysim.approach.solution import LyapunovExponent
from drysim.approach.stick_slip import StickSlip
from drysim.cli import main
from drysim.core.model import (
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
    StrokeLimits,
)
from drysim.core.orbit import velocity_scale_rate
from drysim.orbits import search
from drysim.orbits.lyapunov import lyapunov_exponent
from drysim.orbits.return_map import PeriodicSystem
from drysim.orbits.search import find_orbit
from drysim.scenario.load import load
from drysim.study.ensemble import run

CHAOTIC = (0.76, 0.05, 0.27, 5.0)
SETTLES = (0.501, 0.034, 0.2445, 3.807)
"""Frequency ratio, damping ratio, F_fk/(m A) and F_fs/F_fk of motions that do not repeat."""


def scene(beta, zeta, phi, ratio):
    """Return plant, law, base motion and its period [s] of a case with m = k_x = A = 1."""
    law, motion = CoulombLaw(phi, phi * ratio), Sines((1.0,), (beta / (2 * pi),), (0.3,))
    return Plant(1.0, 1.0, 2 * zeta), law, motion, 2 * pi / beta


def exponent_of(case):
    """Return the exponent of the motion that begins at rest, and the search for its orbit."""
    plant, law, motion, period = scene(*case)
    orbit = find_orbit(plant, law, motion, State(0.5, 0.0), period)
    return orbit, lyapunov_exponent(PeriodicSystem(plant, law, motion, period), orbit.state)


def test_exponent_of_a_chaotic_motion_is_clearly_above_zero():
    orbit, exponent = exponent_of(CHAOTIC)
    assert not orbit.settled
    assert exponent.chaotic
    assert 0.0 < exponent.low < exponent.value < exponent.high
    assert exponent.verdict.startswith("chaotic")


def test_exponent_is_the_rate_at_which_two_close_motions_part():
    plant, law, motion, period = scene(*CHAOTIC)
    exponent, (x, v) = exponent_of(CHAOTIC)[1], (0.5, 0.1)
    rate, size, growth = velocity_scale_rate(plant, period), 1e-7, []
    dx, dv = size, 0.0

    def after_a_period(x, v):
        return StickSlip().trajectory(plant, law, motion, State(x, v), period).state(period)[:2]

    for _ in range(800):
        (end_x, end_v), (other_x, other_v) = (
            after_a_period(x, v),
            after_a_period(x + dx, v + dv),
        )
        dx, dv = other_x - end_x, other_v - end_v
        distance = hypot(dx, dv / rate)
        growth.append(log(distance / size))
        x, v, dx, dv = end_x, end_v, dx * size / distance, dv * size / distance
    assert np.mean(growth[100:]) / period == pytest.approx(exponent.value, rel=0.15)


def test_motion_that_only_settles_slowly_is_not_called_chaotic():
    orbit, exponent = exponent_of(SETTLES)
    assert not orbit.settled
    assert not exponent.chaotic
    assert exponent.high < 0.0
    assert exponent.verdict.startswith("not chaotic")


def test_settled_motion_has_the_exponent_of_its_multipliers():
    # Two stops a period with one multiplier besides zero (Shaw 1986): ln|mu|/T.
    plant, law, motion, period = scene(1.0, 1 / 3, 0.6, 1.2)
    orbit = find_orbit(plant, law, motion, State(0.0, 1.0), period)
    assert orbit.settled
    exponent = lyapunov_exponent(PeriodicSystem(plant, law, motion, period), orbit.state)
    assert exponent.value == pytest.approx(log(0.07120099) / period, rel=1e-6)
    assert not exponent.chaotic


def test_equal_limits_are_never_chaotic_and_have_no_exponent():
    plant, _, motion, period = scene(*CHAOTIC)
    law = CoulombLaw(0.27, 0.27)
    found = lyapunov_exponent(PeriodicSystem(plant, law, motion, period), State(0.5, 0.1))
    assert found is None


# Laws that are marched, and end stops.


def impacts(omega):
    """Return plant, law, base motion and period [s] of impacts on one stop, E = 0.8."""
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(StrokeLimits(0.2, 1e3), e=0.8))
    return Plant(1.0, 1.0, 0.0), law, Sines((1.0,), (omega / (2 * pi),), (0.0,)), 2 * pi / omega


def test_impact_oscillator_is_chaotic_beyond_its_period_doublings():
    # Thompson and Ghaffari, Phys. Lett. A 91 (1982) 5.
    plant, law, motion, period = impacts(2.4)
    orbit = find_orbit(plant, law, motion, State(0.0, 1.0), period)
    assert not orbit.settled
    exponent = lyapunov_exponent(PeriodicSystem(plant, law, motion, period), orbit.state)
    assert exponent.chaotic
    assert exponent.verdict.startswith("chaotic")


def test_exponent_of_one_impact_a_period_is_that_of_its_restitution():
    # The multipliers are a complex pair of modulus 0.8.
    plant, law, motion, period = impacts(2.2)
    orbit = find_orbit(plant, law, motion, State(0.0, 1.0), period)
    exponent = lyapunov_exponent(PeriodicSystem(plant, law, motion, period), orbit.state)
    assert (orbit.settled, orbit.periods, exponent.chaotic) == (True, 1, False)
    assert exponent.low < log(0.8) / period < exponent.high


MARCHED = {
    "jenkins": PiecewiseLaw(45.0, 45.0, 30e3),
    "petrov-ewins": PiecewiseLaw(45.0, 45.0, 30e3, 0.5, 4 * pi, 0.3),
    "by direction": PiecewiseLaw(20.0, 24.0, compression=(35.0, 40.0), damping=(100.0, 400.0)),
    "bumpers": PiecewiseLaw(
        20.0, 24.0, stops=EndStops(StrokeLimits(0.006, 0.006), ((0.0, 40e3),), 400.0)
    ),
    "rigid stops": PiecewiseLaw(20.0, 24.0, stops=EndStops(StrokeLimits(0.006, 0.006), e=0.6)),
}


@pytest.mark.parametrize("name", MARCHED)
def test_settled_motion_of_a_marched_law_has_the_exponent_of_its_multipliers(name):
    plant, law, motion = (
        Plant(75.0, 7500.0, 150.0),
        MARCHED[name],
        Sines((2.5,), (2.0,), (0.3,)),
    )
    orbit = search.find_orbit(plant, law, motion, State(0.0, 0.0), 0.5)
    assert orbit.settled
    length = 0.5 * orbit.periods
    trajectory = search.march_period(plant, law, motion, orbit.state, length)
    largest = abs(np.linalg.eigvals(trajectory.monodromy())).max()
    exponent = lyapunov_exponent(PeriodicSystem(plant, law, motion, 0.5), orbit.state)
    if name == "jenkins":
        assert exponent is None
        return
    assert not exponent.chaotic
    assert exponent.value == pytest.approx(log(largest) / length, rel=1e-2)


def test_neutral_exponent_is_undecided():
    found = LyapunovExponent(1e-6, -1e-5, 1e-5, 4096, False)
    assert found.verdict.startswith("undecided")


SCENARIO = """\
drysim: 1
name: chaotic
oscillator: {mass: 1, stiffness: 1, damping: 0.1}
friction: {law: coulomb, kinetic: 0.27, static_ratio: 5}
excitation: {kind: harmonic, frequency: 0.12095775674984046, amplitude: 1}
start: {x_r: 0.5}
solver: {step: 0.05}
"""


def test_run_says_that_a_motion_is_chaotic(tmp_path, capsys):
    file = tmp_path / "chaotic.yaml"
    file.write_text(SCENARIO)
    outcome = run(load(file))
    (warning,) = (one for one in outcome.warnings if one.slug == "not-settled")
    exponent = outcome.response.numerics.lyapunov
    assert "it is chaotic: nearby motions diverge exponentially" in warning.sentence
    assert warning.numbers["lyapunov"] == exponent.value
    assert warning.numbers["lyapunov_low"] == exponent.low > 0.0
    assert main(["run", str(file), "--no-plots", "--out", str(tmp_path / "out")]) == 0
    fields = json.loads((tmp_path / "out" / "drysim.json").read_text())
    assert fields["numerics"]["lyapunov"]["chaotic"] is True
    assert "lyapunov" in capsys.readouterr().out


def test_periodic_motion_reports_no_exponent(tmp_path):
    file = tmp_path / "periodic.yaml"
    file.write_text(SCENARIO.replace("static_ratio: 5", "static_ratio: 1"))
    assert run(load(file)).response.numerics.lyapunov is None
