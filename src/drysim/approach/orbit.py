"""Orbit: the motion that repeats itself, as an approach finds it."""

from __future__ import annotations

from typing import NamedTuple

from drysim.core.state import AnyState


class Orbit(NamedTuple):
    """The periodic orbit that a start leads to.

    Attributes
    ----------
    state : State or Deflected
        At the beginning of the repetition.
    periods : int
        Excitation periods in the repetition.
    closure : float
        Largest scaled change of the state over the repetition [-].
    settled : bool
        Whether the scene closed at all.
    unique : bool
        Whether neighbours are drawn to it; false for one of a continuum of orbits.
    run_up : float
        Time from the start to the beginning of the repetition [s].
    run_up_peak : float
        Largest |x_r| on the way [m].
    left : float
        How far from the orbit the state still is, scaled as the closure [-]: what a motion that
        is followed until it repeats itself would go on changing by, summed up.
    """

    state: AnyState
    periods: int
    closure: float
    settled: bool
    unique: bool
    run_up: float
    run_up_peak: float
    left: float = 0.0
