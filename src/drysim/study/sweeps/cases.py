"""The cases of a sweep: enumerated lazily, solved one by one, each giving a row."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple, Self

from drysim.approach.stick_slip import Exact
from drysim.core.motion import Samples, Sines
from drysim.core.state import AnyState
from drysim.errors import SolverError
from drysim.metrics import METRICS, Metrics, Values, measure
from drysim.scenario.sweep.axis import size
from drysim.study import comfort
from drysim.study.base_motion import base_motion
from drysim.study.case import Case, assemble
from drysim.study.ensembles.seeds import most
from drysim.study.steady import orbit_of
from drysim.study.sweeps.table import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, Row

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.approach.track import Track
    from drysim.scenario import Scenario

    MotionOf = Callable[[Scenario], Sines | Samples]

KEPT = 4
"""Base motions kept: neighbouring cases differ in friction more often than in motion."""

KEPT_BYTES = 256e6
"""Memory up to which all seeds of a case are kept, as the other cases have the same."""


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
    if not comfort.asked(case):
        return track_of(case, start, step, window[1]), {}
    step = comfort.step_of(case, step, window[1])
    response = comfort.on_step(case, start, step, window[1])
    assert response.track is not None, "an approach gives its response with its track"
    return response.track, comfort.weighted(case, response, window)


def track_of(case: Case, start: AnyState, step: float, duration: float) -> Track:
    """Give the solution of a case, without its grid where the approach needs none."""
    scene = (case.plant, case.law, case.motion, start, step, duration)
    if isinstance(case.approach, Exact):
        return case.approach.track(*scene)
    track = case.approach.solve(*scene).track
    assert track is not None, "every approach gives a track"
    return track


def case_at(scenario: Scenario, point: Mapping[str, float]) -> Scenario:
    """Give the case of a scenario at a point of another, whose axes it may not have."""
    keys = {axis.key for axis in scenario.sweep}
    return scenario.at({key: value for key, value in point.items() if key in keys})


def response_of(scenario: Scenario) -> Response:
    """Give the response of one case, on its grid."""
    from drysim.study.run import solve as solve_case

    return solve_case(assemble(scenario, base_motion(scenario))).response
