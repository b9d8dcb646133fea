"""When a mass on a spring contact turns, and when a contact that yields holds again."""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.stop import NEVER
from drysim.core.sines.blend import Blend
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.vanish import vanish


@compiled
def turning(stretch, waves, way, h):
    """Give the first time in (0, h] at which v_r is zero, or infinity, and x_r then."""
    if way == 0:
        return NEVER, stretch.x_r
    c, w, x_r, v_r, a, j, _, g, r = stretch
    return leave_slip(c, w, waves, x_r, v_r, a, j, g, r, way, h)


@inlined
def turning_before(stretch, waves, law, way, change, v_r):
    """Give what `turning` gives up to a change whose v_r is known."""
    speed = Blend(0.0, 0.0, float(way), 0.0, 0.0)
    turn, x_turn, _ = vanish(stretch, waves, law, speed, 0, change, way * v_r > 0.0)
    return turn, x_turn


@compiled
def end_of_yield(stretch, waves, law, d, way, h):
    """Give when within h [s] the mass turns, and when a yielding contact holds again.

    It does when the mass no longer outruns the limit of its spring, which with a constant
    normal force is when it stops. Result and parameters as in `end_of_hold`, with the direction
    d of yielding.
    """
    x, v = stretch.x_r, stretch.v_r
    if law.variation > 0.0:
        faster = Blend(0.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)
        change, x, v = vanish(stretch, waves, law, faster, 0, h, False)
        if change < NEVER and way != 0:
            turn, x_turn = turning_before(stretch, waves, law, way, change, v)
        else:
            turn, x_turn = turning(stretch, waves, way, h)
        return turn, x_turn, change, 0, x, v
    if way != d:
        return NEVER, x, 0.0, 0, x, v
    turn, x_turn = turning(stretch, waves, way, h)
    return turn, x_turn, turn, 0, x_turn, 0.0
