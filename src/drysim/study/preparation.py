"""From a scenario to a case that is ready to be solved.

`prepare` reads the record and checks what only the complete case shows: the window lies within
the motion, the requested spectra exist, the response fits into memory, and the work takes less
than about an hour. `assemble` does the same for a known base motion: a case of a sweep, or a
seed of an ensemble.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

from drysim.core.compile import engine
from drysim.core.model import Input, RecordSummary, Samples, Sines
from drysim.errors import RecordError, ScenarioError, UsageError, WarningMessage
from drysim.excitation.base import GeneratedMotion
from drysim.excitation.recorded import Record
from drysim.messages import shorten
from drysim.metrics.table import FIT_NAMES
from drysim.scenario.axes import DIRECTION_KEY, FILE_KEY, SWEEP_KEY, chain_length
from drysim.scenario.files import drawn_inputs, files_location, named_files, swept_files
from drysim.scenario.model import STATIC_RATIO, Scenario, scene_period
from drysim.scenario.validation import spoken_name
from drysim.scenario.warnings import extreme_cases, scenario_warnings
from drysim.study import statistics
from drysim.study.budget import (
    BYTES_PER_SEED,
    check_effort,
    effort_warnings,
    memory_shortage,
    shortage_message,
    volume_warnings,
)
from drysim.study.case import LENGTH_TOLERANCE, Case
from drysim.study.ring_down import cut_warnings, rest_steps
from drysim.study.welch import check_spectra
from drysim.wording import format_distinct, format_number, join_words


def require_scenario(scenario: Scenario) -> None:
    """Raise a UsageError for anything but a scenario."""
    if not isinstance(scenario, Scenario):
        given = shorten(repr(scenario))
        raise UsageError(
            f"expected a scenario, not {given}",
            "drysim.load reads one from a file, drysim.scenario one from a mapping or text",
        )


def require_blocks(scenario: Scenario) -> None:
    """Raise a ScenarioError if a block is missing, as `drysim assess` alone allows."""
    if missing := scenario.missing_blocks:
        sentence = f"required by all commands but `drysim assess`: {join_words(missing)}"
        raise scenario.error(sentence, missing[0])


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
    require_blocks(scenario)
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
    with locating_records(scenario):
        motion = base_motion(scenario)
        law = scenario.law()
    force = law.force_record.warnings if law.force_record else ()
    sources = [(getattr(motion, "warnings", ()), getattr(motion, "inputs", ()))]
    records: tuple[RecordSummary, ...] = ()
    if swept and (files := swept_files(scenario)):
        read = [read_swept(scenario, files, i) for i in range(len(files))]
        sources, records = [record[:2] for record in read], tuple(record[2] for record in read)
    warnings = (
        *scenario_warnings(scenario, motion, compared, swept),
        *(warning for warnings, _ in sources for warning in warnings),
        *force,
        *ending_warnings(scenario, motion, swept),
    )
    case = assemble(
        scenario, motion, tuple({warning.sentence: warning for warning in warnings}.values())
    )
    case = replace(
        case,
        inputs=(
            *(record for _, inputs in sources for record in inputs),
            *(drawn_inputs(scenario) if swept else ()),
        ),
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
    cuts: list[WarningMessage] = []
    for case in extreme_cases(scenario) if swept else (scenario,):
        with suppress(ScenarioError):  # of a window that the case itself will report
            end = window(case, motion)[1]
            cuts += cut_warnings(case, case.oscillator.plant(), case.law(), motion, end)
    if cuts:
        yield max(cuts, key=lambda warning: warning.numbers["period"])


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


@contextmanager
def locating_records(scenario: Scenario) -> Iterator[None]:
    """Add to a fault of a record where the scenario names it; if it is missing, only that."""
    try:
        yield
    except RecordError as fault:
        for keys, path in named_files(scenario):
            if str(path) == fault.problem.file:
                problem = scenario.problem(f"{spoken_name(keys)}: {fault.problem}", keys)
                if path.exists() and problem.file:
                    problem = replace(fault.problem, named_at=problem)
                elif path.exists():
                    raise
                raise RecordError(problem, fault.hint) from None
        raise


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
    single = scenario.at(point)
    try:
        motion = base_motion(single)
    except RecordError as fault:
        assert isinstance(single.excitation, Record), "only records have files"
        problem, header = fault.problem, 1 + (single.excitation.skip or 0)
        if not single.excitation.path.exists():
            keys = (*files_location(scenario), i)
            sentence = f"{spoken_name(keys)}: {problem}"
            raise scenario.error(sentence, keys) from None
        if i == 0 or problem.line > header:  # a sample, not the columns
            raise
        sentence = (
            f"{problem.sentence}; all files are read with the same keys of "
            f"`excitation`, which suit `{files[0]}`: give this file the same columns and "
            f"units, or leave it out of {'.'.join(map(str, files_location(scenario)))}"
        )
        raise RecordError(replace(problem, sentence=sentence), fault.hint) from None
    assert isinstance(single.excitation, Record), "only records have files"
    assert isinstance(motion, Samples), "a record is sampled"
    try:
        assemble(single, motion)
    except ScenarioError as fault:
        problems = (replace(p, sentence=f"{file}: {p.sentence}") for p in fault.problems)
        raise ScenarioError(fault.message, tuple(problems)) from None
    warnings = (*motion.warnings, *ending_warnings(single, motion, swept=True))
    return warnings, motion.inputs, single.excitation.summarise(motion)


def assemble(
    scenario: Scenario, motion: Sines | Samples, warnings: tuple[WarningMessage, ...] = ()
) -> Case:
    """Return the case of a scenario with this base motion; errors as in `prepare`."""
    step = motion.dt if isinstance(motion, Samples) else scenario.step
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
    record_end, run_end = format_distinct([force_record.end, case.window[1]])
    sentence = (
        f"friction.normal_record ends at {record_end} s, before the end of the run at "
        f"{run_end} s; use a longer record or a shorter measure.duration"
    )
    raise case.scenario.error(sentence, "friction.normal_record")


def rest_within_normal_record(case: Case, rest: int) -> int:
    """Return the steps of a ring-down that a normal-force record covers."""
    force_record = case.law.force_record
    if force_record is None:
        return rest
    return max(min(rest, int((force_record.end - case.window[1]) / case.step)), 0)
