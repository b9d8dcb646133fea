"""What every excitation on the shelf says of itself. Knows none of them."""

from __future__ import annotations

from typing import ClassVar

from drysim.quantity import Block


class Member(Block):
    """An excitation with its keys."""

    also_called: ClassVar[tuple[str, ...]] = ()
    """Words that somebody may have for it."""
    own_step: ClassVar[bool] = False
    """Whether its samples have a distance of their own, so that solver.step has no use."""
    own_end: ClassVar[bool] = False
    """Whether a run ends with it unless the scenario says otherwise."""
    periodic: ClassVar[bool] = False
    """Whether it is made of sines, which are used analytically and may repeat."""
    steady_by_default: ClassVar[bool] = False
    """Whether it is measured over the periodic orbit unless the scenario says otherwise."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """What repeats [Hz]; none unless it is periodic."""
        return ()
