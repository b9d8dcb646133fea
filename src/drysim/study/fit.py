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

    The samples left out of 3. are those next to an event, usually below 2 %. Which they are
    depends on the parameters alone, so that the intervals are those of ordinary least squares.

    Fits begin with a short part of the record, in which few events can be wrong, and go on with
    longer ones: a mass that stops often remembers where it stopped, and one wrong stop early in
    the record would spoil the rest. Multiple shooting would need states that are not measured.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import ClassVar, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim.core.compile import choose_engine
from drysim.core.model import Floats, Input, Samples, Sines
from drysim.errors import EXIT_CHECK_FAILED, SolverError, UsageError, WarningMessage
from drysim.metrics.checks import Verdict
from drysim.metrics.table import Values
from drysim.parallel import WorkerPool, worker_count
from drysim.records.warnings import STANDARD_GRAVITY
from drysim.scenario.fit import CHANNELS, DELAY_KEY, FreeKey
from drysim.scenario.keys import fields_by_key
from drysim.scenario.laws import LAWS
from drysim.scenario.model import Scenario
from drysim.study.budget import case_cost
from drysim.study.fit_model import (
    MIN_SAMPLES,
    UNCERTAIN,
    FitModel,
    FreeParameter,
    Measurement,
    Prediction,
    Solved,
    build_model,
    fit_of,
    fitted_end,
    is_decay,
    model_of_law,
)
from drysim.study.outcome import Result, format_repr
from drysim.study.preparation import refuse_interval, require_scenario, without_fit_checks
from drysim.study.starting_values import STILL_NOISE, integrate, noise_level, remove_drift
from drysim.study.statistics import NORMAL_95
from drysim.wording import format_number, format_range, format_unit, join_words

Mask = NDArray[np.bool_]

Found = TypeVar("Found")

COARSE_STEP = 1e-2
"""Relative step of the derivatives in the coarse fit."""

STEPS = (3e-2, 1e-2, 1e-3, 1e-4, 1e-6)
"""Relative steps within which the mode of a sample must not change, one fit after another."""

DIFFERENCE = 1e-5
"""Relative step of the derivatives near the solution."""

JUMP = 3.0
"""Ratio of the derivatives on either side above which the motion jumps on one of them."""

PARTS = (0.15, 0.4)
"""Shares of the record that are fitted before the whole."""

MIN_PART = 400
"""Number of samples below which a part is not fitted by itself."""

SMALLEST_SIZE = 0.05
"""Size of a parameter for steps, relative to its start, where its value is smaller."""

COARSE_TIME = 0.02
"""Time between the samples of the coarse fit [s]."""

COARSE_SCALE = 0.05
"""Residual relative to the standard deviation above which the coarse fit is robust."""

ROBUST_NOISE = 3.0
ROBUST_SHARE = 1e-3
"""Residual above which a fit is robust: multiples of the noise, share of the median signal."""

COARSE_CALLS, FINE_CALLS, FINAL_CALLS, PROFILE_CALLS = 25, 10, 15, 6
"""Limits of the evaluations of a fit, without those for derivatives."""

MAX_STARTS = 6
"""Number of starts that are followed to the end: those with the lowest sums of squares, among
the closed-form ones and their coarse fits."""

SIGMAS = 2.0
"""Steps of the final fit, in standard deviations of the parameters."""

SMALLEST_STEP, LARGEST_STEP = 1e-6, 0.05
"""Bounds of these steps, relative to the start of a parameter."""

MAX_FINAL = 8
"""Number of final fits, each with the samples that the one before selects."""

OUTLIER, MAX_OUTLIERS = 6.0, 0.05
"""Residual, in robust standard deviations, above which a sample is an outlier; largest share of
samples left out as such."""

NOISE_MARGIN = 1.1
"""Ratio of the residuals to the noise up to which nothing better is looked for."""

NOISELESS, ROUNDING = 1e-3, 1e-11
"""Noise relative to a signal below which it is the curvature of the signal, and rounding."""

SCAN = tuple(sign * 10.0**e for e in np.linspace(-2.5, 0.3, 15).tolist() for sign in (-1, 1))
"""Relative changes of a parameter tried by the scan."""

NEIGHBOURS = (-0.2, -0.02, 0.02, 0.2)
"""Relative changes of a parameter from which a fit starts again."""

STATIC_PATHS = ("friction.static", "friction.mu_static")
STATIC_NEIGHBOURS = (-0.6, -0.45, -0.3, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0)
"""Those of a static limit, which decides over few stops and has many minima."""

MAX_RESTARTS = 2
"""Number of times that such fits may lead to another solution, and that profiles may."""

BETTER = 0.999
"""Ratio of sums of squares from which a solution is another, better one."""

AGREE = 1.01
"""Ratio of sums of squares up to which two starts agree."""

CHI_SQUARE_95 = NORMAL_95**2
"""Quantile of chi-square for a 95 % interval of one parameter."""

PROFILE_POINTS = 12
"""Number of fits for one end of a profile interval, once a value beyond it is known."""

PROFILE_GROWTH = 10.0
"""Largest ratio of the distances of two such fits from the solution, and of the part that one
of them takes from what is left."""

FARTHEST = 1e3
"""Distance, in sizes of a parameter, within which a profile looks for the end."""

STATIC_RATIOS = np.geomspace(1.0, 1e3, 25).tolist()
"""Ratios of static to kinetic friction tried for the interval of a static limit."""

BISECTIONS = 6
"""Number of halvings of the scan at each end of the interval of a static limit."""

PROFILE_TOLERANCE = 0.05
"""Accuracy of the rise of the sum of squares at an end of a profile interval; where the rise
jumps, that of the distance of the end."""

HIGH_CORRELATION = 0.9
"""Correlation from which two parameters are named."""

UNKNOWN_SHARE = 0.5
"""Relative standard deviation from which a parameter is not determined."""

IN_DIRECTION = 0.3
"""Component from which a parameter belongs to a direction of the parameter space."""

NULL_SHARE = 1e-8
"""Ratio of singular values below which a direction has no effect."""

START_STEP = 1e-3
"""Step of the start state, relative to the motion, within which the mode must not change."""

START_CHANCE, START_WRONG = 12.0, 25.0
"""Decrease of the sum of squares, in noise variances, from which a start that the file does
not state is fitted, and from which a stated one is called wrong: by chance one of 400 and of
250,000 records has as much."""

START_SHARE = 0.9
"""Ratio of sums of squares below which a fit of the start, too, describes a record better."""

ALIKE_NOISE = 1.4
"""RMS of x_dd - ü, in units of its noise, below which base and mass move alike."""

EXACT = 1e-6
"""Relative error below which residuals are rounding."""

WHITE = 4.0
"""Autocorrelation of the residuals, times the root of their number, from which they are not
white."""

FAULT_MARGIN = 2.0
"""Ratio of the residuals to the noise from which faults of the record are looked for."""

BAD_FIT = 0.3
"""Relative error that is worth a warning even if no such fault explains it."""

QUICK_SHARE = 0.3
"""Share of the record on which faults of it are tried."""

WRONG_UNITS = {
    "x_dd": {
        STANDARD_GRAVITY: "9.81: it is in g",
        1.0 / STANDARD_GRAVITY: "9.81: it is not in g",
    },
    "x_r": {0.1: "10", 10.0: "10", 1e-3: "1000", 1e3: "1000"},
}
"""Factors by which the units of channels are often wrong, in words."""

USELESS = 0.8
"""Relative error from which a fit describes next to nothing; its exit code is 1."""

NOT_THIS_MOTION = "the fitted motion is not the measured one"
"""Note to the values of a fit that describes next to nothing."""

CLIPPED = "record-clipped"
"""Warning about samples at the end of the range of a sensor."""

