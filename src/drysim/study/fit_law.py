"""The fit of one friction law: from all starts to the best solution, and how good it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import takewhile
from typing import Any, NamedTuple

import numpy as np

from drysim.core.model import Floats
from drysim.parallel import WorkerPool
from drysim.scenario.fit import CHANNELS
from drysim.scenario.model import STATIC_PATHS
from drysim.study.fit_base_noise import FEW_NOISES, BaseNoise, with_base_noise
from drysim.study.fit_least_squares import (
    BETTER,
    DIFFERENCE,
    STEPS,
    LeastSquares,
    Solution,
    final_fit,
    is_noise,
    neighbours,
    rms,
    scan,
    sizes,
)
from drysim.study.fit_model import FitModel, Prediction
from drysim.study.fit_profiles import (
    CHI_SQUARE_95,
    PROFILE_TOLERANCE,
    ParameterProfile,
    ProfilePoint,
    profile_of,
)
from drysim.study.store import Store
from drysim.wording import display_unit, format_unit

MAX_STARTS = 6
"""Number of starts that are followed to the end: those with the lowest sums of squares, among
the closed-form ones and their coarse fits."""

MAX_RESTARTS = 2
"""Number of times that fits from neighbouring values may lead to another solution, and that
profiles may."""

AGREE = 1.01
"""Ratio of sums of squares up to which two starts agree."""

UNKNOWN_SHARE = 0.5
"""Relative standard deviation from which a parameter is not determined."""

IN_DIRECTION = 0.3
"""Component from which a parameter belongs to a direction of the parameter space."""

START_STEP = 1e-3
"""Step of the start state, relative to the motion, within which the mode must not change."""

START_CHANCE, START_WRONG = 12.0, 25.0
"""Decrease of the sum of squares, in noise variances, from which a start that the file does
not state is fitted, and from which a stated one is called wrong: by chance one of 400 and of
250,000 records has as much."""

START_SHARE = 0.9
"""Ratio of sums of squares below which a fit of the start, too, describes a record better."""

WIDER = 1.2
"""Ratio of variances from which fewer samples are selected, under noise of the base."""

EXACT = 1e-6
"""Relative error below which residuals are rounding."""

USELESS = 0.8
"""Relative error from which a fit describes next to nothing; its exit code is 1."""


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
    """Interval from the profile, spanning 95 % of the draws under noise of the base."""
    note: str = ""
    """What the record does not tell, one sentence; usually empty."""
    bound: float | None = None
    """The bound that the value lies at; None for a value between its bounds."""

    @property
    def scale(self) -> float:
        """Displayed units per SI unit, as in `display_unit`."""
        return display_unit(self.unit, self.value)[0]

    @property
    def displayed(self) -> Parameter:
        """The parameter in the unit in which it is shown."""
        _, symbol = display_unit(format_unit(self.unit), self.value)
        numbers: dict[str, Any] = {
            name: self.scale * number
            for name, number in self._asdict().items()
            if isinstance(number, float)
        }
        return self._replace(unit=symbol, **numbers)


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


@dataclass(frozen=True, eq=False)
class LawFit:
    """Solution under one friction law."""

    model: FitModel
    first: LeastSquares
    """Residuals in units of the signals, by which all starts are compared."""
    ends: tuple[Floats, ...]
    """Scaled parameters to which each start led."""
    solution: Solution
    base_noise: BaseNoise | None = None
    """Noise of the base record, once `under_base_noise` has found it; None without a record."""

    @cached_property
    def values(self) -> Floats:
        """Fitted values in SI; one that differs from its bound by rounding is the bound."""
        values: Floats = np.clip(self.solution.x * self.first.scale, *self.model.bounds)
        for j in range(len(values)):
            bound = self.bound_of(j, float(values[j]))
            values[j] = values[j] if bound is None else bound
        return values

    def with_solution(self, solution: Solution) -> LawFit:
        """Return the fit with another solution under the same law."""
        return replace(self, solution=solution)

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

    @property
    def sticks(self) -> bool:
        """Whether the fitted mass sticks at times."""
        return bool((self.prediction.mode == 0).any())

    @property
    def slides(self) -> bool:
        """Whether the fitted mass slides at times."""
        return bool((self.prediction.mode != 0).any())

    def residuals(self, name: str, offset: float | None) -> Floats:
        """Return the measured minus the fitted samples of a channel; 0 beyond the motion."""
        measured, fitted = self.model.measurement.channels[name], self.prediction
        difference = measured - fitted.channels[name] - (offset or 0.0)
        return np.where(fitted.covers, difference, 0.0)

    @cached_property
    def channels(self) -> tuple[ChannelFit, ...]:
        """How well each channel is fitted and predicted."""
        return tuple(map(self.channel_fit, self.model.compared))

    def channel_fit(self, name: str) -> ChannelFit:
        """Return how well a channel is fitted and predicted."""
        measured, offset = self.model.measurement.channels[name], None
        mask, count = self.solution.mask, self.first.count
        if self.model.has_offset:
            difference = measured - self.prediction.channels[name]
            offset = float(difference[:count][mask].mean())
        size = rms(measured - (offset or 0.0)) or 1.0
        residuals = self.residuals(name, offset)
        fitted, rest = residuals[:count], residuals[count:]
        freedom = max(1, int(mask.sum()) - len(self.model.parameters))
        noise = float(np.sqrt(np.sum(fitted[mask] ** 2) / freedom))
        held_out = rms(rest) / size if len(rest) else None
        return ChannelFit(name, noise, rms(fitted) / size, held_out, offset)

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
            negligible = value <= solution.squares.null_share * values[0]
            if negligible or (len(group) == 1 and value * UNKNOWN_SHARE <= 1.0):
                groups |= dict.fromkeys(group, group)
        return groups


def ignore_progress(count: int) -> None:
    """Ignore the progress of a fit."""


class Steps:
    """Expensive steps of a fit: solved by workers, kept in a store, read from it on a resume.

    The same fit takes the same steps in the same order, so that a step is kept by its number.

    Parameters
    ----------
    pool : WorkerPool
    store : Store, optional
        Default: nothing is kept.
    """

    def __init__(self, pool: WorkerPool, store: Store | None = None) -> None:
        self.pool, self.store = pool, store
        self._count = 0

    def map_in_order(
        self,
        function: Callable[[Any], Any],
        items: Sequence[Any],
        restored: Callable[[Any], Any],
        shared: Sequence[object] = (),
    ) -> Iterator[Any]:
        """Yield `function(item)` for every item, in order.

        Parameters
        ----------
        function, items, shared
            As in `WorkerPool.map_in_order`.
        restored : callable
            Returns a result, given the lists and numbers that the store has of it.
        """
        numbers = range(self._count, self._count + len(items))
        self._count = numbers.stop
        values = map(self.store.read_value, numbers) if self.store is not None else ()
        kept = [*takewhile(lambda value: value is not None, values)]
        yield from map(restored, kept)
        results = self.pool.map_in_order(function, items[len(kept) :], shared)
        for number, result in zip(numbers[len(kept) :], results, strict=True):
            if self.store is not None:
                self.store.write_value(number, result)
            yield result


def restored_end(kept: Any) -> tuple[float, Floats]:
    """Return a sum of squares and its parameters, given what a store has of them."""
    cost, x = kept
    return cost, np.array(x)


def restored_profile(kept: Any) -> ParameterProfile:
    """Return a profile, given what a store has of it."""
    low, high, points = kept
    return ParameterProfile(low, high, [ProfilePoint(v, r, np.array(x)) for v, r, x in points])


def fit_law(
    model: FitModel, end: float, steps: Steps, finished: Callable[[int], None]
) -> LawFit:
    """Return the best solution from all starts; `finished` is called with 1 for each.

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
    candidates = [*closed, *steps.map_in_order(first.coarse, closed, np.array, shared)]
    costs = list(map(first.cost, candidates))
    order = np.argsort(costs, kind="stable")[:MAX_STARTS]
    likely = [candidates[i] for i in order]
    if min(map(first.error, likely)) > USELESS:
        likely = likely[:1]  # no start is anywhere near
    part_ends = []
    for x in steps.map_in_order(first.over_parts, likely, np.array, shared):
        part_ends.append(x)
        finished(1)
    finished(MAX_STARTS - len(part_ends))
    indices = first_alike(part_ends)
    distinct = sorted({*indices})
    fine = partial(first.fine, steps=STEPS)
    ends = steps.map_in_order(fine, [part_ends[i] for i in distinct], restored_end, shared)
    end_of = dict(zip(distinct, ends, strict=True))
    followed = [end_of[i] for i in indices]
    _, x = min(followed, key=lambda pair: pair[0])
    solution = final_fit(first, x)
    keys = [key for key in model.fixed_start if key in model.scenario.unstated_start]
    if keys and begins_in_motion(solution, keys):
        started = fit_law(model.with_free_start(keys), end, steps, ignore_progress)
        if started.first.cost(started.solution.x) < first.cost(solution.x):
            return started
    for _ in range(MAX_RESTARTS):
        squares = solution.squares
        other = scan(squares, solution.x)
        if other is not None:
            near = steps.map_in_order(
                partial(squares.fine, other), ((), STEPS[2:]), restored_end
            )
        elif is_noise(solution) or squares.error(solution.x) > USELESS:
            break
        else:
            others = [*neighbours(squares, solution.x)]
            near = steps.map_in_order(squares.fine, others, restored_end)
        cost, x = min(near, key=lambda pair: pair[0])
        if cost >= BETTER * solution.cost:
            break
        solution = final_fit(squares, x)
    return LawFit(model, first, tuple(x for _, x in followed), solution)


