"""Functions shared by the fixed-step approaches: input on the grid, response, trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from drysim.approach.scene import count_grid_points, make_waves
from drysim.approach.solution import (
    FIXED_STEP,
    Events,
    Floats,
    Int8Array,
    Numerics,
    Path,
    Points,
    Response,
    StoredGrid,
)
from drysim.core.compile import as_engine_array, engine
from drysim.core.forcing import mean_squares
from drysim.core.model import (
    AnyLaw,
    AnyState,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
    Totals,
    base_acceleration,
    interpolate_displacement,
)
from drysim.errors import SolverError

MAX_STATE = 1e100
"""Largest displacement [m] or velocity [m/s]; beyond it squares in the energies would
overflow."""


def input_on_grid(
    motion: Sines | Samples, step: float, duration: float | None
) -> tuple[Floats, Floats, float]:
    """Return ü at the grid points and at their midpoints [m/s²], and the step [s]."""
    if isinstance(motion, Samples):
        last = len(motion.u_dd) if duration is None else count_grid_points(duration, motion.dt)
        u_dd = motion.u_dd[:last]
        return u_dd, 0.5 * (u_dd[:-1] + u_dd[1:]), motion.dt
    assert duration is not None, "sines need a duration"
    n = np.arange(count_grid_points(duration, step), dtype=float)
    at, between = (base_acceleration(motion, k * step) for k in (n, n[:-1] + 0.5))
    return at, between, step


def refine_motion(motion: Sines | Samples, substeps: int) -> Sines | Samples:
    """Return the same base motion with each step divided into `substeps`."""
    if isinstance(motion, Sines):
        return motion
    n, at = len(motion.u_dd), np.arange((len(motion.u_dd) - 1) * substeps + 1) / substeps
    u_dd = np.interp(at, np.arange(n), motion.u_dd[:])
    if motion.u is None:
        return Samples(u_dd, motion.dt / substeps)
    i = np.minimum(at.astype(int), n - 2)
    u = interpolate_displacement(motion, i, at - i)
    return Samples(u_dd, motion.dt / substeps, u)


def decimate_response(response: Response, motion: Sines | Samples, substeps: int) -> Response:
    """Return every `substeps`-th point of a response; its trajectory keeps all points."""
    every = slice(None, None, substeps)
    grid = StoredGrid(
        response.dt * substeps, response.u_dd[every], response.all_points.select(every)
    )
    return replace(response, motion=motion, grid=grid)


def state_buffers(start: AnyState, n: int) -> tuple[Floats, Floats]:
    """Return arrays for x_r and v_r at n points, with the start state in the first."""
    x_r, v_r = np.zeros(n), np.zeros(n)
    x_r[0], v_r[0] = start[:2]
    return as_engine_array(x_r), as_engine_array(v_r)


def solve_with_stick(
    kernel: Callable[..., None],
    limits: tuple[float, ...],
    scene: tuple[Plant, AnyLaw, Sines | Samples],
    start: AnyState,
    grid: tuple[Floats, float],
    name_and_reason: tuple[str, str],
) -> Response:
    """Return the response of a fixed-step method in which the mass may stick.

    Parameters
    ----------
    kernel : callable
        Marches the motion and writes x_r, v_r, F_f and the direction of sliding.
    limits : tuple of float
        Friction parameters of the kernel.
    scene : tuple
        Plant, law and base motion.
    start : State
    grid, name_and_reason
        As in `make_response`.
    """
    u_dd, dt = grid
    n = len(u_dd)
    x_r, v_r = state_buffers(start, n)
    force, d = as_engine_array(np.zeros(n)), as_engine_array(np.zeros(n, dtype=np.int8))
    kernel(scene[0], *limits, as_engine_array(u_dd), dt, x_r, v_r, force, d)
    x_r, v_r, force = map(np.asarray, (x_r, v_r, force))
    return make_response(
        *scene, grid, (x_r, v_r, force, np.asarray(d, dtype=np.int8)), name_and_reason
    )


def make_response(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    grid: tuple[Floats, float],
    state: tuple[Floats, Floats, Floats, Int8Array],
    name_and_reason: tuple[str, str],
) -> Response:
    """Return the response of a fixed-step approach.

    Parameters
    ----------
    plant, law, motion
        The scene.
    grid : tuple
        ü at the grid points [m/s²], shape (n,), and the step [s].
    state : tuple of ndarray, shape (n,)
        x_r [m], v_r [m/s], F_f [N] and direction of sliding.
    name_and_reason : tuple of str
        Name of the approach, and a sentence on its method.

    Raises
    ------
    SolverError
        If the motion diverges beyond `MAX_STATE` or is not finite.
    """
    u_dd, dt = grid
    x_r, v_r, force, d = state
    if not all(-MAX_STATE < series.min() <= series.max() < MAX_STATE for series in (x_r, v_r)):
        within = (np.abs(x_r) < MAX_STATE) & (np.abs(v_r) < MAX_STATE)
        at = int(np.flatnonzero(~within)[0])
        raise SolverError(
            f"{name_and_reason[0]} with a step of {dt:.6g} s diverges at t = {at * dt:.6g} s",
            "use a smaller solver.step, or an exact approach",
        )
    events = mode_changes(plant, u_dd, dt, x_r, d)
    counts = len(x_r) - 1, len(events)
    x_dd = -(plant.k_x * x_r + plant.b * v_r + force) / plant.m
    trajectory = FixedStepTrajectory(plant, law, motion, dt, u_dd, x_r, v_r, x_dd, force, d)
    points = StoredGrid(dt, u_dd, Points(x_r, v_r, d, force))
    return Response(
        plant,
        law,
        motion,
        points,
        events,
        partial(
            Numerics, name_and_reason[0], FIXED_STEP, name_and_reason[1], engine(), *counts
        ),
        trajectory,
    )


def mode_changes(plant: Plant, u_dd: Floats, dt: float, x_r: Floats, d: Int8Array) -> Events:
    """Return the grid points at which the mode changes as events."""
    n = np.concatenate(([0], np.flatnonzero(d[1:] != d[:-1]) + 1))
    kind = d[n].astype(np.int8)
    # A direct change between +1 and -1 is a reversal, coded ±2.
    reverses = (d[n[1:]] != 0) & (d[n[1:] - 1] != 0)
    kind[1:][reverses] *= 2
    return Events(n * dt, kind, x_r[n], plant.m * u_dd[n] + plant.k_x * x_r[n])


@dataclass(frozen=True, eq=False)
class FixedStepTrajectory:
    """Solution known at grid points only: linear between them, sums in place of integrals."""

    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    dt: float
    u_dd: Floats
    x_r: Floats
    v_r: Floats
    x_dd: Floats
    force: Floats
    d: Int8Array
    closest_decision: float = math.inf

    @property
    def end(self) -> float:
        """Final time [s]."""
        return (len(self.x_r) - 1) * self.dt

    def path(self, window: tuple[float, float], limits: StrokeLimits | None) -> Path:
        """Return the start and the local extremes of x_r on the grid."""
        # An extreme is a change of the direction from one step to the next.
        rising = np.sign(np.diff(self.x_r))
        n = np.concatenate(([0], np.flatnonzero(rising[1:] != rising[:-1]) + 1))
        return Path(n * self.dt, self.x_r[n])

    def state(self, t: float) -> State:
        """Return the state at time t [s], interpolated linearly."""
        n = min(int(t / self.dt), len(self.x_r) - 2)
        q = t / self.dt - n
        x_r = (1.0 - q) * self.x_r[n] + q * self.x_r[n + 1]
        return State(float(x_r), float((1.0 - q) * self.v_r[n] + q * self.v_r[n + 1]))

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s] as sums over its grid points."""
        part = self._window_slice(begin, end)
        x_r, v_r, x_dd, u_dd = self.x_r[part], self.v_r[part], self.x_dd[part], self.u_dd[part]
        share = self.force[part] / self.law.F_fk if self.law.F_fk else np.zeros(len(x_r))
        stuck = np.count_nonzero(self.d[part] == 0)
        sums = x_r @ x_r, v_r @ v_r, x_dd @ x_dd, u_dd @ v_r, share @ v_r, stuck, u_dd @ u_dd
        span = (end - begin) / max(len(x_r), 1)
        x2, v2, x_dd2, power, sliding_distance, still, u_dd2 = (
            float(total) * span for total in sums
        )
        return Totals(x2, v2, x_dd2, power, sliding_distance, still, u_dd2, self._u2(part))

    def chatter(self, begin: float, end: float) -> float:
        """Return the share of a window with two sign changes of v_r in four steps [-]."""
        sign = np.sign(self.v_r[self._window_slice(begin, end)])
        # Cumulative number of sign changes; its difference counts those within four steps.
        flips = np.cumsum(np.concatenate(([0], sign[1:] * sign[:-1] < 0.0)))
        return float(np.mean(flips[4:] - flips[:-4] >= 2)) if len(flips) > 4 else 0.0

    def _window_slice(self, begin: float, end: float) -> slice:
        return slice(round(begin / self.dt), round(end / self.dt))

    def _u2(self, part: slice) -> float | None:
        """Return the integral of u² over a slice of the grid [m²s]; None where u is unknown."""
        if isinstance(self.motion, Sines):
            begin: float = part.start * self.dt
            end: float = part.stop * self.dt
            u2: float = mean_squares(make_waves(self.motion), begin, end)[1]
            return u2 * (end - begin)
        if self.motion.u is None:
            return None
        u: Floats = self.motion.u[part]
        return float(np.dot(u, u)) * self.dt
