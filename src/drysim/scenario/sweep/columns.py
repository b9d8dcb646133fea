"""Many cases of a sweep at once: a scenario whose swept numbers are columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from drysim.quantity import Block
from drysim.scenario.shape import models_in

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

Columns = dict[str, NDArray[Any]]


def columned(scenario: Scenario, columns: Mapping[str, NDArray[Any]]) -> Scenario:
    """Give a scenario with a column of values at each of some keys.

    Only its arithmetic has a meaning (plant, law, motion, ...): nothing is validated, and rules
    between the values of a case are for `Scenario.at` to check.
    """
    changed: dict[str, Any] = {}
    for key, column in columns.items():
        name, *steps = key.split(".")
        annotation = type(scenario).model_fields[name].annotation
        old = changed.get(name, getattr(scenario, name))
        changed[name] = _put(old, annotation, steps, column)
    return scenario.copied(changed)


def _put(old: Any, annotation: Any, steps: Sequence[str], column: NDArray[Any]) -> Any:
    """Give a value with a column at the end of some steps."""
    if not steps:
        return column
    first, *rest = steps
    if isinstance(old, tuple):
        i = int(first)
        return (*old[:i], _put(old[i], None, rest, column), *old[i + 1 :])
    if old is None:
        values: Any = {first: column}
        return next(iter(models_in(annotation))).model_construct(**values)
    assert isinstance(old, Block), "a key leads through blocks and lists"
    inner = _put(getattr(old, first), type(old).model_fields[first].annotation, rest, column)
    return old.model_copy(update={first: inner})
