"""How far drysim is from the solution in 50 digits, event by event and integral by integral."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from random import Random
from typing import Any

import numpy as np
from drawn import Scene
from taylor import Solution, solve

from drysim.approach.solution import Trajectory

ULP = 2.0**-52

SQUARES = ("x2", "v2", "x_dd2", "u_dd2")
"""Integrals that are compared relative to themselves."""

AGREES = 1e-9
"""Relative distance that counts as none; without ties it is 1e-13 as a rule."""

TOUCH = 1e-7
"""Share of the duration below which a stop is a velocity that touches zero: where it has a
double root, one rounding of it moves the root by the square root of 2^-52 radians."""

SPREAD = 100.0
"""A distance is explained by the input's rounding where one such rounding makes a hundredth."""


def distance(exact: Solution, trajectory: Trajectory, end: float) -> float:
    """Return the greatest relative distance of all numbers, infinite where the modes differ.

    Times are relative to the duration, places to the greatest |x_r|, integrals to themselves.
    """
    events = trajectory.events
    kinds, *numbers = (column.tolist() for column in (events.kind, events.t, events.x_r))
    rows = [(t, kind, x) for kind, t, x in zip(kinds, *numbers, strict=True)]
    changes = lasting(np.sign(kinds[0]), rows[1:], end)
    true = lasting(exact.start, exact.events, end)
    if [mode for _, mode, _ in changes] != [mode for _, mode, _ in true]:
        return np.inf
    last, totals = trajectory.state(end), trajectory.totals(0.0, end)
    scale = greatest_place(exact, numbers[1][0])
    gaps = [abs(last.x_r - float(exact.x_r)) / scale]
    for (t, _, x), (true_t, _, true_x) in zip(changes, true, strict=True):
        gaps += [abs(t - true_t) / end, abs(x - true_x) / scale]
    gaps.append(abs(totals.stuck - float(exact.integrals["stuck"])) / end)
    for name in SQUARES:
        integral = float(exact.integrals[name])
        gaps.append(abs(getattr(totals, name) - integral) / integral if integral else 0.0)
    return float(max(gaps))


def lasting(
    mode: int, events: Iterable[tuple[Any, int, Any]], end: float
) -> list[tuple[float, int, float]]:
    """Return the changes (time, new mode, x_r) between modes that last longer than `TOUCH`.

    Where a velocity touches zero, rounding decides whether the mass stops there for no time.
    """
    modes: list[tuple[float, int, float]] = []
    rows = [(float(t), int(np.sign(kind)), float(x)) for t, kind, x in events]
    starts = [(0.0, int(mode), np.nan), *rows]
    for row, until in zip(starts, [*(t for t, _, _ in rows), end], strict=True):
        if until - row[0] > TOUCH * end and (not modes or modes[-1][1] != row[1]):
            modes.append(row)
    return modes[1:]


def greatest_place(exact: Solution, start: float = 0.0) -> float:
    """Return the greatest |x_r| at events and ends; 1 where it is 0."""
    places = [*(x for _, _, x in exact.events), exact.x_r, start]
    return float(max(map(abs, places))) or 1.0


def unexplained(scene: Scene, trajectory: Trajectory) -> float:
    """Return the distance, or 0 where the rounding of the input explains it.

    It does where drysim has the exact solution of a scene with numbers one unit in the last
    place away, or where such scenes differ among each other by a hundredth of the distance.
    One unit of a velocity is that of its RMS.
    """
    exact = solve(scene)
    least = distance(exact, trajectory, scene.end)
    if least <= AGREES:
        return least
    speed = math.sqrt(float(exact.integrals["v2"]) / (scene.end or 1.0))
    for other in neighbours(scene, speed):
        near = solve(other)
        least = min(least, distance(near, trajectory, scene.end))
        if least <= AGREES or least <= SPREAD * spread(exact, near, scene.end):
            return 0.0
    return least


def neighbours(scene: Scene, speed: float) -> Iterator[Scene]:
    """Return scenes whose numbers are a rounding or two away."""
    # Up to 1e-15 (F_fs + |F_k|) above it counts as equality, which sticks.
    for units in (8, -8, 18):
        F_fs = scene.F_fs + units * math.ulp(scene.F_fs)
        yield scene._replace(F_fs=max(F_fs, scene.F_fk))
    rng = Random(1)

    def nudge(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(nudge, value))
        return value + rng.choice((-2, 0, 2)) * math.ulp(value) if value else 0.0

    for _ in range(4):
        moved = Scene(*map(nudge, scene))
        v_r = moved.v_r + rng.choice((-ULP, ULP)) * speed
        yield moved._replace(F_fs=max(moved.F_fs, moved.F_fk), v_r=v_r)


def spread(one: Solution, other: Solution, end: float) -> float:
    """Return how far two exact solutions are apart, relative; 0 where their modes differ."""
    changes, others = (lasting(each.start, each.events, end) for each in (one, other))
    if [mode for _, mode, _ in changes] != [mode for _, mode, _ in others]:
        return 0.0
    scale = greatest_place(one)
    gaps = [float(abs(one.x_r - other.x_r)) / scale]
    for (t, _, x), (t_2, _, x_2) in zip(changes, others, strict=True):
        gaps += [abs(t - t_2) / end, abs(x - x_2) / scale]
    gaps.append(float(abs(one.integrals["stuck"] - other.integrals["stuck"])) / end)
    for name in SQUARES:
        true, near = one.integrals[name], other.integrals[name]
        gaps.append(float(abs(near - true) / true) if true else 0.0)
    return max(gaps)