def first_alike(points: Sequence[Floats]) -> list[int]:
    """Return the index of the first of the scaled parameters that each of them repeats.

    Starts that met in the parts of a record lead on to the same solution; they differ by less
    than the last step of the derivatives.
    """
    return [
        next(i for i, y in enumerate(points) if np.all(np.abs(x - y) <= STEPS[-1] * sizes(y)))
        for x in points
    ]


def under_base_noise(law_fit: LawFit, steps: Steps) -> LawFit:
    """Return the fit with what the noise of its base adds to the uncertainty.

    No step is kept: the motions with drawn noise take about a fifth of the time of a fit.
    """
    is_fit = EXACT <= law_fit.error <= USELESS
    if not (is_fit and law_fit.model.has_recorded_base):
        return law_fit
    solution, noise = with_base_noise(law_fit.solution, steps.pool, FEW_NOISES)
    ratios = np.array([solution.inflation(j) for j in range(len(solution.x))])
    if ratios.max() > WIDER:  # profiles must stay where the mode of the samples does not change
        solution = final_fit(solution.squares, solution.x, ratios)
    solution, noise = with_base_noise(solution, steps.pool)
    law_fit = replace(law_fit, solution=solution, base_noise=noise)
    at_rest = without_start(law_fit)
    return law_fit if at_rest is None else under_base_noise(at_rest, steps)


