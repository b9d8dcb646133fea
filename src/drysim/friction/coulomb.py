"""Coulomb: a force that does not depend on the speed, and a limit for sticking."""

from __future__ import annotations

from math import pi
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import model_validator

from drysim.core.plant import Law
from drysim.quantity import Angle, Block, Force, Frequency, Misfit, Quantity

GRAVITY = 9.81
"""The paper's g [m/s²], so that 75 kg press with 735.75 N."""

Coefficient = Annotated[float, Quantity("", at_least=0)]


class NormalVariation(Block):
    """A varying normal force: both limits times 1 + amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("", at_least=0, below=1)]
    """Relative amplitude [-], 0 to below 1: the surfaces never part."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class Coulomb(Block):
    """Dry surfaces pressed together: a constant force against sliding, a limit for sticking.

    Not to be confused with viscous damping, which vanishes with the speed.
    """

    law: Literal["coulomb"]
    """Dry friction of Coulomb's kind."""
    kinetic: Force | None = None
    """Kinetic friction force F_fk [N]."""
    static: Force | None = None
    """Static limit F_fs [N], at least the kinetic force; default: equal to it."""
    static_ratio: Annotated[float, Quantity("", at_least=1)] | None = None
    """F_fs/F_fk [-], at least 1, in place of `static`; default 1."""
    mu_kinetic: Coefficient | None = None
    """Coefficient of kinetic friction [-], in place of `kinetic`."""
    mu_static: Coefficient | None = None
    """Coefficient of static friction [-], at least that of kinetic friction."""
    normal: Force | None = None
    """Normal force [N] behind the coefficients; default 9.81 m/s² times the mass."""
    normal_variation: NormalVariation | None = None
    """Normal force that varies as a sine; default: it is constant."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("kinetic", "mu_kinetic"),)
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("static", "static_ratio", "mu_static"),
    )
    needs: ClassVar[dict[str, str]] = {
        "static": "kinetic",
        "mu_static": "mu_kinetic",
        "normal": "mu_kinetic",
    }

    @model_validator(mode="after")
    def _static_holds_more(self) -> Self:
        for name, static, kinetic, unit in (
            ("static", self.static, self.kinetic, " N"),
            ("mu_static", self.mu_static, self.mu_kinetic, ""),
        ):
            if static is not None and kinetic is not None and static < kinetic:
                least = f"{kinetic:.12g}{unit}"
                given = f"{static:.12g}{unit}"
                raise Misfit(f"must be at least the kinetic {least}, not {given}", name)
        return self

    @property
    def static_given(self) -> bool:
        """Whether anybody said what the static limit is."""
        return (self.static, self.static_ratio, self.mu_static) != (None, None, None)

    def limits(self, m: float) -> Law:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_N = GRAVITY * m if self.normal is None else self.normal
        F_fk = (self.mu_kinetic or 0.0) * F_N if self.kinetic is None else self.kinetic
        if self.static is not None:
            F_fs = self.static
        elif self.mu_static is not None:
            F_fs = self.mu_static * F_N
        else:
            F_fs = F_fk * (1.0 if self.static_ratio is None else self.static_ratio)
        varied = self.normal_variation
        if varied is None:
            return Law(F_fk, F_fs)
        return Law(F_fk, F_fs, varied.amplitude, 2 * pi * varied.frequency, varied.phase)

    def spelled_out(self, m: float) -> dict[str, Any]:
        """Give the words of the block with every default in them."""
        words = self.model_dump(exclude_none=True)
        if not self.static_given:
            words["static_ratio"] = 1.0
        if self.mu_kinetic is not None and self.normal is None:
            words["normal"] = GRAVITY * m
        return words
