"""A scenario as numbers, validated and ready to be solved; nothing is solved here.

Preparation
    `prepare` reads the record and checks what only the complete case shows: the window lies
    within the motion, the requested spectra exist, the response fits into memory, and the
    work takes less than about an hour. `assemble` does the same for a known base motion: a
    case of a sweep, or a seed of an ensemble.

Estimates
    Work: the event search takes steps of about one radian of the fastest oscillation, so the
    total phase of each oscillation bounds the computing time (`largest_oscillation`). Output:
    response.csv has one row per step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any, NamedTuple

from drysim import system
from drysim.approach import Approach
from drysim.approach.cost import StepCost, step_cost
from drysim.approach.stick_slip import ExactApproach
from drysim.core.compile import engine
from drysim.core.model import (
    AnyLaw,
    DynamicLaw,
    Input,
    PiecewiseLaw,
    Plant,
    RecordSummary,
    Samples,
    Sines,
    State,
    StrokeLimits,
    with_rest,
)
from drysim.errors import RecordError, ScenarioError, UsageError, WarningMessage
from drysim.excitation.base import GeneratedMotion
from drysim.excitation.random import RandomMotion
from drysim.excitation.recorded import Record
from drysim.messages import shorten
from drysim.metrics.table import FIT_METRICS
from drysim.scenario.axes import DIRECTION_KEY, FILE_KEY, SWEEP_KEY, chain_length
from drysim.scenario.files import files_location, swept_files
from drysim.scenario.model import STATIC_RATIO, Scenario, scene_period
from drysim.scenario.warnings import extreme_cases, scenario_warnings
from drysim.study import statistics
from drysim.study.ring_down import cut_warnings, rest_steps
from drysim.wording import format_number

FIT_NAMES = frozenset(metric.name for metric in FIT_METRICS)
"""Metrics that only a fit has."""

WORK_PER_FIT = 2000
"""Number of solutions in a fit, for the choice of the engine."""

STEPS_PER_WAVE = 5
"""Cost of one sine at one grid point, in steps of sampled motion."""


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
    def work(self) -> int:
        """Cost of the case, in steps of sampled motion; with a fit block that of the fit.

        A fit may follow a run in the same process, whose engine is chosen once.
        """
        waves = len(self.motion.f) if isinstance(self.motion, Sines) else 0
        radians = largest_oscillation(self).radians
        a_step = max(1 + STEPS_PER_WAVE * waves, self.step_cost.steps)
        once = max(self.steps * a_step, round(STEPS_PER_WAVE * radians))
        return once if self.scenario.fit is None else WORK_PER_FIT * once

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


def require_scenario(scenario: Scenario) -> None:
    """Raise a UsageError for anything but a scenario."""
    if not isinstance(scenario, Scenario):
        given = shorten(repr(scenario))
        raise UsageError(f"expected a scenario, as `drysim.load` returns it, not {given}")


def prepare(
    scenario: Scenario, compared: bool = False, swept: bool = False, interval: bool = False
) -> Case:
    """Return the case of a scenario: read its record and check that it can be solved.

    Parameters
    ----------
    scenario : Scenario
    compared : bool, optional
        Whether other approaches or laws also solve the scenario and use their options.
    swept : bool, optional
        Whether the cases of its sweep are solved, too: their records are then read as well.
    interval : bool, optional
        Whether `friction.static_ratio` may be an interval; its lower end is then prepared.

    Raises
    ------
    RecordError
        When the record of the excitation or of the normal force is invalid.
    ScenarioError
        When the window lies beyond the end of the motion, the spectra do not exist, or the case
        needs more memory or time than is available.
    UsageError
        When `scenario` is not a Scenario, or the environment names an unknown engine.
    """
    require_scenario(scenario)
    if missing := scenario.missing_values:
        sentence = (
            f"{missing[0]} has no value, as it is free in `fit`; use `drysim fit`, and then "
            "the fitted.yaml that it writes"
        )
        raise scenario.error(sentence, ("fit", "free", missing[0]))
    for i, check in enumerate(scenario.checks):
        if check.metric in FIT_NAMES:
            sentence = f"{check.metric} is known to `drysim fit` only; remove the check"
            raise scenario.error(sentence, ("checks", i))
    if not interval or statistics.max_seeds(scenario) > 1:
        refuse_interval(scenario)
    try:
        engine()
    except ValueError as fault:
        raise UsageError(str(fault)) from fault
    seeds = statistics.max_seeds(scenario)
    if shortage := shortage_message(
        f"{seeds:.4g} seeds", float(seeds) * BYTES_PER_SEED, "use fewer"
    ):
        raise scenario.error(f"excitation.seeds: {shortage}", "excitation.seeds")
    motion = base_motion(scenario)
    law = scenario.law()
    force = law.force_record.warnings if law.force_record else ()
    found = [(getattr(motion, "warnings", ()), getattr(motion, "inputs", ()))]
    records: tuple[RecordSummary, ...] = ()
    if swept and (files := swept_files(scenario)):
        read = [read_swept(scenario, files, i) for i in range(len(files))]
        found, records = [one[:2] for one in read], tuple(one[2] for one in read)
    known = (
        *scenario_warnings(scenario, motion, compared),
        *(warning for warnings, _ in found for warning in warnings),
        *force,
        *ending_warnings(scenario, motion, swept),
    )
    case = assemble(scenario, motion, tuple({one.sentence: one for one in known}.values()))
    case = replace(
        case,
        inputs=tuple(record for _, inputs in found for record in inputs),
        records=records,
    )
    check_spectra(case)
    return case


def ending_warnings(
    scenario: Scenario, motion: Sines | Samples, swept: bool
) -> Iterator[WarningMessage]:
    """Warn if the window ends before the response, in the case with the longest period."""
    if not isinstance(scenario.excitation, Record):
        return
    found: list[WarningMessage] = []
    for one in extreme_cases(scenario) if swept else (scenario,):
        with suppress(ScenarioError):  # of a window that the case itself will report
            end = window(one, motion)[1]
            found += cut_warnings(one, one.oscillator.plant(), one.law(), motion, end)
    if found:
        yield max(found, key=lambda warning: warning.numbers["period"])


def without_fit_checks(scenario: Scenario) -> Scenario:
    """Return the scenario without the checks that only a fit can judge."""
    checks = (check for check in scenario.checks if check.metric not in FIT_NAMES)
    return scenario.copy_with({"checks": tuple(checks)})


def refuse_direction(scenario: Scenario, command: str) -> None:
    """Raise a ScenarioError if the scenario is swept up or down.

    For commands that solve each case on its own.
    """
    if chain_length(scenario.sweep):
        sentence = (
            f"sweep.{DIRECTION_KEY} does not apply to `{command}`, which starts each case from "
            f"`start`; add --set sweep.{DIRECTION_KEY}=null"
        )
        raise scenario.error(sentence, (SWEEP_KEY, DIRECTION_KEY))


def refuse_interval(scenario: Scenario) -> None:
    """Raise a ScenarioError if the static ratio is an interval."""
    if scenario.static_interval:
        sentence = "an interval is for `drysim run` and `sweep` with one seed; give one value"
        raise scenario.error(f"friction.static_ratio: {sentence}", STATIC_RATIO)


def read_swept(
    scenario: Scenario, files: Sequence[str], i: int
) -> tuple[tuple[WarningMessage, ...], tuple[Input, ...], RecordSummary]:
    """Read one of the swept records, and return its warnings, inputs and summary.

    Raises
    ------
    RecordError
        When the record is invalid.
    ScenarioError
        When the record is missing, or the scenario does not suit it, such as a window beyond
        its end.
    """
    file = files[i]
    point: dict[str, Any] = {FILE_KEY: file}
    one = scenario.at(point)
    try:
        motion = base_motion(one)
    except RecordError as fault:
        assert isinstance(one.excitation, Record), "only records have files"
        problem, header = fault.problem, 1 + (one.excitation.skip or 0)
        if not one.excitation.path.exists():
            keys = (*files_location(scenario), i)
            sentence = f"{'.'.join(map(str, keys))}: {problem}"
            raise scenario.error(sentence, keys) from None
        if i == 0 or problem.line > header:  # a sample, not the columns
            raise
        sentence = (
            f"{problem.sentence}; all files are read with the same keys of "
            f"`excitation`, which suit `{files[0]}`: give this file the same columns and "
            f"units, or leave it out of {'.'.join(map(str, files_location(scenario)))}"
        )
        raise RecordError(replace(problem, sentence=sentence), fault.hint) from None
    assert isinstance(one.excitation, Record), "only records have files"
    assert isinstance(motion, Samples), "a record is sampled"
    try:
        assemble(one, motion)
    except ScenarioError as fault:
        problems = (replace(p, sentence=f"{file}: {p.sentence}") for p in fault.problems)
        raise ScenarioError(fault.message, tuple(problems)) from None
    warnings = (*motion.warnings, *ending_warnings(one, motion, swept=True))
    return warnings, motion.inputs, one.excitation.summarise(motion)


def assemble(
    scenario: Scenario, motion: Sines | Samples, warnings: tuple[WarningMessage, ...] = ()
) -> Case:
    """Return the case of a scenario with this base motion; errors as in `prepare`."""
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    assert step is not None, "a scenario has a step unless a record defines it"
    repeats = scene_period(scenario) if scenario.measure.steady else None
    plant, law, start = scenario.oscillator.plant(), scenario.law(), scenario.start.state()
    case = Case(
        scenario,
        scenario.solver.member(),
        plant,
        law,
        motion,
        start,
        step,
        window(scenario, motion) if repeats is None else (0.0, repeats),
        repeats,
        warnings,
    )
    if repeats is None:
        rest = rest_steps(scenario, (plant, law, motion, start), step, case.window[1])
        case = replace(case, rest=rest_within_normal_record(case, rest))
    check_normal_record(case)
    check_effort(case)
    return replace(case, warnings=(*warnings, *effort_warnings(case), *volume_warnings(case)))


def check_effort(case: Case) -> None:
    """Raise a ScenarioError for a case that takes too much memory or time."""
    measure = case.scenario.measure
    weighted = bool(measure.weights or measure.spectra)
    if shortage := memory_shortage(case.steps, weighted, is_streamed(case)):
        sentence = f"solver.step and measure.duration: {shortage}"
        raise case.scenario.error(sentence, "measure.duration")
    points = case.steps * case.approach.substeps(case.plant, case.law, case.step)
    if shortage := memory_shortage(points, weighted, is_streamed(case)):
        key = f"solver.{case.approach.approach}"
        raise case.scenario.error(f"{key} subdivides each step: {shortage}", key)
    check_work(case)


LENGTH_TOLERANCE = 1e-9
"""Relative tolerance in comparisons of durations, for rounding."""


def base_motion(scenario: Scenario) -> Sines | Samples:
    """Return the base motion of a scenario, after checking that its samples fit into memory.

    Raises
    ------
    ScenarioError
        When the samples do not fit.
    RecordError
        When the record is invalid.
    """
    excitation, step, measure = scenario.excitation, scenario.solver.step, scenario.measure
    end = None if measure.duration is None else measure.settle + measure.duration
    span, block = end, "measure"
    if excitation.has_own_end:
        span, block = getattr(excitation, "duration", None), "excitation"
    steps = span / step if step and span and isinstance(excitation, GeneratedMotion) else 0
    if shortage := memory_shortage(round(steps)):
        sentence = f"solver.step and {block}.duration: {shortage}"
        raise scenario.error(sentence, f"{block}.duration")
    return excitation.motion(step, end)


def window(scenario: Scenario, motion: Sines | Samples) -> tuple[float, float]:
    """Return begin and end of the metrics [s].

    Raises
    ------
    ScenarioError
        When they lie beyond the end of the base motion.
    """
    settle, duration = scenario.measure.settle, scenario.measure.duration
    if not isinstance(motion, Samples):
        assert duration is not None, "a scenario has a duration unless a record defines it"
        return settle, settle + duration
    last = (len(motion.u_dd) - 1) * motion.dt
    end = last if duration is None else settle + duration
    if settle >= last or end > last * (1.0 + LENGTH_TOLERANCE):
        key = "measure.settle" if settle >= last else "measure.duration"
        sentence = f"{key} exceeds the end of the excitation at {format_number(last, 's')}"
        raise scenario.error(sentence, key)
    return settle, min(end, last)


def check_normal_record(case: Case) -> None:
    """Raise a ScenarioError for a normal-force record that ends before the run."""
    force_record = case.law.force_record
    if force_record is None or case.window[1] <= force_record.end * (1.0 + LENGTH_TOLERANCE):
        return
    sentence = (
        f"friction.normal_record ends at {format_number(force_record.end, 's')}, before the "
        f"end of the run at {format_number(case.window[1], 's')}; use a longer record or a "
        "shorter measure.duration"
    )
    raise case.scenario.error(sentence, "friction.normal_record")


def rest_within_normal_record(case: Case, rest: int) -> int:
    """Return the steps of a ring-down that a normal-force record covers."""
    force_record = case.law.force_record
    if force_record is None:
        return rest
    return max(min(rest, int((force_record.end - case.window[1]) / case.step)), 0)


def check_spectra(case: Case) -> None:
    """Raise a ScenarioError if the requested spectra do not exist."""
    from drysim.metrics.spectra import MIN_SEGMENT_STEPS

    scenario, key = case.scenario, "measure.spectra"
    if not scenario.measure.spectra:
        return
    if not isinstance(case.motion, Samples):
        kind = scenario.excitation.kind
        sentence = f"does not apply to {kind}: spectra need random base motion or a record"
        raise scenario.error(f"{key} {sentence}", key)
    segment, length = segment_length(case), case.window[1] - case.window[0]
    minimum = MIN_SEGMENT_STEPS * case.step
    if segment < minimum * (1 - LENGTH_TOLERANCE):
        key = "measure.segment" if scenario.measure.segment else key
        sentence = (
            f"{key} needs segments of at least {format_number(minimum, 's')}, "
            f"{MIN_SEGMENT_STEPS} steps, not {format_number(segment, 's')}"
        )
        raise scenario.error(sentence, key)
    if segment > length * (1 + LENGTH_TOLERANCE):
        sentence = f"is longer than the window of {format_number(length, 's')}"
        raise scenario.error(f"measure.segment {sentence}", "measure.segment")


BANDWIDTHS_PER_RESONANCE = 3
"""Noise bandwidths of the Hann window within the half-power width of a resolved resonance."""


def segment_length(case: Case) -> float:
    """Return the length of the Welch segments [s]: the value of the scenario, or the default.

    The default is no longer than needed to resolve the resonance; a longer window then means
    more averages.
    """
    from drysim.metrics.spectra import (
        HANN_BANDWIDTH,
        MIN_SEGMENT_STEPS,
        MIN_SEGMENT_TIME,
        MIN_SEGMENTS,
        PERIODS_PER_SEGMENT,
    )

    if case.scenario.measure.segment:
        return case.scenario.measure.segment
    begin, end = case.window
    m, k_x, _ = case.plant
    enough = max(MIN_SEGMENT_TIME, MIN_SEGMENT_STEPS * case.step)
    if k_x:
        enough = max(enough, PERIODS_PER_SEGMENT * 2 * pi * sqrt(m / k_x))
    if width := resonance_width(case):
        enough = max(enough, BANDWIDTHS_PER_RESONANCE * HANN_BANDWIDTH / width)
    return min(enough, (end - begin) / MIN_SEGMENTS)


def resonance_width(case: Case) -> float:
    """Return the half-power width of the resonance [Hz]; 0 without spring or with friction."""
    m, k_x, b = case.plant
    return b / (2 * pi * m) if k_x and not case.law.F_fs else 0.0


# Whether a response fits into the memory of this machine.

BYTES_PER_STEP = 64
"""Memory per step where the complete response is stored (fixed steps) or noise is generated;
the measured maximum is 50, in the transforms of noise."""

BYTES_PER_STREAMED_STEP = 8
"""Memory per step where the response is computed part by part: only events are stored, 25 bytes
each and twice that while they are joined. One event in 24 steps took 2 bytes per step."""

BYTES_PER_WEIGHTED_STEP = 96
"""Additional memory per step for weighting or spectra; measured: 77."""

BYTES_PER_SEED = 6_000
"""Memory for the metrics of one seed; measured: 3,500, and 5,000 with the output."""

GIGA = 1e9


def memory_shortage(steps: int, weighted: bool = False, streamed: bool = False) -> str:
    """Return a message if a response of so many steps does not fit into memory, else ""."""
    required = response_memory(steps, weighted, streamed)
    return shortage_message(
        f"{steps:.4g} steps", required, "use a longer step or a shorter duration"
    )


def response_memory(steps: int, weighted: bool = False, streamed: bool = False) -> float:
    """Return the memory for a response of so many steps [bytes].

    A response that is weighted or transformed is never streamed.
    """
    if streamed and not weighted:
        return float(steps * BYTES_PER_STREAMED_STEP)
    return float(steps * (BYTES_PER_STEP + weighted * BYTES_PER_WEIGHTED_STEP))


def is_streamed(case: Case) -> bool:
    """Whether a long response of the case is computed part by part, never stored completely."""
    varies = isinstance(case.law, PiecewiseLaw) and case.law.varies
    return isinstance(case.approach, ExactApproach) and not varies


def shortage_message(what: str, required: float, remedy: str) -> str:
    """Return the message for a shortage of memory, or "" if `required` [bytes] is available."""
    available = system.total_memory()
    if required <= available:
        return ""
    return (
        f"{what} need {required / GIGA:.3g} GB of memory, this machine has "
        f"{available / GIGA:.3g} GB; {remedy}"
    )


# Estimated work: steps of the event search are at most about a radian of each oscillation.

SLOW_SCENE = "slow-scene"
"""Slug of the warning, which is also shown before the work begins."""

MAX_RADIANS_PER_STEP = 30.0
"""Phase per step [rad] above which a step takes 100 times longer than usual. Measured: 30 ns
for a sampled step with its metrics, 1 µs for a step under sines, 0.1 to 0.5 µs per radian."""

SECONDS_PER_RADIAN = 5e-7
"""Longest time per radian, or per decay time of a velocity in a series, compiled [s]."""

SECONDS_PER_SERIES_RADIAN = 1.5e-4
"""Longest time per radian for Taylor series with bristle states [s]."""

SECONDS_PER_BRISTLE_DECAY = 3e-5
"""Time per step of such a series, about one step per decay time of a strong damper [s]."""

MAX_RADIANS = 1e10
"""Largest phase of a case [rad]: more than an hour of work, beyond double precision."""

DAMPER = "damping time constants"
BRISTLE_DAMPER = "damping time constants of the bristles"
"""Names of dampers in messages; their work is counted in decay times instead of radians."""

RINGDOWN_RADIANS = 40.0
"""A free oscillation with damping ratio ξ decays below double precision within 40/ξ rad."""


class Oscillation(NamedTuple):
    """Phase that an oscillation or a decay runs through within the window of a case."""

    key: str
    """Scenario key that causes it."""
    name: str
    radians: float
    """Phase [rad], or number of decay times of a damper."""
    minimum: float
    """Lower bound of the work, in units of `SECONDS_PER_RADIAN`; a damped oscillation decays
    before its full phase."""
    each: float = SECONDS_PER_RADIAN
    """Longest time per radian or decay time [s]."""

    def describe(self, radians: float) -> str:
        """Describe so many radians, or decay times of a damper, in words."""
        if self.name in (DAMPER, BRISTLE_DAMPER):
            return f"{format_number(radians)} {self.name}"
        return f"{format_number(radians)} rad of the {self.name}"


def largest_oscillation(case: Case) -> Oscillation:
    """Return the oscillation with the largest phase within the window of a case."""
    return max(
        _oscillations(case), key=lambda one: one.radians, default=Oscillation("", "", 0.0, 0.0)
    )


def _oscillations(case: Case) -> Iterator[Oscillation]:
    """Yield excitation, normal force, and the springs and dampers if the mass may move."""
    if not isinstance(case.approach, ExactApproach):
        return  # fixed steps do not resolve oscillations
    span, fastest, law = case.window[1], inf, case.law
    if isinstance(case.motion, Sines):
        fastest = max(case.motion.f, default=0.0)
        radians = 2.0 * pi * fastest * span
        yield Oscillation("excitation", "base motion", radians, radians)
    if not (isinstance(law, DynamicLaw) or law.is_elastic) and law.variation:
        fastest = max(fastest, law.omega / (2.0 * pi))
        radians = law.omega * span
        yield Oscillation("friction.normal_variation", "normal force", radians, radians)
    m, k_x, b = case.plant
    kicks = 2.0 * (fastest * span + 1.0)
    moves = all(one.slug != "will-not-move" for one in case.warnings)
    if isinstance(law, DynamicLaw) and moves:
        decays = b / m * span
        yield Oscillation("oscillator.damping", DAMPER, decays, decays)
    if k_x > 0.0 and moves:
        key = f"oscillator.{case.scenario.oscillator.spring_key}"
        yield _free_oscillation(key, "oscillator", case.plant, span, kicks)
    if isinstance(law, DynamicLaw) and law.sigma_0:
        plant, name = (m, law.sigma_0, b + law.sigma_1), "oscillation on the bristles"
        rings = _free_oscillation("friction.bristle_stiffness", name, plant, span, kicks)
        yield rings._replace(each=SECONDS_PER_SERIES_RADIAN)
        decays = law.sigma_1 / m * span
        minimum = decays * SECONDS_PER_BRISTLE_DECAY / SECONDS_PER_RADIAN
        yield Oscillation(
            "friction.bristle_damping",
            BRISTLE_DAMPER,
            decays,
            minimum,
            SECONDS_PER_BRISTLE_DECAY,
        )
    if isinstance(law, PiecewiseLaw) and law.is_elastic:
        name = "oscillation on the contact"
        yield _free_oscillation(
            "friction.tangential_stiffness", name, (m, law.k_t, b), span, kicks
        )


def _free_oscillation(
    key: str, name: str, plant: tuple[float, float, float], span: float, kicks: float
) -> Oscillation:
    """Return the phase of a free oscillation that is excited `kicks` times in a span [s]."""
    m, k, b = plant
    radians, xi = sqrt(k / m) * span, 0.5 * b / sqrt(k * m)
    return Oscillation(
        key, name, radians, min(radians, kicks * RINGDOWN_RADIANS / xi) if xi else radians
    )


def check_work(case: Case) -> None:
    """Raise a ScenarioError for a case that takes more than `MAX_RADIANS`."""
    most = max(_oscillations(case), key=lambda one: one.minimum, default=None)
    if most is None or most.minimum <= MAX_RADIANS:
        return
    hours = format_number(most.minimum * SECONDS_PER_RADIAN / 3600.0, "h", digits=2)
    sentence = (
        f"{most.key}: {format_number(case.window[1], 's')} span "
        f"{most.describe(min(most.minimum, most.radians))}, up to {hours} of work; "
        "check the units, or use a shorter duration"
    )
    raise case.scenario.error(sentence, most.key)


def effort_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn when a step takes 100 times longer than usual."""
    most = largest_oscillation(case)
    each = most.radians / max(case.steps, 1)
    if each > MAX_RADIANS_PER_STEP:
        time = format_number(most.radians * most.each, "s", digits=2)
        whole = f"up to {time} in total"
        if case.period is not None:
            whole = f"up to {time} per period, and the orbit may take many periods"
        sentence = (
            f"one step spans {most.describe(each)}; this may take 100 times longer than usual, "
            f"{whole}"
        )
        numbers = {"radians": most.radians, "radians_a_step": each}
        yield WarningMessage(SLOW_SCENE, sentence, numbers)


# Estimated size of the output.

LARGE_RESPONSE = "large-response"
"""Slug of the warning, which is also shown before the work begins."""

BYTES_PER_ROW = 100
"""Typical bytes per row of response.csv."""

MIN_BYTES_SHARE = 0.4
"""Share of these bytes that is certain: rows are this short while the mass is at rest."""

LARGE_RESPONSE_BYTES = 1e9
"""Size of response.csv from which the warning is shown [bytes]."""


def response_bytes(case: Case) -> float:
    """Return the estimated size of response.csv [bytes]."""
    return float(BYTES_PER_ROW * (case.steps + 1))


def volume_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn when the response of a run is large; a sweep writes none."""
    volume = response_bytes(case)
    if volume > LARGE_RESPONSE_BYTES and not case.scenario.sweep:
        sentence = (
            f"response.csv will have {case.steps + 1:.3g} rows, about {volume / GIGA:.3g} GB; "
            f"use a step longer than {format_number(case.step, 's')} or a shorter duration"
        )
        yield WarningMessage(
            LARGE_RESPONSE, sentence, {"rows": case.steps + 1, "bytes": volume}
        )
