"""Solution of one case: an outcome for `run`, a row of metrics for sweeps and ensembles.

`solve` returns the outcome, with the response on its grid. `measure_case` returns only the
metrics; the exact approach takes them from the segments of its trajectory, without a grid,
unless they are frequency-weighted.

A scenario that measures the steady state needs a periodic orbit. The exact approach computes
it directly (`core.orbit`). A fixed-step approach has an orbit of its own nearby: it marches
from the exact one until its motion repeats (`fixed_step_orbit`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, isclose, isfinite
from threading import Lock
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from drysim.approach.solution import Orbit, Response, Trajectory
from drysim.approach.stick_slip import ExactApproach
from drysim.core.compile import choose_engine
from drysim.core.model import AnyState, CoulombLaw, Floats, Samples, Sines, State, keep_values
from drysim.core.status import Status
from drysim.errors import RecordError, SolverError, WarningMessage
from drysim.excitation.recorded import Record
from drysim.metrics.comfort import Weighted, weighted_accelerations
from drysim.metrics.table import (
    METRICS,
    Measured,
    Metrics,
    Values,
    evaluate,
    measure,
    observe,
)
from drysim.scenario.axes import count_points
from drysim.scenario.files import swept_files
from drysim.scenario.model import Scenario
from drysim.study.budget import case_cost
from drysim.study.case import Case
from drysim.study.outcome import Outcome
from drysim.study.preparation import assemble, base_motion
from drysim.study.statistics import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, Row, max_seeds
from drysim.study.warnings import (
    changed_metrics,
    orbit_warnings,
    record_end_warning,
    response_warnings,
)
from drysim.study.welch import BANDWIDTHS_PER_RESONANCE, resonance_width, segment_length
from drysim.wording import Point, format_length, format_number

if TYPE_CHECKING:
    from drysim.metrics.spectra import Spectra, TransferEstimate


SolvedMotion = tuple[Response, tuple[float, float], tuple[WarningMessage, ...], str]
"""Response, window of the metrics [s], warnings, and status: `ok`, or why there is no steady
state whose metrics a check could judge."""


def solve(case: Case) -> Outcome:
    """Solve a prepared case."""
    choose_engine(case_cost(case), case.kernels)
    response, window, motion_warnings, status = (
        march_from_start(case) if case.period is None else periodic_motion(case)
    )
    trajectory = trajectory_of_response(response)
    weighted = weighted_motion(case, response, window)
    closure = response.numerics.closure
    metrics = evaluate(observe_window(case, trajectory, window, closure, weighted))
    spectra, from_spectra = response_spectra(case, response, window)
    # The stroke limit also applies while the motion settles.
    includes_settling = bool(window[0] > 0 and metrics["violations"])
    whole = metrics
    if includes_settling:
        whole = measure(trajectory, (0.0, window[1]), case.limits, run_end=trajectory.end)
    judged = metrics if status == OK else unknown_metrics(closure)
    warnings = response_warnings(
        response, whole, case.limits, includes_settling, metrics["x_r_peak"]
    )
    return Outcome(
        case.scenario,
        response,
        metrics,
        tuple(check.judge(judged, status) for check in case.scenario.checks),
        (
            *case.warnings,
            *motion_warnings,
            *warnings,
            *record_end_warnings(case, metrics),
            *from_spectra,
        ),
        spectra,
    )


def march_from_start(case: Case) -> SolvedMotion:
    """Compute the motion from the start state to the end of the window."""
    approach = case.approach
    scene = (case.plant, case.law, case.run_motion, case.start, case.step, case.end)
    if isinstance(approach, ExactApproach):
        return approach.solve(*scene, whole=False), case.window, (), OK
    return approach.solve(*scene), case.window, (), OK


def periodic_motion(case: Case) -> SolvedMotion:
    """Compute one repetition of the periodic orbit reached from the start state."""
    orbit, step = periodic_orbit(case, case.start)
    assert case.period is not None
    length = orbit.periods * case.period
    response = response_on_grid(case, orbit.state, step, length)
    error, exponent = response.numerics.error, None
    distance = orbit.distance if orbit.settled and isfinite(orbit.distance) else None
    if not orbit.settled and isinstance(case.approach, ExactApproach):
        assert isinstance(case.motion, Sines), "samples are not periodic"
        from drysim.orbits.lyapunov import lyapunov_exponent
        from drysim.orbits.return_map import PeriodicSystem

        law = case.approach.effective_law(case.law)
        scene = PeriodicSystem(case.plant, law, case.motion, case.period)
        exponent = lyapunov_exponent(scene, orbit.state)
    numerics = replace(
        response.numerics,
        closure=orbit.closure,
        period_multiple=orbit.periods,
        distance=distance,
        error=None
        if error is None
        else error + (orbit.closure if distance is None else distance),
        lyapunov=exponent,
    )
    motion_warnings = (
        *orbit_warnings(orbit, case, exponent),
        *other_motion_warnings(case),
    )
    status, _ = orbit_status(case, orbit)
    status = OK if status == NOT_UNIQUE else status  # the one reached from the start
    return replace(response, numerics=numerics), (0.0, length), motion_warnings, status


def other_motion_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn of other stable motions that other starts lead to.

    Only Coulomb friction under the exact approach is searched; with F_fs = F_fk there are none.
    """
    law = case.law
    wanted = case.scenario.measure.coexisting is not False
    if not (wanted and isinstance(case.approach, ExactApproach)):
        return
    if not isinstance(law, CoulombLaw) or law.F_fs <= law.F_fk or law.variation:
        return
    from drysim.study.other_motions import find_other_motions

    assert isinstance(case.motion, Sines), "only periodic excitation has an orbit"
    assert case.period is not None
    others, starts = find_other_motions(case.plant, law, case.motion, case.start, case.period)
    if not others:
        return
    listed = "; ".join(
        f"T_a {format_number(motion.T_a, digits=4)}, stroke {format_length(motion.x_r_peak)}"
        for motion in others
    )
    exist = "another stable motion exists" if len(others) == 1 else "other stable motions exist"
    sentence = (
        f"{exist} ({listed}): {starts} other starts were tried; `drysim branches` follows all "
        "motions along a key"
    )
    yield WarningMessage("other-motion", sentence, {"motions": len(others), "starts": starts})


