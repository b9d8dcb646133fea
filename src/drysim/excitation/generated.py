"""What base motions that are generated share: their grid, their end, and how they are drawn."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from drysim.core.motion import Samples
from drysim.excitation.member import Member
from drysim.excitation.noise import numbers
from drysim.quantity import Block, Misfit, Quantity, shown

WHOLE = 1e-9
"""A time this close to a whole number of steps, relative to it, is that number."""

Span = Annotated[float, Quantity("s", above=0)]


def as_whole(given: object) -> object:
    """Give 1e3 as the whole number that it is."""
    return int(given) if isinstance(given, float) and given.is_integer() else given


Whole = Annotated[int, BeforeValidator(as_whole), Field(strict=True)]

MOST = 400
"""Seeds at which `until` gives up by default: then the interval is no wider than a tenth of
what a single seed scatters."""


class Generated(Member):
    """Base motion that is computed on the grid of solver.step, linear between its points."""

    @property
    def highest(self) -> float:
        """Highest frequency of the base motion [Hz], which the step must be able to carry."""
        return 0.0

    @property
    def spans(self) -> dict[str, float]:
        """Times of the base motion [s] that must be whole numbers of steps, by key."""
        return {}

    def check_step(self, step: float) -> None:
        """Make sure that a grid of this step [s] can hold the base motion.

        Raises
        ------
        Misfit
            When a span is no whole number of steps, or half a period of the highest frequency
            is not longer than a step.
        """
        for key, span in self.spans.items():
            steps = round(span / step)
            if abs(span / step - steps) > WHOLE * steps:
                raise Misfit(
                    f"must divide excitation.{key}, {span:.12g} s, into whole steps; "
                    f"{step:.12g} s does so with {max(steps, 1) * step:.12g} s",
                    "step",
                )
        if 2 * self.highest * step >= 1:
            raise Misfit(
                f"must be below {1 / (2 * self.highest):.4g} s, half a period of the highest "
                f"frequency of the excitation, {self.highest:.6g} Hz; not {step:.12g} s",
                "step",
            )


class Ending(Generated):
    """Base motion that is generated and has a length of its own."""

    duration: Span
    """Length of the base motion [s], a whole number of steps."""

    own_end: ClassVar[bool] = True

    @property
    def spans(self) -> dict[str, float]:
        """The whole of it."""
        return {"duration": self.duration}

    def drawn(self, step: float) -> Samples:
        """Give the samples from 0 to `duration` at a step [s] that suits."""
        raise NotImplementedError

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Give the base acceleration on a grid, and what else is known of the motion.

        Parameters
        ----------
        step : float
            Distance of the samples [s].
        end : float, optional
            Not used: the motion has a length of its own.

        Raises
        ------
        Misfit
            When the step does not suit.
        """
        assert step is not None, "a generated signal needs a step"
        self.check_step(step)
        return self.drawn(step)


class Until(Block):
    """How narrow the confidence interval of a mean over seeds is to become."""

    metric: str
    """Name of a metric, from `a_u` to `energy_residual` in their table."""
    half_width: Annotated[float, Quantity("", above=0)]
    """Half of its 95 % confidence interval over its mean [-], such as `1 %`."""


class Drawn(Ending):
    """Random base motion: the same seed gives the same motion, whose last sample is the first.

    With `seeds` or `until` it stands for many motions, one for each seed from `seed` on.
    """

    seed: Annotated[Whole, Field(ge=0)] = 1
    """Seed of the random numbers [-], a whole number; another seed, another signal. The first
    one where there are many."""
    seeds: Annotated[Whole, Field(le=1_000_000_000)] | None = None
    """How many seeds [-], 2 or more: `seed`, `seed` + 1 and so on, each a run of its own. The
    metrics are means over them, with confidence intervals. Beside `until` the most there may
    be; 400 when it is not given."""
    until: Until | None = None
    """Draws seeds until the confidence interval of a metric is as narrow as asked; looked at
    after every tenth seed."""

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("seed", "seeds", "until"),)

    @property
    def most_seeds(self) -> int:
        """How many seeds it stands for at most [-]; 1 where neither key asks for more."""
        return (self.seeds or MOST) if self.until else (self.seeds or 1)

    def of_seed(self, seed: int) -> Self:
        """Give the motion of one seed alone."""
        return self.model_copy(update={"seed": seed, "seeds": None, "until": None})

    @field_validator("seeds")
    @classmethod
    def _several(cls, seeds: int | None) -> int | None:
        if seeds is not None and seeds < 2:
            sentence = "must be at least 2, as one seed has no confidence interval"
            raise ValueError(f"{sentence}; not {shown(seeds)}")
        return seeds

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency of the spectrum [Hz]."""
        raise NotImplementedError

    @property
    def highest(self) -> float:
        """Last frequency of the spectrum [Hz]."""
        return self.band[1]

    @model_validator(mode="after")
    def _long_enough(self) -> Self:
        low, high = self.band
        first, last = numbers(low, high, self.duration)
        if first > last:
            raise Misfit(
                f"must be at least {1 / (high - low):.4g} s: the lines of the spectrum are "
                f"1/duration apart, and none would be from {low:g} to {high:g} Hz",
                "duration",
            )
        return self
