"""Functions shared by the fixed-step approaches: input on the grid, response, trajectory."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drysim.approach.base_motion import base_square_integrals, count_grid_points, make_waves
from drysim.approach.solution import (
    FIXED_STEP,
    Events,
    Numerics,
    Path,
    Response,
    Trajectory,
    stored_grid,
)
from drysim.core.compile import as_engine_array, engine
from drysim.core.fixed_step import BaseOnGrid, MotionOnGrid
from drysim.core.model import (
    AnyLaw,
    AnyState,
    Floats,
    Plant,
    Points,
    Samples,
    Sines,
    Totals,
    base_acceleration,
    interpolate_displacement,
    limit_force,
)
from drysim.errors import SolverError

MAX_STATE = 1e100
"""Largest displacement [m] or velocity [m/s]; beyond it squares in the energies would
overflow."""


def base_on_grid(motion: Sines | Samples, step: float, duration: float | None) -> BaseOnGrid:
    """Return ü on the grid, which samples have of their own, as kernels take it."""
    if isinstance(motion, Samples):
        last = len(motion.u_dd) if duration is None else count_grid_points(duration, motion.dt)
        u_dd, step = motion.u_dd[:last], motion.dt
        between = 0.5 * (u_dd[:-1] + u_dd[1:])
    else:
        assert duration is not None, "sines need a duration"
        n = np.arange(count_grid_points(duration, step), dtype=float)
        u_dd, between = (base_acceleration(motion, k * step) for k in (n, n[:-1] + 0.5))
    return BaseOnGrid(as_engine_array(u_dd), as_engine_array(between), step)


def empty_motion_on_grid(start: AnyState, n: int) -> MotionOnGrid:
    """Return the buffers of a motion at n grid points, with the start in the first."""
    x_r, v_r, F_f = np.zeros(n), np.zeros(n), np.zeros(n)
    x_r[0], v_r[0] = start[:2]
    return MotionOnGrid(*map(as_engine_array, (x_r, v_r, F_f, np.zeros(n, dtype=np.int8))))


def refine_motion(motion: Sines | Samples, substeps: int) -> Sines | Samples:
    """Return the same base motion with each step divided into `substeps`."""
    if isinstance(motion, Sines):
        return motion
    n, position = len(motion.u_dd), np.arange((len(motion.u_dd) - 1) * substeps + 1) / substeps
    u_dd = np.interp(position, np.arange(n), motion.u_dd[:])
    if motion.u is None:
        return Samples(u_dd, motion.dt / substeps)
    i = np.minimum(position.astype(int), n - 2)
    u = interpolate_displacement(motion, i, position - i)
    return Samples(u_dd, motion.dt / substeps, u)


def decimate_response(response: Response, motion: Sines | Samples, substeps: int) -> Response:
    """Return every `substeps`-th point of a response; its trajectory keeps all points."""
    every = slice(None, None, substeps)
    grid = stored_grid(
        response.dt * substeps, response.u_dd[every], response.all_points.select(every)
    )
    return replace(response, motion=motion, grid=grid)


def make_response(
    scene: tuple[Plant, AnyLaw, Sines | Samples],
    base: BaseOnGrid,
    out: MotionOnGrid,
    name: str,
    why: str,
) -> Response:
    """Return the response of a fixed-step approach: its name, and a sentence on its method.

    Raises
    ------
    SolverError
        If the motion diverges beyond `MAX_STATE` or is not finite.
    """
    plant, law, motion = scene
    u_dd, dt = np.asarray(base.u_dd), base.dt
    x_r, v_r, force = map(np.asarray, out[:3])
    if not all(-MAX_STATE < series.min() <= series.max() < MAX_STATE for series in (x_r, v_r)):
        within = (np.abs(x_r) < MAX_STATE) & (np.abs(v_r) < MAX_STATE)
        index = int(np.flatnonzero(~within)[0])
        raise SolverError(
            f"{name} with a step of {dt:.6g} s diverges at t = {index * dt:.6g} s",
            "use a smaller solver.step, or an exact approach",
        )
    x_dd = -(plant.k_x * x_r + plant.b * v_r + force) / plant.m
    points = Points(x_r, v_r, np.asarray(out.d, dtype=np.int8), x_dd, force)
    events = mode_changes(plant, u_dd, dt, points)
    numerics = Numerics(name, FIXED_STEP, why, engine(), len(x_r) - 1, len(events))
    trajectory = FixedStepTrajectory(
        plant=plant,
        law=law,
        motion=motion,
        events=events,
        end=(len(u_dd) - 1) * dt,
        dt=dt,
        u_dd=u_dd,
        points=points,
    )
    grid = stored_grid(dt, u_dd, points)
    return Response(plant, law, motion, grid, events, numerics, trajectory)


def mode_changes(plant: Plant, u_dd: Floats, dt: float, points: Points) -> Events:
    """Return the grid points at which the mode changes as events."""
    d, x_r = points.d, points.x_r
    n = np.concatenate(([0], np.flatnonzero(d[1:] != d[:-1]) + 1))
    kind = d[n].astype(np.int8)
    # A direct change between +1 and -1 is a reversal, coded ±2.
    reverses = (d[n[1:]] != 0) & (d[n[1:] - 1] != 0)
    kind[1:][reverses] *= 2
    return Events(n * dt, kind, x_r[n], limit_force(plant, x_r[n], u_dd[n]))


@dataclass(frozen=True, eq=False, kw_only=True)
class FixedStepTrajectory(Trajectory):
    """Solution known at grid points only: linear between them, sums in place of integrals."""

    dt: float
    u_dd: Floats
    points: Points

    @property
    def path(self) -> Path:
        """The start and the local extremes of x_r on the grid."""
        # An extreme is a change of the direction from one step to the next.
        rising = np.sign(np.diff(self.points.x_r))
        n = np.concatenate(([0], np.flatnonzero(rising[1:] != rising[:-1]) + 1))
        return Path(n * self.dt, self.points.x_r[n])

    def at(self, t: Floats) -> Points:
        """Return the motion at ascending times [s], interpolated linearly."""
        n = np.minimum((t / self.dt).astype(np.int64), len(self.u_dd) - 2)
        q, (before, after) = t / self.dt - n, map(self.points.select, (n, n + 1))
        columns = ((1.0 - q) * a + q * b for a, b in zip(before[:5], after[:5], strict=True))
        x_r, v_r, _, x_dd, F_f = columns
        return Points(x_r, v_r, before.d, x_dd, F_f)

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s] as sums over its grid points."""
        part = self._window_slice(begin, end)
        x_r, v_r, d, x_dd, force, *_ = self.points.select(part)
        u_dd = self.u_dd[part]
        share = (
            force / self.law.F_fk if self.law.F_fk and force is not None else np.zeros(len(x_r))
        )
        stuck = np.count_nonzero(d == 0)
        sums = x_r @ x_r, v_r @ v_r, x_dd @ x_dd, u_dd @ v_r, share @ v_r, stuck, u_dd @ u_dd
        span = (end - begin) / max(len(x_r), 1)
        x2, v2, x_dd2, power, sliding_distance, still, u_dd2 = (
            float(total) * span for total in sums
        )
        totals = Totals(x2, v2, x_dd2, power, sliding_distance, still, u_dd2, self._u2(part))
        # Both ends of the window count.
        peak = float(np.abs(self.points.x_dd[part.start : part.stop + 1]).max(initial=0.0))
        return totals._replace(x_dd_peak=peak)

    def chatter(self, begin: float, end: float) -> float:
        """Return the share of a window with two sign changes of v_r in four steps [-]."""
        sign = np.sign(self.points.v_r[self._window_slice(begin, end)])
        # Cumulative number of sign changes; its difference counts those within four steps.
        flips = np.cumsum(np.concatenate(([0], sign[1:] * sign[:-1] < 0.0)))
        return float(np.mean(flips[4:] - flips[:-4] >= 2)) if len(flips) > 4 else 0.0

    def _window_slice(self, begin: float, end: float) -> slice:
        return slice(round(begin / self.dt), round(end / self.dt))

    def _u2(self, part: slice) -> float | None:
        """Return the integral of u² over a slice of the grid [m²s]; None where u is unknown."""
        if isinstance(self.motion, Sines):
            window = part.start * self.dt, part.stop * self.dt
            return base_square_integrals(self.motion, make_waves(self.motion), *window)[1]
        if self.motion.u is None:
            return None
        u: Floats = self.motion.u[part]
        return float(np.dot(u, u)) * self.dt
