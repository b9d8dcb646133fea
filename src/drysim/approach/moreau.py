"""Moreau: set-valued implicit time stepping (Moreau and Jean; Acary and Brogliato 2008)."""

from __future__ import annotations

from typing import Literal

from drysim.approach.member import Member
from drysim.approach.response import Response
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState


class Moreau(Member):
    """The sign is a set at zero velocity, and every step picks the point that fits.

    Not to be confused with signum: the mass truly sticks, without chatter and without a band;
    nor with stick-slip: stops fall on the grid, and no static friction above kinetic is known.
    """

    approach: Literal["moreau"] = "moreau"

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
        from drysim.core.stepping import moreau_march

        u_dd, _, dt = grid_of(motion, step, duration)
        scene, limits = (plant, law, motion), (law.F_fk,)
        how = (self.approach, "the sign as a set, solved implicitly at every fixed step")
        return sticking(moreau_march, limits, scene, start, (u_dd, dt), how)
