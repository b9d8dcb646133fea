"""Base class of the approaches, and those that are exact.

`StickSlip` switches exactly between sticking and sliding (Eqs. 4, 7, 9); `Viscous` is the same
oscillator without dry friction, the reference curve.
"""

from typing import ClassVar, Literal

from drysim.approach import exact
from drysim.approach.solution import Response, Trajectory
from drysim.block import Block
from drysim.core.model import (
    AnyLaw,
    AnyState,
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
)


class ApproachBase(Block):
    """Approach with its options. A scenario that uses an unsupported feature is an error."""

    supports_friction: ClassVar[bool] = True
    """Whether dry friction is modelled."""
    supports_static: ClassVar[bool] = False
    """Whether the static limit may exceed kinetic friction."""
    supports_variation: ClassVar[bool] = False
    """Whether the normal force may vary."""
    supports_dynamic: ClassVar[bool] = False
    """Whether friction laws other than Coulomb's are modelled."""
    supports_stops: ClassVar[bool] = False
    """Whether end stops are modelled."""
    supports_direction: ClassVar[bool] = False
    """Whether friction and damping may depend on the direction of motion."""

    def substeps(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Return the number of integration steps per step of the output grid [s]."""
        return 1


class ExactApproach(ApproachBase):
    """Base of the exact approaches, which differ in the friction that acts.

    Only they provide a `trajectory` without a grid; `drysim.orbits` finds periodic orbits.
    """

    supports_dynamic: ClassVar[bool] = True
    supports_stops: ClassVar[bool] = True
    supports_direction: ClassVar[bool] = True

    def effective_law(self, law: AnyLaw) -> AnyLaw:
        """Return the part of a friction law that acts: all of it."""
        return law

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
        *,
        whole: bool = True,
    ) -> Response:
        """Return the response from t = 0 to `duration` [s], or to the end of the samples.

        Parameters
        ----------
        plant, law, motion, start
            The scene.
        step : float
            Step of the output grid [s]; not used for samples, which have their own.
        duration : float or None
            Length of the run [s]; optional for samples.
        whole : bool
            Whether to keep all of a long motion over samples in memory, or one block of it.

        Raises
        ------
        SolverError
            If events do not advance in time, or the motion is not finite.
        """
        law = self.effective_law(law)
        return exact.solve(plant, law, motion, start, step, duration, whole)

    def trajectory(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        duration: float | None = None,
    ) -> Trajectory:
        """Return the trajectory without a grid; metrics need no more.

        Parameters and errors as in `solve`.
        """
        law = self.effective_law(law)
        return exact.compute_trajectory(plant, law, motion, start, duration)


class StickSlip(ExactApproach):
    """Stick below the friction limit and sliding above it, both exact.

    Not to be confused with a fixed-step method with a velocity band: here the stop is located,
    and v_r is exactly zero.
    """

    supports_static: ClassVar[bool] = True
    supports_variation: ClassVar[bool] = True

    approach: Literal["stick-slip"] = "stick-slip"


NO_FRICTION = CoulombLaw(0.0, 0.0)


class Viscous(ExactApproach):
    """Spring and damper alone, without the dry friction of the scene.

    Not to be confused with equivalent viscous damping: nothing replaces the friction.
    """

    supports_friction: ClassVar[bool] = False

    approach: Literal["viscous"] = "viscous"

    def effective_law(self, law: AnyLaw) -> AnyLaw:
        """Return no dry friction, with the same end stops and damper."""
        if law.stops is None and law.damping is None:
            return NO_FRICTION
        return PiecewiseLaw(0.0, 0.0, stops=law.stops, damping=law.damping)
