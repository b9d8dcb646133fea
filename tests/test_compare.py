"""Comparisons: the same base motion for all, and a verdict that was computed."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from law_scenes import elastic_law
from seat import dotted, rows_of

from drysim.approach import APPROACHES_BY_NAME
from drysim.core.model import BRISTLE, CoulombLaw, DynamicLaw
from drysim.errors import ScenarioError, UsageError
from drysim.plots.comparison import draw
from drysim.scenario.axes import Axis
from drysim.scenario.laws import LAWS
from drysim.scenario.load import scenario
from drysim.scenario.model import Scenario
from drysim.study.compare import (
    Comparison,
    Judgement,
    compare,
    describe_coinciding,
    describe_others,
    describe_region,
    judge,
    parse_names,
)
from drysim.study.ensemble import run
from drysim.study.statistics import FAILED, Row

SCENE = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
stroke: {limit: 25 mm}
excitation: {kind: harmonic, frequency: 5, rms: 0.5}
solver: {approach: stick-slip, step: 2.5e-3}
"""


def scene(overrides=(), text: str = SCENE) -> Scenario:
    """Return the paper's oscillator where it sticks half the time."""
    return scenario(text, overrides)


def of(comparison: Comparison, approach: str) -> float:
    """Return the deviation of an approach in a comparison of one case."""
    deviation = comparison.deviation(next(comparison.table.of(approach)))
    assert deviation is not None
    return deviation


def test_words_name_approaches_and_vs_is_dropped() -> None:
    assert parse_names(["signum", "vs", "stick-slip"]) == ("signum", "stick-slip")
    assert parse_names(["signum", "vs", "smooth", "vs", "stick-slip"])[-1] == "stick-slip"


@pytest.mark.parametrize(
    ("words", "sentence", "hint"),
    [
        (["signom", "vs", "stick-slip"], "unknown approach or friction law `signom`",
         "did you mean `signum`?"),
        (["lugra", "vs", "stick-slip"], "unknown approach or friction law `lugra`",
         "did you mean `lugre`?"),
        (["seat.yaml", "signum", "vs", "stick-slip"],
         "unknown approach or friction law `seat.yaml`",
         "name the scenario last: `drysim compare signum vs stick-slip seat.yaml`"),
        (["signum"], "needs two approaches", "add one of"),
        (["vs"], "needs two approaches", "give two of"),
        ((), "needs two approaches", "give two of"),
        (["signum", "vs", "signum"], "`signum` is named twice", "another"),
    ],
)  # fmt: skip
def test_words_that_name_no_comparison_are_said(
    words: list[str], sentence: str, hint: str
) -> None:
    with pytest.raises(UsageError, match=sentence) as fault:
        compare(scene(), *([words] if words else []))
    assert hint in fault.value.hint


def test_unknown_word_that_resembles_none_lists_all_approaches_and_laws() -> None:
    with pytest.raises(UsageError) as fault:
        parse_names(["nonsense", "vs", "stick-slip"])
    assert all(word in fault.value.hint for word in (*APPROACHES_BY_NAME, *LAWS))


def test_scenario_is_the_last_word_or_the_only_one_of_the_folder(drysim, seat):
    words = ("compare", "signum", "vs", "stick-slip")
    named = drysim(*words, "seat.yaml", "--dry-run")
    assert (named.code, named.err) == (0, "")
    twice = drysim(*words, "seat.yaml", "--scenario", "seat.yaml")
    assert twice.code == 2
    assert "two scenarios are named: seat.yaml and --scenario seat.yaml" in twice.err
    assert "seat.yaml: no such file" in drysim(*words, "none/seat.yaml").err.replace(
        "none/", ""
    )
    seat.with_name("other.yaml").write_text("services: {}\n")
    only = drysim(*words, "--dry-run")
    assert only.err == "seat.yaml is the only scenario in this folder\n"
    assert only.out == named.out
    seat.with_name("second.yml").write_text("oscillator: [")
    assert "using paper-random from the gallery" in drysim(*words, "--dry-run").err


