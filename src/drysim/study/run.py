"""Run: one case from its scenario to its outcome."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from drysim.approach.stick_slip import Exact
from drysim.core.compiled import settle
from drysim.errors import RecordError, SolverError
from drysim.excitation.record import Record
from drysim.study import comfort
from drysim.study.case import Case, prepare
from drysim.study.cautions import ends_decide, found, moves, orbit_doubtful
from drysim.study.ensembles.seeds import most
from drysim.study.hands import hands
from drysim.study.outcome import Outcome
from drysim.study.spectral import spectra_of
from drysim.study.steady import orbit_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from drysim.approach.response import Response
    from drysim.errors import Caution
    from drysim.metrics import Metrics
    from drysim.scenario import Scenario
    from drysim.study.ensembles.ensemble import Ensemble

    Solved = tuple[Response, tuple[float, float], tuple[Caution, ...]]


def run(scenario: Scenario, *, workers: int | None = None) -> Outcome | Ensemble:
    """Give the response, the metrics and the verdicts of a scenario.

    Parameters
    ----------
    scenario : Scenario
        As `drysim.load` gives it.
    workers : int, optional
        Threads for many seeds; default: one for each processor.

    Returns
    -------
    Outcome or Ensemble
        An ensemble where the scenario asks for many seeds; its metrics are means.

    Raises
    ------
    RecordError
        When the record of the excitation cannot be used.
    ScenarioError
        When the case needs more memory than the machine has.
    SolverError
        When the numerics fail; the time is named.
    UsageError
        When it is no scenario, or `workers` no number of threads.
    """
    case = prepare(scenario)
    hands(workers)  # what is no number of threads is refused for one seed, too
    if most(scenario) == 1:
        return solve(case)
    from drysim.study.ensembles import ensemble

    return ensemble.solve(case, workers=workers)


def solve(case: Case) -> Outcome:
    """Give the outcome of a case that is ready to be solved."""
    settle(case.work, case.price.kernels)
    from drysim.metrics import measure

    response, window, doubts = march(case) if case.period is None else repetition(case)
    track = response.track
    assert track is not None, "an approach gives its response with its track"
    metrics = measure(track, window, case.limit, response.numerics.closure, case.goes_on)
    metrics |= comfort.weighted(case, response, window)
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
    response = case.approach.solve(case.plant, case.law, case.motion, orbit.state, step, length)
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
    from drysim.excitation.record.reading import motion_of
    from drysim.study.sweeps.cases import measured

    try:
        other = replace(case, motion=motion_of(excitation, ends="odd"))
        moved = moves(metrics, measured(other)[0])
    except (RecordError, SolverError):  # such as a file that changed: the answer stands
        return
    if moved:
        yield ends_decide(moved, excitation.remove.below)
