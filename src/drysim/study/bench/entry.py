"""Entry: one approach with one setting, ready to be timed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drysim.study.bench.work import Answer, Work

Run = Callable[[], Answer]
"""The timed part: everything that can be made beforehand has been made."""


@dataclass(frozen=True, eq=False)
class Entry:
    """One approach with one setting.

    Attributes
    ----------
    approach : str
        Name on the shelf, or of the peer.
    setting : str
        What sets this entry apart from others of its approach.
    ready : callable
        Gives the timed part for a work: compiles, allocates and cuts beforehand.
    step : float or None
        Step of its march [s]; None where it chooses its own.
    points : int
        Points that it computes for a sample.
    own : bool
        Whether it stands on drysim's shelf.
    lacks : tuple of str
        What of the scene it leaves out.
    """

    approach: str
    setting: str
    ready: Callable[[Work], Run]
    step: float | None = None
    points: int = 1
    own: bool = False
    lacks: tuple[str, ...] = ()
