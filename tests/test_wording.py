"""Numbers and scenes in words."""

from __future__ import annotations

from math import inf, nan, pi
from types import SimpleNamespace

import numpy as np
import pytest
from law_scenes import elastic_law, separating_law

from drysim import wording
from drysim.core.model import CoulombLaw, Input, Plant, Samples, Sines
from drysim.excitation.harmonic import Harmonic, Rest, SineSum
from drysim.excitation.recorded import Record
from drysim.scenario.axes import Axis
from drysim.scenario.text import (
    describe_axis,
    describe_case,
    describe_friction,
    describe_oscillator,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-15, "-15"),
        (0.97712345, "0.9771"),
        (7500.0, "7500"),
        (123456.7, "123457"),
        (1e6, "1e6"),
        (0.00012345, "0.0001234"),
        (2.1e-15, "2.1e-15"),
        (-1.23456e-12, "-1.235e-12"),
        (9.99996, "10"),
        (inf, "inf"),
        (nan, "nan"),
        (np.float64(0.5), "0.5"),
        (None, "not known"),
    ],
)
def test_number_has_four_digits_and_no_needless_zeros(value, text):
    assert wording.format_number(value) == text


def test_units_stand_behind_and_a_dash_is_none():
    assert wording.format_number(7500, "N/m") == "7500 N/m"
    assert wording.format_number(0.5, "-") == "0.5"
    assert wording.format_length(0.0172612) == "17.26 mm"
    assert wording.format_length(13.318) == "13.32 m"
    assert wording.format_length(-4e-7) == "-0.4 µm"
    assert wording.format_length(0.0) == "0 mm"
    assert wording.format_length(None) == "not known"
    assert wording.format_quantity(0.025, "m") == "25 mm"
    assert wording.format_quantity_range(0.0, 0.025, "m") == "0 to 25 mm"


def test_swept_values_that_differ_do_not_read_alike():
    def description(*values):
        axis = SimpleNamespace(
            key="friction.static_ratio", unit="-", description="", values=values
        )
        return describe_axis(axis)

    assert description(1.0, 1.0000001, 5.0) == "friction.static_ratio 1, 1.0000001, 5"
    assert description(1.0, 2.0, 2.0) == "friction.static_ratio 1, 2, 2"


def test_length_has_the_unit_of_the_one_beside_it_unless_it_is_far_longer():
    assert wording.format_length(5.328, 13.32) == "5.328 m"
    assert wording.format_length(0.025, 13.32) == "0.025 m"
    assert wording.format_length(10.5, 9.99) == "10500 mm"
    assert wording.format_length(9e-6, 12e-6) == "0.009 mm"
    assert wording.format_length(0.025, 2e-6) == "25 mm"
    assert wording.format_length(0.025, 0.0) == wording.format_length(0.025, None) == "25 mm"
    assert wording.format_length(0.0, 13.32) == "0 m"
    assert wording.format_length(None, 13.32) == "not known"


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.0, "0 %"),
        (1.0, "100 %"),
        (0.2189, "21.9 %"),
        (1e-5, "below 0.1 %"),
        (0.99999, "above 99.9 %"),
        (1.13, "113 %"),
        (None, "not known"),
    ],
)
def test_percent_is_never_rounded_to_all_or_nothing(share, text):
    assert wording.format_percent(share) == text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.034, 0.0711, "3.40 % to 7.11 %"),
        (0.00668, 0.354, "0.7 % to 35.4 %"),
        (0.0, 0.277, "0 % to 27.7 %"),
        (0.001, 1.0, "0.1 % to 100 %"),
        (0.9968, 1.0, "99.7 % to 100 %"),
        (0.9998, 1.0, "above 99.9 % to 100 %"),
        (0.0001, 0.5, "below 0.1 % to 50 %"),
        (0.5, 0.5, "50 %"),
    ],
)
def test_range_of_shares_has_one_precision(low, high, text):
    assert wording.format_percent_range(low, high) == text


