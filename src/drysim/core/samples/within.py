"""How far the mass slides within a short step and where it stops: by the series it allows."""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow
from drysim.core.samples.longer import longer_series
from drysim.core.samples.series import distance, fall, rate, series, speed
from drysim.core.samples.stop import NEVER, locate_stop


@inlined
def coast(steps, v, a, r, h):
    """Give distance and velocity after sliding for a time h, parameters as in `locate_stop`."""
    if steps.brief:
        q = series(steps.tail, v, a, r - steps.c * a - steps.w * v)
        return distance(q, h), speed(q, h)
    q = longer_series(steps.tail, steps.more, v, a, r - steps.c * a - steps.w * v)
    return distance(q, h), speed(q, h)


@inlined
def rate_after(steps, v, a, r, h):
    """Return the acceleration after sliding for a time h, parameters as in `locate_stop`."""
    j = r - steps.c * a - steps.w * v
    if steps.brief:
        return rate(series(steps.tail, v, a, j), h)
    return rate(longer_series(steps.tail, steps.more, v, a, j), h)


@inlined
def stop_within(steps, v, a, r, v_end, h):
    """Give the first stop in a short step, or in what is left of it.

    Parameters
    ----------
    steps : Steps
    v, a, r, h : float
        As in `locate_stop`.
    v_end : float
        Velocity at the end, should the mass not stop before [m/s].

    Returns
    -------
    stop, way : float
        When it stops [s] and how far it slides until then [m]; infinity when it does not.
    """
    c, w = steps.c, steps.w
    j = r - c * a - w * v
    if steps.brief:
        stop, way = stop_by_series(series(steps.tail, v, a, j), v_end, h)
    else:
        stop, way = stop_by_series(longer_series(steps.tail, steps.more, v, a, j), v_end, h)
    if stop > 0.0:
        return stop, way
    return stop_by_flow(c, w, v, a, r, v_end, h)


@inlined
def stop_by_series(q, v_end, h):
    """Give what `stop_within` does of a short stretch; -1 leaves it to the general way."""
    if v_end > 0.0 and (q[1] >= 0.0 or rate(q, h) <= 0.0):
        return NEVER, 0.0
    if q[0] > 0.0 and v_end <= 0.0:
        return fall(q, h)
    return -1.0, 0.0


@compiled
def stop_by_flow(c, w, v, a, r, v_end, h):
    """Give what `stop_within` does of a stretch of any length, in the general way."""
    stop = locate_stop(c, w, v, a, r, h)
    if stop == NEVER:
        if v_end > 0.0 or v == 0.0:
            return NEVER, 0.0
        stop = h
    y, _, Y, YY = flow(c, w, stop)
    return stop, v * y + (a + c * v) * Y + r * YY
