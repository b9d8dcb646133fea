"""Viscous: the same plant without dry friction, the reference curve."""

from __future__ import annotations

from typing import ClassVar, Literal

from drysim.approach.stick_slip import Exact
from drysim.core.plant import AnyLaw, Law, Stopped

NO_FRICTION = Law(0.0, 0.0)


class Viscous(Exact):
    """Spring and damper alone; what the friction of the scene would be is left out.

    Not to be confused with an equivalent viscous damping: nothing stands in for the friction.
    """

    use_friction: ClassVar[bool] = False

    approach: Literal["viscous"] = "viscous"

    def acting(self, law: AnyLaw) -> AnyLaw:
        """Give no dry friction, between the same end stops."""
        return law._replace(F_fk=0.0, F_fs=0.0) if isinstance(law, Stopped) else NO_FRICTION
