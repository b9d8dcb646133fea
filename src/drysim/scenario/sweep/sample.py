"""The blocks by which a file asks for a sample: points drawn over several keys at once."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, WithJsonSchema

from drysim.quantity import Block
from drysim.scenario.sweep.axis import KEY, Number

OVER = {"type": "object", "minProperties": 1, "propertyNames": {"pattern": KEY}}
"""What the keys of a sample look like to an editor."""


class Draw(Block):
    """How the values of one key scatter: between two ends, or by a distribution."""

    low: Number = Field(None, alias="from")
    """Least value. A normal or lognormal distribution is cut there; without ends it is cut at
    the bounds of the key itself, as a mass is above 0."""
    high: Number = Field(None, alias="to")
    """Greatest value; as for `from`."""
    scale: Literal["linear", "log"] | None = None
    """Whether equal differences (linear, the default) or equal ratios (log) have equal chances;
    for the uniform distribution."""
    distribution: Literal["uniform", "normal", "lognormal", "triangular"] | None = None
    """Default: uniform."""
    mean: Number = None
    """Mean of a normal or lognormal distribution."""
    sd: Number = None
    """Standard deviation of a normal or lognormal distribution, in the unit of the key."""
    mode: Number = None
    """Most likely value of a triangular distribution."""

    takes: ClassVar[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
        "uniform": (("from", "to"), ("scale",)),
        "normal": (("mean", "sd"), ("from", "to")),
        "lognormal": (("mean", "sd"), ("from", "to")),
        "triangular": (("from", "mode", "to"), ()),
    }
    """What a distribution needs, and what it may have besides."""


class Sample(Block):
    """Cases that are drawn, in place of a grid: every case has its own value of every key."""

    kind: Literal["latin", "sobol", "uniform"]
    """Latin hypercube (every layer of every key has one case), Sobol sequence (scrambled; best
    with a power of two), or independent draws."""
    count: int
    """Number of cases, at least 1."""
    seed: int
    """Seed of the random numbers, a whole number; the same seed, the same cases."""
    over: Annotated[dict[str, Any], WithJsonSchema(OVER)]
    """Dotted keys of this file, each with the range or distribution that it is drawn from."""
