"""Which stretch of several responses tells most: where the yardstick sticks."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from drysim.core.motion import Sines
from drysim.report.plots import curves

if TYPE_CHECKING:
    from drysim.approach.events import Floats
    from drysim.approach.response import Response

PERIODS = (1.0, 3.0)
"""Least and most periods in the stretch, of the sine or else of the oscillator."""

STEPS = 240
"""Steps between them at which what flips with every step can be seen to do so."""

AROUND = 4.0
"""Lengths of a stuck stretch that are shown around it."""

CLOSEST = 0.3
"""Least part of the periods that is shown."""

Stretch = tuple[float, float]


def telling(response: Response, others: Iterable[Response], begin: float) -> Stretch:
    """Give begin and end [s] of the stretch to look at.

    Parameters
    ----------
    response : Response
        Of the yardstick.
    others : iterable of Response
        Of the approaches that are compared with it.
    begin : float
        End of the settling time [s].

    Notes
    -----
    It holds the longest stop that fits with the slips around it; the beginning of a longer one;
    without any, the greatest deviation.
    """
    end = (len(response) - 1) * response.dt
    least, most = (count * _period(response) for count in PERIODS)
    span = min(max(least, min(STEPS * response.dt, most)), end - begin)
    stops = curves.stuck_stretches(response, begin, end)
    fitting = [stop for stop in stops if stop[0] > begin and stop[1] <= 0.5 * span]
    if fitting:
        at, length = max(fitting, key=lambda stop: stop[1])
        middle, width = at + 0.5 * length, max(AROUND * length, CLOSEST * span)
        return _within(middle, min(width, span), begin, end)
    if stops:
        at, length = max(stops, key=lambda stop: stop[1])
        return _within(at if at > begin else at + length, span, begin, end)
    return _within(_apart(response, others, begin), span, begin, end)


def cycle(response: Response, first: float, last: float) -> Stretch:
    """Give begin and end [s] of a whole cycle around a stretch, on which loops can close."""
    if (length := repetition(response)) < inf:
        return 0.0, length
    end = (len(response) - 1) * response.dt
    least = _period(response)
    if last - first >= least:
        return first, last
    return _within(0.5 * (first + last), min(least, end), 0.0, end)


def _within(middle: float, width: float, begin: float, end: float) -> Stretch:
    """Give a stretch around an instant, moved to lie between two others."""
    first = max(min(middle - 0.5 * width, end - width), begin)
    return first, min(first + width, end)


def _period(response: Response) -> float:
    """Give the period of the base, or of the oscillator [s]."""
    if isinstance(response.motion, Sines) and response.motion.f:
        return 1.0 / min(response.motion.f)
    m, k_x, _ = response.plant
    return 2 * pi * sqrt(m / k_x) if k_x > 0 else 1.0


def _apart(response: Response, others: Iterable[Response], begin: float) -> float:
    """Give the instant at which another response differs most [s]."""
    gaps = [difference(response, other, begin) for other in others]
    worst = max(gaps, key=lambda gap: float(gap.max(initial=0.0)), default=np.empty(0))
    return begin + int(worst.argmax()) * response.dt if len(worst) else begin


def difference(response: Response, other: Response, begin: float) -> Floats:
    """Give |x_dd - x_dd of another| on the grid of a response from some instant on [m/s²]."""
    first = round(begin / response.dt)
    t = np.arange(first, len(response)) * response.dt
    own = response.acceleration(slice(first, None))
    beside = np.interp(np.mod(t, repetition(other)), other.t, other.x_dd)
    gap: Floats = np.abs(beside - own)
    return gap


def repetition(response: Response) -> float:
    """Give after how long a response repeats [s]: one of a steady orbit goes on and on."""
    if response.numerics.period_multiple is None:
        return inf
    assert response.track is not None, "an orbit is measured by its track"
    return response.track.end
