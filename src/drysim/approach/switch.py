"""Switch: the paper's fixed-step march with a velocity band (Eq. 10; Karnopp 1985)."""

from __future__ import annotations

from sys import float_info
from typing import Annotated, ClassVar, Literal

from drysim.approach.member import Member
from drysim.approach.response import Response
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState
from drysim.quantity import Quantity


class Switch(Member):
    """Within a band of small velocities the mass may stick; outside it slides.

    Not to be confused with stick-slip, which locates the stop: here the band is wide enough for
    a step to fall into it, and the answer is right to first order in step and band.
    """

    use_static: ClassVar[bool] = True

    approach: Literal["switch"] = "switch"
    band: Annotated[float, Quantity("m/s", above=0)] | None = None
    """Half width ε of the band [m/s]; default: what friction takes in one step, F_fs/m times
    the step."""

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Give the response on the grid of the step; parameters as in `StickSlip.solve`."""
        from drysim.approach.stepped import grid_of, sticking
        from drysim.core.stepping import switch_march

        u_dd, _, dt = grid_of(motion, step, duration)
        band = self.band or dt * law.F_fs / plant.m or float_info.min
        scene, limits = (plant, law, motion), (law.F_fk, law.F_fs, band)
        how = (self.approach, f"fixed step, sticks within a band of {band:.3g} m/s")
        return sticking(switch_march, limits, scene, start, (u_dd, dt), how)
