"""Designs: points spread over a unit cube, each to be had by its number alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]
Shares = NDArray[np.float64]

CHUNK = 4096
"""Points whose random numbers are drawn together: what any of them needs is drawn with it."""

ROUNDS = 6
"""Rounds of the permutation; four would do for one that nobody attacks."""

MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
"""Odd factors of the finaliser of SplitMix64 (Steele, Lea and Flood 2014)."""

STRIDE = np.uint64(0x9E3779B97F4A7C15)
"""Golden ratio, by which the seeds of the rounds are told apart."""

SOBOL_BITS = 30
"""Digits of a Sobol point by default: as many points are told apart as they have values."""


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

    def at(self, numbers: Numbers) -> Shares:
        """Give some points by their numbers, shape (n, dimensions), each share within 0..1."""
        if self.kind == "sobol":
            return self._sobol(numbers)
        within = self._uniform(numbers)
        if self.kind == "uniform":
            return within
        layers = [self._layer(numbers, k) for k in range(self.dimensions)]
        return (np.stack(layers, axis=1) + within) / self.count

    def _uniform(self, numbers: Numbers) -> Shares:
        """Give independent points; each block of them has a stream of its own."""
        found = np.empty((len(numbers), self.dimensions))
        blocks = numbers // CHUNK
        for block in np.unique(blocks).tolist():
            stream = np.random.Generator(np.random.Philox(key=[self.seed, block]))
            drawn = stream.random((CHUNK, self.dimensions))
            here = blocks == block
            found[here] = drawn[numbers[here] % CHUNK]
        return found

    def _layer(self, numbers: Numbers, dimension: int) -> Shares:
        """Give where a permutation of all points puts some: a Feistel network, cycle-walked."""
        half = max(1, (int(self.count - 1).bit_length() + 1) // 2)
        values = numbers.astype(np.uint64)
        values = self._feistel(values, half, dimension)
        while (beyond := values >= self.count).any():
            values[beyond] = self._feistel(values[beyond], half, dimension)
        found: Shares = values.astype(np.float64)
        return found

    def _feistel(self, values: Any, half: int, dimension: int) -> Any:
        """Give a permutation of the numbers of twice so many binary digits."""
        mask, shift = np.uint64((1 << half) - 1), np.uint64(half)
        left, right = values >> shift, values & mask
        for turn in range(ROUNDS):
            salt = np.uint64((self.seed * 1_000_003 + dimension * ROUNDS + turn) % (1 << 64))
            with np.errstate(over="ignore"):
                mixed = right + (salt + np.uint64(1)) * STRIDE
                for factor, bits in zip(MIX, (30, 27), strict=True):
                    mixed = (mixed ^ (mixed >> np.uint64(bits))) * factor
            left, right = right, left ^ ((mixed ^ (mixed >> np.uint64(31))) & mask)
        return (left << shift) | right

    def _sobol(self, numbers: Numbers) -> Shares:
        """Give points of the scrambled Sobol sequence: sums, bit by bit, of its directions."""
        directions, shift, scale = self._directions
        codes = numbers.astype(np.uint64)
        codes ^= codes >> np.uint64(1)  # Gray's code: neighbours differ in one digit
        digits = np.broadcast_to(shift, (len(codes), len(shift))).copy()
        for bit in range(int(codes.max(initial=0)).bit_length()):
            asked = (codes >> np.uint64(bit)) & np.uint64(1) == 1
            digits[asked] ^= directions[:, bit]
        points: Shares = digits * scale
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
