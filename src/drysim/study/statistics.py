"""Means over seeds: which seeds a scenario asks for, what they tell, and when they are enough.

Of each metric: mean, confidence interval, quantiles and extremes, over the seeds that know it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from math import fsum, isfinite, sqrt
from typing import TYPE_CHECKING, NamedTuple

from drysim.errors import Caution
from drysim.excitation.random import Drawn
from drysim.metrics.checks import Verdict

if TYPE_CHECKING:
    from drysim.excitation.base import Until
    from drysim.scenario.model import Scenario
    from drysim.study.rows import Row


CONFIDENCE = 0.95
"""Share of ensembles whose interval holds the true mean [-]."""

QUANTILES = (0.05, 0.50, 0.95)
"""Shares of the seeds [-] below the quantiles that are given."""


class Statistic(NamedTuple):
    """What a metric is over the seeds that know it, in its unit.

    Attributes
    ----------
    seeds : int
        How many know it.
    mean : float
    half_width : float or None
        Half of the confidence interval of the mean, by Student's t; None for one seed.
    std : float or None
        Standard deviation of a single seed, by n - 1; None for one seed.
    quantiles : tuple of float
        As `QUANTILES` says.
    least, greatest : tuple of (float, int)
        Value and the first seed that has it.
    """

    seeds: int
    mean: float
    half_width: float | None
    std: float | None
    quantiles: tuple[float, ...]
    least: tuple[float, int]
    greatest: tuple[float, int]


def statistics(rows: Sequence[Row]) -> dict[str, Statistic | None]:
    """Give the statistics of every metric that rows have, one row for each seed, in order.

    None where no row knows it.
    """
    names = dict.fromkeys(name for row in rows for name in row.metrics)
    return {name: _statistic(rows, name) for name in names}


def _statistic(rows: Sequence[Row], name: str) -> Statistic | None:
    """Give the statistics of a metric over the seeds that know it."""
    found = ((row.seed, row.metrics.get(name)) for row in rows)
    values = {seed: value for seed, value in found if value is not None and isfinite(value)}
    if not values:
        return None
    import numpy as np

    series = np.array(list(values.values()))
    # Of the common definitions the one that leans least on how the values are distributed.
    quantiles = np.quantile(series, QUANTILES, method="median_unbiased").tolist()
    least, greatest = (choose(values, key=values.__getitem__) for choose in (min, max))
    return Statistic(
        len(values), *_moments(series.tolist()), tuple(quantiles),
        (values[least], least), (values[greatest], greatest),
    )  # fmt: skip


def interval(values: Iterable[float]) -> tuple[float, float | None]:
    """Give the mean of values and half of its confidence interval, None for a single one.

    Notes
    -----
    Sums are exact, so neither depends on the order of the values.
    """
    mean, half_width, _ = _moments(list(values))
    return mean, half_width


def _moments(values: Sequence[float]) -> tuple[float, float | None, float | None]:
    """Give mean, half-width of its interval and standard deviation."""
    n, least = len(values), min(values)
    # Over what they span: equal values have themselves for a mean, and no square overflows.
    span = max(values) - least or 1.0
    shares = [(value - least) / span for value in values]
    share = fsum(shares) / n
    mean = least + span * share
    if n < 2:
        return mean, None, None
    std = span * sqrt(fsum((one - share) ** 2 for one in shares) / (n - 1))
    return mean, student(n - 1) * std / sqrt(n), std


@cache
def student(freedom: int) -> float:
    """Give Student's t that both tails beyond the confidence share, by degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))


def about_mean(verdict: Verdict, half_width: float | None, seeds: int) -> Verdict:
    """Give a verdict with what is known of the mean that it is about, if it applies."""
    if verdict.passed is None:
        return verdict
    return replace(verdict, half_width=half_width, seeds=seeds)


# The seeds, one after the other, and when they are enough.

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
    """Tell whether these seeds, the first ones in order, are all that are needed."""
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
