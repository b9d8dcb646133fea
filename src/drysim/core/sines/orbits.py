"""The periodic orbits of many scenes under sines: one call finds and measures a block."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.integrals import integrate_leaps
from drysim.core.means import mean_squares
from drysim.core.sines.leap import leap
from drysim.core.sines.orbit import find, first_direction
from drysim.core.sines.scene import REST, V_R, X_R, plant_and_law
from drysim.core.turns import excursions, passages, state_at
from drysim.core.waves import Waves, set_wave

PERIOD, X_RM, SINES = range(REST, REST + 3)
"""Columns of a scene behind those of `drysim.core.sines.scene`: period of the excitation [s],
stroke limit (infinite for none); from SINES on amplitude [m/s²], frequency [Hz] and phase [rad]
of each sine."""

(
    STATUS, TIME, MULTIPLE, CLOSURE, RUN_UP, RUN_UP_PEAK, X_BEGIN, V_BEGIN, X_END, V_END,
    X2, V2, X_DD2, POWER, RUB, STUCK, U_DD2, U2, PEAK, UPCROSSINGS, ENTRIES,
    TIMES, T_FIRST, T_BEYOND, FOUND,
) = range(25)  # fmt: skip
"""Columns of an answer: status; the time that a failure is told with [s]; periods, closure [-]
and run-up [s, m] as in `settle`; the states at both ends of one repetition; its integrals as in
`Totals`; greatest |x_r| [m], upcrossings of zero and entries beyond the limit; excursions as in
`excursions`. FOUND is their number."""

SETTLED, NOT_SETTLED, NOT_UNIQUE, STORM, OVERFLOW, CROWDED = range(6)
"""What became of a scene; the last three have no orbit: events without end, a motion beyond the
numbers, and more events in a repetition than the log holds."""


@compiled
def solve_orbits(scenes, answers, values, past_x, past_v, most, log, capacity):
    """Find and measure the orbit of every scene.

    Parameters
    ----------
    scenes : array, shape (n, SINES + 3 sines)
        The columns named above.
    answers : array, shape (n, FOUND)
        Written.
    values : array, shape (STRIDE (sines + 1),)
        Scratch, as are `past_x`, `past_v` and the log, which has `capacity` places.
    most : int
        Periods after which a scene counts as not settled.
    """
    for i in range(len(scenes)):
        scene, answer = scenes[i], answers[i]
        plant, law = plant_and_law(scene)
        waves = waves_in(scene, values, law)
        x_r, v_r, multiple, closure, periods, peak, unique = find(
            plant, law, waves, scene[PERIOD], scene[X_R], scene[V_R], most, past_x, past_v,
            log, capacity,
        )  # fmt: skip
        answer[MULTIPLE], answer[CLOSURE] = max(multiple, 1), closure
        answer[RUN_UP], answer[RUN_UP_PEAK] = periods * scene[PERIOD], peak
        answer[TIME] = answer[RUN_UP]
        if multiple < 0:
            answer[STATUS] = STORM
        elif not (math.isfinite(x_r) and math.isfinite(v_r)):
            answer[STATUS] = OVERFLOW
        elif multiple == 0:
            answer[STATUS] = NOT_SETTLED
        elif not unique:
            answer[STATUS] = NOT_UNIQUE
        else:
            length = answer[MULTIPLE] * scene[PERIOD]
            answer[STATUS] = SETTLED
            measure(plant, law, waves, x_r, v_r, length, scene[X_RM], log, capacity, answer)


@compiled
def waves_in(scene, values, law):
    """Give the waves of a scene, written into a table that has room for them."""
    base = (len(scene) - SINES) // 3
    for k in range(base):
        at = SINES + 3 * k
        set_wave(values, k, scene[at], scene[at + 1], scene[at + 2])
    if law.variation == 0.0:
        return Waves(values, base, base)
    set_wave(values, base, 0.0, law.omega / (2.0 * math.pi), law.phase)
    return Waves(values, base + 1, base)


@compiled
def measure(plant, law, waves, x_r, v_r, length, x_rM, log, capacity, answer):
    """Follow one repetition of an orbit from its beginning, and write what it comes to."""
    d = first_direction(plant, law, waves, x_r, v_r)
    log.s[0], log.kind[0], log.x_r[0] = 0.0, d, x_r
    reached, x, v, _, count, _ = leap(
        plant, law, waves, 0.0, 0.0, 0, 0.0, length, 0.0, x_r, v_r, d, log, 1, capacity
    )
    answer[TIME] = reached
    if count < 0 or reached < length or not (math.isfinite(x) and math.isfinite(v)):
        answer[STATUS] = STORM if count < 0 else (CROWDED if reached < length else OVERFLOW)
        return
    t, kind, turns = log.s[:count], log.kind[:count], log.x_r[:count]
    scene = (plant, law, waves, t, kind, turns, v_r)
    answer[X_BEGIN], answer[V_BEGIN] = state_at(*scene, 0.0)
    answer[X_END], answer[V_END] = state_at(*scene, length)
    (
        answer[X2], answer[V2], answer[X_DD2], answer[POWER], answer[RUB], answer[STUCK],
    ) = integrate_leaps(*scene, 0.0, length)  # fmt: skip
    u_dd2, u2 = mean_squares(waves, 0.0, length)
    answer[U_DD2], answer[U2] = u_dd2 * length, u2 * length
    answer[PEAK], answer[UPCROSSINGS], answer[ENTRIES] = passages(
        t, turns, answer[X_BEGIN], answer[X_END], length, x_rM
    )
    answer[TIMES], answer[T_FIRST], answer[T_BEYOND] = 0.0, -1.0, 0.0
    if answer[PEAK] >= x_rM:
        answer[TIMES], answer[T_FIRST], answer[T_BEYOND] = excursions(
            *scene, answer[X_END], length, x_rM, True
        )
