"""heyoka: compiled Taylor series of high order, with events located on the series."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import tau
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.bench.scipy_ivp import INITIAL_SLIP_VELOCITY, SlipState, integrate_stick_slip
from drysim.bench.work import Entry, Run, Work
from drysim.core.model import Samples, Sines
from drysim.errors import SolverError
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.core.model import Floats


PACKAGE = "heyoka"

TOLERANCES = (1e-6, 1e-15)
"""Relative tolerances; the second is close to double precision and heyoka's default."""

START_TOLERANCE = 1e-12
"""A stop within this time of the beginning is the beginning itself [s]."""

COOLDOWN = 1e-7
"""Time for which a root is not detected again [s]. heyoka's own estimate, from the slope of
v_r, is far too long where slip begins without acceleration."""

CHUNK_SAMPLES = 400
"""Maximum number of samples per call under sines; a call also ends at a stop."""


def entries(work: Work) -> Iterator[Entry]:
    """Yield heyoka at several tolerances."""
    for tolerance in TOLERANCES[isinstance(work.motion, Samples) :]:
        yield Entry("heyoka events", format_number(tolerance), with_events(tolerance))


def make_integrators(work: Work, tolerance: float) -> dict[int, Any]:
    """Return an integrator for each direction of slip, which ends where v_r reaches zero."""
    import heyoka as hy

    m, k_x, b = work.plant
    x_r, v_r = hy.make_vars("x_r", "v_r")
    if isinstance(work.motion, Sines):
        waves = zip(*work.motion, strict=True)
        u_dd = sum(A * hy.sin(tau * f * hy.time + phase) for A, f, phase in waves)
    else:
        u_dd = hy.par[0] + hy.par[1] * hy.time
    made = {}
    for d, way in ((1, hy.event_direction.negative), (-1, hy.event_direction.positive)):
        v_d = -u_dd - (k_x * x_r + b * v_r + d * work.law.F_fk) / m
        made[d] = hy.taylor_adaptive(
            [(x_r, v_r), (v_r, v_d)], [0.0, 0.0], tol=tolerance,
            t_events=[hy.t_event(v_r, direction=way, cooldown=COOLDOWN)],
        )  # fmt: skip
    return made


def with_events(tolerance: float) -> Callable[[Work], Run]:
    """Return the preparation of an entry that restarts at every stop, and for a record at every
    sample."""

    def ready(work: Work) -> Run:
        slip = TaylorSolver(work, tolerance)
        return lambda: integrate_stick_slip(work, slip)

    return ready


class TaylorSolver:
    """heyoka as `SlipIntegrator` on the grid of a work."""

    def __init__(self, work: Work, tolerance: float) -> None:
        import heyoka as hy

        self.integrators, self.limit = (
            make_integrators(work, tolerance),
            hy.taylor_outcome.time_limit,
        )
        self.grid = work.grid
        self.u_dd, self.step = work.u_dd.tolist(), work.step
        self.sampled = isinstance(work.motion, Samples)
        self.advance = self._over_sample if self.sampled else self._over_grid

    def __call__(
        self, begin: SlipState, d: int, x_out: Floats, v_out: Floats
    ) -> tuple[SlipState, bool]:
        """Integrate a slip phase in direction d; see `scipy_ivp.SlipIntegrator`."""
        way = self.integrators[d]
        way.time = begin.t
        way.state[:] = begin.x_r, begin.v_r or d * INITIAL_SLIP_VELOCITY
        way.reset_cooldowns()
        stopped = self.advance(way, begin, x_out, v_out)
        if stopped and way.time - begin.t < START_TOLERANCE:
            # Slip begins at v_r = 0, which is detected as a root; continue past it.
            begin = begin._replace(t=way.time)
            stopped = self.advance(way, begin, x_out, v_out)
        x_r, v_r = way.state.tolist()
        if not np.isfinite(x_r):
            raise SolverError(f"heyoka returned non-finite values at t = {begin.t:.6g} s")
        if stopped:
            n = int(np.searchsorted(self.grid, way.time, side="right")) - 1
            return SlipState(way.time, x_r, 0.0, n), True
        n = min(begin.n + (1 if self.sampled else CHUNK_SAMPLES), len(self.grid) - 1)
        return SlipState(way.time, x_r, v_r, n), False

    def _over_grid(self, way: Any, begin: SlipState, x_out: Floats, v_out: Floats) -> bool:
        """Integrate to the stop or over a chunk of the grid; return whether it stopped."""
        ahead = self.grid[begin.n + 1 : begin.n + 1 + CHUNK_SAMPLES]
        outcome, *_, found = way.propagate_grid(np.concatenate(([begin.t], ahead)))
        part = slice(begin.n + 1, begin.n + len(found))
        x_out[part], v_out[part] = found[1:, 0], found[1:, 1]
        return bool(outcome != self.limit)

    def _over_sample(self, way: Any, begin: SlipState, x_out: Floats, v_out: Floats) -> bool:
        """Integrate to the stop or the next sample with ü linear; return whether it stopped."""
        n = begin.n
        slope = (self.u_dd[n + 1] - self.u_dd[n]) / self.step
        way.pars[0], way.pars[1] = self.u_dd[n] - slope * self.grid[n], slope
        outcome = way.propagate_until(self.grid[n + 1])[0]
        if outcome == self.limit:
            x_out[n + 1], v_out[n + 1] = way.state
        return bool(outcome != self.limit)
