"""Numbers with units, converted to SI."""

from __future__ import annotations

import re
import subprocess
import sys
from math import pi

import pytest

from drysim.quantity import Quantity
from drysim.units import QUANTITY_NAMES, conversion_factor, convert


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("25 mm", "m", 0.025),
        ("35mm", "m", 0.035),
        ("1.1 mm", "m", 0.0011),
        ("2.5e1 cm", "m", 0.25),
        ("0.05 g", "m/s²", 0.4903325),
        ("50 g", "kg", 0.05),
        ("2 m/s2", "m/s²", 2.0),
        ("2 m/s^2", "m/s2", 2.0),
        ("2 m s⁻²", "m/s²", 2.0),
        ("7.5 N/mm", "N/m", 7500.0),
        ("500 N·s/m", "N·s/m", 500.0),
        ("500 Ns/m", "N·s/m", 500.0),
        ("−15 N", "N", -15.0),
        ("40 %", "", 0.4),
        ("1.5 in", "m", 0.0381),
        ("96 rpm", "Hz", 1.6),
        ("7 1/min", "Hz", 7 / 60),
        ("1 rad/s", "Hz", 1 / (2 * pi)),
        ("90 deg", "rad", pi / 2),
        ("0.25 turn", "rad", pi / 2),
        ("5 stone", "kg", 31.7514659),
        ("3 kJ", "J", 3000.0),
        ("2 mg", "m/s²", 0.0196133),
        ("2 mg", "kg", 2e-6),
        ("2 µg", "m/s²", 1.96133e-5),
        ("2 μg", "m/s²", 1.96133e-5),
        ("2 µg", "kg", 2e-9),
        ("3 mG", "m/s²", 0.02941995),
        ("1 G", "m/s²", 9.80665),
        ("1 gn", "m/s²", 9.80665),
        ("980.665 gal", "m/s²", 9.80665),
        ("5 Gal", "m/s²", 0.05),
        ("3 mGal", "m/s²", 3e-5),
        ("1 rad", "rad", 1.0),
        ("75", "kg", 75.0),
        ("0 mm", "m", 0.0),
    ],
)
def test_text_with_a_unit_is_converted_and_rounded_once(text, unit, value):
    assert convert(text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "sentence"),
    [
        ("25 mn", "m", "unknown unit `mn`; did you mean `mm`?"),
        ("25 N", "m", "`N` is a unit of force, not length [m]"),
        ("1 g", "m/s", "`g` is a unit of mass or acceleration, not velocity [m/s]"),
        ("15 kn", "N", "`kn` is a unit of velocity, not force [N]; did you mean `kN`?"),
        ("3 deg", "", "`deg` is a unit of angle, not a plain number"),
        ("9 degC", "m", "unknown unit `degC`"),
        ("3 dB", "", "unknown unit `dB`"),
        ("2,5 mm", "m", "`2,5 mm` has a comma; write numbers with a decimal point"),
        ("1_000", "N", "must be a number [N] or a number with a unit, not `1_000`"),
        ("soft", "", "must be a number, not `soft`"),
        ("3 m**9**9**9", "m", "unknown unit `m**9**9**9`"),
    ],
)
def test_text_that_is_no_quantity_earns_a_sentence(text, unit, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)) as fault:
        convert(text, unit)
    assert str(fault.value) == sentence


def test_an_exponent_beyond_all_numbers_costs_no_time():
    assert convert("1e-999999999 mm", "m") == 0.0
    assert convert("1e999999999 mm", "m") == float("inf")


def test_a_quantity_that_is_too_large_in_its_own_unit_alone_is_not_finite():
    assert convert("-1e308 kN", "N") == float("-inf")
    with pytest.raises(ValueError, match="must be a finite number"):
        Quantity("N").read("1e308 kN")


@pytest.mark.parametrize("unit", [unit for unit in QUANTITY_NAMES if unit])
def test_a_unit_is_one_of_itself(unit):
    assert conversion_factor(unit, unit) == 1.0


def test_everyday_units_need_no_units_library():
    code = (
        "import sys; from drysim.units import convert\n"
        "for text, unit in [('25 mm', 'm'), ('0.05 g', 'm/s²'), ('90 deg', 'rad')]:\n"
        "    convert(text, unit)\n"
        "assert 'pint' not in sys.modules\n"
        "convert('1.5 in', 'm')\n"
        "assert 'pint' in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
