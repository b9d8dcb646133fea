"""Least squares of a motion that jumps: residuals of the samples whose mode does not change.

Where sliding begins, stops or reverses, the acceleration jumps. A parameter that moves such an
instant past a sample changes its residual by a jump, which no derivative shows. Samples are
therefore selected whose mode of motion stays the same within a step of each parameter; the
step shrinks from one fit to the next. `study.fit` describes the whole method.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.scenario.model import STATIC_PATHS
from drysim.study.fit_model import UNCERTAIN, Computed, FitModel
from drysim.study.starting_values import integrate, noise_level, remove_drift

Mask = NDArray[np.bool_]

Answer = TypeVar("Answer")

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

TOLERANCE = 1e-10
"""Relative change of the sum of squares, and of the parameters, at which a fit ends. Of a
million samples it leaves a hundredth of a standard deviation."""

COARSE_CALLS, FINE_CALLS, FINAL_CALLS = 25, 10, 15
"""Limits of the evaluations of a fit, without those for derivatives."""

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

STATIC_NEIGHBOURS = (-0.6, -0.45, -0.3, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0)
"""Those of a static limit, which decides over few stops and has many minima."""

BETTER = 0.999
"""Ratio of sums of squares from which a solution is another, better one."""

NULL_SHARE = 1e-8
"""Ratio of singular values below which a direction has no effect."""

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


def remember(
    function: Callable[[Floats], Answer], count: int = 1
) -> Callable[[Floats], Answer]:
    """Return a function that keeps its latest results: `least_squares` asks for them again."""
    latest: deque[tuple[Floats, Answer]] = deque(maxlen=count)

    def remembered(x: Floats) -> Answer:
        for kept, answer in latest:
            if np.array_equal(kept, x):
                return answer
        latest.append((x.copy(), function(x)))
        return latest[-1][1]

    return remembered


class Motions(NamedTuple):
    """The motions at scaled parameters, and their derivatives, of which the latest are kept.

    A fit begins where the one before it ended, with other samples of the same motion.
    """

    solve: Callable[[Floats], Computed | None]
    """As `LeastSquares.solve`."""
    slopes: Callable[[Floats], dict[str, Floats] | None]
    """As `LeastSquares.slopes`, of the motion at x."""


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
    tolerance: float = TOLERANCE,
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

    leaves_out_events: ClassVar[bool] = True
    """Whether samples next to an event are left out of a fit."""
    null_share: ClassVar[float] = NULL_SHARE
    """Ratio of singular values below which a direction has no effect."""

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

    def solve(self, x: Floats) -> Computed | None:
        """Return the motion at scaled parameters."""
        return self.model.solve(np.clip(x * self.scale, *self.model.bounds), self.end)

    def motions(self) -> Motions:
        """Return the motions at scaled parameters, of which the latest are kept."""
        solve = remember(self.solve, 2)  # a trial after the latest step may be rejected
        return Motions(solve, remember(lambda x: self.slopes(solve(x))))

    def slopes(
        self, solved: Computed | None, integrated: bool = False
    ) -> dict[str, Floats] | None:
        """Return the derivatives of the channels by the scaled parameters, shape (p, n).

        None where they are not known in closed form, or not finite; `integrated` as in
        `Computed.slopes`.
        """
        if solved is None:
            return None
        steps = sizes(solved.values / self.scale) * self.scale
        slopes = solved.slopes(steps, self.model.compared, integrated)
        if slopes is None or not all(np.isfinite(rows).all() for rows in slopes.values()):
            return None
        return {name: rows * self.scale[:, None] for name, rows in slopes.items()}

    def differences(self, solved: Computed | None) -> dict[str, Floats]:
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

    def residuals(self, solved: Computed | None, mask: Mask) -> Floats:
        """Return the residuals of the selected samples in units of the noise."""
        differences = self.differences(solved).items()
        return np.concatenate(
            [self.centred(row, mask)[mask] / self.noise[name] for name, row in differences]
        )

    def over(self, mask: Mask, motions: Motions | None = None) -> Differentiable:
        """Return the residuals of the selected samples as a function."""
        solve, slopes_at = motions or self.motions()

        def slopes(x: Floats) -> Floats | None:
            by_channel = slopes_at(x)
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
        solve, names = remember(self.solve), self.model.compared

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

    def unchanged(self, x: Floats, steps: Floats, motions: Motions | None = None) -> Mask:
        """Return the samples whose mode is the same within a step of each parameter."""
        here = (motions or self).solve(x)
        if here is None:
            return self.all_samples
        mode = here.modes
        mask: Mask = mode < UNCERTAIN
        if self.model.fit.is_rig:
            mask &= mode != 0  # the force at rest is not that of a law
        for step in np.diag(steps):
            for x_near in (x + step, x - step):
                near = self.solve(x_near)
                if near is not None:
                    mask &= near.modes == mode
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
        if self.model.fit.is_rig:
            return x
        return minimise(
            self.integrated, x, COARSE_STEP, self.bounds, COARSE_CALLS, COARSE_SCALE, 1e-3
        )

    def fine(self, x: Floats, steps: Sequence[float] = ()) -> tuple[float, Floats]:
        """Return cost and solution of fits with ever smaller steps, after those of parts.

        With `steps` the whole is fitted at once, from values whose events are right.
        """
        x = self.refine(x if steps else self.over_parts(x), steps or STEPS)
        return self.cost(x), x

    def over_parts(self, x: Floats) -> Floats:
        """Return the solution of fits of ever longer parts, with ever smaller steps.

        In a short part few events can be wrong, and each is right before the next is added.
        """
        for share in PARTS:
            part = replace(self, end=share * self.end)
            if part.count >= MIN_PART:
                x = part.refine(x, STEPS[:-1])
        return x

    def refine(self, x: Floats, steps: Sequence[float]) -> Floats:
        """Return the solution of fits of the samples that do not change within each step."""
        motions = self.motions()
        for h in steps:
            mask = self.unchanged(x, h * sizes(x), motions)
            if mask.sum() < 10 * len(x):
                continue
            smooth = self.over(mask, motions)
            robust = max(self.robust_level(), 1.5 * float(np.median(np.abs(smooth.value(x)))))
            rough = 1e-6 if h > STEPS[-1] else TOLERANCE
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

    `covariance` is that of white residuals; `robust_covariance` also has what the noise of the
    base motion adds, if any; `base_errors`, of shape (n, p), are the errors of the parameters
    that drawn noises of it make. `smooth` are the samples whose mode does not change, `mask`
    those of them without outliers.
    """

    squares: LeastSquares
    x: Floats
    covariance: Floats
    robust_covariance: Floats
    jacobian: Floats
    smooth: Mask
    mask: Mask
    sum_of_squares: float
    base_errors: Floats | None = None

    @property
    def cost(self) -> float:
        """Robust sum of squares over all samples."""
        return self.squares.cost(self.x)

    def deviation(self, j: int) -> float:
        """Return the standard deviation of a scaled parameter."""
        return float(np.sqrt(max(self.robust_covariance[j, j], 0.0)))

    def inflation(self, j: int) -> float:
        """Return the ratio of a parameter's variance to that under white residuals."""
        white, robust = float(self.covariance[j, j]), float(self.robust_covariance[j, j])
        return robust / white if white > 0.0 and robust > 0.0 else 1.0


