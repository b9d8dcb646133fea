"""Fit of friction, damping and stiffness to a measured response, by exact stick-slip motion.

Problem
    The residuals are the measured minus the computed channels. The acceleration of the mass and
    the friction force jump where sliding begins, stops or reverses. A parameter that moves such
    an instant past a sample changes this residual by a jump, which no derivative shows: the sum
    of squares is rough, with a local minimum per sample.

Method
    1. Starting values in closed form (`starting_values`), several of them.
    2. A coarse fit of the integrated acceleration, in which jumps are kinks.
    3. Fits of the samples whose mode of motion (stuck, sliding up, sliding down) does not
       change while each parameter varies by a step; over these the residuals are smooth. The
       step shrinks from 3 % to the uncertainty of the parameters.
    4. `scipy.optimize.least_squares` does each fit, robust against outliers at first. The
       derivatives are those of the variational equation (`core.variational`), in one pass over
       the motion. Those of a law without a closed form are central differences.
    5. Where another value of one parameter has a lower sum of squares, or the residuals exceed
       the noise of the signals, fits from neighbouring values look for a better solution.
    6. Intervals from the covariance at the solution, and from the profile: the parameter is
       fixed, the others are fitted again, and the bounds are where the sum of squares has
       risen by 3.84 noise variances (likelihood ratio, 95 %). Where a profile finds a lower sum
       of squares the fit goes on from there.

    7. Noise of the base record colours the residuals: it is drawn, sent through the fitted
       motion, and widens the intervals (`fit_base_noise`).

    The samples left out of 3. are those next to an event, usually below 2 %. Which they are
    depends on the parameters alone, so that the intervals are those of ordinary least squares.

    Fits begin with a short part of the record, in which few events can be wrong, and go on with
    longer ones: a mass that stops often remembers where it stopped, and one wrong stop early in
    the record would spoil the rest. Starts that meet there are followed as one.
    Multiple shooting would need states that are not measured.

Modules
    `fit_model` has the measured response and the motion that is compared with it, the other
    modules 1. (`starting_values`), 2. to 4. (`fit_least_squares`), the way through all of them
    (`fit_law`), 6. (`fit_profiles`), 7. (`fit_base_noise`), and the warnings (`fit_warnings`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from drysim.core.compile import choose_engine
from drysim.core.model import Floats, Input, Samples, Sines
from drysim.errors import EXIT_CHECK_FAILED, SolverError, UsageError, WarningMessage
from drysim.excitation.random import RandomMotion
from drysim.metrics.checks import Verdict
from drysim.metrics.table import Values
from drysim.parallel import WorkerPool, worker_count
from drysim.scenario.keys import fields_by_key
from drysim.scenario.laws import LAWS
from drysim.scenario.model import STATIC_PATHS, Scenario
from drysim.study.budget import case_cost
from drysim.study.fit_base_noise import BaseNoise
from drysim.study.fit_curves import (
    CurveFit,
    CurveModel,
    FittedCurve,
    build_curve_model,
    check_sliding,
    fit_curves,
)
from drysim.study.fit_draws import Draws, draw, draws_warnings, with_metrics
from drysim.study.fit_law import (
    MAX_RESTARTS,
    MAX_STARTS,
    USELESS,
    ChannelFit,
    LawFit,
    Parameter,
    Steps,
    fit_law,
    ignore_progress,
    profiles_of,
    refit_from_profiles,
    under_base_noise,
    with_best_static_limit,
)
from drysim.study.fit_least_squares import Mask, rms
from drysim.study.fit_model import (
    FitModel,
    Measurement,
    Prediction,
    build_model,
    fit_of,
    fitted_end,
    model_of_law,
)
from drysim.study.fit_profiles import ParameterProfile
from drysim.study.fit_spectrum_curves import (
    Scatter,
    SpectrumFit,
    SpectrumModel,
    build_spectrum_model,
    fit_spectrum_curves,
)
from drysim.study.fit_warnings import fit_warnings
from drysim.study.outcome import Result, format_repr
from drysim.study.preparation import (
    prepare,
    refuse_interval,
    require_blocks,
    require_scenario,
    without_fit_checks,
)
from drysim.study.run import measure_case
from drysim.study.starting_values import noise_level
from drysim.study.statistics import NORMAL_95, median_and_ends
from drysim.study.store import Store
from drysim.wording import (
    format_number,
    format_quantity,
    format_range,
    interval_digits,
    join_words,
)

HIGH_CORRELATION = 0.9
"""Correlation from which two parameters are named."""

ALIKE_NOISE = 1.4
"""RMS of x_dd - ü, in units of its noise, below which base and mass move alike."""

NOT_THIS_MOTION = "the fitted motion is not the measured one"
"""Note to the values of a fit that describes next to nothing."""

PREDICTED = "T_a", "SEAT", "x_r_peak"
"""Metrics of the fitted motion that have an interval."""

BLOCKS = 20
"""Number of blocks of the held-out part that laws are compared on."""


class Profile(NamedTuple):
    """Rise of the sum of squares, in noise variances, over the values of one parameter.

    It is that above the solution, from which the interval follows: negative where a fit with
    this value fixed is better. Of a static limit over all samples it is that above the lowest
    point.
    """

    key: str
    values: Floats
    rise: Floats


class MetricInterval(NamedTuple):
    """A metric of the fitted motion and its 95 % interval; None where it is not known."""

    name: str
    value: float
    low: float | None
    high: float | None


class LawScore(NamedTuple):
    """A friction law and its errors; `tied` if the best law is not better on held-out data."""

    law: str
    error: float | None
    error_held_out: float | None
    tied: bool


@dataclass(frozen=True, eq=False)
class FitResult(Result):
    """Fitted scenario, parameters with intervals, and how far the record supports them.

    Attributes
    ----------
    source : Scenario
        The scenario with its fit block.
    scenario : Scenario
        The fitted scenario, which runs.
    motion : Sines or Samples
        Base motion, or the imposed motion of a rig.
    measurement : Measurement
    prediction : Prediction
        The fitted motion: all channels, measured or not.
    selected : ndarray of bool
        Samples that were fitted: neither next to an event nor held out.
    fitted_end : float
        Time from which the record is held out [s].
    parameters : tuple of Parameter
    correlations : tuple
        Pairs of keys and their correlation, where it is above 0.9.
    channels : tuple of ChannelFit
    laws : tuple of LawScore
        Compared laws, the best first; empty if only that of the file was fitted.
    starts : tuple of int
        How many starts led to this solution, and how many there were.
    profiles : tuple of Profile
    draws : Draws
        Joint draws of the values, with the metrics of their motions.
    metrics : dict
        `fit_error` and `fit_error_held_out`, and those of the fitted motion.
    curves : tuple of FittedCurve
        Measured and fitted curves, of a fit to curves.
    base_noise : BaseNoise or None
        Noise of the base record; None if the base is not a record.
    scatter : Scatter or None
        Signals and times of estimates, of a fit to curves under random base motion.
    spring_in_force : bool
        Whether the force of a rig contains those of spring and damper.
    checks : tuple of Verdict
    warnings : tuple of WarningMessage
    """

    kind: ClassVar[str] = "fit"

    source: Scenario
    scenario: Scenario
    motion: Sines | Samples = field(compare=False)
    measurement: Measurement
    prediction: Prediction
    selected: Mask
    fitted_end: float
    parameters: tuple[Parameter, ...]
    correlations: tuple[tuple[str, str, float], ...]
    channels: tuple[ChannelFit, ...]
    laws: tuple[LawScore, ...]
    starts: tuple[int, int]
    profiles: tuple[Profile, ...]
    draws: Draws
    metrics: Values
    curves: tuple[FittedCurve, ...] = ()
    base_noise: BaseNoise | None = field(default=None, compare=False)
    scatter: Scatter | None = None
    spring_in_force: bool = False
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Records of base motion and measurement, each file once."""
        several = (*getattr(self.motion, "inputs", ()), *self.measurement.inputs)
        return tuple({record.file: record for record in several}.values())

    def __repr__(self) -> str:
        """Return the fitted values in one line."""
        values = ", ".join(
            f"{parameter.key} {format_quantity(parameter.value, parameter.unit)}"
            for parameter in self.parameters
        )
        error = f"error {format_number(100 * (self.metrics['fit_error'] or 0.0), '%', 3)}"
        return format_repr("FitResult", self.source.name, values, error)

    def residuals(self, channel: ChannelFit) -> Floats:
        """Return the measured minus the fitted samples of a channel, without its offset."""
        measured, name = self.measurement.channels[channel.name], channel.name
        residuals: Floats = measured - self.prediction.channels[name] - (channel.offset or 0.0)
        return residuals

    @property
    def motion_intervals(self) -> tuple[MetricInterval, ...]:
        """Metrics of the fitted motion on the measured base, with their 95 % intervals."""
        if is_rig(self.source) or self.is_useless:
            return ()
        intervals = []
        for name in PREDICTED:
            if (value := self.metrics.get(name)) is not None:
                low, high = self.draws.interval(name) or (None, None)
                intervals.append(MetricInterval(name, value, low, high))
        return tuple(intervals)

    def exit_code(self, strict: bool = False) -> int:
        """Return the code of all results; 1 if the fit describes next to nothing."""
        return EXIT_CHECK_FAILED if self.is_useless else super().exit_code(strict)

    @property
    def is_useless(self) -> bool:
        """Whether the fitted motion has next to nothing to do with the measured one."""
        return (self.metrics["fit_error"] or 0.0) > USELESS and any(
            warning.slug == "bad-fit" for warning in self.warnings
        )