UNKNOWN_FAULT = "check columns, units, signs and time axes, or try another law"

MUCH_BETTER, OBVIOUS = 0.5, 0.1
"""Ratios of errors from which a fault of the record explains a bad fit: if no other explains it
better, and in any case."""

BLOCKS = 20
"""Number of blocks of the held-out part that laws are compared on."""


class Parameter(NamedTuple):
    """A fitted value with its 95 % intervals; None where there is no bound."""

    key: str
    unit: str
    value: float
    deviation: float | None
    """Standard deviation; None where the record does not determine the value."""
    low: float | None
    high: float | None
    """Interval from the covariance."""
    profile_low: float | None
    profile_high: float | None
    """Interval from the profile."""
    note: str = ""
    """What the record does not tell, one sentence; usually empty."""
    bound: float | None = None
    """The bound that the value lies at; None for a value between its bounds."""


class Profile(NamedTuple):
    """Rise of the sum of squares, in noise variances, over the values of one parameter."""

    key: str
    values: Floats
    rise: Floats


class ChannelFit(NamedTuple):
    """How well one channel is fitted."""

    name: str
    noise: float
    """RMS of the residuals over the selected samples, in SI."""
    error: float
    error_held_out: float | None
    """RMS of the residuals relative to the RMS of the signal [-]."""
    offset: float | None
    """Fitted offset of the measured channel, in SI."""


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
    metrics : dict
        `fit_error` and `fit_error_held_out`.
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
    metrics: Values
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
            f"{parameter.key} {format_number(parameter.value, format_unit(parameter.unit))}"
            for parameter in self.parameters
        )
        error = f"error {format_number(100 * (self.metrics['fit_error'] or 0.0), '%', 3)}"
        return format_repr("FitResult", self.source.name, values, error)

    def residuals(self, channel: ChannelFit) -> Floats:
        """Return the measured minus the fitted samples of a channel, without its offset."""
        measured, name = self.measurement.channels[channel.name], channel.name
        residuals: Floats = measured - self.prediction.channels[name] - (channel.offset or 0.0)
        return residuals

    def exit_code(self, strict: bool = False) -> int:
        """Return the code of all results; 1 if the fit describes next to nothing."""
        return EXIT_CHECK_FAILED if self.is_useless else super().exit_code(strict)

    @property
    def is_useless(self) -> bool:
        """Whether the fitted motion has next to nothing to do with the measured one."""
        return (self.metrics["fit_error"] or 0.0) > USELESS and any(
            warning.slug == "bad-fit" for warning in self.warnings
        )


def format_profile_interval(parameter: Parameter, more: int = 0, unit: str = "") -> str:
    """Return the profile interval of a parameter, to the digits in which its ends differ.

    Where one end is not known, the digits are those of an interval by the deviation.
    """
    ends, digits = (parameter.profile_low, parameter.profile_high), 4
    width = 2.0 * NORMAL_95 * (parameter.deviation or 0.0)
    if parameter.profile_low is not None and parameter.profile_high is not None:
        width = parameter.profile_high - parameter.profile_low
    largest = max((abs(end) for end in ends if end is not None), default=0.0)
    if width > 0.0:
        digits = min(max(digits, 2 + more + len(f"{largest / width:.0f}")), 12)
    return format_range(*ends, unit, digits)


# Least squares over the samples whose mode does not change

Bounds = tuple[Floats, Floats]


def sizes(x: Floats) -> Floats:
    """Return the sizes of scaled parameters, for steps."""
    return np.maximum(np.abs(x), SMALLEST_SIZE)


def rms(values: Floats) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


class Differentiable(NamedTuple):
    """Function of scaled parameters, and its derivatives where they are known."""

    value: Callable[[Floats], Floats]
    """Returns an array of shape (n,)."""
    slopes: Callable[[Floats], Floats | None]
    """Returns the derivatives, shape (n, p); None where they are not known in closed form."""

    def of(self, x: Floats, part: list[int]) -> Differentiable:
        """Return the function of some of the parameters; the others are those of x."""

        def complete(some: Floats) -> Floats:
            whole = x.copy()
            whole[part] = some
            return whole

        def slopes(some: Floats) -> Floats | None:
            rows = self.slopes(complete(some))
            return None if rows is None else rows[:, part]

        return Differentiable(lambda some: self.value(complete(some)), slopes)

    def jacobian(self, x: Floats, h: float, bounds: Bounds) -> Floats:
        """Return the derivatives, if need be by differences with a relative step.

        Differences also replace what is negligible: at its bound the effect of a parameter may
        begin with the square, as that of a static limit equal to kinetic friction.
        """
        slopes, every = self.slopes(x), np.arange(len(x))
        if slopes is None:
            slopes = differences(self.value, x, h, bounds, every)
        elif len(null := negligible_columns(slopes)):
            slopes[:, null] = differences(self.value, x, h, bounds, null)
        slopes[:, negligible_columns(slopes)] = 0.0  # rounding, which would move them far
        return slopes


def negligible_columns(slopes: Floats) -> NDArray[np.intp]:
    """Return the indices of derivatives that are 0 or rounding."""
    norms = np.linalg.norm(slopes, axis=0)
    return np.flatnonzero(norms <= NULL_SHARE * norms.max())


def remember_last(function: Callable[[Floats], Found]) -> Callable[[Floats], Found]:
    """Return a function that keeps its last result: `least_squares` asks for it once more."""
    latest: list[tuple[Floats, Found]] = []

    def remembered(x: Floats) -> Found:
        if not latest or not np.array_equal(latest[0][0], x):
            latest[:] = [(x.copy(), function(x))]
        return latest[0][1]

    return remembered


def differences(
    function: Callable[[Floats], Floats],
    x: Floats,
    h: float,
    bounds: Bounds,
    parameters: NDArray[np.intp],
) -> Floats:
    """Return the derivatives by some parameters, as central differences within bounds.

    The motion jumps where a stop is just made or just missed. With such a jump on one side of
    x the derivative is that of the other side.
    """
    columns, here = [], function(x)
    for j in parameters.tolist():
        step = h * float(sizes(x)[j])
        ends = np.array([x, x])
        ends[:, j] = min(x[j] + step, bounds[1][j]), max(x[j] - step, bounds[0][j])
        up, down = ends[0, j] - x[j], x[j] - ends[1, j]
        above, below = function(ends[0]) - here, here - function(ends[1])
        slope = (above + below) / (up + down)
        if min(up, down) > 0.5 * step:  # else a bound is nearer than rounding allows
            sides = above / up, below / down
            squares = [float(np.sum(side**2)) for side in sides]
            if max(squares) > JUMP**2 * min(squares):
                slope = sides[int(np.argmin(squares))]
        columns.append(slope)
    return np.stack(columns, axis=1)


