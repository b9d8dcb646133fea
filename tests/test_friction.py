"""Friction in words: Coulomb's in particular, and what laws beyond his refuse."""

from __future__ import annotations

import inspect
import re
from math import pi
from pathlib import Path

import numpy as np
import pytest
from law_scenes import PAPER, mirrored, noise, sine, solved
from pydantic import ValidationError

from drysim.approach import APPROACHES_BY_NAME
from drysim.approach.stick_slip import ExactApproach, StickSlip
from drysim.block import field_descriptions
from drysim.core.model import CoulombLaw
from drysim.errors import ScenarioError
from drysim.friction import (
    FRICTION_LAWS,
    Coulomb,
    Dahl,
    Jenkins,
    Leuven,
    Lugre,
    Stribeck,
)
from drysim.manual import pages
from drysim.metrics.table import measure
from drysim.quantity import Quantity
from drysim.scenario.keys import numeric_keys
from drysim.scenario.laws import LAWS
from drysim.scenario.load import load

BRISTLES = {"stribeck_velocity": 5e-3, "bristle_stiffness": 1e5}
WORDS = {
    Stribeck: {"law": "stribeck", "kinetic": 15, "static": 18, "stribeck_velocity": "5 mm/s"},
    Jenkins: {"law": "jenkins", "kinetic": 15, "tangential_stiffness": "100 kN/m"},
    Dahl: {"law": "dahl", "kinetic": 15, "bristle_stiffness": "100 kN/m"},
    Lugre: {"law": "lugre", "static_ratio": 1.2, "bristle_damping": 300, **BRISTLES},
    Leuven: {"law": "leuven", "transition": 3, "bristle_damping": 0, **BRISTLES},
}
M = 75.0


def coulomb(**words: object) -> Coulomb:
    return Coulomb.model_validate({"law": "coulomb", **words})


VARIED = {"amplitude": 0.4, "frequency": 1.7, "phase": "90 deg"}


@pytest.mark.parametrize(
    ("words", "law", "defaults"),
    [
        ({"kinetic": 45}, CoulombLaw(45.0, 45.0), {"static_ratio": 1.0}),
        ({"kinetic": 45, "static": 54}, CoulombLaw(45.0, 54.0), {}),
        ({"kinetic": 45, "static": "0.054 kN"}, CoulombLaw(45.0, 54.0), {}),
        ({"kinetic": 45, "static_ratio": 1.2}, CoulombLaw(45.0, 54.0), {}),
        ({"mu_kinetic": 0.02, "mu_static": 0.03}, CoulombLaw(0.02 * 735.75, 0.03 * 735.75),
         {"normal": 735.75}),
        ({"mu_kinetic": 0.5, "normal": 100}, CoulombLaw(50.0, 50.0), {"static_ratio": 1.0}),
        ({"mu_kinetic": 0.5, "normal": 100, "static_ratio": 2}, CoulombLaw(50.0, 100.0), {}),
        ({"kinetic": 30, "static": 40, "normal_variation": VARIED},
         CoulombLaw(30.0, 40.0, 0.4, 2 * pi * 1.7, pi / 2), {}),
    ],
)  # fmt: skip
def test_forces_or_coefficients_with_defaults_give_coulombs_law(words, law, defaults):
    friction = coulomb(**words)
    assert friction.to_law(M) == law
    assert friction.with_defaults(M).items() >= defaults.items()
    assert friction.static_given == bool(words.keys() & {"static", "static_ratio", "mu_static"})


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            {"kinetic": 15, "static": 12},
            "must be at least the kinetic 15 N, not 12 N; `static_ratio` in its place",
        ),
        ({"mu_kinetic": 0.3, "mu_static": 0.2}, "must be at least the kinetic 0.3, not 0.2"),
        ({"kinetic": 15, "static_ratio": 0.9}, "must be at least 1, not 0.9"),
    ],
)
def test_static_below_kinetic_is_refused(words, sentence):
    with pytest.raises(ValidationError, match=sentence):
        coulomb(**words)


@pytest.mark.parametrize("law", WORDS)
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
    law = Stribeck.model_validate({**WORDS[Stribeck], "exponent": 0.75}).to_law(M)
    assert law.exponent == 0.75


