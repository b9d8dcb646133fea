"""Case: a scenario crossed from words to symbols, ready to be solved. Computes nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from drysim.approach.stick_slip import Exact
from drysim.core.compiled import engine
from drysim.core.motion import Samples, Sines
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import AnyLaw, Dynamic, Law, Plant
from drysim.core.state import State
from drysim.errors import Caution, UsageError
from drysim.excitation.generated import Drawn
from drysim.excitation.record import Record
from drysim.quantity import short
from drysim.scenario import Scenario, cautions, period
from drysim.study import effort, memory, volume
from drysim.study.base_motion import ON_THE_END, base_motion, misfit, window
from drysim.study.ensembles import seeds
from drysim.study.spectral import refusal
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.approach import Approach

WAVE_WORK = 5
"""What a wave adds to a grid point, in steps of sampled motion."""


@dataclass(frozen=True, eq=False)
class Case:
    """Everything that an approach needs, and the scenario that it came from.

    Attributes
    ----------
    scenario : Scenario
    approach
        A member of the shelf, with its options.
    plant, law, motion, start
        The scene.
    step : float
        Distance of the output grid [s].
    window : tuple of float
        Begin and end of the metrics [s]; one period when an orbit is wanted.
    period : float or None
        Period of the excitation [s] when an orbit is wanted.
    cautions : tuple of Caution
        What is to be said before anything is computed.
    """

    scenario: Scenario
    approach: Approach
    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    start: State
    step: float
    window: tuple[float, float]
    period: float | None
    cautions: tuple[Caution, ...]

    @property
    def steps(self) -> int:
        """Number of steps of the output grid."""
        return round(self.window[1] / self.step)

    @property
    def work(self) -> int:
        """Number of steps of sampled motion that are as much work as this case."""
        waves = len(self.motion.f) if isinstance(self.motion, Sines) else 0
        radians = effort.turns(self).radians
        a_step = max(1 + WAVE_WORK * waves, self.price.of(self.motion))
        return max(self.steps * a_step, round(WAVE_WORK * radians))

    @property
    def price(self) -> effort.Price:
        """What a step costs."""
        return effort.price(self.approach, self.law)

    @property
    def limit(self) -> float | None:
        """Stroke limit x_rM [m], if there is one."""
        stroke = self.scenario.stroke
        return None if stroke is None else stroke.limit

    @property
    def goes_on(self) -> bool:
        """Whether the base may be taken to go on moving as in the window: noise and records."""
        return isinstance(self.scenario.excitation, Drawn | Record)


def require(scenario: Scenario) -> None:
    """Make sure that this is a scenario."""
    if not isinstance(scenario, Scenario):
        given = short(repr(scenario))
        raise UsageError(
            f"what is solved is a scenario, as `drysim.load` gives it, not {given}"
        )


def prepare(scenario: Scenario, compared: bool = False) -> Case:
    """Give the case of a scenario: read its record, check that it can be solved.

    Parameters
    ----------
    scenario : Scenario
    compared : bool, optional
        Whether other approaches or laws solve it, too, which use their options.

    Returns
    -------
    Case

    Raises
    ------
    RecordError
        When the record of the excitation, or of the normal force, cannot be used.
    ScenarioError
        When the window of the metrics lies beyond the end of the motion, the spectra cannot be
        had, or the case needs more memory than the machine has.
    UsageError
        When it is no scenario, or the environment names an engine that there is not.
    """
    require(scenario)
    require_engine()
    if shortage := memory.shortage_of_seeds(seeds.most(scenario)):
        raise misfit(scenario, f"excitation.seeds: {shortage}", "excitation.seeds")
    motion = base_motion(scenario)
    law = scenario.law()
    force = law.pressure.cautions if isinstance(law, Pressed) and law.pressure else ()
    known = (*cautions(scenario, motion, compared), *getattr(motion, "cautions", ()), *force)
    case = assemble(scenario, motion, known)
    if refused := refusal(case):
        raise misfit(scenario, *refused)
    return case


def assemble(
    scenario: Scenario, motion: Sines | Samples, remarks: tuple[Caution, ...] = ()
) -> Case:
    """Give the case of a scenario whose base motion is known; errors as in `prepare`."""
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    assert step is not None, "a scenario has a step unless its record owns one"
    repeats = period(scenario) if scenario.measure.steady else None
    case = Case(
        scenario,
        scenario.solver.member(),
        scenario.oscillator.plant(),
        scenario.law(),
        motion,
        scenario.start.state(),
        step,
        window(scenario, motion) if repeats is None else (0.0, repeats),
        repeats,
        remarks,
    )
    weighed = bool(scenario.measure.weights or scenario.measure.spectra)
    if sentence := too_short(case):
        raise misfit(scenario, sentence, "friction.normal_record")
    if shortage := memory.shortage(case.steps, weighed, by_parts(case)):
        sentence = f"solver.step and measure.duration: {shortage}"
        raise misfit(scenario, sentence, "measure.duration")
    points = case.steps * case.approach.pieces(case.plant, case.law, step)
    if shortage := memory.shortage(points, weighed, by_parts(case)):
        key = f"solver.{case.approach.approach}"
        raise misfit(scenario, f"{key} divides every step: {shortage}", key)
    if excess := effort.excess(case):
        raise misfit(scenario, *excess)
    return replace(case, cautions=(*remarks, *effort.cautions(case), *volume.cautions(case)))


def too_short(case: Case) -> str:
    """Say when a recorded normal force ends before the run; nothing where it does not."""
    pressure = case.law.pressure if isinstance(case.law, Pressed) else None
    if pressure is None or case.window[1] <= pressure.end * (1.0 + ON_THE_END):
        return ""
    ends = f"ends at {number(pressure.end, 's')}"
    return (
        f"friction.normal_record {ends}, before the run, which ends at "
        f"{number(case.window[1], 's')}; give a longer record or a shorter measure.duration"
    )


def by_parts(case: Case) -> bool:
    """Tell whether a long response of a case is never held whole."""
    return isinstance(case.approach, Exact) and isinstance(case.law, Law | Dynamic)


def require_engine() -> None:
    """Make sure that the environment names an engine that there is."""
    try:
        engine()
    except ValueError as fault:
        raise UsageError(str(fault)) from fault
