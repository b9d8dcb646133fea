"""The periodic orbit that a start leads to, under any law.

Coulomb friction under sines has an algorithm of its own (`drysim.core.orbit`). Any other motion
is followed period by period until it closes on itself; changes that die away are summed up on
the way. Neighbours then tell whether the orbit is one, or one of a continuum.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.approach import coulomb, end_stops, exact
from drysim.approach.solution import Orbit
from drysim.core.model import (
    AnyLaw,
    AnyState,
    Deflected,
    Dynamic,
    Law,
    Plant,
    Sines,
    Slider,
    Stopped,
)
from drysim.core.orbit import AWAY, RESTS, SLOW, decays, fixed_point, patience, radius

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drysim.approach.piecewise import AnyOther, Traced
    from drysim.approach.solution import Floats, Path
    from drysim.approach.taylor import Series


def find_orbit(
    plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit with the core that fits the law."""
    if isinstance(law, Stopped):
        return find_bounded_orbit(plant, law, motion, start, period)
    if not isinstance(law, Law):
        return find_marched_orbit(plant, law, motion, start, period)
    return coulomb.find_orbit(plant, law, motion, start, period)


WAY = 2_000
"""Periods on the way to an orbit that are looked at for a stop."""

DECAYS = 40.0
"""Decays after which what a start has left is below double precision."""


