"""What a mistyped word meant."""

from __future__ import annotations

import pytest

from drysim.messages import closest_match


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("stifness", "stiffness"),
        ("Mass", "mass"),
        ("damp", "damping"),
        ("dampign", "damping"),
        ("static-ratio", "static_ratio"),
        ("colour", None),
        ("b", None),
    ],
)
def test_near_name_is_the_word_that_was_meant(written, meant):
    known = ["mass", "stiffness", "damping", "damping_ratio", "static", "static_ratio"]
    assert closest_match(written, known) == meant


def test_a_single_letter_is_no_slip_of_another():
    assert closest_match("I", "ABCDEFGH") is None
    assert closest_match("c", "ABCDEFGH") == "C"
