"""Dahl: surfaces that yield like a spring before they slide."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import BRISTLE, Dynamic
from drysim.friction.forces import TOLERANCE, Tolerance
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Quantity


class Dahl(Rubbing):
    """A contact that yields smoothly before it slides, as rolling bearings do; no stick.

    Not to be confused with `jenkins`, whose spring is linear up to the limit.

    Notes
    -----
    dz/dt = v (1 - σ_0 z sgn(v)/F_fk), F_f = σ_0 z, with z [m] the deflection of the contact.
    Dahl, A solid friction model, TOR-0158(3107-18)-1, The Aerospace Corporation (1968).
    """

    law: Literal["dahl"]
    """Dry friction of Dahl's kind."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the contact before it slides."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"bristle_stiffness": "σ_0"}

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk = self.kinetic_force(m)
        return Dynamic(
            F_fk, F_fk, BRISTLE, sigma_0=self.bristle_stiffness, tolerance=self.tolerance
        )
