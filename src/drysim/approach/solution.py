"""What every approach gives, as plain values that know no file and no metric.

A `Response` is the motion on a grid, whole or part by part, with its `Events` and with how the
numbers were made (`Numerics`). Behind it is a `Trajectory`, the continuous solution that knows no
grid: any instant, any window. An `Orbit` is the motion that repeats itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import (
    BLOCK_SIZE,
    MAX_KEPT,
    AnyLaw,
    AnyState,
    CoulombLaw,
    EndStopLaw,
    Plant,
    Samples,
    Sines,
    Totals,
)

if TYPE_CHECKING:
    from drysim.core.events import EventLog


Floats = NDArray[np.float64]
Int8Array = NDArray[np.int8]

EVENT_NAMES = {
    0: "stick", 1: "slip+", -1: "slip-", 2: "reversal+", -2: "reversal-", 3: "lift",
    4: "contact+", -4: "contact-", 5: "release+", -5: "release-", 6: "impact+", -6: "impact-",
}  # fmt: skip
"""Event codes: the sign is the new direction of v_r; a stop that sticks has none."""


@dataclass(frozen=True, eq=False)
class Events:
    """Stops, break-aways and reversals in the order of time; the first is the state at t = 0.

    Attributes
    ----------
    t : ndarray, shape (n_events,)
        Time [s].
    kind : ndarray of int8, shape (n_events,)
        Code, see `EVENT_NAMES`.
    x_r : ndarray, shape (n_events,)
        Relative displacement [m].
    F_L : ndarray, shape (n_events,)
        Limit force m·ü + k_x·x_r [N], Eq. (9).
    """

    t: Floats
    kind: Int8Array
    x_r: Floats
    F_L: Floats

    def __len__(self) -> int:
        """Give the number of events."""
        return len(self.t)

    def __repr__(self) -> str:
        """Give how many there are and the first few, in a line."""
        first = zip(self.t[:3].tolist(), self.kind[:3].tolist(), strict=True)
        few = ", ".join(f"{EVENT_NAMES[kind]} at {t:.6g} s" for t, kind in first)
        more = ", ..." if len(self) > 3 else ""
        return f"<Events: {len(self)}; {few}{more}>"

    def until(self, t: float) -> Events:
        """Give the events up to an instant [s], itself included."""
        count = int(np.searchsorted(self.t, t, side="right"))
        return Events(self.t[:count], self.kind[:count], self.x_r[:count], self.F_L[:count])

    def select(self, which: NDArray[np.bool_]) -> Events:
        """Give some of the events, the first one always among them."""
        which[0] = True
        return Events(self.t[which], self.kind[which], self.x_r[which], self.F_L[which])

    @property
    def names(self) -> list[str]:
        """The names of the events, in order."""
        return [EVENT_NAMES[code] for code in self.kind.tolist()]


def events_from_log(log: EventLog, count: int, dt: float) -> Events:
    """Give what a kernel has written into a log, its times by steps of a length [s]."""
    n, s, kind, x_r, F_L = (np.asarray(column[:count]) for column in log)
    return Events(n * dt + s, kind.astype(np.int8), x_r, F_L)


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


class Points(NamedTuple):
    """Neighbouring points of a grid, each array of shape (n,).

    Attributes
    ----------
    x_r, v_r : ndarray
        Relative displacement [m] and velocity [m/s].
    d : ndarray of int8
        Direction of sliding: -1, +1, or 0 where stuck.
    force : ndarray or None
        Friction force as the approach had it [N]; None where the mode and the law give it.
    stop : ndarray or None
        Force of an end stop, counted like friction [N]; None where none is met.
    """

    x_r: Floats
    v_r: Floats
    d: Int8Array
    force: Floats | None = None
    stop: Floats | None = None

    def select(self, part: slice) -> Points:
        """Give some of the points."""
        x_r, v_r, d, force, stop = self
        bare = Points(x_r[part], v_r[part], d[part])
        if stop is not None:
            bare = bare._replace(stop=stop[part])
        return bare if force is None else bare._replace(force=force[part])


class Grid(Protocol):
    """Where the points of a response come from."""

    @property
    def dt(self) -> float:
        """Distance of the points [s]."""

    def __len__(self) -> int:
        """Give their number."""

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""


@dataclass(frozen=True, eq=False)
class StoredGrid:
    """Points that are there with the base's acceleration [m/s²], `dt` seconds apart."""

    dt: float
    u_dd: Floats
    points: Points

    def __len__(self) -> int:
        """Give their number."""
        return len(self.points.x_r)

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return self.u_dd[first:last]

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        return self.points.select(slice(first, last))


