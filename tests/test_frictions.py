"""Friction in words: Coulomb's in particular, and what laws beyond his refuse."""

from __future__ import annotations

from math import pi

import pytest
from pydantic import ValidationError

from drysim.core.model import Law
from drysim.friction.coulomb import Coulomb
from drysim.friction.dynamic import Dahl, Leuven, Lugre, Stribeck
from drysim.friction.elastic import Jenkins, PetrovEwins

WORDS = {
    Stribeck: {"law": "stribeck", "kinetic": 15, "static": 18, "stribeck_velocity": "5 mm/s"},
    Jenkins: {"law": "jenkins", "kinetic": 15, "tangential_stiffness": "100 kN/m"},
    PetrovEwins: {
        "law": "petrov-ewins",
        "mu_kinetic": 0.3,
        "normal": 150,
        "tangential_stiffness": 1e5,
        "normal_stiffness": 1e5,
        "normal_motion": {"amplitude": "2 mm", "frequency": 4},
    },
    Dahl: {"law": "dahl", "kinetic": 15, "bristle_stiffness": "100 kN/m"},
    Lugre: {
        "law": "lugre",
        "mu_kinetic": 0.02,
        "static_ratio": 1.2,
        "stribeck_velocity": 5e-3,
        "bristle_stiffness": 1e5,
        "bristle_damping": 300,
    },
    Leuven: {
        "law": "leuven",
        "kinetic": 15,
        "static": 18,
        "stribeck_velocity": 5e-3,
        "bristle_stiffness": 1e5,
        "transition": 3,
        "bristle_damping": 0,
    },
}
M = 75.0


def coulomb(**words: object) -> Coulomb:
    return Coulomb.model_validate({"law": "coulomb", **words})


def test_static_limit_defaults_to_kinetic_friction():
    friction = coulomb(kinetic=45)
    assert friction.limits(M) == Law(45.0, 45.0)
    assert not friction.static_given
    assert friction.spelled_out(M)["static_ratio"] == 1.0


@pytest.mark.parametrize(
    "static", [{"static": 54}, {"static": "0.054 kN"}, {"static_ratio": 1.2}]
)
def test_static_limit_is_a_force_or_a_ratio(static):
    friction = coulomb(kinetic=45, **static)
    assert friction.limits(M) == Law(45.0, 54.0)
    assert friction.static_given


def test_coefficients_work_on_the_weight():
    friction = coulomb(mu_kinetic=0.02, mu_static=0.03)
    assert friction.limits(M) == Law(0.02 * 735.75, 0.03 * 735.75)
    assert friction.spelled_out(M)["normal"] == 735.75


def test_coefficients_work_on_the_normal_force_when_it_is_given():
    assert coulomb(mu_kinetic=0.5, normal=100).limits(M) == Law(50.0, 50.0)
    assert coulomb(mu_kinetic=0.5, normal=100, static_ratio=2).limits(M) == Law(50.0, 100.0)


def test_varying_normal_force_keeps_its_sine():
    varied = {"amplitude": 0.4, "frequency": 1.7, "phase": "90 deg"}
    law = coulomb(kinetic=30, static=40, normal_variation=varied).limits(M)
    assert law == Law(30.0, 40.0, 0.4, 2 * pi * 1.7, pi / 2)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"kinetic": 15, "static": 12}, "must be at least the kinetic 15 N, not 12 N"),
        ({"mu_kinetic": 0.3, "mu_static": 0.2}, "must be at least the kinetic 0.3, not 0.2"),
        ({"kinetic": 15, "static_ratio": 0.9}, "must be at least 1, not 0.9"),
    ],
)
def test_static_below_kinetic_is_refused(words, sentence):
    with pytest.raises(ValidationError, match=sentence):
        coulomb(**words)


@pytest.mark.parametrize("law", [Stribeck, Jenkins, Dahl, Lugre, Leuven])
@pytest.mark.parametrize("zero", ["kinetic", "mu_kinetic", "normal"])
def test_a_law_that_yields_at_a_force_of_zero_is_refused(law, zero):
    words = {**WORDS[law], "mu_kinetic": 0.02, "normal": 500, zero: 0}
    for name in ("static", "static_ratio", "mu_kinetic" if zero == "kinetic" else "kinetic"):
        words.pop(name, None)
    if zero == "kinetic":
        words.pop("normal")
    with pytest.raises(ValidationError, match=f"must be above 0 under law `{words['law']}`"):
        law.model_validate(words)


@pytest.mark.parametrize(("exponent", "sentence"), [(0.4, "at least 0.5"), (20, "below 20")])
def test_exponent_out_of_its_range_is_refused_with_what_is_allowed(exponent, sentence):
    with pytest.raises(ValidationError, match=sentence):
        Stribeck.model_validate({**WORDS[Stribeck], "exponent": exponent})


def test_exponent_between_is_taken():
    law = Stribeck.model_validate({**WORDS[Stribeck], "exponent": 0.75}).limits(M)
    assert law.exponent == 0.75
