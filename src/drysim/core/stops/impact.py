"""Rigid end stops: the rebound, and how a chatter of ever smaller rebounds ends in rest.

The flights that no number for x_r can show are not followed one by one: what they take of the
time and of x"² is summed in closed form. Their v_r² is below rounding.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.events import IMPACT, note
from drysim.core.sines.stretch import force_rates
from drysim.core.stops.bumper import APART, CHATTERS, STEADY, mode_of


@compiled
def pressures(plant, law, side, F_L, load):
    """Return what presses the mass to a rigid stop on the way away from it and back [m/s²]."""
    friction = law.F_fk * load
    return (-side * F_L + friction) / plant.m, (-side * F_L - friction) / plant.m


@compiled
def chatter_time(law, p, q, v):
    """Return how long all flights after a rebound at speed v last together, and the first [s].

    Parameters
    ----------
    p, q : float
        As in `pressures`, p above 0.

    Notes
    -----
    The mass flies v²/(2 p) high for v (1/p + 1/√(p q)) and is at the stop again with v √(q/p):
    the times are a geometric series. Without q friction holds the mass where it turns.
    """
    if q <= 0.0:
        return v / p, v / p
    flight = v * (1.0 / p + 1.0 / math.sqrt(p * q))
    keeps = law.e * math.sqrt(q / p)
    return flight / (1.0 - keeps) if keeps < 1.0 else math.inf, flight


@compiled
def chatter_acceleration(plant, law, p, q, z, load):
    """Return the mean square of x" [m²/s⁴] over all flights of a chatter at z [m].

    Friction has its sign on the way away for √q/(√p + √q) of the time: 1/p of 1/p + 1/√(p q).
    """
    pull, friction = plant.k_x * abs(z) / plant.m, law.F_fk * load / plant.m
    away = math.sqrt(q) / (math.sqrt(p) + math.sqrt(q)) if q > 0.0 else 1.0
    return away * (pull - friction) ** 2 + (1.0 - away) * (pull + friction) ** 2


@compiled
def comes_to_rest(plant, law, waves, slope, side, F_L, load, t, v):
    """Tell whether a chatter is such that no number for x_r can show it.

    Parameters
    ----------
    plant, law, waves
        Waves anchored at the impact.
    slope : float
        Rate of ü besides the waves [m/s³].
    side : int
        Of the stop.
    F_L : float
        Limit force at the impact [N].
    load : float
        Normal force relative to its mean [-].
    t : float
        Time of the impact [s].
    v : float
        Speed of the rebound [m/s].

    Notes
    -----
    That is so when the next flight is so low that x_r and the limit are one number, or so
    short that t and its end are, and when the force provably presses until the last of all
    flights is over, see `chatter_time`. The motion after them is then the same to the last
    bit, and what they take of the time is a closed form.
    """
    p, q = pressures(plant, law, side, F_L, load)
    if p <= 0.0:
        return False
    whole, flight = chatter_time(law, p, q, v)
    if not low_or_short(law, v * v / (2.0 * p), t, flight):
        return False
    return q <= 0.0 or force_rates(waves, slope)[0] * whole < q


@compiled
def low_or_short(law, high, t, flight):
    """Tell whether a flight leaves no trace in the numbers for x_r or for t."""
    return law.x_rM - high == law.x_rM or t + flight == t


@compiled
def rebound(plant, law, waves, slope, n, s, t, v_r, z, d, u_dd, load, log, count):
    """Throw the mass back from a rigid stop, or let it chatter to rest; gives v_r and mode.

    Parameters
    ----------
    n, s, t : int, float, float
        Interval, time in it [s]; and time since the start of the motion [s].
    v_r, d : float, int
        Velocity [m/s] before the impact, and its direction: the side of the stop.
    z : float
        Where the stop is [m].
    u_dd, load : float
        ü [m/s²] and the relative normal force then.
    """
    F_L = plant.m * u_dd + plant.k_x * z
    count = note(log, count, n, s, -d * IMPACT, z, F_L)
    speed = law.e * max(d * v_r, 0.0)
    if speed == 0.0:
        return 0.0, mode_of(APART, -d, STEADY), count
    if comes_to_rest(plant, law, waves, slope, d, F_L, load, t, speed):
        return -d * speed, mode_of(APART, 0, CHATTERS), count
    return -d * speed, mode_of(APART, -d, STEADY), count
