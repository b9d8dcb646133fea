"""A case: a scenario as numbers, validated and ready to be solved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from drysim.approach import Approach
from drysim.approach.cost import StepCost, step_cost
from drysim.core.model import (
    AnyLaw,
    Input,
    Plant,
    RecordSummary,
    Samples,
    Sines,
    State,
    StrokeLimits,
    with_rest,
)
from drysim.errors import WarningMessage
from drysim.excitation.random import RandomMotion
from drysim.excitation.recorded import Record
from drysim.scenario.model import Scenario

LENGTH_TOLERANCE = 1e-9
"""Relative tolerance in comparisons of durations, for rounding."""


@dataclass(frozen=True, eq=False)
class Case:
    """Everything that an approach needs, and the scenario that it comes from."""

    scenario: Scenario
    approach: Approach
    """Approach with its options."""
    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    start: State
    """Oscillator, friction law, base motion and start state."""
    step: float
    """Step of the output grid [s]."""
    window: tuple[float, float]
    """Begin and end of the interval over which metrics are taken [s]; one period for a periodic
    orbit."""
    period: float | None
    """Period of the excitation [s] for a periodic orbit, else None."""
    warnings: tuple[WarningMessage, ...]
    """Warnings known before the computation."""
    inputs: tuple[Input, ...] = ()
    """Records of the base motion; all of them where the record is swept."""
    records: tuple[RecordSummary, ...] = ()
    """The swept records; none for other sweeps."""
    rest: int = 0
    """Steps of the ring-down after the window, with the base at rest."""

    @property
    def steps(self) -> int:
        """Number of steps of the output grid."""
        return round(self.window[1] / self.step) + self.rest

    @property
    def end(self) -> float:
        """End of the run [s]."""
        if self.rest and isinstance(self.run_motion, Samples):
            return (len(self.run_motion.u_dd) - 1) * self.step
        return self.window[1] + self.rest * self.step

    @cached_property
    def run_motion(self) -> Sines | Samples:
        """Base motion to the end of the run."""
        motion = self.motion
        return with_rest(motion, self.rest) if isinstance(motion, Samples) else motion

    @property
    def step_cost(self) -> StepCost:
        """Cost of one step."""
        return step_cost(self.approach, self.law, self.motion)

    @property
    def kernels(self) -> str:
        """Kernels compiled for the case, as `compile.choose_engine` takes them."""
        return self.step_cost.kernels

    @property
    def limits(self) -> StrokeLimits | None:
        """Stroke limits, if any."""
        stroke = self.scenario.stroke
        return None if stroke is None else stroke.limits

    @property
    def stationary(self) -> bool:
        """Whether the base is assumed to move on as in the window: noise and records."""
        return isinstance(self.scenario.excitation, RandomMotion | Record)
