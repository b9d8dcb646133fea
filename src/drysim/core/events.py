"""Event kinds, the logs of events and segments, and the decision between stick and slip.

A march writes its events to an `EventLog` and the start of each segment to `Segments`, or to
`SeriesSegments` for Taylor series: parallel arrays that the caller allocates, because kernels
do not allocate.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core import model
from drysim.core.compile import compiled, inlined

STICK, SLIP, REVERSAL, LIFT = 0, 1, 2, 3
CONTACT, RELEASE, IMPACT = 4, 5, 6
"""Kinds of event. All but stick and lift-off are multiplied by the sign of the new direction
of v_r."""

FORCE_ROUNDING = 1e-15
"""Relative rounding error of a limit force: of the product, the sum and the state."""

MAX_EVENTS_PER_STEP = 4096
"""Maximum number of events in one step; more than this is a motion that double precision does
not resolve."""

SERIES_LOG_RESERVE = 3
"""Events and segments that one step may add to their logs, and one spare entry."""


class EventLog(NamedTuple):
    """Events of a march: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int, shape (capacity,)
        Sample at or before the event.
    s : array of float, shape (capacity,)
        Time since that sample [s].
    kind : array of int8, shape (capacity,)
        0 stick, ±1 slip, ±2 reversal, 3 lift-off, ±4 contact with an end stop, ±5 release from
        it, ±6 impact; the sign is the new direction of v_r, 0 for stuck.
    x_r, F_L : array of float, shape (capacity,)
        Relative displacement [m] and limit force [N].
    """

    n: Any
    s: Any
    kind: Any
    x_r: Any
    F_L: Any


class Segments(NamedTuple):
    """Start of each closed-form segment of a motion; n and s as in `SeriesSegments`.

    Attributes
    ----------
    x_r, v_r : array of float
        State at the start [m, m/s]; x_r counts from the origin of the mode.
    x_0 : array of float
        x_r at which an elastic contact carries no force [m].
    d : array of int
        Mode, encoded; with Coulomb friction alone the direction of sliding.
    """

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    x_0: Any
    d: Any


class SeriesSegments(NamedTuple):
    """Start of each segment of a motion: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int
        Sample at or before the start; 0 under sines.
    s : array of float
        Time since that sample [s].
    x_r, v_r, z : array of float
        State at the start [m, m/s, m].
    d : array of int
        Direction of motion, times a code: 0 stuck or in equilibrium on bristles; ±1 moving; ±2
        at a break-away or leaving an equilibrium on bristles; ±3 (`CREEPING`) too slow for the
        Stribeck curve to have fallen. Under bristles, magnitudes above 2 (`QUASI_STEADY`) are 2
        plus the iterations of a quasi-steady series.
    terms : array of int
        Degree of its series; unused otherwise.
    rise, bend : array of float
        Slope of its hysteresis branch as in `TaylorSeries`; unused otherwise.
    """

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    z: Any
    d: Any
    terms: Any
    rise: Any
    bend: Any


@compiled
def record_event(log, count, n, s, kind, x_r, F_L):
    """Write one event; return the new number of events."""
    log.n[count] = n
    log.s[count] = s
    log.kind[count] = kind
    log.x_r[count] = x_r
    log.F_L[count] = F_L
    return count + 1


@inlined
def record_segment(segments, count, time, state, d):
    """Write the start of a segment; return the new number of segments.

    `time` has the columns n and s, `state` those between s and d.
    """
    segments[0][count], segments[1][count] = time
    segments[2][count], segments[3][count], segments[4][count] = state
    segments.d[count] = d
    return count + 1


@inlined
def slide_time(log, count, n, s, dt):
    """Return the time from the last event in a log to a time s within interval n [s]."""
    if count == 0:
        return n * dt + s
    return (n - log.n[count - 1]) * dt + (s - log.s[count - 1])


@compiled
def sign(value):
    """Return the sign of a number: -1, 0 or 1."""
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@inlined
def motion_direction(v_r, a, j):
    """Return the direction of motion: sign of v_r, else of a, else of the jerk j."""
    if v_r != 0.0:
        return sign(v_r)
    return sign(a) if a != 0.0 else sign(j)


limit_force = inlined(model.limit_force)
"""`model.limit_force` as a kernel."""


@inlined
def stick_limit(F_fs, F_k):
    """Return the greatest |F_L| at which the mass sticks [N]: F_fs plus the rounding of F_L.

    `F_k` is F_L without m ü. Equality sticks, and an excess of a few roundings counts as
    equality. Otherwise a mass that creeps up to its limit would stop and start at every
    rounding.
    """
    return F_fs + FORCE_ROUNDING * (F_fs + abs(F_k))


@inlined
def direction_from_rest(F_L, F_fs, F_k):
    """Return the direction in which a mass at v_r = 0 slides on, 0 if it sticks, Eq. (4)."""
    return 0 if abs(F_L) <= stick_limit(F_fs, F_k) else -sign(F_L)


@compiled
def decision_margin(F_L, F_fs):
    """Return the relative distance of a stop decision from the opposite outcome [-]."""
    larger = max(abs(F_L), F_fs)
    return abs(abs(F_L) - F_fs) / larger if larger > 0.0 else 1.0


class SampledLimit(NamedTuple):
    """Static limit at sample k: F_fs (1 + variation·sin(phase + advance·k)) [N]."""

    F_fs: float
    variation: float
    phase: float
    advance: float


@compiled
def excess_margin(plant, u_dd, limit, n, F_k, d, closest):
    """Return the smaller of `closest` and the relative margin of a break-away over samples [-].

    The mass would stay stuck under a limit above the extreme to which |F_L| goes on.

    Parameters
    ----------
    plant, u_dd
        The oscillator, and ü at the samples [m/s²].
    limit : SampledLimit
    n, d : int
        Interval of the break-away, and the direction in which the mass leaves.
    F_k : float
        F_L without m ü [N].
    closest : float
        Margin at which the search ends [-].
    """
    F_fs, variation, phase, advance = limit
    excess, larger = -math.inf, 1.0
    for k in range(n + 1, len(u_dd)):
        F, hold = -d * (plant.m * u_dd[k] + F_k), F_fs
        if variation > 0.0:
            hold *= 1.0 + variation * math.sin(phase + advance * k)
        if F - hold <= excess:
            # The last sample was the extreme.
            return min(closest, max(excess, 0.0) / larger)
        excess, larger = F - hold, F
        if excess >= closest * F:
            return closest
    # It rises up to the last sample; what follows is not known here.
    return closest


@compiled
def grazing_margin(plant, F_fs, low, time):
    """Return the relative margin of a stop that did not happen, or just happened [-].

    Notes
    -----
    A change of friction by this share of F_fs changes v_r by about `low`: over the `time` of
    the slide, or as long as the oscillator remembers a force.

    Parameters
    ----------
    plant : Plant
    F_fs, low, time : float
        Static limit [N]; least speed before the mass turned to faster motion, or `stop_depth`
        [m/s]; time since the slide began [s].
    """
    m, k_x, b = plant
    change = F_fs * time
    return low * (m + (b + math.sqrt(k_x * m)) * time) / change if change > 0.0 else math.inf


@inlined
def stop_depth(a, j):
    """Return how far v_r would go beyond zero but for a stop [m/s], infinite where it goes on.

    `a` and `j` are acceleration [m/s²] and jerk [m/s³] there, in the direction of motion.
    """
    return 0.5 * a * a / j if j > 0.0 else math.inf


@compiled
def initial_direction(plant, law, x_r, v_r, u_dd):
    """Return the direction of sliding at t = 0, F_L [N], and the margin of the decision [-].

    The friction limits may vary. The margin is infinite where v_r ≠ 0 or F_L = 0.
    """
    F_L = limit_force(plant, x_r, u_dd)
    if v_r != 0.0:
        return sign(v_r), F_L, math.inf
    F_fs = law.F_fs * (1.0 + law.variation * math.sin(law.phase))
    margin = decision_margin(F_L, F_fs) if F_L != 0.0 else math.inf
    return direction_from_rest(F_L, F_fs, plant.k_x * x_r), F_L, margin
