"""How the base of a case moves, and the window of its metrics."""

from __future__ import annotations

from drysim.core.motion import Samples, Sines
from drysim.errors import ScenarioError
from drysim.excitation.generated import Generated
from drysim.scenario import Scenario
from drysim.study import memory
from drysim.wording import number

ON_THE_END = 1e-9
"""A window that ends this close to the end of the record, relative to it, ends there."""


def base_motion(scenario: Scenario) -> Sines | Samples:
    """Give the motion of the base.

    Raises
    ------
    ScenarioError
        When a signal would not fit into memory; it is not made then.
    RecordError
        When the record cannot be used.
    """
    excitation, step, measure = scenario.excitation, scenario.solver.step, scenario.measure
    end = None if measure.duration is None else measure.settle + measure.duration
    span, block = end, "measure"
    if excitation.own_end:
        span, block = getattr(excitation, "duration", None), "excitation"
    steps = span / step if step and span and isinstance(excitation, Generated) else 0
    if shortage := memory.shortage(round(steps)):
        sentence = f"solver.step and {block}.duration: {shortage}"
        raise misfit(scenario, sentence, f"{block}.duration")
    return excitation.motion(step, end)


def window(scenario: Scenario, motion: Sines | Samples) -> tuple[float, float]:
    """Give begin and end of the metrics [s].

    Raises
    ------
    ScenarioError
        When a record does not reach to the end.
    """
    settle, duration = scenario.measure.settle, scenario.measure.duration
    if not isinstance(motion, Samples):
        assert duration is not None, "a scenario has a duration unless its record ends it"
        return settle, settle + duration
    last = (len(motion.u_dd) - 1) * motion.dt
    end = last if duration is None else settle + duration
    if settle >= last or end > last * (1.0 + ON_THE_END):
        key = "measure.settle" if settle >= last else "measure.duration"
        sentence = (
            f"{key} asks for motion beyond the end of the excitation at {number(last, 's')}"
        )
        raise misfit(scenario, sentence, key)
    return settle, min(end, last)


def misfit(scenario: Scenario, sentence: str, key: str) -> ScenarioError:
    """Give the error for a key that only the whole case shows to be wrong."""
    problem = scenario.problem(sentence, key)
    name = scenario.origin["file"] or scenario.name
    return ScenarioError(f"{name} is not a scenario yet: 1 problem", (problem,))
