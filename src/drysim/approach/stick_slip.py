"""What an approach declares, and those that are solved exactly.

Stick-slip switches exactly between sticking and sliding (Eqs. 4, 7, 9); viscous is the same
plant without dry friction, the reference curve.
"""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar, Literal

from drysim.approach.solution import Orbit, Response, Track
from drysim.core.model import AnyLaw, AnyState, Law, Plant, Samples, Sines, Stopped
from drysim.units import Block


class Member(Block):
    """An approach with its options; a scenario that names what it cannot use is at fault."""

    use_friction: ClassVar[bool] = True
    """Whether it can use dry friction at all."""
    use_static: ClassVar[bool] = False
    """Whether it knows a static limit above kinetic friction."""
    use_variation: ClassVar[bool] = False
    """Whether it knows a normal force that varies."""
    use_dynamic: ClassVar[bool] = False
    """Whether it knows other laws than Coulomb's."""
    use_stops: ClassVar[bool] = False
    """Whether it knows end stops."""

    def pieces(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Give the number of points that are computed for a step of the output grid [s]."""
        return 1


@cache
def core() -> Any:
    """Give the module that solves; it brings the kernels, so it is loaded when first used."""
    from drysim.approach import exact

    return exact


class Exact(Member):
    """What the approaches do that follow a motion exactly; they differ in what rubs.

    They alone give a `track` without a grid, and orbits; all others march by fixed steps.
    """

    use_dynamic: ClassVar[bool] = True
    use_stops: ClassVar[bool] = True

    def acting(self, law: AnyLaw) -> AnyLaw:
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
        law = self.acting(law)
        response: Response = core().solve(plant, law, motion, start, step, duration, True)
        return response

    def by_parts(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response as `solve` does; of a long one no more than a part is ever held."""
        law = self.acting(law)
        response: Response = core().solve(plant, law, motion, start, step, duration, False)
        return response

    def track(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Track:
        """Give the solution without its grid, which is all that metrics need.

        Parameters and errors as in `solve`; under sines no grid takes part.
        """
        track: Track = core().follow(plant, self.acting(law), motion, start, duration)
        return track

    def orbit(
        self, plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
    ) -> Orbit:
        """Give the periodic orbit that the start leads to; period of the excitation in s."""
        from drysim.approach.steady_state import find_orbit

        return find_orbit(plant, self.acting(law), motion, start, period)


class StickSlip(Exact):
    """The mass sticks below the friction limit and slides above it; both exactly.

    Not to be confused with a fixed-step march that decides by a velocity band: here the stop is
    located and v_r is zero exactly.
    """

    use_static: ClassVar[bool] = True
    use_variation: ClassVar[bool] = True

    approach: Literal["stick-slip"] = "stick-slip"


NO_FRICTION = Law(0.0, 0.0)


class Viscous(Exact):
    """Spring and damper alone; what the friction of the scene would be is left out.

    Not to be confused with an equivalent viscous damping: nothing stands in for the friction.
    """

    use_friction: ClassVar[bool] = False

    approach: Literal["viscous"] = "viscous"

    def acting(self, law: AnyLaw) -> AnyLaw:
        """Give no dry friction, between the same end stops."""
        return law._replace(F_fk=0.0, F_fs=0.0) if isinstance(law, Stopped) else NO_FRICTION
