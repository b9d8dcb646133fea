"""Rigid end stops: the rebound, and how a chatter of ever smaller rebounds ends in rest."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.events import IMPACT, STICK, note
from drysim.core.sines.stretch import force_rates
from drysim.core.stops.bumper import APART, STEADY, mode_of


@compiled
def comes_to_rest(plant, law, waves, slope, side, F_L, load, t, v):
    """Give how long a chatter lasts that no number can show, or -1 where it can be seen.

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
    The mass leaves with speed v against a force that brings it back: it flies v²/(2 p) high for
    v (1/p + 1/√(p q)) long, with p and q what presses it towards the stop on the way there and
    back, and is at the stop again with v √(q/p). So heights fall by e² q/p from one rebound to
    the next, and times by its root. The mass counts as at rest when the next flight is so low
    that x_r and the limit are one number, or so short that t and its end are, and when the
    force provably presses until the last of all flights is over. The rest of the motion is then
    the same to the last bit, whatever the mass does in this time.
    """
    friction = law.F_fk * load
    p = (-side * F_L + friction) / plant.m
    q = (-side * F_L - friction) / plant.m
    if p <= 0.0:
        return -1.0
    high = v * v / (2.0 * p)
    if q <= 0.0:
        # Friction holds it where it turns.
        flight = v / p
        return flight if low_or_short(law, high, t, flight) else -1.0
    flight = v * (1.0 / p + 1.0 / math.sqrt(p * q))
    if not low_or_short(law, high, t, flight):
        return -1.0
    keeps = law.e * math.sqrt(q / p)
    whole = flight / (1.0 - keeps) if keeps < 1.0 else math.inf
    change = force_rates(waves, slope)[0] * whole
    return whole if change < q else -1.0


@compiled
def low_or_short(law, high, t, flight):
    """Tell whether a flight leaves no trace in the numbers for x_r or for t."""
    return law.x_rM - high == law.x_rM or t + flight == t


@compiled
def rebound(plant, law, waves, slope, n, s, length, t, v_r, z, d, u_dd, load, log, count):
    """Throw the mass back from a rigid stop, or lay it to rest; gives v_r and mode.

    Parameters
    ----------
    n, s, length, t : int, float, float, float
        Interval, time in it, its length [s]; and time since the start of the motion [s].
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
    lasts = comes_to_rest(plant, law, waves, slope, d, F_L, load, t, speed)
    if lasts < 0.0:
        return -d * speed, mode_of(APART, -d, STEADY), count
    count = note(log, count, n, min(s + lasts, length), STICK, z, F_L)
    return 0.0, mode_of(APART, 0, STEADY), count
