"""When a spring contact that yields holds again."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import onset
from drysim.core.sines.blend import Blend
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.vanish import vanish


@compiled
def end_of_yield(stretch, waves, law, d, h):
    """Give when within h [s] a contact that yields in direction d holds again, and how.

    It does when the mass no longer outruns the limit of its spring, which with a constant
    normal force is when it stops. Parameters and result as in `leave_hold`.
    """
    c, w, x_r, v_r, a, j, _, g, r = stretch
    if law.variation > 0.0:
        faster = Blend(0.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)
        return vanish(stretch, waves, law, faster, 0, h)
    if onset(stretch.v_r, stretch.a, stretch.j) != d:
        return 0.0, x_r, v_r
    stop, x = leave_slip(c, w, waves, x_r, v_r, a, j, g, r, d, h)
    return stop, x, 0.0
