"""What base motions that are generated share: a duration, a seed, and steps that fit in."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from drysim.quantity import Block, Misfit, Quantity

WHOLE = 1e-9
"""A duration this close to a whole number of steps, relative to it, is that number."""


class Generated(Block):
    """Base motion that is computed on the grid of solver.step, and ends."""

    duration: Annotated[float, Quantity("s", above=0)]
    """Length of the base motion [s], a whole number of steps."""

    own_end: ClassVar[bool] = True
    """A run ends with its base motion unless the scenario says otherwise."""

    @property
    def highest(self) -> float:
        """Highest frequency of the base motion [Hz], which the step must be able to carry."""
        return 0.0

    def check_step(self, step: float) -> None:
        """Make sure that samples at this distance [s] can hold the base motion.

        Raises
        ------
        Misfit
            When the duration is no whole number of steps, or half a period of the highest
            frequency is not longer than a step.
        """
        steps = round(self.duration / step)
        if abs(self.duration / step - steps) > WHOLE * steps:
            raise Misfit(
                f"must divide excitation.duration, {self.duration:.12g} s, into whole steps; "
                f"{step:.12g} s does so with {steps * step or step:.12g} s",
                "step",
            )
        if 2 * self.highest * step >= 1:
            raise Misfit(
                f"must be below {1 / (2 * self.highest):.4g} s, half a period of the highest "
                f"frequency of the excitation, {self.highest:.6g} Hz; not {step:.12g} s",
                "step",
            )


class Drawn(Generated):
    """Random base motion: the same seed gives the same motion."""

    seed: Annotated[int, Field(strict=True, ge=0)]
    """Seed of the random numbers [-], a whole number; another seed, another signal."""
