"""Signum: the bare sign of the velocity in a fixed-step march (Eqs. 3, 7)."""

from __future__ import annotations

from typing import Literal

from drysim.approach.member import Member
from drysim.approach.response import Response
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState

METHODS = ("euler", "semi-implicit", "heun", "rk4")


class Signum(Member):
    """Friction against the sign of the velocity at every step, with sign(0) = 0.

    Not to be confused with stick-slip: there is no stick. Where the mass should stand still its
    acceleration on the grid is about ±F_fk/m, however small the step. Under `euler` and
    `semi-implicit` the mass chatters with period 2Δt; under `heun` and mostly under `rk4` the
    sign changes between the stages of a step, and v_r on the grid hardly does.
    """

    approach: Literal["signum"] = "signum"
    method: Literal["euler", "semi-implicit", "heun", "rk4"] = "semi-implicit"
    """Integrator: euler, semi-implicit, heun or rk4."""

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
        import numpy as np

        from drysim.approach.stepped import from_start, grid_of, respond
        from drysim.core.compiled import held
        from drysim.core.law import SIGN
        from drysim.core.stepping import step_march

        u_dd, u_mid, dt = grid_of(motion, step, duration)
        x_r, v_r = from_start(start, len(u_dd))
        method = METHODS.index(self.method)
        step_march(plant, law.F_fk, SIGN, 0.0, method, held(u_dd), held(u_mid), dt, x_r, v_r)
        x, v = np.asarray(x_r), np.asarray(v_r)
        # A mass that happens to have v_r = 0 at a grid point is not stuck: nothing holds it.
        mode = np.where(v < 0.0, -1, 1).astype(np.int8)
        how = (self.approach, f"the sign of v_r at every step, by {self.method}")
        return respond(plant, law, motion, (u_dd, dt), (x, v, law.F_fk * np.sign(v), mode), how)
