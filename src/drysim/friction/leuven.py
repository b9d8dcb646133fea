"""Leuven: bristles with hysteresis, which remember where they turned."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.plant import LEUVEN, Dynamic
from drysim.friction.bristles import Bristles
from drysim.friction.forces import TOLERANCE, Tolerance
from drysim.quantity import Quantity


class Leuven(Bristles):
    """Surfaces whose bristles bend with hysteresis: a loop within a loop closes where it began.

    Not to be confused with `lugre`, whose bristles are elastic and remember one number.

    Notes
    -----
    dz/dt = v (1 - sgn(F_h/s) |F_h/s|^n), F_f = F_h + σ_1 dz/dt + σ_2 v [N], with the limit
    s = sgn(v) (F_fk + (F_fs - F_fk) exp(-(v/v_s)²)) and F_h the hysteresis force over the
    travel z [m] of the bristles: on the virgin curve F_∞ (1 - exp(-σ_0 |z|/F_∞)), from where
    they turn the same curve twice as large (Masing), and where a loop closes the curve of the
    loop around it. Swevers, Al-Bender, Ganseman and Prajogo, IEEE TAC 45 (2000) 675, leave the
    virgin curve open; this one is drysim's choice.

    Lampaert, Swevers and Al-Bender, IEEE TAC 47 (2002) 683, correct two things. (1) F_h as a
    whole stands in dz/dt, not the part since the last turn, so the force has no jump as a loop
    closes: so it is here. (2) They take F_h from a finite row of Maxwell's slip elements, which
    cannot overflow as a stack of turns does. Here the stack stays: it is what such a row comes
    to as its elements grow many. It holds 128 turns, and where one more comes, the two that
    differ least from their neighbours are forgotten, without a jump in the force. At worst, of
    128 turns evenly within one another from limit to limit, and with F_∞ = 2 F_fs, that moves
    the force by 1e-4 of F_fs later on; a row of a hundred elements errs by as much always.
    """

    law: Literal["leuven"]
    """Dry friction of the Leuven kind."""
    hysteresis_ratio: Annotated[float, Quantity("", above=1)] = 2.0
    """F_∞/F_fs [-], above 1, the force that the bristles alone would come to over the static
    limit; default 2. The greater, the narrower the loops; far above 1 they are elastic."""
    transition: Annotated[float, Quantity("", at_least=0.5, below=20)] = 1.0
    """Exponent n [-] of the transition to sliding, from 0.5 to below 20; default 1. The
    greater, the later the bristles give way. For 1, 2 and 3 the motion is a series through zero
    force, too; any other takes up to four times as many steps, as it comes there by degrees."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {
        **Bristles.symbols,
        "hysteresis_ratio": "F_∞/F_fs",
        "transition": "n",
    }

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        law = self.bent(m, LEUVEN, self.tolerance)
        return law._replace(F_h=self.hysteresis_ratio * law.F_fs, power=self.transition)
