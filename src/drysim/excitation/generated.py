"""What base motions that are generated share: their grid, their end, and how they are drawn."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from drysim.core.motion import Samples
from drysim.excitation.noise import numbers
from drysim.quantity import Block, Misfit, Quantity

WHOLE = 1e-9
"""A time this close to a whole number of steps, relative to it, is that number."""

Span = Annotated[float, Quantity("s", above=0)]


class Generated(Block):
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
    """A run ends with its base motion unless the scenario says otherwise."""

    @property
    def spans(self) -> dict[str, float]:
        """The whole of it."""
        return {"duration": self.duration}


class Drawn(Ending):
    """Random base motion: the same seed gives the same motion."""

    seed: Annotated[int, Field(strict=True, ge=0)]
    """Seed of the random numbers [-], a whole number; another seed, another signal."""

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency of the spectrum [Hz]."""
        raise NotImplementedError

    @property
    def highest(self) -> float:
        """Last frequency of the spectrum [Hz]."""
        return self.band[1]

    def drawn(self, step: float) -> Samples:
        """Give the samples at a step [s] that suits."""
        raise NotImplementedError

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Draw the base acceleration on a grid, and what else is known of the motion.

        Parameters
        ----------
        step : float
            Distance of the samples [s].
        end : float, optional
            Not used: the motion has a length of its own.

        Returns
        -------
        Samples
            From 0 to `duration`; the last sample is the first one again.

        Raises
        ------
        Misfit
            When the step does not suit.
        """
        assert step is not None, "a generated signal needs a step"
        self.check_step(step)
        return self.drawn(step)

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