@pytest.mark.parametrize(
    ("F_fk", "rms", "f", "signum", "tanh"),
    [(15, 0.5, 5, 1.8, -0.43), (45, 0.75, 2, 1.8, 0.71), (45, 0.5, 5, 24.0, -0.37),
     (45, 0.5, 1.6, 25.0, 0.32), (45, 0.33, 5, 84.0, -0.17)],
)  # fmt: skip
def test_approximations_are_off_by_what_is_known(
    F_fk: float, rms: float, f: float, signum: float, tanh: float
) -> None:
    case = {"friction.kinetic": F_fk, "excitation.rms": rms, "excitation.frequency": f}
    found = compare(scene(case), ("signum", "smooth", "stick-slip"))
    assert 100 * of(found, "signum") == pytest.approx(signum, abs=1.1)
    assert 100 * of(found, "smooth") == pytest.approx(tanh, abs=0.006)
    assert of(found, "stick-slip") == 0.0


def test_last_named_is_the_reference_and_viscous_is_added() -> None:
    found = compare(scene(), ("stick-slip", "moreau"))
    assert found.reference == "moreau"
    assert found.table.approaches == ("stick-slip", "moreau", "viscous")
    assert of(found, "moreau") == 0.0


@pytest.mark.parametrize("approach", ["stick-slip", "signum"])
def test_signum_is_told_to_chatter_beyond_the_help_of_a_smaller_step(approach: str) -> None:
    found = compare(scene({"solver.approach": approach}), ("signum", "stick-slip"))
    verdict = " ".join(found.verdict)
    assert found.verdict[0].startswith("signum deviates from stick-slip: T_a +2")
    assert "period 2Δt" in verdict
    assert "a smaller step does not help signum" in verdict
    # Viscous beside them is without dry friction by definition.
    assert not any(warning.slug == "left-out" for warning in found.table.warnings)


def test_switch_is_told_that_a_smaller_step_helps() -> None:
    found = compare(scene(), ("switch", "stick-slip"))
    verdict = " ".join(found.verdict)
    assert "half the step of switch leaves T_a " in verdict
    assert "2Δt" not in verdict


def test_dull_smoothing_is_told_the_sharpness_it_needs() -> None:
    dull = {"solver.smooth.sharpness": 100}
    found = compare(scene(dull), ("smooth", "stick-slip"))
    (sentence,) = (words for words in found.verdict if "needs a sharpness" in words)
    needed = float(sentence.split("about ")[1].split()[0])
    enough = compare(scene({"solver.smooth.sharpness": 2 * needed}), ("smooth", "stick-slip"))
    assert abs(of(enough, "smooth")) < 0.012


def test_no_sharpness_is_promised_where_none_helps() -> None:
    varied = {
        "friction.kinetic": 30,
        "friction.normal_variation": {"amplitude": 1.5, "frequency": 4},
    }
    found = compare(scene(varied), ("smooth", "stick-slip"))
    assert abs(of(found, "smooth")) > 0.05
    verdict = " ".join(found.verdict)
    assert "a sharper smooth does not help: 2000 s/m leaves T_a " in verdict
    assert "needs a sharpness" not in verdict


def range_of_agreement(comparison: Comparison) -> str:
    """Return the sentence on the cases in which two approaches agree."""
    (sentence,) = (words for words in comparison.verdict if "agrees within" in words)
    return sentence


@pytest.mark.parametrize(
    ("name", "forces", "told"),
    [("switch", [50, 15, 70], "in 2 of 3 cases: kinetic 50 to 70 N"),
     ("switch", [0, 15, 70], "in 2 of 3 cases: kinetic 0, 70 N"),
     ("switch", [50, 70, 15], "in 2 of 3 cases: kinetic 50 to 70 N"),
     ("signum", [15, 45], "in 1 of 2 cases: kinetic 15 N"),
     ("signum", [2, 15, 45], "in 2 of 3 cases: kinetic 2 to 15 N")],
)  # fmt: skip
def test_range_of_agreement_is_told_with_its_gaps(
    name: str, forces: list[float], told: str
) -> None:
    dull = {"excitation.rms": 0.33, "solver.switch": {"band": 0.02}}
    base = dull if name == "switch" else {"excitation.frequency": 2}
    found = compare(scene(base | {"sweep": {"friction.kinetic": forces}}), (name, "stick-slip"))
    assert range_of_agreement(found).endswith(told)


