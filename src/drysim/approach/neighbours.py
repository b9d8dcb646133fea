"""Whether a periodic orbit draws its neighbours to it, or is one of a continuum."""

from __future__ import annotations

import math
from collections.abc import Callable

from drysim.core.sines.period_map import radius
from drysim.core.state import AnyState, State

NUDGE = 1e-6
"""How far a neighbour is put from the orbit, relative to the motion."""

DRAWS = 1.0 - 1e-4
"""A map that shrinks distances less than this would not have settled; slopes by neighbours are
this sharp."""

Repeat = Callable[[AnyState], AnyState]


def drawn(repeat: Repeat, end: AnyState, scale: tuple[float, float]) -> bool:
    """Tell whether neighbours in x_r and v_r come closer to an orbit.

    Parameters
    ----------
    repeat : callable
        Gives the state a repetition later.
    end : State or Deflected
        Of the orbit.
    scale : tuple of float
        Largest |x_r| [m] and |v_r| [m/s] of the motion.
    """
    image, slopes = repeat(end), []
    # Inwards, for beyond a rigid stop there is nothing.
    for dx, dv in ((-math.copysign(NUDGE, end.x_r), 0.0), (0.0, NUDGE)):
        moved = repeat(State(end.x_r + dx * scale[0], end.v_r + dv * scale[1]))
        off = (moved.x_r - image.x_r) / scale[0], (moved.v_r - image.v_r) / scale[1]
        slopes.append([each / (dx or dv) for each in off])
    (a, c), (b, e) = slopes
    return bool(radius(a, b, c, e) < DRAWS)
