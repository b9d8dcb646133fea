"""Drawn: the values of a key that a sample draws, made when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, log, log1p, sqrt
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.scenario.sweep.design import CHUNK, Design
from drysim.scenario.sweep.lazy import Lazy
from drysim.wording import number

Floats = NDArray[np.float64]

SURE = 1.0 - 2.0**-53
"""The double before 1: below no finite value lie all, but sums of shares round up to it."""
TAIL = 4.0
"""Standard deviations from the mean beyond which a range has its shares by logarithms."""
LEAST = float(np.finfo(float).tiny)
MOST = float(np.finfo(float).max)


class Distribution(Protocol):
    """How the values of a key scatter."""

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""

    def words(self, unit: str) -> str:
        """Give it in words."""


@dataclass(frozen=True)
class Uniform:
    """Equal chances from `low` to `high`: by difference, or by ratio (log)."""

    low: float
    high: float
    log: bool = False

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""
        if self.log:
            return self.low * np.exp(share * log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def words(self, unit: str) -> str:
        """Give it in words."""
        return f"{number(self.low)} to {number(self.high, unit)}{', log' * self.log}"


@dataclass(frozen=True)
class Normal:
    """Gauss's distribution by mean and standard deviation, cut at `low` and `high`."""

    mean: float
    sd: float
    low: float = -inf
    high: float = inf

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""
        low, high = ((end - self.mean) / self.sd for end in (self.low, self.high))
        if low > TAIL:
            scaled = -_in_lower_tail(-high, -low, 1.0 - share, share)
        elif high < -TAIL:
            scaled = _in_lower_tail(low, high, share, 1.0 - share)
        else:
            scaled = _about_the_mean(low, high, share)
        return np.asarray(np.clip(self.mean + self.sd * scaled, self.low, self.high))

    def words(self, unit: str) -> str:
        """Give it in words."""
        return f"normal, mean {number(self.mean, unit)}, sd {number(self.sd, unit)}"


@dataclass(frozen=True)
class LogNormal:
    """A value whose logarithm is normal, by its own mean and standard deviation."""

    mean: float
    sd: float
    low: float = 0.0
    high: float = inf

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""
        ratio = self.sd / self.mean
        square = max(log1p(min(ratio * ratio, MOST)), LEAST)
        low = log(self.low) if self.low > 0.0 else -inf
        high = log(self.high) if self.high < inf else inf
        inner = Normal(log(self.mean) - 0.5 * square, sqrt(square), low, high)
        return np.asarray(np.clip(np.exp(inner.quantile(share)), self.low, self.high))

    def words(self, unit: str) -> str:
        """Give it in words."""
        return f"lognormal, mean {number(self.mean, unit)}, sd {number(self.sd, unit)}"


@dataclass(frozen=True)
class Triangular:
    """Chances that rise from `low` to `mode` and fall to `high`."""

    low: float
    mode: float
    high: float

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""
        width, rise, fall = self.high - self.low, self.mode - self.low, self.high - self.mode
        lower = self.low + np.sqrt(share * width * rise)
        upper = self.high - np.sqrt((1.0 - share) * width * fall)
        return np.where(share * width <= rise, lower, upper)

    def words(self, unit: str) -> str:
        """Give it in words."""
        ends = f"{number(self.low)} to {number(self.high, unit)}"
        return f"triangular, {ends}, mode {number(self.mode, unit)}"


def _about_the_mean(low: float, high: float, share: Floats) -> Floats:
    """Give quantiles of the standard normal distribution, cut at ends of which none is far."""
    from scipy.special import ndtr, ndtri

    below, upto = ndtr(low), ndtr(high)
    return np.asarray(ndtri(np.minimum(below + share * (upto - below), SURE)))


def _in_lower_tail(low: float, high: float, share: Floats, rest: Floats) -> Floats:
    """Give quantiles of the standard normal distribution, cut at ends far below its mean.

    By logarithms: the shares below the ends themselves vanish in double precision from 38
    standard deviations on. `rest` is what `share` leaves of 1. Where even a logarithm would
    overflow, the quantiles lie above `high`, the end that nearly all values are next to.
    """
    from scipy.special import log_ndtr, ndtri_exp

    below, upto = (max(float(log_ndtr(end)), -MOST / 4) for end in (low, high))
    of_low, of_high = (np.log(np.maximum(part, LEAST)) for part in (rest, share))
    return np.asarray(ndtri_exp(np.logaddexp(below + of_low, upto + of_high)))


@dataclass(frozen=True)
class Drawn(Lazy[float]):
    """The values of one dimension of a design."""

    design: Design
    dimension: int
    law: Distribution

    def __len__(self) -> int:
        """Give the number of points."""
        return self.design.count

    def one(self, number: int) -> float:
        """Give one value."""
        return float(self.at(np.array([number])).item())

    def __iter__(self) -> Iterator[float]:
        """Return the values in order, drawn block by block: one alone costs a whole block."""
        for begin in range(0, len(self), CHUNK):
            numbers = np.arange(begin, min(begin + CHUNK, len(self)))
            yield from self.at(numbers).tolist()

    def at(self, numbers: NDArray[np.int64]) -> Floats:
        """Give some values by their numbers."""
        return self.of(self.design.at(numbers))

    def of(self, shares: Floats) -> Floats:
        """Give the values of points of the design, shape (n, dimensions)."""
        return self.law.quantile(shares[:, self.dimension])
