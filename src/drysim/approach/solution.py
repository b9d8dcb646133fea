"""Results of every approach: response, events, trajectory, periodic orbit.

A `Response` is the motion on a grid, as a whole or in blocks, with its `Events` and a report on
the numerical method (`Numerics`). Behind it is a `Trajectory`, the continuous solution: state
at any time, integrals over any window (compare `scipy.integrate.OdeSolution`). An `Orbit` is a
periodic motion. These are plain values without reference to files or metrics.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import (
    BLOCK_SIZE,
    MAX_CACHED,
    AnyLaw,
    AnyState,
    DynamicLaw,
    Floats,
    Plant,
    Points,
    Samples,
    Sines,
    State,
    Totals,
    limit_force,
)

if TYPE_CHECKING:
    from drysim.core.events import EventLog
    from drysim.core.stroke import Crossings


Int8Array = NDArray[np.int8]

EVENT_NAMES = {
    0: "stick", 1: "slip+", -1: "slip-", 2: "reversal+", -2: "reversal-", 3: "lift",
    4: "contact+", -4: "contact-", 5: "release+", -5: "release-", 6: "impact+", -6: "impact-",
}  # fmt: skip
"""Names of the event codes. The sign is the direction of v_r after the event; stick and lift
have none."""


@dataclass(frozen=True, eq=False)
class Events:
    """Events of every kind in order of time; the first one is the start."""

    t: Floats
    kind: Int8Array
    x_r: Floats
    F_L: Floats

    def __len__(self) -> int:
        """Number of events."""
        return len(self.t)

    def __repr__(self) -> str:
        """Number of events and the first three, in one line."""
        first = zip(self.t[:3].tolist(), self.kind[:3].tolist(), strict=True)
        few = ", ".join(f"{EVENT_NAMES[kind]} at {t:.6g} s" for t, kind in first)
        more = ", ..." if len(self) > 3 else ""
        return f"<Events: {len(self)}; {few}{more}>"

    def until(self, t: float) -> Events:
        """Return the events up to and including time t [s]."""
        if t >= self.t[-1]:
            return self
        count = int(np.searchsorted(self.t, t, side="right"))
        return Events(self.t[:count], self.kind[:count], self.x_r[:count], self.F_L[:count])

    def select(self, which: NDArray[np.bool_]) -> Events:
        """Return the events where a mask is true; the first event is always included."""
        which[0] = True
        return Events(self.t[which], self.kind[which], self.x_r[which], self.F_L[which])

    @property
    def names(self) -> list[str]:
        """Names of the events, in order."""
        return [EVENT_NAMES[code] for code in self.kind.tolist()]


def events_from_log(log: EventLog, count: int, dt: float) -> Events:
    """Convert the first `count` rows of an event log to `Events`; `dt` is its step [s]."""
    n, s, kind, x_r, F_L = (np.asarray(column[:count]) for column in log)
    return Events(n * dt + s, kind.astype(np.int8), x_r, F_L)


FIXED_STEP = "step"
"""`Numerics.core` of the approaches with a fixed step, which locate no events."""


@dataclass(frozen=True)
class LyapunovExponent:
    """Largest Lyapunov exponent: mean rate at which small deviations of a motion grow.

    Attributes
    ----------
    value, low, high : float
        The exponent and its 95 % interval [1/s].
    periods : int
        Excitation periods over which it was averaged.
    chaotic : bool
        Whether it is clearly above zero.
    """

    value: float
    low: float
    high: float
    periods: int
    chaotic: bool

    @property
    def verdict(self) -> str:
        """What the exponent says of the motion, as a clause."""
        if self.chaotic:
            return "chaotic: nearby motions diverge exponentially"
        if self.high < 0.0:
            return "not chaotic: nearby motions do not diverge"
        return "undecided whether it is chaotic"


@dataclass(frozen=True)
class Numerics:
    """How a result was computed.

    Attributes
    ----------
    approach : str
        Name of the approach.
    core : str
        Name of the algorithm that solved the scene.
    why : str
        How that algorithm solves it, one phrase.
    engine : str
        `plain` or `compiled`.
    steps : int
        Steps of the output grid.
    events : int
        Number of events, including the state at t = 0.
    closest_decision : float or None
        Smallest relative margin of all decisions between stick and slip [-]: of stops and
        break-aways, and of those that just do not happen. None where nothing is decided.
    closure : float or None
        Largest change of the scaled state over one repetition of a periodic orbit [-]; not an
        error, as the motion may be much farther from the orbit.
    distance : float or None
        Estimated distance of the motion to its periodic orbit, scaled as the closure [-]; None
        where unknown, as by fixed steps or where nearby motions are not attracted.
    period_multiple : int or None
        Excitation periods per repetition of the orbit.
    error : float or None
        Estimated error of x_r relative to its peak [-], where the method provides one; that of
        a periodic orbit includes `distance`.
    lyapunov : LyapunovExponent or None
        Of a motion that has not become periodic, where it may be chaotic and is in closed form.
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
    lyapunov: LyapunovExponent | None = None
    distance: float | None = None


