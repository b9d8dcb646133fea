"""The case at a point of a sweep, made from the scenario without reading its file again."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from drysim.errors import Problem, ScenarioError
from drysim.excitation.generated import Generated
from drysim.quantity import Misfit
from drysim.scenario.measure import in_periods, in_seconds
from drysim.scenario.rules import unused
from drysim.scenario.sentences import sentences
from drysim.scenario.shape import models_in
from drysim.scenario.sweeping import SWEEP, points
from drysim.source import Keys
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

FEW = 10_000
"""Points that are tried when a scenario is loaded; in a larger grid, each when it is met."""

TOGETHER = (
    ("oscillator.",),
    ("friction.",),
    ("excitation.", "solver.", "measure.", "friction.normal_variation."),
)
"""Keys between which there are rules; across these groups there are none."""

Fault = tuple[str, str]


def case_at(scenario: Scenario, point: Mapping[str, float]) -> Scenario:
    """Give the case at a point; only the blocks that the point touches are checked again.

    Raises
    ------
    ScenarioError
        When the values of the point do not go together.
    """
    try:
        return _case(scenario, point)
    except _Odd as odd:
        raise _error(scenario, point, *odd.fault) from None


def in_conflict(scenario: Scenario, most: int = FEW) -> list[Problem]:
    """Give the problem of the first point whose values do not go together, if there is one.

    Where rules connect more than `most` points, none of them is tried.
    """
    for group in TOGETHER:
        axes = tuple(axis for axis in scenario.axes if axis.key.startswith(group))
        if prod(len(axis.values) for axis in axes) > most:
            continue
        try:
            for point in points(axes) if axes else ():
                case_at(scenario, point)
        except ScenarioError as fault:
            return [*fault.problems]
    return []


class _Odd(Exception):
    """A value that does not fit the others: its key and the sentence."""

    def __init__(self, key: str, sentence: str) -> None:
        super().__init__(sentence)
        self.fault: Fault = key, sentence


def _case(scenario: Scenario, point: Mapping[str, float]) -> Scenario:
    """Give the case at a point, or what is odd about it."""
    changed: dict[str, Any] = {SWEEP: (), "reference": None}
    touched: dict[str, Any] = {}
    for key, value in point.items():
        name, *steps = key.split(".")
        if name not in touched:
            touched[name] = {} if name == "measure" else scenario.words_of(name)
        touched[name] = _with(touched[name], steps, value)
    for name, words in touched.items():
        if name != "measure":
            changed[name] = _block(scenario, name, words)
    case = scenario.copied(changed)
    _step_suits(case, touched.keys())
    if touched.keys() & {"measure", "excitation", "friction"}:
        case = _measured(case, touched.get("measure"))
    if touched.keys() & {"friction", "oscillator"}:
        for keys, sentence in unused(case):
            raise _Odd(".".join(map(str, keys)), sentence)
    if any(check.conditions for check in scenario.checks):
        case = case.copied({"checks": tuple(check.where(point) for check in scenario.checks)})
    return case


def _with(words: Any, steps: list[str], value: float) -> Any:
    """Give words with a value at the end of some steps; the old words are left alone."""
    first, *rest = steps
    if isinstance(words, list | tuple):
        at = int(first)
        new = _with(words[at], rest, value) if rest else value
        return [*words[:at], new, *words[at + 1 :]]
    old = words.get(first)
    if rest:
        return {**words, first: _with({} if old is None else old, rest, value)}
    # A whole number that was spread over an axis, such as a seed, may have become a float.
    whole = type(old) is int and isinstance(value, float) and value.is_integer()
    return {**words, first: int(value) if whole else value}


def _block(scenario: Scenario, name: str, words: Mapping[str, Any]) -> BaseModel:
    """Give a block of the scenario with other words."""
    old = getattr(scenario, name, None)
    field = type(scenario).model_fields.get(name)
    models = [type(old)] if old is not None else models_in(field.annotation) if field else []
    if not models or not isinstance(models[0], type) or not issubclass(models[0], BaseModel):
        raise _Odd(name, f"there is no block {name}")
    try:
        return models[0].model_validate(words, context={"folder": scenario.folder})
    except ValidationError as fault:
        found = list(sentences(fault, {name: words}, (name,)))
        keys, sentence = found[0] if found else ((name,), fault.errors()[0]["msg"])
        raise _Odd(".".join(map(str, keys)), sentence) from None


def _step_suits(case: Scenario, touched: Any) -> None:
    """Make sure that the grid of the step can hold a generated base motion."""
    excitation, step = case.excitation, case.solver.step
    if isinstance(excitation, Generated) and step and touched & {"excitation", "solver"}:
        try:
            excitation.check_step(step)
        except Misfit as fault:
            raise _Odd("solver.step", f"solver.step {fault}") from None


def _measured(case: Scenario, words: Mapping[str, float] | None) -> Scenario:
    """Give the case with its window: periods counted anew, a common period looked for."""
    from drysim.scenario.model import frequencies

    spoken = {**case.spoken("measure"), **(words or {})}
    found = frequencies(case.excitation, case.friction)
    if words is None and not in_periods(spoken) and len(found) < 2:
        return case
    steady = getattr(case.excitation, "steady_by_default", False)
    try:
        window = in_seconds(spoken, found, steady)
    except Misfit as fault:
        raise _Odd("measure", f"measure.{'.'.join(map(str, fault.at))} {fault}") from None
    return case.copied({"measure": type(case.measure).model_validate(window)})


def _error(
    scenario: Scenario, point: Mapping[str, float], key: str, sentence: str
) -> ScenarioError:
    """Give the error for values that do not go together, located at one of them."""
    blamed = key if key in point else [*point][-1]
    axis = next((axis for axis in scenario.axes if axis.key == blamed), None)
    keys: Keys = tuple(blamed.split("."))
    if axis is not None:
        value = point[blamed]
        keys = (SWEEP, blamed, axis.values.index(value) if value in axis.values else "")
    where = ", ".join(f"{name} = {number(value, digits=12)}" for name, value in point.items())
    problem = scenario.problem(f"{sentence} (at {where})", keys)
    name = scenario.origin["file"] or scenario.name
    return ScenarioError(f"{name} is not a scenario yet: 1 problem", (problem,))
