"""Random base motion: its spectrum, its level, its displacement, and what is refused."""

from __future__ import annotations

import json
import sys
from math import log2, pi, sqrt

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import trapezoid  # noqa: TID253

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Plant, State, integrate_base_squares, with_rest
from drysim.errors import ScenarioError
from drysim.excitation import random
from drysim.excitation.random import (
    MACHINE_CLASSES,
    Psd,
    Road,
    Standard,
    compare_psd,
    loglog_integral,
    spectrum_mean_square,
)
from drysim.study.ensemble import run
from drysim.study.preparation import prepare
from drysim.units import convert

G = 9.80665
CARRIER = ((10.0, 0.015), (40.0, 0.015), (500.0, 0.00015))
"""Common carrier, vertical: Hz and g²/Hz."""

FLAT = ([0.5, 1.0], [10.0, 1.0])
STEP = 2.5e-3


def psd(points=FLAT, duration=60.0, seed=1, **words):
    """Return a predefined PSD."""
    return Psd.model_validate(
        {"kind": "psd", "points": points, "duration": duration, "seed": seed, **words}
    )


def in_samples(motion):
    """Return a motion whose mean squares follow from its samples alone."""
    return motion._replace(mean_squares=None)


@pytest.fixture
def loaded(scenario):
    """Return the scenario of an excitation."""

    def load(excitation, step="step: 2.5e-3"):
        return scenario(
            "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
            f"excitation: {{{excitation}}}\nsolver: {{{step}}}\n"
        )

    return load


def problem_of(loaded, *words):
    """Return the problem of a scenario that is refused."""
    with pytest.raises(ScenarioError) as fault:
        loaded(*words)
    (problem,) = fault.value.problems
    return problem


def test_area_of_a_log_log_polygon_is_that_of_the_common_carrier():
    assert sqrt(loglog_integral(CARRIER)) == pytest.approx(1.043, abs=5e-4)


@pytest.mark.parametrize("slope", [-3, -1 - 1e-9, -1, -1 + 1e-12, 0, 2])
def test_area_of_a_segment_is_its_integral(slope):
    f = np.geomspace(2, 7, 100_001)
    fine = trapezoid(3 * (f / 2) ** slope, f)
    assert loglog_integral(((2.0, 3.0), (7.0, 3 * 3.5**slope))) == pytest.approx(fine, rel=1e-9)


def test_the_samples_have_the_mean_square_of_the_psd_to_rounding():
    motion = psd(((0.7, 2.0), (3.1, 0.3), (9.0, 1.0))).motion(STEP)
    wanted = loglog_integral(((0.7, 2.0), (3.1, 0.3), (9.0, 1.0)))
    assert np.mean(motion.u_dd[:-1] ** 2) == pytest.approx(wanted, rel=1e-12)
    assert motion.realised["rms_asked"] == pytest.approx(sqrt(wanted), rel=1e-12)