NOISY = """\
oscillator: {mass: 75, stiffness: 3500, damping: 250}
friction: {law: coulomb, kinetic: 20}
excitation: {kind: standard, class: EM6, duration: 20 s, seed: 1}
solver: {step: 2.5e-3, smooth: {sharpness: 30}}
measure: {direction: vertical}
sweep: {friction.kinetic: [0, 5, 10, 15, 20, 30, 45]}
"""


@pytest.mark.parametrize("name", ["signum", "smooth", "switch"])
def test_agreement_needs_T_a_stroke_and_SEAT_and_no_chatter(name: str) -> None:
    found = compare(scenario(NOISY), (name, "stick-slip"))
    exact = {row.point["friction.kinetic"]: row for row in found.table.of("stick-slip")}
    largest = max(row.metrics["x_r_peak"] for row in exact.values())
    good = []
    for row in found.table.of(name):
        own, theirs = row.metrics, exact[row.point["friction.kinetic"]].metrics
        peak = abs(own["x_r_peak"] - theirs["x_r_peak"])
        agrees = (
            abs(own["T_a"] / theirs["T_a"] - 1) <= 0.05
            and abs(own["SEAT"] / theirs["SEAT"] - 1) <= 0.05
            and peak <= 0.05 * max(theirs["x_r_peak"], 0.05 * largest)
            and own["chatter_share"] <= 0.01
        )
        good.append(agrees)
    assert [one.agrees for one in judge(found, name)] == good
    said = found.verdict[0].startswith(f"{name} agrees with")
    assert said == all(good)
    counted = rf"{name} agrees within 5 %( and without chatter)? in {sum(good) or 'no'} "
    assert all(good) or any(re.match(counted, words) for words in found.verdict)


def test_SEAT_that_deviates_is_named_where_T_a_agrees() -> None:
    found = compare(scenario(NOISY, {"sweep": None}), ("signum", "stick-slip"))
    # The chatter replaces in T_a what the friction should transmit; SEAT filters it out.
    assert abs(of(found, "signum")) < 0.05
    assert found.verdict[0].startswith("signum deviates from stick-slip: T_a +")
    assert "; SEAT -20" in found.verdict[0]
    assert any("leaves SEAT -" in sentence for sentence in found.verdict)


@pytest.mark.parametrize(
    ("others", "chatter", "beyond", "within"),
    [
        ({"x_r_peak": 0.01, "SEAT": -0.02}, 0.0, "", "peak |x_r| +1 %, SEAT -2 %"),
        ({"x_r_peak": 0.3, "SEAT": -0.02}, 0.0, "peak |x_r| +30 %", "SEAT -2 %"),
        ({}, 0.02, "chatter 2 %", ""),
        ({}, 0.01004, "", ""),  # shown as 1 %, which is allowed
    ],
)
def test_stroke_and_chatter_beyond_their_tolerance_are_named(others, chatter, beyond, within):
    judged = [Judgement(Row({}, "signum", 1.0, 1.0, {}), (0.0, None), others, chatter)]
    assert describe_others(judged, ()) == (beyond, within)
    assert judged[0].agrees == (not beyond)


