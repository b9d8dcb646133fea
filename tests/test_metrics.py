"""The window of the metrics: its default, its periods, and what repeats."""

from __future__ import annotations

import math

import numpy as np
import pytest

import drysim
from drysim.core.model import StrokeLimits
from drysim.metrics.stroke import (
    count_limit_entries,
    count_upcrossings,
    half_cycle_peaks,
    hourly_stroke,
)
from drysim.scenario.model import scene_period

# The window of the metrics: its default, its periods, and what repeats.


SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""


@pytest.mark.parametrize(
    ("frequencies", "common"),
    [([1.6], 0.625), ([1.6, 0.7], 10.0), ([0.1, 0.2, 0.3], 10.0), ([1.0, 1.00001], None)],
)
def test_common_period_is_exact_for_decimal_frequencies(scenario, frequencies, common):
    sines = ", ".join(f"{{frequency: {f}, rms: 1}}" for f in frequencies)
    text = SEAT.replace("harmonic, frequency: 1.6, rms: 1.0", f"sines, components: [{sines}]")
    assert scene_period(scenario(text + "measure: {duration: 10}\n")) == common


@pytest.mark.parametrize(
    ("measure", "steady", "settle", "duration"),
    [
        ("{}", True, 0.0, None),
        ("{steady: true}", True, 0.0, None),
        ("{duration: 60}", False, 0.0, 60.0),
        ("{settle: 1 min, duration: 2 min}", False, 60.0, 120.0),
        ("{steady: false, duration: 1 period}", False, 0.0, 0.625),
    ],
)
def test_harmonic_is_steady_unless_a_window_is_given(
    scenario, measure, steady, settle, duration
):
    found = scenario(f"{SEAT}measure: {measure}\n").measure
    assert (found.steady, found.settle, found.duration) == (steady, settle, duration)


def test_times_may_be_counted_in_the_period_of_a_sum_of_sines(scenario):
    sines = "sines, components: [{frequency: 1.6, rms: 1}, {frequency: 0.7, rms: 1}]"
    text = SEAT.replace("harmonic, frequency: 1.6, rms: 1.0", sines)
    found = scenario(f"{text}measure: {{settle: 1 period, duration: 2.5 periods}}\n").measure
    assert (found.settle, found.duration) == (10.0, 25.0)


def test_normal_force_that_does_not_vary_has_no_period(scenario):
    varied = "normal_variation: {amplitude: 0, frequency: 1.70001}"
    assert (
        scene_period(scenario(f"{SEAT}friction: {{law: coulomb, kinetic: 15, {varied}}}\n"))
        == 0.625
    )


# Statistics of the stroke: counted where they can be, and Rice where he has the answer.


PATH = np.array([0.0, 1.0, -2.0, -1.5, -3.0, 0.0, 2.0, 1.0, 1.5, -1.0])


def test_passages_of_zero_are_counted_upwards_and_a_rest_on_zero_is_none():
    assert count_upcrossings(PATH) == 1
    assert count_upcrossings(np.array([-1.0, 0.0, -1.0, 0.0, 1.0])) == 1


def test_each_half_cycle_has_one_peak():
    assert half_cycle_peaks(PATH).tolist() == [1.0, 3.0, 2.0, 1.0]
    assert half_cycle_peaks(np.zeros(3)).tolist() == []


def test_every_return_to_the_limit_counts_and_a_start_beyond_does_not():
    assert count_limit_entries(PATH, StrokeLimits(1.5, 1.5)) == 3
    assert count_limit_entries(np.array([2.0, 1.0, -2.0]), StrokeLimits(1.5, 1.5)) == 1


def test_too_few_half_cycles_are_not_extrapolated():
    assert hourly_stroke(np.ones(149), 60.0) is None
    assert hourly_stroke(np.ones(150), 60.0) == 1.0


def test_tail_of_rayleigh_peaks_is_continued_by_its_law():
    n, sigma = 100_000, 0.01
    heights = sigma * np.sqrt(-2 * np.log((np.arange(n) + 0.5) / n))
    expected = sigma * math.sqrt(2 * math.log(n * 3600 / 600))
    assert hourly_stroke(heights, 600.0) == pytest.approx(expected, rel=1e-3)


def test_gaussian_motion_meets_the_stroke_that_rice_gives(seat):
    noise = {"kind": "psd", "points": [[0.3, 1], [20, 1]], "duration": 900, "seed": 4}
    metrics = drysim.run(
        drysim.load(
            seat,
            {
                "friction": None,
                "excitation": noise,
                "measure": {"settle": 5},
                "stroke.limit": "30 mm",
            },
        )
    ).metrics
    sigma, rate = metrics["x_r_rms"], metrics["v_r_rms"] / metrics["x_r_rms"] / (2 * math.pi)
    assert metrics["crossing_rate"] == pytest.approx(rate, rel=0.03)
    beyond = 2 * rate * math.exp(-((0.03 / sigma) ** 2) / 2)
    assert metrics["limit_rate"] == pytest.approx(beyond, rel=0.25)
    hour = sigma * math.sqrt(2 * math.log(2 * rate * 3600))
    assert metrics["stroke_once_an_hour"] == pytest.approx(hour, rel=0.1)


def test_stroke_that_suffices_knows_the_settling(seat):
    slow = {
        "friction": None,
        "start": {"x_r": "50 mm"},
        "measure": {"settle": 4, "duration": 1},
    }
    metrics = drysim.run(drysim.load(seat, slow)).metrics
    assert metrics["stroke_suffices"] == 0.05 > metrics["x_r_peak"]
    assert metrics["stroke_once_an_hour"] is None


def test_extrapolation_from_two_minutes_with_friction_holds_in_hours_of_the_same_noise(seat):
    def metrics(seed, duration):
        noise = {"kind": "standard", "class": "EM1", "duration": duration, "seed": seed}
        words = {"excitation": noise, "friction.kinetic": 45, "measure": {}}
        return drysim.run(drysim.load(seat, words | {"solver.step": 5e-3})).metrics

    short = np.mean([metrics(seed, 120)["stroke_once_an_hour"] for seed in range(8)])
    hours = [metrics(seed, 3600) for seed in (101, 102, 103)]
    assert short == pytest.approx(np.mean([m["stroke_once_an_hour"] for m in hours]), rel=0.05)
    # The greatest stroke of an hour lies about one mean excess above the one met once an hour.
    assert short < np.mean([m["x_r_peak"] for m in hours]) < 1.2 * short