def test_rms_is_met_to_rounding_by_the_motion_between_its_samples():
    motion = psd(rms=0.33).motion(0.01)
    squares, _ = integrate_base_squares(in_samples(motion), 0.0, 60.0)
    assert sqrt(squares / 60.0) == pytest.approx(0.33, rel=1e-12)
    assert motion.realised["rms"] == pytest.approx(0.33, rel=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_mean_squares_in_closed_form_are_those_of_the_samples(seed):
    rng = np.random.default_rng(seed)
    step = rng.choice([2.5e-3, 0.01, 0.04])
    f = np.sort(rng.uniform(0.1, rng.choice([1.0, 0.4 / step]), 4))
    points = tuple((at, 10 ** rng.uniform(-3, 3)) for at in f.tolist())
    duration = step * int(rng.integers(30, 100) / step)
    motion = psd(points, duration=duration, seed=seed).motion(step)
    end = (len(motion.u_dd) - 1) * step
    known = integrate_base_squares(motion, 0.0, end)
    assert known == pytest.approx((end * motion.mean_squares[0], end * motion.mean_squares[1]))
    sampled = integrate_base_squares(in_samples(motion), 0.0, end)
    assert known == pytest.approx(sampled, rel=1e-11)
    cut = with_rest(motion, 3)
    more = integrate_base_squares(cut, 0.0, end + 3 * step)
    assert more[0] > known[0] or motion.u_dd[-1] == 0.0
    part = 0.5 * step, end
    sampled = integrate_base_squares(in_samples(motion), *part)
    assert integrate_base_squares(motion, *part) == sampled


def test_points_in_g_are_points_in_si():
    spoken = psd([[10, "0.015 g²/Hz"], ["40 Hz", "0.015 g^2/Hz"], [500, "0.00015 g2/Hz"]])
    assert [P for _, P in spoken.points] == pytest.approx([P * G**2 for _, P in CARRIER])
    assert convert("3 (m/s²)²/Hz", "(m/s²)²/Hz") == convert("3 m²/s³", "(m/s²)²/Hz") == 3
    assert convert("3 cm^2/s^3", "(m/s²)²/Hz") == pytest.approx(3e-4, rel=1e-15)


def test_welch_finds_the_psd_that_was_asked_for():
    from scipy.signal import welch

    points = ((0.5, 0.2), (2.0, 1.0), (5.0, 1.0), (10.0, 0.1))
    motion = psd(points, duration=4000.0).motion(0.01)
    f, found = welch(motion.u_dd, 100.0, nperseg=1000)
    inside = (f > 1.0) & (f < 9.5)
    corners = np.log(np.array(points)).T
    asked = np.exp(np.interp(np.log(f[inside]), *corners))
    assert np.abs(found[inside] - asked).max() < 0.1
    assert found[f > 10.5].max() < 1e-6


def test_nothing_is_outside_the_band():
    motion = psd(((2.0, 1.0), (4.0, 1.0))).motion(STEP)
    lines = np.abs(np.fft.rfft(motion.u_dd[:-1], norm="forward"))
    outside = np.ones(len(lines), bool)
    outside[120:241] = False
    assert lines[outside].max() < 1e-15
    assert lines[120:241].min() > 0.04


def test_same_seed_gives_the_same_bits_and_another_seed_another_signal():
    first, again, other = (psd(seed=seed).motion(STEP).u_dd for seed in (7, 7, 8))
    assert first.tobytes() == again.tobytes()
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.2


@pytest.mark.parametrize("samples", [1200, 1201, 2002])
def test_signal_is_the_same_to_the_last_bit_whatever_is_loaded(monkeypatch, samples):
    import scipy.fft  # noqa: F401

    lines = random.spectral_lines(np.ones_like, (0.5, 10.0), 1.0, samples * 2.5e-3)
    amplitudes = random.line_amplitudes(lines, 2.5e-3)
    beside = random.random_signal(amplitudes, 3)
    monkeypatch.delitem(sys.modules, "scipy.fft")
    alone = random.random_signal(amplitudes, 3)
    assert np.array_equal(beside.u_dd, alone.u_dd)
    assert np.array_equal(beside.u[:], alone.u[:])


def test_a_finer_step_draws_the_same_signal():
    coarse, fine = psd().motion(STEP), psd().motion(STEP / 4)
    assert np.abs(fine.u_dd[::4] - coarse.u_dd).max() < 1e-12


def test_another_band_keeps_the_lines_that_both_have():
    wide, narrow = (psd(((0.5, 1.0), (top, 1.0))).motion(STEP).u_dd for top in (10.0, 8.0))
    wide, narrow = (np.fft.rfft(u_dd[:-1], norm="forward") for u_dd in (wide, narrow))
    assert np.abs(np.angle(wide[40:400] / narrow[40:400])).max() < 1e-9


def test_motion_covers_its_duration_and_closes():
    motion = psd().motion(STEP)
    assert len(motion.u_dd) == 24_001
    assert motion.u_dd[0] == motion.u_dd[-1]
    assert motion.u is not None
    assert motion.u[0] == motion.u[-1]


@pytest.mark.parametrize("step", [STEP, 0.02])
def test_displacement_is_that_of_the_acceleration_as_it_is(step):
    from scipy.interpolate import CubicSpline

    motion = psd().motion(step)
    t = step * np.arange(len(motion.u))
    spline = CubicSpline(t, motion.u[:], bc_type="periodic")  # the one with continuous velocity
    assert np.abs(spline(t, 2) - motion.u_dd).max() < 1e-8
    assert abs(motion.u[:-1].mean()) < 1e-15
    _, squares = integrate_base_squares(in_samples(motion), 0.0, 60.0)
    fine = spline(np.arange(0, 60, step / 8))
    assert squares / 60 == pytest.approx(np.mean(fine**2), rel=1e-6)


def test_without_friction_the_response_has_the_psd_of_the_transfer_function():
    from scipy.signal import welch

    plant, motion = Plant(75.0, 7500.0, 500.0), psd(duration=2000.0).motion(STEP)
    response = StickSlip().solve(
        plant, CoulombLaw(0.0, 0.0), motion, State(0.0, 0.0), STEP, 2000.0
    )
    f, base = welch(motion.u_dd, 1 / STEP, nperseg=8000)
    _, mass = welch(response.x_dd, 1 / STEP, nperseg=8000)
    inside = (f > 0.6) & (f < 9.9)
    s = 2j * np.pi * f[inside]
    T = (500 * s + 7500) / (75 * s**2 + 500 * s + 7500)
    ratio = mass[inside] / base[inside] / np.abs(T) ** 2
    assert ratio.mean() == pytest.approx(1, abs=0.01)
    assert np.abs(ratio - 1).max() < 0.1


def test_metrics_cover_the_whole_duration_and_know_the_displacement(loaded):
    level = "rms: 0.33, duration: 60, seed: 1"
    outcome = run(loaded(f"kind: psd, points: [[0.5, 1], [10, 1]], {level}"))
    assert outcome.metrics["a_u"] == pytest.approx(0.33, rel=1e-12)
    assert outcome.metrics["T_x"] is not None
    assert len(outcome.response.x_r) == 24_001
    assert outcome.scenario.measure.duration is None


def test_few_lines_are_said_to_be_no_noise():
    (caution,) = psd(duration=1.0).motion(STEP).warnings
    assert (caution.slug, caution.numbers["lines"]) == ("few-lines", pytest.approx(10, rel=0.1))


def test_a_coarse_step_is_said_with_one_that_is_not():
    (caution,) = psd().motion(0.02).warnings
    assert caution.slug == "coarse-step"
    assert "; use 0.0086 s or less" in caution.sentence
    assert psd(duration=60.2).motion(0.0086).warnings == ()


POINTS = {
    "points: [[1, 1]]": "excitation.points must have at least two points",
    "points: [[1, 1], [1, 2]]": "excitation.points #2, value 1 must be above the previous",
    "points: [[1, 1], [5, 2, 3]]": "excitation.points #2 must be a pair [frequency, PSD]",
    "points: [[1, 1], 5]": "excitation.points #2 must be a pair [frequency, PSD], not 5",
    "points: [[0, 1], [5, 1]]": "excitation.points #1, value 1 must be above 0 Hz",
    "points: [[1, 0], [5, 1]]": "excitation.points #1, value 2 must be above 0 (m/s²)²/Hz",
    "points: [[1, 1 m/s2], [5, 1]]": "excitation.points #1, value 2: `m/s2` is a unit",
    "points: [[1, 1], [1.01, 1]]": "excitation.duration must be at least 100 s",
    "points: [[1, 1], [200, 1]]": "solver.step must be below 0.0025 s",
}


@pytest.mark.parametrize(("points", "sentence"), POINTS.items(), ids=POINTS)
def test_faulty_points_are_refused_at_their_place(loaded, points, sentence):
    problem = problem_of(loaded, f"kind: psd, {points}, duration: 1.5, seed: 1")
    assert problem.sentence.startswith(sentence)
    assert problem.line in (2, 3)


PSD = "kind: psd, points: [[1, 1], [5, 1]]"
ROAD = "kind: road, duration: 60, seed: 1"
FAULTS = {
    f"{PSD}, seed: 1": "excitation.duration is required",
    f"{PSD}, duration: 60": "excitation needs seed, seeds or until",
    f"{PSD}, duration: 0, seed: 1": "excitation.duration must be above 0 s",
    f"{PSD}, duration: 60, seed: 1.5": "excitation.seed must be a whole number",
    f"{PSD}, duration: 60, seed: true": "excitation.seed must be a whole number",
    f"{PSD}, duration: 60, seed: -1": "excitation.seed must be at least 0",
    f"{PSD}, duration: 60, seed: 1, rms: 0": "excitation.rms must be above 0 m/s²",
    f"{PSD}, duration: 60.001, seed: 1": "solver.step must divide excitation.duration = 60.001",
    "kind: standard, class: EN3, duration: 60, seed: 1": "excitation.class must be EM1 to EM9, "
    "IT1 to IT4 or AG1 to AG3, not `EN3`; did you mean `EM3`?",
    f"{ROAD}, speed: 20": "excitation needs class or roughness",
    f"{ROAD}, class: A": "excitation.speed is required",
    f"{ROAD}, class: A, speed: 0": "excitation.speed must be above 0 m/s",
    f"{ROAD}, class: K, speed: 20": "excitation.class must be A, B, C, D, E, F, G or H",
    f"{ROAD}, class: A, roughness: 1, speed: 20": "excitation has class already",
    f"{ROAD}, class: A, reference: n0, speed: 20": "excitation.reference requires roughness",
    f"{ROAD}, roughness: 16e-6, speed: 20": "excitation.roughness needs its reference: "
    "`reference: n0`",
    f"{ROAD}, roughness: 0, reference: n0, speed: 20": "excitation.roughness must be above 0",
    f"{ROAD}, class: A, speed: 20, wave_numbers: {{from: 3}}": "excitation.wave_numbers.to",
    f"{ROAD}, class: A, speed: 400": "solver.step must be below 0.0004417 s",
}


@pytest.mark.parametrize(("words", "sentence"), FAULTS.items(), ids=FAULTS)
def test_faulty_excitation_is_refused(loaded, words, sentence):
    assert problem_of(loaded, words).sentence.startswith(sentence)


def test_a_step_is_required(loaded):
    problem = problem_of(loaded, f"{PSD}, duration: 60, seed: 1", "")
    assert problem.sentence.startswith("solver.step is required")


def test_a_signal_larger_than_the_memory_is_refused_before_it_is_made(loaded):
    huge = loaded(f"{PSD}, duration: 1e12, seed: 1")
    with pytest.raises(ScenarioError) as fault:
        prepare(huge)
    assert "GB of memory" in fault.value.problems[0].sentence


def test_motion_without_scenario_refuses_a_step_that_does_not_suit():
    with pytest.raises(ValueError, match="must divide"):
        psd().motion(0.007)
    with pytest.raises(ValidationError, match="two points"):
        psd(points=[])


def test_a_block_on_white_noise_has_the_laplace_law():
    """Density of v_r ∝ exp(-F|v_r|/(m D)), for noise of two-sided intensity 2D."""
    white, step, T = [[0.001, 4.0], [98.0, 4.0]], 0.005, 5000.0  # one-sided in Hz, D is 1
    motion = psd(white, T, seed=3).motion(step)
    response = StickSlip().solve(
        Plant(1.0, 0.0, 0.0), CoulombLaw(1.0, 1.0), motion, State(0.0, 0.0), step, T
    )
    speed = np.abs(response.v_r)
    assert speed.mean() == pytest.approx(1, abs=0.05)
    shares = [(speed > limit).mean() for limit in (0.5, 1, 2, 3)]
    assert shares == pytest.approx(np.exp([-0.5, -1, -2, -3]), abs=0.02)


# Seat-test classes: each proves itself, by its integral, its RMS and its spectrum.


INTEGRALS = {
    "EM1": 1.714, "EM2": 2.049, "EM3": 1.726, "EM4": 0.962, "EM5": 1.936, "EM6": 1.648,
    "EM7": 2.255, "EM8": 1.049, "EM9": 1.631, "IT1": 1.575, "IT2": 1.049, "IT3": 0.962,
    "IT4": 1.591, "AG1": 2.255, "AG2": 1.938, "AG3": 1.738,
}  # fmt: skip
"""RMS acceleration by the integral of the spectrum over its band [m/s²]."""


def standard(machine, duration=60.0, **words):
    """Return a predefined class."""
    words = {"kind": "standard", "class": machine, "duration": duration, "seed": 1, **words}
    return Standard.model_validate(words)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_integral_is_the_known_one_and_meets_the_stated_rms_within_a_percent(machine):
    spectrum = MACHINE_CLASSES[machine]
    integral = sqrt(spectrum_mean_square(spectrum))
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
    squares, _ = integrate_base_squares(in_samples(motion), 0.0, 60.0)
    assert sqrt(squares / 60) == pytest.approx(MACHINE_CLASSES[machine].rms, rel=1e-12)
    assert motion.realised["rms"] == pytest.approx(MACHINE_CLASSES[machine].rms, rel=1e-12)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_without_scaling_the_rms_is_that_of_the_spectrum(machine):
    motion = standard(machine, scale="nothing").motion(1e-3)
    assert motion.u_dd[:-1].std() == pytest.approx(INTEGRALS[machine], abs=6e-4)
    assert motion.realised["scale"] == 1
    assert motion.realised["rms_asked"] == MACHINE_CLASSES[machine].rms


BANDS = ({"from": 1.0, "to": 2.0, "asked": 0.5, "found": 0.4},)


@pytest.mark.parametrize("machine", MACHINE_CLASSES)
def test_realised_psd_stands_beside_its_definition(machine):
    realised = standard(machine).motion(STEP).realised
    assert realised["psd_error"] < 0.01
    bands = realised["psd"]
    assert (bands[0]["from"], bands[-1]["to"]) == pytest.approx(MACHINE_CLASSES[machine].band)
    found = sum(band["found"] * (band["to"] - band["from"]) for band in bands)
    assert sqrt(found) == pytest.approx(MACHINE_CLASSES[machine].rms, rel=0.02)


def test_a_false_spectrum_would_be_found_out():
    motion = standard("EM1").motion(STEP)
    assert max(b["found"] - b["asked"] for b in compare_psd(MACHINE_CLASSES["EM4"], motion)) > 1


def test_psd_of_a_seed_is_compared_only_when_it_is_read(monkeypatch):
    calls = []
    monkeypatch.setattr(random, "compare_psd", lambda *_: calls.append(1) or BANDS)
    motion = standard("EM3").motion(STEP)
    assert not calls
    assert dict(motion.realised)["psd"] == BANDS
    assert motion.realised["class"] == "EM3"
    assert len(calls) == 1


def test_recalled_rms_is_said_to_be_recalled():
    assert [c.slug for c in standard("EM7").motion(STEP).warnings] == ["recalled"]
    assert standard("AG1").motion(STEP).warnings == ()


def test_class_and_proof_are_printed():
    words = (one := standard("EM6")).describe(one.motion(STEP))
    assert words.startswith("standard EM6, 24001 samples at 400 Hz, 60 s, 1.65 m/s² RMS")
    assert "(requested: 1.65), PSD error up to 0." in words


def test_proof_is_in_the_sidecar_and_the_class_in_the_metrics(drysim, loaded):
    loaded("kind: standard, class: EM3, duration: 60, seed: 1")
    answer = drysim("run", "seat.yaml", "--json", "--no-plots")
    assert answer.code == 0
    told = json.loads(answer.out)
    assert told["metrics"]["a_u"] == pytest.approx(1.73, rel=1e-12)
    assert told["metrics"]["T_x"] is not None
    base = told["excitation"]
    assert (base["kind"], base["seed"], len(base["sha256"])) == ("standard", 1, 64)
    assert base["realised"]["rms"] == pytest.approx(1.73)
    assert len(base["realised"]["psd"]) == 21


# Roads of ISO 8608: the right level, whatever it refers to, and the band that it has.


ROAD_STEP = 1e-3


def road(duration=100.0, speed=20.0, **words):
    """Return a predefined road."""
    words = {"kind": "road", "speed": speed, "duration": duration, "seed": 1, **words}
    return Road.model_validate(words)


def test_velocity_psd_of_class_a_at_20_metres_a_second_is_white_and_known():
    (first, last) = road(**{"class": "A"}).corners()
    for f, G in (first, last):
        assert G / (2 * pi * f) ** 2 == pytest.approx(1.263e-4, rel=5e-4)


def test_a_class_is_four_times_the_one_before():
    levels = [road(**{"class": name}).G_d for name in "ABCDEFGH"]
    assert levels == pytest.approx([m * 1e-6 for m in
        (16, 64, 256, 1024, 4096, 16384, 65536, 262144)])  # fmt: skip


def test_a_cubic_centimetre_at_one_radian_a_metre_is_class_a():
    spoken = road(roughness="1 cm3", reference="Omega0")
    assert spoken.G_d == pytest.approx(16e-6, rel=0.01)
    assert road(roughness=16e-6, reference="n0").G_d == 16e-6


def test_references_describe_one_straight_line_in_log_log_axes():
    per_radian = road(roughness=1e-6, reference="Omega0").G_d
    n = 1 / (2 * pi)  # cycle/m where the wave number is 1 rad/m
    assert per_radian * (n / 0.1) ** -2 == pytest.approx(2 * pi * 1e-6)


def test_mean_square_follows_from_the_band():
    motion = road(**{"class": "B"}).motion(ROAD_STEP)
    rise = 16 * pi**4 * 0.01 * 64e-6 * 20
    wanted = rise * ((20 * 2.83) ** 3 - (20 * 0.011) ** 3) / 3
    assert loglog_integral(road(**{"class": "B"}).corners()) == pytest.approx(wanted)
    assert np.mean(motion.u_dd[:-1] ** 2) == pytest.approx(wanted, rel=1e-12)


def test_height_has_the_psd_of_the_class():
    from scipy.signal import welch

    motion = road(2000.0, **{"class": "C"}).motion(5e-3)
    f, found = welch(motion.u[:], 200.0, nperseg=2000)
    inside = (f > 1) & (f < 10)
    asked = 256e-6 * 0.01 * 20 / f[inside] ** 2
    assert np.abs(found[inside] / asked - 1).max() < 0.3
    assert np.mean(found[inside] / asked) == pytest.approx(1, abs=0.02)


def test_nothing_is_outside_the_wave_numbers():
    words = {"class": "A", "wave_numbers": {"from": 0.05, "to": 0.5}}
    u_dd = road(**words).motion(ROAD_STEP).u_dd
    lines = np.abs(np.fft.rfft(u_dd[:-1], norm="forward"))
    assert np.flatnonzero(lines > 1e-12)[[0, -1]].tolist() == [100, 1000]


def test_twice_the_speed_shakes_by_the_fourth_power_of_its_root():
    slow, fast = (road(speed=V, **{"class": "A"}) for V in (10.0, 20.0))
    ratio = sqrt(loglog_integral(fast.corners()) / loglog_integral(slow.corners()))
    assert ratio == pytest.approx(2**2)


def test_rough_classes_are_said_to_be_recalled():
    assert [c.slug for c in road(**{"class": "E"}).motion(ROAD_STEP).warnings] == ["recalled"]
    assert road(**{"class": "D"}).motion(ROAD_STEP).warnings == ()
