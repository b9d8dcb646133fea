"""The window of the metrics: its default, its periods, and what repeats."""

from __future__ import annotations

import math

import numpy as np
import pytest
from paths import measured_path

import drysim
from drysim.core.model import StrokeLimits
from drysim.metrics.stroke import hourly_stroke
from drysim.metrics.text import describe_residual
from drysim.scenario.model import scene_period

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
    assert measured_path(PATH)[0].upcrossings == 1
    assert measured_path(np.array([-1.0, 0.0, -1.0, 0.0, 1.0]))[0].upcrossings == 1


def test_each_half_cycle_has_one_peak():
    assert measured_path(PATH)[1] == [1.0, -3.0, 2.0, -1.0]
    assert measured_path(np.zeros(3))[1] == []


def test_every_return_to_the_limit_counts_and_a_start_beyond_does_not():
    limits = StrokeLimits(1.5, 1.5)
    assert measured_path(PATH, limits)[0].entries == 3
    assert measured_path(np.array([2.0, 1.0, -2.0]), limits)[0].entries == 1


def test_too_few_half_cycles_are_not_extrapolated():
    assert hourly_stroke(np.ones(149), 60.0) is None
    assert hourly_stroke(np.ones(150), 60.0) == 1.0


def test_peak_that_was_reached_within_an_hour_is_reached_once_an_hour():
    heights = np.append(np.linspace(0.5, 1.0, 500), 9.0)
    assert hourly_stroke(heights, 60.0) == 9.0
    assert hourly_stroke(heights, 36_000.0) < 9.0


def test_tail_of_rayleigh_peaks_is_continued_by_its_law():
    n, sigma = 100_000, 0.01
    heights = sigma * np.sqrt(-2 * np.log((np.arange(n) + 0.5) / n))
    expected = sigma * math.sqrt(2 * math.log(n * 3600 / 600))
    assert hourly_stroke(heights, 600.0) == pytest.approx(expected, rel=1e-3)


def test_gaussian_motion_meets_the_stroke_that_rice_gives(seat):
    noise = {"kind": "psd", "points": [[0.3, 1], [20, 1]], "duration": 900, "seed": 4}
    scene = {"friction": None, "excitation": noise, "measure": {"settle": 5}}
    metrics = drysim.run(drysim.load(seat, scene | {"stroke.limit": "30 mm"})).metrics
    sigma, rate = metrics["x_r_rms"], metrics["v_r_rms"] / metrics["x_r_rms"] / (2 * math.pi)
    assert metrics["crossing_rate"] == pytest.approx(rate, rel=0.03)
    beyond = 2 * rate * math.exp(-((0.03 / sigma) ** 2) / 2)
    assert metrics["limit_rate"] == pytest.approx(beyond, rel=0.25)
    hour = sigma * math.sqrt(2 * math.log(2 * rate * 3600))
    assert metrics["stroke_once_an_hour"] == pytest.approx(hour, rel=0.1)


UNEQUAL = {
    "oscillator.damping": {"extension": 100, "compression": 700},
    "stroke.limit": {"up": "100 mm", "down": "40 mm"},
}
"""A seat that moves farther up than down, and farther beyond its limit down than up."""


def hourly_strokes(seat, changes, seed=1, duration=200, **more):
    noise = {"kind": "standard", "class": "EM3", "duration": duration, "seed": seed} | more
    words = {"excitation": noise, "friction.kinetic": 20, "measure": {}, "solver.step": 5e-3}
    return drysim.run(drysim.load(seat, words | changes))


def test_unequal_limits_are_compared_with_the_peaks_of_their_own_sides_in_an_hour(seat):
    up, down = (f"stroke_once_an_hour_{side}" for side in ("up", "down"))
    short = [hourly_strokes(seat, UNEQUAL, seed).metrics for seed in range(1, 7)]
    hours = [hourly_strokes(seat, UNEQUAL, seed, 3600).metrics for seed in (101, 102, 103)]
    for side, sign, extreme in ((up, 1.0, "x_r_max"), (down, -1.0, "x_r_min")):
        stroke = np.mean([m[side] for m in short])
        assert stroke == pytest.approx(np.mean([m[side] for m in hours]), rel=0.05)
        assert stroke < sign * np.mean([m[extreme] for m in hours]) < 1.2 * stroke
    assert all(m[down] < m["x_r_peak"] for m in short)


def too_short(outcome):
    found = [each for each in outcome.warnings if each.slug == "stroke-too-short"]
    return found[0].sentence if found else ""


