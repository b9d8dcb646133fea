"""scipy's `solve_ivp` as a benchmark peer: restarted at events, and with smoothed friction.

With located events and tight tolerances it is also the reference for the exact approach. The
state machine around an integrator is here as well and serves all peers: it integrates a slip
phase up to the next stop, and advances a stick phase without an integrator, from the condition
|F_L| <= F_fs alone. It uses no code of drysim's core, so that both are independent. The
smoothed law replaces sign(v_r) by tanh(c v_r), Eq. (8) of the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf, sqrt, tanh, tau
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np

from drysim.bench.work import Answer, Entry, Run, Work
from drysim.core.model import AnyLaw, DynamicLaw, Samples
from drysim.errors import SolverError
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.core.model import Floats


# The state machine around an integrator.

LOOKAHEAD = 512
"""Samples tested at a time for break-away."""

BREAK_AWAY_TOLERANCE = 1e-15
"""Relative tolerance of the break-away time [-]."""

INITIAL_SLIP_VELOCITY = 1e-300
"""Initial velocity of a slip phase [m/s]: nonzero, so that its beginning is not an event."""

MAX_EVENTS_PER_SAMPLE = 100
"""Events between two samples above which a peer has failed to progress."""


class SlipState(NamedTuple):
    """Time [s], x_r [m], v_r [m/s], and the index of the last completed sample."""

    t: float
    x_r: float
    v_r: float
    n: int


class SlipIntegrator(Protocol):
    """Integrator of a slip phase."""

    def __call__(
        self, begin: SlipState, d: int, x_out: Floats, v_out: Floats
    ) -> tuple[SlipState, bool]:
        """Integrate a slip phase in direction d up to a stop or a point of the grid.

        Parameters
        ----------
        begin : SlipState
        d : int
            Direction of slip, 1 or -1.
        x_out, v_out : ndarray, shape (samples + 1,)
            x_r [m] and v_r [m/s] on the grid; the passed samples are written.

        Returns
        -------
        SlipState
            State at the end.
        bool
            Whether the mass has stopped.
        """


def integrate_stick_slip(work: Work, slip: SlipIntegrator) -> Answer:
    """Integrate the motion as an alternation of slip and stick phases.

    Parameters
    ----------
    work : Work
    slip : SlipIntegrator
        Integrates one slip phase.

    Raises
    ------
    SolverError
        If events accumulate between two samples.
    """
    x_out, v_out = np.zeros(work.samples + 1), np.zeros(work.samples + 1)
    d_out = np.zeros(work.samples + 1)
    state = SlipState(0.0, *work.start, 0)
    x_out[0], v_out[0] = work.start
    d = slip_direction(work, state) if state.v_r == 0.0 else int(np.sign(state.v_r))
    d_out[0], event_count, stops = d, 0, 0
    while state.n < work.samples:
        n = state.n
        if d == 0:
            state = advance_stick(work, state, x_out)
            d = -int(np.sign(limit_force(work, state)))
        else:
            state, stopped = slip(state, d, x_out, v_out)
            d_out[n + 1 : state.n + 1] = d
            stops += stopped
            d = slip_direction(work, state) if stopped else d
        event_count = event_count + 1 if state.n == n else 0
        if event_count > MAX_EVENTS_PER_SAMPLE:
            raise SolverError(f"events accumulate at t = {state.t:.6g} s")
    return Answer(x_out, v_out, lambda: friction_force(work, x_out, d_out), stops=stops)


def limit_force(work: Work, state: SlipState) -> float:
    """Return the force that holds the mass in stick [N], Eq. (9)."""
    return work.plant.m * work.base(state.t) + work.plant.k_x * state.x_r


def slip_direction(work: Work, state: SlipState) -> int:
    """Return the direction of slip of a mass at rest, 0 if it sticks."""
    F_L = limit_force(work, state)
    return 0 if abs(F_L) <= work.law.F_fs else -int(np.sign(F_L))


def advance_stick(work: Work, state: SlipState, x_out: Floats) -> SlipState:
    """Advance a stick phase to its break-away, or to the end.

    x_r is constant in stick, so the limit force is monotone between the extrema of ü: testing
    it there cannot miss a break-away.
    """
    m, F_k = work.plant.m, work.plant.k_x * state.x_r
    t, u_dd = work.extrema
    end, t_break_away = work.samples, work.end
    extremum = int(np.searchsorted(t, state.t, side="right"))
    while extremum < len(t):
        exceeds = np.abs(m * u_dd[extremum : extremum + LOOKAHEAD] + F_k) > work.law.F_fs
        if exceeds.any():
            extremum += int(exceeds.argmax())
            t_break_away = break_away_time(
                work, state, max(state.t, float(t[extremum - 1])), float(t[extremum])
            )
            end = max(
                state.n, int(np.searchsorted(work.grid[:-1], t_break_away, side="right")) - 1
            )
            break
        extremum += LOOKAHEAD
    x_out[state.n + 1 : end + 1] = state.x_r
    return SlipState(t_break_away, state.x_r, 0.0, end)


def break_away_time(work: Work, state: SlipState, begin: float, end: float) -> float:
    """Return the time at which |F_L| exceeds the static limit, between two times [s]."""
    from scipy.optimize import brentq

    m, F_k, F_fs, base = work.plant.m, work.plant.k_x * state.x_r, work.law.F_fs, work.base

    def excess(t: float) -> float:
        return abs(m * base(t) + F_k) - F_fs

    if excess(begin) >= 0.0:
        return begin
    if isinstance(work.motion, Samples):
        low = limit_force(work, state._replace(t=begin))
        rise = limit_force(work, state._replace(t=end)) - low
        limit = work.law.F_fs if rise > 0.0 else -work.law.F_fs
        return begin + (end - begin) * (limit - low) / rise
    if excess(end) <= 0.0:
        return end
    t = float(
        brentq(excess, begin, end, xtol=BREAK_AWAY_TOLERANCE * end, rtol=BREAK_AWAY_TOLERANCE)
    )
    ahead = BREAK_AWAY_TOLERANCE * end
    while excess(t) <= 0.0:  # at or below the limit the mass would stick again
        t, ahead = min(t + ahead, end), 2.0 * ahead
    return t


def friction_force(work: Work, x_r: Floats, d: Floats) -> Floats:
    """Return F_f on the grid [N]: kinetic in slip, -F_L in stick."""
    F_L = work.plant.m * work.u_dd + work.plant.k_x * x_r
    F_f: Floats = np.where(d == 0, -F_L, d * work.law.F_fk)
    return F_f


# Shared by all peers.


def smoothed_answer(work: Work, x_r: Floats, v_r: Floats, c: float) -> Answer:
    """Return the answer of a peer with smoothed friction of sharpness c [s/m]."""
    return Answer(x_r, v_r, lambda: work.law.F_fk * np.tanh(c * v_r))


def has_static_excess(work: Work) -> bool:
    """Whether a scene has more than the single friction force that most peers support."""
    return work.law.F_fs > work.law.F_fk


def unsupported_law(law: AnyLaw) -> str:
    """Return what the peers do not support in a law; empty for Coulomb friction."""
    if law.stops is not None:
        return "end stops"
    if not (isinstance(law, DynamicLaw) or law.is_elastic):
        return "a varying normal force" if law.may_separate or law.variation else ""
    return "this friction law"


def motion_scale(work: Work) -> Floats:
    """Return the scales of x_r [m] and v_r [m/s] for absolute tolerances.

    The peak of ü acts for 1/omega_0, or for 0.1 s without a spring.
    """
    m, k_x, _ = work.plant
    time = sqrt(m / k_x) if k_x else 0.1
    a = float(np.abs(work.u_dd).max())
    v = a * time + abs(work.start.v_r)
    return np.array([(v * time + abs(work.start.x_r)) or 1.0, v or 1.0])


# scipy itself.

Method = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]

EVENT_SETTINGS: tuple[tuple[Method, float], ...] = (
    ("RK45", 1e-3),
    ("RK45", 1e-6),
    ("DOP853", 1e-9),
    ("DOP853", 1e-12),
)
"""Methods and relative tolerances with located events; the first is scipy's default."""

