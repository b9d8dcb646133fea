"""A spring contact: its modes, and the oscillator and the force in each of them."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import sign
from drysim.core.plant import Plant
from drysim.core.waves import OMEGA, STEADY, STRIDE, anchor

HOLD, FREE, POISED = 0, 2, 4
"""Modes of the contact besides yielding in direction +1 or -1: it holds, it is lifted off, or,
with the sign of the direction, it has just ceased to yield and holds at its very limit."""

SLOW = 16.0
"""Square of how many times as fast as a wave a spring is that follows it at once."""

SLACK = 1e-14
"""Relative distance from its limit at which a contact that goes on is at its limit."""


@compiled
def holds(mode):
    """Tell whether the contact holds."""
    return mode == HOLD or abs(mode) == POISED


@compiled
def spring(plant, law, mode):
    """Give the oscillator as it is in a mode: a holding contact is one more spring."""
    return Plant(plant.m, plant.k_x + (law.k_t if holds(mode) else 0.0), plant.b)


@compiled
def steady_force(law, mode, x_0):
    """Give the part of the contact force that is constant in a mode [N]."""
    if holds(mode):
        return -law.k_t * x_0
    return 0.0 if mode == FREE else mode * law.F_fk


@compiled
def contact_force(law, mode, x_r, x_0, load):
    """Give the contact force [N]; `load` is the normal force relative to its mean."""
    if holds(mode):
        return law.k_t * (x_r - x_0)
    return 0.0 if mode == FREE else mode * law.F_fk * load


@compiled
def begin_stretch(plant, law, waves, mode, x_0, t):
    """Set the waves for a stretch from time t [s]; gives b/m, k/m and steady force/m."""
    effective = spring(plant, law, mode)
    anchor(waves, effective, law, t, mode if abs(mode) == 1 else 0)
    m = plant.m
    w = effective.k_x / m
    for i in range(waves.size):
        at = STRIDE * i
        if waves.values[at + STEADY] > 0.0 and SLOW * waves.values[at + OMEGA] ** 2 <= w:
            waves.values[at + STEADY] = 2.0
    return effective.b / m, w, steady_force(law, mode, x_0) / m


@inlined
def just_met(law, v_r, rate):
    """Give the mode of surfaces that carry nothing yet: what outruns their limit yields.

    `rate` is that of the limit [N/s].
    """
    return sign(v_r) if law.k_t * abs(v_r) > rate else HOLD


@compiled
def first_contact(law, x_r, v_r, x_0):
    """Give mode and x_0 at t = 0 of a contact that carries no force at x_0 [m].

    One that is bent to its limit, and bent on, yields already: its next event is not at once.
    One that would be bent beyond, as what an orbit is summed up to may tell, has given way.
    """
    load = 1.0 + law.variation * math.sin(law.phase)
    rate = law.F_fk * law.variation * law.omega * math.cos(law.phase)
    if load <= 0.0:
        # A force that only touches zero parts no surfaces; they carry nothing just then.
        parted = load < 0.0 or (law.variation > 1.0 and rate <= 0.0)
        return FREE if parted else just_met(law, v_r, rate), x_r
    way = sign(x_r - x_0)
    reach = law.F_fk * load / law.k_t
    far = abs(x_r - x_0)
    if far > reach:
        x_0 = x_r - way * reach
    bent = far >= reach - SLACK * (reach + abs(x_r))
    return (way if bent and law.k_t * way * v_r > rate else HOLD), x_0
