"""How far drysim is from the solution in 50 digits, event by event and integral by integral."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random
from typing import Any

import numpy as np
from drawn import Scene
from taylor import Solution, solve

from drysim.approach.solution import Trajectory

ULP = 2.0**-52

AGREES = 1e-9
"""Relative distance that counts as none; without ties it is 1e-13 as a rule."""

SPREAD = 100.0
"""A distance is explained by the input's rounding where one such rounding makes a hundredth."""


def distance(exact: Solution, trajectory: Trajectory, end: float) -> float:
    """Return the greatest relative distance of all numbers, infinite where the events differ.

    Times are relative to the duration, places to the greatest |x_r|, integrals to themselves.
    """
    turning_points = trajectory.events
    if [kind for _, kind, _ in exact.events] != turning_points.kind[1:].tolist():
        return np.inf
    last, totals = trajectory.state(end), trajectory.totals(0.0, end)
    x = np.array([float(x) for _, _, x in exact.events] + [float(exact.x_r)])
    t = np.array([float(t) for t, _, _ in exact.events])
    scale = float(max(np.abs(x).max(), abs(turning_points.x_r[0]))) or 1.0
    gaps = [abs(last.x_r - x[-1]) / scale, *np.abs(turning_points.t[1:] - t) / end]
    gaps += (np.abs(turning_points.x_r[1:] - x[:-1]) / scale).tolist()
    gaps.append(abs(totals.stuck - float(exact.integrals["stuck"])) / end)
    for name in ("x2", "v2", "x_dd2", "u_dd2"):
        true = float(exact.integrals[name])
        gaps.append(abs(getattr(totals, name) - true) / true if true else 0.0)
    return float(max(gaps))


def unexplained(scene: Scene, trajectory: Trajectory) -> float:
    """Return the distance, or 0 where the rounding of the input explains it.

    It does where drysim has the exact solution of a scene with numbers one unit in the last
    place away, or where such scenes differ among each other by a hundredth of the distance.
    """
    exact = solve(scene)
    least = distance(exact, trajectory, scene.end)
    if least <= AGREES:
        return least
    for other in neighbours(scene):
        near = solve(other)
        least = min(least, distance(near, trajectory, scene.end))
        if least <= AGREES or least <= SPREAD * spread(exact, near, scene.end):
            return 0.0
    return least


def neighbours(scene: Scene) -> Iterator[Scene]:
    """Return scenes whose numbers are a rounding or two away."""
    # Up to 1e-15 (F_fs + |F_k|) above it counts as equality, which sticks.
    for factor in (1.0 + 4.0 * ULP, 1.0 - 4.0 * ULP, 1.0 + 9.0 * ULP):
        yield scene._replace(F_fs=max(factor * scene.F_fs, scene.F_fk))
    rng = Random(1)

    def nudge(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(nudge, value))
        return value * (1.0 + rng.choice((-ULP, 0.0, ULP)))

    for _ in range(4):
        moved = Scene(*map(nudge, scene))
        yield moved._replace(F_fs=max(moved.F_fs, moved.F_fk))


def spread(one: Solution, other: Solution, end: float) -> float:
    """Return how far two exact solutions are apart, relative; 0 where their events differ."""
    if [kind for _, kind, _ in one.events] != [kind for _, kind, _ in other.events]:
        return 0.0
    scale = float(max(abs(x) for _, _, x in [*one.events, (0, 0, one.x_r)])) or 1.0
    gaps = [float(abs(one.x_r - other.x_r)) / scale]
    for (t, _, x), (t_2, _, x_2) in zip(one.events, other.events, strict=True):
        gaps += [float(abs(t - t_2)) / end, float(abs(x - x_2)) / scale]
    for name, true in one.integrals.items():
        gaps.append(float(abs(other.integrals[name] - true) / true) if true else 0.0)
    return max(gaps)
