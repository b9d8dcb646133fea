"""The case at a point of a sweep, made from the scenario without reading its file again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from drysim.errors import Problem, ScenarioError
from drysim.excitation.generated import Generated
from drysim.quantity import Block, Misfit
from drysim.scenario.measure import in_periods, in_seconds, steady_by_default
from drysim.scenario.misfits import faults
from drysim.scenario.rules import unused
from drysim.scenario.sentences import sentences
from drysim.scenario.shape import models_in
from drysim.scenario.sweep.axis import points, size
from drysim.scenario.sweep.drawn import Drawn
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
    ("stroke.", "start."),
)
"""Keys between which there are rules; from group to group there are none."""

KEPT = 4096
"""Blocks that a scenario keeps: the cases of a grid share most of them."""

Point = Mapping[str, float]


class Odd(Exception):
    """A value that does not fit the others: its key and the sentence."""

    def __init__(self, key: str, sentence: str) -> None:
        super().__init__(sentence)
        self.key = key


def case_at(scenario: Scenario, point: Point) -> Scenario:
    """Give the case at a point; only the blocks that the point touches are checked again.

    Raises
    ------
    ScenarioError
        When the values of the point do not go together.
    """
    try:
        return _case(scenario, point)
    except Odd as odd:
        problem = _located(scenario, point, odd)
    name = scenario.origin["file"] or scenario.name
    raise ScenarioError(f"{name} is not a scenario yet: 1 problem", (problem,))


def in_conflict(scenario: Scenario, most: int = FEW) -> list[Problem]:
    """Give the problem of the first point whose values do not go together, if there is one.

    Where rules connect more than `most` points, none of them is tried.
    """
    for group in TOGETHER:
        axes = tuple(axis for axis in scenario.sweep if axis.key.startswith(group))
        if not axes or size(axes) > most:
            continue
        try:
            for point in points(axes):
                case_at(scenario, point)
        except ScenarioError as fault:
            return [*fault.problems]
    return []


def _case(scenario: Scenario, point: Point) -> Scenario:
    """Give the case at a point, or what is odd about it."""
    touched: dict[str, tuple[tuple[str, float], ...]] = {}
    for item in point.items():
        name = item[0].partition(".")[0]
        touched[name] = (*touched.get(name, ()), item)
    changed: dict[str, Any] = {
        name: _block(scenario, name, values)
        for name, values in touched.items()
        if name != "measure"
    }
    if any(check.conditions for check in scenario.checks):
        changed["checks"] = tuple(check.based_on(point) for check in scenario.checks)
    case = scenario.copied({"sweep": (), "reference": None, **changed})
    if touched.keys() & {"excitation", "solver"}:
        _step_suits(case)
    if touched.keys() & {"measure", "excitation", "friction"}:
        case = _measured(case, touched.get("measure", ()))
    if touched.keys() & {"friction", "stroke", "start"}:
        for keys, sentence in unused(case):
            raise Odd(".".join(map(str, keys)), sentence)
        for key, sentence in faults(case.friction, case.named_law):
            raise Odd(key, sentence)
    return case


def _block(scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]) -> Block:
    """Give a block of the scenario with other values in it; one that was made is kept."""
    kept = scenario.kept  # shared by threads: each takes its block by one look
    block = kept.get(values)
    if block is None:
        block = _made(scenario, name, values)
        if len(kept) >= KEPT:
            kept.clear()
        kept[values] = block
    return block


def _made(scenario: Scenario, name: str, values: tuple[tuple[str, float], ...]) -> Block:
    """Give a block of the scenario with other values in it, validated."""
    old, words = getattr(scenario, name, None), scenario.words_of(name)
    field = type(scenario).model_fields.get(name)
    models = models_in(field.annotation) if field else []
    model = type(old) if isinstance(old, Block) else next(iter(models), None)
    if model is None:
        raise Odd(name, f"there is no block {name}")
    for key, value in values:
        words = _with(words, key.split(".")[1:], value, key)
    try:
        return model.model_validate(words, context={"folder": scenario.folder})
    except ValidationError as fault:
        found = sentences(fault, {name: words}, (name,))
        for keys, sentence in found:
            raise Odd(".".join(map(str, keys)), sentence) from None
        raise Odd(values[0][0], f"{name} takes no {values[0][0]} here") from None


def _with(words: Any, steps: list[str], value: float, key: str) -> Any:
    """Give words with a value at the end of some steps; the old words are left alone."""
    if not steps:
        raise Odd(key, f"{key} is a block, not a number")
    first, *rest = steps
    if isinstance(words, list | tuple):
        if not first.isdecimal() or int(first) >= len(words):
            raise Odd(key, f"there is no {key}")
        i = int(first)
        new = _with(words[i], rest, value, key) if rest else value
        return [*words[:i], new, *words[i + 1 :]]
    if not isinstance(words, Mapping):
        raise Odd(key, f"there is no {key}")
    old = words.get(first)
    if rest:
        inner = old if isinstance(old, Mapping | list | tuple) else {}
        return {**words, first: _with(inner, rest, value, key)}
    # A whole number, such as a seed, may come as a float from an array.
    whole = type(old) is int and isinstance(value, float) and value.is_integer()
    return {**words, first: int(value) if whole else value}


def _step_suits(case: Scenario) -> None:
    """Make sure that the grid of the step can hold a generated base motion."""
    excitation, step = case.excitation, case.solver.step
    if isinstance(excitation, Generated) and step:
        try:
            excitation.check_step(step)
        except Misfit as fault:
            raise Odd("solver.step", f"solver.step {fault}") from None


def _measured(case: Scenario, values: tuple[tuple[str, float], ...]) -> Scenario:
    """Give the case with its window: periods counted anew, a common period looked for."""
    frequencies, spoken = case.frequencies, case.spoken("measure")
    if not values and len(frequencies) < 2 and not in_periods(spoken):
        return case
    words = {**spoken, **{key.partition(".")[2]: value for key, value in values}}
    steady = steady_by_default(case.excitation, case.friction)
    try:
        window = in_seconds(words, frequencies, steady)
    except Misfit as fault:
        raise Odd("measure", f"measure.{'.'.join(map(str, fault.at))} {fault}") from None
    return case.copied({"measure": type(case.measure).model_validate(window)})


def _located(scenario: Scenario, point: Point, odd: Odd) -> Problem:
    """Give the problem of values that do not go together, located at one of them."""
    key = odd.key if odd.key in point else [*point][-1]
    axis = next((axis for axis in scenario.sweep if axis.key == key), None)
    keys: Keys = tuple(key.split("."))
    if axis is not None:
        drawn = isinstance(axis.values, Drawn)
        i = "" if drawn or point[key] not in axis.values else axis.values.index(point[key])
        keys = (*(axis.place or ("sweep", key)), i)
    where = ", ".join(f"{name} = {number(value, digits=12)}" for name, value in point.items())
    return scenario.problem(f"{odd} (at {where})", keys)
