"""Comparisons of friction laws: their options, what they leave out, what is written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drysim.approach import SHELF
from drysim.cli import main
from drysim.core.model import BRISTLE, Dynamic, Law, Slider
from drysim.errors import ScenarioError, UsageError
from drysim.plots.comparison import draw
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.scenario.reading import LAWS
from drysim.study.compare import coinciding, compare, named
from drysim.study.ensemble import run
from drysim.study.rows import FAILED
from seat import rows_of

LUGRE = "{stribeck_velocity: 5 mm/s, bristle_stiffness: 100 kN/m, bristle_damping: 300}"
SCENE = f"""\
drysim: 1
name: scene
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


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Write the paper's oscillator with options of other laws."""
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    return file


def law_of(scene: Path, name: str, **changes: object) -> object:
    return load(scene, changes).with_law(name).law()


def test_no_word_means_both_an_approach_and_a_law():
    assert not SHELF.keys() & LAWS.keys()


def test_unknown_word_is_held_against_both_shelves():
    with pytest.raises(UsageError, match="no approach or friction law `lugra`") as fault:
        named(["lugra", "vs", "stick-slip"])
    assert fault.value.hint == "did you mean `lugre`?"
    with pytest.raises(UsageError) as fault:
        named(["nonsense", "vs", "stick-slip"])
    for word in (*SHELF, *LAWS):
        assert word in fault.value.hint


class TestOptions:
    def test_law_shares_the_forces_of_the_block(self, scene):
        assert law_of(scene, "lugre") == Dynamic(45, 54, BRISTLE, 5e-3, 2, 1e5, 300.0)
        assert law_of(scene, "jenkins") == Slider(45, 45e3)

    def test_option_of_a_law_stands_for_the_key_of_the_block(self, scene):
        assert law_of(scene, "dahl").F_fk == 40

    def test_option_stands_for_the_keys_that_it_excludes(self, scene):
        law = law_of(scene, "dahl", **{"friction.dahl": {"mu_kinetic": 0.1, "normal": 300,
                                                        "bristle_stiffness": 1e5}})  # fmt: skip
        assert law.F_fk == pytest.approx(30)

    def test_law_of_the_scene_is_what_it_was(self, scene):
        assert law_of(scene, "coulomb") == Law(45, 54)

    def test_options_do_not_touch_a_run(self, scene):
        plain = scene.with_name("plain.yaml")
        plain.write_text("".join(
            line for line in SCENE.splitlines(True) if "{bristle" not in line
            and "{tang" not in line and "{strib" not in line
        ))  # fmt: skip
        with_options, without = run(load(scene)), run(load(plain))
        assert with_options.metrics == without.metrics

    def test_options_of_the_own_law_are_read_as_keys_of_the_block(self, scene):
        other = load(scene, {"friction.law": "lugre"})
        assert other.law() == load(scene).with_law("lugre").law()

    def test_resolved_scenario_holds_the_options_and_is_read_again(self, scene, tmp_path):
        words = load(scene).resolved()
        assert words["friction"]["dahl"] == {"bristle_stiffness": 60e3, "kinetic": 40.0}
        again = tmp_path / "again.yaml"
        again.write_text(json.dumps(words))
        assert load(again).resolved() == words

    def test_option_is_checked_where_it_stands(self, scene):
        with pytest.raises(ScenarioError) as fault:
            load(scene, {"friction.dahl.bristle_stiffness": -1})
        (problem,) = fault.value.problems
        assert problem.sentence.startswith(
            "friction.dahl.bristle_stiffness must be above 0 N/m"
        )

    def test_option_of_the_own_law_is_swept_by_its_key_in_the_block(self, scene):
        swept = {"friction.law": "lugre", "sweep": {"friction.lugre.bristle_damping": [1, 2]}}
        with pytest.raises(ScenarioError) as fault:
            load(scene, swept)
        (problem,) = fault.value.problems
        assert problem.sentence.endswith("did you mean `friction.bristle_damping`?")

    def test_missing_keys_of_a_law_are_named_with_their_units(self, scene):
        with pytest.raises(ScenarioError) as fault:
            load(scene).with_law("petrov-ewins")
        (problem,) = fault.value.problems
        assert problem.sentence == (
            "law petrov-ewins needs friction.petrov-ewins.mu_kinetic [-], "
            "friction.petrov-ewins.normal [N] and "
            "friction.petrov-ewins.tangential_stiffness [N/m]: "
            "give them in a block `petrov-ewins` of friction"
        )
        assert problem.line == 4

    def test_keys_that_do_not_go_together_are_said_of_the_law(self, scene):
        with pytest.raises(ScenarioError) as fault:
            load(scene, {"friction.lugre.static": 30}).with_law("lugre")
        (problem,) = fault.value.problems
        assert problem.sentence == (
            "friction as lugre: static must be at least the kinetic 45 N, not 30 N"
        )

    def test_scene_without_friction_has_no_law_to_exchange(self, scene):
        with pytest.raises(ScenarioError, match="not a scenario for law lugre") as fault:
            load(scene, {"friction": None}).with_law("lugre")
        assert "needs a friction block" in fault.value.problems[0].sentence


