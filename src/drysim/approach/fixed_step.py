"""Fixed-step approaches: moreau, signum, smooth and switch.

- Moreau: Moreau-Jean time stepping, set-valued and implicit (Acary and Brogliato 2008).
- Signum: the sign of the velocity, not regularised (Eqs. 3, 7).
- Smooth: a continuous function in place of the sign of the velocity (Eq. 8).
- Switch: the paper's fixed-step method with a velocity band (Eq. 10; Karnopp 1985).

Each class declares its options; its kernels are imported on first use.
"""

from __future__ import annotations

from math import ceil
from sys import float_info
from typing import Annotated, ClassVar, Literal

from drysim.approach.solution import Floats, Response
from drysim.approach.stick_slip import ApproachBase
from drysim.core.model import AnyLaw, AnyState, Plant, Samples, Sines
from drysim.units import Quantity


class Moreau(ApproachBase):
    """Set-valued sign at zero velocity, solved implicitly at every step.

    Not to be confused with signum: the mass sticks, without chatter and without a velocity
    band; nor with stick-slip: stops fall on the grid, and static friction equals kinetic
    friction.
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
        """Return the response on the grid of the step; parameters as in `StickSlip.solve`."""
        from drysim.approach.stepping import input_on_grid, solve_with_stick
        from drysim.core.fixed_step import march_moreau

        u_dd, _, dt = input_on_grid(motion, step, duration)
        scene, limits = (plant, law, motion), (law.F_fk,)
        name_and_reason = (
            self.approach,
            "set-valued sign, solved implicitly at every fixed step",
        )
        return solve_with_stick(march_moreau, limits, scene, start, (u_dd, dt), name_and_reason)


METHODS = ("euler", "semi-implicit", "heun", "rk4")
"""Integrators in the order of their codes in `core.fixed_step`."""


class Signum(ApproachBase):
    """Sign of the velocity at every step, with sign(0) = 0.

    Not to be confused with stick-slip: there is no stick. Where the mass should stand still its
    acceleration on the grid is about ±F_fk/m, however small the step. Under `euler` and
    `semi-implicit` the mass chatters with period 2Δt; under `heun` and mostly under `rk4` the
    sign changes between the stages of a step, and v_r on the grid hardly changes.
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
        """Return the response on the grid of the step; parameters as in `StickSlip.solve`."""
        import numpy as np

        from drysim.approach.stepping import input_on_grid, make_response, state_buffers
        from drysim.core.compile import as_engine_array
        from drysim.core.fixed_step import SIGN, march_fixed_step

        u_dd, u_mid, dt = input_on_grid(motion, step, duration)
        x_r, v_r = state_buffers(start, len(u_dd))
        method = METHODS.index(self.method)
        march_fixed_step(
            plant,
            law.F_fk,
            SIGN,
            0.0,
            method,
            as_engine_array(u_dd),
            as_engine_array(u_mid),
            dt,
            x_r,
            v_r,
        )
        x, v = np.asarray(x_r), np.asarray(v_r)
        # v_r = 0 at a grid point is no stick: this method has none.
        mode = np.where(v < 0.0, -1, 1).astype(np.int8)
        name_and_reason = (
            self.approach,
            f"sign of v_r at every step, integrated by {self.method}",
        )
        return make_response(
            plant, law, motion, (u_dd, dt), (x, v, law.F_fk * np.sign(v), mode), name_and_reason
        )


FORMS = ("sign", "arctan", "tanh", "erf", "rational")
"""Forms of the sign function in the order of their codes in `core.fixed_step`."""

MAX_SUBSTEP_STIFFNESS = 0.15
"""Largest F_fk c Δt/m of a substep. RK4 is stable up to 2.8; at this value its error is
negligible."""

MIN_SUBSTEPS = 4
"""Fewest substeps per step, so that sums over them are good integrals."""

ADAPTIVE_RTOL = 1e-9
"""Relative tolerance of the adaptive method, far below the error of a finite sharpness."""


