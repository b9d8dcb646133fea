"""Coulomb: a force that does not depend on the speed, and a limit for sticking."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

from drysim.core.plant import Law
from drysim.friction.forces import Limits
from drysim.quantity import Angle, Block, Frequency, Quantity


class NormalVariation(Block):
    """A varying normal force: both limits times 1 + amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("", at_least=0, below=1)]
    """Relative amplitude [-], 0 to below 1: the surfaces never part."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class Coulomb(Limits):
    """Dry surfaces pressed together: a constant force against sliding, a limit for sticking.

    Not to be confused with viscous damping, which vanishes with the speed.

    Notes
    -----
    F_f = F_fk sgn(v_r) while it slides; while it sticks F_f = -F_L, at most F_fs = μ_s F_N in
    size, with F_L = m d²u/dt² + k_x x_r. Coulomb, Théorie des machines simples (1785), as Eqs.
    (3), (4), (7) and (9) of the paper have it.
    """

    law: Literal["coulomb"]
    """Dry friction of Coulomb's kind."""
    normal_variation: NormalVariation | None = None
    """Normal force that varies as a sine; default: it is constant."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """The frequencies of a normal force that varies periodically [Hz]."""
        varied = self.normal_variation
        return (varied.frequency,) if varied and varied.amplitude else ()

    def limits(self, m: float) -> Law:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        varied = self.normal_variation
        if varied is None:
            return Law(F_fk, F_fs)
        return Law(F_fk, F_fs, varied.amplitude, 2 * pi * varied.frequency, varied.phase)