def record_end_warnings(case: Case, metrics: Metrics) -> Iterator[WarningMessage]:
    """Warn when the ends of a high-passed record decide a metric.

    A high-pass continues the record beyond its ends. The case is solved a second time, with
    another continuation that the record supports equally well; the difference of the metrics
    is the uncertainty.
    """
    excitation = case.scenario.excitation
    if not isinstance(excitation, Record) or excitation.remove.below is None:
        return
    from drysim.records.record import read_motion

    try:
        other = replace(case, motion=read_motion(excitation, ends="odd"))
        moved = changed_metrics(metrics, measure_case(other)[0])
    except (RecordError, SolverError):  # e.g. a changed file: no warning
        return
    if moved:
        yield record_end_warning(moved, excitation.remove.below)


# Rows of metrics, for the cases of a sweep.

MotionSource = Callable[[Scenario], Sines | Samples]
"""Function that returns the base motion of a scenario."""

CaseResult = tuple[Metrics, str, str]
"""Metrics of a case (empty on failure), its status and a note."""

SolvedCase = tuple[CaseResult, AnyState]
"""Result of a case and its last state: on the orbit at the beginning of a period of the
excitation, or at the end of the window. A case without numbers keeps the state from which it
started."""


def count_cases(scenarios: Sequence[Scenario]) -> int:
    """Return the number of cases, without enumerating them."""
    return sum(count_points(scenario.sweep) for scenario in scenarios)


def solve_row(swept: Scenario, point: dict[str, Any], motions: MotionCache) -> Row:
    """Solve one case of a sweep."""
    return solve_row_from(swept, point, motions, None)[0]


def solve_row_from(
    swept: Scenario, point: dict[str, Any], motions: MotionCache, start: AnyState | None
) -> tuple[Row, AnyState]:
    """Solve one case of a sweep from a start state; return its row and its last state.

    `start` None stands for the start state of the scenario.
    """
    scenario = swept.at(point)
    law, (result, last) = scenario.law(), try_measure(scenario, motions.of, start)
    return Row(point, scenario.label, law.F_fk, law.F_fs, *result), last


