"""Sine sweeps: the right frequency at every instant, the right level, and what is refused."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import Law, Plant, State
from drysim.errors import ScenarioError
from drysim.excitation.transient import Chirp
from drysim.scenario.load import load
from drysim.study.ensemble import run

STEP = 1e-3
SCALES = ("linear", "log")


def chirp(scale="linear", **words):
    """Give a sweep of the shelf: 1 to 20 Hz in 100 s, amplitude 1 m/s²."""
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
    response = StickSlip().solve(plant, Law(0.0, 0.0), motion, State(0.0, 0.0), STEP, 400.0)
    peak = np.abs(response.x_r).max() * plant.k_x
    assert peak == pytest.approx(1 / (2 * 0.05 * sqrt(1 - 0.05**2)), rel=5e-3)


def test_coarse_grid_is_said_at_the_highest_frequency():
    (caution,) = chirp(**{"from": 20, "to": 1}).motion(0.005).cautions
    assert caution.slug == "coarse-step"
    assert "at 20 Hz" in caution.sentence
    assert chirp().motion(0.0025).cautions == ()


def scenario(tmp_path, words):
    """Load a scenario with some sweep."""
    file = tmp_path / "seat.yaml"
    file.write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        f"excitation: {{kind: sweep, {words}}}\nsolver: {{step: 1e-3}}\n"
    )
    return load(file)


def test_run_is_as_long_as_the_sweep(tmp_path):
    outcome = run(scenario(tmp_path, "from: 1, to: 10 Hz, rms: 1, duration: 20, scale: log"))
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
def test_faulty_sweeps_are_refused(tmp_path, words, sentence):
    with pytest.raises(ScenarioError) as fault:
        scenario(tmp_path, words)
    (problem,) = fault.value.problems
    assert problem.sentence.startswith(sentence)
