"""A scenario as plain words again: overrides and defaults spelled out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim.excitation.record import Record
from drysim.scenario.laws import BY_NAME, LAWS
from drysim.scenario.measure import in_periods
from drysim.scenario.rules import STATIC

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario


def spelled_out(scenario: Scenario, relative_to: Path | None) -> dict[str, Any]:
    """Give the words of `Scenario.resolved`."""
    words = scenario.model_dump(by_alias=True, exclude_none=True, mode="json")
    if scenario.friction is not None:
        spelt = scenario.friction.spelled_out(scenario.oscillator.mass)
        words["friction"] = {
            key: _options(value, BY_NAME) if key in LAWS else value
            for key, value in spelt.items()
            if key not in _open(scenario)
        }
    words["excitation"] = {"kind": scenario.excitation.kind} | words["excitation"]
    if isinstance(scenario.excitation, Record) and relative_to is not None:
        words["excitation"]["file"] = scenario.excitation.file_from(relative_to)
    if scenario.friction is not None and relative_to is not None:
        options = {law: getattr(scenario.friction, law, None) for law in LAWS}
        blocks = [(scenario.friction, words["friction"])]
        blocks += [(one, words["friction"][law]) for law, one in options.items() if one]
        for block, block_words in blocks:
            force = getattr(block, "normal_record", None)
            if force is not None:
                block_words["normal_record"]["file"] = force.file_from(relative_to)
    member = scenario.solver.member().model_dump(mode="json", exclude_none=True)
    solver = words["solver"] | {scenario.solver.approach: member}
    plain = {key: _options(value, "approach") for key, value in solver.items()}
    words["solver"] = {key: value for key, value in plain.items() if value != {}}
    if scenario.sweep and in_periods(spoken := scenario.spoken("measure")):
        words["measure"] |= spoken  # the period may vary from case to case
    elif scenario.measure.steady:
        # The rest has no use beside a steady state.
        asked = {"steady", "direction", "weighting"}
        words["measure"] = {k: v for k, v in words["measure"].items() if k in asked}
    return {key: value for key, value in words.items() if value not in ("", [], {})}


def _open(scenario: Scenario) -> set[str]:
    """Give the defaults of the friction block that depend on what a sweep varies."""
    friction, swept = scenario.friction, {axis.key for axis in scenario.sweep}
    if friction is None:
        return set()
    left = set()
    if friction.normal is None and "oscillator.mass" in swept:
        left.add("normal")
    if not friction.static_given and swept & {f"friction.{key}" for key in STATIC}:
        left.add("static_ratio")
    return left


def _options(value: Any, name: str) -> Any:
    """Give the options of a member of a shelf without its name, which their key says."""
    if not isinstance(value, dict):
        return value
    return {key: option for key, option in value.items() if key != name}