def minimise(
    function: Differentiable,
    x: Floats,
    h: float,
    bounds: Bounds,
    calls: int,
    robust: float | None = None,
    tolerance: float = 1e-15,
) -> Floats:
    """Return the solution of `scipy.optimize.least_squares`.

    Parameters
    ----------
    function : Differentiable
        Residuals.
    x : ndarray, shape (p,)
        Start.
    h : float
        Relative step of differences.
    bounds : tuple of ndarray
    calls : int
        Largest number of evaluations, without those for derivatives.
    robust : float, optional
        Residual above which the loss grows linearly; default: least squares.
    tolerance : float, optional
        Relative change of the cost, and of x, at which it ends.
    """
    from scipy.optimize import least_squares

    margin = 1e-10 * np.maximum(1.0, np.abs(x))
    x = np.clip(x, bounds[0] + margin, bounds[1] - margin)
    first = function.jacobian(x, h, bounds)
    # A parameter without effect makes the problem singular and its steps short.
    active = np.flatnonzero(first.any(axis=0))
    if not len(active):
        return x
    start, few = x[active], function.of(x, active.tolist())
    few_bounds = bounds[0][active], bounds[1][active]

    def derivatives(some: Floats) -> Floats:
        if np.array_equal(some, start):
            return first[:, active]
        return few.jacobian(some, h, few_bounds)

    result = least_squares(
        few.value,
        start,
        jac=derivatives,
        bounds=few_bounds,
        loss="linear" if robust is None else "cauchy",
        f_scale=robust or 1.0,
        max_nfev=calls,
        xtol=tolerance,
        ftol=tolerance,
        gtol=1e-15,
    )
    solution = x.copy()
    solution[active] = result.x
    return solution


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Residuals of a model, and their minimisation in scaled parameters."""

    model: FitModel
    end: float
    """Time up to which samples are fitted [s]."""
    scale: Floats
    """Size of each parameter, shape (p,); the scaled ones are about 1."""
    noise: dict[str, float]
    """Noise of each channel, by which residuals are divided."""

    @classmethod
    def starting_from(cls, model: FitModel, end: float, start: Floats) -> Self:
        """Return the residuals in units of the signals, scaled by a start in SI."""
        scale = [
            model.size_of(parameter.key) or abs(value) or 1.0
            for parameter, value in zip(model.parameters, start.tolist(), strict=True)
        ]
        channels = model.measurement.channels
        noise = {name: float(channels[name].std()) or 1.0 for name in model.compared}
        return cls(model, end, np.array(scale), noise)

    @cached_property
    def count(self) -> int:
        """Number of fitted instants."""
        return int(np.sum(self.model.measurement.t <= self.end * (1.0 + 1e-12)))

    @cached_property
    def measured(self) -> dict[str, Floats]:
        """Fitted samples of each compared channel."""
        channels = self.model.measurement.channels
        return {name: channels[name][: self.count] for name in self.model.compared}

    @cached_property
    def all_samples(self) -> Mask:
        """The selection of all samples."""
        return np.ones(self.count, dtype=bool)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Bounds of the scaled parameters."""
        low, high = self.model.bounds
        return low / self.scale, high / self.scale

    def solve(self, x: Floats) -> Solved | None:
        """Return the motion at scaled parameters."""
        return self.model.solve(np.clip(x * self.scale, *self.model.bounds), self.end)

    def slopes(
        self, solved: Solved | None, integrated: bool = False
    ) -> dict[str, Floats] | None:
        """Return the derivatives of the channels by the scaled parameters, shape (p, n).

        None where they are not known in closed form, or not finite; `integrated` as in
        `Solved.slopes`.
        """
        if solved is None:
            return None
        steps = sizes(solved.values / self.scale) * self.scale
        slopes = solved.slopes(steps, self.model.compared, integrated)
        if slopes is None or not all(np.isfinite(rows).all() for rows in slopes.values()):
            return None
        return {name: rows * self.scale[:, None] for name, rows in slopes.items()}

    def differences(self, solved: Solved | None) -> dict[str, Floats]:
        """Return computed minus measured channels; large if the scene cannot be solved."""
        if solved is None:
            return {name: 10.0 * np.abs(row) + 1.0 for name, row in self.measured.items()}
        computed = solved.prediction(self.model.compared)
        return {
            name: np.where(computed.covers, computed.channels[name] - row, 0.0)
            for name, row in self.measured.items()
        }

    def centred(self, difference: Floats, mask: Mask) -> Floats:
        """Return differences without the offset of their channel, if it is unknown."""
        return difference - difference[mask].mean() if self.model.has_offset else difference

    def residuals(self, solved: Solved | None, mask: Mask) -> Floats:
        """Return the residuals of the selected samples in units of the noise."""
        differences = self.differences(solved).items()
        return np.concatenate(
            [self.centred(row, mask)[mask] / self.noise[name] for name, row in differences]
        )

    def over(self, mask: Mask) -> Differentiable:
        """Return the residuals of the selected samples as a function."""
        solve = remember_last(self.solve)

        def slopes(x: Floats) -> Floats | None:
            by_channel = self.slopes(solve(x))
            if by_channel is None:
                return None
            columns = []
            for name, rows in by_channel.items():
                chosen = rows[:, mask]
                if self.model.has_offset:
                    chosen -= chosen.mean(axis=1, keepdims=True)
                columns.append(chosen / self.noise[name])
            return np.concatenate(columns, axis=1).T

        return Differentiable(lambda x: self.residuals(solve(x), mask), slopes)

    @property
    def integrated(self) -> Differentiable:
        """Residuals without jumps: of velocities instead of accelerations.

        They are relative to the signal, and of fewer samples, as velocities are smooth.

        The value is a trapezoidal sum of samples, as of what was measured. The derivatives are
        those of the exact velocity, on purpose: they contain what the shifts of the jumps
        contribute, which the sum shows only where a jump passes a sample.
        """
        solve, names = remember_last(self.solve), self.model.compared

        def value(x: Floats) -> Floats:
            differences = self.differences(solve(x))
            smooth = {name: self.smoothed(series, name) for name, series in differences.items()}
            return np.concatenate([smooth[name] / self.smooth_sizes[name] for name in names])

        def slopes(x: Floats) -> Floats | None:
            by_channel = self.slopes(solve(x), integrated=True)
            if by_channel is None:
                return None
            columns = []
            for name in names:
                rows = [self.smoothed(row, name, integrated=True) for row in by_channel[name]]
                columns.append(np.array(rows) / self.smooth_sizes[name])
            return np.concatenate(columns, axis=1).T

        return Differentiable(value, slopes)

    @cached_property
    def smooth_sizes(self) -> dict[str, float]:
        """Standard deviation of each measured signal, as `smoothed` returns it."""
        deviations = {}
        for name, signal in self.measured.items():
            relative = signal - self.model.base()[: self.count] if name == "x_dd" else signal
            deviations[name] = float(self.smoothed(relative, name).std()) or 1.0
        return deviations

    def smoothed(self, values: Floats, name: str, integrated: bool = False) -> Floats:
        """Return a series of a channel at fewer samples, an acceleration as a velocity.

        `integrated` says that the values are velocities already.
        """
        dt = self.model.measurement.dt
        every = max(1, round(COARSE_TIME / dt))
        if name == "x_dd":
            velocity = values if integrated else integrate(values, dt)
            return remove_drift(velocity[::every], every * dt)
        few = values[::every]
        return few - few.mean() if self.model.has_offset else few

    def unchanged(self, x: Floats, steps: Floats) -> Mask:
        """Return the samples whose mode is the same within a step of each parameter."""
        here = self.solve(x)
        if here is None:
            return self.all_samples
        mode = here.places.mode
        mask: Mask = mode < UNCERTAIN
        if self.model.fit.measured.is_rig:
            mask &= mode != 0  # the force at rest is not that of a law
        for step in np.diag(steps):
            for x_near in (x + step, x - step):
                near = self.solve(x_near)
                if near is not None:
                    mask &= near.places.mode == mode
        return mask

    def robust_level(self) -> float:
        """Return the residual, in units of the noise, above which a fit is robust."""
        levels = [1e-12]
        for name, signal in self.measured.items():
            levels.append(ROBUST_NOISE * noise_level(signal) / self.noise[name])
            levels.append(ROBUST_SHARE * float(np.median(np.abs(signal))) / self.noise[name])
        return max(levels)

    def coarse(self, x: Floats) -> Floats:
        """Return the solution of the coarse fit."""
        if self.model.fit.measured.is_rig:
            return x
        return minimise(
            self.integrated, x, COARSE_STEP, self.bounds, COARSE_CALLS, COARSE_SCALE, 1e-3
        )

    def fine(self, x: Floats, steps: Sequence[float] = ()) -> tuple[float, Floats]:
        """Return cost and solution of fits of ever longer parts, with ever smaller steps.

        In a short part few events can be wrong, and each is right before the next is added.
        With `steps` the whole is fitted at once, from values whose events are right.
        """
        for share in () if steps else PARTS:
            part = replace(self, end=share * self.end)
            if part.count >= MIN_PART:
                x = part.refine(x, STEPS[:-1])
        x = self.refine(x, steps or STEPS)
        return self.cost(x), x

    def refine(self, x: Floats, steps: Sequence[float]) -> Floats:
        """Return the solution of fits of the samples that do not change within each step."""
        for h in steps:
            mask = self.unchanged(x, h * sizes(x))
            if mask.sum() < 10 * len(x):
                continue
            smooth = self.over(mask)
            robust = max(self.robust_level(), 1.5 * float(np.median(np.abs(smooth.value(x)))))
            rough = 1e-6 if h > STEPS[-1] else 1e-15
            x = minimise(smooth, x, min(h / 10, 1e-4), self.bounds, FINE_CALLS, robust, rough)
        return x

    def error(self, x: Floats) -> float:
        """Return the error of the worst channel, relative to the RMS of its signal."""
        errors = []
        for name, difference in self.differences(self.solve(x)).items():
            centred = self.centred(difference, self.all_samples)
            errors.append(rms(centred) / (rms(self.measured[name]) or 1.0))
        return max(errors)

    def cost(self, x: Floats) -> float:
        """Return the robust sum of squares over all samples, in units of the noise."""
        residuals = self.residuals(self.solve(x), self.all_samples)
        level = self.robust_level()
        return float(2 * level**2 * np.sum(np.sqrt(1 + (residuals / level) ** 2) - 1))