def lying(good: list[int], count: int, keys: int = 1) -> str:
    """Describe where some cases of a sweep lie, at forces of 0, 1, 2 ... N by 2 masses."""
    axes = (Axis("friction.kinetic", "N", (0.0,)), Axis("oscillator.mass", "kg", (1.0,)))
    every = [
        Row({axes[0].key: at // keys, axes[1].key: 1 + at % keys}, "signum", 0.0, 0.0, {})
        for at in range(count)
    ]
    return describe_region([every[at] for at in good], every, axes)


def test_few_cases_that_agree_are_named_and_a_range_of_all_is_not() -> None:
    assert lying([0, 1, 2], 16) == ": kinetic 0 to 2 N"
    assert lying([0, 2, 15], 16) == ": kinetic 0, 2, 15 N"
    assert lying([0, 3], 4, keys=2) == ": kinetic 0 N, mass 1 kg; kinetic 1 N, mass 2 kg"
    assert lying([0, 1, 2, 4, 6, 8], 16) == ", all within kinetic 0 to 8 N"
    assert lying([0, 2, 4, 6, 8, 15], 16) == ", scattered over the whole sweep"
    assert lying([0, 1, 2, 3, 4, 5], 16, keys=2) == ": kinetic 0 to 2 N"


def test_an_approach_whose_numerics_fail_is_named_and_leaves_the_others() -> None:
    stiff = {"oscillator.stiffness": 7.5e9, "measure": {"duration": 1}}
    found = compare(scene(stiff), ("signum", "stick-slip"))
    assert set(found.responses) == {"stick-slip", "viscous"}
    assert found.table.exit_code() == 3
    (sentence,) = (
        warning.sentence for warning in found.table.warnings if warning.slug == "case-failed"
    )
    assert sentence.startswith("1 of 1 case by signum: failed; signum with a step of 0.0025 s")


def test_what_an_approach_leaves_out_is_a_caution_that_names_it() -> None:
    found = compare(scene({"friction.static_ratio": 1.2}), ("signum", "stick-slip"))
    sentences = [warning.sentence for warning in found.table.warnings]
    assert any("signum" in sentence and "static" in sentence for sentence in sentences)
    exact = next(found.table.of("stick-slip"))
    assert (exact.F_fk, exact.F_fs) == (45.0, 54.0)
    assert next(found.table.of("signum")).F_fs == 45.0


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (("stick-slip", "signum"), "signum uses fixed steps"),
        (("stick-slip", "moreau"), "moreau uses a constant normal force"),
        (("signum", "viscous"), "viscous ignores dry friction"),
    ],
)
def test_none_is_off_a_reference_that_may_be_off_itself(names, why) -> None:
    """The exact solution was `off: +97.5 %` against an approach that left the lift-off out."""
    varied = {"amplitude": 1.4, "frequency": 7}
    words = {"friction.normal_variation": varied} if "moreau" in names else {}
    found = compare(scene(words), names)
    assert not any(" deviates from" in words for words in found.verdict)
    first = found.verdict[0]
    assert first.startswith(f"{names[0]} differs from {names[-1]}: T_a ")
    assert f"; {why}" in first
    exact = compare(scene(words), names[::-1])
    assert any(words.startswith(f"{names[-1]} deviates from") for words in exact.verdict) == (
        names[0] == "stick-slip"
    )


# Comparisons of friction laws: their options, what they leave out, what is written.


LUGRE = "{stribeck_velocity: 5 mm/s, bristle_stiffness: 100 kN/m, bristle_damping: 300}"
LAWS_SCENE = f"""\
oscillator: {{mass: 75, stiffness: 7500, damping: 500}}
friction:
  law: coulomb
  kinetic: 45
  static_ratio: 1.2
  lugre: {LUGRE}
  dahl: {{bristle_stiffness: 60 kN/m, kinetic: 40}}
  jenkins: {{tangential_stiffness: 45 kN/m}}
stroke: {{limit: 25 mm}}
excitation: {{kind: harmonic, frequency: 2, rms: 0.75}}
solver: {{step: 2.5e-3}}
"""


def laws_scene(overrides=(), text: str = LAWS_SCENE) -> Scenario:
    """Return the paper's oscillator with options of other laws."""
    return scenario(text, overrides)


PRESSED = {"mu_kinetic": 0.1, "normal": 300, "bristle_stiffness": 1e5}


