"""What every excitation on the shelf says of itself. Knows none of them."""

from __future__ import annotations

from collections.abc import Collection
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

    def told(self, varied: Collection[str] = ()) -> str:
        """Give what it is by its keys, behind its kind, without those that a sweep varies.

        Parameters
        ----------
        varied : collection of str
            Keys of the block, such as `speed`.

        Returns
        -------
        str
            E.g. `C at 10 m/s` of a road; nothing where its motion tells it all.
        """
        return ""
