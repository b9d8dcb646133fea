"""A generated base motion is told by its data: in summaries, and above every picture."""

from __future__ import annotations

import pytest

from drysim.plots.comparison import draw as draw_comparison
from drysim.plots.response import draw as draw_response
from drysim.plots.sweep import draw_transmissibility as draw_sweep
from drysim.scenario.load import scenario
from drysim.study.compare import compare
from drysim.study.ensemble import run
from drysim.study.sweep import sweep

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 300}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
solver: {step: 5 ms}
measure: {duration: 1 s}
excitation: """

GENERATED = {
    "{kind: standard, class: EM3, duration: 2 s, seed: 1}": "standard EM3",
    "{kind: road, class: C, speed: 36 km/h, duration: 2 s, seed: 1}": "road C at 10 m/s",
    "{kind: road, roughness: 1e-6, reference: n0, speed: 9, duration: 2 s, seed: 1}": (
        "road of 1e-6 m³ (n0) at 9 m/s"
    ),
    "{kind: shock, pulse: half-sine, amplitude: 3 g, duration: 50 ms}": (
        "shock half-sine of 29.42 m/s² for 0.05 s"
    ),
    "{kind: sweep, from: 0.5, to: 10, scale: log, amplitude: 1, duration: 2 s}": (
        "sweep 0.5 to 10 Hz, log"
    ),
    "{kind: psd, points: [[1, 2], [8, 2]], rms: 1, duration: 2 s, seed: 1}": "psd 1 to 8 Hz",
}
ASKED = {"sweep": ", 2 s, 1 m/s² amplitude", "psd": ", 2 s, 1 m/s² RMS", "shock": ""}


def seat(excitation, more=""):
    """Return a seat on some base motion."""
    return scenario(f"{SEAT}{excitation}\n{more}\n")


def headed(figure):
    """Return the heading of a picture in one line."""
    return " ".join(text.get_text() for text in figure.texts)


@pytest.mark.parametrize(("excitation", "words"), GENERATED.items())
def test_generated_motion_is_told_by_its_data_in_runs_and_sweeps(excitation, words):
    base = seat(excitation).excitation
    assert base.describe(base.motion(5e-3, 1.0)).startswith(f"{words}, ")
    shared = base.describe_cases(None, ["friction.kinetic"])
    assert shared == words + ASKED.get(base.kind, ", 2 s")


@pytest.mark.parametrize(
    ("excitation", "swept", "words"),
    [
        (1, "excitation.speed", "road C, 2 s"),
        (2, "excitation.roughness", "road at 9 m/s, 2 s"),
        (3, "excitation.amplitude", "shock half-sine for 0.05 s"),
        (3, "excitation.duration", "shock half-sine of 29.42 m/s²"),
        (4, "excitation.to", "sweep log, 2 s, 1 m/s² amplitude"),
        (4, "excitation.amplitude", "sweep 0.5 to 10 Hz, log, 2 s"),
        (5, "excitation.duration", "psd 1 to 8 Hz, 1 m/s² RMS"),
        (5, "excitation.points.0.0", "psd, 2 s, 1 m/s² RMS"),
    ],
)
def test_what_is_swept_of_a_generated_motion_is_not_told_as_shared(excitation, swept, words):
    base = seat(list(GENERATED)[excitation]).excitation
    assert base.describe_cases(None, [swept]) == words


def test_pictures_of_run_sweep_and_comparison_name_class_and_length():
    excitation = "{kind: standard, class: EM3, duration: 2 s, scale: nothing, seed: 1}"
    seat_alone = seat(excitation, "")
    told = headed(draw_response(run(seat_alone)))
    assert "standard EM3, 401 samples at 200 Hz, 2 s" in told
    swept = seat(excitation, "sweep: {friction.kinetic: [20, 45]}")
    assert "; standard EM3, 2 s; swept:" in headed(draw_sweep(sweep(swept)))
    made = compare(seat_alone, "signum vs stick-slip")
    assert "; standard EM3, 2 s" in headed(draw_comparison(made))


def test_seat_test_classes_are_explained(drysim):
    done = drysim("explain", "EM3")
    assert done.code == 0
    words = " ".join(done.out.split())
    assert "wheel loader above 4500 kg (name unverified)" in words
    assert "1.73 m/s², 0.89 to 11.22 Hz" in words
    unknown = drysim("explain", "EM12")
    assert unknown.code == 2
    assert "did you mean `EM1`?" in unknown.err