def test_clean_text_is_one_line_without_any_control_sign():
    assert wording.sanitise("a\n b\tc") == "a b c"
    assert wording.sanitise("\x1b[31mred\x07\u202e\udc80") == r"\x1b[31mred\x07\u202e\udc80"
    assert wording.sanitise("größer [bold] 日本 ẍ") == "größer [bold] 日本 ẍ"


def test_scene_names_what_follows_from_it():
    words = "m 75 kg, k_x 7500 N/m, b 500 N·s/m, f_0 1.592 Hz, ξ 0.333"
    assert describe_oscillator(Plant(75.0, 7500.0, 500.0)) == words
    assert describe_oscillator(Plant(1.0, 0.0, 0.0)) == "m 1 kg, k_x 0 N/m, b 0 N·s/m"


def test_friction_says_when_the_static_limit_was_not_given():
    assert describe_friction(CoulombLaw(15.0, 18.0)) == "F_fk 15 N, F_fs 18 N"
    assert describe_friction(CoulombLaw(15.0, 15.0), True).endswith("(not given: F_fs = F_fk)")
    assert describe_friction(CoulombLaw(0.0, 0.0), True) == "no dry friction"
    varied = describe_friction(CoulombLaw(15.0, 15.0, 0.4, 2 * pi * 1.7))
    assert varied == "F_fk 15 N, F_fs 15 N, both ± 40 % at 1.7 Hz"


def test_excitation_is_told_by_what_moves_the_base():
    assert Rest(kind="rest").describe(Sines((), (), ())) == "rest, the base stands still"
    harmonic = Harmonic(kind="harmonic", frequency=1.6, rms=1.0)
    assert harmonic.describe(harmonic.motion()) == "harmonic 1.6 Hz, 1 m/s² RMS"
    sines = SineSum(kind="sines", components=[{"frequency": 1, "rms": 1}])
    two = Sines((3.0, 4.0), (0.5, 5.0), (0.0, 0.0))
    description = "sines, 2 components, 0.5 to 5 Hz, 3.536 m/s² RMS"
    assert sines.describe(two) == description
    opposed = Sines((1.0, 1.0, 2.0), (1.0, 1.0, 2.0), (0.0, pi, 0.0))
    assert sines.describe(opposed).endswith(", 1.414 m/s² RMS")
    series = Samples(np.zeros(5), 0.25, inputs=(Input("a\x1b.csv", "", 0),))
    assert (
        Record(kind="record", file="a\x1b.csv").describe(series)
        == r"record a\x1b.csv, 5 samples at 4 Hz, 1 s, 0 m/s² RMS, linear between samples"
    )


def test_what_a_sweep_varies_is_left_out_with_what_follows_from_it():
    plant = Plant(75.0, 7500.0, 500.0)
    assert describe_oscillator(plant, ["excitation.rms"]) == describe_oscillator(plant)
    assert describe_oscillator(plant, ["oscillator.mass"]) == "k_x 7500 N/m, b 500 N·s/m"
    by_ratio = describe_oscillator(plant, ["oscillator.mass"], {"damping_ratio": 1 / 3})
    assert by_ratio == "k_x 7500 N/m, ξ 0.333"
    by_frequency = {"natural_frequency": 1.6}
    f_0 = describe_oscillator(plant, ["oscillator.mass"], by_frequency)
    assert f_0 == "b 500 N·s/m, f_0 1.592 Hz"
    swept = ["oscillator.natural_frequency"]
    assert describe_oscillator(plant, swept, by_frequency) == "m 75 kg, b 500 N·s/m"
    damped = describe_oscillator(plant, ["oscillator.damping"])
    assert damped == "m 75 kg, k_x 7500 N/m, f_0 1.592 Hz"
    law = CoulombLaw(15.0, 18.0)
    assert describe_friction(law, kinetic=False) == "F_fs 18 N"
    assert describe_friction(law, kinetic=False, static=False) == ""
    ratio = describe_friction(law, kinetic=False, static=False, ratios={"static_ratio": 1.2})
    assert ratio == "F_fs/F_fk 1.2"
    assert describe_friction(law, True, False, False) == "F_fs = F_fk (not given)"
    assert describe_friction(CoulombLaw(0.0, 0.0), kinetic=False, static=False) == ""


