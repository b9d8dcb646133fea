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
    from collections.abc import Callable

    from drysim.approach.events import Floats

AHEAD = 512
"""Samples looked at together while the mass sticks."""

ROUNDING = 4e-16
"""An interval this narrow, relative to its end, holds no further number worth a look."""

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
    d_out[0], row = d, 0
    while now.n < work.samples:
        n = now.n
        if d == 0:
            now = stick(work, now, x_out)
            d = -int(np.sign(limit_force(work, now)))
        else:
            now, stopped = slide(now, d, x_out, v_out)
            d_out[n + 1 : now.n + 1] = d
            d = direction(work, now) if stopped else d
        row = row + 1 if now.n == n else 0
        if row > MOST_IN_A_ROW:
            raise SolverError(f"events follow each other without end at t = {now.t:.6g} s")
    return Answer(x_out, v_out, lambda: friction(work, x_out, d_out))


def limit_force(work: Work, now: Slip) -> float:
    """Give the force that holds the mass [N], Eq. (9)."""
    return work.plant.m * work.base(now.t) + work.plant.k_x * now.x_r


def direction(work: Work, now: Slip) -> int:
    """Give the direction in which a mass at rest starts to slide, 0 where it sticks."""
    F_L = limit_force(work, now)
    return 0 if abs(F_L) <= work.law.F_fs else -int(np.sign(F_L))


def stick(work: Work, now: Slip, x_out: Floats) -> Slip:
    """Stick until the limit force meets the static limit, or to the end."""
    m, k_x = work.plant.m, work.plant.k_x
    n = now.n
    while n < work.samples:
        F_L = m * work.u_dd[n + 1 : n + 1 + AHEAD] + k_x * now.x_r
        over = np.abs(F_L) > work.law.F_fs
        held = int(over.argmax()) if over.any() else len(F_L)
        x_out[n + 1 : n + 1 + held] = now.x_r
        n += held
        if held < len(F_L):
            begin = max(now.t, n * work.step)
            return Slip(break_away(work, now, begin, (n + 1) * work.step), now.x_r, 0.0, n)
    return Slip(work.end, now.x_r, 0.0, n)


def break_away(work: Work, now: Slip, begin: float, end: float) -> float:
    """Give the instant at which the limit force passes the static limit [s]."""
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
    return root(beyond, begin, end)


def root(beyond: Callable[[float], float], begin: float, end: float) -> float:
    """Give where a function that rises through zero between two instants does so [s].

    Regula falsi with the Illinois rule: a handful of evaluations, and never outside.
    """
    low, high = beyond(begin), beyond(end)
    if high <= 0.0:
        return end
    side = 0
    for _ in range(MOST_IN_A_ROW):
        t = (begin * high - end * low) / (high - low)
        if not begin < t < end:
            break
        value = beyond(t)
        if value == 0.0:
            return t
        if value > 0.0:
            end, high, low = t, value, 0.5 * low if side > 0 else low
            side = 1
        else:
            begin, low, high = t, value, 0.5 * high if side < 0 else high
            side = -1
        if end - begin <= ROUNDING * end:
            break
    return end


def friction(work: Work, x_r: Floats, d: Floats) -> Floats:
    """Give F_f on the grid [N]: kinetic where the mass slides, what holds it elsewhere."""
    F_L = work.plant.m * work.u_dd + work.plant.k_x * x_r
    F_f: Floats = np.where(d == 0, -F_L, d * work.law.F_fk)
    return F_f
