"""Rest: the base stands still."""

from __future__ import annotations

from typing import Literal

from drysim.core.motion import Sines
from drysim.excitation.member import Member


class Rest(Member):
    """A base that stands still: the free motion from `start`.

    Not to be confused with a mass at rest: it may be let go from anywhere, at any speed.
    """

    kind: Literal["rest"]
    """The base stands still."""

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Give the base acceleration: no sine at all."""
        return Sines((), (), ())
