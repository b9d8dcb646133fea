"""The periodic orbit that a start leads to: a fixed point of the period map or its powers."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.events import first_mode
from drysim.core.plant import Law
from drysim.core.sines.period_map import one_period, rate_of, refine
from drysim.core.sines.reached import AWAY, ROOM, SLOW, decays, patience, reached
from drysim.core.waves import OMEGA, PHASE, STRIDE, A

MOST_MULTIPLE, USUAL = 64, 8
"""Longest repetition looked for, in periods of the excitation; and up to which in each period,
as hardly any orbit takes longer."""

SELDOM = 16
"""Periods from one look for the longer ones to the next."""

CLOSED = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings."""

NOISE = 1e-10
"""A change below this that has long found no smaller one is rounding of a stiff scene."""

PATIENCE = 20
"""Periods without a new smallest change: swings of the change itself are shorter."""

NEAR = 1e-2
"""Scaled change below which Newton's method may take over."""

BETTER = 0.5
"""Share of the change before to which each of Newton's steps must bring it."""

WAIT = 10
"""Periods of the motion itself after Newton's method has failed first; then twice as many."""


@compiled
def find(plant, law, waves, period, x_r, v_r, most, past_x, past_v, log, capacity):
    """Give the periodic orbit that a start leads to.

    Parameters
    ----------
    As in `settle`, from rest on; without dry friction the steady motion itself is the start.

    Returns
    -------
    x_r, v_r, multiple, closure, periods, peak
        As in `settle`.
    unique : bool
        Whether neighbours are drawn to the orbit; false for one of a continuum.
    """
    if law.F_fs == 0.0 and plant.k_x > 0.0 and plant.b > 0.0:
        x_r, v_r = steady_start(plant, waves)
    d = first_direction(plant, law, waves, x_r, v_r)
    x_r, v_r, d, multiple, closure, periods, peak = settle(
        plant, law, waves, period, x_r, v_r, d, patience(plant, period, most), past_x, past_v,
        log, capacity,
    )  # fmt: skip
    unique = True
    length = multiple * period
    if multiple > 0 and decays(plant, length) < SLOW:
        unique, left = reached(plant, law, waves, length, x_r, v_r, d, log, capacity)
        if left > AWAY:
            multiple = 0
    return x_r, v_r, multiple, closure, periods, peak, unique


@compiled
def first_direction(plant, law, waves, x_r, v_r):
    """Give the direction of sliding at t = 0, 0 for stuck."""
    u_dd = 0.0
    for i in range(waves.base):
        at = STRIDE * i
        u_dd += waves.values[at + A] * math.sin(waves.values[at + PHASE])
    load = 1.0 + law.variation * math.sin(law.phase)
    limits = Law(law.F_fk * load, law.F_fs * load, law.variation, law.omega, law.phase)
    return first_mode(plant, limits, x_r, v_r, u_dd)


@compiled
def steady_start(plant, waves):
    """Give the steady x_r and v_r at t = 0 of the oscillator without dry friction."""
    x_r, v_r = 0.0, 0.0
    for i in range(waves.base):
        at = STRIDE * i
        omega, phase = waves.values[at + OMEGA], waves.values[at + PHASE]
        stiff = complex(plant.k_x - plant.m * omega * omega, plant.b * omega)
        turn = complex(math.cos(phase), math.sin(phase))
        swing = -plant.m * waves.values[at + A] * turn / stiff
        x_r += swing.imag
        v_r += omega * swing.real
    return x_r, v_r


@compiled
def longer(past_x, past_v, n, x_r, v_r, rate, limit):
    """Return the shortest repetition beyond the usual over which a state changes little enough.

    Parameters
    ----------
    past_x, past_v, n
        The states at the beginning of the latest periods, and the number of the last.
    x_r, v_r : float
        The state at its end [m, m/s].
    rate : float
        As in `rate_of` [1/s].
    limit : float
        Largest change that is little enough [m].

    Returns
    -------
    multiple : int
        In periods, 0 for none.
    change : float
        Of the state over it [m].
    """
    for multiple in range(USUAL + 1, min(n + 1, MOST_MULTIPLE) + 1):
        i = (n + 1 - multiple) % MOST_MULTIPLE
        change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate)
        if change <= limit:
            return multiple, change
    return 0, math.inf