def format_profile_interval(
    parameter: Parameter, more: int = 0, with_unit: bool = False
) -> str:
    """Return the profile interval of a parameter, to the digits in which its ends differ.

    Where one end is not known, the digits are those of an interval by the deviation.
    """
    ends = parameter.profile_low, parameter.profile_high
    width = 2.0 * NORMAL_95 * (parameter.deviation or 0.0)
    if parameter.profile_low is not None and parameter.profile_high is not None:
        width = parameter.profile_high - parameter.profile_low
    largest = max((abs(end) for end in ends if end is not None), default=0.0)
    unit = parameter.unit if with_unit else ""
    return format_range(*ends, unit, interval_digits(width, largest, more))


def fit(
    scenario: Scenario,
    *,
    workers: int | None = None,
    finished: Callable[[int], None] = ignore_progress,
) -> FitResult:
    """Fit the free keys of a scenario to its measured response.

    Parameters
    ----------
    scenario : Scenario
        With a fit block.
    workers : int, optional
        Number of workers; the result does not depend on it. Default: one for each core.
    finished : callable, optional
        Called with the number of finished steps, of which `count_steps` returns the total.

    Returns
    -------
    FitResult

    Raises
    ------
    RecordError
        If a record cannot be used.
    ScenarioError
        If a free key has no start.
    SolverError
        If the record determines nothing.
    UsageError
        If the scenario has no fit block.
    """
    return solve(scenario, prepare_fit(scenario), workers=workers, finished=finished)


