"""scipy.integrate.solve_ivp: the yardstick that people know, with events and smoothed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf, sqrt, tanh, tau
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from drysim.core.motion import Samples
from drysim.errors import SolverError
from drysim.study.bench.entry import Entry, Run
from drysim.study.bench.peers.machine import SLIPPING, Slip, follow
from drysim.study.bench.peers.smoothed import lacks, smoothed, swing
from drysim.study.bench.work import Answer, Work
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.approach.events import Floats

PACKAGE = "scipy"

Method = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]

EVENTS: tuple[tuple[Method, float], ...] = (
    ("RK45", 1e-3),
    ("RK45", 1e-6),
    ("DOP853", 1e-9),
    ("DOP853", 1e-12),
)
"""Methods and relative tolerances with located events; the first is what scipy takes alone."""

REFERENCE: tuple[Method, float] = ("DOP853", 1e-13)
"""The tightest that double precision allows with some room: what `stick-slip` is held to."""

CHECK: tuple[Method, float, int] = ("DOP853", 1e-12, 3)
"""Method, tolerance and how many times shorter steps: the second run of the reference. What
both runs differ by tells the error of the reference itself."""

SMOOTHED: tuple[tuple[Method, float, float], ...] = (
    ("RK45", 1e-3, 1e3), ("LSODA", 1e-6, 1e4), ("Radau", 1e-6, 1e4), ("BDF", 1e-6, 1e5)
)  # fmt: skip
"""Methods, relative tolerances and sharpnesses [s/m] on the smoothed law."""

CHUNK = 200
"""Samples that one call may slide over: a stop is looked for in no more than that."""


def entries(work: Work) -> Iterator[Entry]:
    """Give scipy at several tolerances, with events and on the smoothed law."""
    # Under samples every sample is a restart, which makes all tolerances alike.
    for method, tolerance in EVENTS[:: 3 if isinstance(work.motion, Samples) else 1]:
        words = f"{method}, {number(tolerance)}"
        yield Entry("solve_ivp events", words, with_events(method, tolerance))
    for method, tolerance, c in SMOOTHED:
        words = f"{method}, {number(tolerance)}, tanh c {number(c)}"
        ready = on_smoothed_law(method, tolerance, c)
        yield Entry("solve_ivp tanh", words, ready, lacks=lacks(work))


def reference() -> Entry:
    """Give the entry that the exact approach is held to."""
    method, tolerance = REFERENCE
    words = f"{method}, {number(tolerance)}"
    return Entry("solve_ivp events", words, with_events(method, tolerance))


def checked(work: Work) -> Answer:
    """Return the answer of the reference with another tolerance and shorter steps."""
    method, tolerance, shorter = CHECK
    return with_events(method, tolerance, shorter)(work)()


def with_events(method: Method, tolerance: float, shorter: int = 1) -> Callable[[Work], Run]:
    """Return an entry that restarts at every stop, and under samples at every sample.

    Its steps may be made so many times shorter than `longest_step`.
    """

    def ready(work: Work) -> Run:
        slide = Restarted(work, method, tolerance, longest_step(work) / shorter)
        return lambda: follow(work, slide)

    return ready


class Restarted:
    """How solve_ivp slides: to the stop, to the next sample, or over a chunk of a grid."""

    def __init__(self, work: Work, method: Method, tolerance: float, longest: float) -> None:
        self.work, self.sampled = work, isinstance(work.motion, Samples)
        self.settings: dict[str, Any] = {
            "method": method, "rtol": tolerance, "atol": tolerance * swing(work),
            "max_step": longest,
        }  # fmt: skip
        self.grid = work.grid

    def __call__(self, begin: Slip, d: int, x_out: Floats, v_out: Floats) -> tuple[Slip, bool]:
        """Slide in direction d; see `machine.Slide`."""
        last = min(begin.n + (1 if self.sampled else CHUNK), self.work.samples)
        found = self._solved(begin, d, last)
        if not found.success:
            raise SolverError(f"solve_ivp at t = {begin.t:.6g} s: {found.message}")
        stopped = found.status == 1
        if self.sampled:
            n = begin.n + (not stopped)
            if not stopped:
                x_out[n], v_out[n] = found.y[:, -1]
        else:
            n = begin.n + len(found.t)
            if n > begin.n:  # scipy gives lists in place of arrays where a stop comes first
                x_out[begin.n + 1 : n + 1], v_out[begin.n + 1 : n + 1] = found.y
        if stopped:
            t, (x_r, _) = float(found.t_events[0][0]), found.y_events[0][0].tolist()
            return Slip(t, x_r, 0.0, n), True
        return Slip(self.grid[last], float(x_out[last]), float(v_out[last]), last), False

    def _solved(self, begin: Slip, d: int, last: int) -> Any:
        """Return what solve_ivp finds from an instant to a point of the grid, or to the stop.

        solve_ivp finds an event by its sign at the ends of a step, so it overlooks a v_r that
        vanishes twice within one. In between lies a minimum of d·v_r, which is an event as
        well: where d·v_r is below zero there, the mass has stopped before.
        """
        from scipy.integrate import solve_ivp

        m, k_x, b = self.work.plant
        f, u_dd = d * self.work.law.F_fk / m, base_of(self.work, begin.n)

        def rates(t: float, y: Floats) -> tuple[float, float]:
            x_r, v_r = y.tolist()
            return v_r, -u_dd(t) - (k_x * x_r + b * v_r) / m - f

        def stop(t: float, y: Floats) -> float:
            return float(y[1])

        def minimum(t: float, y: Floats) -> float:
            return rates(t, y)[1]

        def solved(end: float) -> Any:
            ahead = self.grid[begin.n + 1 : last + 1]
            return solve_ivp(
                rates, (begin.t, end), np.array([begin.x_r, begin.v_r or d * SLIPPING]),
                events=(stop, minimum), t_eval=None if self.sampled else ahead[ahead <= end],
                **self.settings,
            )  # fmt: skip

        stop.terminal, stop.direction = True, -d  # type: ignore[attr-defined]
        minimum.direction = d  # type: ignore[attr-defined]
        found = solved(self.grid[last])
        for t, y in zip(found.t_events[1], found.y_events[1], strict=True):
            if d * y[1] < 0.0:
                until = solved(float(t))
                return until if until.status == 1 else found
        return found


def longest_step(work: Work) -> float:
    """Return a step [s] within which v_r has one extremum at most: a quarter of a period.

    Between samples dv_r/dt swings at the damped natural frequency, under sines at theirs, too.
    """
    m, k_x, _ = work.plant
    fastest = max([sqrt(k_x / m), *(omega for _, omega, _ in work.waves)])
    return 0.25 * tau / fastest if fastest else inf


def base_of(work: Work, n: int) -> Callable[[float], float]:
    """Give the base acceleration near sample n: of samples the straight line from there."""
    if not isinstance(work.motion, Samples):
        return work.base
    u_0, t_0 = float(work.u_dd[n]), n * work.step
    slope = (float(work.u_dd[n + 1]) - u_0) / work.step
    return lambda t: u_0 + slope * (t - t_0)


def on_smoothed_law(method: Method, tolerance: float, c: float) -> Callable[[Work], Run]:
    """Give an entry on tanh(c v) in place of the sign, in one call."""

    def ready(work: Work) -> Run:
        from scipy.integrate import solve_ivp

        m, k_x, b = work.plant
        F_fk, base, grid = work.law.F_fk, work.base, work.grid

        def rates(t: float, y: Floats) -> tuple[float, float]:
            x_r, v_r = y.tolist()
            F_f = F_fk * tanh(c * v_r)
            return v_r, -base(t) - (k_x * x_r + b * v_r + F_f) / m

        def run() -> Answer:
            found = solve_ivp(
                rates, (0.0, work.end), list(work.start), method, grid, rtol=tolerance,
                atol=tolerance * swing(work), max_step=10 * work.step,
            )  # fmt: skip
            if not found.success:
                raise SolverError(f"solve_ivp: {found.message}")
            return smoothed(work, found.y[0], found.y[1], c)

        return run

    return ready