REFERENCE_SETTING: tuple[Method, float] = ("DOP853", 1e-13)
"""Method and relative tolerance of the reference: close to the limit of double precision."""

SECOND_RUN_SETTING: tuple[Method, float, int] = ("DOP853", 1e-12, 3)
"""Method, relative tolerance and divisor of the maximum step of the second run. The difference
of both runs estimates the error of the reference."""

SMOOTHED_SETTINGS: tuple[tuple[Method, float, float], ...] = (
    ("RK45", 1e-3, 1e3), ("LSODA", 1e-6, 1e4), ("Radau", 1e-6, 1e4), ("BDF", 1e-6, 1e5)
)  # fmt: skip
"""Methods, relative tolerances and sharpnesses [s/m] with smoothed friction."""

CHUNK_SAMPLES = 200
"""Maximum number of samples per call of `solve_ivp`, which ends at a stop."""


def entries(work: Work) -> Iterator[Entry]:
    """Yield scipy at several tolerances, with events and with smoothed friction."""
    # A record restarts the integrator at every sample, which makes all tolerances equal.
    for setting in EVENT_SETTINGS[:: 3 if isinstance(work.motion, Samples) else 1]:
        yield event_entry(*setting)
    for method, tolerance, c in SMOOTHED_SETTINGS:
        text = f"{method}, {format_number(tolerance)}, tanh c {format_number(c)}"
        ready = on_smoothed_law(method, tolerance, c)
        yield Entry("solve_ivp tanh", text, ready, other_law=has_static_excess(work))


