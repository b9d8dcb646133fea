"""Turns of a mass on a spring contact, as far as they tell anything of its way.

A contact that rings while it holds turns hundreds of times and more, and nearly none of them
leads anywhere: neither through zero nor a limit of the stroke, nor as far as it goes anyway.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.contacts.contact import begin_stretch, holds
from drysim.core.contacts.ring import ringing, stays_within
from drysim.core.events import onset, sign
from drysim.core.samples.stop import NEVER
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.slide import slide
from drysim.core.sines.stretch import starting

SLACK = 1e-14
"""Relative distance by which what is as far as something else may seem to be farther."""


@compiled
def unseen(x_r, far, x_rM):
    """Give between which displacements [m] nothing is told of a way.

    Parameters
    ----------
    x_r : float
        Where the mass is [m].
    far : float
        How far it is known to go on this side of zero [m].
    x_rM : float
        Limit of the stroke [m]; infinite for none.

    Returns
    -------
    low, high : float
        Zero, the limit and what is known to be reached lie outside, or on the ends.
    """
    size = abs(x_r)
    low, high = (0.0, x_rM) if size < x_rM else (x_rM, math.inf)
    high = min(high, max(far, size) * (1.0 + SLACK))
    return (low, high) if x_r > 0.0 else (-high, -low)


@compiled
def holds_unseen(law, trail, i, x_rM):
    """Tell whether the limits of a holding contact alone keep it where nothing is told."""
    side = sign(trail.x_r[i])
    low, high = unseen(trail.x_r[i], side * trail.x_r[i + 1], x_rM)
    reach = law.F_fk / law.k_t * (1.0 + law.variation)
    return low <= trail.z[i] - reach and trail.z[i] + reach <= high


@compiled
def next_turn(stretch, waves, h):
    """Give the first time in (0, h] at which v_r is zero, or infinity, and x_r then."""
    c, w, x_r, v_r, a, j, _, g, r = stretch
    way = onset(stretch.v_r, stretch.a, stretch.j)
    if way == 0:
        return NEVER, x_r
    return leave_slip(c, w, waves, x_r, v_r, a, j, g, r, way, h)


@compiled
def farthest(far, x_r):
    """Give the farthest of a half cycle [m], of what it was and where the mass is told next."""
    return far if far * x_r > 0.0 and abs(far) > abs(x_r) else x_r


@compiled
def goes_unseen(law, waves, stretch, x_turn, far, x_end, x_rM, turn, h):
    """Give until when the motion after a turn tells nothing, by its envelope [s].

    Parameters
    ----------
    law, waves, stretch
        The stretch of holding, and the waves anchored at its start.
    x_turn, far, x_end : float
        Where it turns, the farthest that is told of this half cycle, and where the piece
        ends [m]: whoever stays on this side until then is told to come by there.
    x_rM : float
        Limit of the stroke [m]; infinite for none.
    turn, h : float
        Time of the turn, and length of what is left of the piece [s].
    """
    if stretch.w * (h - turn) * (h - turn) < math.pi * math.pi:
        return turn
    own = ringing(stretch, waves)
    if own.side == 0:
        return turn
    side = sign(x_turn)
    until = turn
    for known in (max(side * far, side * x_end), side * far):
        low, high = unseen(x_turn, known, x_rM)
        middle, reach = 0.5 * (low + high), 0.5 * (high - low)
        until = stays_within(own, stretch, waves, law, middle, reach, False, turn, h)
        if until >= h or side * x_end <= side * far:
            return until
    return until


@compiled
def tell(plant, law, waves, u_dd, dt, trail, lengths, whole, x_rM, at, t_out, x_out):
    """Write the beginning of each piece and its turns, until all is told or no room is left.

    Parameters
    ----------
    plant, law, waves, u_dd, dt, trail
        As in `replay.read`.
    lengths : array, shape (pieces,)
        Of the pieces [s].
    whole : array, shape (pieces,)
        Whether every turn of a piece is wanted, as of the last one, or only what tells.
    x_rM : float
        Limit of the stroke [m]; infinite for none.
    at : tuple
        Where to go on: piece, time since its beginning [s], x_r and v_r then [m, m/s], and the
        farthest that is told of the half cycle [m].
    t_out, x_out : array, shape (room,)
        Written: time [s] and displacement [m].

    Returns
    -------
    at, count
        Where to go on, at the number of pieces where all is told; and how many are written.
    """
    i, s, x_r, v_r, far = at
    count = 0
    while i < len(trail.n) and count + 2 <= len(t_out):
        mode, t, only = trail.d[i], trail.n[i] * dt + trail.s[i], not whole[i]
        if s == 0.0:
            x_r, v_r = trail.x_r[i], trail.v_r[i]
            t_out[count], x_out[count] = t, x_r
            # What was told before a piece that a window cuts may lie outside the window.
            far = x_r if i > 0 and whole[i - 1] else farthest(far, x_r)
            count += 1
            yields = abs(mode) == 1 and law.variation == 0.0
            if yields or (only and holds(mode) and holds_unseen(law, trail, i, x_rM)):
                i += 1
                continue
        n = trail.n[i]
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        u_0 = u_dd[n] + slope * (trail.s[i] + s)
        c, w, f = begin_stretch(plant, law, waves, mode, trail.z[i], t + s)
        stretch = starting(c, w, waves, x_r, v_r, -u_0 - f, -slope)
        left = lengths[i] - s
        turn, x_turn = next_turn(stretch, waves, left)
        if turn >= left or not t + s + turn > t + s:
            i, s = i + 1, 0.0
            continue
        t_out[count], x_out[count] = t + s + turn, x_turn
        far = farthest(far, x_turn)
        count += 1
        until = turn
        if only and holds(mode):
            x_end = trail.x_r[i + 1]
            until = goes_unseen(law, waves, stretch, x_turn, far, x_end, x_rM, turn, left)
        if until > turn:
            x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, stretch.g, -slope, until)
        else:
            x_r, v_r = x_turn, 0.0
        s += until
    return (i, s, x_r, v_r, far), count