class Solution(NamedTuple):
    """A minimum: residuals in units of the noise, scaled parameters, covariance, samples.

    `smooth` are the samples whose mode does not change, `mask` those of them without outliers.
    """

    squares: LeastSquares
    x: Floats
    covariance: Floats
    jacobian: Floats
    smooth: Mask
    mask: Mask
    sum_of_squares: float

    @property
    def cost(self) -> float:
        """Robust sum of squares over all samples."""
        return self.squares.cost(self.x)

    def deviation(self, j: int) -> float:
        """Return the standard deviation of a scaled parameter."""
        return float(np.sqrt(max(self.covariance[j, j], 0.0)))


def final_fit(squares: LeastSquares, x: Floats) -> Solution:
    """Return the least-squares solution near x; its residuals are in units of their noise.

    The samples depend on the uncertainty of the parameters and it on them: a few repetitions.
    """
    steps = np.asarray(1e-2 * sizes(x))
    given = squares.model.fit.noise
    for i in range(MAX_FINAL):
        smooth = squares.unchanged(x, steps)
        if smooth.sum() < 10 * len(x):
            smooth = squares.unchanged(x, SMALLEST_STEP * sizes(x))
        mask = without_outliers(squares, x, smooth)
        robust = squares.robust_level() if i < 2 else None
        x = minimise(squares.over(mask), x, DIFFERENCE, squares.bounds, FINAL_CALLS, robust)
        noise = {}
        for name, difference in squares.differences(squares.solve(x)).items():
            chosen = squares.centred(difference, mask)[mask]
            size = float(np.sqrt(np.sum(chosen**2) / max(1, len(chosen) - len(x))))
            signal = squares.model.measurement.channels[name]
            stated = getattr(given, name, None)
            noise[name] = stated or max(size, 1e-15 * float(np.abs(signal).max()), 1e-300)
        squares = replace(squares, noise=noise)
        slopes = squares.over(mask).jacobian(x, DIFFERENCE, squares.bounds)
        covariance = covariance_of(slopes)
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        new = np.clip(SIGMAS * deviations, SMALLEST_STEP * sizes(x), LARGEST_STEP)
        if i > 2 and np.allclose(new, steps, rtol=0.05):
            break
        steps = new
    residuals = squares.residuals(squares.solve(x), mask)
    total = float(residuals @ residuals)
    return Solution(squares, x, covariance, slopes, smooth, mask, total)


def covariance_of(slopes: Floats) -> Floats:
    """Return the covariance for residuals of variance 1; 0 for parameters without effect.

    An inverse of the whole matrix would have rounding in their place.
    """
    active = np.flatnonzero(slopes.any(axis=0))
    some, covariance = slopes[:, active], np.zeros((slopes.shape[1],) * 2)
    covariance[np.ix_(active, active)] = np.linalg.pinv(some.T @ some, rcond=1e-14)
    return covariance


def without_outliers(squares: LeastSquares, x: Floats, mask: Mask) -> Mask:
    """Return the selected samples without outliers, unless there are too many.

    A stop that the motion makes or misses by very little is an outlier until its parameter is
    right; Gaussian noise has none.
    """
    kept = mask.copy()
    for difference in squares.differences(squares.solve(x)).values():
        difference = squares.centred(difference, mask)
        level = OUTLIER * float(np.median(np.abs(difference[mask]))) / 0.6745
        kept &= np.abs(difference) <= level
    return kept if kept.sum() >= (1.0 - MAX_OUTLIERS) * mask.sum() else mask


def is_noise(solution: Solution, margin: float = NOISE_MARGIN) -> bool:
    """Return whether the residuals are no larger than the noise of the signals, or rounding.

    Those next to an event do not count: its time is known within the uncertainty only.
    """
    squares = solution.squares
    for name, difference in squares.differences(squares.solve(solution.x)).items():
        signal = squares.measured[name]
        size, level = float(np.abs(signal).max()), noise_level(signal)
        least = max(margin * level * (level > NOISELESS * size), ROUNDING * size)
        difference = squares.centred(difference, solution.mask)[solution.smooth]
        if rms(difference) > least:
            return False
    return True


def begins_in_motion(solution: Solution, keys: Sequence[str]) -> bool:
    """Return whether a record shows another start than that of the scenario, as after a cut."""
    if gain_of_start(solution, keys) > START_CHANCE:
        return True
    if is_noise(solution):
        return False
    # Far from the solution a linear step shows little.
    wide, x = with_free_start(solution, keys)
    p = len(solution.x)
    x[p:] = wide.model.starts()[0][p:] / wide.scale[p:]
    return wide.fine(x, STEPS[2:])[0] < START_SHARE * solution.cost


def with_free_start(solution: Solution, keys: Sequence[str]) -> tuple[LeastSquares, Floats]:
    """Return residuals in which the start is fitted, too, and the parameters of a solution."""
    squares, state = solution.squares, solution.squares.model.scenario.start
    model = squares.model.with_free_start(keys)
    more = np.array([model.size_of(key) or 1.0 for key in keys])
    values = np.array([{"start.x_r": state.x_r, "start.v_r": state.v_r}[key] for key in keys])
    wide = replace(squares, model=model, scale=np.append(squares.scale, more))
    return wide, np.append(solution.x, values / more)


def gain_of_start(solution: Solution, keys: Sequence[str]) -> float:
    """Return the decrease of the sum of squares that another start state would bring.

    It is in noise variances, less if neighbouring residuals are alike, and that of a linear
    step in the start and all parameters together. A start with a small gain biases no
    parameter by more than a small share of its deviation, as only the first second depends on
    it.
    """
    if not keys or solution.squares.error(solution.x) < EXACT:
        return 0.0
    wide, x = with_free_start(solution, keys)
    p = len(solution.x)
    steps = np.append(np.zeros(p), np.full(len(keys), START_STEP))
    mask = solution.smooth & wide.unchanged(x, steps)
    slopes = wide.over(mask).jacobian(x, DIFFERENCE, wide.bounds)
    residuals = wide.residuals(wide.solve(x), mask)
    left = [
        float(np.sum((residuals - some @ np.linalg.lstsq(some, residuals, rcond=None)[0]) ** 2))
        for some in (slopes[:, :p], slopes)
    ]
    rho = float(np.sum(residuals[1:] * residuals[:-1])) / (float(np.sum(residuals**2)) or 1.0)
    return (left[0] - left[1]) / max(1.0, (1.0 + rho) / (1.0 - min(rho, 0.999)))


