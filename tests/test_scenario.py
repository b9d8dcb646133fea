"""A scenario file that is sound: what it means, what it defaults to, and how it runs again."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import ClassVar, Literal, get_args

import pytest
from pydantic import BaseModel

from drysim.approach import APPROACHES_BY_NAME
from drysim.block import Block
from drysim.core.model import CoulombLaw, Plant, State
from drysim.errors import ScenarioError
from drysim.excitation import EXCITATIONS
from drysim.friction import FRICTION_LAWS
from drysim.scenario import schema
from drysim.scenario.blocks import solver_with_options
from drysim.scenario.load import load
from drysim.scenario.model import scene_period
from drysim.yaml_document import dump

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""

EVERYTHING = """\
drysim: 1
name: everything
about: "All of it: once"
oscillator: {mass: 75 kg, stiffness: 7.5 kN/m, damping_ratio: 0.333}
friction:
  law: coulomb
  mu_kinetic: 0.02
  mu_static: 0.03
  normal_variation: {amplitude: 0.4, frequency: 0.8, phase: 90 deg}
stroke: {limit: 25 mm}
start: {x_r: -1 mm, v_r: 0.1}
excitation: {kind: harmonic, frequency: 1.6, rms: 0.05 g}
solver: {approach: stick-slip, step: 2.5 ms}
measure: {settle: 4 periods, duration: 20 periods}
checks: [x_r_peak < 25 mm, T_a < 1.75]
"""

RECORD = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation: {kind: record, file: data/base.csv, column: u_dd, window: {from: 1 s}}
"""


def test_only_oscillator_and_excitation_and_a_step_are_needed(scenario):
    found = scenario(SEAT)
    assert found.name == "seat"
    assert found.oscillator.plant() == Plant(75.0, 7500.0, 500.0)
    assert found.law() == CoulombLaw(0.0, 0.0)
    assert found.start.state() == State(0.0, 0.0)
    assert found.stroke is None
    assert found.solver.approach == "stick-slip"
    assert found.measure.steady
    assert found.checks == ()


def test_friction_that_names_no_law_is_coulomb(scenario):
    block = "{kinetic: 15, static: 18}"
    named = scenario(f"{SEAT}friction: {{law: coulomb, kinetic: 15, static: 18}}\n")
    unnamed = scenario(f"{SEAT}friction: {block}\n")
    assert unnamed.friction.law == "coulomb"
    assert unnamed.law() == named.law() == CoulombLaw(15.0, 18.0)
    assert unnamed.resolved() == named.resolved()
    block = "{kinetic: 15, dahl: {bristle_stiffness: 1e5}}"
    assert scenario(f"{SEAT}friction: {block}\n").friction.dahl.bristle_stiffness == 1e5


@pytest.mark.parametrize(
    ("block", "sentence"),
    [
        ("{lw: dahl, kinetic: 15, bristle_stiffness: 1e5}", "did you mean `law`?"),
        ("{kinetic: 15, bristle_stiffness: 1e5}", "of law coulomb; it belongs to law dahl"),
        ("{law: dal, kinetic: 15}", "unknown law `dal` in friction; did you mean `dahl`?"),
    ],
)
def test_friction_of_a_mistyped_law_is_not_taken_for_coulomb(scenario, block, sentence):
    with pytest.raises(ScenarioError) as fault:
        scenario(f"{SEAT}friction: {block}\n")
    (problem,) = fault.value.problems
    assert sentence in problem.sentence


def test_every_word_is_read_in_si(scenario):
    found = scenario(EVERYTHING)
    assert found.oscillator.plant() == Plant(75.0, 7500.0, 0.333 * 2 * 750.0)
    assert found.law()[:3] == (0.02 * 735.75, 0.03 * 735.75, 0.4)
    assert found.start.state() == State(-0.001, 0.1)
    assert found.stroke.limit == 0.025
    assert found.excitation.rms == 0.4903325
    assert found.solver.step == 0.0025
    assert [str(check) for check in found.checks] == ["x_r_peak < 25 mm", "T_a < 1.75"]


def test_periods_are_the_common_period_of_base_and_normal_force(scenario):
    found = scenario(EVERYTHING)
    assert scene_period(found) == 1.25
    assert (found.measure.settle, found.measure.duration) == (5.0, 25.0)


def test_record_is_measured_to_its_end_and_not_read_yet(scenario, tmp_path):
    found = scenario(RECORD)
    assert (found.measure.settle, found.measure.duration) == (0.0, None)
    assert found.solver.step is None
    assert found.folder == tmp_path
    assert scene_period(found) is None


@pytest.mark.parametrize("text", [SEAT, EVERYTHING, RECORD])
def test_resolved_scenario_runs_again_as_it_is(scenario, text):
    found = scenario(text)
    words, law = found.resolved(), found.law()
    again = scenario(dump(words))
    assert again.resolved() == words
    assert again.law() == law


def test_resolved_scenario_spells_out_defaults_and_overrides(scenario):
    words = scenario(SEAT, ["friction={law: coulomb, kinetic: 15}", "name=other"]).resolved()
    assert words["name"] == "other"
    assert words["friction"] == {"law": "coulomb", "kinetic": 15.0, "static_ratio": 1.0}
    assert words["solver"] == {"approach": "stick-slip", "step": 0.0025}
    assert words["measure"] == {"steady": True}
    assert words["start"] == {"x_r": 0.0, "v_r": 0.0}
    words = scenario(SEAT, ["solver.approach=signum"]).resolved()["solver"]
    options = {"method": "semi-implicit"}
    assert words == {"approach": "signum", "step": 0.0025, "signum": options}


def test_resolved_record_is_found_from_another_folder(scenario, tmp_path):
    words = scenario(RECORD).resolved(tmp_path / "out" / "seat")
    assert words["excitation"]["file"] == "../../data/base.csv"
    assert words["excitation"]["window"] == {"from": 1.0}


