"""Viscous: the same plant without dry friction, the reference curve."""

from __future__ import annotations

from typing import ClassVar, Literal

from drysim.approach.orbit import Orbit
from drysim.approach.response import Response, Track
from drysim.approach.stick_slip import StickSlip
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Law, Plant, Stopped
from drysim.core.state import AnyState
from drysim.quantity import Block

NO_FRICTION = Law(0.0, 0.0)


def without_friction(law: AnyLaw) -> AnyLaw:
    """Give no dry friction, between the same end stops."""
    return law._replace(F_fk=0.0, F_fs=0.0) if isinstance(law, Stopped) else NO_FRICTION


class Viscous(Block):
    """Spring and damper alone; what the friction of the scene would be is left out.

    Not to be confused with an equivalent viscous damping: nothing stands in for the friction.
    """

    use_friction: ClassVar[bool] = False
    use_static: ClassVar[bool] = False
    use_variation: ClassVar[bool] = False
    use_dynamic: ClassVar[bool] = True
    use_stops: ClassVar[bool] = True

    approach: Literal["viscous"] = "viscous"

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response without dry friction; parameters as in `StickSlip.solve`."""
        return StickSlip().solve(plant, without_friction(law), motion, start, step, duration)

    def by_parts(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response part by part; parameters as in `StickSlip.by_parts`."""
        return StickSlip().by_parts(plant, without_friction(law), motion, start, step, duration)

    def track(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Track:
        """Give the solution without its grid; parameters as in `StickSlip.track`."""
        return StickSlip().track(plant, without_friction(law), motion, start, step, duration)

    def orbit(
        self, plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
    ) -> Orbit:
        """Give the steady motion under excitation of this period [s]."""
        return StickSlip().orbit(plant, without_friction(law), motion, start, period)