def perturbed(
    squares: LeastSquares, x: Floats, j: int, changes: Iterable[float]
) -> Iterator[Floats]:
    """Yield scaled parameters with relative changes of one of them, within its bounds."""
    for change in changes:
        near = x.copy()
        value = x[j] + change * sizes(x)[j]
        near[j] = np.clip(value, squares.bounds[0][j], squares.bounds[1][j])
        if near[j] != x[j]:
            yield near


def scan(squares: LeastSquares, x: Floats) -> Floats | None:
    """Return scaled parameters with a lower cost than x, varying one at a time; else None."""
    best, lowest = None, BETTER * squares.cost(x)
    for j in range(len(x)):
        for near in perturbed(squares, x, j, SCAN):
            if (cost := squares.cost(near)) < lowest:
                best, lowest = near, cost
    return best


def neighbours(squares: LeastSquares, x: Floats) -> Iterator[Floats]:
    """Yield starts around a solution, each with one parameter changed."""
    for j, parameter in enumerate(squares.model.parameters):
        static = parameter.key.startswith(STATIC_PATHS)
        yield from perturbed(squares, x, j, STATIC_NEIGHBOURS if static else NEIGHBOURS)


# Profiles


class ProfilePoint(NamedTuple):
    """Value of one scaled parameter, rise of the sum of squares, and all parameters there."""

    at: float
    rise: float
    x: Floats


class ParameterProfile(NamedTuple):
    """Both ends of the profile interval of a scaled parameter, and its points in order."""

    low: float | None
    high: float | None
    points: Sequence[ProfilePoint]


def profile_of(solution: Solution, determined: Sequence[int], j: int) -> ParameterProfile:
    """Return the profile of a parameter.

    The other parameters are fitted again, as far as the record determines them.
    """
    others = [i for i in determined if i != j]
    points = [ProfilePoint(float(solution.x[j]), 0.0, solution.x)]
    size, deviation = float(sizes(solution.x)[j]), solution.deviation(j)
    step = 0.1 * size
    if deviation > 0.0:
        step = float(np.clip(NORMAL_95 * deviation, ROUNDING * size, size))
    ends = []
    for sign in (-1.0, 1.0):
        end, tried = _profile_end(solution, others, j, sign * step)
        ends.append(end)
        points += tried
    profile = ParameterProfile(ends[0], ends[1], sorted(points, key=lambda point: point[:2]))
    static = solution.squares.model.parameters[j].key.startswith(STATIC_PATHS)
    return _over_all_samples(solution, j, profile) if static else profile


def _over_all_samples(
    solution: Solution, j: int, selected: ParameterProfile
) -> ParameterProfile:
    """Return the profile of a static limit over all samples, given that of the selected ones.

    A static limit decides at the events themselves, next to which no sample is selected. Over
    all samples the sum of squares has several minima, one for each order of events. The
    interval spans all values that are as good as the best one, and those that the selected
    samples do not exclude. The other parameters are as fitted, or as refitted to the latter.
    """
    squares = solution.squares
    least = squares.cost(solution.x)

    def point(x: Floats) -> ProfilePoint:
        return ProfilePoint(float(x[j]), squares.cost(x) - least, x)

    starts = [
        *(point.x for point in selected.points),
        *perturbed(squares, solution.x, j, SCAN),
        *perturbed(squares, solution.x, j, _static_changes(solution, j)),
    ]
    points = sorted(map(point, starts), key=lambda point: point[:2])
    ends: list[float | None] = []
    for sign, selected_end in ((1, selected.low), (-1, selected.high)):
        for _ in range(BISECTIONS):
            ordered = points[::sign]
            first = _first_within(ordered)
            if first == 0:
                break
            x = solution.x.copy()
            x[j] = 0.5 * (ordered[first].at + ordered[first - 1].at)
            points = sorted([*points, point(x)], key=lambda point: point[:2])
        ordered = points[::sign]
        first = _first_within(ordered)
        # The interval is rather too wide than too narrow.
        if first == 0 or selected_end is None:
            ends.append(None)
        else:
            ends.append(sign * min(sign * ordered[first - 1].at, sign * selected_end))
    return ParameterProfile(ends[0], ends[1], points)


def _static_changes(solution: Solution, j: int) -> list[float]:
    """Return the relative changes of a static limit to all multiples of kinetic friction.

    They reach values that few motions survive, wherever the fit has left the static limit.
    """
    x, scale = solution.x, solution.squares.scale
    law = solution.squares.model.scene(np.clip(x * scale, *solution.squares.model.bounds)).law
    kinetic = float(x[j]) * law.F_fk / (law.F_fs or 1.0)
    return [(kinetic * ratio - float(x[j])) / float(sizes(x)[j]) for ratio in STATIC_RATIOS]


def _first_within(points: Sequence[ProfilePoint]) -> int:
    """Return the index of the first point that is as good as the best one, at 95 %."""
    limit = min(point.rise for point in points) + CHI_SQUARE_95
    return next(i for i, point in enumerate(points) if point.rise <= limit)


def _profile_end(
    solution: Solution, others: list[int], j: int, step: float
) -> tuple[float | None, list[ProfilePoint]]:
    """Return one end of a profile interval by the secant rule on the root of the rise.

    An end is a value that the record excludes: None where there is none up to the bound of the
    parameter, or far beyond its size. The signed `step` leads to the first point.
    """
    start, sign = float(solution.x[j]), float(np.sign(step))
    limit = solution.squares.bounds[0 if sign < 0 else 1][j]
    farthest = FARTHEST * float(sizes(solution.x)[j])
    wanted, inner, outer = abs(step), (0.0, 0.0), np.inf
    points: list[ProfilePoint] = []
    while np.isinf(outer) or len(points) < PROFILE_POINTS:
        value = start + sign * wanted
        bounded = (value - limit) * sign >= 0.0
        value = float(limit) if bounded else value
        points.append(_profile_point(solution, others, j, value))
        rise, step = points[-1].rise, abs(value - start)
        if abs(rise - CHI_SQUARE_95) < PROFILE_TOLERANCE * CHI_SQUARE_95:
            return value, points
        if rise < CHI_SQUARE_95 and (bounded or step >= farthest):
            return None, points
        root = float(np.sqrt(max(rise, 0.0)))
        slope = (root - inner[1]) / (step - inner[0])
        if rise < CHI_SQUARE_95:
            inner = step, root
        else:
            outer = step
        if outer - inner[0] < PROFILE_TOLERANCE * outer:
            break
        near, far = inner[0], min(outer, PROFILE_GROWTH * step)
        wanted = near + (NORMAL_95 - inner[1]) / slope if slope > 0.0 else far
        if np.isinf(outer):
            wanted = min(wanted, far)
        elif not near + (far - near) / PROFILE_GROWTH < wanted < far or len(points) % 3 == 0:
            wanted = 0.5 * (near + far)  # secants alone may approach from one side, slowly
    return start + sign * outer, points  # rather too wide than too narrow


def _profile_point(solution: Solution, others: list[int], j: int, value: float) -> ProfilePoint:
    """Return the point of a profile at a value of one parameter, the others fitted."""
    squares, x, variance = solution.squares, solution.x.copy(), solution.covariance[j, j]
    x[j] = value

    residuals = squares.over(solution.mask).of(x, others)
    best = x[others]
    if others:
        if variance > 0.0:
            best += solution.covariance[others, j] / variance * (value - solution.x[j])
        bounds = squares.bounds[0][others], squares.bounds[1][others]
        best = minimise(residuals, np.clip(best, *bounds), DIFFERENCE, bounds, PROFILE_CALLS)
    rise = float(np.sum(residuals.value(best) ** 2)) - solution.sum_of_squares
    x[others] = best
    return ProfilePoint(value, rise, x)