def prepare_fit(scenario: Scenario) -> list[FitModel]:
    """Return the models of the laws to compare, or that of the scenario alone.

    Raises
    ------
    RecordError, ScenarioError, SolverError, UsageError
        As `fit` does, for all that is found without a fit.
    """
    require_fit(scenario)
    first = read_model(scenario)
    if isinstance(first, CurveModel):
        check_sliding(first)
        return [first]
    choose_engine(case_cost(first.case), first.case.kernels)
    check_motion(first)
    names, read = fit_of(scenario).laws, (first.motion, first.measurement)
    models = [model_of_law(scenario, *read, name) for name in names] or [first]
    for model in models:
        model.starts()
    return models


def solve(
    scenario: Scenario,
    models: Sequence[FitModel],
    *,
    workers: int | None = None,
    finished: Callable[[int], None] = ignore_progress,
    store: Store | None = None,
) -> FitResult:
    """Fit the models of `prepare_fit`; other arguments as those of `fit`.

    A store keeps the finished steps, and has those of an interrupted fit.
    """
    names = fit_of(scenario).laws
    with WorkerPool(worker_count(workers)) as pool:
        steps = Steps(pool, store)
        fits = [fit_model(model, steps, finished) for model in models]
        for left in range(MAX_RESTARTS, -1, -1):
            scores = score_laws(names, fits)
            best = names.index(scores[0].law) if scores else 0
            counted = finished if left == MAX_RESTARTS else ignore_progress
            fits[best] = under_base_noise(fits[best], steps)
            counted(1)
            profiles = profiles_of(fits[best], steps, counted)
            better = refit_from_profiles(fits[best], profiles) if left else None
            if better is None:
                break
            fits[best] = better
        reported = fits[best]
        if not isinstance(reported, CurveFit) or not reported.sticks:
            reported = with_best_static_limit(reported, profiles)
        draws = draw(fits[best], reported, profiles, steps)
        case = prepare(fitted_scenario(reported)) if needs_motion(scenario) else None
        metrics = {} if case is None else dict(measure_case(case)[0])
        shown = [name for name in PREDICTED if metrics.get(name) is not None]
        if case is not None and shown and len(draws.values) and not is_rig(scenario):
            base_noise = reported.base_noise
            level = 0.0 if base_noise is None else base_noise.level
            draws = with_metrics(draws, case, shown, steps, level)
        finished(1)
    return describe_fit(scenario, reported, scores, profiles, draws, metrics)