def without_start(law_fit: LawFit) -> LawFit | None:
    """Return the fit with the default start; None unless the record may begin there.

    It may not where the file has a start, or where the record shows another one by more than
    the noise of the base, which is not known when the start is chosen.
    """
    model, solution = law_fit.model, law_fit.solution
    free = [p.key for p in model.parameters]
    keys = [key for key in model.scenario.unstated_start if key in free]
    if not keys:
        return None
    started = [free.index(key) for key in keys]
    state = model.scenario.start
    rest = np.array([{"start.x_r": state.x_r, "start.v_r": state.v_r}[key] for key in keys])
    shift = solution.x[started] - rest / law_fit.first.scale[started]
    inverse = np.linalg.pinv(solution.robust_covariance[np.ix_(started, started)])
    if shift @ inverse @ shift > START_CHANCE:
        return None
    kept = [j for j in range(len(free)) if j not in started]
    model = replace(model, parameters=tuple(model.parameters[j] for j in kept))
    first, squares = (
        replace(each, model=model, scale=each.scale[kept])
        for each in (law_fit.first, solution.squares)
    )
    ends = tuple(x[kept] for x in law_fit.ends)
    at_rest = final_fit(squares, solution.x[kept])
    return replace(law_fit, model=model, first=first, ends=ends, solution=at_rest)


def profiles_of(
    law_fit: LawFit, steps: Steps, finished: Callable[[int], None] = ignore_progress
) -> dict[int, ParameterProfile]:
    """Return the profiles of the parameters; of those that depend on others there are none.

    `finished` is called with 1 for each parameter.

    Without a motion that resembles the measured one, or without noise, there are none at all.
    """
    if law_fit.error > USELESS or law_fit.error < EXACT:
        finished(len(law_fit.model.parameters))
        return {}
    groups, every = law_fit.undetermined, range(len(law_fit.model.parameters))
    free = [j for j in every if not len(groups.get(j, ())) > 1]
    held: set[int] = set()
    for group in dict.fromkeys(groups.values()):
        # Without one of them the others are determined.
        held |= {next((j for j in group if j not in held), group[0])}
    determined = [j for j in every if j not in held]
    profile = partial(profile_of, law_fit.solution, determined)
    profiles = {}
    finished(len(every) - len(free))
    for j, kept in zip(free, steps.map_in_order(profile, free, restored_profile), strict=True):
        profiles[j] = kept
        finished(1)
    return profiles


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
    return law_fit.with_solution(solution) if is_better else None


def with_best_static_limit(law_fit: LawFit, profiles: Mapping[int, ParameterProfile]) -> LawFit:
    """Return the fit with the static limit that is best over all samples.

    It is the least one if no other is better by more than a standard deviation: the limit may
    not matter up to some value, and the lowest sum of squares is then that of chance.
    """
    x = law_fit.solution.x.copy()
    for j, profile in profiles.items():
        if law_fit.model.parameters[j].key.startswith(STATIC_PATHS):
            best, least = min(profile.points, key=lambda point: point.rise), profile.points[0]
            x[j] = least.value if least.rise - best.rise < 1.0 else best.value
    return replace(law_fit, solution=law_fit.solution._replace(x=x))


def is_near(value: float, bound: float | None, scale: float) -> bool:
    """Return whether a value is at a bound; the least squares stay inside by a little."""
    if bound is None or not np.isfinite(bound):
        return False
    return abs(value - bound) <= 1e-6 * max(abs(bound), scale)
