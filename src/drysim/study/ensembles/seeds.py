"""The seeds that a scenario asks for: which, one after the other, and when they are enough."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from drysim.errors import Caution
from drysim.excitation.generated import Drawn
from drysim.study.ensembles.statistics import interval

if TYPE_CHECKING:
    from drysim.excitation.generated import Until
    from drysim.scenario import Scenario
    from drysim.study.sweeps.table import Row

LOOK = 10
"""Seeds between two looks at the interval. Looks are taken at fixed numbers of seeds, in their
order, so that what is decided does not depend on which of them was ready first."""


def most(scenario: Scenario) -> int:
    """Give how many seeds a scenario asks for at most; 1 where it asks for no more."""
    excitation = scenario.excitation
    return excitation.most_seeds if isinstance(excitation, Drawn) else 1


def until_of(scenario: Scenario) -> Until | None:
    """Give when the seeds of a scenario are to be enough; None where their number is given."""
    excitation = scenario.excitation
    return excitation.until if isinstance(excitation, Drawn) else None


def asked(scenario: Scenario) -> range:
    """Give the seeds that a scenario asks for, as far as they may have to go."""
    excitation = scenario.excitation
    assert isinstance(excitation, Drawn), "only random base motion has seeds"
    return range(excitation.seed, excitation.seed + excitation.most_seeds)


def of_seed(scenario: Scenario, seed: int) -> Scenario:
    """Give the scenario with the base motion of one seed alone."""
    excitation = scenario.excitation
    assert isinstance(excitation, Drawn), "only random base motion has seeds"
    return scenario.copied({"excitation": excitation.of_seed(seed)})


def one_only(scenario: Scenario) -> Iterator[Caution]:
    """Say that one seed is taken where a scenario asks for many, which is of no use."""
    if most(scenario) > 1:
        first = asked(scenario)[0]
        sentence = f"excitation.seeds has no use here: only the first seed, {first}, is taken"
        yield Caution("one-seed", sentence, {"seed": first})


def enough(scenario: Scenario, rows: Sequence[Row]) -> bool:
    """Tell whether these seeds, the first ones, are all that are needed.

    Parameters
    ----------
    scenario : Scenario
    rows : sequence of Row
        One for each seed, in order.
    """
    return len(rows) == most(scenario) or (len(rows) % LOOK == 0 and narrow(scenario, rows))


def narrow(scenario: Scenario, rows: Sequence[Row]) -> bool:
    """Tell whether the interval of a metric is as narrow as `until` asks for.

    A seed that does not know the metric, or has failed, leaves it open.
    """
    until = until_of(scenario)
    if until is None:
        return False
    mean, half_width, known = width_of(rows, until.metric)
    if known < len(rows) or half_width is None:
        return False
    return half_width <= until.half_width * abs(mean)


def width_of(rows: Sequence[Row], metric: str) -> tuple[float, float | None, int]:
    """Give mean and half-width of a metric over the seeds that know it, and their number."""
    values = [row.metrics.get(metric) for row in rows]
    known = [value for value in values if value is not None]
    return (*interval(known), len(known)) if known else (0.0, None, 0)