@compiled
def settle(plant, law, waves, period, x_r, v_r, d, most, past_x, past_v, log, capacity):
    """Follow a start to the periodic orbit it leads to.

    Parameters
    ----------
    plant, law, waves
    period : float
        Of the excitation [s].
    x_r, v_r, d
        State at t = 0.
    most : int
        Periods after which the scene counts as not settled.
    past_x, past_v : array, shape (MOST_MULTIPLE,)
        Scratch.
    log : Log
        Scratch.
    capacity : int
        Length of the log.

    Returns
    -------
    x_r, v_r, d
        At the beginning of the repetition.
    multiple : int
        Excitation periods in the repetition; 0 when not settled, -1 when events follow each
        other without end.
    closure : float
        Largest scaled change over the repetition [-].
    periods : int
        Periods followed.
    peak : float
        Largest |x_r| on the way [m].
    """
    rate = rate_of(plant, period)
    highest = abs(x_r)
    events_before = -1
    step_before = math.inf
    smallest = math.inf
    smallest_at = 0
    wait, pause = 0, WAIT
    refined = False
    plain_x, plain_v, plain_d = x_r, v_r, d
    closure = math.inf
    for n in range(most):
        past_x[n % MOST_MULTIPLE] = x_r
        past_v[n % MOST_MULTIPLE] = v_r
        d_before, x_before, v_before = d, x_r, v_r
        image = one_period(plant, law, waves, period, x_r, v_r, d, log, capacity)
        x_r, v_r, d, events, peak = image
        if events < 0:
            return x_r, v_r, d, -1, closure, n + 1, highest
        step = max(abs(x_r - x_before), abs(v_r - v_before) / rate)
        alike = events == events_before and d == d_before and events + ROOM <= capacity
        if refined and not (alike and step < BETTER * step_before):
            # Newton leads astray: the motion goes on from where it was.
            x_r, v_r, d = plain_x, plain_v, plain_d
            for i in range(MOST_MULTIPLE):
                past_x[i] = math.inf
            refined, wait, pause = False, pause, 2 * pause
            continue
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
        for multiple in range(1, min(n + 1, USUAL) + 1):
            i = (n + 1 - multiple) % MOST_MULTIPLE
            change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate) / scale
            closure = change if multiple == 1 else min(closure, change)
            if multiple == 1 and change < smallest:
                smallest, smallest_at = change, n
            still = change <= NOISE and change <= 10.0 * smallest and n - smallest_at > PATIENCE
            apart = multiple == 1 or step > NOISE * scale
            if apart and (change <= CLOSED or still):
                return x_r, v_r, d, multiple, change, n + 1, highest
        if (n + 1) % SELDOM == 0 and step > NOISE * scale:
            limit = NOISE if n - smallest_at > PATIENCE else CLOSED
            multiple, change = longer(past_x, past_v, n, x_r, v_r, rate, limit * scale)
            if multiple > 0:
                return x_r, v_r, d, multiple, change / scale, n + 1, highest
        wait -= 1
        if wait <= 0 and step < NEAR * scale and alike:
            # Where a mass may come to rest depends on its way there, if F_fs exceeds F_fk: a
            # step that leads to no orbit must leave no trace then.
            if not refined or law.F_fs <= law.F_fk:
                plain_x, plain_v, plain_d = x_r, v_r, d
            refined, x_r, v_r = refine(
                plant, law, waves, period, rate, x_before, v_before, d, image, log
            )
            if not refined:
                wait = WAIT
        step_before = step
        events_before = events
    return x_r, v_r, d, 0, closure, most, highest
