"""Between end stops: what a mass without velocity does, and what a bumper leaves it to do."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import CONTACT, RELEASE, REVERSAL, ROUNDING, STICK, note, sign
from drysim.core.plant import Plant
from drysim.core.sines.leave import break_away, leave_stick
from drysim.core.stops.bumper import (
    APART,
    AWAY,
    POISED,
    STEADY,
    TOUCHING,
    mode_of,
    place,
    steady_pull,
    touch_of,
    wall_of,
)


@compiled
def at_rest(plant, law, touch, z, xi, u_dd, load):
    """Give the direction in which a mass with v_r = 0 slides on, 0 where it sticks, and F_L.

    Eq. (9) with the force of a bumper. A rigid stop bears what presses the mass against it.
    """
    pull = steady_pull(plant, law, touch, z, xi)
    F_L = plant.m * u_dd + pull
    hold = law.F_fs * load
    d = -sign(F_L) if abs(F_L) > hold + ROUNDING * (hold + abs(pull)) else 0
    return (0 if d != 0 and d == wall_of(law, z, xi) else d), F_L


@compiled
def first_bounds(plant, law, x_r, v_r, u_dd, load):
    """Give xi, v_r, z and the mode at t = 0."""
    z, xi, touch = place(law, x_r, v_r)
    d = sign(v_r)
    if d == 0:
        d, _ = at_rest(plant, law, touch, z, xi, u_dd, load)
    return xi, v_r, z, mode_of(touch, d, STEADY)


@compiled
def leave_rest(plant, law, waves, touch, z, xi, u_0, slope, left):
    """Give when a stuck mass breaks away, or infinity, and in which direction."""
    # What springs pull with is constant: one spring of 1 N/m that is so many metres long.
    pull = steady_pull(plant, law, touch, z, xi)
    wall = wall_of(law, z, xi)
    one = Plant(plant.m, 1.0, 0.0)
    if wall == 0:
        return break_away(one, law, waves, pull, u_0, slope, slope, left)
    return leave_stick(one, law, waves, pull, u_0, slope, wall, 0.0, left), -wall


@compiled
def let_go(touch, after, d, n, s, z, xi, F_L, log, count):
    """Change how the mass is to a bumper on its way inwards; gives xi and mode."""
    if abs(after) == AWAY and d * xi >= 0.0:
        after = APART
    if abs(touch) == TOUCHING:
        count = note(log, count, n, s, d * RELEASE, z + xi, F_L)
    elif after != APART:
        count = note(log, count, n, s, d * CONTACT, z + xi, F_L)
    if after == APART:
        return 0.0, mode_of(APART, d, STEADY), count
    return xi, mode_of(after, d, POISED), count


@compiled
def stand(plant, law, n, s, xi, z, mode, u_dd, load, log, count):
    """Decide what a mass does whose velocity is zero: stick, or slide on; gives its mode."""
    touch = touch_of(mode)
    if abs(touch) == AWAY:
        touch = touch // AWAY
    d, F_L = at_rest(plant, law, touch, z, xi, u_dd, load)
    count = note(log, count, n, s, d * REVERSAL if d != 0 else STICK, z + xi, F_L)
    return mode_of(touch, d, STEADY), count
