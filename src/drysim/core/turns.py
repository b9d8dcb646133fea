"""What follows from the turning points of a solution: between two x_r is monotone."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import direction, sign
from drysim.core.grid import latest, state_within

NEWTON_CAP = 100
"""Newton needs about 5 rounds; a halved bracket is down to one float after 60."""


@compiled
def state_at(plant, law, waves, t, kind, x_r, v_first, at):
    """Give x_r and v_r at a time.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        The events; the first is the start of the run, with velocity `v_first` [m/s].
    at : float
        The time [s], not before the first event.
    """
    i = latest(t, at)
    v_r = v_first if i == 0 else 0.0
    d = direction(kind[i])
    return state_within(plant, law, waves, 0.0, 0.0, t[i], x_r[i], v_r, d, at - t[i])


@compiled
def passages(t, x_r, x_begin, x_end, end, x_rM):
    """Count what x_r does on its way from turn to turn, from 0 to the end of a window.

    Parameters
    ----------
    t, x_r : array, shape (events,)
        The events.
    x_begin, x_end : float
        Displacement at the ends of the window [m].
    end : float
        Its end [s].
    x_rM : float
        Stroke limit [m]; infinite for none.

    Returns
    -------
    peak : float
        Greatest |x_r| [m].
    upcrossings, entries : int
        How often x_r passes zero upwards, and |x_r| reaches the limit anew.
    """
    peak = max(abs(x_begin), abs(x_end))
    upcrossings, entries = 0, 0
    side = sign(x_begin)
    beyond = sign(x_begin) if abs(x_begin) >= x_rM else 0
    for i in range(len(t) + 1):
        x = x_r[i] if i < len(t) else x_end
        if i < len(t):
            peak = max(peak, abs(x))
            if not 0.0 < t[i] < end:
                continue
        if x != 0.0:
            upcrossings += side < 0 and x > 0.0
            side = sign(x)
        now = sign(x) if abs(x) >= x_rM else 0
        entries += now != 0 and now != beyond
        beyond = now
    return peak, upcrossings, entries


@compiled
def reach(plant, law, waves, t, kind, x_r, v_first, level, lo, hi):
    """Give the time at which x_r, monotone from lo to hi, is at a level [m] in between."""
    scene = (plant, law, waves, t, kind, x_r, v_first)
    rising = state_at(*scene, hi)[0] > state_at(*scene, lo)[0]
    at = 0.5 * (lo + hi)
    for _ in range(NEWTON_CAP):
        x, v = state_at(*scene, at)
        if x == level:
            return at
        if (x < level) == rising:
            lo = at
        else:
            hi = at
        before = at
        at = at + (level - x) / v if v != 0.0 else lo
        if not lo < at < hi:
            at = 0.5 * (lo + hi)
        if at == before or not lo < at < hi:
            return hi
    return at


@compiled
def excursions(plant, law, waves, t, kind, x_r, v_first, x_end, end, x_rM, repeats):
    """Give how often |x_r| is at or beyond a limit, when first [s], and for how long [s].

    Parameters
    ----------
    t, kind, x_r, v_first
        As in `state_at`.
    x_end, end : float
        Displacement at the end [m], and the end [s].
    x_rM : float
        Stroke limit [m], above 0.
    repeats : bool
        Whether the end goes on at the start, as on a periodic orbit.

    Returns
    -------
    times : int
    first : float
        Below 0 when there is none.
    beyond : float
    """
    scene = (plant, law, waves, t, kind, x_r, v_first)
    begins = sign(x_r[0]) if abs(x_r[0]) >= x_rM else 0
    times, first = (1, 0.0) if begins != 0 else (0, -1.0)
    entered, left = 0.0, 0.0
    side = begins
    for i in range(len(t)):
        until = t[i + 1] if i + 1 < len(t) else end
        x = x_r[i + 1] if i + 1 < len(t) else x_end
        now = sign(x) if abs(x) >= x_rM else 0
        if now == side:
            continue
        if side != 0:
            left += reach(*scene, side * x_rM, t[i], until)
        if now != 0:
            at = reach(*scene, now * x_rM, t[i], until)
            entered += at
            first = at if times == 0 else first
            times += 1
        side = now
    if side != 0:
        left += end
    # An excursion across the seam of an orbit is one, unless there is nothing else.
    seam = 1 if repeats and begins != 0 and side == begins and times > 1 else 0
    return times - seam, first, left - entered