def try_measure(
    scenario: Scenario, motion_of: MotionSource, start: AnyState | None = None
) -> SolvedCase:
    """Return the result of a scenario; a numerical failure becomes a status."""
    case = assemble(scenario, motion_of(scenario))
    start = case.start if start is None else start
    try:
        return measure_motion(case, start)
    except SolverError as fault:
        return ({}, FAILED, str(fault)), start


def measure_case(case: Case) -> CaseResult:
    """Return metrics, status and note of a case."""
    return measure_motion(case, case.start)[0]


def observe_motion(case: Case, start: AnyState) -> tuple[Measured, AnyState]:
    """Return what the metrics of a motion that is no orbit follow from, and its last state."""
    trajectory, weighted = solve_and_weight(case, start, case.step, case.window, case.end)
    observed = observe_window(case, trajectory, case.window, None, weighted)
    return observed, trajectory.state(case.window[1])


def measure_motion(case: Case, start: AnyState) -> SolvedCase:
    """Return the result of a case from a start state, and its last state."""
    if case.period is None:
        observed, last = observe_motion(case, start)
        return (evaluate(observed), OK, ""), last
    orbit, step = periodic_orbit(case, start)
    status, note = orbit_status(case, orbit)
    if status != OK:
        return (unknown_metrics(orbit.closure), status, note), start
    window = (0.0, orbit.periods * case.period)
    trajectory, weighted = solve_and_weight(case, orbit.state, step, window, window[1])
    metrics = evaluate(observe_window(case, trajectory, window, orbit.closure, weighted))
    return (metrics, OK, ""), orbit.state


def orbit_status(case: Case, orbit: Orbit) -> tuple[str, str]:
    """Return the status of an orbit, and why it is not a steady state; empty if it is one.

    A fixed-step orbit is measured even if it does not close: `closure` shows it.
    """
    if isinstance(case.approach, ExactApproach):
        if not orbit.settled:
            return NOT_SETTLED, Status.NOT_SETTLED.sentence(t=orbit.run_up)
        if not orbit.unique:
            return NOT_UNIQUE, Status.NOT_UNIQUE.sentence()
    return OK, ""


def unknown_metrics(closure: float | None) -> Values:
    """Return the metrics of an orbit that is not a steady state: only its closure is known."""
    return {metric.name: None for metric in METRICS} | {"closure": closure}


def observe_window(
    case: Case,
    trajectory: Trajectory,
    window: tuple[float, float],
    closure: float | None,
    weighted: Weighted | None,
) -> Measured:
    """Return what the metrics of a case in a window [s] follow from."""
    settings, end = case.scenario.measure, trajectory.end if case.rest else None
    return observe(
        trajectory, window, case.limits, closure, case.stationary, weighted, settings, end
    )


def solve_and_weight(
    case: Case, start: AnyState, step: float, window: tuple[float, float], end: float
) -> tuple[Trajectory, Weighted | None]:
    """Return the trajectory of a case and its weighted motion, which alone needs a grid.

    The run goes on from the start to `end` [s], the weighted motion covers the window.
    """
    if case.scenario.measure.weights is None:
        return trajectory_of(case, start, step, end), None
    step = weighting_step(case, step, window[1])
    response = response_on_grid(case, start, step, end)
    return trajectory_of_response(response), weighted_motion(case, response, window)


def trajectory_of(case: Case, start: AnyState, step: float, duration: float) -> Trajectory:
    """Return the trajectory of a case, without a grid if the approach needs none."""
    if isinstance(case.approach, ExactApproach):
        return case.approach.trajectory(case.plant, case.law, case.run_motion, start, duration)
    return trajectory_of_response(response_on_grid(case, start, step, duration))


def trajectory_of_response(response: Response) -> Trajectory:
    """Return the trajectory of a response; every approach sets it."""
    assert response.trajectory is not None, (
        "an approach returns its response with its trajectory"
    )
    return response.trajectory


def response_on_grid(case: Case, start: AnyState, step: float, length: float) -> Response:
    """Return the response of a case from a start state, on a grid with this step [s]."""
    return case.approach.solve(case.plant, case.law, case.run_motion, start, step, length)


MAX_CACHED_MOTIONS = 4
"""Number of cached base motions: neighbouring cases rarely differ in their motion."""

MAX_CACHED_BYTES = 256e6
"""Memory up to which the motions of all seeds of a case are cached for the other cases."""


