"""How far a contact that holds may ring: what bounds the motion, whatever its turns are.

What a stiff contact has of its own swings fast about the slow response to the base, and fades:
the motion is within an envelope, and comes near it once a swing only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.events import sign
from drysim.core.sines.cease import above_zero
from drysim.core.sines.slide import steady_response
from drysim.core.waves import (
    ACROSS,
    ALONG,
    OMEGA,
    STEADY,
    STRIDE,
    V_START,
    X_START,
    A,
    normal_force,
)

SWINGS = 0.5
"""Radians of its own swing below which a contact is no longer led on by its envelope."""


class Ringing(NamedTuple):
    """What a stretch has besides the steady response to its force.

    Attributes
    ----------
    side : int
        Of the swing that is at its peak at about the start: 1 or -1, 0 where it is not known.
    size, fade : float
        The motion is side·size·exp(-fade s)·cos(omega s - phase) at time s [m, 1/s].
    omega, phase : float
        As above [rad/s, rad]; the phase is within a quarter of a swing.
    half, grows : float
        Half a swing [s], and by what share it was more half a swing before.
    bend : float
        Greatest acceleration of the steady response [m/s²].
    """

    side: int
    size: float
    fade: float
    omega: float
    phase: float
    half: float
    grows: float
    bend: float


@compiled
def ringing(stretch, waves):
    """Give what a stretch has of its own, waves anchored at its start."""
    c, w, x_r, v_r, _, _, _, g, r = stretch
    fade, square = 0.5 * c, w - 0.25 * c * c
    none = Ringing(0, 0.0, fade, 0.0, 0.0, 0.0, 0.0, 0.0)
    if square < 0.5 * w or w == 0.0:
        return none
    lag, rate, bend = x_r - (g - c * r / w) / w, v_r - r / w, 0.0
    for i in range(waves.size):
        at = STRIDE * i
        if waves.values[at + A] == 0.0:
            continue
        if waves.values[at + STEADY] == 0.0:
            return none
        lag -= waves.values[at + X_START]
        rate -= waves.values[at + V_START]
        swing = math.hypot(waves.values[at + ALONG], waves.values[at + ACROSS])
        bend += waves.values[at + OMEGA] ** 2 * swing
    omega = math.sqrt(square)
    across = (rate + fade * lag) / omega
    side = sign(lag) if lag != 0.0 else sign(across)
    phase = math.atan2(side * across, side * lag)
    half = math.pi / omega
    grows = math.exp(fade * half) - 1.0
    return Ringing(side, math.hypot(lag, across), fade, omega, phase, half, grows, bend)


@inlined
def slow(stretch, waves, s):
    """Give the steady response at time s of a stretch: x_r and v_r."""
    c, w, _, _, _, _, _, g, r = stretch
    x, v = (g + r * (s - c / w)) / w, r / w
    for i in range(waves.size):
        at = STRIDE * i
        if waves.values[at + A] != 0.0:
            swing, rate, _, _, _ = steady_response(waves.values, at, s)
            x += swing
            v += rate
    return x, v


@compiled
def stays_within(own, stretch, waves, law, middle, reach, loaded, begin, h):
    """Give until when x_r surely stays nearer to a middle than some reach, or h.

    Parameters
    ----------
    own : Ringing
        Of the stretch, known.
    stretch, waves, law
        Waves anchored at its start.
    middle, reach : float
        Middle and reach [m].
    loaded : bool
        Whether the reach varies as the normal force does.
    begin, h : float
        Time of the stretch to begin at, and its length [s].

    Notes
    -----
    The room between envelope and reach bends by no more than the steady response, the load and
    the fading do, the last most of all now: a parabola is below it. Where the envelope comes to
    the reach the motion itself need not.
    """
    bend = own.bend + (reach * law.variation * law.omega**2 if loaded else 0.0)
    s = begin
    while s < h:
        x, v = slow(stretch, waves, s)
        left = own.size * math.exp(-own.fade * s)
        room, gain = reach - left, own.fade * left
        if loaded:
            load, load_d, _ = normal_force(law, waves, s)
            room, gain = reach * load - left, gain + reach * load_d
        if room <= abs(x - middle):
            break
        most = bend + own.fade * own.fade * left
        up = above_zero(room - (x - middle), gain - v, most)
        down = above_zero(room + (x - middle), gain + v, most)
        s += min(up, down)
        if min(up, down) * own.omega < SWINGS:
            break
    return min(s, h)


@compiled
def clear_of(own, stretch, waves, law, x_0, side, peak):
    """Give how long before a peak of the swing a contact surely holds on one side [s].

    Parameters
    ----------
    own, stretch, waves, law
        As in `stays_within`.
    x_0 : float
        Where the contact carries no force [m].
    side, peak : int, float
        Side of the peak, and its time [s].

    Returns
    -------
    float
        Below 0 where the contact holds for half a swing on either side of the peak; half a
        swing at most.

    Notes
    -----
    Within half a swing h, cos(omega t) <= 1 - 2 (t/h)², and fading may add no more than
    2 (exp(fade h) - 1) |t|/h; the rest has moved by no more than its rate and bend allow.
    """
    half, reach = own.half, law.F_fk / law.k_t
    x, v = slow(stretch, waves, peak)
    load, load_d, _ = normal_force(law, waves, peak)
    left = own.size * math.exp(-own.fade * peak)
    room = reach * load - side * (x - x_0) - left
    loses = abs(reach * load_d - side * v)
    loses += 0.5 * half * (own.bend + reach * law.variation * law.omega**2)
    loses += 2.0 * left * own.grows / half
    recedes = 2.0 * left / (half * half)
    square = loses * loses - 4.0 * recedes * room
    if square < 0.0:
        return -1.0
    before = loses + math.sqrt(square)
    return before / (2.0 * recedes) if before < 2.0 * recedes * half else half
