"""Exact solution of scenes between end stops; one that never reaches them goes without them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from drysim.approach import coulomb, piecewise
from drysim.approach.scene import base_on_grid, grid_points, numerics, times
from drysim.approach.solution import (
    Events,
    Floats,
    Held,
    Located,
    Numerics,
    Path,
    Points,
    Response,
    Track,
)
from drysim.core.events import CONTACT, RELEASE, REVERSAL, SLIP, STICK, tightness
from drysim.core.model import AnyState, Plant, Samples, Sines, State, Stopped, Totals
from drysim.core.modes import MEET
from drysim.core.trajectory import hardest_push

NOT_REACHED = "the end stops are never reached"

CARRIED = (CONTACT, -CONTACT, RELEASE, -RELEASE)
"""Kinds of event at which the mass moves on: x_r has no extremum there."""


def solve(
    plant: Plant,
    law: Stopped,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene and write it on its grid; `whole` as in `coulomb.solve`."""
    bare = coulomb.solve(plant, law.coulomb, motion, start, step, duration, whole)
    assert bare.track is not None, "it is solved with its track"
    if not reached(bare.track, law.x_rM):
        how = partial(unreached_numerics, bare)
        return replace(bare, law=law, how=how, track=Unreached(law, bare.track))
    track = march(plant, law, motion, start, duration)
    dt = motion.dt if isinstance(motion, Samples) else step
    n = grid_points(track.end, dt)
    x_r, v_r, F_stop, F_f, d = track.at(times(0, n, dt))
    grid = Held(dt, base_on_grid(motion, 0, n, dt), Points(x_r, v_r, d, F_f, F_stop))
    events, approach = track.events, "stick-slip"
    if law.F_fs == 0.0:
        # As without stops: turning points are not events then, but rest at a stop is.
        kind, at_stop = np.abs(events.kind), np.abs(events.x_r) == law.x_rM
        stays = (kind >= CONTACT) | (at_stop & (kind <= SLIP))
        events, approach = events.chosen(stays), "viscous"
    how = partial(numerics, law, motion, n, events, track.closest, approach=approach)
    return Response(plant, law, motion, grid, events, how, track)


def unreached_numerics(bare: Response) -> Numerics:
    """Give how the numbers of a response were made that never reaches the stops."""
    return replace(bare.numerics, why=f"{bare.numerics.why}; {NOT_REACHED}")


def follow(
    plant: Plant, law: Stopped, motion: Sines | Samples, start: AnyState, duration: float | None
) -> Bounded | Unreached:
    """Solve a scene without its grid."""
    bare = coulomb.follow(plant, law.coulomb, motion, start, duration)
    if not reached(bare, law.x_rM):
        return Unreached(law, bare)
    return march(plant, law, motion, start, duration)


def reached(track: Track, x_rM: float) -> bool:
    """Tell whether |x_r| comes to a limit [m]: where its path comes by or at an end."""
    far = float(np.abs(track.path((0.0, track.end), x_rM).x_r).max())
    return max(far, abs(track.state(track.end).x_r)) >= x_rM


def march(
    plant: Plant, law: Stopped, motion: Sines | Samples, start: AnyState, duration: float | None
) -> Bounded:
    """Solve a scene that reaches its stops."""
    track = piecewise.follow_as(Bounded, plant, law, motion, start, duration)
    kind, F_L, x_r = track.events.kind, track.events.F_L, track.events.x_r
    decided = np.isin(kind, (STICK, REVERSAL, -REVERSAL))
    decided &= (np.abs(x_r) < law.x_rM) | (not law.rigid)
    closest = min((tightness(F, law.F_fs) for F in F_L[decided].tolist()), default=math.inf)
    return replace(track, closest=closest) if law.F_fs > 0.0 else track


class Hits(NamedTuple):
    """When the mass came to a stop, and how fast: arrays of shape (hits,).

    Attributes
    ----------
    t : ndarray
        Time [s].
    v_r : ndarray
        Velocity just before [m/s]; its sign is the side of the stop.
    """

    t: Floats
    v_r: Floats


@dataclass(frozen=True, eq=False)
class Bounded(piecewise.Traced):
    """A solution between end stops, known from each step to the next."""

    law: Stopped

    @cached_property
    def turns(self) -> Events:
        """The start, every zero of v_r and every impact: between two x_r is monotone."""
        return self.events.chosen(~np.isin(self.events.kind, CARRIED))

    @property
    def series(self) -> tuple[Floats, ...]:
        """What each component of the state came to along the way."""
        return self.turns.x_r, self.trail.v_r

    def state(self, t: float) -> State:
        """Give the state at time t [s]; at an impact, that after it."""
        x_r, v_r, *_ = self.at(np.array([t]))
        return State(float(x_r[0]), float(v_r[0]))

    def hits(self) -> Hits:
        """Give when the mass came to a stop, and how fast."""
        met = np.flatnonzero(self.trail.d == MEET)
        t = self.trail.n[met] * self.base[1] + self.trail.s[met]
        return Hits(t, self.trail.v_r[met])

    def hardest_push(self, begin: float, end: float) -> float:
        """Give the greatest force of a bumper in a window [N]."""
        kernel: Any = hardest_push
        force: float = kernel(*self.scene, begin, end)
        return force

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]; impacts at its end are in it."""
        totals = super().totals(begin, end)
        if not self.law.rigid:
            return totals
        t, v_r = self.hits()
        struck = np.square(v_r[(t > begin) & (t <= end)]).sum()
        lost = 0.5 * self.plant.m * (1.0 - self.law.e**2) * struck
        return totals._replace(hits=float(lost))


@dataclass(frozen=True, eq=False)
class Unreached(Located):
    """A solution of a scene with end stops that never reaches one."""

    law: Stopped
    bare: Track

    @property
    def plant(self) -> Plant:
        """The oscillator."""
        return self.bare.plant

    @property
    def closest(self) -> float:
        """Smallest relative margin of a stop decision; infinite for none."""
        return self.bare.closest

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s]."""
        return self.bare.path(window, x_rM)

    @property
    def end(self) -> float:
        """Last instant [s]."""
        return self.bare.end

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""
        return self.bare.state(t)

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""
        return self.bare.totals(begin, end)

    def hits(self) -> Hits:
        """Give no hits."""
        return Hits(np.empty(0), np.empty(0))

    def hardest_push(self, begin: float, end: float) -> float:
        """Give no force."""
        return 0.0