# What every law on the shelf keeps, taken from its scenario in the gallery.


ROOT = Path(__file__).parents[1]
LAWS_PAGE, KEYS_PAGE = (pages()[name].text for name in ("friction", "keys"))
LAW_M = PAPER.m
STEPPING = [
    name for name, one in APPROACHES_BY_NAME.items() if not issubclass(one, ExactApproach)
]
CLOSED = 1e-10
"""Residual of the energy of a law that is followed by a series: its tolerance is 1e-12."""

MOTIONS = {"sine": sine(1.0, 1.6), "noise": noise(1200, 0.8)}


def file_of(name: str) -> Path:
    return ROOT / "scenarios" / f"friction-{name}.yaml"


@pytest.fixture(params=LAWS)
def name(request):
    """Return the name of every law."""
    return request.param


@pytest.fixture
def friction(name):
    """Return the friction of a law as its scenario in the gallery has it."""
    return load(file_of(name)).friction


@pytest.fixture(params=MOTIONS)
def response(request, friction):
    """Return the motion of the paper's oscillator under a law."""
    return solved(friction.to_law(LAW_M), MOTIONS[request.param], duration=2.9)


def problems(name: str, **changes: object) -> list[str]:
    """Return the messages on the scenario of a law with other values in its friction block."""
    with pytest.raises(ScenarioError) as fault:
        load(file_of(name), {f"friction.{key}": value for key, value in changes.items()})
    assert all("friction." in problem.key for problem in fault.value.problems)
    return [problem.sentence for problem in fault.value.problems]


class TestWords:
    def test_formula_and_source_stand_in_the_docstring(self, name):
        about, _, notes = inspect.getdoc(LAWS[name]).partition("Notes\n-----\n")
        assert "Not to be confused with" in about
        assert "=" in notes
        assert re.search(r"\(\d{4}\)", notes), "no source with its year"

    def test_every_field_is_documented_and_says_its_unit(self, name):
        texts = field_descriptions(LAWS[name])
        for key, field in LAWS[name].model_fields.items():
            assert texts[key]
            for unit in (part.unit for part in field.metadata if isinstance(part, Quantity)):
                assert f"[{unit or '-'}]" in texts[key], key

    def test_words_spelled_out_mean_the_same_law(self, friction):
        words = friction.with_defaults(LAW_M)
        assert type(friction).model_validate(words).to_law(LAW_M) == friction.to_law(LAW_M)

    def test_law_is_told_by_its_name_and_its_own_keys(self, name):
        scenario = load(file_of(name))
        own = set(LAWS[name].symbols) if name != "coulomb" else set()
        told = " ".join(scenario.terms)
        assert told.startswith(f"law {name} ") or name == "coulomb"
        for key in own:
            if getattr(scenario.friction, key) != LAWS[name].model_fields[key].default:
                assert f"{LAWS[name].symbols[key]} " in told

    def test_symbols_are_those_of_keys(self, name):
        assert getattr(LAWS[name], "symbols", {}).keys() <= LAWS[name].model_fields.keys()

    def test_readme_tells_the_law_its_keys_and_shows_its_loop(self, name):
        assert f"| `{name}` |" in LAWS_PAGE
        assert f"loops/friction-{name}.png" in LAWS_PAGE
        assert f"## `friction` with `law: {name}`" in KEYS_PAGE