@dataclass
class MotionCache:
    """Base motions of the latest cases, shared by threads."""

    cached: dict[object, Sines | Samples] = field(default_factory=dict)
    max_size: int = MAX_CACHED_MOTIONS
    lock: Lock = field(default_factory=Lock)

    @classmethod
    def starting_with(cls, case: Case) -> Self:
        """Return a cache that holds the motion of this case, with room for seeds or files."""
        motions, motion = cls(), case.motion
        keep_values(motion)
        motions.cached[motion_key(case.scenario)] = motion
        count = max(max_seeds(case.scenario), len(swept_files(case.scenario)))
        if isinstance(motion, Samples) and 16 * count * len(motion.u_dd) <= MAX_CACHED_BYTES:
            motions.max_size += count
        return motions

    def of(self, scenario: Scenario) -> Sines | Samples:
        """Return the base motion of a scenario."""
        wanted = motion_key(scenario)
        motion = self.cached.get(wanted)
        if motion is None:
            motion = base_motion(scenario)
            keep_values(motion)
            with self.lock:
                self.cached[wanted] = motion
                while len(self.cached) > self.max_size:
                    del self.cached[next(iter(self.cached))]
        return motion


def motion_key(scenario: Scenario) -> tuple[object, ...]:
    """Return all parts of a scenario that its base motion depends on."""
    return scenario.excitation, scenario.solver.step, scenario.measure


def scenario_at(scenario: Scenario, point: Point) -> Scenario:
    """Return the scenario at a point of another one, whose axes it may lack."""
    keys = {axis.key for axis in scenario.sweep}
    return scenario.at({key: value for key, value in point.items() if key in keys})


def response_of(scenario: Scenario) -> Response:
    """Return the response of one case, on its grid."""
    return solve(assemble(scenario, base_motion(scenario))).response


# Weighted motion and spectra.

STEP_TOLERANCE = 1e-9
"""Relative difference below which two steps are equal."""


def weighted_motion(
    case: Case, response: Response, window: tuple[float, float]
) -> Weighted | None:
    """Return the frequency-weighted accelerations of a case; None if it requests none.

    For a periodic orbit, `response` is one repetition.
    """
    weights = case.scenario.measure.weights
    if weights is None:
        return None

    step, length = weighting_step(case, response.dt, window[1]), window[1]
    if not isclose(step, response.dt, rel_tol=STEP_TOLERANCE):
        response = response_on_grid(
            case, trajectory_of_response(response).state(0.0), step, length
        )
    return weighted_accelerations(response, window, *weights, periodic=case.period is not None)


def weighting_step(case: Case, step: float, length: float) -> float:
    """Return the step of the grid for weighting [s]; it divides the period of an orbit."""
    return step if case.period is None else dividing_step(step, length)


MIN_SEGMENTS = 8
"""Number of half-overlapping segments below which PSD and coherence are poor estimates."""