def test_the_hourly_stroke_is_too_short_for_the_side_whose_limit_it_exceeds(seat):
    sentence = too_short(outcome := hourly_strokes(seat, UNEQUAL))
    stroke = outcome.metrics["stroke_once_an_hour_down"]
    assert f"is {-1e3 * stroke:.4g} mm" in sentence
    assert f"{100.0 * stroke / 0.04:.3g} % of the lower limit" in sentence
    # The same peaks up are within their limit, whatever the smaller one is.
    wide = UNEQUAL | {"stroke.limit": {"up": "100 mm", "down": "60 mm"}}
    assert outcome.metrics["stroke_once_an_hour"] > 0.06
    assert not too_short(hourly_strokes(seat, wide))
    high = UNEQUAL | {"stroke.limit": {"up": "80 mm", "down": "70 mm"}}
    assert "of the upper limit" in too_short(hourly_strokes(seat, high))


@pytest.mark.parametrize("seed", range(5))
def test_the_peaks_of_half_cycles_alternate_and_change_sides_in_a_mirror(seed):
    rng = np.random.default_rng(seed)
    path = np.round(np.convolve(rng.normal(size=400), np.ones(3), "valid"), 1)
    peaks = np.array(measured_path(path)[1])
    assert np.all(peaks[1:] * peaks[:-1] < 0.0)
    assert peaks.max() == path.max()
    assert peaks.min() == path.min()
    assert measured_path(-path)[1] == (-peaks).tolist()


def test_many_cases_and_seeds_name_the_side_of_the_limit_that_is_too_small(seat):
    noise = {"kind": "standard", "class": "EM3", "duration": 150}
    words = UNEQUAL | {"friction.kinetic": 20, "measure": {}, "solver.step": 5e-3}
    limits = {"up": "110 mm", "down": "42 mm"}
    words |= {"excitation": noise | {"seeds": 3}, "stroke.limit": limits}
    ensemble = drysim.run(drysim.load(seat, words))
    assert "violations" not in [each.slug for each in ensemble.warnings]
    used = ensemble.metrics["stroke_once_an_hour_down"] / 0.042
    assert f"{100.0 * used:.3g} % of the lower limit" in too_short(ensemble)
    assert too_short(ensemble).endswith("mean of 3 seeds")

    forces = {"sweep": {"friction.kinetic": [10, 20, 400]}}
    words["excitation"] = noise | {"seed": 1}
    table = drysim.sweep(drysim.load(seat, words | forces))
    shares = [(row.metrics["stroke_once_an_hour_down"] or 0.0) / 0.042 for row in table]
    assert table[2].metrics["x_r_peak"] < 0.02
    assert f"in {sum(share > 1.0 for share in shares)} of 3 cases" in too_short(table)
    assert f"{100.0 * max(shares):.3g} % of the lower limit" in too_short(table)


@pytest.mark.parametrize(
    "several", [{"excitation.seeds": 3}, {"sweep": {"oscillator.mass": [75, 80]}}]
)
def test_many_cases_and_seeds_warn_of_a_stroke_that_an_hour_exceeds(seat, several):
    noise = {"kind": "standard", "class": "EM3", "duration": 120, "seed": 1}
    words = {"excitation": noise, "friction.kinetic": 20, "measure": {}, "solver.step": 5e-3}

    def solved(limit):
        command = drysim.sweep if "sweep" in several else drysim.run
        return command(drysim.load(seat, words | several | {"stroke.limit": limit}))

    metrics = [row.metrics for row in solved(1.0).rows]
    strokes = [m["stroke_once_an_hour"] for m in metrics]
    peaks = [m["x_r_peak"] for m in metrics]
    stroke = max(strokes) if "sweep" in several else float(np.mean(strokes))
    assert max(peaks) < 0.98 * stroke
    sentence = too_short(solved(0.99 * stroke))
    assert "is expected to be if the base moves on like this" in sentence
    assert "101 % of the limit" in sentence
    assert not too_short(solved(1.01 * stroke))
    assert not too_short(solved(0.9 * min(peaks)))  # exceeded already


def test_stroke_that_suffices_knows_the_settling(seat):
    slow = {"friction": None, "start": {"x_r": "50 mm"}}
    times = {"measure": {"settle": 4, "duration": 1}}
    metrics = drysim.run(drysim.load(seat, slow | times)).metrics
    assert metrics["stroke_suffices"] == 0.05 > metrics["x_r_peak"]
    assert metrics["stroke_once_an_hour"] is None


def test_residual_that_is_rounding_is_shown_without_its_digits():
    assert describe_residual(8e-16, "at most ") == "residual below 1e-14"
    assert describe_residual(2.345e-12, "at most ") == "residual at most 2.3e-12"
    assert describe_residual(None) == "residual not known"
