"""heyoka: Taylor series of high order, compiled, with events located on the series itself."""

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
    from drysim.approach.solution import Floats


PACKAGE = "heyoka"

TOLERANCES = (1e-6, 1e-15)
"""The second is about the least that double precision knows, and heyoka's own choice."""

START_TOLERANCE = 1e-12
"""A stop within this time [s] of the beginning is the beginning."""

COOLDOWN = 1e-7
"""Time [s] for which a root that was found is not found again; heyoka's own guess, by the slope
of v_r there, is far too long where slip begins without acceleration."""

CHUNK_SAMPLES = 400
"""Samples that one call may slide over under sines: it ends at the stop in any case."""


def entries(work: Work) -> Iterator[Entry]:
    """Give heyoka at several tolerances."""
    for tolerance in TOLERANCES[isinstance(work.motion, Samples) :]:
        yield Entry("heyoka events", format_number(tolerance), with_events(tolerance))


def make_integrators(work: Work, tolerance: float) -> dict[int, Any]:
    """Give an integrator for each direction of sliding, which ends where v_r comes to zero."""
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
    """Give an entry that restarts at every stop, and under samples at every sample."""

    def ready(work: Work) -> Run:
        slip = TaylorSolver(work, tolerance)
        return lambda: integrate_stick_slip(work, slip)

    return ready


class TaylorSolver:
    """How heyoka slides: its integrators, and the grid on which the motion is wanted."""

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
        """Slide in direction d; see `scipy_ivp.Slide`."""
        way = self.integrators[d]
        way.time = begin.t
        way.state[:] = begin.x_r, begin.v_r or d * INITIAL_SLIP_VELOCITY
        way.reset_cooldowns()
        stopped = self.advance(way, begin, x_out, v_out)
        if stopped and way.time - begin.t < START_TOLERANCE:
            # Slip begins at v_r = 0, which is a root, too; it is passed over now.
            begin = begin._replace(t=way.time)
            stopped = self.advance(way, begin, x_out, v_out)
        x_r, v_r = way.state.tolist()
        if not np.isfinite(x_r):
            raise SolverError(f"heyoka has left the numbers at t = {begin.t:.6g} s")
        if stopped:
            n = int(np.searchsorted(self.grid, way.time, side="right")) - 1
            return SlipState(way.time, x_r, 0.0, n), True
        n = min(begin.n + (1 if self.sampled else CHUNK_SAMPLES), len(self.grid) - 1)
        return SlipState(way.time, x_r, v_r, n), False

    def _over_grid(self, way: Any, begin: SlipState, x_out: Floats, v_out: Floats) -> bool:
        """Slide to the stop, or over a chunk of the grid; tell whether it was the stop."""
        ahead = self.grid[begin.n + 1 : begin.n + 1 + CHUNK_SAMPLES]
        outcome, *_, found = way.propagate_grid(np.concatenate(([begin.t], ahead)))
        part = slice(begin.n + 1, begin.n + len(found))
        x_out[part], v_out[part] = found[1:, 0], found[1:, 1]
        return bool(outcome != self.limit)

    def _over_sample(self, way: Any, begin: SlipState, x_out: Floats, v_out: Floats) -> bool:
        """The same over samples: ü is a straight line to the next one."""
        n = begin.n
        slope = (self.u_dd[n + 1] - self.u_dd[n]) / self.step
        way.pars[0], way.pars[1] = self.u_dd[n] - slope * self.grid[n], slope
        outcome = way.propagate_until(self.grid[n + 1])[0]
        if outcome == self.limit:
            x_out[n + 1], v_out[n + 1] = way.state
        return bool(outcome != self.limit)