def event_entry(method: Method, tolerance: float) -> Entry:
    """Return the entry of a method with located events and a relative tolerance."""
    setting = f"{method}, {format_number(tolerance)}"
    return Entry("solve_ivp events", setting, with_events(method, tolerance))


def reference_entry() -> Entry:
    """Return the entry that is the reference for the exact approach."""
    return event_entry(*REFERENCE_SETTING)


def second_run(work: Work) -> Answer:
    """Return the answer of the reference with another tolerance and a smaller maximum step."""
    return with_events(*SECOND_RUN_SETTING)(work)()


def with_events(
    method: Method, tolerance: float, step_divisor: int = 1
) -> Callable[[Work], Run]:
    """Return the preparation of an entry that restarts at every stop.

    Parameters
    ----------
    method : str
    tolerance : float
        Relative tolerance [-].
    step_divisor : int
        `longest_step` over the maximum step.

    Notes
    -----
    A record restarts the integrator at every sample, where the slope of ü jumps.
    """

    def ready(work: Work) -> Run:
        slip = RestartedSolver(work, method, tolerance, longest_step(work) / step_divisor)
        return lambda: integrate_stick_slip(work, slip)

    return ready


class RestartedSolver:
    """`solve_ivp` as `SlipIntegrator`: to the stop, the next sample, or over a chunk."""

    def __init__(self, work: Work, method: Method, tolerance: float, max_step: float) -> None:
        self.work, self.sampled = work, isinstance(work.motion, Samples)
        self.settings: dict[str, Any] = {
            "method": method, "rtol": tolerance, "atol": tolerance * motion_scale(work),
            "max_step": max_step,
        }  # fmt: skip
        self.grid = work.grid

    def __call__(
        self, begin: SlipState, d: int, x_out: Floats, v_out: Floats
    ) -> tuple[SlipState, bool]:
        """Integrate a slip phase in direction d; see `SlipIntegrator`."""
        last = min(begin.n + (1 if self.sampled else CHUNK_SAMPLES), self.work.samples)
        solution = self._solve(begin, d, last)
        if not solution.success:
            raise SolverError(f"solve_ivp at t = {begin.t:.6g} s: {solution.message}")
        stopped = solution.status == 1
        if self.sampled:
            n = begin.n + (not stopped)
            if not stopped:
                x_out[n], v_out[n] = solution.y[:, -1]
        else:
            n = begin.n + len(solution.t)
            if n > begin.n:  # scipy returns lists instead of arrays if a stop comes first
                x_out[begin.n + 1 : n + 1], v_out[begin.n + 1 : n + 1] = solution.y
        if stopped:
            t, (x_r, _) = float(solution.t_events[0][0]), solution.y_events[0][0].tolist()
            return SlipState(t, x_r, 0.0, n), True
        return SlipState(self.grid[last], float(x_out[last]), float(v_out[last]), last), False

    def _solve(self, begin: SlipState, d: int, last: int) -> Any:
        """Return the result of solve_ivp up to a point of the grid, or to the stop.

        solve_ivp detects events by a sign change over a step and misses two roots of v_r in
        one step. Between them d·v_r has a minimum, which is an event as well: if d·v_r < 0
        there, the mass has stopped before, and the integration is repeated up to the minimum.
        """
        from scipy.integrate import solve_ivp

        m, k_x, b = self.work.plant
        f, u_dd = d * self.work.law.F_fk / m, local_base(self.work, begin.n)

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
                rates,
                (begin.t, end),
                np.array([begin.x_r, begin.v_r or d * INITIAL_SLIP_VELOCITY]),
                events=(stop, minimum),
                t_eval=None if self.sampled else ahead[ahead <= end],
                **self.settings,
            )

        stop.terminal, stop.direction = True, -d  # type: ignore[attr-defined]
        minimum.direction = d  # type: ignore[attr-defined]
        solution = solved(self.grid[last])
        for t, y in zip(solution.t_events[1], solution.y_events[1], strict=True):
            if d * y[1] < 0.0:
                until = solved(float(t))
                return until if until.status == 1 else solution
        return solution


