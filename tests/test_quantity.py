"""Fields with a unit: which values they accept."""

from __future__ import annotations

import re

import pytest

from drysim.quantity import Quantity


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (True, "must be a number [N], not true"),
        (None, "must be a number [N], not nothing"),
        ([1], "must be a number [N], not a list"),
        (float("nan"), "must be a finite number [N], not nan"),
        ("1e999 N", "must be a finite number [N], not `1e999 N`"),
        (-15, "must be at least 0 N, not -15"),
        ("-0.1 kN", "must be at least 0 N, not `-0.1 kN`"),
        (100.0, "must be below 100 N, not 100"),
        (1e-31, "must be 0 or between 1e-30 and 1e+30 N in magnitude, not 1e-31"),
    ],
)
def test_value_outside_its_field_earns_a_sentence(given, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)) as fault:
        Quantity("N", at_least=0, below=100).read(given)
    assert str(fault.value) == sentence


@pytest.mark.parametrize("given", [1e31, -1e300, "1e28 t", -5e-324])
def test_a_size_whose_squares_leave_doubles_is_refused(given):
    with pytest.raises(
        ValueError, match="must be 0 or between 1e-30 and 1e\\+30 kg in magnitude"
    ):
        Quantity("kg").read(given)


@pytest.mark.parametrize("given", [0.0, 1e30, -1e-30])
def test_a_size_at_the_ends_of_its_span_is_taken(given):
    assert Quantity("kg").read(given) == given


def test_an_integer_beyond_doubles_is_not_finite():
    with pytest.raises(ValueError, match="must be a finite number"):
        Quantity("kg").read(10**400)