class Smooth(ApproachBase):
    """Friction as a steep continuous function of velocity.

    Not to be confused with stick-slip: where the mass should stand still it creeps, and the
    sharper the function, the stiffer the equation.
    """

    approach: Literal["smooth"] = "smooth"
    form: Literal["arctan", "tanh", "erf", "rational"] = "tanh"
    """Function in place of the sign: arctan, tanh, erf or rational."""
    sharpness: Annotated[float, Quantity("s/m", above=0)] = 1e3
    """Sharpness c [s/m] of the function, above 0."""
    method: Literal["substeps", "rk4", "adaptive"] = "substeps"
    """Integrator: substeps (RK4 with as many substeps per solver.step as the sharpness
    requires, so that only the error of the function remains), rk4 with solver.step, or
    adaptive (implicit, slow, for reference)."""

    def substeps(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Return the number of substeps per step; it grows with the sharpness."""
        if self.method == "rk4":
            return 1
        return max(
            MIN_SUBSTEPS,
            ceil(law.F_fk * self.sharpness * dt / (plant.m * MAX_SUBSTEP_STIFFNESS)),
        )

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Return the response on the grid of the step; parameters as in `StickSlip.solve`."""
        from drysim.approach.stepping import decimate_response, refine_motion

        if self.method == "rk4":
            return self._march(plant, law, motion, start, step, duration)
        dt = motion.dt if isinstance(motion, Samples) else step
        substeps = self.substeps(plant, law, dt)
        fine = self._march(
            plant, law, refine_motion(motion, substeps), start, step / substeps, duration
        )
        return decimate_response(fine, motion, substeps)

    def _march(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None,
    ) -> Response:
        """Return the response with one integration step per grid step."""
        import numpy as np

        from drysim.approach.stepping import input_on_grid, make_response, state_buffers
        from drysim.core.compile import as_engine_array
        from drysim.core.fixed_step import RK4, march_fixed_step, regularise_signs

        u_dd, u_mid, dt = input_on_grid(motion, step, duration)
        form = FORMS.index(self.form)
        if self.method == "adaptive":
            x, v = self._adaptive(plant, law, motion, start, (u_dd, dt))
        else:
            x_r, v_r = state_buffers(start, len(u_dd))
            base = (as_engine_array(u_dd), as_engine_array(u_mid), dt)
            march_fixed_step(plant, law.F_fk, form, self.sharpness, RK4, *base, x_r, v_r)
            x, v = np.asarray(x_r), np.asarray(v_r)
        signs = as_engine_array(v.copy())
        regularise_signs(form, self.sharpness, signs)
        mode = np.where(v < 0.0, -1, 1).astype(np.int8)
        reason = f"{self.form} of sharpness {self.sharpness:g} s/m as the sign, {self.method}"
        state = (x, v, law.F_fk * np.asarray(signs), mode)
        return make_response(plant, law, motion, (u_dd, dt), state, (self.approach, reason))

    def _adaptive(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        grid: tuple[Floats, float],
    ) -> tuple[Floats, Floats]:
        """Return x_r and v_r on the grid by scipy's LSODA."""
        import numpy as np
        from scipy.integrate import solve_ivp

        from drysim.core.fixed_step import regularised_sign
        from drysim.core.model import base_acceleration
        from drysim.errors import SolverError

        u_dd, dt = grid
        t = np.arange(len(u_dd)) * dt
        form, (m, k_x, b) = FORMS.index(self.form), plant

        def base(now: float) -> float:
            if isinstance(motion, Samples):
                return float(np.interp(now, t, u_dd))
            return float(base_acceleration(motion, np.array([now]))[0])

        def rates(now: float, state: Floats) -> list[float]:
            F_f = law.F_fk * regularised_sign(form, self.sharpness, state[1])
            return [state[1], -base(now) - (b * state[1] + k_x * state[0] + F_f) / m]

        # Order of magnitude of the motion, for the absolute tolerance.
        scale = float(np.abs(u_dd).max(initial=0.0)) * dt + abs(start.v_r) + abs(start.x_r)
        solution = solve_ivp(
            rates, (0.0, t[-1]), list(start[:2]), "LSODA", t, rtol=ADAPTIVE_RTOL,
            atol=ADAPTIVE_RTOL * 1e-3 * (scale or 1.0), max_step=10 * dt,
        )  # fmt: skip
        if not solution.success:
            raise SolverError(
                f"smooth, adaptive: {solution.message}", "use a smaller sharpness"
            )
        return solution.y[0], solution.y[1]


class Switch(ApproachBase):
    """Stick within a band of small velocities, sliding outside it.

    Not to be confused with stick-slip, which locates the stop: here the band must be wide
    enough for a step to fall into it, and the error is first order in step and band.
    """

    supports_static: ClassVar[bool] = True

    approach: Literal["switch"] = "switch"
    band: Annotated[float, Quantity("m/s", above=0)] | None = None
    """Half width ε of the band [m/s]; default: the velocity lost to friction in one step,
    F_fs/m times the step."""

    def solve(
        self,
        plant: Plant,
        law: AnyLaw,
        motion: Sines | Samples,
        start: AnyState,
        step: float,
        duration: float | None = None,
    ) -> Response:
        """Return the response on the grid of the step; parameters as in `StickSlip.solve`."""
        from drysim.approach.stepping import input_on_grid, solve_with_stick
        from drysim.core.fixed_step import march_switch

        u_dd, _, dt = input_on_grid(motion, step, duration)
        band = self.band or dt * law.F_fs / plant.m or float_info.min
        scene, limits = (plant, law, motion), (law.F_fk, law.F_fs, band)
        name_and_reason = (self.approach, f"fixed step, sticks within a band of {band:.3g} m/s")
        return solve_with_stick(march_switch, limits, scene, start, (u_dd, dt), name_and_reason)
