"""Run: one case from its scenario to its outcome, or, of a sweep, to a row of numbers.

`solve` gives the outcome with the response on its grid; `measured` gives the metrics alone, of
a solution that needs no grid unless they are weighted. A scenario that measures steadily has
the periodic orbit solved: the exact approach finds its own, one by fixed steps marches from
there until its motion repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import ceil, isclose
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from drysim.approach.solution import Floats, Orbit, Response, Track
from drysim.approach.stick_slip import Exact, StickSlip
from drysim.core.compile import settle
from drysim.core.model import AnyState, Samples, Sines, State
from drysim.errors import Caution, RecordError, SolverError
from drysim.excitation.recorded import Record
from drysim.metrics.stroke import Values
from drysim.metrics.table import METRICS, Metrics, measure
from drysim.scenario.axes import size
from drysim.scenario.model import Scenario
from drysim.study.case import LINES, Case, _width, assemble, base_motion, segment_of
from drysim.study.outcome import Outcome
from drysim.study.statistics import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, Row, most
from drysim.study.warnings import ends_decide, found, moves, orbit_doubtful
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.metrics.spectra import Spectra


Solved = tuple[Response, tuple[float, float], tuple[Caution, ...]]


def solve(case: Case) -> Outcome:
    """Give the outcome of a case that is ready to be solved."""
    settle(case.work, case.price.kernels)
    response, window, doubts = march(case) if case.period is None else repetition(case)
    track = tracked(response)
    metrics = measure(track, window, case.limit, response.numerics.closure, case.goes_on)
    metrics |= weighted(case, response, window)
    spectra, unclear = spectra_of(case, response, window)
    # The stroke limit holds while the motion settles, too.
    late = bool(window[0] > 0 and metrics["violations"])
    whole = measure(track, (0.0, window[1]), case.limit) if late else metrics
    cautions = found(response, whole, case.limit, late, metrics["x_r_peak"])
    return Outcome(
        case.scenario,
        response,
        metrics,
        tuple(check.judge(metrics) for check in case.scenario.checks),
        (*case.cautions, *doubts, *cautions, *ends_matter(case, metrics), *unclear),
        spectra,
    )


def march(case: Case) -> Solved:
    """Give the motion from the start state to the end of the window."""
    approach = case.approach
    solve = approach.by_parts if isinstance(approach, Exact) else approach.solve
    scene = (case.plant, case.law, case.motion, case.start)
    return solve(*scene, case.step, case.window[1]), case.window, ()


def repetition(case: Case) -> Solved:
    """Give one repetition of the periodic orbit that the start state leads to."""
    orbit, step = orbit_of(case)
    assert case.period is not None
    length = orbit.periods * case.period
    response = on_step(case, orbit.state, step, length)
    error = response.numerics.error
    how = partial(
        replace,
        response.numerics,
        closure=orbit.closure,
        period_multiple=orbit.periods,
        error=None if error is None else error + orbit.left,
    )
    doubts = tuple(orbit_doubtful(orbit, case))
    return replace(response, how=how), (0.0, length), doubts


def ends_matter(case: Case, metrics: Metrics) -> Iterator[Caution]:
    """Warn when the ends of a high-passed record decide a metric; that takes a second solution.

    The high-pass must continue the record beyond its ends. Another way to do so, which the
    record supports as well, shows how much depends on that.
    """
    excitation = case.scenario.excitation
    if not isinstance(excitation, Record) or excitation.remove.below is None:
        return
    from drysim.records.record import motion_of

    try:
        other = replace(case, motion=motion_of(excitation, ends="odd"))
        moved = moves(metrics, measured(other)[0])
    except (RecordError, SolverError):  # such as a file that changed: the answer stands
        return
    if moved:
        yield ends_decide(moved, excitation.remove.below)


# The cases of a sweep: enumerated lazily, solved one by one, each giving a row.

MotionOf = Callable[[Scenario], Sines | Samples]

Found = tuple[Metrics, str, str]
"""Metrics of a case, its status and a note; no metrics where the numerics fail."""

ONE_OF_MANY = "one of a continuum of orbits"


class Job(NamedTuple):
    """One case of one approach: its number, the scenario to take it from, and its point."""

    number: int
    scenario: Scenario
    point: dict[str, float]


def count(scenarios: Sequence[Scenario]) -> int:
    """Give the number of cases without making one."""
    return sum(size(scenario.sweep) for scenario in scenarios)


def row_of(job: Job, motions: Motions) -> Row:
    """Give the row of one case."""
    scenario = job.scenario.at(job.point)
    law, found = scenario.law(), attempted(scenario, motions.of)
    return Row(job.point, scenario.word, law.F_fk, law.F_fs, *found)


def attempted(scenario: Scenario, motion_of: MotionOf) -> Found:
    """Give what `measured` does; a failure of the numerics is a status, not an end."""
    try:
        return measured(assemble(scenario, motion_of(scenario)))
    except SolverError as fault:
        return {}, FAILED, str(fault)


def measured(case: Case) -> Found:
    """Give the metrics of a case, its status and what is to be said about it."""
    if case.period is None:
        track, felt = follow(case, case.start, case.step, case.window)
        found = measure(track, case.window, case.limit, goes_on=case.goes_on)
        return found | felt, OK, ""
    orbit, step = orbit_of(case)
    unknown: Values = {metric.name: None for metric in METRICS}
    unknown["closure"] = orbit.closure
    # The orbit of fixed steps is measured even where it does not close.
    if isinstance(case.approach, Exact):
        if not orbit.settled:
            return unknown, NOT_SETTLED, unsettled(orbit.run_up)
        if not orbit.unique:
            return unknown, NOT_UNIQUE, ONE_OF_MANY
    length = orbit.periods * case.period
    track, felt = follow(case, orbit.state, step, (0.0, length))
    return measure(track, (0.0, length), case.limit, orbit.closure) | felt, OK, ""


def unsettled(run_up: float) -> str:
    """Say that a motion had not settled after some time [s]."""
    return f"it still changes after {run_up:.6g} s"


def follow(
    case: Case, start: AnyState, step: float, window: tuple[float, float]
) -> tuple[Track, Values]:
    """Give the solution of a case and its weighted metrics, which alone need its grid."""
    if case.scenario.measure.weights is None:
        return track_of(case, start, step, window[1]), {}
    step = step_of(case, step, window[1])
    response = on_step(case, start, step, window[1])
    return tracked(response), weighted(case, response, window)


def track_of(case: Case, start: AnyState, step: float, duration: float) -> Track:
    """Give the solution of a case, without its grid where the approach needs none."""
    if isinstance(case.approach, Exact):
        return case.approach.track(case.plant, case.law, case.motion, start, step, duration)
    return tracked(on_step(case, start, step, duration))


def tracked(response: Response) -> Track:
    """Give the track of a response; every approach gives one."""
    assert response.track is not None, "an approach gives its response with its track"
    return response.track


def on_step(case: Case, start: AnyState, step: float, length: float) -> Response:
    """Give the response of a case from a start state, on a grid of some step [s]."""
    return case.approach.solve(case.plant, case.law, case.motion, start, step, length)


KEPT = 4
"""Base motions kept: neighbouring cases differ in friction more often than in motion."""

KEPT_BYTES = 256e6
"""Memory up to which all seeds of a case are kept, as the other cases have the same."""


@dataclass
class Motions:
    """The base motions of the latest cases: what cases share is not made anew."""

    kept: dict[object, Sines | Samples] = field(default_factory=dict)
    most: int = KEPT
    lock: Lock = field(default_factory=Lock)

    @classmethod
    def beginning_with(cls, case: Case) -> Self:
        """Give the motions that know that of a case already."""
        motions, motion, seeds = cls(), case.motion, most(case.scenario)
        motions.kept[words(case.scenario)] = motion
        if isinstance(motion, Samples) and 16 * seeds * len(motion.u_dd) <= KEPT_BYTES:
            motions.most += seeds
        return motions

    def of(self, scenario: Scenario) -> Sines | Samples:
        """Give the base motion of a scenario."""
        wanted = words(scenario)
        motion = self.kept.get(wanted)
        if motion is None:
            motion = base_motion(scenario)
            with self.lock:
                self.kept[wanted] = motion
                while len(self.kept) > self.most:
                    del self.kept[next(iter(self.kept))]
        return motion


def words(scenario: Scenario) -> tuple[object, ...]:
    """Give everything in a scenario that its base motion depends on."""
    return scenario.excitation, scenario.solver.step, scenario.measure


def case_at(scenario: Scenario, point: Mapping[str, float]) -> Scenario:
    """Give the case of a scenario at a point of another, whose axes it may not have."""
    keys = {axis.key for axis in scenario.sweep}
    return scenario.at({key: value for key, value in point.items() if key in keys})


def response_of(scenario: Scenario) -> Response:
    """Give the response of one case, on its grid."""
    return solve(assemble(scenario, base_motion(scenario))).response


# Weighted metrics and spectra.

SAME = 1e-9
"""Two steps this close, relative to them, are one."""


def weighted(case: Case, response: Response, window: tuple[float, float]) -> Values:
    """Give the weighted metrics that a case asks for; none where it asks for none.

    The response is one repetition where an orbit is wanted.
    """
    weights = case.scenario.measure.weights
    if weights is None:
        return {}
    from drysim.metrics.comfort import comfort

    step, length = step_of(case, response.dt, window[1]), window[1]
    if not isclose(step, response.dt, rel_tol=SAME):
        response = on_step(case, tracked(response).state(0.0), step, length)
    return comfort(response, window, *weights, periodic=case.period is not None)


def step_of(case: Case, step: float, length: float) -> float:
    """Give the step of the grid to weight on [s]: one that divides what repeats."""
    return step if case.period is None else fitted(step, length)


FEW = 8
"""Half-overlapping segments below which PSD and coherence are hardly estimates."""


def run_only(case: Case) -> Iterator[Caution]:
    """Say that only a run gives spectra, where many cases are asked for them."""
    if case.scenario.measure.spectra:
        sentence = "measure.spectra has no use here: only `drysim run` gives spectra"
        yield Caution("spectra-left-out", sentence)


def spectra_of(
    case: Case, response: Response, window: tuple[float, float]
) -> tuple[Spectra | None, tuple[Caution, ...]]:
    """Give the spectra of a response, where they are asked for, and what to say of them."""
    if not case.scenario.measure.spectra:
        return None, ()
    from drysim.metrics.spectra import spectra

    found = spectra(response, window, segment_of(case))
    return found, tuple(doubts(case, found))


def doubts(case: Case, found: Spectra) -> Iterator[Caution]:
    """Say when the segments are too few, or too short for the resonance."""
    from drysim.metrics.spectra import WIDTH

    if found.segments < FEW:
        sentence = (
            f"the spectra are means over {found.segments} segments, fewer than {FEW}: their "
            "lines scatter widely and the coherence is too high; take a longer window or a "
            "shorter measure.segment"
        )
        yield Caution("few-segments", sentence, {"segments": found.segments})
    width, lines = _width(case), WIDTH / found.segment
    if 0 < width < lines:
        sentence = (
            f"the spectra resolve {number(lines, 'Hz')}, the resonance is "
            f"{number(width, 'Hz')} wide: its peak is flattened; "
            f"measure.segment: {number(LINES * WIDTH / width, 's', 2)} would show it"
        )
        yield Caution("coarse-spectra", sentence, {"resolution": lines, "width": width})


# The periodic orbit of fixed steps: march until the motion repeats, and say how well.

BURST = 8
"""Periods marched at a time at least, and the longest repetition that is looked for; those of
the exact orbit where these are more."""

MOST_BURSTS = 64
"""Bursts after which a motion counts as not settled: what decays has decayed by then."""

PATIENCE = 3
"""Bursts at least; more only while each closes better than the one before."""

BETTER = 0.99
"""Share of the change before that counts as closing better: what creeps closes slowly."""

CLOSED = 1e-9
"""Scaled change of the state over a repetition that counts as none [-]."""

ON_GRID = 1e-9
"""A period this close to a whole number of steps, in steps, is that number."""


def orbit_of(case: Case) -> tuple[Orbit, float]:
    """Give the periodic orbit of a case, and the step that it is solved with [s]."""
    period = case.period
    assert period is not None, "only what repeats has an orbit"
    approach, motion = case.approach, case.motion
    assert isinstance(motion, Sines), "samples end, so they repeat nothing"
    scene = (case.plant, case.law, motion, case.start, period)
    if isinstance(approach, Exact):
        return approach.orbit(*scene), case.step
    step, exact = fitted(case.step, period), StickSlip().orbit(*scene)
    return march_to_orbit(case, exact.state, step, period, max(BURST, exact.periods)), step


def march_to_orbit(case: Case, state: AnyState, dt: float, period: float, burst: int) -> Orbit:
    """Follow the exact orbit, step by step, to the orbit of a fixed-step approach.

    Fixed steps have an orbit of their own near that of the motion, so a march begins on the
    latter. One that chatters may have none, and its closure says so.
    """
    steps = round(period / dt)
    peak, closure, before, multiple, bursts = 0.0, np.inf, np.inf, burst, 0
    while bursts < PATIENCE or (CLOSED < closure < BETTER * before and bursts < MOST_BURSTS):
        response = on_step(case, state, dt, burst * period)
        x_r, v_r = response.x_r, response.v_r
        changes = np.maximum(repeats(x_r, steps, burst), repeats(v_r, steps, burst))
        closed = np.flatnonzero(changes <= CLOSED)
        multiple = int(closed[0]) + 1 if len(closed) else burst
        closure, before = float(changes[multiple - 1]), closure
        state = State(float(x_r[burst * steps]), float(v_r[burst * steps]))
        peak, bursts = max(peak, float(np.abs(x_r).max())), bursts + 1
    run_up = bursts * burst * period
    return Orbit(state, multiple, closure, closure <= CLOSED, True, run_up, peak)


def repeats(series: Floats, steps: int, burst: int) -> Floats:
    """Give the change of a series over the last 1, 2, ... periods of a burst, scaled [-]."""
    ends = series[steps * burst - steps * np.arange(burst + 1)]
    scale = float(np.abs(series).max())
    changes: Floats = np.abs(ends[1:] - ends[0]) / (scale or 1.0)
    return changes


def fitted(step: float, period: float) -> float:
    """Give the greatest step that is at most `step` and divides the period [s]."""
    return period / max(1, ceil(period / step - ON_GRID))