@dataclass(frozen=True, eq=False)
class SlidingGrid:
    """The points of another grid, none of them stuck."""

    grid: Grid

    @property
    def dt(self) -> float:
        """Distance of the points [s]."""
        return self.grid.dt

    def __len__(self) -> int:
        """Give their number."""
        return len(self.grid)

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return self.grid.base(first, last)

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        points = self.grid.part(first, last)
        return points._replace(d=points.d * 0 + 1)


class Path(NamedTuple):
    """Where the mass came by: arrays of shape (points,), in the order of time.

    Attributes
    ----------
    t : ndarray
        Time [s].
    x_r : ndarray
        Relative displacement [m].
    """

    t: Floats
    x_r: Floats


class Trajectory(Protocol):
    """The continuous solution behind a response: any instant, any window."""

    @property
    def plant(self) -> Plant:
        """The oscillator."""

    @property
    def law(self) -> AnyLaw:
        """Its friction."""

    @property
    def closest_decision(self) -> float:
        """Smallest relative margin of a stop decision; infinite for none."""

    @property
    def end(self) -> float:
        """Last instant [s]."""

    def state(self, t: float) -> AnyState:
        """Give the state at time t [s]."""

    def totals(self, begin: float, end: float) -> Totals:
        """Give the integrals over a window [s]."""

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the points of x_r that tell all of its way in a window [s], from the start on.

        Between two of them x_r passes zero and a stroke limit x_rM [m] once at most, and goes
        no farther from zero than at some of them in the same half cycle.
        """

    def chatter(self, begin: float, end: float) -> float:
        """Give the share of a window in which v_r flips twice within four steps [-]."""


class HasTurningPoints(Protocol):
    """A track that knows where it turns."""

    @property
    def turning_points(self) -> Events:
        """The start and every zero of v_r: between two of them x_r is monotone."""


class EventDriven:
    """A track whose stops are located: nothing is left to flip with a step."""

    def path(self: HasTurningPoints, window: tuple[float, float], x_rM: float | None) -> Path:
        """Give the start and every zero of v_r: between two of them x_r is monotone."""
        return Path(self.turning_points.t, self.turning_points.x_r)

    def chatter(self, begin: float, end: float) -> float:
        """Give 0."""
        return 0.0


ALL_POINTS = (0, -1)
"""Stands for all points among the parts of a response that are kept; no part ends there."""


@dataclass(frozen=True, eq=False)
class Response:
    """Relative motion on an equidistant grid, with the events between its points.

    A long one that is not asked for as a whole never is one: `parts` cuts its grid into blocks,
    `base`, `points`, `acceleration` and `friction` give what belongs to each. What is not asked
    for is not computed.

    Attributes
    ----------
    plant, law, motion
        The scene.
    grid : Grid
        Where its points come from.
    events : Events
    how : callable
        Gives how the numbers were made.
    track : Track or None
        The solution between the grid points; None where only the motion was asked for.
    """

    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    grid: Grid
    events: Events
    compute_numerics: Callable[[], Numerics]
    trajectory: Trajectory | None = None
    _cache: dict[tuple[int, int], Points] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        """Give the number of grid points."""
        return len(self.grid)

    def __repr__(self) -> str:
        """Give how much there is of it, in a line."""
        grid = f"{len(self)} points at {self.dt:.6g} s"
        return f"<Response: {grid}, {len(self.events)} events>"

    @property
    def dt(self) -> float:
        """Distance of the grid points [s]."""
        return self.grid.dt

    @cached_property
    def numerics(self) -> Numerics:
        """How the numbers were made."""
        return self.compute_numerics()

    @property
    def all_points(self) -> Points:
        """All points."""
        # Kept as a part is: a cached property would lock, some hundredths of a short run.
        if ALL_POINTS not in self._cache:
            self._cache[ALL_POINTS] = self.grid.part(0, len(self.grid))
        return self._cache[ALL_POINTS]

    @cached_property
    def u_dd(self) -> Floats:
        """Base acceleration [m/s²], shape (n,)."""
        return self.grid.base(0, len(self))

    @property
    def x_r(self) -> Floats:
        """Relative displacement [m], shape (n,)."""
        return self.all_points.x_r

    @property
    def v_r(self) -> Floats:
        """Relative velocity [m/s], shape (n,)."""
        return self.all_points.v_r

    @property
    def d(self) -> Int8Array:
        """Direction of sliding, shape (n,): -1, +1, or 0 where stuck."""
        return self.all_points.d

    @cached_property
    def t(self) -> Floats:
        """Time of the grid points [s], shape (n,)."""
        t: Floats = np.arange(len(self), dtype=np.float64) * self.dt
        return t

    @cached_property
    def stuck(self) -> NDArray[np.bool_]:
        """Whether the mass sticks to the base, shape (n,)."""
        stuck: NDArray[np.bool_] = self.d == 0
        return stuck

    @cached_property
    def F_f(self) -> Floats:
        """Friction force as it acts on the mass [N], shape (n,); balances F_L while stuck."""
        return self.friction(slice(None))

    @cached_property
    def F_stop(self) -> Floats:
        """Force of an end stop, counted like F_f [N], shape (n,); an impact has none."""
        return self.stop(slice(None))

    @cached_property
    def x_dd(self) -> Floats:
        """Absolute acceleration of the mass [m/s²], shape (n,); equals ü while stuck."""
        return self.acceleration(slice(None))

    def parts(self) -> Iterator[slice]:
        """Cut the grid into blocks, in the order of time."""
        return (
            slice(at, min(at + BLOCK_SIZE, len(self))) for at in range(0, len(self), BLOCK_SIZE)
        )

    def base(self, part: slice) -> Floats:
        """Give ü [m/s²] on a part of the grid."""
        if len(self) <= MAX_KEPT or "u_dd" in vars(self):
            return self.u_dd[part]
        first, last, _ = part.indices(len(self))
        return self.grid.base(first, last)

    def points(self, part: slice) -> Points:
        """Give a part of the grid, so that long responses need not be held whole."""
        if len(self) <= MAX_KEPT or ALL_POINTS in self._cache:
            return self.all_points.select(part)
        first, last, _ = part.indices(len(self))
        if (first, last) not in self._cache:
            self._cache.clear()
            self._cache[first, last] = self.grid.part(first, last)
        return self._cache[first, last]

    def friction(self, part: slice) -> Floats:
        """Give F_f [N] on a part of the grid."""
        x_r, _, d, force, _ = self.points(part)
        if force is not None:
            return force
        kinetic = d * self.law.F_fk
        if isinstance(self.law, CoulombLaw | EndStopLaw) and self.law.variation:
            t = np.arange(*part.indices(len(self))) * self.dt
            kinetic = kinetic * (
                1 + self.law.variation * np.sin(self.law.omega * t + self.law.phase)
            )
        F_L = self.plant.m * self.base(part) + self.plant.k_x * x_r
        return np.where(d == 0, -F_L, kinetic)

    def acceleration(self, part: slice) -> Floats:
        """Give x_dd [m/s²] on a part of the grid."""
        m, k_x, b = self.plant
        x_r, v_r, d, force, stop = self.points(part)
        pull = k_x * x_r + b * v_r + self.friction(part)
        if stop is not None:
            pull += stop
        sticks = force is None or stop is not None
        return np.where(d == 0 if sticks else False, self.base(part), -pull / m)

    def stop(self, part: slice) -> Floats:
        """Give F_stop [N] on a part of the grid; 0 where there is no end stop."""
        x_r, *_, stop = self.points(part)
        return np.zeros_like(x_r) if stop is None else stop


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
    distance: float = 0.0
