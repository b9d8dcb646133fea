"""Curves of a response as a picture needs them; draws nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from drysim.core.motion import acceleration_at
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import Dynamic, Law, Stopped

if TYPE_CHECKING:
    from drysim.approach.bounded import Bounded
    from drysim.approach.events import Floats
    from drysim.approach.response import Response

BINS = 1200
"""Bins of an envelope: about as many as the picture has dots across."""

WINDOW = 8.0
"""Natural periods in a zoomed view."""

PARTED = 1e-9
"""Share of the mean normal force that is none: what rounding leaves where surfaces part."""

SHARE = 0.4
"""Share of a response that a zoomed view shows at most: more of it is no closer look."""

POINTS = (150, 4000)
"""Fewest and most grid points in a zoomed view."""


class Curve(NamedTuple):
    """A stretch of the response, with every event as a point before and a point after it."""

    t: Floats
    u_dd: Floats
    x_dd: Floats
    x_r: Floats
    v_r: Floats
    F_f: Floats


class Peak(NamedTuple):
    """The greatest magnitude of a series, and its grid point."""

    value: float
    point: int


def curve(response: Response, part: slice) -> Curve:
    """Give a stretch of the response in which jumps of force and acceleration stand upright.

    Parameters
    ----------
    response : Response
    part : slice
        Part of the grid.

    Returns
    -------
    Curve
        Grid points and events in the order of time.
    """
    points = grid(response, part)
    sides = _event_sides(response, *ends(response, part))
    merged = [np.concatenate(series) for series in zip(*sides, points, strict=True)]
    order = np.argsort(merged[0], kind="stable")
    return Curve(*(series[order] for series in merged))


def grid(response: Response, part: slice) -> Curve:
    """Give the grid points of a stretch alone."""
    first, last, _ = part.indices(len(response))
    t = np.arange(first, last) * np.float64(response.dt)
    u_dd, x_dd = response.base(part), response.acceleration(part)
    x_r, v_r, *_ = response.points(part)
    return Curve(t, u_dd, x_dd, x_r, v_r, response.friction(part))


def ends(response: Response, part: slice) -> tuple[float, float]:
    """Give begin and end [s] of a stretch; the motion may end behind the last grid point."""
    first, last, _ = part.indices(len(response))
    begin, track = first * response.dt, response.track
    if track is None or last < len(response):
        return begin, (last - 1) * response.dt
    return begin, track.end


def _event_sides(response: Response, begin: float, end: float) -> tuple[Curve, Curve]:
    """Give the events of a stretch twice: as they were met and as they were left."""
    if response.points(slice(0, 1)).stop is not None:
        return _sides_of_track(response, begin, end)
    events = response.events
    directions = np.sign(events.kind)
    # The first event is the state at t = 0: nothing jumps there.
    inside = np.flatnonzero((events.t >= begin) & (events.t <= end))
    inside = inside[(inside > 0) & response.law.sticks]
    t, x_r, F_L = events.t[inside], events.x_r[inside], events.F_L[inside]
    plant, law = response.plant, response.law
    if isinstance(law, Pressed):
        limit = law.F_fk * law.load(t)
        # Where the surfaces part, meet or are apart, no force jumps, and v_r need not be 0.
        rubs = limit > PARTED * law.F_fk
        inside, t, x_r, F_L, limit = (each[rubs] for each in (inside, t, x_r, F_L, limit))
    elif isinstance(law, Law | Stopped):
        limit = law.F_fk * (1 + law.variation * np.sin(law.omega * t + law.phase))
    else:
        limit = np.full_like(t, law.F_fs)
    u_dd = (F_L - plant.k_x * x_r) / plant.m

    def side(direction: Floats) -> Curve:
        F_f = np.where(direction == 0, -F_L, direction * limit)
        x_dd = -(plant.k_x * x_r + F_f) / plant.m
        return Curve(t, u_dd, x_dd, x_r, np.zeros_like(t), F_f)

    return side(directions[inside - 1]), side(directions[inside])


def _sides_of_track(response: Response, begin: float, end: float) -> tuple[Curve, Curve]:
    """Give what `_event_sides` does where the mass may be moving at an event: at end stops."""
    track = cast("Bounded", response.track)
    t = track.events.t[1:]
    t = t[(t >= begin) & (t <= end)]
    m, k_x, b = response.plant

    def side(at: Floats) -> Curve:
        x_r, v_r, F_stop, F_f, d = track.at(at)
        u_dd = acceleration_at(response.motion, at)
        x_dd = np.where(d == 0, u_dd, -(k_x * x_r + b * v_r + F_f + F_stop) / m)
        return Curve(t, u_dd, x_dd, x_r, v_r, F_f)

    return side(np.nextafter(t, 0.0)), side(t)


def envelope(series: Callable[[slice], Floats], length: int) -> tuple[Floats, Floats, Floats]:
    """Give the middle [grid points], least and greatest value of each bin of a long series.

    Parameters
    ----------
    series : callable
        Gives the values of a part of the grid, so that they need not be held whole.
    length : int
        Grid points, at least `BINS`.
    """
    edges = np.linspace(0, length, BINS + 1).astype(np.int64)
    low, high = np.empty(BINS), np.empty(BINS)
    for at, (begin, end) in enumerate(
        zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ):
        values = series(slice(begin, end))
        low[at], high[at] = values.min(), values.max()
    return (edges[:-1] + edges[1:]) / 2, low, high


def greatest(response: Response, name: str, begin: int = 0) -> Peak:
    """Give the greatest |value| of ü or a series of `Points` from some grid point on."""
    found = Peak(-1.0, begin)
    for part in response.parts():
        of = response.base(part) if name == "u_dd" else getattr(response.points(part), name)
        values = np.abs(of[max(begin - part.start, 0) :])
        if len(values) and values.max() > found.value:
            found = Peak(float(values.max()), part.stop - len(values) + int(values.argmax()))
    return found


def zoom(response: Response, begin: float) -> slice:
    """Give the part of the grid around the largest stroke; around the largest ü when stuck.

    Parameters
    ----------
    response : Response
    begin : float
        End of the settling time [s]; the largest stroke is looked for behind it.
    """
    length, settled = len(response), min(round(begin / response.dt), len(response) - 1)
    x_r = response.points(slice(0, 1)).x_r
    moves = any((response.points(part).x_r != x_r).any() for part in response.parts())
    peak = greatest(response, "x_r" if moves else "u_dd", settled).point
    m, k_x, _ = response.plant
    period = 2 * np.pi * np.sqrt(m / k_x) if k_x > 0 else np.inf
    points = min(max(WINDOW * period / response.dt, POINTS[0]), POINTS[1])
    points = min(points, max(SHARE * length, 2.0))
    first = int(min(max(peak - points / 2, 0), length - points))
    return slice(first, first + int(points))


def stuck_stretches(response: Response, begin: float, end: float) -> list[tuple[float, float]]:
    """Give begin and length [s] of every stuck stretch: stick to next slip."""
    yields = isinstance(response.law, Dynamic) and not response.law.sticks
    if response.law.F_fs == 0 or yields:
        return []
    events = response.events
    until = np.append(events.t[1:], ends(response, slice(None))[1])
    stuck = events.kind == 0
    first = np.maximum(events.t[stuck], begin)
    last = np.minimum(until[stuck], end)
    return [(a, b - a) for a, b in zip(first.tolist(), last.tolist(), strict=True) if b > a]
