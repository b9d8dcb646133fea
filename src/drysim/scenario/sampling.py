"""Samples: points spread over a cube, and the distributions that make values of them.

Every point of a `Design` (Latin hypercube, Sobol, independent) is to be had by its number
alone, so a sample of any size is never held: `SampledValues` makes the values of a key when they are
asked for, as every `LazySequence` sequence does.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, log, log1p, sqrt
from operator import index
from typing import Any, Protocol, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from drysim.wording import format_number

Indices = NDArray[np.int64]
Floats = NDArray[np.float64]

POINTS_PER_CHUNK = 4096
"""Points whose random numbers are drawn together: what any of them needs is drawn with it."""

FEISTEL_ROUNDS = 6
"""Rounds of the permutation; four would do for one that nobody attacks."""

SPLITMIX_FACTORS = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
"""Odd factors of the finaliser of SplitMix64 (Steele, Lea and Flood 2014)."""

GOLDEN_RATIO = np.uint64(0x9E3779B97F4A7C15)
"""Golden ratio, by which the seeds of the rounds are told apart."""

SOBOL_BITS = 30
"""Digits of a Sobol point by default: as many points are told apart as they have values."""


MAX_PROBABILITY = 1.0 - 2.0**-53
"""The double before 1: below no finite value lie all, but sums of shares round up to it."""
TAIL_START = 4.0
"""Standard deviations from the mean beyond which a range has its shares by logarithms."""
MIN_FLOAT = float(np.finfo(float).tiny)
MAX_FLOAT = float(np.finfo(float).max)

Made = TypeVar("Made", covariant=True)


class LazySequence(Sequence[Made]):
    """A sequence of a known length that makes one value at a time, and holds none."""

    @abstractmethod
    def one(self, number: int) -> Made:
        """Give the value of a number from 0 to the length less 1."""

    @overload
    def __getitem__(self, number: int) -> Made: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Made]: ...
    def __getitem__(self, number: int | slice) -> Made | Sequence[Made]:
        """Give one value, or some."""
        if isinstance(number, slice):
            return [self.one(i) for i in range(*number.indices(len(self)))]
        at, count = index(number), len(self)
        if not -count <= at < count:
            raise IndexError(f"there is no number {at} among {count}, counted from 0")
        return self.one(at % count)


@dataclass(frozen=True)
class SampledValues(LazySequence[float]):
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
        for begin in range(0, len(self), POINTS_PER_CHUNK):
            numbers = np.arange(begin, min(begin + POINTS_PER_CHUNK, len(self)))
            yield from self.at(numbers).tolist()

    def at(self, numbers: Indices) -> Floats:
        """Give some values by their numbers."""
        return self.of(self.design.at(numbers))

    def of(self, shares: Floats) -> Floats:
        """Give the values of points of the design, shape (n, dimensions)."""
        return self.law.quantile(shares[:, self.dimension])


@dataclass(frozen=True)
class Design:
    """A number of points in a cube of some dimensions.

    Attributes
    ----------
    kind : str
        `uniform` (independent), `latin` (one point in every layer of every dimension) or
        `sobol` (scrambled by Owen's method: even in every projection).
    count, dimensions, seed : int
    """

    kind: str
    count: int
    dimensions: int
    seed: int

    def at(self, numbers: Indices) -> Floats:
        """Give some points by their numbers, shape (n, dimensions), each share within 0..1."""
        if self.kind == "sobol":
            return self._sobol(numbers)
        within = self._uniform(numbers)
        if self.kind == "uniform":
            return within
        layers = [self._permuted(numbers, k) for k in range(self.dimensions)]
        return (np.stack(layers, axis=1) + within) / self.count

    def _uniform(self, numbers: Indices) -> Floats:
        """Give independent points; each block of them has a stream of its own."""
        found = np.empty((len(numbers), self.dimensions))
        blocks = numbers // POINTS_PER_CHUNK
        for block in np.unique(blocks).tolist():
            stream = np.random.Generator(np.random.Philox(key=[self.seed, block]))
            drawn = stream.random((POINTS_PER_CHUNK, self.dimensions))
            here = blocks == block
            found[here] = drawn[numbers[here] % POINTS_PER_CHUNK]
        return found

    def _permuted(self, numbers: Indices, dimension: int) -> Floats:
        """Give where a permutation of all points puts some: a Feistel network, cycle-walked."""
        half = max(1, (int(self.count - 1).bit_length() + 1) // 2)
        values = numbers.astype(np.uint64)
        values = self._feistel(values, half, dimension)
        while (beyond := values >= self.count).any():
            values[beyond] = self._feistel(values[beyond], half, dimension)
        found: Floats = values.astype(np.float64)
        return found

    def _feistel(self, values: Any, half: int, dimension: int) -> Any:
        """Give a permutation of the numbers of twice so many binary digits."""
        mask, shift = np.uint64((1 << half) - 1), np.uint64(half)
        left, right = values >> shift, values & mask
        for turn in range(FEISTEL_ROUNDS):
            salt = np.uint64(
                (self.seed * 1_000_003 + dimension * FEISTEL_ROUNDS + turn) % (1 << 64)
            )
            with np.errstate(over="ignore"):
                mixed = right + (salt + np.uint64(1)) * GOLDEN_RATIO
                for factor, bits in zip(SPLITMIX_FACTORS, (30, 27), strict=True):
                    mixed = (mixed ^ (mixed >> np.uint64(bits))) * factor
            left, right = right, left ^ ((mixed ^ (mixed >> np.uint64(31))) & mask)
        return (left << shift) | right

    def _sobol(self, numbers: Indices) -> Floats:
        """Give points of the scrambled Sobol sequence: sums, bit by bit, of its directions."""
        directions, shift, scale = self._directions
        codes = numbers.astype(np.uint64)
        codes ^= codes >> np.uint64(1)  # Gray's code: neighbours differ in one digit
        digits = np.broadcast_to(shift, (len(codes), len(shift))).copy()
        for bit in range(int(codes.max(initial=0)).bit_length()):
            asked = (codes >> np.uint64(bit)) & np.uint64(1) == 1
            digits[asked] ^= directions[:, bit]
        points: Floats = digits * scale
        return points

    @cached_property
    def _directions(self) -> tuple[Any, Any, float]:
        """The scrambled directions of all dimensions, their shift and the unit of a digit.

        Taken from within scipy, which itself has no way to a point but through all before it.
        """
        from scipy.stats import qmc

        bits = SOBOL_BITS if self.count <= 1 << SOBOL_BITS else 64
        source = np.random.Generator(np.random.PCG64(self.seed))
        sobol: Any = qmc.Sobol
        engine = sobol(self.dimensions, scramble=True, bits=bits, **{self._word: source})
        return engine._sv, engine._shift, engine._scale

    @cached_property
    def _word(self) -> str:
        """What scipy calls its source of random numbers; newer ones say rng."""
        from inspect import signature

        from scipy.stats import qmc

        return "rng" if "rng" in signature(qmc.Sobol.__init__).parameters else "seed"


class Distribution(Protocol):
    """How the values of a key scatter."""

    def quantile(self, share: Floats) -> Floats:
        """Give the values below which these shares of all lie."""

    def describe(self, unit: str) -> str:
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

    def describe(self, unit: str) -> str:
        """Give it in words."""
        return (
            f"{format_number(self.low)} to {format_number(self.high, unit)}{', log' * self.log}"
        )


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
        if low > TAIL_START:
            scaled = -_tail_quantile(-high, -low, 1.0 - share, share)
        elif high < -TAIL_START:
            scaled = _tail_quantile(low, high, share, 1.0 - share)
        else:
            scaled = _truncated_quantile(low, high, share)
        return np.asarray(np.clip(self.mean + self.sd * scaled, self.low, self.high))

    def describe(self, unit: str) -> str:
        """Give it in words."""
        return (
            f"normal, mean {format_number(self.mean, unit)}, sd {format_number(self.sd, unit)}"
        )


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
        square = max(log1p(min(ratio * ratio, MAX_FLOAT)), MIN_FLOAT)
        low = log(self.low) if self.low > 0.0 else -inf
        high = log(self.high) if self.high < inf else inf
        inner = Normal(log(self.mean) - 0.5 * square, sqrt(square), low, high)
        return np.asarray(np.clip(np.exp(inner.quantile(share)), self.low, self.high))

    def describe(self, unit: str) -> str:
        """Give it in words."""
        return f"lognormal, mean {format_number(self.mean, unit)}, sd {format_number(self.sd, unit)}"


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

    def describe(self, unit: str) -> str:
        """Give it in words."""
        ends = f"{format_number(self.low)} to {format_number(self.high, unit)}"
        return f"triangular, {ends}, mode {format_number(self.mode, unit)}"


def _truncated_quantile(low: float, high: float, share: Floats) -> Floats:
    """Give quantiles of the standard normal distribution, cut at ends of which none is far."""
    from scipy.special import ndtr, ndtri

    below, upto = ndtr(low), ndtr(high)
    return np.asarray(ndtri(np.minimum(below + share * (upto - below), MAX_PROBABILITY)))


def _tail_quantile(low: float, high: float, share: Floats, rest: Floats) -> Floats:
    """Give quantiles of the standard normal distribution, cut at ends far below its mean.

    By logarithms: the shares below the ends themselves vanish in double precision from 38
    standard deviations on. `rest` is what `share` leaves of 1. Where even a logarithm would
    overflow, the quantiles lie above `high`, the end that nearly all values are next to.
    """
    from scipy.special import log_ndtr, ndtri_exp

    below, upto = (max(float(log_ndtr(end)), -MAX_FLOAT / 4) for end in (low, high))
    of_low, of_high = (np.log(np.maximum(part, MIN_FLOAT)) for part in (rest, share))
    return np.asarray(ndtri_exp(np.logaddexp(below + of_low, upto + of_high)))
