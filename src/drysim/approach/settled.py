"""The periodic orbit of a motion that is followed step by step: one, or one of a continuum."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach import exact
from drysim.approach.closing import CHANGES, Closing
from drysim.approach.orbit import Orbit
from drysim.core.motion import Sines
from drysim.core.plant import Dynamic, Plant, Slider, Stopped
from drysim.core.sines.period_map import fixed_point, radius
from drysim.core.sines.reached import AWAY, RESTS, SLOW, decays, patience
from drysim.core.state import AnyState, Deflected

if TYPE_CHECKING:
    from drysim.approach.by_series import Series
    from drysim.approach.traced import Traced
    from drysim.approach.track import Path
    from drysim.approach.ways import AnyOther

MOST_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

ROUNDING = 1e-12
"""Scaled change of the state over a repetition that is none in closed form [-]."""

SLACK = 10.0
"""Tolerances of a series that two repetitions may differ by."""

NUDGE = 1e-6
"""How far a neighbour is put from the orbit, relative to the motion."""

DRAWS = 1.0 - 1e-4
"""A map that shrinks distances less than this would not have settled; slopes by neighbours are
this sharp."""

Repeat = Callable[[float, float], AnyState]


def once(
    plant: Plant, law: AnyOther | Dynamic, motion: Sines, state: AnyState, period: float
) -> Traced | Series:
    """Follow a state for one period."""
    if isinstance(law, Stopped):
        from drysim.approach.bounded import march

        return march(plant, law, motion, state, period)
    home = exact.home_of(law, motion)
    track: Traced | Series = home.follow(plant, law, motion, state, period)
    return track


def find_orbit(
    plant: Plant,
    law: AnyOther | Dynamic,
    motion: Sines,
    start: AnyState,
    period: float,
) -> Orbit:
    """Follow a start, period by period, to its periodic orbit.

    Notes
    -----
    A contact that holds all through a repetition has kept where it yielded last. No sum of
    changes tells that, so the motion is then followed without any until it holds. So is one
    that sums led to no orbit: where nothing settles, the start itself says what is told.
    """
    closing = Closing(closed(law))
    orbit, events = approached(plant, law, motion, start, period, closing)
    if closing.summed and isinstance(law, Slider) and events == 0:
        closing = Closing(closed(law), quiet=CHANGES)
        orbit, _ = approached(plant, law, motion, start, period, closing)
    if closing.summed and not orbit.settled:
        closing = Closing(closed(law), quiet=math.inf)
        orbit, _ = approached(plant, law, motion, start, period, closing)
    return orbit


def approached(
    plant: Plant,
    law: AnyOther | Dynamic,
    motion: Sines,
    start: AnyState,
    period: float,
    closing: Closing,
) -> tuple[Orbit, int]:
    """Give the orbit that a start leads to, and how many events its last period has."""
    state, peak, periods = start, 0.0, 0
    most = patience(plant, period, MOST_PERIODS)
    while True:
        track = once(plant, law, motion, state, period)
        way = track.path((0.0, period), None)
        sizes, end = largest(track, way, period), track.state(period)
        if closing.add(end, sizes, len(track.turns) - 1):
            periods, peak = periods + 1, max(peak, sizes[0])
            change, multiple = closing.repetition()
            if change <= closing.closed or periods >= most:
                break
        state = closing.onwards()
    settled, run_up = change <= closing.closed, periods * period
    left, multiple = closing.left(change), multiple if settled else 1

    def repeat(dx: float, dv: float) -> AnyState:
        state, length = beside(law, end, dx, dv), multiple * period
        return once(plant, sharp(law), motion, state, length).state(length)

    unique = True
    moves = float(np.ptp(way.x_r)) > RESTS * peak
    if settled and moves and decays(plant, multiple * period) < SLOW:
        unique, far = drawn(repeat, end, plant.k_x > 0.0, (closing.scale[0], closing.scale[1]))
        left = max(left, far)
        if not unique and far > AWAY:
            # Nothing draws it anywhere, and it does move on: slowly beside its own size.
            settled, multiple, unique = False, 1, True
    orbit = Orbit(end, multiple, change, settled, unique, run_up, peak, left)
    return orbit, len(track.turns) - 1


def largest(track: Traced | Series, way: Path, period: float) -> list[float]:
    """Give the largest of each number of the state within a period.

    One without events is a single piece, at whose ends the mass may be at rest: its mean speed
    is a measure then.
    """
    sizes = [float(np.abs(column).max()) for column in track.series]
    travelled = float(np.abs(np.diff(way.x_r)).sum())
    return [float(np.abs(way.x_r).max()), max(sizes[1], travelled / period), *sizes[2:]]


def beside(law: AnyOther | Dynamic, state: AnyState, dx: float, dv: float) -> AnyState:
    """Give a state beside another; a contact stays in its place, and bristles bend."""
    x_r, v_r = state.x_r + dx, state.v_r + dv
    if isinstance(law, Dynamic) and isinstance(state, Deflected):
        return Deflected(x_r, v_r, state.z + dx, state.turned)
    return state._replace(x_r=x_r, v_r=v_r)


def sharp(law: AnyOther | Dynamic) -> AnyOther | Dynamic:
    """Give the law by which neighbours are told apart: a series would blur them."""
    return law._replace(tolerance=ROUNDING) if isinstance(law, Dynamic) else law


def closed(law: AnyOther | Dynamic) -> float:
    """Give the scaled change of the state over a repetition that counts as none [-]."""
    return max(ROUNDING, SLACK * law.tolerance) if isinstance(law, Dynamic) else ROUNDING


def drawn(
    repeat: Repeat, end: AnyState, held: bool, scale: tuple[float, float]
) -> tuple[bool, float]:
    """Tell whether neighbours in x_r and v_r come closer to an orbit, and how far off it is.

    Parameters
    ----------
    repeat : callable
        Gives the state a repetition after that at the end, moved by dx_r [m] and dv_r [m/s].
    end : State or Deflected
        Of the orbit.
    held : bool
        Whether a spring holds the mass; without one no place is like another, and speeds count.
    scale : tuple of float
        Largest |x_r| [m] and |v_r| [m/s] of the motion.

    Returns
    -------
    unique : bool
        Whether they do.
    left : float
        What the motion would go on changing by, summed up and scaled [-]; in a repetition,
        where they do not.
    """
    image, slopes = repeat(0.0, 0.0), []
    # Inwards, for beyond a rigid stop there is nothing.
    for dx, dv in ((-math.copysign(NUDGE, end.x_r), 0.0), (0.0, NUDGE)):
        moved = repeat(dx * scale[0], dv * scale[1])
        off = (moved.x_r - image.x_r) / scale[0], (moved.v_r - image.v_r) / scale[1]
        slopes.append([each / (dx or dv) for each in off])
    (a, c), (b, e) = slopes
    gap = (image.x_r - end.x_r) / scale[0], (image.v_r - end.v_r) / scale[1]
    if not held:
        a, b, gap = 0.0, 0.0, (0.0, gap[1])
    if not radius(a, b, c, e) < DRAWS:
        return False, max(map(abs, gap))
    return True, max(map(abs, fixed_point(a, b, c, e, 1.0, *gap)))