def is_rig(scenario: Scenario) -> bool:
    """Return whether the measurement is that of a rig, which has no motion of its own."""
    return fit_of(scenario).is_rig


def needs_motion(scenario: Scenario) -> bool:
    """Return whether the metrics of the fitted motion are shown or judged."""
    return bool(scenario.checks) or not is_rig(scenario)


def read_model(scenario: Scenario) -> FitModel:
    """Read what is measured, and return the model under the law of the file.

    Raises
    ------
    RecordError, ScenarioError
        As `build_model` does.
    """
    if fit_of(scenario).curves is None:
        return build_model(scenario)
    if isinstance(scenario.excitation, RandomMotion):
        return build_spectrum_model(scenario)
    return build_curve_model(scenario)


def fit_model(model: FitModel, steps: Steps, finished: Callable[[int], None]) -> LawFit:
    """Return the best solution for one model; `finished` is called with 1 for each start."""
    if isinstance(model, SpectrumModel):
        return fit_spectrum_curves(model, steps, finished)
    if isinstance(model, CurveModel):
        return fit_curves(model, steps, finished)
    end = fitted_end(model.scenario, model.measurement)
    return fit_law(model, end, steps, finished)


def require_fit(scenario: Scenario) -> None:
    """Raise a UsageError for anything but a scenario with a fit block."""
    require_scenario(scenario)
    require_blocks(scenario)
    refuse_interval(scenario)
    if scenario.fit is None:
        raise UsageError(
            f"{scenario.name} has no fit block", "`drysim manual fit` shows how to write one"
        )


def count_steps(scenario: Scenario) -> int:
    """Return the number of steps that show the progress of a fit.

    They are the starts, which it follows for each law, the noise of the base, the profiles of
    the parameters, and the draws.
    """
    block = fit_of(scenario)
    return MAX_STARTS * max(1, len(block.laws)) + len(block.free) + 2


def check_motion(model: FitModel) -> None:
    """Raise SolverError if the mass does not move relative to the base, beyond the noise."""
    channels = model.measurement.channels
    if model.fit.is_rig:
        return
    for name, values in channels.items():
        signal = values - model.base() if name == "x_dd" else values
        signal = signal - (signal.mean() if model.has_offset else 0.0)
        noise = getattr(model.fit.noise, name, None) or noise_level(signal)
        if rms(signal) > max(ALIKE_NOISE * noise, 1e-9 * float(np.abs(values).max())):
            return
    what = (
        "base and mass differ by less than the noise"
        if "x_dd" in channels
        else "the relative motion is smaller than its noise"
    )
    raise SolverError(
        f"{what}: nothing can be fitted; the mass does not slide, a column is nothing but "
        "noise, or both columns are those of the same sensor"
    )


def score_laws(names: Sequence[str], fits: Sequence[LawFit]) -> tuple[LawScore, ...]:
    """Return the laws ordered by their error on the held-out part.

    Laws are tied with the best one if the squared residuals of both differ, over blocks of the
    held-out part, by less than twice the standard error of the mean difference. Among tied laws
    the one with the fewest parameters comes first, then the first one of the file.
    """
    if not names:
        return ()
    # All laws have a held-out part, or none has.
    errors = [
        law_fit.error if law_fit.error_held_out is None else law_fit.error_held_out
        for law_fit in fits
    ]
    blocks = [block_squares(law_fit) for law_fit in fits]
    leader = int(np.argmin(errors))
    ranked = []
    for i, (name, law_fit) in enumerate(zip(names, fits, strict=True)):
        difference = blocks[i] - blocks[leader]
        spread = float(difference.std(ddof=1)) / np.sqrt(len(difference))
        tied = i == leader or float(difference.mean()) <= 2.0 * spread
        score = LawScore(name, law_fit.error, law_fit.error_held_out, False)
        ranked.append(
            (not tied, len(law_fit.model.parameters) if tied else 0, i, errors[i], score)
        )
    several = sum(not entry[0] for entry in ranked) > 1
    ranked.sort(key=lambda entry: (entry[0], entry[1], entry[3] if entry[0] else entry[2]))
    return tuple(score._replace(tied=several and not worse) for worse, *_, score in ranked)