def unused_spectra_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn of requested spectra where many cases are computed: only a run returns them."""
    if case.scenario.measure.spectra:
        sentence = "measure.spectra is ignored: only `drysim run` computes spectra"
        yield WarningMessage("spectra-left-out", sentence)


def response_spectra(
    case: Case, response: Response, window: tuple[float, float]
) -> tuple[Spectra | None, tuple[WarningMessage, ...]]:
    """Return the spectra of a response, if requested, and warnings about them."""
    if not case.scenario.measure.spectra:
        return None, ()
    from drysim.metrics.spectra import spectra, third_octaves

    estimate = spectra(response, window, segment_length(case))
    if case.scenario.measure.bands:
        bands = third_octaves(response, window, case.scenario.measure.weights)
        estimate = estimate._replace(bands=bands)
    return estimate, tuple(spectra_warnings(case, estimate))


def spectra_warnings(
    case: Case, estimate: Spectra | TransferEstimate
) -> Iterator[WarningMessage]:
    """Warn when the segments are too few, or too short for the resonance."""
    from drysim.metrics.spectra import HANN_BANDWIDTH

    if estimate.segments < MIN_SEGMENTS:
        sentence = (
            f"the spectra are averages over {estimate.segments} segments, fewer than "
            f"{MIN_SEGMENTS}: their variance is large and the coherence too high; use a longer "
            "window or a shorter measure.segment"
        )
        yield WarningMessage("few-segments", sentence, {"segments": estimate.segments})
    width, lines = resonance_width(case), HANN_BANDWIDTH / estimate.segment
    if 0 < width < lines:
        segment = BANDWIDTHS_PER_RESONANCE * HANN_BANDWIDTH / width
        sentence = (
            f"the spectra resolve {format_number(lines, 'Hz')}, but the resonance is "
            f"{format_number(width, 'Hz')} wide: its peak is too low; "
            f"use measure.segment: {format_number(segment, 's', 2)}"
        )
        yield WarningMessage("coarse-spectra", sentence, {"resolution": lines, "width": width})


# Periodic orbits of fixed-step approaches: march until the motion repeats.

PERIODS_PER_BURST = 8
"""Periods marched at a time, and the longest repetition searched for. The exact orbit may
demand more of both."""

MAX_BURSTS = 64
"""Bursts after which a motion counts as not settled: any transient has decayed by then."""

MIN_BURSTS = 3
"""Bursts marched in any case; more follow only while the closure improves."""

MIN_IMPROVEMENT = 0.99
"""Ratio of successive closures below which the motion still converges, however slowly."""

CLOSURE_TOLERANCE = 1e-9
"""Scaled change of the state over one repetition below which an orbit is closed [-]."""

GRID_TOLERANCE = 1e-9
"""Distance of a period from a whole number of steps, in steps, that counts as rounding."""


def periodic_orbit(case: Case, start: AnyState) -> tuple[Orbit, float]:
    """Return the periodic orbit reached from a start, and the step of its solution [s]."""
    period = case.period
    assert period is not None, "only periodic excitation has an orbit"
    approach, motion = case.approach, case.motion
    assert isinstance(motion, Sines), "samples are not periodic"
    from drysim.orbits.search import find_orbit

    if isinstance(approach, ExactApproach):
        law = approach.effective_law(case.law)
        return find_orbit(case.plant, law, motion, start, period), case.step
    step = dividing_step(case.step, period)
    exact = find_orbit(case.plant, case.law, motion, start, period)
    return fixed_step_orbit(
        case, exact.state, step, period, max(PERIODS_PER_BURST, exact.periods)
    ), step


def fixed_step_orbit(
    case: Case, state: AnyState, dt: float, period: float, burst: int
) -> Orbit:
    """Return the periodic orbit of a fixed-step approach, marched from the exact orbit.

    Parameters
    ----------
    case : Case
    state : State
        State of the exact orbit.
    dt : float
        Step [s], a divisor of the period.
    period : float
        Period of the excitation [s].
    burst : int
        Periods marched at a time.

    Returns
    -------
    Orbit
        Its closure shows whether it repeats; an approach that chatters may have no orbit.
    """
    # Loads kernels, so only after the choice of the engine.
    from drysim.orbits.search import shortest_repetition

    steps = round(period / dt)
    peak, closure, before, multiple, bursts = 0.0, np.inf, np.inf, burst, 0
    while bursts < MIN_BURSTS or (
        CLOSURE_TOLERANCE < closure < MIN_IMPROVEMENT * before and bursts < MAX_BURSTS
    ):
        response = response_on_grid(case, state, dt, burst * period)
        x_r, v_r = response.x_r, response.v_r
        changes = np.maximum(
            closure_by_period(x_r, steps, burst), closure_by_period(v_r, steps, burst)
        )
        multiple = shortest_repetition(changes, CLOSURE_TOLERANCE) or burst
        closure, before = float(changes[multiple - 1]), closure
        state = State(float(x_r[burst * steps]), float(v_r[burst * steps]))
        peak, bursts = max(peak, float(np.abs(x_r).max())), bursts + 1
    run_up = bursts * burst * period
    return Orbit(state, multiple, closure, closure <= CLOSURE_TOLERANCE, True, run_up, peak)


def closure_by_period(series: Floats, steps: int, burst: int) -> Floats:
    """Return the scaled change of a series over the last 1, 2, ... `burst` periods [-]."""
    ends = series[steps * burst - steps * np.arange(burst + 1)]
    scale = float(np.abs(series).max())
    changes: Floats = np.abs(ends[1:] - ends[0]) / (scale or 1.0)
    return changes


def dividing_step(step: float, period: float) -> float:
    """Return the largest step that is at most `step` and divides the period [s]."""
    return period / max(1, ceil(period / step - GRID_TOLERANCE))