def final_fit(squares: LeastSquares, x: Floats, inflation: Floats | float = 1.0) -> Solution:
    """Return the least-squares solution near x; its residuals are in units of their noise.

    The samples depend on the uncertainty of the parameters and it on them: a few repetitions.

    Parameters
    ----------
    squares : LeastSquares
    x : ndarray, shape (p,)
    inflation : float or ndarray, shape (p,), optional
        Ratio of the variances of the parameters to those under white residuals.
    """
    steps = np.asarray(1e-2 * sizes(x))
    given, motions = squares.model.fit.noise, squares.motions()
    for i in range(MAX_FINAL):
        smooth = squares.unchanged(x, steps, motions)
        if smooth.sum() < 10 * len(x):
            smooth = squares.unchanged(x, SMALLEST_STEP * sizes(x), motions)
        mask = without_outliers(squares, x, smooth)
        robust = squares.robust_level() if i < 2 else None
        function = squares.over(mask, motions)
        x = minimise(function, x, DIFFERENCE, squares.bounds, FINAL_CALLS, robust)
        noise = {}
        for name, difference in squares.differences(motions.solve(x)).items():
            chosen = squares.centred(difference, mask)[mask]
            size = float(np.sqrt(np.sum(chosen**2) / max(1, len(chosen) - len(x))))
            signal = squares.model.measurement.channels[name]
            stated = getattr(given, name, None)
            noise[name] = stated or max(size, 1e-15 * float(np.abs(signal).max()), 1e-300)
        squares = replace(squares, noise=noise)
        slopes = squares.over(mask, motions).jacobian(x, DIFFERENCE, squares.bounds)
        covariance = covariance_of(slopes)
        deviations = np.sqrt(np.maximum(inflation * np.diag(covariance), 0.0))
        new = np.clip(SIGMAS * deviations, SMALLEST_STEP * sizes(x), LARGEST_STEP)
        if i > 2 and np.allclose(new, steps, rtol=0.05):
            break
        steps = new
    residuals = squares.residuals(motions.solve(x), mask)
    total = float(residuals @ residuals)
    return Solution(squares, x, covariance, covariance, slopes, smooth, mask, total)


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
