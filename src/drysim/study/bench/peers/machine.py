"""The state machine that every peer with events needs around its integrator.

A peer slides from an instant to the stop or to the end; sticking needs no integrator. This is
what a careful person writes around a general solver, and nothing of drysim's core is in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from drysim.core.motion import Samples
from drysim.errors import SolverError
from drysim.study.bench.work import Answer, Work

if TYPE_CHECKING:
    from drysim.approach.events import Floats

AHEAD = 512
"""Samples looked at together while the mass sticks."""

ROUNDING = 1e-15
"""What the instant of a break-away is sought to, relative to it."""

SLIPPING = 1e-300
"""Velocity [m/s] with which slip begins: above zero, so that its beginning is no stop."""

MOST_IN_A_ROW = 100
"""Events between two samples after which a peer counts as caught."""


class Slip(NamedTuple):
    """An instant of sliding: time [s], state, and the last sample that is known."""

    t: float
    x_r: float
    v_r: float
    n: int


class Slide(Protocol):
    """How a peer slides."""

    def __call__(self, begin: Slip, d: int, x_out: Floats, v_out: Floats) -> tuple[Slip, bool]:
        """Slide in direction d, write the samples passed, tell whether the mass has stopped."""


def follow(work: Work, slide: Slide) -> Answer:
    """Give the motion from the start to the last sample, sliding and sticking in turns."""
    x_out, v_out = np.zeros(work.samples + 1), np.zeros(work.samples + 1)
    d_out = np.zeros(work.samples + 1)
    now = Slip(0.0, *work.start, 0)
    x_out[0], v_out[0] = work.start
    d = direction(work, now) if now.v_r == 0.0 else int(np.sign(now.v_r))
    d_out[0], row, stops = d, 0, 0
    while now.n < work.samples:
        n = now.n
        if d == 0:
            now = stick(work, now, x_out)
            d = -int(np.sign(limit_force(work, now)))
        else:
            now, stopped = slide(now, d, x_out, v_out)
            d_out[n + 1 : now.n + 1] = d
            stops += stopped
            d = direction(work, now) if stopped else d
        row = row + 1 if now.n == n else 0
        if row > MOST_IN_A_ROW:
            raise SolverError(f"events follow each other without end at t = {now.t:.6g} s")
    return Answer(x_out, v_out, lambda: friction(work, x_out, d_out), stops=stops)


def limit_force(work: Work, now: Slip) -> float:
    """Give the force that holds the mass [N], Eq. (9)."""
    return work.plant.m * work.base(now.t) + work.plant.k_x * now.x_r


def direction(work: Work, now: Slip) -> int:
    """Give the direction in which a mass at rest starts to slide, 0 where it sticks."""
    F_L = limit_force(work, now)
    return 0 if abs(F_L) <= work.law.F_fs else -int(np.sign(F_L))


def stick(work: Work, now: Slip, x_out: Floats) -> Slip:
    """Stick until the limit force meets the static limit, or to the end.

    The limit force is monotone wherever ü is, so looking at the ends of such stretches misses
    no break-away.
    """
    m, F_k = work.plant.m, work.plant.k_x * now.x_r
    t, u_dd = work.monotone
    end, away, at = work.samples, work.end, int(np.searchsorted(t, now.t, side="right"))
    while at < len(t):
        over = np.abs(m * u_dd[at : at + AHEAD] + F_k) > work.law.F_fs
        if over.any():
            at += int(over.argmax())
            away = break_away(work, now, max(now.t, float(t[at - 1])), float(t[at]))
            end = max(now.n, int(np.searchsorted(work.grid[:-1], away, side="right")) - 1)
            break
        at += AHEAD
    x_out[now.n + 1 : end + 1] = now.x_r
    return Slip(away, now.x_r, 0.0, end)


def break_away(work: Work, now: Slip, begin: float, end: float) -> float:
    """Return the instant at which the limit force passes the static limit [s]."""
    from scipy.optimize import brentq

    m, F_k, F_fs, base = work.plant.m, work.plant.k_x * now.x_r, work.law.F_fs, work.base

    def beyond(t: float) -> float:
        return abs(m * base(t) + F_k) - F_fs

    if beyond(begin) >= 0.0:
        return begin
    if isinstance(work.motion, Samples):
        low = limit_force(work, now._replace(t=begin))
        rise = limit_force(work, now._replace(t=end)) - low
        limit = work.law.F_fs if rise > 0.0 else -work.law.F_fs
        return begin + (end - begin) * (limit - low) / rise
    if beyond(end) <= 0.0:
        return end
    t = float(brentq(beyond, begin, end, xtol=ROUNDING * end, rtol=ROUNDING))
    ahead = ROUNDING * end
    while beyond(t) <= 0.0:  # below the limit the mass would stop at once
        t, ahead = min(t + ahead, end), 2.0 * ahead
    return t


def friction(work: Work, x_r: Floats, d: Floats) -> Floats:
    """Give F_f on the grid [N]: kinetic where the mass slides, what holds it elsewhere."""
    F_L = work.plant.m * work.u_dd + work.plant.k_x * x_r
    F_f: Floats = np.where(d == 0, -F_L, d * work.law.F_fk)
    return F_f
