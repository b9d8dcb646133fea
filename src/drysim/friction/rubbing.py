"""Laws whose contact yields or falls towards a force, which therefore is never zero."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from drysim.friction.forces import Kinetic
from drysim.quantity import Misfit


class Rubbing(Kinetic):
    """A force against sliding that is above zero: the measure of the law's own state."""

    @model_validator(mode="after")
    def _always_rubs(self) -> Self:
        for name in ("kinetic", "mu_kinetic", "normal"):
            if getattr(self, name) == 0.0:
                without = "leave out the block `friction` for none"
                raise Misfit(f"must be above 0 under law `{self.law}`; {without}", name)
        return self
