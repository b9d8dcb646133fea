"""Blocks that messages show to be copied: they fit each scenario of the gallery."""

from __future__ import annotations

import pytest

from drysim.errors import ScenarioError
from drysim.scenario.examples import design_example, map_example, sweep_example
from drysim.scenario.load import load
from drysim.study import gallery
from drysim.study.branches import prepare_branches
from drysim.study.design import prepare_design
from drysim.study.plan import approaches_of
from drysim.study.preparation import prepare
from drysim.study.regimes import prepare_map
from drysim.yaml_document import document_of

SCENARIOS = {each.name: each.file for each in gallery.list_scenarios()}
WITHOUT = {"sweep": None, "design": None, "reference": None, "checks": None, "fit": None}


def block_of(example: str) -> dict[str, object]:
    """Return the block of an example, as overrides."""
    text = example.removeprefix("for example:\n\n").partition("\n\nor, without")[0]
    return document_of(text, "the block").value


def without_blocks(name: str, **more: object):
    """Return a scenario of the gallery without its studies, with other overrides."""
    given = load(SCENARIOS[name]).resolved()
    less = {key: value for key, value in WITHOUT.items() if key in given}
    if "until" in given["excitation"]:
        less["excitation.until"] = None
    return load(SCENARIOS[name], less | more)


@pytest.mark.parametrize("name", [name for name in SCENARIOS if not name.startswith("fit-")])
def test_examples_fit_the_scenario(name: str) -> None:
    scenario = without_blocks(name)
    swept = without_blocks(name, **block_of(sweep_example(scenario)))
    assert len(swept.sweep) == 1
    assert prepare(swept, swept=True).scenario.sweep
    designed = without_blocks(name, **block_of(design_example(scenario)))
    assert prepare_design(designed).scenario.design is not None


@pytest.mark.parametrize("name", ["paper-low-friction", "regime-map", "seat-comfort-em6"])
def test_example_of_a_map_fits_the_scenario(name: str) -> None:
    scenario = without_blocks(name)
    mapped = without_blocks(name, **block_of(map_example(scenario)))
    assert len(prepare_map(mapped).scenario.sweep) == 2


@pytest.mark.parametrize(
    ("solve", "key"),
    [(approaches_of, "sweep"), (prepare_branches, "sweep"), (prepare_map, "sweep"),
     (prepare_design, "design")],
)  # fmt: skip
def test_missing_block_is_shown(solve, key: str) -> None:
    with pytest.raises(ScenarioError, match=f"{key} is required") as fault:
        solve(without_blocks("paper-low-friction"))
    assert block_of(fault.value.hint).keys() == {key}
