"""What an approach declares, and those that are solved exactly.

Stick-slip switches exactly between sticking and sliding (Eqs. 4, 7, 9); viscous is the same
plant without dry friction, the reference curve.
"""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar, Literal

from drysim.approach.solution import Orbit, Response, Trajectory
from drysim.core.model import AnyLaw, AnyState, CoulombLaw, EndStopLaw, Plant, Samples, Sines
from drysim.units import Block


class ApproachBase(Block):
    """An approach with its options; a scenario that names what it cannot use is at fault."""

    supports_friction: ClassVar[bool] = True
    """Whether it can use dry friction at all."""
    supports_static: ClassVar[bool] = False
    """Whether it knows a static limit above kinetic friction."""
    supports_variation: ClassVar[bool] = False
    """Whether it knows a normal force that varies."""
    supports_dynamic: ClassVar[bool] = False
    """Whether it knows other laws than Coulomb's."""
    supports_stops: ClassVar[bool] = False
    """Whether it knows end stops."""

    def substeps(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Give the number of points that are computed for a step of the output grid [s]."""
        return 1


@cache
def solver() -> Any:
    """Give the module that solves; it brings the kernels, so it is loaded when first used."""
    from drysim.approach import exact

    return exact


class ExactApproach(ApproachBase):
    """What the approaches do that follow a motion exactly; they differ in what rubs.

    They alone give a `trajectory` without a grid, and orbits; all others march by fixed steps.
    """

    supports_dynamic: ClassVar[bool] = True
    supports_stops: ClassVar[bool] = True

    def effective_law(self, law: AnyLaw) -> AnyLaw:
        """Give what acts of a law: all of it."""
        return law

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response from t = 0 to `duration` [s], or to the end of the samples.

        Parameters
        ----------
        plant, law, motion, start
            The scene.
        step : float
            Distance of the output grid [s]; samples own their step, so it is not used for them.
        duration : float or None
            Length of the run [s]; samples may do without.

        Raises
        ------
        SolverError
            When events follow each other without end or the motion leaves the numbers.
        """
        law = self.effective_law(law)
        response: Response = solver().solve(plant, law, motion, start, step, duration, True)
        return response

    def solve_in_blocks(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response as `solve` does; of a long one no more than a part is ever held."""
        law = self.effective_law(law)
        response: Response = solver().solve(plant, law, motion, start, step, duration, False)
        return response

    def trajectory(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Trajectory:
        """Give the solution without its grid, which is all that metrics need.

        Parameters and errors as in `solve`; under sines no grid takes part.
        """
        trajectory: Trajectory = solver().compute_trajectory(
            plant, self.effective_law(law), motion, start, duration
        )
        return trajectory

    def orbit(
        self, plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
    ) -> Orbit:
        """Give the periodic orbit that the start leads to; period of the excitation in s."""
        from drysim.approach.steady_state import find_orbit

        return find_orbit(plant, self.effective_law(law), motion, start, period)


class StickSlip(ExactApproach):
    """The mass sticks below the friction limit and slides above it; both exactly.

    Not to be confused with a fixed-step march that decides by a velocity band: here the stop is
    located and v_r is zero exactly.
    """

    supports_static: ClassVar[bool] = True
    supports_variation: ClassVar[bool] = True

    approach: Literal["stick-slip"] = "stick-slip"


NO_FRICTION = CoulombLaw(0.0, 0.0)


class Viscous(ExactApproach):
    """Spring and damper alone; what the friction of the scene would be is left out.

    Not to be confused with an equivalent viscous damping: nothing stands in for the friction.
    """

    supports_friction: ClassVar[bool] = False

    approach: Literal["viscous"] = "viscous"

    def effective_law(self, law: AnyLaw) -> AnyLaw:
        """Give no dry friction, between the same end stops."""
        return law._replace(F_fk=0.0, F_fs=0.0) if isinstance(law, EndStopLaw) else NO_FRICTION