def law_of(name: str, **changes: object) -> object:
    return laws_scene(dotted(changes)).with_law(name).law()


def test_no_word_means_both_an_approach_and_a_law():
    assert not APPROACHES_BY_NAME.keys() & LAWS.keys()


@pytest.mark.parametrize(
    ("law", "changes", "expected"),
    [
        ("lugre", {}, DynamicLaw(45, 54, BRISTLE, 5e-3, 2, 1e5, 300.0)),
        ("jenkins", {}, elastic_law(45, 45e3)),
        ("dahl", {}, DynamicLaw(40, 40, BRISTLE, sigma_0=60e3)),
        ("coulomb", {}, CoulombLaw(45, 54)),
        ("dahl", {"friction__dahl": PRESSED}, DynamicLaw(30, 30, BRISTLE, sigma_0=1e5)),
    ],
    ids=["forces of the block", "own key", "option instead of a key", "law of the file",
         "option that excludes keys"],
)  # fmt: skip
def test_law_of_a_word_has_the_keys_of_the_block_and_its_options(law, changes, expected):
    assert law_of(law, **changes) == pytest.approx(expected)


class TestOptions:
    def test_options_do_not_touch_a_run(self):
        options = dict.fromkeys(("friction.lugre", "friction.dahl", "friction.jenkins"))
        assert run(laws_scene()).metrics == run(laws_scene(options)).metrics

    def test_options_of_the_own_law_are_read_as_keys_of_the_block(self):
        other = laws_scene({"friction.law": "lugre"})
        assert other.law() == law_of("lugre")

    def test_resolved_scenario_holds_the_options_and_is_read_again(self):
        words = laws_scene().resolved()
        assert words["friction"]["dahl"] == {"bristle_stiffness": 60e3, "kinetic": 40.0}
        assert scenario(words).resolved() == words

    @pytest.mark.parametrize(
        ("law", "changes", "sentence"),
        [
            ("", {"friction.dahl.bristle_stiffness": -1},
             "friction.dahl.bristle_stiffness must be above 0 N/m, not -1"),
            ("", {"friction.law": "lugre",
                  "sweep": {"friction.lugre.bristle_damping": [1, 2]}},
             "did you mean `friction.bristle_damping`?"),
            ("dahl", {"friction.dahl": None},
             "law dahl needs friction.dahl.bristle_stiffness [N/m]: give it in a block"),
            ("petrov-ewins", {},
             "law petrov-ewins needs friction.petrov-ewins.mu_kinetic [-], "
             "friction.petrov-ewins.normal [N] and "
             "friction.petrov-ewins.tangential_stiffness [N/m]: "
             "give them in a block `petrov-ewins` in friction"),
            ("lugre", {"friction.lugre.static": 30},
             "friction as lugre: static must be at least the kinetic 45 N, not 30 N"),
            ("lugre", {"friction": None}, "needs a friction block"),
            ("", {"solver.approach": "lugre"},
             "`lugre`; it is a friction law: set friction.law"),
        ],
    )  # fmt: skip
    def test_faulty_option_is_said_where_it_stands(self, law, changes, sentence):
        with pytest.raises(ScenarioError) as fault:
            laws_scene(changes).with_law(law)
        (problem,) = fault.value.problems
        assert sentence in problem.sentence
        assert law != "petrov-ewins" or problem.line == 2


NOISE = {"kind": "psd", "points": [[0.5, 1], [10, 1]], "rms": 0.6, "duration": 3}


@pytest.fixture
def laws_file(tmp_path: Path) -> Path:
    """Write the scene with options of other laws."""
    file = tmp_path / "scene.yaml"
    file.write_text(LAWS_SCENE)
    return file


