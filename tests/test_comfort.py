"""Weighted vibration: the filters by their table, and sines whose answers are closed forms."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from seat import SEAT, dotted

import drysim
from drysim import system
from drysim.metrics.comfort import (
    DIRECTIONS,
    WEIGHTINGS,
    apply_weighting,
    fast_length,
    max_running_rms,
    weighting_gain,
)
from drysim.scenario.blocks import Measure
from drysim.study import budget
from drysim.study.sweep import sweep

BANDS = (-4, -3, 0, 3, 6, 7, 8, 9, 10, 12, 15, 19)
"""Exact third octaves 10^(n/10) Hz: 0.4 0.5 1 2 4 5 6.3 8 10 16 31.5 80."""

TABLE = {
    "Wk": (0.3504, 0.4188, 0.4825, 0.5308, 0.9648, 1.0392, 1.0544, 1.0374, 0.9884, 0.7743,
           0.4031, 0.1339),
    "Wd": (0.7097, 0.8540, 1.0110, 0.8913, 0.5143, 0.4081, 0.3226, 0.2550, 0.2017, 0.1266,
           0.0630, 0.0213),
}  # fmt: skip

NAMES = ("a_w", "SEAT", "VDV", "SEAT_VDV", "MTVV", "crest_factor")

SINE = {"kind": "harmonic", "frequency": 4.0, "rms": 1.0}
STEADY = {"steady": True, "direction": "vertical"}
EM6 = {"kind": "standard", "class": "EM6", "duration": 20, "seed": 1}
NOISE = {"excitation": EM6, "measure": {"settle": 2, "direction": "vertical"}}
HELD = {"law": "coulomb", "kinetic": 1000}


def outcome_of(**changes):
    """Run the seat with blocks replaced; a double underscore is the dot of a key."""
    return drysim.run(drysim.scenario(SEAT, dotted(changes)))


def weight(name, f):
    """Return |W| at one frequency."""
    return float(np.abs(weighting_gain(name, np.array([f])))[0])


@pytest.mark.parametrize("name", TABLE)
def test_weighting_is_that_of_the_table_to_four_digits(name):
    found = np.abs(weighting_gain(name, 10 ** (np.array(BANDS) / 10)))
    assert found.round(4).tolist() == list(TABLE[name])


def test_weighting_of_a_backrest_differs_from_that_of_a_seat_in_one_corner():
    f = np.array([0.0, 0.1, 4.0, 50.0, 1e4])
    s, limits = 2j * np.pi * f, weighting_gain("Wd", f)
    low, high = 4 * np.pi, 16 * np.pi

    def transition(omega):
        return (1 + s / omega) / (1 + s / (0.63 * omega) + (s / omega) ** 2)

    expected = limits / transition(low) * transition(high)
    assert weighting_gain("Wc", f) == pytest.approx(expected, rel=1e-12)
    assert weighting_gain("Wc", f)[0] == 0


def test_scenario_knows_every_weighting_and_direction():
    for name in WEIGHTINGS:
        assert Measure(weighting=name).weights == (name, 1.0)
    for name, weights in DIRECTIONS.items():
        assert Measure(direction=name, weighting=weights[0]).weights == weights


@pytest.mark.parametrize(
    ("asked", "name", "k"),
    [
        ({"direction": "vertical"}, "Wk", 1.0),
        ({"direction": "horizontal"}, "Wd", 1.4),
        ({"direction": "horizontal", "weighting": "Wd"}, "Wd", 1.4),
        ({"weighting": "Wd"}, "Wd", 1.0),
        ({"weighting": "Wc"}, "Wc", 1.0),
    ],
)
@pytest.mark.parametrize("f", [0.5, 4.0, 31.5])
def test_sine_of_1_m_s2_on_a_held_seat_is_felt_as_the_weighting_says(asked, name, k, f):
    sine, length = SINE | {"frequency": f}, 1 / f
    metrics = outcome_of(
        friction=HELD, excitation=sine, measure={"steady": True} | asked
    ).metrics
    a_w = k * weight(name, f)
    assert metrics["a_w"] == pytest.approx(a_w, rel=1e-12)
    assert metrics["VDV"] == pytest.approx(a_w * (1.5 * length) ** 0.25, rel=1e-9)
    assert (metrics["SEAT"], metrics["SEAT_VDV"]) == (1.0, 1.0)
    assert metrics["crest_factor"] == pytest.approx(math.sqrt(2), rel=0.1)


def test_mtvv_of_a_sine_with_a_whole_number_of_periods_a_second_is_its_rms():
    metrics = outcome_of(friction=HELD, excitation=SINE, measure=STEADY).metrics
    assert metrics["MTVV"] == pytest.approx(metrics["a_w"], rel=1e-9)


def test_held_seat_on_noise_has_a_seat_of_exactly_one():
    metrics = outcome_of(**NOISE, friction=HELD).metrics
    assert (metrics["SEAT"], metrics["SEAT_VDV"]) == (1.0, 1.0)


def test_seat_of_a_sine_without_friction_is_its_transmissibility():
    metrics = outcome_of(friction=None, excitation=SINE, measure=STEADY).metrics
    assert metrics["SEAT"] == pytest.approx(metrics["T_a"], rel=1e-9)


def test_weighted_metrics_are_unknown_unless_they_are_asked_for():
    metrics = outcome_of(measure={"steady": True}).metrics
    assert [metrics[name] for name in NAMES] == [None] * len(NAMES)


def test_twice_the_motion_and_friction_is_felt_twice_as_much():
    flat = {"kind": "psd", "duration": 9, "seed": 1, "points": [[1, 1], [20, 1]]}
    once, twice = (
        outcome_of(
            excitation=flat | {"rms": rms},
            friction__kinetic=15 * rms,
            measure={"weighting": "Wk"},
        ).metrics
        for rms in (1.0, 2.0)
    )
    for name in ("a_w", "VDV", "MTVV"):
        assert twice[name] == pytest.approx(2 * once[name], rel=1e-9)
    for name in ("SEAT", "SEAT_VDV", "crest_factor"):
        assert twice[name] == pytest.approx(once[name], rel=1e-9)


def test_grid_that_does_not_divide_the_period_makes_no_difference():
    odd, even = (
        outcome_of(excitation=SINE, measure=STEADY, solver__step=step).metrics["a_w"]
        for step in (0.25 / 99.7, 0.25 / 100)
    )
    assert odd == pytest.approx(even, rel=1e-12)


def test_end_of_a_series_does_not_reach_round_to_its_beginning():
    series = np.zeros(4000)
    series[-100:] = 1.0
    assert np.abs(apply_weighting(series, 2.5e-3, "Wk")[:3000]).max() < 1e-4


def test_fast_length_is_that_of_scipy():
    from scipy.fft import next_fast_len

    for least in [*range(1, 2000), 24_600, 8_008_000, 1_000_000_001]:
        assert fast_length(least) == next_fast_len(least, real=True)


def test_running_rms_finds_the_second_of_a_burst():
    series = np.zeros(1000)
    series[300:350] = 2.0  # half a second of 0.01 s steps
    assert max_running_rms(series, 0.01) == pytest.approx(math.sqrt(2.0), rel=1e-12)
    assert max_running_rms(series[:99], 0.01) is None


def test_checks_take_the_new_metrics_and_their_units():
    checks = ["SEAT < 1.5", "a_w < 0.5 g", "VDV < 9 m/s^1.75", "crossing_rate > 1 Hz"]
    verdicts = outcome_of(excitation=SINE, measure=STEADY, checks=checks).checks
    assert [verdict.passed for verdict in verdicts] == [True] * 4


def test_sweep_weighs_every_case_as_a_run_does():
    axis = {"excitation.frequency": [1.0, 4.0]}
    scenario = drysim.scenario(SEAT, {"measure": STEADY, "sweep": axis, "reference": "viscous"})
    table = sweep(scenario)
    alone = outcome_of(measure=STEADY, excitation__frequency=4.0).metrics
    assert table.rows[1].metrics["SEAT"] == alone["SEAT"]
    assert all(row.metrics["a_w"] > 0 for row in table.rows)


def test_cases_that_share_a_base_motion_are_weighted_as_each_alone():
    forces = [10.0, 20.0, 30.0]
    table = sweep(drysim.scenario(SEAT, {**NOISE, "sweep": {"friction.kinetic": forces}}))
    for force, row in zip(forces, table.rows, strict=True):
        alone = outcome_of(**NOISE, friction__kinetic=force).metrics
        assert [row.metrics[name] for name in (*NAMES, "a_u")] == [
            alone[name] for name in (*NAMES, "a_u")
        ]


@pytest.mark.parametrize("approach", ["switch", "moreau", "smooth"])
def test_fixed_steps_feel_what_the_exact_approach_feels(approach):
    exact, found = (
        outcome_of(measure=STEADY, solver={"approach": name, "step": 5e-4}).metrics
        for name in ("stick-slip", approach)
    )
    assert found["SEAT"] == pytest.approx(exact["SEAT"], rel=2e-2)


def test_columns_of_comfort_stand_behind_the_others_and_only_when_asked_for(drysim, seat):
    words = ("sweep", seat, "--no-plots", "--set", "sweep={friction.kinetic: [15, 30]}")
    heads = []
    for asked in ("{}", "{direction: vertical}"):
        drysim(*words, "--out", "out", "--set", f"measure={asked}")
        heads.append((seat.parent / "out/transmissibility.csv").read_text().splitlines()[0])
    added = "a_w [m/s2],SEAT [-],VDV [m/s^1.75],SEAT_VDV [-],MTVV [m/s2],crest_factor [-]"
    assert heads[1] == f"{heads[0]},{added}"


def test_what_is_asked_survives_the_resolved_scenario():
    asked = {"direction": "horizontal"}
    steady = drysim.scenario(SEAT, {"measure": STEADY}).resolved()["measure"]
    window = drysim.scenario(SEAT, {"measure": {"duration": 1} | asked}).resolved()["measure"]
    assert steady == STEADY
    assert window["direction"] == "horizontal"


def test_grid_that_is_too_coarse_to_weigh_on_is_a_warning():
    for step, said in ((6.25e-3, False), (10e-3, True)):
        outcome = outcome_of(measure=STEADY, solver__step=step)
        slugs = {warning.slug for warning in outcome.warnings}
        assert ("coarse-weighting" in slugs) is said


def test_memory_of_weighting_counts(monkeypatch):
    monkeypatch.setattr(system, "total_memory", lambda: 100.0)
    assert budget.memory_shortage(1) == ""
    assert budget.memory_shortage(1, weighted=True)


def test_summary_shows_seat_and_a_w_of_runs_and_sweeps_only_when_asked(drysim, seat):
    words = (seat, "--no-plots", "--set", "measure={direction: horizontal}")
    answer = drysim("run", *words)
    assert re.search(r"SEAT +[0-9.]+ +SEAT_VDV [0-9.]+, VDV", answer.out)
    assert re.search(r"a_w +[0-9.]+ m/s² +Wd, k 1.4; MTVV", answer.out)
    assert "SEAT" in drysim("sweep", *words, "--set", "sweep={friction.kinetic: [1, 9]}").out
    assert "SEAT" not in drysim("run", seat, "--no-plots").out


@pytest.mark.parametrize(("step", "off"), [(4e-3, 1.5e-4), (2e-3, 2.5e-5)])
@pytest.mark.parametrize("rms", [0.5, 0.75, 1.0])
def test_weighting_of_jumps_depends_on_the_step_as_little_as_the_readme_says(step, off, rms):
    words = {"excitation": SINE | {"frequency": 1.6, "rms": rms}, "measure": STEADY}
    coarse, fine = (
        outcome_of(friction__kinetic=45, solver__step=dt, **words).metrics["a_w"]
        for dt in (step, 1e-4)
    )
    assert coarse == pytest.approx(fine, rel=off)


def test_daily_exposure_is_a_w_over_eight_hours(drysim, seat):
    day, half, none = (
        outcome_of(measure=STEADY | stated).metrics
        for stated in ({"exposure": "8 h"}, {"exposure": "2 h"}, {})
    )
    assert day["A_8"] == day["a_w"] == none["a_w"]
    assert half["A_8"] == pytest.approx(0.5 * half["a_w"], rel=1e-15)
    assert none["A_8"] is none["VDV_day"] is None
    ratio = day["VDV_day"] / half["VDV_day"]
    assert ratio == pytest.approx(4.0**0.25, rel=1e-15)
    words = (seat, "--set", "measure={direction: vertical, exposure: 2 h}")
    axis = ("--set", "sweep={friction.kinetic: [15, 20]}")
    drysim("sweep", *words, "--no-plots", *axis, "--out", "out")
    heading = (seat.parent / "out/transmissibility.csv").read_text().splitlines()[0]
    assert heading.endswith(",crest_factor [-],A_8 [m/s2],VDV_day [m/s^1.75]")
    row = r"A_8 +[0-9.]+ m/s² +daily exposure A.8. for 2 h a day"
    assert re.search(row, drysim("run", *words).out)
    lone = drysim("validate", seat, "--set", "measure.exposure=2 h")
    assert "measure.exposure requires `direction` or `weighting`" in lone.out


def test_exposure_of_a_steady_state_is_resolved_and_may_be_swept(seat, drysim):
    measure = STEADY | {"exposure": "2 h"}
    assert outcome_of(measure=measure).scenario.resolved()["measure"]["exposure"] == 7200
    words = ("--set", "measure={direction: vertical, exposure: 1 h}", "--no-plots")
    drysim("sweep", seat, *words, "--set", "sweep.measure.exposure=[2 h, 8 h]", "--out", "out")
    lines = (seat.parent / "out/transmissibility.csv").read_text().splitlines()
    names = lines[0].split(",")
    short, long = (dict(zip(names, line.split(","), strict=True)) for line in lines[1:])
    assert float(short["A_8 [m/s2]"]) == pytest.approx(0.5 * float(long["A_8 [m/s2]"]))
    assert long["A_8 [m/s2]"] == long["a_w [m/s2]"]