def longest_step(work: Work) -> float:
    """Return a step [s] in which v_r has at most one extremum: a quarter of the least period.

    dv_r/dt oscillates at the damped natural frequency, under sines also at their frequencies.
    """
    m, k_x, _ = work.plant
    fastest = max([sqrt(k_x / m), *(omega for _, omega, _ in work.sines)])
    return 0.25 * tau / fastest if fastest else inf


def local_base(work: Work, n: int) -> Callable[[float], float]:
    """Return the base acceleration near sample n; for a record its linear segment there."""
    if not isinstance(work.motion, Samples):
        return work.base
    u_0, t_0 = float(work.u_dd[n]), n * work.step
    slope = (float(work.u_dd[n + 1]) - u_0) / work.step
    return lambda t: u_0 + slope * (t - t_0)


def on_smoothed_law(method: Method, tolerance: float, c: float) -> Callable[[Work], Run]:
    """Return the preparation of an entry with tanh(c v_r) for sign(v_r), in a single call.

    Parameters
    ----------
    method : str
    tolerance : float
        Relative tolerance [-].
    c : float
        Sharpness [s/m].
    """

    def ready(work: Work) -> Run:
        from scipy.integrate import solve_ivp

        m, k_x, b = work.plant
        F_fk, base, grid = work.law.F_fk, work.base, work.grid

        def rates(t: float, y: Floats) -> tuple[float, float]:
            x_r, v_r = y.tolist()
            F_f = F_fk * tanh(c * v_r)
            return v_r, -base(t) - (k_x * x_r + b * v_r + F_f) / m

        def run() -> Answer:
            solution = solve_ivp(
                rates, (0.0, work.end), list(work.start), method, grid, rtol=tolerance,
                atol=tolerance * motion_scale(work), max_step=10 * work.step,
            )  # fmt: skip
            if not solution.success:
                raise SolverError(f"solve_ivp: {solution.message}")
            return smoothed_answer(work, solution.y[0], solution.y[1], c)

        return run

    return ready