class TestComparison:
    def test_laws_are_rows_of_their_own_solved_as_if_named_in_the_file(self):
        found = compare(laws_scene(), ("lugre", "dahl", "coulomb"))
        assert found.table.approaches == ("lugre", "dahl", "coulomb", "viscous")
        for name in ("lugre", "dahl"):
            (row,) = found.table.of(name)
            alone = run(laws_scene({"friction.law": name, **LESS.get(name, {})}))
            assert row.metrics["T_a"] == alone.metrics["T_a"]
        assert found.laws == {
            "lugre": "lugre", "dahl": "dahl", "coulomb": "coulomb", "viscous": ""
        }  # fmt: skip

    def test_same_law_by_two_words_is_said_to_be_one(self):
        found = compare(laws_scene(), ("coulomb", "lugre", "stick-slip"))
        (coulomb,), (exact,) = found.table.of("coulomb"), found.table.of("stick-slip")
        assert coulomb.metrics == exact.metrics
        assert "coulomb and stick-slip are the same here" in " ".join(found.verdict)

    def test_other_law_is_no_error(self):
        found = compare(laws_scene(), ("lugre", "signum", "stick-slip"))
        verdict = " ".join(found.verdict)
        assert "lugre deviates" not in verdict
        assert "lugre differs from" in verdict or "lugre agrees with" in verdict

    def test_all_words_get_the_very_same_motion(self):
        noise = NOISE | {"seed": 3}
        words = ("lugre", "jenkins", "signum", "moreau", "stick-slip")
        found = compare(laws_scene({"excitation": noise, "friction.static_ratio": 1}), words)
        first, *others = found.responses.values()
        for other in others:
            assert np.array_equal(first.u_dd, other.u_dd)

    def test_what_a_law_leaves_out_is_a_caution(self):
        varied = {"friction.normal_variation": {"amplitude": 0.2, "frequency": 1}}
        found = compare(laws_scene(varied), ("jenkins", "lugre", "stick-slip"))
        sentences = {warning.sentence for warning in found.table.warnings}
        assert sentences >= {
            "lugre ignores friction.normal_variation",
            "jenkins has no static limit above kinetic friction and uses F_fs = F_fk",
        }

    def test_sweep_goes_over_the_words_that_have_use_for_it(self):
        keys = {"friction.kinetic": [30, 45], "friction.lugre.bristle_stiffness": [1e5, 2e5]}
        found = compare(laws_scene({"sweep": keys}), ("dahl", "lugre", "stick-slip"))
        sizes = {name: len(list(found.table.of(name))) for name in found.table.approaches}
        assert sizes == {"dahl": 1, "lugre": 4, "stick-slip": 2, "viscous": 1}
        T_a = {row.metrics["T_a"] for row in found.table.of("lugre")}
        assert len(T_a) == 4

    def test_key_that_only_the_reference_has_use_for_leaves_no_gap_in_the_verdict(self):
        swept = {"sweep": {"friction.lugre.bristle_stiffness": [1e4, 1e5, 1e6]}}
        found = compare(laws_scene(swept), ("coulomb", "stick-slip", "lugre"))
        verdict = " ".join(found.verdict)
        assert "coulomb differs from lugre: T_a" in verdict
        assert "coulomb agrees within 5 % in no case" in verdict
        assert found.shown.keys() == {"friction.lugre.bristle_stiffness"}

    def test_case_shown_is_one_at_which_a_word_is_off(self):
        swept = {"sweep": {"excitation.frequency": [0.5, 2, 8]}}
        found = compare(laws_scene(swept), ("coulomb", "jenkins", "stick-slip"))
        worst = max(found.table.of("jenkins"), key=lambda row: abs(found.deviation(row)))
        assert found.shown == worst.point

    def test_point_at_which_a_law_breaks_its_rules_is_found_before_the_work(self):
        swept = {"sweep": {"friction.kinetic": [30, 60]}, "friction.lugre.static": 50}
        with pytest.raises(ScenarioError) as fault:
            compare(laws_scene(swept), ("lugre", "stick-slip"))
        assert "at least the kinetic 60 N, not 50 N" in fault.value.problems[0].sentence
        assert "friction.kinetic = 60" in fault.value.problems[0].sentence

    def test_law_is_called_by_its_name_where_its_seeds_are_measured_together(
        self, laws_file, process
    ):
        """Rows of a block were called by the approach, a word that the table did not know."""
        noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.6, duration: 3, seeds: 8}"
        words = ("compare", "dahl", "vs", "coulomb", "-s", laws_file, "--no-plots")
        answer = process(*words, "--set", f"excitation={noise}", DRYSIM_ENGINE="compiled")
        assert answer.code == 0, answer.err
        rows = rows_of(laws_file.parent / "out/scene-compare/comparison.csv")
        assert [row["approach"] for row in rows] == ["dahl", "coulomb", "viscous"]

    def test_seeds_are_compared_in_pairs(self):
        seeds = {"excitation": NOISE | {"seeds": 3}}
        comparison = compare(laws_scene(seeds), ("lugre", "jenkins", "stick-slip"))
        (row,) = comparison.table.of("lugre")
        off, half_width = comparison.off(row)
        assert row.seeds == 3
        assert half_width > 0
        assert off == pytest.approx(0, abs=0.2)


