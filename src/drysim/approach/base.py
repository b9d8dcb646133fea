"""What an approach declares."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from drysim.units import Block

if TYPE_CHECKING:
    from drysim.core.model import AnyLaw, Plant


class Member(Block):
    """An approach with its options; a scenario that names what it cannot use is at fault."""

    use_friction: ClassVar[bool] = True
    """Whether it can use dry friction at all."""
    use_static: ClassVar[bool] = False
    """Whether it knows a static limit above kinetic friction."""
    use_variation: ClassVar[bool] = False
    """Whether it knows a normal force that varies."""
    use_dynamic: ClassVar[bool] = False
    """Whether it knows other laws than Coulomb's."""
    use_stops: ClassVar[bool] = False
    """Whether it knows end stops."""

    def pieces(self, plant: Plant, law: AnyLaw, dt: float) -> int:
        """Give the number of points that are computed for a step of the output grid [s]."""
        return 1
