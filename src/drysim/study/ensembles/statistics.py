"""Statistics of one metric over many seeds: mean, confidence interval, quantiles, extremes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from math import fsum, isfinite, sqrt
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from drysim.study.sweeps.table import Row

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
    return {name: _statistic(_known(rows, name)) for name in names}


def interval(values: Iterable[float]) -> tuple[float, float | None]:
    """Give the mean of values and half of its confidence interval, None for a single one.

    Notes
    -----
    Sums are exact, so neither depends on the order of the values.
    """
    mean, half_width, _ = _moments(list(values))
    return mean, half_width


def _known(rows: Sequence[Row], name: str) -> Mapping[int, float]:
    """Give the values of a metric by seed, where they are known."""
    found = ((row.seed, row.metrics.get(name)) for row in rows)
    return {seed: value for seed, value in found if value is not None and isfinite(value)}


def _statistic(values: Mapping[int, float]) -> Statistic | None:
    """Give the statistics of values by seed."""
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
