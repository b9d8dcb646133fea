"""Smooth: continuous functions in place of the sign of the velocity (Eq. 8)."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Annotated, Literal

from drysim.approach.member import Member
from drysim.approach.response import Response
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Plant
from drysim.core.state import AnyState
from drysim.quantity import Quantity

if TYPE_CHECKING:
    from drysim.approach.events import Floats

FORMS = ("sign", "arctan", "tanh", "erf", "rational")
STIFFNESS = 0.15
"""Largest F_fk c Δt/m of a substep: rk4 is stable to 2.8, and at this its error is gone."""

LEAST_PIECES = 4
"""Substeps in a step at least, so that sums over them stand for integrals."""

RELATIVE = 1e-9
"""Relative tolerance of the adaptive method; the sharpness errs by far more."""


class Smooth(Member):
    """Friction as a steep but continuous function of velocity.

    Not to be confused with stick-slip: where the mass should stand still it creeps, and the
    sharper the function, the stiffer the equation.
    """

    approach: Literal["smooth"] = "smooth"
    form: Literal["arctan", "tanh", "erf", "rational"] = "tanh"
    """Function in place of the sign: arctan, tanh, erf or rational."""
    sharpness: Annotated[float, Quantity("s/m", above=0)] = 1e3
    """Sharpness c [s/m] of the function, above 0."""
    method: Literal["substeps", "rk4", "adaptive"] = "substeps"
    """Integrator: substeps (rk4 with as many steps within solver.step as the sharpness asks,
    so that what is left is the error of the function), rk4 with solver.step, or adaptive (an
    implicit one, slow, for reference)."""

    def pieces(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Give how many; the sharper the function, the more."""
        if self.method == "rk4":
            return 1
        return max(LEAST_PIECES, ceil(law.F_fk * self.sharpness * dt / (plant.m * STIFFNESS)))

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
        from drysim.approach.stepped import finer, thinned

        if self.method == "rk4":
            return self._march(plant, law, motion, start, step, duration)
        dt = motion.dt if isinstance(motion, Samples) else step
        pieces = self.pieces(plant, law, dt)
        fine = self._march(plant, law, finer(motion, pieces), start, step / pieces, duration)
        return thinned(fine, motion, pieces)

    def _march(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None,
    ) -> Response:
        """Give the response with one step from each grid point to the next."""
        import numpy as np

        from drysim.approach.stepped import from_start, grid_of, respond
        from drysim.core.compiled import held
        from drysim.core.law import sliding_shares
        from drysim.core.stepping import RK4, step_march

        u_dd, u_mid, dt = grid_of(motion, step, duration)
        form = FORMS.index(self.form)
        if self.method == "adaptive":
            x, v = self._adaptive(plant, law, motion, start, (u_dd, dt))
        else:
            x_r, v_r = from_start(start, len(u_dd))
            base = (held(u_dd), held(u_mid), dt)
            step_march(plant, law.F_fk, form, self.sharpness, RK4, *base, x_r, v_r)
            x, v = np.asarray(x_r), np.asarray(v_r)
        share = held(v.copy())
        sliding_shares(form, self.sharpness, share)
        mode = np.where(v < 0.0, -1, 1).astype(np.int8)
        why = f"{self.form} with sharpness {self.sharpness:g} s/m for the sign, {self.method}"
        state = (x, v, law.F_fk * np.asarray(share), mode)
        return respond(plant, law, motion, (u_dd, dt), state, (self.approach, why))

    def _adaptive(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        grid: tuple[Floats, float],
    ) -> tuple[Floats, Floats]:
        """Give x_r and v_r on the grid by scipy's LSODA."""
        import numpy as np
        from scipy.integrate import solve_ivp

        from drysim.core.law import sliding_share
        from drysim.core.motion import base_acceleration
        from drysim.errors import SolverError

        u_dd, dt = grid
        t = np.arange(len(u_dd)) * dt
        form, (m, k_x, b) = FORMS.index(self.form), plant

        def base(now: float) -> float:
            if isinstance(motion, Samples):
                return float(np.interp(now, t, u_dd))
            return float(base_acceleration(motion, np.array([now]))[0])

        def rates(now: float, state: Floats) -> list[float]:
            F_f = law.F_fk * sliding_share(form, self.sharpness, state[1])
            return [state[1], -base(now) - (b * state[1] + k_x * state[0] + F_f) / m]

        swing = float(np.abs(u_dd).max(initial=0.0)) * dt + abs(start.v_r) + abs(start.x_r)
        found = solve_ivp(
            rates, (0.0, t[-1]), list(start[:2]), "LSODA", t, rtol=RELATIVE,
            atol=RELATIVE * 1e-3 * (swing or 1.0), max_step=10 * dt,
        )  # fmt: skip
        if not found.success:
            raise SolverError(f"smooth, adaptive: {found.message}", "take a smaller sharpness")
        return found.y[0], found.y[1]
