"""Evaluation of measured records of base and mass, beside the model where there is one.

The channels are read and placed on one time axis as for a fit, and the metrics are those of the
table, evaluated on the samples. Several runs of a test give a mean, a spread and a verdict on
whether they agree; the axes of a seat give the daily exposure of directive 2002/44/EC.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import ceil, floor
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np

from drysim.core.compile import choose_engine
from drysim.core.model import Floats, Input, Plant, Samples
from drysim.errors import UsageError, WarningMessage
from drysim.excitation.recorded import Record
from drysim.metrics.checks import MEAN, Verdict
from drysim.metrics.comfort import EXPOSURE_LIMITS, STEP_TOLERANCE, Complexes
from drysim.metrics.spectra import (
    Spectra,
    TransferEstimate,
    combined_estimate,
    is_same_signal,
    spectra,
    transfer_estimate,
)
from drysim.metrics.table import (
    OF_STROKE,
    PEAK_STROKE,
    STROKE_USED,
    Values,
    evaluate,
    evaluate_samples,
)
from drysim.records.clean import missing_low_pass
from drysim.records.columns import record_error
from drysim.scenario.assess import AXES, Assess, MeasuredRuns
from drysim.scenario.model import Scenario
from drysim.scenario.text import describe_limits
from drysim.scenario.warnings import cannot_hold_warning, lacking_need, weighting_warnings
from drysim.study.assess_faults import fault_warning
from drysim.study.budget import case_cost
from drysim.study.case import Case
from drysim.study.fit_model import (
    GRID_TOLERANCE,
    Measurement,
    as_base_motion,
    check_columns,
    read_measurement,
)
from drysim.study.outcome import Result, count_verdicts, format_repr
from drysim.study.preparation import (
    assemble,
    base_motion,
    locating_records,
    refuse_interval,
    require_scenario,
    without_fit_checks,
)
from drysim.study.run import (
    march_from_start,
    observe_window,
    spectra_warnings,
    trajectory_of_response,
    weighted_motion,
)
from drysim.study.statistics import NORMAL_95, student_t
from drysim.study.table import STROKE_LIMIT, largest_excess
from drysim.study.welch import check_segment, segment_length
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_percent,
    join_words,
    sanitise,
)

AGREEING = {True: ("SEAT", "a_w"), False: ("T_a", "a_x")}
"""Metrics in which runs must agree, with and without a weighting."""

INTERPOLATED = "record-interpolated"
"""Warning that lines between the samples of a base lose some of its RMS."""

OF_THE_DAY = ("A_8", "VDV_day")
"""Metrics of which the largest of all axes counts."""


CleanUp = tuple[tuple[str, Mapping[str, object]], ...]
"""Name of a channel of a run, and a step of its clean-up as stored in drysim.json."""


class Run(NamedTuple):
    """One record along one axis."""

    file: str
    axis: str
    """`x`, `y` or `z`; empty where no direction is stated."""
    dt: float
    """Step of the samples [s]."""
    length: float
    """Length of the window [s]."""
    metrics: Values
    """Measured metrics by name, in SI units; None where unknown."""
    transfer: TransferEstimate | None = None
    """Measured spectra and transmissibility; None without a base."""
    model: Values | None = None
    """The same metrics of the model on the measured base; None without a model."""
    model_spectra: Spectra | None = None
    repeats: str = ""
    """File of an earlier run whose base is the same signal; empty if there is none."""
    clean_up: CleanUp = ()


class Exposure(NamedTuple):
    """Hours a day until the limits of directive 2002/44/EC are reached, along one axis."""

    axis: str
    a_w: float
    VDV: float | None
    """Means over the runs [m/s²], [m/s^1.75], times k; VDV is None if their lengths differ."""
    hours: dict[str, tuple[float, float]]
    """Name of each limit: hours until A(8), and until the dose, reaches it; infinite for
    never."""


@dataclass(frozen=True, eq=False, repr=False)
class AssessResult(Result):
    """What was measured on base and mass, beside the model.

    Attributes
    ----------
    scenario : Scenario
        With its assess block.
    motion : Samples
        Measured base motion of the first run.
    inputs : tuple of Input
        The records.
    runs : tuple of Run
        The runs along the axis of `measured`.
    others : tuple of Run
        The runs along other axes.
    metrics : dict
        Means of the measured metrics over the runs, by name, of peaks the largest; `A_8` and
        `VDV_day` are each the largest of all axes. VDV is None if the runs differ in length.
    model : dict or None
        The same of the metrics of the model.
    exposures : tuple of Exposure
        One for each axis, the one with the highest a_w first; empty without a direction.
    checks : tuple of Verdict
        Verdicts on the measured metrics.
    warnings : tuple of WarningMessage
    """

    kind: ClassVar[str] = "assess"

    scenario: Scenario
    motion: Samples = field(compare=False)
    inputs: tuple[Input, ...]
    runs: tuple[Run, ...]
    others: tuple[Run, ...]
    metrics: Values
    model: Values | None
    exposures: tuple[Exposure, ...]
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()

    @property
    def agree_within(self) -> float:
        """Share of their mean within which the runs must agree [-]."""
        return assess_of(self.scenario).agree_within

    @property
    def transfer(self) -> TransferEstimate:
        """Transmissibility from all runs along the axis of `measured`."""
        runs = [(run.transfer, not run.repeats) for run in self.runs if run.transfer]
        transfers, are_independent = zip(*runs, strict=True)
        return combined_estimate(transfers, are_independent)

    @property
    def model_H1(self) -> Complexes | None:
        """Transmissibility H1 of the model at the same lines [-], shape (n,), or None.

        Of several runs the mean of H1, weighted by the number of segments and the PSD of the
        base; NaN at lines at which the base of the model does not move.
        """
        models = [run.model_spectra for run in self.runs if run.model_spectra is not None]
        if not models:
            return None
        power = sum(model.segments * model.G_u for model in models)
        cross = sum(
            model.segments * np.where(model.G_u > 0.0, model.G_u * model.H1, 0.0)
            for model in models
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            H1 = np.asarray(cross / power, dtype=np.complex128)
        return H1[: len(self.transfer.f)]  # a base of velocity has half the step, more lines

    def deviation(self, name: str) -> float | None:
        """Return the largest relative deviation of a run from the mean of a metric [-].

        None where the mean is unknown.
        """
        if self.metrics[name] is None:
            return None
        return largest_deviation([run.metrics[name] for run in self.runs])

    def __repr__(self) -> str:
        """Return the number of runs, key metrics and verdicts in one line."""
        name, (ratio, level) = self.scenario.name, AGREEING[self.metrics["a_w"] is not None]
        numbers = ", ".join(
            f"{key} {format_number(value, digits=4)}"
            for key in (ratio, level)
            if (value := self.metrics[key]) is not None
        )
        verdicts = count_verdicts(self.checks, self.warnings)
        return format_repr(
            "AssessResult", name, format_count(len(self.runs), "run"), numbers, verdicts
        )


def assess(scenario: Scenario) -> AssessResult:
    """Evaluate what was measured on base and mass.

    Parameters
    ----------
    scenario : Scenario
        With an assess block. If it states an oscillator, its motion on the measured base is
        computed as well.

    Returns
    -------
    AssessResult

    Raises
    ------
    RecordError
        If a record cannot be used.
    ScenarioError
        If the window or the segments do not suit the records.
    UsageError
        If the scenario has no assess block.
    """
    prepared, other_prepared = prepare_runs(scenario)
    segment = segment_of(prepared)
    runs = tuple(
        evaluate_run(run, segment)._replace(repeats=earlier_run(run, prepared[:i]))
        for i, run in enumerate(prepared)
    )
    others = tuple(evaluate_run(run, segment) for run in other_prepared)
    all_prepared, all_runs = [*prepared, *other_prepared], [*runs, *others]
    exposures = daily_exposures(scenario, all_runs)
    metrics = combine(runs)
    by_axis = [
        combine([run for run in others if run.axis == axis])
        for axis in dict.fromkeys(run.axis for run in others)
    ]
    for name in OF_THE_DAY:
        values = [each[name] for each in (metrics, *by_axis)]
        metrics[name] = max((value for value in values if value is not None), default=None)
    modelled = [run._replace(metrics=run.model) for run in runs if run.model is not None]
    warnings = [
        *records_warnings(all_prepared, segment),
        *agreement_warnings(scenario, runs),
        *stroke_warnings(scenario, metrics),
        *check_warnings(scenario),
    ]
    inputs = [record for run in all_prepared for record in run.inputs]
    return AssessResult(
        scenario=scenario,
        motion=prepared[0].motion,
        inputs=tuple({record.file: record for record in inputs}.values()),
        runs=runs,
        others=others,
        metrics=metrics,
        model=combine(modelled) if modelled else None,
        exposures=exposures,
        checks=tuple(
            explained(check.judge(metrics), scenario)
            for check in without_fit_checks(scenario).checks
        ),
        warnings=tuple({warning.sentence: warning for warning in warnings}.values()),
    )


def explained(verdict: Verdict, scenario: Scenario) -> Verdict:
    """Return a verdict that names the stroke as not measured where its metric needs it."""
    is_measured = assess_of(scenario).measured.x_r is not None
    if is_measured or verdict.value is not None or verdict.check.metric not in OF_STROKE:
        return verdict
    return replace(verdict, reason=f"{verdict.reason}: no x_r is measured")


def require_assess(scenario: Scenario) -> None:
    """Raise a UsageError for anything but a scenario with an assess block."""
    require_scenario(scenario)
    refuse_interval(scenario)
    if scenario.assess is None:
        raise UsageError(
            f"{scenario.name} has no assess block",
            "`drysim manual assess` shows how to write one",
        )


def assess_of(scenario: Scenario) -> Assess:
    """Return the assess block of a scenario that has one."""
    assert scenario.assess is not None, "only a scenario with an assess block is assessed"
    return scenario.assess


def require_bases(scenario: Scenario) -> None:
    """Raise a ScenarioError unless each file of the runs has a base."""
    measured, excitation = assess_of(scenario).measured, scenario.excitation
    if measured.u_dd is not None:
        return
    key = "assess.measured.u_dd"
    if not isinstance(excitation, Record) or "excitation" in scenario.missing_blocks:
        sentence = f"{key} is required, the base, unless `excitation` is its record"
        raise scenario.error(sentence, "assess.measured")
    if measured.more_files and excitation.path != measured.path:
        sentence = (
            f"{key} is required with `more_files`: each file has its own base; of two loggers "
            "put base and mass of each run into one file, or assess each run by itself"
        )
        raise scenario.error(sentence, "assess.measured.more_files")


def base_file(scenario: Scenario) -> str:
    """Return the file of the base where it is not that of the mass; else empty."""
    measured, excitation = assess_of(scenario).measured, scenario.excitation
    if measured.u_dd is not None or not isinstance(excitation, Record):
        return ""
    return "" if excitation.path == measured.path else shown_name(excitation.file)


def shown_name(file: str) -> str:
    """Return a file as its scenario names it, an absolute one without its folder."""
    return Path(file).name if Path(file).is_absolute() else file


def prepare_runs(scenario: Scenario) -> tuple[list[PreparedRun], list[PreparedRun]]:
    """Read all records: along the axis of `measured`, and along other axes.

    Raises
    ------
    RecordError, ScenarioError, UsageError
        As `assess` does.
    """
    require_assess(scenario)
    require_bases(scenario)
    block = assess_of(scenario)
    files, names = block.measured.files, block.axis_names
    with locating_records(scenario):
        runs = [prepare_run(scenario, "", file) for file in files]
        others = [prepare_run(scenario, axis, file) for axis in names for file in files]
        check_columns(scenario, block.channels, has_base=block.measured.u_dd is None)
    first, *rest = [run.measurement for run in runs]
    for run, measurement in zip(runs[1:], rest, strict=True):
        if abs(measurement.dt / first.dt - 1.0) > GRID_TOLERANCE:
            step = format_number(first.dt, "s", 9)
            sentence = (
                f"its step is {format_number(measurement.dt, 's', 9)}, that of {files[0]} "
                f"{step}; add `resample: {{step: {step}, by: spline}}` to assess.measured"
            )
            raise record_error(run.file, sentence)
    return runs, others


def segment_of(runs: Sequence[PreparedRun]) -> float:
    """Return the length of the segments of the spectra of several runs [s].

    The measured spectra do not depend on a model: its resonance does not count.
    """
    cases = (replace(run.case, plant=Plant(1.0, 0.0, 0.0)) for run in runs)
    return min(map(segment_length, cases))


def describe_clean_ups(runs: Sequence[Run] | Sequence[PreparedRun]) -> list[str]:
    """Return what was done to each channel of all runs.

    Of several files a step is that of the first that has it; filled gaps are those of each.
    """
    files, axes = ({getattr(run, name) for run in runs} for name in ("file", "axis"))
    sentences: dict[tuple[str, ...], list[str]] = {}
    for run in runs:
        for channel, step in run.clean_up:
            label = channel + f" along {run.axis}" * (len(axes) > 1)
            named = label + f" of {run.file}" * (len(files) > 1)
            key = (label, str(step["step"]), run.file * (step["step"] == "gaps"))
            sentences.setdefault(key, []).append(sanitise(f"{named}: {step['sentence']}"))
    return [
        first + f"; {format_count(len(more), 'more file')} likewise" * bool(more)
        for first, *more in sentences.values()
    ]


# One run


class PreparedRun(NamedTuple):
    """A record along one axis, ready to be evaluated."""

    axis: str
    file: str
    case: Case
    """The model on the measured base; of a scenario without one, a placeholder."""
    motion: Samples
    """The measured base; without one only its times count."""
    measurement: Measurement
    u_dd: Floats | None
    """Base acceleration at the measured instants [m/s²], shape (n,); None if not measured."""
    part: slice
    """Measured samples in the window."""
    has_model: bool
    """Whether there is a model; it moves along the axis of `measured` only."""

    @property
    def name(self) -> str:
        """File, and axis if there is one."""
        return f"{self.file} along {self.axis}" if self.axis else self.file

    @property
    def inputs(self) -> tuple[Input, ...]:
        """The records that were read."""
        return (*self.motion.inputs, *self.measurement.inputs)

    @property
    def clean_up(self) -> CleanUp:
        """What was done to the base and to the channels before they were used."""
        of_base = () if self.u_dd is None else self.motion.realised.get("clean_up", ())
        assert isinstance(of_base, list | tuple), "reports of the steps"
        of_mass = ((name, report.to_dict()) for name, report in self.measurement.clean_up)
        return (*(("u_dd", step) for step in of_base), *of_mass)

    def transfer_to(self, channel: str, segment: float) -> TransferEstimate | None:
        """Return the estimate from the base to a channel, by segments of a length [s].

        None if the base or the channel is not measured.
        """
        values, part = self.measurement.channels.get(channel), self.part
        if self.u_dd is None or values is None:
            return None
        return transfer_estimate(self.u_dd[part], values[part], self.measurement.dt, segment)


def prepare_run(scenario: Scenario, axis: str, file: str) -> PreparedRun:
    """Read a record along an axis.

    Parameters
    ----------
    scenario : Scenario
        With an assess block.
    axis : str
        `x`, `y` or `z` of `assess.axes`; empty for the axis of `measured`.
    file : str

    Raises
    ------
    RecordError
        If the record cannot be used.
    ScenarioError
        If window or segments do not suit it.
    """
    block, measure = assess_of(scenario), scenario.measure
    measured = (block.along(axis) if axis else block.measured).of_file(file)
    main_axis = next((name for name, along in AXES.items() if along == measure.direction), "")
    if axis and main_axis in ("", axis):
        sentence = f"assess.axes.{axis} is the axis of `measured` already"
        if not main_axis:
            sentence = "assess.axes requires measure.direction, that of `measured`"
        raise scenario.error(sentence, ("assess", "axes", axis))
    if axis:
        measure = measure.model_copy(update={"direction": AXES[axis], "weighting": None})
    has_base = measured.u_dd is not None or not axis
    if measured.u_dd is not None or axis:
        name = "u_dd" if measured.u_dd is not None else "x_dd"  # gives the times only
        base = as_base_motion(measured.record(name), {"gravity": "refuse"})
    else:
        assert isinstance(scenario.excitation, Record), "`require_bases` has checked it"
        base = scenario.excitation
        base = base.with_file(file) if block.measured.more_files else base
    source = scenario.copy_with(
        {
            "excitation": base,
            "measure": measure.model_copy(update={"steady": False}),
            "solver": scenario.solver.model_copy(update={"step": None}),
        }
    )
    motion = base_motion(source)
    assert isinstance(motion, Samples), "a record is sampled"
    if has_base and float(np.ptp(motion.u_dd[:])) == 0.0:
        sentence = "the base is the same in every sample: no motion was recorded"
        raise record_error(str(base.path), sentence)
    measurement = read_measurement(source, measured.model_copy(update={"u_dd": None}), motion)
    check_steps(measured, base, measurement)
    if has_base:
        warnings = measurement.warnings, filter_warnings(measured, base)
        measurement = measurement._replace(warnings=(*chain(*warnings),))
    case = assemble(source, motion)
    t, dt = measurement.t, measurement.dt
    begin, end = max(case.window[0], float(t[0])), min(case.window[1], float(t[-1]))
    if warning := window_warning(case.window, (begin, end)):
        measurement = measurement._replace(warnings=(*measurement.warnings, warning))
    case = replace(case, window=(begin, end), rest=0)
    check_segment(case)
    first = ceil((begin - float(t[0])) / dt - STEP_TOLERANCE)
    last = floor((end - float(t[0])) / dt + STEP_TOLERANCE)
    # A sample stands for the step after it, which a window that ends before the record lacks.
    beyond = last if last < len(t) - 1 else len(t)
    lag = round(measured.delay / motion.dt)
    places = measurement.first - lag + measurement.stride * np.arange(len(t))
    u_dd = motion.u_dd[:][np.clip(places, 0, len(motion.u_dd) - 1)] if has_base else None
    missing = {*scenario.missing_blocks, *scenario.missing_values} - {"excitation"}
    return PreparedRun(
        axis=axis or main_axis,
        file=shown_name(file),
        case=case,
        motion=motion,
        measurement=measurement,
        u_dd=u_dd,
        part=slice(first, beyond),
        has_model=not (axis or missing),
    )


def window_warning(
    stated: tuple[float, float], covered: tuple[float, float]
) -> WarningMessage | None:
    """Warn of a window of the base [s] of which the mass covers a part only."""
    length, used = (end - begin for begin, end in (stated, covered))
    if used >= 0.98 * length:
        return None
    sentence = (
        f"the mass is measured in {format_number(used, 's')} of the window of "
        f"{format_number(length, 's')} of the base; the rest is not used"
    )
    return WarningMessage("measurement-cut", sentence, {"used": used, "window": length})


def earlier_run(prepared: PreparedRun, before: Sequence[PreparedRun]) -> str:
    """Return the file of the first run before whose base is the same signal; empty if none.

    A simulator repeats its signal, and the mass what friction makes of it: such a run tells no
    more of the scatter, however often it is repeated.
    """
    for run in before:
        if prepared.u_dd is None or run.u_dd is None:
            continue
        if is_same_signal(prepared.u_dd[prepared.part], run.u_dd[run.part]):
            return run.file
    return ""


def check_steps(measured: MeasuredRuns, base: Record, measurement: Measurement) -> None:
    """Raise a RecordError if the base has more samples than the mass."""
    per_sample = 2 if base.quantity == "velocity" else 1  # whose motion has half its step
    if measurement.stride > per_sample:
        step = format_number(measurement.dt, "s", 9)
        finer = format_number(per_sample * measurement.dt / measurement.stride, "s", 9)
        sentence = (
            f"the base has a step of {finer}, the mass {step}; an assessment needs the same: "
            f"add `resample: {{step: {step}, by: spline}}` to {base.block}"
        )
        if low_pass := missing_low_pass(measurement.dt, base.remove):
            sentence += f", and the low-pass {low_pass} to both {base.block} and `x_dd`"
        raise record_error(str(measured.path), sentence)


def filter_warnings(measured: MeasuredRuns, base: Record) -> Iterator[WarningMessage]:
    """Warn of filters that base and mass do not have in common."""
    mass = measured.record("x_dd")
    filters = [each.remove.model_copy(update={"trend": "nothing"}) for each in (base, mass)]
    of_base, of_mass = (each.yaml_with() if each.has_filters else "nothing" for each in filters)
    if of_base == of_mass:
        return
    sentence = (
        "base and mass are filtered differently, which changes their ratios, SEAT, T_a and H1: "
        f"{base.block} has {of_base}, {mass.block} {of_mass}; give both the same `remove`"
    )
    if filters[0].has_filters and mass.column is not None:
        sentence += f", `x_dd: {{column: {mass.column}, {of_base.strip('`')}}}`"
    yield WarningMessage("filters-differ", sentence)


def evaluate_run(prepared: PreparedRun, segment: float) -> Run:
    """Evaluate a record, and the model on its base.

    Parameters
    ----------
    prepared : PreparedRun
    segment : float
        Length of the segments of the spectra [s].
    """
    case, channels, dt = prepared.case, prepared.measurement.channels, prepared.measurement.dt
    x_dd, settings = channels["x_dd"], case.scenario.measure
    metrics = evaluate_samples(
        x_dd, prepared.u_dd, channels.get("x_r"), dt, prepared.part, case.limits, settings
    )
    length, transfer = len(x_dd[prepared.part]) * dt, prepared.transfer_to("x_dd", segment)
    measured = Run(prepared.file, prepared.axis, dt, length, metrics, transfer)
    measured = measured._replace(clean_up=prepared.clean_up)
    if not prepared.has_model:
        return measured
    choose_engine(case_cost(case), case.kernels)
    response = march_from_start(case)[0]
    weighted = weighted_motion(case, response, case.window)
    observed = observe_window(
        case, trajectory_of_response(response), case.window, None, weighted
    )
    lines = segment if transfer is None else transfer.segment  # a whole number of samples
    return measured._replace(
        model=evaluate(observed), model_spectra=spectra(response, case.window, lines)
    )


LARGEST = (PEAK_STROKE, "x_r_max", STROKE_USED, "stroke_suffices", "x_dd_peak", "MTVV")
"""Metrics of which the largest value of several runs counts, not the mean."""


def combine(runs: Sequence[Run]) -> Values:
    """Return the mean of each metric over runs, of peaks the largest; None where unknown.

    A dose grows with the length of the run: VDV is unknown of runs whose lengths differ by more
    than a sample. VDV_day is that of all runs one after the other.
    """
    combined: Values = {}
    lengths = np.array([run.length for run in runs])
    for name in runs[0].metrics:
        values = [value for run in runs if (value := run.metrics[name]) is not None]
        how = np.max if name in LARGEST else np.min if name == "x_r_min" else np.mean
        combined[name] = float(how(values)) if len(values) == len(runs) else None
        if name == "VDV_day" and combined[name] is not None:
            fourth_power = np.average(np.array(values) ** 4, weights=lengths)
            combined[name] = float(fourth_power**0.25)
    if np.ptp(lengths) > runs[0].dt * (1.0 + STEP_TOLERANCE):
        combined["VDV"] = None
    return combined


def largest_deviation(values: Sequence[float | None]) -> float | None:
    """Return the largest relative deviation from the mean [-]; None where it is unknown."""
    numbers = np.array([value for value in values if value is not None])
    if len(numbers) < max(len(values), 2) or not numbers.mean():
        return None
    return float(np.abs(numbers / numbers.mean() - 1.0).max())


def daily_exposures(scenario: Scenario, runs: Sequence[Run]) -> tuple[Exposure, ...]:
    """Return the exposure along each axis, the one with the highest a_w first.

    Empty without a direction of the scenario, as a_w is then unknown.
    """
    if scenario.measure.direction is None:
        return ()
    exposures = []
    for axis in dict.fromkeys(run.axis for run in runs):
        same = [run for run in runs if run.axis == axis]
        combined = combine(same)
        a_w, doses = combined["a_w"], [run.metrics["VDV"] for run in same]
        assert a_w is not None, "a direction has a weighting"
        total = sum(dose**4 for dose in doses if dose is not None) ** 0.25
        length = sum(run.length for run in same)
        hours = {limit.name: limit.hours(a_w, total, length) for limit in EXPOSURE_LIMITS}
        exposures.append(Exposure(axis, a_w, combined["VDV"], hours))
    return tuple(sorted(exposures, key=lambda each: -each.a_w))


# Confidence of the transmissibility


def band_of_H1(transfer: TransferEstimate) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % confidence interval of |H1| [-], each of shape (n,).

    Notes
    -----
    |H1| (1 ± t √((1 - γ²)/(γ² 2 (n - 1)))), with n independent averages and Student's t of
    2 (n - 1) degrees of freedom; Bendat and Piersol, Random Data (2010), section 9.2.4, with
    the residual variance estimated. It holds what noise of the mass and friction add, and not
    the bias by noise of the base, nor what the finite width of the lines smooths.
    """
    freedom, size = 2.0 * (transfer.averages - 1.0), np.abs(transfer.H1)
    if freedom <= 0.0:
        return np.zeros(len(size)), np.full(len(size), np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.sqrt((1.0 - transfer.coherence) / (transfer.coherence * freedom))
    half = size * student_t(freedom) * share
    return np.maximum(size - half, 0.0), size + half


def band_of_coherence(transfer: TransferEstimate) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % confidence interval of the coherence, each of shape (n,).

    Notes
    -----
    By Fisher's transformation: artanh γ has the standard deviation √(1/(2 (n - 1))) and a bias
    of 1/(2 (n - 1)), with n independent averages; Enochson and Goodman (1965), for n of about
    10 or more.
    """
    freedom = 2.0 * (transfer.averages - 1.0)
    if freedom <= 0.0:
        return np.zeros(len(transfer.f)), np.ones(len(transfer.f))
    with np.errstate(divide="ignore"):
        z = np.arctanh(np.sqrt(transfer.coherence)) - 1.0 / freedom
    low, high = (np.maximum(z + s * NORMAL_95 / np.sqrt(freedom), 0.0) for s in (-1.0, 1.0))
    return np.square(np.tanh(low)), np.square(np.tanh(high))


# Warnings


def records_warnings(runs: Sequence[PreparedRun], segment: float) -> Iterator[WarningMessage]:
    """Yield what the records themselves show, such as channels that are exchanged.

    Parameters
    ----------
    runs : sequence of PreparedRun
        Along all axes.
    segment : float
        Length of the segments of the spectra [s].
    """
    for run in runs:
        yield from run_warnings(run, run.transfer_to("x_dd", segment), len(runs) > 1)


def run_warnings(
    prepared: PreparedRun, transfer: TransferEstimate | None, is_named: bool
) -> Iterator[WarningMessage]:
    """Yield the warnings about a run, with its file and axis if there are several."""
    motion, where = prepared.motion, f"{prepared.name}: " * is_named
    base = prepared.case.scenario.excitation
    # The samples of an acceleration are evaluated as they are; only the model joins them.
    joins = prepared.has_model or getattr(base, "quantity", "") != "acceleration"
    warnings = [each for each in motion.warnings if joins or each.slug != INTERPOLATED]
    warnings += prepared.measurement.warnings
    spacing = prepared.measurement.file_spacing
    warnings += weighting_warnings(prepared.case.scenario, motion, spacing)
    if transfer is not None:
        warnings += spectra_warnings(prepared.case, transfer)
        stroke = prepared.transfer_to("x_r", transfer.segment)
        assert prepared.u_dd is not None, "a transmissibility has a base"
        x_dd, dt = prepared.measurement.channels["x_dd"], prepared.measurement.dt
        u_dd, x_dd = (series[prepared.part] for series in (prepared.u_dd, x_dd))
        scales = prepared.measurement.scales
        if fault := fault_warning(u_dd, x_dd, dt, transfer, stroke, scales):
            warnings.append(fault)
    names = {source.file for source in prepared.inputs} | {prepared.file}
    for warning in warnings:
        name, _, rest = warning.sentence.partition(": ")
        sentence = rest if where and name in names else warning.sentence
        yield replace(warning, sentence=f"{where}{sentence}")


def check_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of checks of seeds, which a record does not have, and of those that cannot hold."""
    for i, check in enumerate(scenario.checks):
        if lacking := lacking_need(scenario, check):
            yield cannot_hold_warning(i, check, lacking)
        if check.judges != MEAN:
            sentence = f"the check `{check}` judges the mean of the runs: records have no seeds"
            yield WarningMessage("check-of-one-seed", sentence, {f"checks.{i}": check.limit})


def stroke_warnings(scenario: Scenario, metrics: Values) -> Iterator[WarningMessage]:
    """Warn of a measured stroke beyond its limit."""
    used, stroke = metrics[STROKE_USED], scenario.stroke
    if used is None or stroke is None or STROKE_LIMIT.holds(used):
        return
    symbol, reached, beyond = largest_excess(metrics, stroke.limits)
    sentence = (
        f"the stroke limit of {describe_limits(stroke.limits, reached)} is exceeded: {symbol} "
        f"reaches {format_length(reached)}, {format_length(beyond, reached)} beyond the limit"
    )
    yield WarningMessage("stroke-violated", sentence, {"stroke_used": used})


def agreement_warnings(scenario: Scenario, runs: Sequence[Run]) -> Iterator[WarningMessage]:
    """Warn of runs that do not agree."""
    within = assess_of(scenario).agree_within
    for name in AGREEING[scenario.measure.weights is not None]:
        values = [run.metrics[name] for run in runs]
        deviation = largest_deviation(values)
        if deviation is not None and deviation > within:
            mean = float(np.mean([value for value in values if value is not None]))
            far = [
                run.file
                for run, value in zip(runs, values, strict=True)
                if value is not None and abs(value / mean - 1.0) > within
            ]
            sentence = (
                f"the runs do not agree within {format_percent(within)} in {name}: "
                f"{join_words(far)} differ by up to {format_percent(deviation)} from the mean"
            )
            yield WarningMessage("runs-disagree", sentence, {"deviation": deviation})