def test_origin_names_file_hash_and_overrides(scenario):
    origin = scenario(SEAT, {"oscillator.mass": 80}).origin
    assert (origin["file"], origin["overrides"]) == ("seat.yaml", {"oscillator.mass": 80})
    assert len(origin["sha256"]) == 64


def test_problem_found_later_is_shown_at_its_key(scenario):
    problem = scenario(SEAT).problem("is too long", "solver.step")
    assert (problem.line, problem.column, problem.width) == (3, 16, 6)


@pytest.mark.parametrize(
    ("file", "name"),
    [("a b.yaml", "a b"), (".seat.yaml", "seat"), ("ä(1).yaml", "ä-1"),
     ("seat.partial.yaml", "scenario"), ("con.yaml", "scenario")],
)  # fmt: skip
def test_name_defaults_to_the_file_made_safe_for_a_folder(tmp_path, file, name):
    (tmp_path / file).write_text(SEAT)
    assert load(tmp_path / file).name == name


def test_scenario_cannot_be_changed(scenario):
    with pytest.raises(ValueError, match="frozen"):
        scenario(SEAT).name = "other"


@pytest.mark.parametrize(
    ("words", "key"),
    [
        ("static_ratio: 1.2", "friction.static_ratio"),
        ("normal_variation: {amplitude: 0.1, frequency: 1.6}", "friction.normal_variation"),
    ],
)
def test_friction_that_the_approach_cannot_use_is_refused(scenario, words, key):
    text = f"{SEAT}friction: {{law: coulomb, kinetic: 15, {words}}}\n"
    with pytest.raises(ScenarioError) as fault:
        scenario(text, ["solver.approach=signum"])
    (problem,) = fault.value.problems
    assert (problem.key, problem.line) == (key, 4)
    assert "approach signum does not support" in problem.sentence


def test_approach_with_options_brings_its_own_block():
    class Smooth(BaseModel):
        supports_friction: ClassVar[bool] = True
        approach: Literal["smooth"] = "smooth"
        sharpness: float = 1e3

    block = solver_with_options({**APPROACHES_BY_NAME, "smooth": Smooth})
    solver = block.model_validate({"approach": "stick-slip", "smooth": {"sharpness": 5}})
    assert solver.smooth == Smooth(sharpness=5)
    assert solver.member() == APPROACHES_BY_NAME["stick-slip"]()


def test_loading_needs_no_heavy_library(tmp_path):
    (tmp_path / "seat.yaml").write_text(EVERYTHING.replace(" deg", ""))
    code = (
        "import sys; from drysim.scenario import load, scenario_warnings\n"
        "scenario_warnings(load('seat.yaml'))\n"
        "assert not {'numba', 'scipy', 'pint', 'matplotlib'} & sys.modules.keys()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path)
    assert done.returncode == 0


# The JSON schema of scenario files: derived from the models, never kept twice.


@pytest.fixture(scope="module")
def words():
    return schema()


def blocks(words):
    """Return every block of a scenario by name."""
    return {"Scenario": words, **words["$defs"]}


def test_schema_names_its_dialect_and_what_is_required(words):
    assert words["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert words["allOf"] == [  # an assessment needs neither
        {"anyOf": [{"required": [key]}, {"required": ["assess"]}]}
        for key in ("oscillator", "excitation")
    ]
    assert words["properties"]["drysim"]["const"] == 1


def test_every_key_is_described_here_or_where_it_refers_to(words):
    for name, block in blocks(words).items():
        for key, field in block["properties"].items():
            target = words["$defs"].get(field.get("$ref", "").rpartition("/")[2], {})
            assert field.get("description") or target.get("description"), f"{name}.{key}"


def test_every_member_of_every_shelf_is_in_it(words):
    kinds = {get_args(member.model_fields["kind"].annotation)[0] for member in EXCITATIONS}
    assert set(words["properties"]["excitation"]["discriminator"]["mapping"]) == kinds
    assert {member.__name__ for member in FRICTION_LAWS} <= words["$defs"].keys()
    assert words["$defs"]["Solver"]["properties"]["approach"]["enum"] == list(
        APPROACHES_BY_NAME
    )


def test_blocks_keep_alternatives_and_bounds_and_take_neither_unknown_keys_nor_null(words):
    springs = [{"required": ["stiffness"]}, {"required": ["natural_frequency"]}]
    dampers = [{"required": ["damping"]}, {"required": ["damping_ratio"]}]
    either = [{"oneOf": springs}, {"oneOf": dampers}]
    assert words["$defs"]["Oscillator"]["allOf"] == either
    number, text = words["$defs"]["Oscillator"]["properties"]["mass"]["anyOf"]
    assert number == {"type": "number", "exclusiveMinimum": 0}
    assert text["type"] == "string"
    assert all(block["additionalProperties"] is False for block in blocks(words).values())
    assert "null" not in str(words)
    assert schema() == words  # asked for twice


def test_schema_beside_the_gallery_is_this_one(words):
    file = Path(__file__).parents[1] / "scenarios" / "scenario.schema.json"
    assert json.loads(file.read_text(encoding="utf-8")) == words, "make schema writes it anew"


def test_no_annotation_of_a_block_is_text_that_pydantic_has_to_evaluate():
    models = [Block]
    for model in models:
        models += [one for one in model.__subclasses__() if one not in models]
    # The approaches name types of the core, which is imported later.
    ours = [one for one in models if re.match(r"drysim\.(?!approach)", one.__module__)]
    assert len(ours) > 50
    texts = [text for one in ours for text in vars(one).get("__annotations__", {}).values()]
    assert [text for text in texts if isinstance(text, str)] == []
