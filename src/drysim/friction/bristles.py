"""What LuGre's law and Leuven's share: bristles under Stribeck's curve."""

from __future__ import annotations

from typing import Annotated, ClassVar

from drysim.core.plant import Dynamic
from drysim.friction.forces import Limits
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Damping, Quantity


class Bristles(Limits, Rubbing):
    """Bristles between the surfaces, whose limit falls with the speed."""

    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the bristles where they begin to bend."""
    bristle_damping: Damping
    """Damping σ_1 [N·s/m], at least 0, of the bristles."""
    viscous: Damping = 0.0
    """Viscous friction σ_2 [N·s/m] of the contact; default 0: the damper is all there is."""

    symbols: ClassVar[dict[str, str]] = {
        "stribeck_velocity": "v_s",
        "bristle_stiffness": "σ_0",
        "bristle_damping": "σ_1",
        "viscous": "σ_2",
    }

    def bent(self, m: float, kind: int, tolerance: float) -> Dynamic:
        """Give the law in forces, of one kind of bristles; the mass [kg] as in `limits`."""
        return Dynamic(
            self.kinetic_force(m), self.static_force(m), kind, v_s=self.stribeck_velocity,
            sigma_0=self.bristle_stiffness, sigma_1=self.bristle_damping,
            sigma_2=self.viscous, tolerance=tolerance,
        )  # fmt: skip
