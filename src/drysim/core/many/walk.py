"""Lanes that wait walk up to the step that they wait for, as many as a register holds."""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.many.lanes import LANES, WIDTH
from drysim.core.many.queue import AHEAD, HERE, LEFT, RISE, SUMS, U_1, WENT, D, U, V, X
from drysim.core.many.stride import grip_of, plus, step
from drysim.core.many.trapezia import summed


@inlined
def one_on(pace, grip, x, v, u, rise, along, u_1, going, z):
    """Give what a step of those that are going leads to, and whether they go on or stand."""
    x_1, v_1, change, along_1, event, terms = step(pace, grip, x, v, u, rise, along, u_1)
    goes, here = going and not event, going and event
    counted = (
        terms[0] if going else 0.0, terms[1] if going else 0.0, terms[2] if going else 0.0,
        terms[3] if going else 0.0, terms[4] if going else 0.0, terms[5] if going else 0.0,
        terms[6] if going else 0.0, terms[7] if going else 0.0, terms[8] if going else 0.0,
    )  # fmt: skip
    return (
        x_1 if goes else x, v_1 if goes else v, u_1 if goes else u, change if goes else rise,
        along_1 if goes else along, goes, here, plus(z, counted),
    )  # fmt: skip


@compiled
def walk(pace, rule, at):
    """Let as many lanes as a register holds walk up to an event or to the last sample."""
    for i in range(WIDTH):
        x, v, d = at[X + i], at[V + i], at[D + i]
        u, rise, left = at[U + i], at[RISE + i], at[LEFT + i]
        u_1, u_2 = at[AHEAD + i], at[AHEAD + LANES + i]
        u_3, u_4 = at[AHEAD + 2 * LANES + i], at[AHEAD + 3 * LANES + i]
        grip, z = grip_of(pace, x, d), (0.0,) * 9
        first, along = rise, d * v
        x, v, u, rise, along, g_1, h_1, z = one_on(
            pace, grip, x, v, u, rise, along, u_1, left > 0.0, z
        )
        x, v, u, rise, along, g_2, h_2, z = one_on(
            pace, grip, x, v, u, rise, along, u_2, g_1 and left > 1.0, z
        )
        x, v, u, rise, along, g_3, h_3, z = one_on(
            pace, grip, x, v, u, rise, along, u_3, g_2 and left > 2.0, z
        )
        x, v, u, rise, along, g_4, h_4, z = one_on(
            pace, grip, x, v, u, rise, along, u_4, g_3 and left > 3.0, z
        )
        here = (h_1 or h_2) or (h_3 or h_4)
        went = (1.0 if g_1 else 0.0) + (1.0 if g_2 else 0.0)
        went += (1.0 if g_3 else 0.0) + (1.0 if g_4 else 0.0)
        next_u = u_1 if h_1 else (u_2 if h_2 else (u_3 if h_3 else u_4))
        next_u = next_u if here else u
        reached = went + (1.0 if here else 0.0)
        slides = d != 0.0
        # The change before the last sample reached ends its sum.
        total = summed(
            rule, pace,
            (
                z[0], z[1], z[2], z[3], z[4], z[5],
                z[6] if slides else 0.0, z[7], z[8] if slides else 0.0,
            ),
            d * ((next_u - u if here else rise) - first),
            0.0 if slides else z[8], 0.0 if slides else reached,
        )  # fmt: skip
        at[X + i], at[V + i], at[U + i], at[RISE + i] = x, v, u, rise
        at[HERE + i], at[U_1 + i], at[WENT + i] = 1.0 if here else 0.0, next_u, went
        at[SUMS + i], at[SUMS + LANES + i] = total[0], total[1]
        at[SUMS + 2 * LANES + i], at[SUMS + 3 * LANES + i] = total[2], total[3]
        at[SUMS + 4 * LANES + i], at[SUMS + 5 * LANES + i] = total[4], total[5]
        at[SUMS + 6 * LANES + i] = total[6]
