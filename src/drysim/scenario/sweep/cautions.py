"""What a reader of a sweep should know before it is computed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from drysim.approach.stick_slip import Exact
from drysim.errors import Caution
from drysim.scenario.sweep.axis import columns_of, size, walks

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario
    from drysim.scenario.sweep.axis import Axis


MANY = 10_000
"""Values of a swept key beyond which the first and the last stand for all."""


def extremes(scenario: Scenario) -> Iterator[Scenario]:
    """Give the cases at the least and the greatest value of every swept key."""
    first = _points(scenario.sweep, 0, 1)[0]
    for group in walks(scenario.sweep):
        for point in _ends(group):
            yield scenario.at({**first, **point})


def _ends(group: Sequence[Axis]) -> list[dict[str, float]]:
    """Return the points at which a key of a group has its least or its greatest value."""
    count = len(group[0].values)
    if count > MANY:
        return [*_points(group, 0, 1), *_points(group, count - 1, count)]
    # All keys of a sample are drawn together, once: a single value costs as much as many.
    every = _points(group, 0, count)
    values = {axis.key: [point[axis.key] for point in every] for axis in group}
    places = {column.index(pick(column)) for column in values.values() for pick in (min, max)}
    return [every[place] for place in sorted(places)]


def _points(axes: Sequence[Axis], begin: int, end: int) -> list[dict[str, float]]:
    """Return the points with numbers from `begin` to the one before `end`."""
    columns = {key: column.tolist() for key, column in columns_of(axes, begin, end).items()}
    return [
        dict(zip(columns, point, strict=True)) for point in zip(*columns.values(), strict=True)
    ]


def needless(scenario: Scenario) -> Iterator[Caution]:
    """Say which swept keys change nothing, and what the reference leaves out."""
    for axis in scenario.sweep:
        if why := _why_needless(scenario, axis):
            sentence = f"sweep of {axis.key} {why}"
            yield Caution("sweep-changes-nothing", sentence, {"values": len(axis.values)})
    reference = scenario.reference
    if reference is not None and errs(scenario, scenario.with_approach(reference)):
        for sentence in scenario.losses(reference):
            yield Caution("left-out", f"reference: {sentence}")


def errs(scenario: Scenario, reference: Scenario) -> bool:
    """Tell whether a reference has friction of its own to leave out, or no end stops."""
    return reference.friction is not None or reference.stops != scenario.stops


def _why_needless(scenario: Scenario, axis: Axis) -> str | None:
    """Say why a swept key changes nothing; None when it changes something."""
    if len(axis.values) == 1:
        return "has one value only; set it in the scenario instead"
    if axis.key == "stroke.limit" and scenario.stops is None:
        return "changes no motion and no transmissibility, only which stroke counts as too much"
    approach = scenario.solver.approach
    block, option, *rest = axis.key.split(".")
    if block == "solver" and rest and option != approach:
        return f"changes nothing: the approach is {approach}, which has no use for {option}"
    exact = isinstance(scenario.solver.member(), Exact)
    if axis.key == "solver.step" and exact and scenario.excitation.periodic:
        return f"changes nothing: {approach} under sines makes no error that depends on it"
    phase = axis.key.startswith("excitation.") and axis.key.endswith(".phase")
    if phase and scenario.measure.steady and len(scenario.frequencies) == 1:
        return (
            "changes nothing: the metrics cover a whole repetition of the steady orbit (where "
            "several orbits coexist, it decides which of them the start leads to)"
        )
    count = size(scenario.sweep)
    first, last = _points(scenario.sweep, 0, 1)[0], _points(scenario.sweep, count - 1, count)[0]
    together = next(group for group in walks(scenario.sweep) if axis in group)
    if _scene(scenario, last) == _scene(
        scenario, last | {a.key: first[a.key] for a in together}
    ):
        return "changes nothing: what it stands for is 0 or not used"
    return None


def _scene(scenario: Scenario, point: dict[str, float]) -> tuple[object, ...]:
    """Give all that the metrics of a case depend on."""
    case = scenario.at(point)
    solver = case.solver.step, case.solver.member()
    return (
        case.oscillator.plant(), case.law(), case.excitation, case.start, solver, case.measure
    )  # fmt: skip