LESS = {"dahl": {"friction.static_ratio": None}}
"""What a law of the file may not say beside its own options."""


class TestFiles:
    def test_table_tells_word_and_law(self, drysim, laws_file):
        done = drysim("compare", "lugre vs signum vs stick-slip", laws_file, "--json")
        assert done.code == 0
        rows = rows_of("out/scene-compare/comparison.csv")
        assert [(row["approach"], row["law"]) for row in rows] == [
            ("lugre", "lugre"), ("signum", "coulomb"), ("stick-slip", "coulomb"),
            ("viscous", ""),
        ]  # fmt: skip
        told = json.loads(done.out)
        assert told["numerics"]["laws"]["lugre"] == "lugre"
        assert "lugre" in told["metrics"]

    def test_override_reaches_an_option(self, drysim, laws_file):
        stiff = ["--set", "friction.jenkins.tangential_stiffness=90 kN/m", "--no-plots"]
        done = drysim("compare", "jenkins vs stick-slip", laws_file, *stiff)
        assert "90000 N/m" in done.out

    def test_missing_key_ends_with_nothing_computed(self, refused, laws_file):
        error = refused("compare", "stribeck vs stick-slip", laws_file)
        assert "friction.stribeck.stribeck_velocity [m/s]" in error


@pytest.mark.parametrize(
    "approach", [name for name in APPROACHES_BY_NAME if name not in ("stick-slip", "viscous")]
)
@pytest.mark.parametrize("law", ["jenkins", "dahl"])
def test_fixed_steps_refuse_every_law_but_coulombs(law, approach):
    changes = {"friction.law": law, "friction.static_ratio": None, "solver.approach": approach}
    with pytest.raises(ScenarioError) as fault:
        laws_scene(changes)
    assert "supports Coulomb friction only" in fault.value.problems[0].sentence


def test_laws_that_move_the_mass_alike_are_said_to_coincide():
    contact = {"tangential_stiffness": 45e3, "mu_kinetic": 0.1, "normal": 450}
    changes = {"friction.petrov-ewins": contact}
    told = "jenkins and petrov-ewins coincide"
    made = compare(laws_scene(changes), "jenkins dahl petrov-ewins vs coulomb")
    assert made.verdict.count(told) == 1
    assert sum(told in text.get_text() for text in draw(made).texts) == 1
    contact["tangential_stiffness"] = 45.1e3
    made = compare(laws_scene(changes), "jenkins dahl petrov-ewins vs coulomb")
    assert not any("coincide" in sentence for sentence in made.verdict)


def test_words_of_which_nothing_is_known_do_not_coincide():
    made = compare(
        laws_scene({"sweep": {"friction.kinetic": [30, 45]}}), "signum switch vs moreau"
    )
    rows = tuple(replace(row, metrics={}, status=FAILED) for row in made.table.rows)
    assert not [
        *describe_coinciding(replace(made, table=replace(made.table, rows=rows, summary={})))
    ]
