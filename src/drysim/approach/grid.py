"""Response of an exact solution on a grid: that of its samples, or any under sines."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from drysim.approach.base_motion import base_acceleration_on_grid, count_grid_points
from drysim.approach.solution import Events, ExactTrajectory, Grid, Numerics, Response
from drysim.approach.solvers import solver_of
from drysim.core.compile import engine
from drysim.core.events import CONTACT, SLIP
from drysim.core.model import Floats, Points, Samples, Sines, has_friction

NOT_REACHED = "the end stops are never reached"


def grid_times(dt: float, first: int, last: int) -> Floats:
    """Return the times [s] of the grid points `first` to `last` - 1."""
    return np.arange(first, last, dtype=np.float64) * dt


def points_of_trajectory(trajectory: Any, dt: float, first: int, last: int) -> Points:
    """Return grid points `first` to `last` - 1 of a trajectory that is known at any time."""
    points: Points = trajectory.at(grid_times(dt, first, last))
    rest = np.flatnonzero(points.d == 0)
    if len(rest):
        points.x_dd[rest] = base_acceleration_on_grid(trajectory.motion, dt, first, last)[rest]
    return points if trajectory.law.stops is not None else points._replace(F_stop=None)


def response_on_grid(trajectory: ExactTrajectory, step: float) -> Response:
    """Return the response of a solution on a grid; samples have their own step."""
    law, motion = trajectory.law, trajectory.motion
    if isinstance(motion, Sines) and law.stops is not None and not trajectory.reaches_stops:
        response = response_on_grid(trajectory.without_stops, step)
        numerics = replace(response.numerics, why=f"{response.numerics.why}; {NOT_REACHED}")
        return replace(response, law=law, numerics=numerics, trajectory=trajectory)
    dt = motion.dt if isinstance(motion, Samples) else step
    length = count_grid_points(trajectory.end, dt)
    if isinstance(motion, Samples):
        length = min(length, len(motion.u_dd))
    solver, closest = solver_of(law, motion), trajectory.closest_decision
    approach, why, evaluate = "stick-slip", solver.why, partial(trajectory.points, dt)
    if not has_friction(law):
        approach = "viscous"
        if law.stops is None:
            why, closest = "closed form in each step, no dry friction", math.inf
            evaluate = partial(sliding_points, trajectory, dt)
    grid = Grid(dt, length, partial(base_acceleration_on_grid, motion, dt), evaluate)
    events = events_of_scene(trajectory)
    numerics = Numerics(
        approach, solver.core, why, engine(), length - 1, len(events),
        closest if closest < 1.0 else None, error=trajectory.error(grid),
    )  # fmt: skip
    return Response(trajectory.plant, law, motion, grid, events, numerics, trajectory)


def events_of_scene(trajectory: ExactTrajectory) -> Events:
    """Return the events of a motion; without friction turning points are none."""
    events, law = trajectory.events, trajectory.law
    if has_friction(law):
        return events
    if law.stops is None:
        return Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    # Rest at a stop is one.
    kind, at_stop = np.abs(events.kind), law.stops.limits.side(events.x_r) != 0
    return events.select((kind >= CONTACT) | (at_stop & (kind <= SLIP)))


def sliding_points(trajectory: ExactTrajectory, dt: float, first: int, last: int) -> Points:
    """Return grid points `first` to `last` - 1, none of them stuck."""
    points = trajectory.points(dt, first, last)
    return points._replace(d=np.ones_like(points.d))
