"""Codes of events, the log they are written to, and whether a mass sticks at the start.

A march writes what happens to a `EventLog`, and to a `SeriesSegments` or `Segments` where each segment of the
motion begins: parallel arrays, as kernels do not allocate.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import compiled, inlined

STICK, SLIP, REVERSAL, LIFT = 0, 1, 2, 3
CONTACT, RELEASE, IMPACT = 4, 5, 6
"""Kinds of event; but for stick and lift they carry the sign of the new direction."""

FORCE_ROUNDING = 1e-15
"""Relative error of a limit force: the product and the sum round, as does the state."""

MAX_EVENTS_PER_STEP = 4096
"""Most events that one step may hold; more is a scene at the end of double precision."""

LOG_RESERVE = 3
"""Events and steps that one step may add to their logs, and one to spare."""


class EventLog(NamedTuple):
    """Where a march writes its events: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int, shape (capacity,)
        Sample at or before the event.
    s : array of float, shape (capacity,)
        Time since that sample [s].
    kind : array of int8, shape (capacity,)
        0 stick, ±1 slip, ±2 reversal, ±4, ±5, ±6 contact with an end stop, its end, an impact;
        the sign is the new direction of v_r.
    x_r, F_L : array of float, shape (capacity,)
        Relative displacement [m] and limit force [N].
    """

    n: Any
    s: Any
    kind: Any
    x_r: Any
    F_L: Any


class Segments(NamedTuple):
    """Where each segment of a motion begins that is solved in closed form, as in `SeriesSegments`."""

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    z: Any
    d: Any


class SeriesSegments(NamedTuple):
    """Where each piece begins: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int
        Sample at or before the beginning; 0 under sines.
    s : array of float
        Time since that sample [s].
    x_r, v_r, z : array of float
        The state there [m, m/s, m].
    d : array of int
        Direction of motion, 0 where stuck or at rest on bristles; 2 and -2 where the mass
        breaks away just then, or leaves its equilibrium on bristles; 3
        and -3 where it is too slow for friction to have fallen. Under bristles, above 2: how
        many rounds a series on settled ones took, as in `settle`.
    terms : array of int
        Last term of its series; else not written.
    rise, bend : array of float
        Slope of the branch that bristles with a memory are on, as in `Jet`; else not written.
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
    """Write one event; returns the new count."""
    log.n[count] = n
    log.s[count] = s
    log.kind[count] = kind
    log.x_r[count] = x_r
    log.F_L[count] = F_L
    return count + 1


@inlined
def record_segment(segments, at, n, s, x_r, v_r, z, d):
    """Write where a segment begins; returns the new number of segments."""
    segments.n[at] = n
    segments.s[at] = s
    segments.x_r[at] = x_r
    segments.v_r[at] = v_r
    segments.z[at] = z
    segments.d[at] = d
    return at + 1


@compiled
def direction_after(kind):
    """Return the direction of sliding after an event of this kind, 0 for stuck."""
    return sign(kind)


@compiled
def sign(value):
    """Return -1, 0 or 1."""
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@inlined
def motion_direction(v_r, a, j):
    """Return the direction in which a mass sets out: of v_r, else of acceleration or jerk."""
    if v_r != 0.0:
        return sign(v_r)
    return sign(a) if a != 0.0 else sign(j)


@compiled
def limit_force(plant, x_r, u_dd):
    """Force the interface must carry for the mass to stay stuck [N].

    Notes
    -----
    Valid at v_r = 0 only: no damper term. Not to be confused with F_f, which balances it while
    stuck. Eq. (9).
    """
    return plant.m * u_dd + plant.k_x * x_r


@compiled
def stick_limit(plant, law, x_r):
    """Return the greatest |F_L| that a stuck mass bears [N]: F_fs, to the rounding of F_L.

    Equality sticks, and a force a few roundings beyond is equal: else a mass that creeps up to
    its limit would stop and start at each rounding.
    """
    return law.F_fs + FORCE_ROUNDING * (law.F_fs + abs(plant.k_x * x_r))


@compiled
def decision_margin(F_L, F_fs):
    """Relative distance of a stop decision from the other outcome [-]."""
    larger = max(abs(F_L), F_fs)
    return abs(abs(F_L) - F_fs) / larger if larger > 0.0 else 1.0


@compiled
def initial_direction(plant, law, x_r, v_r, u_dd):
    """Return the direction of sliding at the start, 0 for stuck."""
    if v_r != 0.0:
        return sign(v_r)
    F_L = limit_force(plant, x_r, u_dd)
    return 0 if abs(F_L) <= stick_limit(plant, law, x_r) else -sign(F_L)


@compiled
def initial_mode(plant, law, x_r, v_r, u_dd):
    """Return the mode at t = 0, F_L, and how near the mode is to the other [-].

    The limits may vary; the margin is infinite where nothing pulls.
    """
    load = 1.0 + law.variation * math.sin(law.phase)
    F_L = limit_force(plant, x_r, u_dd)
    if v_r != 0.0:
        return sign(v_r), F_L, math.inf
    F_fs = law.F_fs * load
    hold = F_fs + FORCE_ROUNDING * (F_fs + abs(plant.k_x * x_r))
    margin = decision_margin(F_L, F_fs) if F_L != 0.0 else math.inf
    return 0 if abs(F_L) <= hold else -sign(F_L), F_L, margin
