"""LuGre: bristles between the surfaces, and friction that falls with the speed."""

from __future__ import annotations

from typing import Literal

from drysim.core.plant import BRISTLE, Dynamic
from drysim.friction.bristles import Bristles
from drysim.friction.forces import TOLERANCE, Tolerance


class Lugre(Bristles):
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
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        return self.bent(m, BRISTLE, self.tolerance)
