"""Roads of ISO 8608: the right level, whatever it refers to, and the band that it has."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from drysim.errors import ScenarioError
from drysim.excitation.random import Road, area
from drysim.scenario.load import load

STEP = 1e-3


def road(duration=100.0, speed=20.0, **words):
    """Give a road of the shelf."""
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
    motion = road(**{"class": "B"}).motion(STEP)
    rise = 16 * pi**4 * 0.01 * 64e-6 * 20
    wanted = rise * ((20 * 2.83) ** 3 - (20 * 0.011) ** 3) / 3
    assert area(road(**{"class": "B"}).corners()) == pytest.approx(wanted)
    assert np.mean(motion.u_dd[:-1] ** 2) == pytest.approx(wanted, rel=1e-12)


def test_height_has_the_psd_of_the_class():
    from scipy.signal import welch

    motion = road(2000.0, **{"class": "C"}).motion(5e-3)
    f, found = welch(motion.u, 200.0, nperseg=2000)
    inside = (f > 1) & (f < 10)
    asked = 256e-6 * 0.01 * 20 / f[inside] ** 2
    assert np.abs(found[inside] / asked - 1).max() < 0.3
    assert np.mean(found[inside] / asked) == pytest.approx(1, abs=0.02)


def test_height_neither_drifts_nor_has_a_mean():
    u = road(**{"class": "C"}).motion(STEP).u
    assert abs(u[:-1].mean()) < 1e-15
    assert u[0] == u[-1]


def test_nothing_is_outside_the_wave_numbers():
    words = {"class": "A", "wave_numbers": {"from": 0.05, "to": 0.5}}
    u_dd = road(**words).motion(STEP).u_dd
    lines = np.abs(np.fft.rfft(u_dd[:-1], norm="forward"))
    assert np.flatnonzero(lines > 1e-12)[[0, -1]].tolist() == [100, 1000]


def test_twice_the_speed_shakes_by_the_fourth_power_of_its_root():
    slow, fast = (road(speed=V, **{"class": "A"}) for V in (10.0, 20.0))
    ratio = sqrt(area(fast.corners()) / area(slow.corners()))
    assert ratio == pytest.approx(2**2)


def test_rough_classes_are_said_to_be_recalled():
    assert [c.slug for c in road(**{"class": "E"}).motion(STEP).cautions] == ["recalled"]
    assert road(**{"class": "D"}).motion(STEP).cautions == ()


WORDS = {
    "speed: 20": "excitation needs class or roughness",
    "class: A": "excitation.speed is required",
    "class: A, speed: 0": "excitation.speed must be above 0 m/s",
    "class: K, speed: 20": "excitation.class must be A, B, C, D, E, F, G or H",
    "class: A, roughness: 1, speed: 20": "excitation has class already",
    "class: A, reference: n0, speed: 20": "excitation.reference has a meaning only beside",
    "roughness: 16e-6, speed: 20": "excitation.roughness needs its reference: `reference: n0`",
    "roughness: 0, reference: n0, speed: 20": "excitation.roughness must be above 0 m³",
    "class: A, speed: 20, wave_numbers: {from: 3}": "excitation.wave_numbers.to must be above",
    "class: A, speed: 400": "solver.step must be below 0.0004417 s",
}


@pytest.mark.parametrize(("words", "sentence"), WORDS.items(), ids=WORDS)
def test_faulty_roads_are_refused(tmp_path, words, sentence):
    file = tmp_path / "seat.yaml"
    file.write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        f"excitation: {{kind: road, duration: 60, seed: 1, {words}}}\nsolver: {{step: 1e-3}}\n"
    )
    with pytest.raises(ScenarioError) as fault:
        load(file)
    (problem,) = fault.value.problems
    assert problem.sentence.startswith(sentence)
