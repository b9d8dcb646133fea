"""What laws of friction share: their two forces, and how a scenario may say them.

A force is named itself, or by a coefficient and the normal force, whose default is the weight
of the mass.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Self

from pydantic import model_validator

from drysim.units import Block, Force, Misfit, Quantity

GRAVITY = 9.81
"""The paper's g [m/s²], so that 75 kg press with 735.75 N."""

TOLERANCE = 1e-12
"""Default share of the motion that one step may neglect: what is left is near rounding."""

Tolerance = Annotated[float, Quantity("", at_least=1e-14, below=1e-3)]

Coefficient = Annotated[float, Quantity("", at_least=0)]


class Kinetic(Block):
    """A force against sliding, named itself or by a coefficient and the normal force."""

    law: str
    """Name of the law."""
    kinetic: Force | None = None
    """Kinetic friction force F_fk [N]."""
    mu_kinetic: Coefficient | None = None
    """Coefficient of kinetic friction [-], in place of `kinetic`."""
    normal: Force | None = None
    """Normal force [N] behind the coefficients; default 9.81 m/s² times the mass."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("kinetic", "mu_kinetic"),)
    needs: ClassVar[dict[str, str]] = {"normal": "mu_kinetic"}
    symbols: ClassVar[dict[str, str]] = {}
    """The source's symbols for keys of the law's own; a key without one is told as it is."""

    @property
    def static_given(self) -> bool:
        """Whether anybody said what the static limit is; a law without one leaves no doubt."""
        return True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """The frequencies of a normal force that varies periodically [Hz]."""
        return ()

    def kinetic_force(self, m: float) -> float:
        """Give F_fk [N]; the mass [kg] is the normal force's default."""
        if self.kinetic is not None:
            return self.kinetic
        # Neither is given while the faults of a file are being collected.
        return self.forced(0.0 if self.mu_kinetic is None else self.mu_kinetic, m)

    def forced(self, mu: float, m: float) -> float:
        """Give the force [N] behind a coefficient."""
        return mu * (GRAVITY * m if self.normal is None else self.normal)

    def spelled_out(self, m: float) -> dict[str, Any]:
        """Give the words of the block with every default in them."""
        words = self.model_dump(exclude_none=True)
        if self.mu_kinetic is not None and self.normal is None:
            words["normal"] = GRAVITY * m
        return words


class Limits(Kinetic):
    """A force against sliding, and the greater one that a contact at rest holds."""

    static: Force | None = None
    """Static limit F_fs [N], at least the kinetic force; default: equal to it."""
    static_ratio: Annotated[float, Quantity("", at_least=1)] | None = None
    """F_fs/F_fk [-], at least 1, in place of `static`; default 1."""
    mu_static: Coefficient | None = None
    """Coefficient of static friction [-], at least that of kinetic friction."""

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

    def static_force(self, m: float) -> float:
        """Give F_fs [N]."""
        if self.static is not None:
            return self.static
        if self.mu_static is not None:
            return self.forced(self.mu_static, m)
        return self.kinetic_force(m) * (1.0 if self.static_ratio is None else self.static_ratio)

    def spelled_out(self, m: float) -> dict[str, Any]:
        """Give the words of the block with every default in them."""
        words = super().spelled_out(m)
        return words if self.static_given else words | {"static_ratio": 1.0}


class Rubbing(Kinetic):
    """A force against sliding that is above zero: the measure of the law's own state.

    The contact of such a law yields, or falls, towards it.
    """

    @model_validator(mode="after")
    def _always_rubs(self) -> Self:
        for name in ("kinetic", "mu_kinetic", "normal"):
            if getattr(self, name) == 0.0:
                without = "leave out the block `friction` for none"
                raise Misfit(f"must be above 0 under law `{self.law}`; {without}", name)
        return self
