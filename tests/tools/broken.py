"""Motions of any law broken on purpose: what a certificate must not let pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from drysim.approach.coulomb import CODES, CoulombMarch
from drysim.approach.piecewise import PiecewiseTrajectory
from drysim.approach.solution import Events
from drysim.approach.taylor import TaylorTrajectory
from drysim.core.compile import as_engine_array
from drysim.core.modes import ARRIVAL, FREE, decode_mode, encode_mode
from drysim.core.taylor import ORDER

Break = Callable[[Any, int, np.random.Generator], None]


def break_motion(trajectory: Any, way: str, rng: np.random.Generator) -> Any:
    """Return a copy of a motion that is broken in a way, `BREAKS`, at a random place."""
    if isinstance(trajectory, PiecewiseTrajectory):
        if isinstance(trajectory.march, CoulombMarch):
            return break_samples(trajectory, way, rng)
        block = trajectory.march.block(0)
        rows = break_segments(block.rows, trajectory.dt, way, rng, turned_mode)
        samples = block.samples
        if way == DOUBLED and samples is not None:
            shift = rows.x_r[-1] - block.rows.x_r[-1]
            moved = np.flatnonzero(rows.x_r != block.rows.x_r).min(initial=len(rows.n))
            x_r = np.array(samples.x_r)
            x_r[int(rows.n[min(moved, len(rows.n) - 1)]) + 1 :] += shift
            samples = samples._replace(x_r=x_r)
        return with_segments(trajectory, rows, samples)
    assert isinstance(trajectory, TaylorTrajectory)
    return break_series(trajectory, way, rng)


DELETED, MOVED, TURNED, DOUBLED = "deleted", "moved", "turned", "doubled"
BREAKS = (DELETED, MOVED, TURNED, DOUBLED)
"""An event is missed, or found at a wrong time; a direction is swapped; a step counts twice."""


def between(before: float, now: float, after: float, rng: np.random.Generator) -> float:
    """Return another time for an event, some way towards one of its neighbours."""
    to = before if rng.random() < 0.5 else after
    return float(now + rng.uniform(0.3, 0.9) * (to - now))


def break_samples(trajectory: PiecewiseTrajectory, way: str, rng: np.random.Generator) -> Any:
    """Break a motion stored at its samples, with the events between them.

    After a missed event the motion goes on in its direction to the next sample that is known.
    """
    march = trajectory.march
    block = march.block(0)
    log = type(block.log)(*(np.array(column) for column in block.log))
    x_r, v_r, d = (np.array(column) for column in block.solution.samples)
    i = int(rng.integers(1, len(log.n)))
    first = int(log.n[i]) + 1
    last = int(log.n[i + 1]) + 1 if i + 1 < len(log.n) else len(d)
    if way == DELETED:
        log = type(log)(*(np.delete(column, i) for column in log))
        d[first:last] = d[first - 1]
    elif way == MOVED:
        dt = march.motion.dt
        after = (last - 1) * dt
        t = between(log.n[i - 1] * dt + log.s[i - 1], log.n[i] * dt + log.s[i], after, rng)
        log.n[i] = min(int(t / dt), len(d) - 2)
        log.s[i] = t - log.n[i] * dt
        d[min(first, log.n[i]) : max(first, log.n[i])] = np.sign(
            log.kind[i] if log.n[i] < first else log.kind[i - 1]
        )
    elif way == TURNED:
        log.kind[i] = -log.kind[i] if log.kind[i] else 1
        d[first:last] = np.sign(log.kind[i])
    else:
        n = int(rng.integers(1, len(d) - 2))
        x_r[n:-1], v_r[n:-1], d[n:-1] = x_r[n + 1 :], v_r[n + 1 :], d[n + 1 :]
    samples, modes = type(block.samples)(x_r, v_r, d), CODES[np.sign(log.kind)]
    v_first = np.where(np.arange(len(log.n)) == 0, block.rows.v_r[0], 0.0)
    rows = type(block.rows)(log.n, log.s, log.x_r, v_first, 0.0 * v_first, modes)
    broken = replace(block, samples=samples, log=log, rows=rows)
    kind = np.asarray(log.kind, np.int8)
    t = log.n * march.motion.dt + log.s
    points = Events(t, kind, log.x_r, log.F_L)
    return replace(trajectory, march=replace(march, cached={0: broken}), events=points)


def with_segments(
    trajectory: PiecewiseTrajectory, segments: Any, samples: Any = None
) -> PiecewiseTrajectory:
    """Return a motion of one block that has other segments, and the state at other samples."""
    block = replace(trajectory.march.block(0), samples=samples, rows=segments)
    march = replace(trajectory.march, cached={0: block})
    turns, impacts = block.turning_points(trajectory.dt), block.hits(trajectory.dt)
    return replace(trajectory, march=march, turns=turns, impacts=impacts)


def break_segments(
    segments: Any, dt: float, way: str, rng: np.random.Generator, turned: Callable[[int], int]
) -> Any:
    """Break a motion stored as segments: where one begins, with what, and in which mode.

    A change of mode is missed with its segment, or, where more segments follow in the same
    mode, as after samples, in all of them.
    """
    columns = type(segments)(*(np.array(column) for column in segments))
    d = columns.d
    changes = 1 + np.flatnonzero(d[1:] != d[:-1])
    if not len(changes):
        return columns
    at = int(rng.integers(len(changes)))
    i, end = int(changes[at]), int(changes[at + 1]) if at + 1 < len(changes) else len(d)
    # An impact is a record of the arrival and the segment after it.
    first = i - (d[i - 1] == ARRIVAL)
    last = i + 1 + (d[i] == ARRIVAL)
    single = end - i == 1 or d[i - 1] == ARRIVAL
    if way == DELETED and single:
        return type(segments)(*(np.delete(column, slice(first, last)) for column in columns))
    if way == DELETED:
        d[i:end] = d[i - 1]
    elif way == MOVED and single:
        same = columns.n == columns.n[i]
        before = columns.s[i - 1] if same[i - 1] else 0.0
        after = columns.s[i + 1] if i + 1 < len(same) and same[i + 1] else dt
        columns.s[i] = between(before, columns.s[i], after, rng)
    elif way == MOVED:
        d[i : int(rng.integers(i + 1, end))] = d[i - 1]
    elif way == TURNED:
        d[i:end] = turned(int(d[i]))
    else:
        columns[2][i:] += columns[2][i] - columns[2][i - 1]
    return columns


def turned_mode(code: int) -> int:
    """Return a mode with its direction swapped, or at rest, set in motion."""
    if code == ARRIVAL:
        return code
    mode = decode_mode(code)
    d = -mode.direction or 1
    contact = -mode.contact if abs(mode.contact) == 1 else mode.contact
    if mode.direction == 0 and contact != FREE:
        contact = d
    return int(encode_mode(mode._replace(direction=d, contact=contact)))


def break_series(trajectory: TaylorTrajectory, way: str, rng: np.random.Generator) -> Any:
    """Break a motion by Taylor series in one of its blocks."""
    march = trajectory.march
    number = int(rng.integers(len(march.checkpoints) - 1))
    block = march.block(number)
    segments = block.solution.segments
    # At rest the degree of the series is not set.
    degrees = np.where(np.asarray(segments.d) == 0, ORDER, segments.terms)
    segments = break_segments(
        segments._replace(terms=degrees), march.scene.dt, way, rng, lambda code: -code or 1
    )
    begins = segments.n * march.scene.dt + segments.s
    # In plain Python numpy's numbers warn of an overflow to infinity; the kernels count on it.
    segments = type(segments)(*map(as_engine_array, segments))
    broken = block._replace(solution=block.solution._replace(segments=segments), begins=begins)
    return replace(trajectory, march=replace(march, cached=march.cached | {number: broken}))
