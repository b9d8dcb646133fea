"""Spring contacts of constant limit over samples, solved on the grid of the samples."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from drysim.approach.events import of_log
from drysim.approach.jointed import Jointed
from drysim.approach.points import Held, Points
from drysim.approach.response import Response
from drysim.approach.room import empty, empty_log, larger, put_first
from drysim.approach.scene import PER_CALL, grid_points, numerics, refuse_storm
from drysim.approach.spans import last_needed, run_length
from drysim.core.compiled import held
from drysim.core.contacts.contact import first_contact
from drysim.core.contacts.joint import march_joint
from drysim.core.events import ROOM
from drysim.core.motion import Samples
from drysim.core.plant import Plant, Slider
from drysim.core.state import AnyState
from drysim.core.trail import Pieces

FEW_EVENTS = 0.1
"""Events a sample that there is room for at first."""


def follow(
    plant: Plant, law: Slider, motion: Samples, start: AnyState, duration: float | None
) -> Jointed:
    """Solve a scene from t = 0 to `duration` [s], or to the end of the samples."""
    end = run_length(motion, duration)
    _, last = last_needed(motion, end)
    u_dd = motion.u_dd[: last + 1]
    x_r, v_r = held(np.empty((2, last + 1)))
    d = held(np.empty(last + 1, dtype=np.int8))
    x_0 = start[2] if len(start) > 2 else start.x_r
    mode, x_0 = first_contact(law, start.x_r, start.v_r, x_0)
    x_r[0], v_r[0], d[0] = start.x_r, start.v_r, mode
    room = int(FEW_EVENTS * last) + 4 * ROOM
    trail, log = empty(Pieces, room), empty_log(room)
    put_first(trail, (0, 0.0, start.x_r, start.v_r, x_0, mode))
    F_L = plant.m * float(u_dd[0]) + plant.k_x * start.x_r
    put_first(log, (0, 0.0, mode, start.x_r, F_L))
    given, n, used, count = held(u_dd), 0, 1, 1
    state: tuple[Any, ...] = (start.x_r, start.v_r, x_0, mode)
    while n < last:
        if max(used, count) > len(trail.n) - ROOM:
            trail, log = (larger(kept, 2 * len(kept[0])) for kept in (trail, log))
        until, written = min(n + PER_CALL, last), (x_r, v_r, d, trail, used, log, count)
        rest: tuple[Any, ...] = (n, until, *state, *written)
        n, *moved, used, count = march_joint(plant, law, given, motion.dt, *rest)
        state = tuple(moved)
        refuse_storm(count, n * motion.dt, state)
    trail = Pieces(*(np.asarray(column[:used]) for column in trail))
    events = of_log(log, count, motion.dt).until(end)
    series = np.asarray(x_r), np.asarray(v_r), np.asarray(d, dtype=np.int8)
    return Jointed(plant, law, motion, u_dd, *series, trail, events, end)


def solve(
    plant: Plant,
    law: Slider,
    motion: Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene under samples, on their own grid, whatever the step."""
    track = follow(plant, law, motion, start, duration)
    n = grid_points(track.end, motion.dt)
    x_r, v_r, d = track.x_r[:n], track.v_r[:n], track.d[:n]
    F_f = law.k_t * (x_r - track.x_0[:n])
    np.multiply(d, law.F_fk, out=F_f, where=d != 0)
    heading = np.where(v_r < 0.0, np.int8(-1), np.int8(1))
    how = partial(numerics, law, motion, n, track.events, math.inf)
    grid = Held(motion.dt, track.u_dd[:n], Points(x_r, v_r, heading, F_f))
    return Response(plant, law, motion, grid, track.events, how, track)