# The fit of one law


@dataclass(frozen=True, eq=False)
class LawFit:
    """Solution under one friction law."""

    model: FitModel
    first: LeastSquares
    """Residuals in units of the signals, by which all starts are compared."""
    ends: tuple[Floats, ...]
    """Scaled parameters to which each start led."""
    solution: Solution

    @cached_property
    def values(self) -> Floats:
        """Fitted values in SI; one that differs from its bound by rounding is the bound."""
        values: Floats = np.clip(self.solution.x * self.first.scale, *self.model.bounds)
        for j in range(len(values)):
            bound = self.bound_of(j, float(values[j]))
            values[j] = values[j] if bound is None else bound
        return values

    def bound_of(self, j: int, value: float) -> float | None:
        """Return the bound that a value of a parameter is at; None between them."""
        p, scale = self.model.parameters[j], float(self.first.scale[j])
        return next((end for end in (p.low, p.high) if is_near(value, end, scale)), None)

    @cached_property
    def prediction(self) -> Prediction:
        """The fitted motion: all channels, measured or not."""
        solved = self.model.solve(self.values)
        assert solved is not None, "the solution was solved before"
        return solved.prediction(tuple(CHANNELS))

    def residuals(self, name: str, offset: float | None) -> Floats:
        """Return the measured minus the fitted samples of a channel; 0 beyond the motion."""
        measured, fitted = self.model.measurement.channels[name], self.prediction
        difference = measured - fitted.channels[name] - (offset or 0.0)
        return np.where(fitted.covers, difference, 0.0)

    @cached_property
    def channels(self) -> tuple[ChannelFit, ...]:
        """How well each channel is fitted and predicted."""
        return tuple(errors_of(self))

    @property
    def error(self) -> float:
        """Error of the worst channel, relative to its signal."""
        return max(channel.error for channel in self.channels)

    @property
    def error_held_out(self) -> float | None:
        """The same over the held-out part; None without one."""
        errors = [channel.error_held_out for channel in self.channels]
        return max((error for error in errors if error is not None), default=None)

    @property
    def starts(self) -> tuple[int, int]:
        """How many starts led to the solution, and how many there were.

        Static limits do not count, nor samples next to an event: both are settled last, from
        the best start alone.
        """
        static = [p.key.startswith(STATIC_PATHS) for p in self.model.parameters]

        def squares(x: Floats) -> float:
            same = np.where(static, self.solution.x, x)
            return float(
                np.sum(self.first.residuals(self.first.solve(same), self.solution.mask) ** 2)
            )

        lowest = squares(self.solution.x)
        agree = sum(squares(x) <= AGREE * lowest + 1e-9 for x in self.ends)
        return agree, len(self.ends)

    @cached_property
    def undetermined(self) -> dict[int, tuple[int, ...]]:
        """The parameters that the record does not determine, each with those it depends on.

        A direction of the parameter space has no effect if its singular value is negligible. A
        single parameter is not determined if its standard deviation exceeds half of its value,
        or half of its typical size where 0 is a value like any other.
        """
        solution = self.solution
        about_zero = [
            self.model.size_of(parameter.key) is not None for parameter in self.model.parameters
        ]
        whole = np.where(about_zero, 1.0, sizes(solution.x))
        _, values, directions = np.linalg.svd(solution.jacobian * whole, full_matrices=False)
        groups: dict[int, tuple[int, ...]] = {}
        for value, direction in zip(values, directions, strict=True):
            group = tuple(np.flatnonzero(np.abs(direction) > IN_DIRECTION).tolist())
            negligible = value <= NULL_SHARE * values[0]
            if negligible or (len(group) == 1 and value * UNKNOWN_SHARE <= 1.0):
                groups |= dict.fromkeys(group, group)
        return groups


def fit_law(
    model: FitModel, end: float, pool: WorkerPool, finished: Callable[[int], None]
) -> LawFit:
    """Return the best solution from all starts.

    Raises
    ------
    SolverError
        If no start can be solved.
    """
    starts, shared = model.starts(), (model.motion, model.measurement)  # by all laws
    first = LeastSquares.starting_from(model, end, starts[0])
    closed = [start / first.scale for start in starts]
    if first.solve(closed[0]) is None:
        model.at(starts[0])  # raises what is wrong with the values
    candidates = [*closed, *pool.map_in_order(first.coarse, closed, shared)]
    costs = list(map(first.cost, candidates))
    order = np.argsort(costs, kind="stable")[:MAX_STARTS]
    likely = [candidates[i] for i in order]
    if min(map(first.error, likely)) > USELESS:
        likely = likely[:1]  # no start is anywhere near
    followed = []
    for end_point in pool.map_in_order(first.fine, likely, shared):
        followed.append(end_point)
        finished(1)
    _, x = min(followed, key=lambda pair: pair[0])
    solution = final_fit(first, x)
    keys = [key for key in model.fixed_start if key in model.scenario.unstated_start]
    if keys and begins_in_motion(solution, keys):
        started = fit_law(model.with_free_start(keys), end, pool, ignore_progress)
        if started.first.cost(started.solution.x) < first.cost(solution.x):
            return started
    for _ in range(MAX_RESTARTS):
        squares = solution.squares
        other = scan(squares, solution.x)
        if other is not None:
            near = pool.map_in_order(partial(squares.fine, other), ((), STEPS[2:]))
        elif is_noise(solution) or squares.error(solution.x) > USELESS:
            break
        else:
            near = pool.map_in_order(squares.fine, neighbours(squares, solution.x))
        cost, x = min(near, key=lambda pair: pair[0])
        if cost >= BETTER * solution.cost:
            break
        solution = final_fit(squares, x)
    return LawFit(model, first, tuple(x for _, x in followed), solution)


def profiles_of(law_fit: LawFit, pool: WorkerPool) -> dict[int, ParameterProfile]:
    """Return the profiles of the parameters; of those that depend on others there are none.

    Without a motion that resembles the measured one, or without noise, there are none at all.
    """
    if law_fit.error > USELESS or law_fit.error < EXACT:
        return {}
    groups, every = law_fit.undetermined, range(len(law_fit.model.parameters))
    free = [j for j in every if not len(groups.get(j, ())) > 1]
    determined = [j for j in free if j not in groups]
    profile = partial(profile_of, law_fit.solution, determined)
    return dict(zip(free, pool.map_in_order(profile, free), strict=True))


def refit_from_profiles(
    law_fit: LawFit, profiles: Mapping[int, ParameterProfile]
) -> LawFit | None:
    """Return the fit from the lowest point of the profiles; None if it is no better one."""
    points = [point for profile in profiles.values() for point in profile.points]
    lowest = min(points, key=lambda point: point.rise, default=None)
    if lowest is None or lowest.rise >= -PROFILE_TOLERANCE * CHI_SQUARE_95:
        return None
    squares = law_fit.solution.squares
    _, x = squares.fine(lowest.x, STEPS[2:])
    solution = final_fit(squares, x)
    is_better = squares.cost(solution.x) < BETTER * law_fit.solution.cost
    return replace(law_fit, solution=solution) if is_better else None