def find_bounded_orbit(
    plant: Plant, law: Stopped, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit, between the stops or without reaching them."""
    bare = coulomb.find_orbit(plant, law.coulomb, motion, start, period)
    if bare.settled and bare.run_up_peak < law.x_rM:
        decay = 0.5 * plant.b / plant.m * period
        periods = WAY if decay * WAY < DECAYS else math.ceil(DECAYS / decay)
        way = coulomb.follow(plant, law.coulomb, motion, start, max(periods, 1) * period)
        if not end_stops.reached(way, law.x_rM):
            return bare
    return find_marched_orbit(plant, law, motion, start, period)


# The orbit of a motion that is followed step by step.


MOST_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

SETTLED_ROUNDING = 1e-12
"""Scaled change of the state over a repetition that is none in closed form [-]."""

SLACK = 10.0
"""Tolerances of a series that two repetitions may differ by."""

NUDGE = 1e-6
"""How far a neighbour is put from the orbit, relative to the motion."""

DRAWS = 1.0 - 1e-4
"""A map that shrinks distances less than this would not have settled; slopes by neighbours are
this sharp."""

Repeat = Callable[[float, float], AnyState]


def find_marched_orbit(
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
    left, multiple = change * closing.gain, multiple if settled else 1

    # By a series that is not sharp neighbours would not be told apart.
    sharp = law._replace(tolerance=SETTLED_ROUNDING) if isinstance(law, Dynamic) else law

    def repeat(dx: float, dv: float) -> AnyState:
        state, length = beside(law, end, dx, dv), multiple * period
        return once(plant, sharp, motion, state, length).state(length)

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


def once(
    plant: Plant, law: AnyOther | Dynamic, motion: Sines, state: AnyState, period: float
) -> Traced | Series:
    """Follow a state for one period."""
    if isinstance(law, Stopped):
        return end_stops.march(plant, law, motion, state, period)
    track: Any = exact.follow(plant, law, motion, state, period)
    found: Traced | Series = track
    return found


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


def closed(law: AnyOther | Dynamic) -> float:
    """Give the scaled change of the state over a repetition that counts as none [-]."""
    if isinstance(law, Dynamic):
        return max(SETTLED_ROUNDING, SLACK * law.tolerance)
    return SETTLED_ROUNDING


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


# How a motion that is followed period by period closes on itself.


MOST_MULTIPLE, USUAL = 64, 8
"""Longest repetition that is looked for, in periods of the excitation; and the longest by which
changes may be summed."""

CHANGES = 4
"""Changes that a sum is made of: one more than a state has numbers."""

DYING = 1e-2
"""Change below which a motion is taken to die away [-]."""

BETTER = 0.5
"""Share of the change before to which a sum must bring it: a motion that grows for ever changes
as much wherever it is put, and less only beside its own size."""

NOISE = 1e-8
"""Changes this much smaller than the others tell nothing [-]."""

ROUNDING = 1e-15
"""Of a change [-]: where changes fall so slowly that it adds up to more than the change itself,
their sum is a guess."""


class Closing:
    """The ends of the last periods, and where they lead to.

    Changes that die away like geometric series have a sum, to which the motion is moved on
    (reduced rank extrapolation; Sidi, Vector Extrapolation Methods, SIAM 2017). From there it
    is followed as before: an orbit is always followed, never extrapolated. `summed` tells
    whether that was done and kept, and `gain` by how much the state may be farther from the
    orbit than its last change.

    Parameters
    ----------
    closed : float
        Scaled change over a repetition that counts as none [-].
    quiet : float, optional
        Repetitions without events that a sum asks for; infinite for no sums at all.
    """

    def __init__(self, closed: float, quiet: float = 0.0) -> None:
        self.closed = closed
        self.wanted, self.summed = quiet, False
        self.quiet = 0
        self.ends: list[AnyState] = []
        self.scale: Sequence[float] = ()
        self.gain = 1.0
        self.before: tuple[float, AnyState] | None = None
        self.promised = 1.0

    def add(self, end: AnyState, largest: Sequence[float], events: int = 0) -> bool:
        """Add the state at the end of a period, and the largest of each number on the way.

        Gives whether it counts. The period after a sum shows whether that led to where the
        motion changes less, in the scale from before. If not, the period is forgotten: the
        motion goes on from where it was.
        """
        if self.before is not None:
            (least, last), self.before = self.before, None
            if self.distance(end, self.ends[0]) > max(BETTER * least, self.closed):
                self.ends = [last]
                return False
            self.gain, self.summed = self.promised, True
        self.quiet = 0 if events else self.quiet + 1
        before = self.scale or (0.0,) * len(largest)
        self.scale = [max(new, 0.5 * old) for new, old in zip(largest, before, strict=True)]
        self.ends = [end, *self.ends[:MOST_MULTIPLE]]
        return True

    def repetition(self) -> tuple[float, int]:
        """Give the scaled change over a repetition [-], and of how many periods that is.

        The shortest that is closed; where none is, the usual one that is closest to it. One
        that is longer is none where the motion hardly changes over a usual one: it dies away.
        """
        if len(self.ends) < 2:
            return math.inf, 1
        ends = self.scaled(self.ends)
        changes = np.abs(ends[1:] - ends[0]).max(axis=1)
        least = int(changes[:USUAL].argmin())
        closed = np.flatnonzero(changes <= self.closed)
        if closed.size and (closed[0] < USUAL or changes[least] > NOISE):
            least = int(closed[0])
        return float(changes[least]), least + 1

    def distance(self, one: AnyState, other: AnyState) -> float:
        """Give how far two states are apart, scaled [-]."""
        ends = self.scaled((one, other))
        return float(np.abs(ends[0] - ends[1]).max())

    def scaled(self, states: Sequence[AnyState]) -> Floats:
        """Return the numbers of states in units of their scale [-], a row each."""
        return np.array([state[:3] for state in states]) / [size or 1.0 for size in self.scale]

    def onwards(self) -> AnyState:
        """Give where to follow the motion from: its end, or where its changes add up to."""
        change, periods = self.repetition()
        end = self.ends[0]
        ends = self.ends[: CHANGES * periods + 1 : periods]
        early = change > DYING or len(ends) <= CHANGES
        early |= self.quiet < self.wanted * periods
        if early or getattr(end, "turned", False):
            return end
        total = self.sum_of(self.scaled(ends[::-1]))
        if total is not None:
            self.before = change, end
            sizes = [size or 1.0 for size in self.scale]
            self.ends = [type(end)(*(total * sizes).tolist())]
        return self.ends[0]

    def sum_of(self, ends: Floats) -> Floats | None:
        """Give where the changes between some ends add up to; None where they do not die away.

        Parameters
        ----------
        ends : ndarray, shape (changes + 1, numbers)
        """
        changes = np.diff(ends, axis=0)
        sizes = np.abs(changes).max(axis=1)
        if not sizes[-1] < sizes[0]:
            return None
        last = changes[-1]
        shares = np.linalg.lstsq((changes[:-1] - last).T, -last, rcond=NOISE)[0]
        total: Floats = ends[-1] + shares @ (ends[1:-1] - ends[-1])
        gain = max(1.0, float(np.abs(total - ends[-1]).max() / sizes[-1]))
        if gain * ROUNDING > sizes[-1]:
            return None
        self.promised = gain
        return total