def block_squares(law_fit: LawFit) -> Floats:
    """Return the mean squared relative residual of blocks of the held-out part."""
    count = len(law_fit.model.measurement.t)
    begin = law_fit.first.count if count - law_fit.first.count >= BLOCKS else 0
    total: Floats = np.zeros(count - begin)
    for channel in law_fit.channels:
        size = float(law_fit.model.measurement.channels[channel.name].std()) or 1.0
        total = total + (law_fit.residuals(channel.name, channel.offset)[begin:] / size) ** 2
    return np.array([float(block.mean()) for block in np.array_split(total, BLOCKS)])


def describe_fit(
    source: Scenario,
    law_fit: LawFit,
    scores: tuple[LawScore, ...],
    profiles: Mapping[int, ParameterProfile],
    draws: Draws,
    metrics: Values,
) -> FitResult:
    """Return the result for a solution: intervals, errors, checks, warnings.

    `metrics` are those of the fitted motion, as far as they are needed.
    """
    model = law_fit.model
    parameters = tuple(intervals(law_fit, spanning_draws(profiles, law_fit, draws)))
    scenario = fitted_scenario(law_fit)
    metrics = {
        **metrics,
        "fit_error": law_fit.error,
        "fit_error_held_out": law_fit.error_held_out,
    }
    of_base = getattr(model.motion, "warnings", ())
    of_records = {
        warning.sentence: warning for warning in (*of_base, *model.measurement.warnings)
    }
    warnings = tuple(of_records.values())
    return FitResult(
        source=source,
        scenario=scenario,
        motion=model.motion,
        measurement=model.measurement,
        prediction=law_fit.prediction,
        selected=law_fit.solution.mask,
        fitted_end=law_fit.first.end,
        curves=tuple(law_fit.curves) if isinstance(law_fit, CurveFit) else (),
        parameters=parameters,
        correlations=tuple(correlations(law_fit, parameters)),
        channels=law_fit.channels,
        laws=scores,
        starts=law_fit.starts,
        profiles=tuple(shown_profile(law_fit, j, profile) for j, profile in profiles.items()),
        draws=draws,
        metrics=metrics,
        base_noise=law_fit.base_noise,
        scatter=law_fit.scatter if isinstance(law_fit, SpectrumFit) else None,
        spring_in_force=model.fit.is_rig and model.spring_in_force,
        checks=tuple(check.judge(metrics) for check in source.checks),
        warnings=(
            *warnings,
            *fit_warnings(law_fit, parameters, warnings),
            *draws_warnings(draws),
        ),
    )


def shown_profile(law_fit: LawFit, j: int, profile: ParameterProfile) -> Profile:
    """Return the profile of a parameter in its unit."""
    key = law_fit.model.parameters[j].key
    values, rise = np.array([(point.value, point.rise) for point in profile.points]).T
    if key.startswith(STATIC_PATHS) and law_fit.first.leaves_out_events:
        rise = rise - rise.min()
    return Profile(key, values * law_fit.first.scale[j], rise)


def spanning_draws(
    profiles: Mapping[int, ParameterProfile], law_fit: LawFit, draws: Draws
) -> dict[int, ParameterProfile]:
    """Return profiles whose ends span 95 % of the draws, too, under noise of the base.

    The noise moves stops and break-aways. A profile takes the measured base as exact there, and
    a static limit as what it is at the solution.
    """
    if not (law_fit.base_noise and law_fit.base_noise.level and len(draws.values)):
        return dict(profiles)
    spanning = {}
    for j, profile in profiles.items():
        _, low, high = median_and_ends(draws.values[:, j] / float(law_fit.first.scale[j]))
        spanning[j] = profile._replace(
            low=None if profile.low is None else min(profile.low, low),
            high=None if profile.high is None else max(profile.high, high),
        )
    return spanning