def with_best_static_limit(law_fit: LawFit, profiles: Mapping[int, ParameterProfile]) -> LawFit:
    """Return the fit with the static limit that is best over all samples.

    It is the least one if no other is better by more than a standard deviation: the limit may
    not matter up to some value, and the lowest sum of squares is then that of chance.
    """
    x = law_fit.solution.x.copy()
    for j, profile in profiles.items():
        if law_fit.model.parameters[j].key.startswith(STATIC_PATHS):
            best, least = min(profile.points, key=lambda point: point.rise), profile.points[0]
            x[j] = least.at if least.rise - best.rise < 1.0 else best.at
    return replace(law_fit, solution=law_fit.solution._replace(x=x))


# The complete fit


def ignore_progress(count: int) -> None:
    """Ignore the progress of a fit."""


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
        Called with 1 for each start that has been followed; `count_starts` returns how many.

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
    require_fit(scenario)
    first = build_model(scenario)
    choose_engine(case_cost(first.case), first.case.kernels)
    check_motion(first)
    end = fitted_end(scenario, first.measurement)
    names, read = fit_of(scenario).laws, (first.motion, first.measurement)
    models = [model_of_law(scenario, *read, name) for name in names] or [first]
    with WorkerPool(worker_count(workers)) as pool:
        fits = [fit_law(model, end, pool, finished) for model in models]
        for left in range(MAX_RESTARTS, -1, -1):
            scores = score_laws(names, fits)
            best = names.index(scores[0].law) if scores else 0
            profiles = profiles_of(fits[best], pool)
            better = refit_from_profiles(fits[best], profiles) if left else None
            if better is None:
                break
            fits[best] = better
    fits[best] = with_best_static_limit(fits[best], profiles)
    return describe_fit(scenario, fits[best], scores, profiles)


def require_fit(scenario: Scenario) -> None:
    """Raise a UsageError for anything but a scenario with a fit block."""
    require_scenario(scenario)
    refuse_interval(scenario)
    if scenario.fit is None:
        raise UsageError(
            f"{scenario.name} has no fit block", "`drysim manual fit` shows how to write one"
        )


def count_starts(scenario: Scenario) -> int:
    """Return the number of starts that a fit follows, over all laws."""
    return MAX_STARTS * max(1, len(scenario.fit.laws if scenario.fit else ()))


def check_motion(model: FitModel) -> None:
    """Raise SolverError if the mass does not move relative to the base, beyond the noise."""
    channels = model.measurement.channels
    if model.fit.measured.is_rig:
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


def errors_of(law_fit: LawFit) -> Iterator[ChannelFit]:
    """Yield how well each channel is fitted and predicted."""
    model, mask, count = law_fit.model, law_fit.solution.mask, law_fit.first.count
    for name in model.compared:
        measured, offset = model.measurement.channels[name], None
        if model.has_offset:
            difference = measured - law_fit.prediction.channels[name]
            offset = float(difference[:count][mask].mean())
        size = rms(measured - (offset or 0.0)) or 1.0
        residuals = law_fit.residuals(name, offset)
        fitted, rest = residuals[:count], residuals[count:]
        freedom = max(1, int(mask.sum()) - len(model.parameters))
        noise = float(np.sqrt(np.sum(fitted[mask] ** 2) / freedom))
        held_out = rms(rest) / size if len(rest) else None
        yield ChannelFit(name, noise, rms(fitted) / size, held_out, offset)


def describe_fit(
    source: Scenario,
    law_fit: LawFit,
    scores: tuple[LawScore, ...],
    profiles: Mapping[int, ParameterProfile],
) -> FitResult:
    """Return the result for a solution: intervals, errors, checks, warnings."""
    model, scale = law_fit.model, law_fit.first.scale
    parameters = tuple(intervals(law_fit, profiles))
    scenario = fitted_scenario(law_fit)
    metrics: Values = {"fit_error": law_fit.error, "fit_error_held_out": law_fit.error_held_out}
    if source.checks:
        metrics = metrics_of_fitted(scenario) | metrics
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
        parameters=parameters,
        correlations=tuple(correlations(law_fit, parameters)),
        channels=law_fit.channels,
        laws=scores,
        starts=law_fit.starts,
        profiles=tuple(
            Profile(
                model.parameters[j].key,
                np.array([point.at for point in profile.points]) * scale[j],
                np.array([point.rise for point in profile.points])
                - min(point.rise for point in profile.points),
            )
            for j, profile in profiles.items()
        ),
        metrics=metrics,
        spring_in_force=model.fit.measured.is_rig and model.spring_in_force,
        checks=tuple(check.judge(metrics) for check in source.checks),
        warnings=(*warnings, *fit_warnings(law_fit, parameters, warnings)),
    )


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
                    note += (
                        f" up to {format_number(parameter.profile_high, format_unit(p.unit))}"
                    )
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
    fields = without_fit_checks(scenario).copy_with({"fit": None}).resolved()
    if friction is not None:
        options = friction.model_dump(by_alias=True, exclude_none=True, mode="json")
        law_keys = fields_by_key(LAWS[friction.law])  # without the options of other laws
        fields["friction"] = {key: value for key, value in options.items() if key in law_keys}
    context = {"folder": scenario.folder, "document": document}
    plain = Scenario.model_validate(fields, context=context)
    swept = law_fit.model.scenario
    return plain.copy_with({"sweep": swept.sweep, "reference": swept.reference})


def metrics_of_fitted(scenario: Scenario) -> Values:
    """Return the metrics of the fitted scenario on its own base motion, for checks."""
    from drysim.study.preparation import prepare
    from drysim.study.run import measure_case

    return dict(measure_case(prepare(scenario))[0])


def reason_of(law_fit: LawFit, group: tuple[int, ...]) -> str:
    """Return why the record does not determine a parameter, or those of a group."""
    model, fitted = law_fit.model, law_fit.prediction
    named = [model.parameters[j].key for j in group]
    if len(named) > 1:
        mass = ", usually the mass" if "oscillator.mass" in named else ""
        return f"only the ratios of {join_words(named)} follow; state one of them{mass}"
    span = format_number(float(model.measurement.t[-1]), "s")
    if is_without_stops(law_fit, named[0]):
        return f"the mass never sticks in {span}, so that its value does not matter here"
    if (fitted.mode == 0).all():
        return f"the fitted mass never slides in {span}"
    return "it has no effect on this record beyond the noise"


def is_without_stops(law_fit: LawFit, key: str) -> bool:
    """Return whether a key is a static limit, and the fitted mass never sticks."""
    return key.startswith(STATIC_PATHS) and not (law_fit.prediction.mode == 0).any()


def correlations(
    law_fit: LawFit, parameters: Sequence[Parameter]
) -> Iterator[tuple[str, str, float]]:
    """Yield the pairs of keys with a correlation above `HIGH_CORRELATION`."""
    covariance = law_fit.solution.covariance
    determined = [j for j, p in enumerate(parameters) if p.deviation]
    for a, i in enumerate(determined):
        for j in determined[a + 1 :]:
            value = float(covariance[i, j] / np.sqrt(covariance[i, i] * covariance[j, j]))
            if abs(value) > HIGH_CORRELATION:
                yield parameters[i].key, parameters[j].key, value


# Warnings about a fit


