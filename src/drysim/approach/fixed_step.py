"""Fixed-step approaches: moreau, signum, smooth and switch.

- Moreau: Moreau-Jean time stepping, set-valued and implicit (Acary and Brogliato 2008).
- Signum: the sign of the velocity, not regularised (Eqs. 3, 7).
- Smooth: a continuous function in place of the sign of the velocity (Eq. 8).
- Switch: the paper's fixed-step method with a velocity band (Eq. 10; Karnopp 1985).

Each class declares its options and calls its kernel, which is imported on first use.
"""

from __future__ import annotations

from math import ceil
from sys import float_info
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from drysim.approach.solution import Response
from drysim.approach.stick_slip import ApproachBase
from drysim.core.model import AnyLaw, AnyState, Floats, Plant, Samples, Sines
from drysim.quantity import Quantity

if TYPE_CHECKING:
    from drysim.core.fixed_step import BaseOnGrid, MotionOnGrid

Scene = tuple[Plant, AnyLaw, Sines | Samples]
"""Oscillator, friction law and base motion."""


class FixedStepApproach(ApproachBase):
    """Base of the approaches with a fixed step, which differ in how they march."""

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
        from drysim.approach import stepping

        base = stepping.base_on_grid(motion, step, duration)
        out = stepping.empty_motion_on_grid(start, len(base.u_dd))
        scene = plant, law, motion
        why = self.march(scene, base, out)
        name: str = type(self).model_fields["approach"].default
        return stepping.make_response(scene, base, out, name, why)

    def march(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> str:
        """Write the motion on the grid; return a sentence on the method."""
        raise NotImplementedError


class Moreau(FixedStepApproach):
    """Set-valued sign at zero velocity, solved implicitly at every step.

    Not to be confused with signum: the mass sticks, without chatter and without a velocity
    band; nor with stick-slip: stops fall on the grid, and static friction equals kinetic
    friction.
    """

    approach: Literal["moreau"] = "moreau"

    def march(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> str:
        """Write the motion on the grid; return a sentence on the method."""
        from drysim.core.fixed_step import march_moreau

        plant, law, _ = scene
        march_moreau(plant, law.F_fk, base, out)
        return "set-valued sign, solved implicitly at every fixed step"


METHODS = ("euler", "semi-implicit", "heun", "rk4")
"""Integrators in the order of their codes in `core.fixed_step`."""


class Signum(FixedStepApproach):
    """Sign of the velocity at every step, with sign(0) = 0.

    Not to be confused with stick-slip: there is no stick. Where the mass should stand still its
    acceleration on the grid is about ±F_fk/m, however small the step. Under `euler` and
    `semi-implicit` the mass chatters with period 2Δt; under `heun` and mostly under `rk4` the
    sign changes between the stages of a step, and v_r on the grid hardly changes.
    """

    approach: Literal["signum"] = "signum"
    method: Literal["euler", "semi-implicit", "heun", "rk4"] = "semi-implicit"
    """Integrator: euler, semi-implicit, heun or rk4."""

    def march(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> str:
        """Write the motion on the grid; return a sentence on the method."""
        from drysim.core.fixed_step import SIGN, march_fixed_step

        (plant, law, _), method = scene, METHODS.index(self.method)
        march_fixed_step(plant, law.F_fk, SIGN, 0.0, method, base, out)
        return f"sign of v_r at every step, integrated by {self.method}"


FORMS = ("sign", "arctan", "tanh", "erf", "rational")
"""Forms of the sign function in the order of their codes in `core.fixed_step`."""

MAX_SUBSTEP_STIFFNESS = 0.15
"""Largest F_fk c Δt/m of a substep. RK4 is stable up to 2.8; at this value its error is
negligible."""

MIN_SUBSTEPS = 4
"""Fewest substeps per step, so that sums over them are good integrals."""

ADAPTIVE_RTOL = 1e-9
"""Relative tolerance of the adaptive method, far below the error of a finite sharpness."""


class Smooth(FixedStepApproach):
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
            return super().solve(plant, law, motion, start, step, duration)
        dt = motion.dt if isinstance(motion, Samples) else step
        substeps = self.substeps(plant, law, dt)
        fine = super().solve(
            plant, law, refine_motion(motion, substeps), start, step / substeps, duration
        )
        return decimate_response(fine, motion, substeps)

    def march(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> str:
        """Write the motion on the grid; return a sentence on the method."""
        from drysim.core.fixed_step import RK4, march_fixed_step

        (plant, law, _), form = scene, FORMS.index(self.form)
        if self.method == "adaptive":
            self._integrate(scene, base, out)
        else:
            march_fixed_step(plant, law.F_fk, form, self.sharpness, RK4, base, out)
        return f"{self.form} of sharpness {self.sharpness:g} s/m as the sign, {self.method}"

    def _integrate(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> None:
        """Write the motion on the grid as found by scipy's LSODA."""
        import numpy as np
        from scipy.integrate import solve_ivp

        from drysim.core.fixed_step import regularised_sign
        from drysim.core.model import base_acceleration
        from drysim.errors import SolverError

        (m, k_x, b), law, motion = scene
        u_dd, dt, form = np.asarray(base.u_dd), base.dt, FORMS.index(self.form)
        t = np.arange(len(u_dd)) * dt

        def base_at(now: float) -> float:
            if isinstance(motion, Samples):
                return float(np.interp(now, t, u_dd))
            return float(base_acceleration(motion, np.array([now]))[0])

        def friction(v_r: float) -> float:
            return law.F_fk * float(regularised_sign(form, self.sharpness, v_r))

        def rates(now: float, state: Floats) -> list[float]:
            pull = b * state[1] + k_x * state[0] + friction(state[1])
            return [state[1], -base_at(now) - pull / m]

        # Order of magnitude of the motion, for the absolute tolerance.
        begin = [out.x_r[0], out.v_r[0]]
        scale = float(np.abs(u_dd).max(initial=0.0)) * dt + abs(begin[1]) + abs(begin[0])
        solution = solve_ivp(
            rates, (0.0, t[-1]), begin, "LSODA", t, rtol=ADAPTIVE_RTOL,
            atol=ADAPTIVE_RTOL * 1e-3 * (scale or 1.0), max_step=10 * dt,
        )  # fmt: skip
        if not solution.success:
            raise SolverError(
                f"smooth, adaptive: {solution.message}", "use a smaller sharpness"
            )
        for n, (x_r, v_r) in enumerate(solution.y.T.tolist()):
            out.x_r[n], out.v_r[n], out.F_f[n] = x_r, v_r, friction(v_r)
            out.d[n] = -1 if v_r < 0.0 else 1


class Switch(FixedStepApproach):
    """Stick within a band of small velocities, sliding outside it.

    Not to be confused with stick-slip, which locates the stop: here the band must be wide
    enough for a step to fall into it, and the error is first order in step and band.
    """

    supports_static: ClassVar[bool] = True

    approach: Literal["switch"] = "switch"
    band: Annotated[float, Quantity("m/s", above=0)] | None = None
    """Half width ε of the band [m/s]; default: the velocity lost to friction in one step,
    F_fs/m times the step."""

    def march(self, scene: Scene, base: BaseOnGrid, out: MotionOnGrid) -> str:
        """Write the motion on the grid; return a sentence on the method."""
        from drysim.core.fixed_step import march_switch

        plant, law, _ = scene
        band = self.band or base.dt * law.F_fs / plant.m or float_info.min
        march_switch(plant, law.F_fk, law.F_fs, band, base, out)
        return f"fixed step, sticks within a band of {band:.3g} m/s"