def intervals(law_fit: LawFit, profiles: Mapping[int, ParameterProfile]) -> Iterator[Parameter]:
    """Yield the fitted values with their intervals."""
    model, solution, groups = law_fit.model, law_fit.solution, law_fit.undetermined
    point = model.point(law_fit.values)
    for j, p in enumerate(model.parameters):
        value, scale = point[p.key], float(law_fit.first.scale[j])
        parameter = Parameter(p.key, p.unit, value, None, None, None, None, None)
        parameter = parameter._replace(bound=law_fit.bound_of(j, float(law_fit.values[j])))
        if law_fit.error > USELESS:
            yield parameter._replace(note=NOT_THIS_MOTION)
            continue
        if j not in groups:
            deviation = scale * solution.deviation(j)
            half = NORMAL_95 * deviation
            low, high = max(value - half, p.low), min(value + half, p.high)
            parameter = parameter._replace(deviation=deviation, low=low, high=high)
        if profile := profiles.get(j):
            parameter = parameter._replace(
                profile_low=None if profile.low is None else profile.low * scale,
                profile_high=None if profile.high is None else profile.high * scale,
            )
            if profile.low is None and (
                profile.high is None or is_without_stops(law_fit, p.key)
            ):
                # The record excludes no value, whatever the curvature at the fitted one, or
                # none of a static limit up to that of a first stop.
                note = reason_of(law_fit, groups.get(j, (j,)))
                if parameter.profile_high is not None:
                    note += f" up to {format_quantity(parameter.profile_high, p.unit)}"
                parameter = parameter._replace(deviation=None, low=None, high=None, note=note)
        elif j in groups:
            parameter = parameter._replace(note=reason_of(law_fit, groups[j]))
        else:  # rounding has no profile
            parameter = parameter._replace(
                profile_low=None if parameter.low == parameter.bound else parameter.low,
                profile_high=None if parameter.high == parameter.bound else parameter.high,
            )
        yield parameter


def fitted_scenario(law_fit: LawFit) -> Scenario:
    """Return the scenario with the fitted values, without its fit block and checks of it."""
    scenario = law_fit.model.at(law_fit.values)
    document, friction = scenario.document, scenario.active_friction
    # Axes and conditions of these name keys, which only the reading of a file resolves.
    judged = without_fit_checks(scenario)
    unread = {"fit": None, "design": None, "checks": ()}
    fields = judged.copy_with(unread).resolved()
    if friction is not None:
        options = friction.model_dump(by_alias=True, exclude_none=True, mode="json")
        law_keys = fields_by_key(LAWS[friction.law])  # without the options of other laws
        fields["friction"] = {key: value for key, value in options.items() if key in law_keys}
    context = {"folder": scenario.folder, "document": document}
    plain = Scenario.model_validate(fields, context=context)
    swept = law_fit.model.scenario
    # The solver is that of the file: a default step may differ between the cases of a sweep.
    kept = {"sweep": swept.sweep, "reference": swept.reference, "solver": scenario.solver}
    return plain.copy_with(kept | {"design": scenario.design, "checks": judged.checks})


def reason_of(law_fit: LawFit, group: tuple[int, ...]) -> str:
    """Return why the record does not determine a parameter, or those of a group."""
    model = law_fit.model
    named = [model.parameters[j].key for j in group]
    if len(named) > 1:
        mass = ", usually the mass" if "oscillator.mass" in named else ""
        return f"only the ratios of {join_words(named)} follow; state one of them{mass}"
    if is_without_stops(law_fit, named[0]):
        return f"the mass never sticks {model.extent}, so that its value does not matter here"
    if not law_fit.slides:
        return f"the fitted mass never slides {model.extent}"
    if group[0] not in law_fit.undetermined:
        bounds = [float(ends[group[0]]) for ends in model.bounds]
        if np.isfinite(bounds).all():
            return f"its bounds are narrower than its interval from {model.subject}"
        return f"none of its values contradicts {model.subject}"
    return f"it has no effect on {model.subject} beyond the noise"


def is_without_stops(law_fit: LawFit, key: str) -> bool:
    """Return whether a key is a static limit, and the fitted mass never sticks."""
    return key.startswith(STATIC_PATHS) and not law_fit.sticks


def correlations(
    law_fit: LawFit, parameters: Sequence[Parameter]
) -> Iterator[tuple[str, str, float]]:
    """Yield the pairs of keys with a correlation above `HIGH_CORRELATION`."""
    covariance = law_fit.solution.robust_covariance
    determined = [j for j, p in enumerate(parameters) if p.deviation]
    for a, i in enumerate(determined):
        for j in determined[a + 1 :]:
            value = float(covariance[i, j] / np.sqrt(covariance[i, i] * covariance[j, j]))
            if abs(value) > HIGH_CORRELATION:
                yield parameters[i].key, parameters[j].key, value
