"""End stops: the modes of a mass between them, the force of a bumper, and when it ends.

Beside a stop the mass is placed by xi, how far x_r is beyond z = ±x_rM: so a contact or a
rebound of any size keeps all its digits, next to a limit however far from zero.
"""

from __future__ import annotations

from drysim.core.bracket import BISECTIONS, kept_between
from drysim.core.compiled import compiled
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.blend import Blend
from drysim.core.sines.slide import slide
from drysim.core.sines.stretch import starting
from drysim.core.sines.vanish import vanish

APART, TOUCHING, AWAY = 0, 1, 2
"""How the mass is to a stop: clear of it, pressed against it, or beyond the limit and yet
apart, as a bumper that only pushes cannot follow what leaves fast; times the side."""

STEADY, BROKE, POISED, CHATTERS = 0, 1, 2, 3
"""How a stretch begins: on its way, breaking away just then, with a bumper's force that is
zero just then; or it is the rest of a chatter against a rigid stop, with v_r that of the first
rebound."""

MEET = 1000
"""Mode of a mark that tells with which velocity the mass comes to a stop."""


@compiled
def mode_of(touch, d, fresh):
    """Give one number for how the mass is to the stops, its direction, and its beginning."""
    return d + 4 * touch + 64 * fresh


@compiled
def fresh_of(mode):
    """Give how a stretch in this mode begins."""
    return (mode + 32) // 64


@compiled
def touch_of(mode):
    """Give how the mass is to the stops: one of the constants times the side."""
    return (mode - 64 * fresh_of(mode) + 1) // 4


@compiled
def way_of(mode):
    """Give the direction of sliding, 0 where stuck."""
    return mode - 64 * fresh_of(mode) - 4 * touch_of(mode)


@compiled
def pushes(law, touch):
    """Tell whether a bumper acts."""
    return law.k_s > 0.0 and abs(touch) == TOUCHING


@compiled
def bumper_force(law, touch, xi, v_r):
    """Give the force of a bumper against the mass [N], positive at the positive stop.

    Notes
    -----
    F = k_s xi + b_s v_r while xi is beyond the limit and the bumper presses, else 0: it cannot
    pull. Where the mass leaves faster than the bumper relaxes, contact is lost beyond the
    limit already; if the mass slows down there enough, the bumper touches it again.
    """
    return law.k_s * xi + law.b_s * v_r if pushes(law, touch) else 0.0


@compiled
def steady_pull(plant, law, touch, z, xi):
    """Give what springs pull the mass back with [N], that of a bumper included."""
    return plant.k_x * (z + xi) + bumper_force(law, touch, xi, 0.0)


@compiled
def wall_of(law, z, xi):
    """Give the side of the rigid stop that the mass is at, 0 for none."""
    if law.k_s > 0.0 or xi != 0.0 or abs(z) != law.x_rM:
        return 0
    return 1 if z > 0.0 else -1


@compiled
def place(law, x_r, v_r):
    """Give z, xi and how the mass is to the stops at a state."""
    if abs(x_r) < law.x_rM:
        return 0.0, x_r, APART
    side = 1 if x_r > 0.0 else -1
    z = side * law.x_rM
    xi = x_r - z
    if law.k_s == 0.0 or xi == 0.0:
        return z, xi, APART
    presses = side * (law.k_s * xi + law.b_s * v_r) > 0.0
    return z, xi, side * (TOUCHING if presses else AWAY)


@compiled
def meet(c, w, waves, xi, v_r, g, r, d, far, until):
    """Give the first time in [0, until] at which xi, moving in direction d, is at d·far.

    Parameters
    ----------
    c, w, waves, v_r, g, r
        As in `slide`; xi stands for x_r. The velocity does not change its sign up to `until`.
    far : float
        Where to, seen in the direction of motion [m].

    Returns
    -------
    float
        Time [s]; infinity when it does not come so far.
    """
    gap = far - d * xi
    if gap <= 0.0:
        return 0.0
    rest = far - d * slide(c, w, waves, xi, v_r, g, r, until)[0]
    if rest > 0.0:
        return NEVER
    low, high = 0.0, until
    s = until * (gap / (gap - rest))
    for _ in range(BISECTIONS):
        x, v, _, _ = slide(c, w, waves, xi, v_r, g, r, s)
        gap = far - d * x
        low, high = (s, high) if gap > 0.0 else (low, s)
        step = gap / (d * v) if d * v > 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s = kept_between(low, high, s + step)
        if not low < s < high:
            return high
    return s


@compiled
def fade_out(c, w, waves, law, xi, v_r, g, r, side, poised, h):
    """Give the first time in [0, h] at which side·(k_s xi + b_s v_r) is no longer above zero.

    With the stop's own side that is where contact is lost, with the other one where it is
    found again.

    Parameters
    ----------
    c, w, waves, v_r, g, r
        As in `slide`; xi stands for x_r.
    law : Stopped
    side : int
        +1 or -1.
    poised : bool
        Whether the value is zero exactly at the start.
    h : float
        Length of the stretch [s].
    """
    if not poised and side * (law.k_s * xi + law.b_s * v_r) <= 0.0:
        return 0.0
    push = Blend(0.0, side * law.k_s, side * law.b_s, 0.0, 0.0)
    stretch = starting(c, w, waves, xi, v_r, g, r)
    return vanish(stretch, waves, law, push, 1 if poised else 0, h)[0]