def fit_warnings(
    law_fit: LawFit, parameters: Sequence[Parameter], of_records: Sequence[WarningMessage]
) -> Iterator[WarningMessage]:
    """Yield the warnings about a fit; of one that describes next to nothing only the cause."""
    error = law_fit.error
    if not is_noise(law_fit.solution, FAULT_MARGIN):
        sentence = f"the fitted motion differs from the measured one by {100 * error:.3g} %"
        clipped = any(warning.slug == CLIPPED for warning in of_records)
        unknown = "clipped samples are not those of the motion" if clipped else UNKNOWN_FAULT
        if cause := likely_fault(law_fit) or (unknown if clipped or error > BAD_FIT else ""):
            yield WarningMessage("bad-fit", f"{sentence}; {cause}", {"fit_error": error})
            if error > USELESS:
                return
    notes: dict[str, list[str]] = {}
    for j, (p, free) in enumerate(zip(parameters, law_fit.model.parameters, strict=True)):
        given = law_fit.model.fit.free.get(p.key, FreeKey())
        scale = float(law_fit.first.scale[j])
        if p.note:
            notes.setdefault(p.note, []).append(p.key)
        elif is_near(p.value, given.low, scale) or is_near(p.value, given.high, scale):
            end = format_number(p.value, format_unit(free.unit))
            sentence = f"{p.key} ends at its bound of {end} in fit.free"
            yield WarningMessage("at-bound", sentence)
        elif p.bound == free.low == 0.0:
            sentence = f"{p.key} ends at 0, its least value: this record shows none of it"
            yield WarningMessage("at-bound", sentence)
        elif p.bound is not None:
            end = format_number(p.bound, format_unit(free.unit))
            which = "least" if p.bound == free.low else "largest"
            yield WarningMessage("at-bound", f"{p.key} ends at {end}, its {which} value")
    for note, keys in notes.items():
        about = "" if len(keys) > 1 and join_words(keys) in note else f"{join_words(keys)}: "
        yield WarningMessage("not-determined", f"{about}{note}")
    stated = law_fit.model.stated_start
    if gain_of_start(law_fit.solution, stated) > START_WRONG:
        sentence = f"{describe_wrong_start(stated)}; the intervals may miss the true values"
        yield WarningMessage("start-differs", sentence)
    agree, total = law_fit.starts
    if agree < 2 <= total:
        many = f"only {agree} of {total} starts led" if agree else f"none of {total} starts led"
        sentence = (
            f"{many} to this solution: it may not be the best; give `start` values or bounds"
        )
        yield WarningMessage("starts-disagree", sentence, {"agree": agree, "starts": total})
    for channel in law_fit.channels:
        rho = lag_correlation(law_fit, channel.name)
        count = int(law_fit.solution.mask.sum())
        if error > EXACT and abs(rho) * np.sqrt(count) > WHITE:
            factor = format_number(np.sqrt((1.0 + rho) / (1.0 - rho)), digits=2)
            sentence = (
                f"the residuals of {channel.name} are not white (correlation of neighbours "
                f"{rho:.2f}): the intervals are too "
                + (f"narrow, by a factor of about {factor}" if rho > 0.0 else "wide")
            )
            yield WarningMessage("residuals-not-white", sentence, {"correlation": rho})


def is_near(value: float, bound: float | None, scale: float) -> bool:
    """Return whether a value is at a bound; the least squares stay inside by a little."""
    if bound is None or not np.isfinite(bound):
        return False
    return abs(value - bound) <= 1e-6 * max(abs(bound), scale)


def lag_correlation(law_fit: LawFit, name: str) -> float:
    """Return the correlation of neighbouring residuals of a channel."""
    difference, mask = (
        law_fit.first.differences(law_fit.first.solve(law_fit.solution.x))[name],
        law_fit.solution.mask,
    )
    values = difference - difference[mask].mean()
    both = mask[1:] & mask[:-1]
    size = float(np.mean(values[mask] ** 2))
    if size == 0.0 or not both.any():
        return 0.0
    return min(float(np.mean((values[1:] * values[:-1])[both])) / size, 0.999)


def likely_fault(law_fit: LawFit) -> str:
    """Return the most likely fault of a record that is not fitted well; empty if none."""
    model = law_fit.model
    if model.fit.measured.is_rig:
        return ""
    if is_decay(model.scenario) and (still := samples_at_rest(model)):
        measured = model.measurement
        rest = {name: values[still:] for name, values in measured.channels.items()}
        released = replace(
            model, measurement=measured._replace(channels=rest, t=measured.t[:-still])
        )
        if refitted(law_fit, released)[0] < MUCH_BETTER * law_fit.error:
            time = format_number(still * measured.dt, "s", 3)
            return (
                f"the mass seems to be held for the first {time}: let `window` begin where it "
                "is released"
            )
    uncorrected, best, cause = refitted(law_fit, model)[0], np.inf, ""
    for fault, other in possible_faults(model):
        error, values = refitted(law_fit, other, OBVIOUS * uncorrected)
        if error < best:
            best, cause = error, fault.format(lag=format_number(values[-1], "s", 3))
        if best < OBVIOUS * uncorrected:
            break
    return cause if best < MUCH_BETTER * min(uncorrected, 1.0) else ""


def samples_at_rest(model: FitModel) -> int:
    """Return the number of samples before the first channel moves beyond its noise."""
    values = model.measurement.channels[model.compared[0]]
    count = len(values) - MIN_SAMPLES
    level = STILL_NOISE * max(noise_level(values[:MIN_SAMPLES]), 1e-6 * float(np.ptp(values)))
    moves = np.abs(values - np.median(values[:MIN_SAMPLES])) > level
    still = int(np.argmax(moves))
    return still if MIN_SAMPLES <= still <= count else 0


def possible_faults(model: FitModel) -> Iterator[tuple[str, FitModel]]:
    """Yield usual faults of a record in words, each with the model in which it is corrected."""
    measured, motion = model.measurement, model.motion

    def multiplied(name: str, factor: float) -> FitModel:
        channels = measured.channels | {name: factor * measured.channels[name]}
        return replace(model, measurement=measured._replace(channels=channels))

    for name in model.compared:
        yield f"the sign of {name} seems to be wrong: `scale: -1`", multiplied(name, -1.0)
    whole = isinstance(motion, Samples) and len(measured.t) == len(motion.u_dd)
    if "x_dd" in measured.channels and isinstance(motion, Samples) and whole:
        swapped = measured._replace(channels=measured.channels | {"x_dd": motion.u_dd[:]})
        exchanged = motion._replace(u_dd=measured.channels["x_dd"], u=None)
        fault = "base and mass seem to be swapped: exchange the columns"
        yield fault, replace(model, measurement=swapped, motion=exchanged)
    if stated := model.stated_start:
        yield describe_wrong_start(stated), model.with_free_start(stated)
    # Nothing lags behind a base at rest.
    if DELAY_KEY not in [p.key for p in model.parameters] and not is_decay(model.scenario):
        far = 20.0 * measured.dt
        delay = FreeParameter(DELAY_KEY, "s", -far, far, 0.0)
        fault = "the measured response seems to lag by {lag}: free `measured.delay`"
        yield fault, replace(model, parameters=(*model.parameters, delay))
    for name in model.compared:
        for factor, fault in WRONG_UNITS.get(name, {}).items():
            fault = f"the unit of {name} seems to be wrong by a factor of {fault}"
            yield fault, multiplied(name, factor)


def describe_wrong_start(stated: Sequence[str]) -> str:
    """Return that a record begins in another state than stated, and the remedy."""
    keys = "these keys" if len(stated) > 1 else "this key"
    return (
        f"the record does not begin with the stated {join_words(stated)}: without {keys} in "
        "the file the start is fitted"
    )


def refitted(law_fit: LawFit, model: FitModel, enough: float = 0.0) -> tuple[float, Floats]:
    """Return relative error and values of a quick fit of another model.

    Up to three starts are followed, until an error is small enough.
    """
    t = model.measurement.t
    end = min(
        law_fit.first.end, max(QUICK_SHARE * float(t[-1]), float(t[min(MIN_PART, len(t)) - 1]))
    )
    best, values = np.inf, np.zeros(len(model.parameters))
    for start in model.starts()[:3]:
        squares = LeastSquares.starting_from(model, end, start)
        scale = squares.scale
        x = squares.refine(squares.coarse(start / scale), STEPS[:3])
        error = rms(squares.residuals(squares.solve(x), squares.all_samples))
        if error < best:
            best, values = error, x * scale
        if best < enough:
            break
    return best, values
