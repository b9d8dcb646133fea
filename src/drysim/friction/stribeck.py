"""Stribeck: friction that falls from its static limit as sliding gathers speed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import STRIBECK, Dynamic
from drysim.friction.forces import TOLERANCE, Limits, Tolerance
from drysim.friction.rubbing import Rubbing
from drysim.quantity import Quantity


class Stribeck(Limits, Rubbing):
    """Lubricated or soft surfaces, which rub less the faster they slide; true stick.

    Not to be confused with `coulomb`, whose force drops at once when sliding starts.

    Notes
    -----
    F_k(v) = F_fk + (F_fs - F_fk) exp(-|v/v_s|^δ) [N] against sliding, v and v_s [m/s]; stick
    holds up to F_fs. Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083.
    """

    law: Literal["stribeck"]
    """Dry friction that falls with the speed."""
    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    exponent: Annotated[float, Quantity("", at_least=0.5, below=20)] = 2.0
    """Exponent δ [-] of the fall, from 0.5 to below 20; default 2, the Gaussian of
    Armstrong-Hélouvry. Published are 0.5 to 1 of Bo and Pavelescu for dry metals, 1 of Tustin
    and great ones of Fuller for boundary lubricants. For 1 and 2 friction is a series in the
    speed at rest, too; any other takes two to four times as many steps, as they come to a stop
    by degrees. Below 0.5, less than any of these, the fall begins so steeply that the default
    tolerance leaves more than a millionth of the motion; there `coulomb` is near."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"stribeck_velocity": "v_s", "exponent": "δ"}

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        return Dynamic(
            F_fk, F_fs, STRIBECK, v_s=self.stribeck_velocity, exponent=self.exponent,
            tolerance=self.tolerance,
        )  # fmt: skip