class TestComparison:
    def test_laws_are_rows_of_their_own_solved_as_if_named_in_the_file(self, scene):
        found = compare(load(scene), ("lugre", "dahl", "coulomb"))
        assert found.table.approaches == ("lugre", "dahl", "coulomb", "viscous")
        for name in ("lugre", "dahl"):
            (row,) = found.table.of(name)
            alone = run(load(scene, {"friction.law": name, **LESS.get(name, {})}))
            assert row.metrics["T_a"] == alone.metrics["T_a"]
        assert found.laws == {
            "lugre": "lugre", "dahl": "dahl", "coulomb": "coulomb", "viscous": ""
        }  # fmt: skip

    def test_same_law_by_two_words_is_said_to_be_one(self, scene):
        found = compare(load(scene), ("coulomb", "lugre", "stick-slip"))
        (coulomb,), (exact,) = found.table.of("coulomb"), found.table.of("stick-slip")
        assert coulomb.metrics == exact.metrics
        assert "coulomb is stick-slip here" in " ".join(found.verdict)

    def test_other_law_is_no_error(self, scene):
        found = compare(load(scene), ("lugre", "signum", "stick-slip"))
        verdict = " ".join(found.verdict)
        assert "lugre is off" not in verdict
        assert "lugre differs from" in verdict or "lugre agrees with" in verdict

    def test_all_words_get_the_very_same_motion(self, scene):
        noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.6, duration: 3, seed: 3}"
        text = SCENE.replace("{kind: harmonic, frequency: 2, rms: 0.75}", noise)
        scene.write_text(text)
        found = compare(load(scene), ("lugre", "jenkins", "stick-slip"))
        first, *others = found.responses.values()
        for other in others:
            assert np.array_equal(first.u_dd, other.u_dd)

    def test_what_a_law_leaves_out_is_a_caution(self, scene):
        varied = {"friction.normal_variation": {"amplitude": 0.2, "frequency": 1}}
        found = compare(load(scene, varied), ("jenkins", "lugre", "stick-slip"))
        sentences = {caution.sentence for caution in found.table.warnings}
        assert sentences >= {
            "lugre has no use for friction.normal_variation and leaves it out",
            "jenkins knows no static limit above kinetic friction and takes F_fs = F_fk",
        }

    def test_sweep_goes_over_the_words_that_have_use_for_it(self, scene):
        keys = (
            "sweep: {friction.kinetic: [30, 45], friction.lugre.bristle_stiffness: [1e5, 2e5]}"
        )
        scene.write_text(SCENE + keys)
        found = compare(load(scene), ("dahl", "lugre", "stick-slip"))
        sizes = {name: len(list(found.table.of(name))) for name in found.table.approaches}
        assert sizes == {"dahl": 1, "lugre": 4, "stick-slip": 2, "viscous": 1}
        T_a = {row.metrics["T_a"] for row in found.table.of("lugre")}
        assert len(T_a) == 4

    def test_key_that_only_the_yardstick_has_use_for_leaves_no_gap_in_the_verdict(self, scene):
        scene.write_text(SCENE + "sweep: {friction.lugre.bristle_stiffness: [1e4, 1e5, 1e6]}")
        found = compare(load(scene), ("coulomb", "stick-slip", "lugre"))
        verdict = " ".join(found.verdict)
        assert "coulomb differs from lugre: T_a" in verdict
        assert "coulomb agrees within 5 % nowhere in this sweep" in verdict
        assert found.shown.keys() == {"friction.lugre.bristle_stiffness"}

    def test_case_shown_is_one_at_which_a_word_is_off(self, scene):
        scene.write_text(SCENE + "sweep: {excitation.frequency: [0.5, 2, 8]}")
        found = compare(load(scene), ("coulomb", "jenkins", "stick-slip"))
        worst = max(found.table.of("jenkins"), key=lambda row: abs(found.deviation(row)))
        assert found.shown == worst.point

    def test_point_at_which_a_law_breaks_its_rules_is_found_before_the_work(self, scene):
        scene.write_text(SCENE + "sweep: {friction.kinetic: [30, 60]}")
        with pytest.raises(ScenarioError) as fault:
            compare(load(scene, {"friction.lugre.static": 50}), ("lugre", "stick-slip"))
        assert "at least the kinetic 60 N, not 50 N" in fault.value.problems[0].sentence
        assert "friction.kinetic = 60" in fault.value.problems[0].sentence

    def test_law_is_called_by_its_name_where_its_seeds_are_measured_together(
        self, scene, process
    ):
        """Rows of a block were called by the approach, a word that the table did not know."""
        noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.6, duration: 3, seeds: 8}"
        words = ("compare", "dahl", "vs", "coulomb", "-s", scene, "--no-plots")
        answer = process(*words, "--set", f"excitation={noise}", DRYSIM_ENGINE="compiled")
        assert answer.code == 0, answer.err
        rows = rows_of(scene.parent / "out/scene-compare/comparison.csv")
        assert [row["approach"] for row in rows] == ["dahl", "coulomb", "viscous"]

    def test_seeds_are_compared_in_pairs(self, scene):
        noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.6, duration: 3, seeds: 3}"
        scene.write_text(SCENE.replace("{kind: harmonic, frequency: 2, rms: 0.75}", noise))
        found = compare(load(scene), ("lugre", "jenkins", "stick-slip"))
        (row,) = found.table.of("lugre")
        off, half_width = found.off(row)
        assert row.seeds == 3
        assert half_width > 0
        assert off == pytest.approx(0, abs=0.2)


