"""The response that weighted metrics are taken from, and those metrics."""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING

from drysim.study.steady import fitted

if TYPE_CHECKING:
    from drysim.approach.response import Response
    from drysim.core.state import AnyState
    from drysim.metrics import Values
    from drysim.study.case import Case

SAME = 1e-9
"""Two steps this close, relative to them, are one."""


def asked(case: Case) -> bool:
    """Whether a scenario asks for weighted metrics."""
    return case.scenario.measure.weights is not None


def step_of(case: Case, step: float, length: float) -> float:
    """Give the step of the grid to weight on [s]: one that divides what repeats."""
    return step if case.period is None else fitted(step, length)


def weighted(case: Case, response: Response, window: tuple[float, float]) -> Values:
    """Give the weighted metrics that a case asks for; none where it asks for none.

    Parameters
    ----------
    case : Case
    response : Response
        Its motion; one repetition where an orbit is wanted.
    window : tuple of float
        Begin and end [s].
    """
    weights = case.scenario.measure.weights
    if weights is None:
        return {}
    from drysim.comfort import comfort

    step, length = step_of(case, response.dt, window[1]), window[1]
    if not isclose(step, response.dt, rel_tol=SAME):
        response = on_step(case, first(response), step, length)
    return comfort(response, window, *weights, periodic=case.period is not None)


def first(response: Response) -> AnyState:
    """Give the state of a response at t = 0."""
    assert response.track is not None, "an approach gives its response with its track"
    return response.track.state(0.0)


def on_step(case: Case, start: AnyState, step: float, length: float) -> Response:
    """Give the response of a case on a grid of another step [s]."""
    return case.approach.solve(case.plant, case.law, case.motion, start, step, length)