@pytest.mark.parametrize(
    ("swept", "words"),
    [
        ("friction.normal_variation.phase", "F_fk 12 N, F_fs 16 N, both ± 140 % at 9 Hz"),
        ("friction.normal_variation.amplitude", "F_fk 12 N, F_fs 16 N, both varying at 9 Hz"),
        ("friction.normal_variation.frequency", "F_fk 12 N, F_fs 16 N, both ± 140 %"),
    ],
)
def test_swept_amplitude_of_the_normal_force_is_not_told_as_that_of_the_file(swept, words):
    law = separating_law(12.0, 16.0, 1.4, 2 * pi * 9)
    assert describe_friction(law, swept=[swept]) == words


@pytest.mark.parametrize("key", ["normal_motion.amplitude", "normal_stiffness"])
def test_load_of_a_contact_is_not_told_where_what_makes_it_is_swept(key):
    law = elastic_law(30.0, 2e4, 1.4, 2 * pi * 4)
    assert describe_friction(law, swept=[f"friction.{key}"]).endswith("load varying at 4 Hz")
    both = [f"friction.{key}", "friction.normal_motion.frequency"]
    assert "load" not in describe_friction(law, swept=both)


@pytest.mark.parametrize(
    ("table", "people"),
    [
        ("m/s2", "m/s²"),
        ("-", ""),
        ("N*s/m", "N·s/m"),
        ("(m/s2)2/Hz", "(m/s²)²/Hz"),
        ("m3", "m³"),
    ],
)
def test_unit_of_a_table_is_written_as_people_do(table, people):
    assert wording.format_unit(table) == people


def test_place_of_a_case_names_keys_by_their_last_word_unless_two_share_it():
    def axis(key, unit, *values):
        return Axis(key, unit, values)

    axes = [axis("excitation.frequency", "Hz", 1.6), axis("excitation.rms", "m/s2", 0.5)]
    point = {"excitation.frequency": 1.6, "excitation.rms": 0.5}
    assert describe_case(point, axes) == "frequency 1.6 Hz, rms 0.5 m/s²"
    twins = [axis("a.rms", "m", 0.003), axis("b.rms", "-", 2.0)]
    assert describe_case({"a.rms": 0.003, "b.rms": 2.0}, twins) == "a.rms 3 mm, b.rms 2"
    assert describe_axis(axis("a.b", "N", 1.0, 2.0)) == "a.b 1, 2 N"
    assert describe_axis(axis("a.b", "-", *range(9))) == "a.b 0 to 8 (9 values)"
    assert describe_axis(axis("a.b", "m", 0.01, 0.025)) == "a.b 10, 25 mm"


@pytest.mark.parametrize(
    ("low", "high", "unit", "text"),
    [
        (1.0, 2.5, "Hz", "1 to 2.5 Hz"),
        (1.0, 1.00001, "Hz", "1 Hz"),
        (0.25, 0.5, "-", "0.25 to 0.5"),
        (1.0, None, "Hz", "at least 1 Hz"),
        (None, 2.0, "", "at most 2"),
        (None, None, "Hz", "not known"),
        ("below 0.1 %", "5 %", "", "below 0.1 % to 5 %"),
    ],
)
def test_a_range_is_written_by_its_ends(low, high, unit, text):
    assert wording.format_range(low, high, unit) == text


@pytest.mark.parametrize(
    ("deviation", "half_width", "text"),
    [
        (0.84, None, "+84 %"),
        (-0.012345, None, "-1.23 %"),
        (0.0, None, "+0 %"),
        (12.345, None, "+1234 %"),
        (-0.012, 0.0035, "-1.20 ± 0.35 %"),
    ],
)
def test_a_deviation_has_its_sign(deviation, half_width, text):
    assert wording.format_deviation(deviation, half_width) == text