LESS = {"dahl": {"friction.static_ratio": None}}
"""What a law of the file may not say beside its own options."""


class TestFiles:
    def test_table_tells_word_and_law(self, scene, tmp_path, capsys):
        words = ["compare", "lugre", "vs", "signum", "vs", "stick-slip", "-s", str(scene)]
        assert main([*words, "-o", str(tmp_path / "out"), "--json"]) == 0
        rows = rows_of(tmp_path / "out" / "comparison.csv")
        assert [(row["approach"], row["law"]) for row in rows] == [
            ("lugre", "lugre"), ("signum", "coulomb"), ("stick-slip", "coulomb"),
            ("viscous", ""),
        ]  # fmt: skip
        told = json.loads(capsys.readouterr().out)
        assert told["numerics"]["laws"]["lugre"] == "lugre"
        assert "lugre" in told["metrics"]

    def test_table_of_approaches_is_what_it_was(self, scene, tmp_path):
        words = ["compare", "signum", "vs", "stick-slip", "-s", str(scene), "--no-plots", "-q"]
        assert main([*words, "-o", str(tmp_path / "out")]) == 0
        header = (tmp_path / "out" / "comparison.csv").read_text().splitlines()[0]
        assert header.endswith(",T_a_deviation [-]")

    def test_override_reaches_an_option(self, scene, tmp_path, capsys):
        words = ["compare", "jenkins", "vs", "stick-slip", "-s", str(scene), "--no-plots"]
        stiff = ["--set", "friction.jenkins.tangential_stiffness=90 kN/m"]
        assert main([*words, *stiff, "-o", str(tmp_path / "out")]) == 0
        assert "90000 N/m" in capsys.readouterr().out

    def test_missing_key_ends_with_nothing_computed(self, scene, tmp_path, capsys):
        words = ["compare", "stribeck", "vs", "stick-slip", "-s", str(scene)]
        assert main([*words, "-o", str(tmp_path / "out")]) == 2
        assert "friction.stribeck.stribeck_velocity [m/s]" in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "approach", [name for name in SHELF if name not in ("stick-slip", "viscous")]
)
@pytest.mark.parametrize("law", ["jenkins", "dahl"])
def test_fixed_steps_refuse_every_law_but_coulombs(scene, law, approach):
    changes = {"friction.law": law, "friction.static_ratio": None, "solver.approach": approach}
    with pytest.raises(ScenarioError) as fault:
        load(scene, changes)
    assert "knows Coulomb's friction only" in fault.value.problems[0].sentence


def test_law_in_place_of_an_approach_is_told_where_it_belongs(scene):
    with pytest.raises(ScenarioError) as fault:
        load(scene, {"solver.approach": "lugre"})
    (problem,) = fault.value.problems
    assert problem.sentence.endswith("`lugre`; it is a friction law: friction.law takes it")


def test_laws_that_move_the_mass_alike_are_said_to_coincide(scene):
    contact = {"tangential_stiffness": 45e3, "mu_kinetic": 0.1, "normal": 450}
    changes = {"friction.petrov-ewins": contact}
    told = "jenkins and petrov-ewins coincide"
    made = compare(load(scene, changes), "jenkins dahl petrov-ewins vs coulomb")
    assert made.verdict.count(told) == 1
    assert sum(told in text.get_text() for text in draw(made).texts) == 1
    contact["tangential_stiffness"] = 45.1e3
    made = compare(load(scene, changes), "jenkins dahl petrov-ewins vs coulomb")
    assert not any("coincide" in sentence for sentence in made.verdict)


def test_words_of_which_nothing_is_known_do_not_coincide(scene):
    made = compare(
        load(scene, {"sweep": {"friction.kinetic": [30, 45]}}), "signum switch vs moreau"
    )
    rows = tuple(replace(row, metrics={}, status=FAILED) for row in made.table.rows)
    assert not [*coinciding(replace(made, table=replace(made.table, rows=rows, told={})))]


def test_scenario_with_options_is_a_scenario(scene):
    assert isinstance(load(scene), Scenario)
