"""A contact that rings while it holds: its turns one after another, in closed form.

What a stiff contact has of its own swings fast about the slow response to the base. While that
ringing is the faster by far, every half swing holds just one turn, next to where the ringing
alone would turn: nothing need be searched for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.contacts.hit import NEAR, ROUNDS
from drysim.core.events import REVERSAL, note
from drysim.core.samples.stop import NEVER
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

OUTRUNS = 2.0
"""So many times as fast as the slow response the ringing must be: then both may only cancel
within π/6 of a zero of the ringing, where its slope is at least √3/2 of its greatest."""


class Ringing(NamedTuple):
    """What a stretch has besides the steady response to its force.

    Attributes
    ----------
    fade, omega : float
        Of the velocity speed·exp(-fade s)·cos(omega s - phase) [1/s, rad/s].
    speed, phase : float
        As above [m/s, rad].
    until : float
        Time of the stretch up to which it outruns the steady response [s]; 0 for never.
    """

    fade: float
    omega: float
    speed: float
    phase: float
    until: float


@compiled
def ringing(stretch, waves):
    """Give what a stretch has of its own, waves anchored at its start."""
    c, w, x_r, v_r, _, _, _, g, r = stretch
    fade, square = 0.5 * c, w - 0.25 * c * c
    none = Ringing(fade, 0.0, 0.0, 0.0, 0.0)
    if square < 0.5 * w or w == 0.0:
        return none
    lag, rate = x_r - (g - c * r / w) / w, v_r - r / w
    most_v, most_a = abs(r) / w, 0.0
    for i in range(waves.size):
        at = STRIDE * i
        if waves.values[at + A] == 0.0:
            continue
        if waves.values[at + STEADY] == 0.0:
            return none
        lag -= waves.values[at + X_START]
        rate -= waves.values[at + V_START]
        omega = waves.values[at + OMEGA]
        swing = omega * math.hypot(waves.values[at + ALONG], waves.values[at + ACROSS])
        most_v += swing
        most_a += omega * swing
    omega_d = math.sqrt(square)
    across = -(fade * rate + w * lag) / omega_d
    speed = math.hypot(rate, across)
    # Two zeros where the slow response outdoes the slope of the ringing would be one too many.
    least = max(OUTRUNS * most_v, most_a / (0.5 * (math.sqrt(3.0) * omega_d - fade)))
    if speed <= least:
        return none
    until = math.log(speed / least) / fade if fade > 0.0 and least > 0.0 else math.inf
    return Ringing(fade, omega_d, speed, math.atan2(across, rate), until)


@inlined
def ringing_motion(own, stretch, waves, turn, s, angle):
    """Give x_r, v_r, a, j and k at time s, which is `angle` past where the ringing turns.

    `turn` is 1 where the ringing turns upwards there, -1 where downwards.
    """
    c, w, _, _, _, _, _, g, r = stretch
    size = turn * own.speed * math.exp(-own.fade * s)
    sine, cosine = math.sin(angle), math.cos(angle)
    v = size * sine
    a = size * (own.omega * cosine - own.fade * sine)
    j = -c * a - w * v
    k = -c * j - w * a
    x = (g + r * (s - c / w) - a - c * v) / w
    v += r / w
    for i in range(waves.size):
        at = STRIDE * i
        if waves.values[at + A] == 0.0:
            continue
        swing, rate, push, push_d, push_dd = steady_response(waves.values, at, s)
        x += swing
        v += rate
        a += push
        j += push_d
        k += push_dd
    return x, v, a, j, k


@inlined
def turn_near(own, stretch, waves, turn, middle, shift):
    """Give how far from time `middle` the mass turns [s], infinity for not found; x_r and a.

    Parameters
    ----------
    own, stretch, waves, turn
        As in `ringing_motion`.
    middle, shift : float
        Where the ringing alone turns [s], and a guess.
    """
    for _ in range(ROUNDS):
        angle = own.omega * shift
        x, v, a, j, k = ringing_motion(own, stretch, waves, turn, middle + shift, angle)
        step = -v / a
        step -= step * step * (0.5 * j + k * step / 6.0) / (a + j * step)
        shift += step
        if abs(step) * own.omega <= NEAR:
            x += step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            return shift, x, a + step * (j + 0.5 * step * k)
        if 6.0 * abs(shift) * own.omega > math.pi:
            break
    return NEVER, 0.0, 0.0


@compiled
def ring(plant, law, waves, stretch, x_0, way, n, s, begin, x_r, left, log, count, full):
    """Follow a contact that rings from turn to turn; every turn is written to the log.

    Parameters
    ----------
    plant, law, waves, stretch
        Waves anchored where the stretch starts; the contact holds.
    x_0 : float
        Where the contact carries no force [m].
    way : int
        Direction of motion after the turn to begin at.
    n, s : int, float
        Interval and time within it at which the stretch starts [s].
    begin, x_r, left : float
        Time of the stretch of that turn [s] and displacement then [m]; end of the stretch [s].
    log, count, full : Log, int, int
        Where to write zeros of v_r, how many events are written, and may be.

    Returns
    -------
    at, x_r, count
        Time of the stretch of the last turn [s], the displacement then, and the events
        written. The first turn not told is left to the general way, as are changes of mode.
    """
    own = ringing(stretch, waves)
    at = begin
    if own.until <= begin:
        return at, x_r, count
    half, reach = math.pi / own.omega, law.F_fk / law.k_t
    number = round((own.omega * begin - own.phase) / math.pi - 0.5)
    last = min(own.until, left) - half / 6.0
    # From turn to turn is a half swing and a third at most.
    loses = law.variation * law.omega * half * 4.0 / 3.0
    near, before = 0.0, 0.0
    while count < full:
        number += 1
        middle = (own.phase + (number + 0.5) * math.pi) / own.omega
        if middle > last:
            break
        upwards = -1 if number % 2 == 0 else 1
        if upwards == way:
            break
        shift, x, a = turn_near(own, stretch, waves, upwards, middle, before)
        if shift == NEVER:
            break
        load = normal_force(law, waves, middle + shift)[0] - loses
        if max(abs(x - x_0), abs(x_r - x_0)) >= reach * load:
            break
        near, before = shift, near
        at, x_r, way = middle + shift, x, upwards
        F_L = -plant.m * a - law.k_t * (x - x_0)
        count = note(log, count, n, s + at, way * REVERSAL, x_r, F_L)
    return at, x_r, count
