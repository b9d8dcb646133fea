"""Lanes that wait walk up to the step that they wait for, as many as a register holds."""

from __future__ import annotations

from drysim.core.compiled import compiled, fused
from drysim.core.many.lanes import LANES, STRIDE, WIDTH
from drysim.core.many.queue import AHEAD, DONE, HERE, SUMS, U_1, D, U, V, X
from drysim.core.many.stride import NOTHING, added, grip_of, step
from drysim.core.many.trapezia import summed


@fused
def may_hold(pace, grip, v, v_1, felt, u, u_1):
    """Tell whether a step from one state to another may hold an event."""
    along, along_1 = grip.d * v, grip.d * v_1
    doubt = pace.steep * abs(u_1 - u) + pace.fast * (along + along_1)
    dips = min(along, along_1) <= doubt and grip.d * (felt + u) > 0.0
    stops, breaks = along_1 <= 0.0 or dips, abs(pace.m * u_1 + grip.F_k) > grip.hold
    return stops if grip.slides else breaks


@fused
def one_on(pace, grip, state, u_b, u, u_1, going, z):
    """Give what a step of a lane that is going leads to, and whether it stands before it."""
    x, v, done, bends = state
    x_1, v_1, felt = step(pace, grip, x, v, u, u_1)
    event = may_hold(pace, grip, v, v_1, felt, u, u_1)
    goes, here = going and not event, going and event
    bend = (u_1 - u) - (u - u_b)
    counted = added(z, x, v, felt if grip.slides else u, u, bend)
    z = (
        counted[0] if going else z[0], counted[1] if going else z[1],
        counted[2] if going else z[2], counted[3] if going else z[3],
        counted[4] if going else z[4], counted[5] if going else z[5],
        counted[6] if going else z[6], counted[7] if going else z[7],
        counted[8] if going else z[8],
    )  # fmt: skip
    bends = bends + bend if going else bends
    return (
        (x_1 if goes else x, v_1 if goes else v, done + 1.0 if goes else done, bends),
        here,
        z,
    )


@compiled
def walk(pace, rule, at, length):
    """Let as many lanes as a register holds walk up to an event or to the end of the stride.

    Gives how many stand before an event. `length` is that of the stride in steps.
    """
    return walk_of_eight(pace, rule, at, float(length))


@fused
def walk_of_eight(pace, rule, at, length):
    """Walk; see `walk`."""
    events = 0
    for i in range(WIDTH):
        x, v, d, done = at[X + i], at[V + i], at[D + i], at[DONE + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + (STRIDE + 1) * LANES + i]
        grip, first = grip_of(pace, x, d), done
        state = x, v, done, 0.0
        state, h_1, z = one_on(
            pace, grip, state, u_b, u, u_1, done == 0.0 and length > 0.0, NOTHING
        )
        state, h_2, z = one_on(
            pace, grip, state, u, u_1, u_2, state[2] == 1.0 and length > 1.0, z
        )
        state, h_3, z = one_on(
            pace, grip, state, u_1, u_2, u_3, state[2] == 2.0 and length > 2.0, z
        )
        state, h_4, z = one_on(
            pace, grip, state, u_2, u_3, u_4, state[2] == 3.0 and length > 3.0, z
        )
        here, slides = (h_1 or h_2) or (h_3 or h_4), grip.slides
        reached = state[2] - first + (1.0 if here else 0.0)
        total = summed(
            rule, pace,
            (
                z[0], z[1], z[2], z[3], d * z[4], z[5],
                z[6] if slides else 0.0, z[7], z[8] if slides else 0.0,
            ),
            d * state[3], 0.0 if slides else z[8], 0.0 if slides else reached,
        )  # fmt: skip
        at[X + i], at[V + i], at[DONE + i] = state[0], state[1], state[2]
        at[HERE + i] = 1.0 if here else 0.0
        at[U + i] = u if h_1 else (u_1 if h_2 else (u_2 if h_3 else u_3))
        at[U_1 + i] = u_1 if h_1 else (u_2 if h_2 else (u_3 if h_3 else u_4))
        at[SUMS + i] += total[0]
        at[SUMS + LANES + i] += total[1]
        at[SUMS + 2 * LANES + i] += total[2]
        at[SUMS + 3 * LANES + i] += total[3]
        at[SUMS + 4 * LANES + i] += total[4]
        at[SUMS + 5 * LANES + i] += total[5]
        at[SUMS + 6 * LANES + i] += total[6]
        events += 1 if here else 0
    return events
