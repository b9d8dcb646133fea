"""How the numbers of a response were made. Plain values."""

from __future__ import annotations

from dataclasses import dataclass

FIXED_STEP = "step"
"""The core of the approaches that locate no event."""


@dataclass(frozen=True)
class Numerics:
    """How the numbers were made.

    Attributes
    ----------
    approach : str
        Name on the shelf.
    core : str
        Which core solved the scene.
    why : str
        Why that core: a sentence.
    engine : str
        `plain` or `compiled`.
    steps : int
        Steps of the output grid.
    events : int
        Number of events, the state at t = 0 included.
    closest_decision : float or None
        Smallest relative distance ||F_L| - F_fs|/max(|F_L|, F_fs) of all decisions at a stop
        [-].
    closure : float or None
        Largest change of the scaled state over one repetition of a periodic orbit [-].
    period_multiple : int or None
        Excitation periods in one repetition of the orbit.
    error : float or None
        Bound of the error of x_r relative to its peak [-], where the core has one to state.
    """

    approach: str
    core: str
    why: str
    engine: str
    steps: int
    events: int
    closest_decision: float | None = None
    closure: float | None = None
    period_multiple: int | None = None
    error: float | None = None