class TestFaults:
    def test_number_below_its_bound_is_refused(self, name):
        known = numeric_keys(LAWS[name], {})
        bounded = [
            key for key, numeral in known.items()
            if numeral and numeral.quantity and (numeral.quantity.at_least is not None
                                                 or numeral.quantity.above is not None)
            and "." not in key
        ]  # fmt: skip
        assert bounded
        for key in bounded:
            given = load(file_of(name)).friction
            if getattr(given, key) is None:
                continue  # it would clash with what stands in its place
            (sentence,) = problems(name, **{key: -1})
            assert sentence.startswith(f"friction.{key} must be ")

    def test_what_must_be_above_zero_is_not_zero(self, name):
        given = load(file_of(name)).friction
        for key, numeral in numeric_keys(LAWS[name], {}).items():
            above = numeral.quantity.above if numeral and numeral.quantity else None
            if above is None or "." in key or getattr(given, key) is None:
                continue
            (sentence,) = problems(name, **{key: above})
            assert sentence.startswith(f"friction.{key} must be above ")

    def test_static_limit_below_kinetic_friction_is_refused(self, name):
        if "static" not in LAWS[name].model_fields:
            pytest.skip("one limit serves both")
        (sentence,) = problems(name, static=1.0, static_ratio=None)
        assert sentence.startswith("friction.static must be at least the kinetic ")

    def test_key_without_the_one_that_it_needs_is_refused(self, name):
        given = load(file_of(name)).friction
        for key, other in LAWS[name].needs.items():
            if getattr(given, key) is None or getattr(given, other) is None:
                continue
            (sentence,) = problems(name, **{other: None})
            assert sentence == f"friction.{key} requires {other}"

    def test_key_of_another_law_names_the_laws_that_have_it(self, name):
        others = {key for law in FRICTION_LAWS for key in law.model_fields}
        for key in sorted(others - LAWS[name].model_fields.keys()):
            (sentence,) = problems(name, **{key: 1})
            told = f"unknown key `{key}` in friction of law {name}; it belongs"
            assert sentence.startswith(told)
            for other in LAWS.keys() - {name}:
                is_named = bool(re.search(rf"\b{other}\b", sentence[50:]))
                assert is_named == (key in LAWS[other].model_fields)

    @pytest.mark.parametrize("approach", STEPPING)
    def test_fixed_steps_know_coulombs_friction_only(self, name, approach):
        law = load(file_of(name)).law()
        if isinstance(law, CoulombLaw) and law.F_fs == law.F_fk:
            pytest.skip("every approach can use it")
        if name == "coulomb" and APPROACHES_BY_NAME[approach].supports_static:
            pytest.skip("it knows a static limit")
        with pytest.raises(ScenarioError) as fault:
            load(file_of(name), {"solver.approach": approach})
        assert f"approach {approach} " in fault.value.problems[0].sentence


class TestMotion:
    def test_energy_closes_and_friction_takes(self, response):
        metrics = measure(response.trajectory, (0.7, 2.9), None)
        assert metrics["energy_residual"] < CLOSED
        assert metrics["energy_friction"] > 0

    def test_force_is_against_sliding_where_nothing_yields(self, response):
        if not response.law.can_stick:
            pytest.skip("a contact that yields gives back what it has stored")
        assert (response.F_f * response.v_r >= 0.0).all()
        assert (response.v_r[response.stuck] == 0.0).all()
        F_L = PAPER.m * response.u_dd + PAPER.k_x * response.x_r
        limit = response.law.F_fs * (1.0 + 1e-12)
        assert (np.abs(F_L[response.stuck]) <= limit).all()

    def test_contact_that_yields_never_counts_as_stuck(self, response):
        if not response.law.can_stick:
            assert not response.stuck.any()

    def test_mirrored_base_motion_gives_the_mirrored_response_bit_for_bit(self, friction):
        for motion in MOTIONS.values():
            one, two = (
                solved(friction.to_law(LAW_M), each, duration=1.5)
                for each in (motion, mirrored(motion))
            )
            assert (one.x_r == -two.x_r).all()
            assert (one.F_f == -two.F_f).all()

    def test_solution_says_its_core_and_why(self, response):
        assert response.numerics.core
        assert response.numerics.why

    def test_error_is_stated_where_there_is_one(self, friction, response):
        asked = "tolerance" in type(friction).model_fields
        assert (response.numerics.error is not None) == asked
        assert (response.numerics.error or 0.0) < 1e-8

    def test_static_limit_is_never_below_kinetic_friction(self, friction):
        law = friction.to_law(LAW_M)
        assert law.F_fs >= law.F_fk > 0


def test_every_law_is_solved_by_the_approach_that_comparisons_take():
    assert StickSlip.supports_dynamic
    assert StickSlip.supports_static
    assert StickSlip.supports_variation


def test_shelf_holds_every_law_once():
    assert len(LAWS) == len(FRICTION_LAWS)
    assert LAWS["coulomb"] is Coulomb