PointsOfRange = Callable[[int, int], Points]
"""Function that returns points `first` to `last` - 1 of a grid."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Points n·dt of a response, computed on request.

    Attributes
    ----------
    dt : float
        Step [s].
    length : int
        Number of points.
    base : callable
        Returns ü [m/s²] at points `first` to `last` - 1.
    evaluate : PointsOfRange
        Computes a range of points.
    cached : dict
        Points in memory by range: all of a short grid, or the latest range of a long one.
    """

    dt: float
    length: int
    base: Callable[[int, int], Floats]
    evaluate: PointsOfRange
    cached: dict[tuple[int, int], Points] = field(default_factory=dict)

    def __len__(self) -> int:
        """Number of points."""
        return self.length

    def points(self, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1."""
        whole = 0, self.length
        if (first, last) != whole and (self.length <= MAX_CACHED or whole in self.cached):
            return self.points(*whole).part(first, last)
        if (first, last) not in self.cached:
            self.cached.clear()
            self.cached[first, last] = self.evaluate(first, last)
        return self.cached[first, last]


def stored_grid(dt: float, u_dd: Floats, points: Points) -> Grid:
    """Return the grid of points and base acceleration [m/s²] that are in memory."""
    return Grid(dt, len(u_dd), partial(elements, u_dd), points.part)


def elements(values: Floats, first: int, last: int) -> Floats:
    """Return elements `first` to `last` - 1."""
    return values[first:last]


class Path(NamedTuple):
    """Start and turning points of x_r in order of time; arrays of shape (n,).

    Attributes
    ----------
    t : ndarray
        Time [s].
    x_r : ndarray
        Relative displacement [m].
    """

    t: Floats
    x_r: Floats

    def until(self, t: float) -> Path:
        """Return the points up to and including time t [s]."""
        count = int(np.searchsorted(self.t, t, side="right"))
        return Path(self.t[:count], self.x_r[:count])


class Impacts(NamedTuple):
    """Contacts with an end stop; arrays of shape (n,).

    Attributes
    ----------
    t : ndarray
        Time [s].
    v_r : ndarray
        Velocity just before [m/s]; its sign is the side of the stop.
    """

    t: Floats
    v_r: Floats


def keeps_anchor(monodromy: Floats) -> bool:
    """Return whether an elastic contact never yields, from a derivative by `monodromy`."""
    return len(monodromy) == 3 and bool((monodromy[2] == (0.0, 0.0, 1.0)).all())


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory:
    """Continuous solution behind a response: state at any time, integrals over any window.

    What its methods return here holds unless a class knows better.

    Attributes
    ----------
    plant, law, motion
        The scene.
    events : Events
        The start and every change of mode.
    end : float
        Final time [s].
    closest_decision : float
        Smallest relative margin of a decision between stick and slip [-].
    """

    plant: Plant
    law: Any
    motion: Any
    events: Events
    end: float
    closest_decision: float = math.inf

    def at(self, t: Floats) -> Points:
        """Return the motion at ascending times [s]; where it jumps, that after the jump."""
        raise NotImplementedError

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        raise NotImplementedError

    def state(self, t: float) -> AnyState:
        """Return the state at time t [s]."""
        points = self.at(np.array([t]))
        return State(float(points.x_r[0]), float(points.v_r[0]))

    @property
    def path(self) -> Path:
        """The start and the turning points of x_r, which is monotone between them.

        Here the events: where each is a zero of v_r and none of these is missing.
        """
        return Path(self.events.t, self.events.x_r)

    def chatter(self, begin: float, end: float) -> float:
        """Return the share of a window with two sign changes of v_r in four steps [-].

        It is 0 where stops are located: there is no step to chatter with.
        """
        return 0.0

    def crossing_times(self, crossings: Crossings) -> Floats:
        """Return the times of crossings of levels, accurate to rounding [s].

        They are roots between two states.
        """
        from drysim.core.roots import MAX_BISECTIONS, safeguarded_newton

        times = np.array(crossings.low)
        for i in np.flatnonzero(crossings.low < crossings.high).tolist():
            lo, hi, level, side, _ = (float(column[i]) for column in crossings)
            t = 0.5 * (lo + hi)
            for _ in range(MAX_BISECTIONS):
                x_r, v_r = self.state(t)[:2]
                lo, hi, t, done = safeguarded_newton(
                    lo, hi, t, side * (level - x_r), -side * v_r
                )
                if done:
                    break
            times[i] = t
        return times

    def monodromy(self) -> Floats:
        """Return the derivative of the final state by the first one, shape (n, n).

        The state is x_r [m], v_r [m/s] and, with an elastic contact, the x_r at which that
        carries no force [m]. NaN where it is not known in closed form.
        """
        return np.full((2, 2), math.nan)

    def jacobian(self) -> tuple[float, float] | None:
        """Return trace and determinant of the derivative of the final state by the first one.

        Of the three multipliers of an elastic contact one is trivial and left out: 0 of a
        contact that yields, as it forgets where it was, and 1 of one that never does. None
        where the motion grazes a stop or v_r = 0, and where no closed form is known.
        """
        M = self.monodromy()
        if not np.isfinite(M).all():
            return None
        if keeps_anchor(M):
            M = M[:2, :2]
        pairs = ((0, 1), (0, 2), (1, 2))[: 1 if len(M) == 2 else 3]
        minors = [float(M[i, i] * M[j, j] - M[i, j] * M[j, i]) for i, j in pairs]
        return float(np.trace(M)), sum(minors)

    @property
    def reaches_stops(self) -> bool:
        """Whether x_r reaches an end stop."""
        return False

    @property
    def without_stops(self) -> Self:
        """The same motion in the scene without end stops, where it reaches none."""
        return self

    def hits(self) -> Impacts:
        """Return the contacts with an end stop."""
        return Impacts(np.empty(0), np.empty(0))

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return the largest force of a bumper in a window [N]."""
        return 0.0


class ExactTrajectory(Trajectory):
    """Trajectory by an exact algorithm, from which any grid can be computed."""

    def points(self, dt: float, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1 of a grid with step dt [s]; samples have it."""
        raise NotImplementedError

    def error(self, grid: Grid) -> float | None:
        """Return the estimated error of x_r on a grid relative to its peak [-].

        None where there is none but rounding.
        """
        return None


@dataclass(frozen=True, eq=False)
class Response:
    """Relative motion on an equidistant grid, with the events between the grid points.

    Arrays are computed on first access. A long response need never be held as a whole: `parts`
    cuts the grid into blocks, and `base`, `points`, `acceleration` and `friction` return the
    values of one block.

    Attributes
    ----------
    plant, law, motion
        The scene.
    grid : Grid
        Source of the grid points.
    events : Events
    numerics : Numerics
        How the result was computed.
    trajectory : Trajectory or None
        Continuous solution; None where only the grid was computed.
    """

    plant: Plant = field(compare=False)
    law: AnyLaw = field(compare=False)
    motion: Sines | Samples = field(compare=False)
    grid: Grid = field(compare=False)
    events: Events
    numerics: Numerics
    trajectory: Trajectory | None = field(default=None, compare=False)

    def __len__(self) -> int:
        """Number of grid points."""
        return len(self.grid)

    def __repr__(self) -> str:
        """Number of points, step and number of events, in one line."""
        grid = f"{len(self)} points at {self.dt:.6g} s"
        return f"<Response: {grid}, {len(self.events)} events>"

    @property
    def dt(self) -> float:
        """Step of the grid [s]."""
        return self.grid.dt

    @property
    def all_points(self) -> Points:
        """All grid points."""
        return self.grid.points(0, len(self))

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
        """Friction force on the mass [N], shape (n,); balances F_L while stuck."""
        return self.friction(slice(None))

    @property
    def F_stop(self) -> Floats:
        """Force of the end stops [N], sign as F_f, shape (n,); impacts are not included."""
        return self.stop(slice(None))

    @property
    def x_dd(self) -> Floats:
        """Absolute acceleration [m/s²], shape (n,); equals ü while stuck."""
        return self.all_points.x_dd

    def parts(self) -> Iterator[slice]:
        """Return the slices of consecutive blocks of the grid."""
        return (
            slice(start, min(start + BLOCK_SIZE, len(self)))
            for start in range(0, len(self), BLOCK_SIZE)
        )

    def base(self, part: slice) -> Floats:
        """Return ü [m/s²] on a slice of the grid."""
        if len(self) <= MAX_CACHED or "u_dd" in vars(self):
            return self.u_dd[part]
        first, last, _ = part.indices(len(self))
        return self.grid.base(first, last)

    def points(self, part: slice) -> Points:
        """Return the points of a slice of the grid; a long response caches one slice."""
        first, last, _ = part.indices(len(self))
        return self.grid.points(first, last)

    def friction(self, part: slice) -> Floats:
        """Return F_f [N] on a slice of the grid."""
        x_r, _, d, x_dd, *given = self.points(part)
        friction: Floats | None = given[0]
        if friction is not None:
            return friction
        friction = np.multiply(d, self.law.F_fk, dtype=np.float64)
        if not isinstance(self.law, DynamicLaw) and self.law.variation:
            t = np.arange(*part.indices(len(self))) * self.dt
            friction *= 1 + self.law.variation * np.sin(self.law.omega * t + self.law.phase)
        rest = np.flatnonzero(d == 0)
        friction[rest] = -limit_force(self.plant, x_r[rest], x_dd[rest])
        return friction

    def acceleration(self, part: slice) -> Floats:
        """Return x_dd [m/s²] on a slice of the grid."""
        return self.points(part).x_dd

    def stop(self, part: slice) -> Floats:
        """Return F_stop [N] on a slice of the grid; 0 without end stops."""
        points = self.points(part)
        return np.zeros_like(points.x_r) if points.F_stop is None else points.F_stop


class Orbit(NamedTuple):
    """Periodic orbit reached from a start.

    Attributes
    ----------
    state : State or ContactState
        State at the beginning of the repetition.
    periods : int
        Excitation periods per repetition.
    closure : float
        Largest scaled change of the state over the repetition [-].
    settled : bool
        Whether the motion converged to a periodic orbit.
    unique : bool
        False if the orbit is found to be one of a continuum, without an attraction of its own.
        Tested where the motion decays slowly; a mass that stays stuck is not tested.
    run_up : float
        Time from the start to the beginning of the repetition [s].
    run_up_peak : float
        Largest |x_r| during that time [m].
    distance : float
        Estimated distance of the state to the orbit, scaled as the closure [-]: the sum of all
        remaining changes. Infinite where nearby motions are not attracted, NaN if unknown.
    """

    state: AnyState
    periods: int
    closure: float
    settled: bool
    unique: bool
    run_up: float
    run_up_peak: float
    distance: float = math.nan
