"""Leuven: bristles with hysteresis, which remember where they turned."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import LEUVEN, Dynamic
from drysim.friction.forces import TOLERANCE, Limits, Tolerance
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Damping, Quantity


class Leuven(Limits, Rubbing):
    """Surfaces whose bristles bend with hysteresis: a loop within a loop closes where it began.

    Not to be confused with `lugre`, whose bristles are elastic and remember one number.

    Notes
    -----
    dz/dt = v (1 - sgn(F_h/s) |F_h/s|^n), F_f = F_h + σ_1 dz/dt + σ_2 v [N], with the limit
    s = sgn(v) (F_fk + (F_fs - F_fk) exp(-(v/v_s)²)) and F_h the hysteresis force over the
    travel z [m] of the bristles: on the virgin curve F_∞ (1 - exp(-σ_0 |z|/F_∞)), from where
    they turn the same curve twice as large (Masing), and where a loop closes the curve of the
    loop around it. Swevers et al., IEEE TAC 45 (2000) 675; Lampaert et al., IEEE TAC 47 (2002)
    683: F_h as a whole stands in dz/dt, so that the force has no jump as a loop closes, and
    the memory is bounded: 128 turns, of which the two that differ least from their neighbours
    are forgotten where one more comes.
    """

    law: Literal["leuven"]
    """Dry friction of the Leuven kind."""
    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the bristles where they turn."""
    hysteresis_ratio: Annotated[float, Quantity("", above=1)] = 2.0
    """F_∞/F_fs [-], above 1, the force that the bristles alone would come to over the static
    limit; default 2. The greater, the narrower the loops; far above 1 they are elastic."""
    transition: Literal[1, 2, 3] = 1
    """Exponent n [-] of the transition to sliding, 1, 2 or 3; default 1. The greater, the
    later the bristles give way."""
    bristle_damping: Damping
    """Damping σ_1 [N·s/m], at least 0, of the bristles."""
    viscous: Damping = 0.0
    """Viscous friction σ_2 [N·s/m] of the contact; default 0: the damper is all there is."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {
        "stribeck_velocity": "v_s",
        "bristle_stiffness": "σ_0",
        "hysteresis_ratio": "F_∞/F_fs",
        "transition": "n",
        "bristle_damping": "σ_1",
        "viscous": "σ_2",
    }

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        return Dynamic(
            F_fk, F_fs, LEUVEN, v_s=self.stribeck_velocity, sigma_0=self.bristle_stiffness,
            sigma_1=self.bristle_damping, sigma_2=self.viscous, tolerance=self.tolerance,
            F_h=self.hysteresis_ratio * F_fs, power=self.transition,
        )  # fmt: skip
