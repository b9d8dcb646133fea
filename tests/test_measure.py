"""The window of the metrics: its default, its periods, and what repeats."""

from __future__ import annotations

import pytest

from drysim.scenario.model import period

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
    assert period(scenario(text + "measure: {duration: 10}\n")) == common


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
        period(scenario(f"{SEAT}friction: {{law: coulomb, kinetic: 15, {varied}}}\n")) == 0.625
    )
