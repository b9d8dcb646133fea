"""Seat-test classes: each proves itself, by its integral, its RMS and its spectrum."""

from __future__ import annotations

import json
from math import log2, sqrt

import numpy as np
import pytest

from drysim.core.model import sample_squares
from drysim.errors import ScenarioError
from drysim.excitation.random import MACHINE_CLASSES, Standard, proof
from drysim.scenario.load import load
from drysim.wording import excitation

STEP = 2.5e-3

INTEGRALS = {
    "EM1": 1.714, "EM2": 2.049, "EM3": 1.726, "EM4": 0.962, "EM5": 1.936, "EM6": 1.648,
    "EM7": 2.255, "EM8": 1.049, "EM9": 1.631, "IT1": 1.575, "IT2": 1.049, "IT3": 0.962,
    "IT4": 1.591, "AG1": 2.255, "AG2": 1.938, "AG3": 1.738,
}  # fmt: skip
"""RMS acceleration by the integral of the spectrum over its band [m/s²]."""


def standard(machine, duration=60.0, **words):
    """Give a class of the shelf."""
    words = {"kind": "standard", "class": machine, "duration": duration, "seed": 1, **words}
    return Standard.model_validate(words)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_integral_is_the_known_one_and_meets_the_stated_rms_within_a_percent(machine):
    spectrum = MACHINE_CLASSES[machine]
    integral = sqrt(spectrum.square())
    assert integral == pytest.approx(INTEGRALS[machine], abs=6e-4)
    assert integral == pytest.approx(spectrum.rms, rel=0.01)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_corners_hold_half_the_power(machine):
    spectrum = MACHINE_CLASSES[machine]
    (n, f_h), (p, f_l) = spectrum.high_pass, spectrum.low_pass
    far = np.array([f_h * 1e-3, f_h * 2e-3, f_l * 1e3, f_l * 2e3])
    low, low_2, high, high_2 = spectrum.density(far)
    assert log2(low_2 / low) == pytest.approx(2 * n, abs=1e-5)
    assert log2(high_2 / high) == pytest.approx(-2 * p, abs=1e-5)
    at = spectrum.density(np.array([f_h, f_l]))
    other = 1 / (1 + (f_h / f_l) ** (2 * p)), 1 / (1 + (f_h / f_l) ** (2 * n))
    assert at == pytest.approx([spectrum.G0 / 2 * share for share in other])


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_the_motion_has_the_stated_rms_to_rounding(machine):
    motion = standard(machine).motion(STEP)
    squares, _ = sample_squares(motion, 0.0, 60.0)
    assert sqrt(squares / 60) == pytest.approx(MACHINE_CLASSES[machine].rms, rel=1e-12)
    assert motion.realised["rms"] == pytest.approx(MACHINE_CLASSES[machine].rms, rel=1e-12)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_without_scaling_the_rms_is_that_of_the_spectrum(machine):
    motion = standard(machine, scale="nothing").motion(1e-3)
    assert motion.u_dd[:-1].std() == pytest.approx(INTEGRALS[machine], abs=6e-4)
    assert motion.realised["scale"] == 1
    assert motion.realised["rms_asked"] == MACHINE_CLASSES[machine].rms


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_realised_psd_stands_beside_its_definition(machine):
    realised = standard(machine).motion(STEP).realised
    assert realised["psd_error"] < 0.01
    bands = realised["psd"]
    assert (bands[0]["from"], bands[-1]["to"]) == pytest.approx(MACHINE_CLASSES[machine].band)
    found = sum(band["found"] * (band["to"] - band["from"]) for band in bands)
    assert sqrt(found) == pytest.approx(MACHINE_CLASSES[machine].rms, rel=0.02)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_welch_is_within_a_tenth_of_the_peak(machine):
    from scipy.signal import welch

    motion = standard(machine, duration=4000.0).motion(0.01)
    f, found = welch(motion.u_dd, 100.0, nperseg=1024)
    low, high = MACHINE_CLASSES[machine].band
    inside = (f > low + 0.2) & (f < high - 0.2)
    asked = MACHINE_CLASSES[machine].density(f[inside])
    assert np.abs(found[inside] - asked).max() < 0.1 * asked.max()


def test_a_false_spectrum_would_be_found_out():
    motion = standard("EM1").motion(STEP)
    assert max(b["found"] - b["asked"] for b in proof(MACHINE_CLASSES["EM4"], motion)) > 1


def test_recalled_rms_is_said_to_be_recalled():
    assert [c.slug for c in standard("EM7").motion(STEP).cautions] == ["recalled"]
    assert standard("AG1").motion(STEP).cautions == ()


def test_class_and_proof_are_printed():
    words = excitation(one := standard("EM6"), one.motion(STEP))
    assert words.startswith("standard EM6, 24001 samples at 400 Hz, 60 s, 1.65 m/s² RMS")
    assert "(asked for: 1.65), PSD within 0." in words


@pytest.fixture
def seat(tmp_path):
    """Write a scenario with a class."""
    file = tmp_path / "seat.yaml"
    file.write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        "excitation: {kind: standard, class: EM3, duration: 60, seed: 1}\n"
        "solver: {step: 2.5e-3}\n"
    )
    return file


def test_proof_is_in_the_sidecar_and_the_class_in_the_metrics(drysim, seat):
    answer = drysim("run", seat, "--json", "--no-plots")
    assert answer.code == 0
    told = json.loads(answer.out)
    assert told["metrics"]["a_u"] == pytest.approx(1.73, rel=1e-12)
    assert told["metrics"]["T_x"] is not None
    base = told["excitation"]
    assert (base["kind"], base["seed"], len(base["sha256"])) == ("standard", 1, 64)
    assert base["realised"]["rms"] == pytest.approx(1.73)
    assert len(base["realised"]["psd"]) == 21


def test_unknown_class_is_named_with_its_nearest_relative(seat):
    seat.write_text(seat.read_text().replace("EM3", "EN3"))
    with pytest.raises(ScenarioError) as fault:
        load(seat)
    (problem,) = fault.value.problems
    assert problem.sentence == (
        "excitation.class must be EM1 to EM9, IT1 to IT4 or AG1 to AG3, not `EN3`; "
        "did you mean `EM3`?"
    )
