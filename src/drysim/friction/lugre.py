"""LuGre: bristles between the surfaces, and friction that falls with the speed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import BRISTLE, Dynamic
from drysim.friction.forces import TOLERANCE, Limits, Tolerance
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Damping, Quantity


class Lugre(Limits, Rubbing):
    """Surfaces whose bristles bend before they slide; Stribeck's fall, delay and creep.

    Not to be confused with `leuven`, whose bristles remember where they turned.

    Notes
    -----
    dz/dt = v - σ_0 |v| z/g(v), F_f = σ_0 z + σ_1 dz/dt + σ_2 v [N], with
    g = F_fk + (F_fs - F_fk) exp(-(v/v_s)²) and z [m] the mean deflection of the bristles.
    Canudas de Wit, Olsson, Åström and Lischinsky, IEEE TAC 40 (1995) 419.
    """

    law: Literal["lugre"]
    """Dry friction of the LuGre kind."""
    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the bristles."""
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
        "bristle_damping": "σ_1",
        "viscous": "σ_2",
    }

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        return Dynamic(
            F_fk, F_fs, BRISTLE, v_s=self.stribeck_velocity, sigma_0=self.bristle_stiffness,
            sigma_1=self.bristle_damping, sigma_2=self.viscous, tolerance=self.tolerance,
        )  # fmt: skip
