"""The exact march over samples on a spring contact of constant limit: hold and yield."""

from __future__ import annotations

import math

import numpy as np

from drysim.core.compiled import compiled, held, inlined
from drysim.core.contacts.contact import HOLD, POISED, holds
from drysim.core.contacts.hit import next_crossing, next_stop
from drysim.core.contacts.skim import skim
from drysim.core.contacts.whole import whole_steps
from drysim.core.events import ROOM, SLIP, STICK, limit_force, note, onset
from drysim.core.plant import Plant
from drysim.core.samples.glide import glide, look_ahead
from drysim.core.samples.march import STRETCH
from drysim.core.samples.steps import steps_of
from drysim.core.samples.stop import NEVER
from drysim.core.trail import mark


def march_joint(
    plant, law, u_dd, dt, n, end, x_r, v_r, x_0, mode, x_out, v_out, d_out, trail, at, log,
    count
):  # fmt: skip
    """March from sample n to sample `end`, or until trail or log is nearly full.

    Parameters
    ----------
    plant : Plant
    law : Slider
        Of constant normal force.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Distance of the samples [s].
    n, end : int
        First and last sample of this march.
    x_r, v_r, x_0 : float
        State at sample n [m, m/s], and where the contact carries no force [m].
    mode : int
        Of the contact, as in `touch`.
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached: the state, and in which direction the contact
        yields, 0 where it holds; what lies up to `end` may be scribbled on.
    trail, at : Trail, int
        Where to write each beginning of a mode, and how many are written.
    log, count : Log, int
        Where to write changes of mode, and how many are written.

    Returns
    -------
    n, x_r, v_r, x_0, mode, at, count
        The sample reached, the state there, and what is written; `count` is negative when one
        step holds too many events.
    """
    bare = whole_steps(plant, dt)
    sprung = whole_steps(Plant(plant.m, plant.k_x + law.k_t, plant.b), dt)
    # A contact that yields holds with the force it has, so a faint velocity decides nothing.
    yields = steps_of(plant, law, dt)._replace(faint_f=0.0, faint_x=0.0)
    ahead = held(np.empty(STRETCH)), held(np.empty(STRETCH))
    return march_on(
        plant, law, bare, sprung, yields, u_dd, n, end, x_r, v_r, x_0, mode,
        x_out, v_out, d_out, trail, at, log, count, *ahead,
    )  # fmt: skip


@compiled
def march_on(
    plant, law, bare, sprung, yields, u_dd, n, end, x_r, v_r, x_0, mode, x_out, v_out, d_out,
    trail, at, log, count, x_ahead, v_ahead,
):  # fmt: skip
    """March stretch by stretch, as `march_joint` says; the last two are scratch for one."""
    reach = law.F_fk / law.k_t
    stiffness, f_k = law.k_t / plant.m, law.F_fk / plant.m
    begin, until = n, n
    full = len(trail.n) - ROOM
    while n < end and at <= full and 0 <= count <= full:
        if n >= until:
            begin, until = -1, min(n - n % STRETCH + STRETCH, end)
        if mode == HOLD and v_r != 0.0 and sprung.fine:
            n, x_r, v_r = skim(
                sprung, u_dd, n, until, x_r, v_r, -stiffness * x_0, x_0 - reach, x_0 + reach,
                x_out, v_out, d_out,
            )  # fmt: skip
        elif mode * v_r > 0.0 and yields.fine:
            if begin < 0:
                begin = n
                look_ahead(yields.x_base, u_dd[n : until + 1], x_ahead)
                look_ahead(yields.v_base, u_dd[n : until + 1], v_ahead)
            n, x_r, v_r = glide(
                yields, u_dd, n, until, x_r, v_r, mode, x_out, v_out, d_out, begin, x_ahead,
                v_ahead
            )  # fmt: skip
        if n < until:
            x_r, v_r, x_0, mode, at, count = through(
                plant, reach, stiffness, f_k, bare, sprung, u_dd[n], u_dd[n + 1], n, x_r, v_r,
                x_0, mode, trail, at, log, count,
            )  # fmt: skip
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = 0 if holds(mode) else mode
    return n, x_r, v_r, x_0, mode, at, count


@inlined
def through(
    plant, reach, stiffness, f_k, bare, sprung, u_0, u_1, n, x_r, v_r, x_0, mode, trail, at,
    log, count
):  # fmt: skip
    """Carry the state through one step that may hold any number of events.

    `stiffness` and `f_k` are k_t [1/s²] and F_fk [m/s²] per mass; the rest is as in `march_on`.
    """
    h, c = bare.dt, bare.c
    slope = (u_1 - u_0) / h
    begin = 0.0
    room = count + ROOM
    # The force of the contact does not jump, so neither does a: what takes no time keeps it.
    a, stopped = math.nan, 0
    while count < room:
        left = h - begin
        if left <= 0.0:
            return x_r, v_r, x_0, mode, at, count
        holding = holds(mode)
        w, f = (sprung.w, -stiffness * x_0) if holding else (bare.w, mode * f_k)
        if a != a:
            a = -(u_0 + slope * begin + c * v_r + w * x_r + f)
            # A velocity that has just fallen to zero does not rise by the rounding of forces.
            a = 0.0 if stopped * a > 0.0 else a
        way = onset(v_r, a, -slope)
        if way == 0:
            return x_r, v_r, x_0, mode, at, count
        v, push, r = way * v_r, way * a, -way * slope
        if holding:
            gap = reach - way * (x_r - x_0) if mode != way * POISED else 0.0
            stop, far, v_end = (
                next_stop(sprung, v, push, r, left) if gap > 0.0 else (0.0, 0.0, v)
            )
            if far >= gap:
                s, x_next = 0.0, x_r
                if gap > 0.0:
                    s, v = next_crossing(sprung, v, push, r, gap, far, v_end, min(stop, left))
                    x_next = x_0 + way * reach
                    a, stopped = math.nan, 0
                begin = min(begin + s, h)
                x_r, v_r, mode = x_next, way * v, way
                at = mark(trail, at, n, begin, x_r, v_r, x_0, mode)
                F_L = limit_force(plant, x_r, u_0 + slope * begin)
                count = note(log, count, n, begin, way * SLIP, x_r, F_L)
                continue
            mode = HOLD
        elif way != mode:
            stop, far, v_end = 0.0, 0.0, 0.0
        else:
            stop, far, v_end = next_stop(bare, v, push, r, left)
        x_r += way * far
        v_r = way * v_end
        if stop == NEVER:
            return x_r, v_r, x_0, mode, at, count
        begin = min(begin + stop, h)
        if stop > 0.0:
            a, stopped = math.nan, way
        if not holding:
            F_L = limit_force(plant, x_r, u_0 + slope * begin)
            x_0, mode = x_r - mode * reach, mode * POISED
            at = mark(trail, at, n, begin, x_r, v_r, x_0, mode)
            count = note(log, count, n, begin, STICK, x_r, F_L)
    return x_r, v_r, x_0, mode, at, -1
