"""Joint draws of the fitted values: what a record knows of them, for the studies that follow.

Problem
    The intervals of the values say nothing of their correlation, nor what they leave open of
    the motion. Draws from the likelihood do: each is a scene that explains the record, a draw
    of a static limit at least between events.

Method
    1. Points of a multivariate t distribution about the solution, with its covariance, are
       weighted by the likelihood exp(-rise/2) of the selected samples, over which the motion
       is smooth (importance sampling). Values beyond a bound, and scenes that are not valid,
       have the weight 0. Where too few points bear the weight, a further round draws from the
       mean and covariance of those weighted so far; the points of all rounds count together.
    2. Systematic resampling gives draws without weights.
    3. A static limit that only the order of events bounds is uniform over the interval of its
       profile. Any other is a value as the rest: how long the mass sticks tells it. Its
       likelihood may have several modes, which is why a first round spans its whole interval.
    4. Noise of the base moves the values, which the likelihood does not know, and changes the
       metrics of a motion, often in the same direction. Each draw gets a noise of its own: the
       error of the values that it makes is added, and the motion is solved with it. What else
       the noise of the channels has beyond white noise of the fitted size scales the draws
       about their mean (horizontal adjustment). Values that would leave their bounds stay.
    5. A value that the record does not determine is uniform over what is left open, if it has
       bounds; otherwise there are no draws.

    The points are those of a scrambled Sobol sequence, so that the same fit has the same draws.

Sources: Kong, Liu and Wong, JASA 89 (1994) 278 (effective sample size); Veach and Guibas,
SIGGRAPH 1995 (balance heuristic); Chandler and Bate, Biometrika 94 (2007) 167.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from drysim.core.model import Floats, Samples, Sines
from drysim.errors import WarningMessage
from drysim.scenario.model import STATIC_PATHS, Scenario
from drysim.scenario.sampling import Design, sobol_points
from drysim.study.case import Case
from drysim.study.fit_base_noise import NOISES, drawn_noise
from drysim.study.fit_law import EXACT, USELESS, LawFit, Steps
from drysim.study.fit_least_squares import (
    SMALLEST_STEP,
    Solution,
    covariance_of,
)
from drysim.study.fit_model import is_valid_scene
from drysim.study.fit_profiles import ParameterProfile
from drysim.study.run import try_measure
from drysim.study.statistics import NORMAL_95, median_and_ends
from drysim.wording import join_words

DRAWS = NOISES
"""Number of draws: the ends of a 95 % interval have 6 of them beyond."""

POINTS, ROUNDS = 512, 5
"""Points of a round, and most rounds. A round takes 5 % of the time of a fit, one of a law with
series 25 %."""

FREEDOM = 5.0
"""Degrees of freedom of the t distribution: its tails are heavier than those of any likelihood
that is near to a normal one, and its weights are still alike."""

POOR = 100.0
"""Effective number of points below which the ends of an interval are uncertain."""

POINTS_PER_STEP, DRAWS_PER_STEP = 32, 16
"""Points, and draws whose metrics are computed, that a worker solves at a time."""

WIDER = 1.5
"""Ratio of the intervals from profile and covariance from which the former counts."""

SINGULAR = 1e-10
"""Least eigenvalue of a covariance, relative to the largest."""


class Draws(NamedTuple):
    """Joint draws of the fitted values, and metrics of the motion of each."""

    keys: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats
    """In SI, shape (n, p); without rows if there are none."""
    effective: float
    """Number of points that bear the weight."""
    metrics: Mapping[str, Floats] = MappingProxyType({})
    """Metrics of each draw on the measured base, less what noise of the base changes in them;
    shape (n,) each, NaN where the motion has none."""
    reason: str = ""
    """Why there are none; empty if there are."""

    @property
    def points(self) -> list[dict[str, float]]:
        """The draws by key."""
        return [dict(zip(self.keys, row, strict=True)) for row in self.values.tolist()]

    def interval(self, name: str) -> tuple[float, float] | None:
        """Return the 95 % interval of a metric; None if a draw has no value."""
        values = self.metrics.get(name, np.empty(0))
        if not len(values) or np.isnan(values).any():
            return None
        _, low, high = median_and_ends(values)
        return low, high


class Range(NamedTuple):
    """Ends of what the record leaves open of a value, in scaled parameters."""

    low: float
    high: float

    @property
    def deviation(self) -> float:
        """Standard deviation of a uniform distribution."""
        return (self.high - self.low) / float(np.sqrt(12.0))


def draw(
    law_fit: LawFit, reported: LawFit, profiles: Mapping[int, ParameterProfile], steps: Steps
) -> Draws:
    """Return joint draws of the values of a fit.

    Parameters
    ----------
    law_fit : LawFit
        The least-squares solution.
    reported : LawFit
        The same with the static limit that is best over all samples.
    profiles : mapping
    steps : Steps
        Solves the points.
    """
    parameters, solution = law_fit.model.parameters, law_fit.solution
    keys, units = tuple(p.key for p in parameters), tuple(p.unit for p in parameters)
    none = Draws(keys, units, np.empty((0, len(keys))), 0.0)
    if law_fit.error > USELESS:
        return none._replace(reason="the fitted motion is not the measured one")
    if reason := open_reason(law_fit, profiles):
        return none._replace(reason=reason)
    unknown = [
        j for j in law_fit.undetermined
        if keys[j].startswith(STATIC_PATHS)
        or is_open(profiles.get(j))
        or not solution.jacobian[:, j].any()
    ]  # fmt: skip
    regular = [j for j in range(len(keys)) if j not in unknown]
    x = np.tile(reported.solution.x, (DRAWS, 1))
    effective = float(DRAWS)
    if regular:
        likelihood = Likelihood(
            solution, tuple(regular), first_rounds(law_fit, profiles, regular)
        )
        x[:, regular], effective = likelihood.draw(steps, law_fit.error < EXACT)
    shares = sobol_points(Design("sobol", DRAWS, len(keys), 1))
    shares = (np.argsort(np.argsort(shares, axis=0), axis=0) + 0.5) / DRAWS
    for j in unknown:
        ends = range_of(law_fit, profiles.get(j), j)
        x[:, j] = ends.low + shares[:, j] * (ends.high - ends.low)
    return none._replace(
        values=valid_values(law_fit, x, reported.solution.x), effective=effective
    )


def wide_range(law_fit: LawFit, profile: ParameterProfile | None, j: int) -> Range | None:
    """Return the range of a parameter of which the covariance tells too little; else None.

    Bounds may be narrower. The likelihood may also be flat about the solution, and fall far
    from it only, as the profile shows; that of a static limit may have other modes.
    """
    solution = law_fit.solution
    bounds = Range(*(float(ends[j]) for ends in solution.squares.bounds))
    if bounds.deviation < solution.deviation(j):
        return bounds
    ends = range_of(law_fit, profile, j)
    usual = 2.0 * NORMAL_95 * solution.deviation(j)
    is_static = law_fit.model.parameters[j].key.startswith(STATIC_PATHS)
    is_wide = is_static or ends.high - ends.low > WIDER * usual
    return ends if profile is not None and is_wide and np.isfinite(ends.deviation) else None


def valid_values(law_fit: LawFit, x: Floats, instead: Floats) -> Floats:
    """Return scaled parameters in SI, within their bounds.

    Where x is no valid scene, those of `instead` take its place.
    """
    model, scale, rows = law_fit.model, law_fit.first.scale, []
    for row in x:
        values = np.clip(row * scale, *model.bounds)
        scene = model.scene(values)
        if not is_valid_scene(scene.law, scene.start):
            values = np.clip(instead * scale, *model.bounds)
        rows.append(list(model.point(values).values()))
    return np.array(rows)


def is_open(profile: ParameterProfile | None) -> bool:
    """Return whether a profile excludes no value, or there is none."""
    return profile is None or (profile.low is None and profile.high is None)


def range_of(law_fit: LawFit, profile: ParameterProfile | None, j: int) -> Range:
    """Return what a record leaves open of a parameter; without an end where nothing bounds it.

    A profile has no end where the record excludes nothing up to the bound of the parameter.
    """
    low, high = (float(ends[j]) for ends in law_fit.solution.squares.bounds)
    if profile is not None:
        low = low if profile.low is None else profile.low
        high = high if profile.high is None else profile.high
    if law_fit.model.parameters[j].key.startswith(STATIC_PATHS):
        low = max(low, kinetic_limit(law_fit, j))
    return Range(low, high)


def open_reason(law_fit: LawFit, profiles: Mapping[int, ParameterProfile]) -> str:
    """Return which values the record leaves open without a bound; empty if there are none."""
    model = law_fit.model
    for group in law_fit.undetermined.values():
        if len(group) > 1:
            named = join_words([model.parameters[j].key for j in group])
            return f"only the ratios of {named} follow; state one of them"
    for j, parameter in enumerate(model.parameters):
        if j not in profiles and j not in law_fit.undetermined:
            continue
        ends = range_of(law_fit, profiles.get(j), j)
        missing = [
            word
            for word, end in (("from", ends.low), ("to", ends.high))
            if not np.isfinite(end)
        ]
        if missing:
            both = join_words([f"`{word}`" for word in missing])
            return (
                f"the record sets no {'end' if len(missing) == 1 else 'ends'} to "
                f"{parameter.key}; give {both} for it in fit.free"
            )
    return ""


def kinetic_limit(law_fit: LawFit, j: int) -> float:
    """Return the scaled static limit that equals kinetic friction."""
    model, x = law_fit.model, law_fit.solution.x
    law = model.scene(np.clip(x * law_fit.first.scale, *model.bounds)).law
    forces = law.F_fk, law.F_fs
    if model.parameters[j].key.endswith(".compression") and law.compression:
        forces = law.compression
    return float(x[j]) * forces[0] / (forces[1] or 1.0)


class Round(NamedTuple):
    """Centre and scale of the points of a round."""

    centre: Floats
    root: Floats
    """Square root of the scale matrix."""

    def points(self, shares: Floats) -> Floats:
        """Return points of the t distribution for points of the unit cube."""
        from scipy.special import gammaincinv, ndtri

        normal = ndtri(np.clip(shares[:, :-1], 1e-15, 1.0 - 1e-15))
        square = 2.0 * gammaincinv(0.5 * FREEDOM, np.clip(shares[:, -1:], 1e-15, 1.0))
        points: Floats = self.centre + (normal / np.sqrt(square / FREEDOM)) @ self.root.T
        return points

    def log_density(self, x: Floats) -> Floats:
        """Return the logarithm of the density, up to a constant of all rounds."""
        scaled = np.linalg.solve(self.root, (x - self.centre).T)
        power = 0.5 * (FREEDOM + len(self.centre))
        logarithm: Floats = -power * np.log1p(np.sum(scaled**2, axis=0) / FREEDOM)
        return logarithm - float(np.linalg.slogdet(self.root)[1])


def first_rounds(
    law_fit: LawFit, profiles: Mapping[int, ParameterProfile], regular: list[int]
) -> tuple[Round, ...]:
    """Return the rounds to begin with: about the solution and, if any is wide, over the ranges.

    Parameters
    ----------
    law_fit : LawFit
    profiles : mapping
    regular : list of int
        The parameters of the rounds.
    """
    solution = law_fit.solution
    narrow = [wide_range(law_fit, None, j) for j in regular]
    ranges = [wide_range(law_fit, profiles.get(j), j) for j in regular]
    first = round_over(
        narrow, solution.x[regular], covariance_of(solution.jacobian[:, regular])
    )
    if ranges == narrow:
        return (first,)
    covariance = solution.robust_covariance[np.ix_(regular, regular)]
    return first, round_over(ranges, solution.x[regular], covariance)


def round_over(ranges: Sequence[Range | None], centre: Floats, covariance: Floats) -> Round:
    """Return a round whose parameters with a range span it, without correlation."""
    centre, covariance = centre.copy(), covariance.copy()
    for i, ends in enumerate(ranges):
        if ends is not None:
            centre[i] = 0.5 * (ends.low + ends.high)
            covariance[i], covariance[:, i] = 0.0, 0.0
            covariance[i, i] = ends.deviation**2
    return Round(centre, root_of(covariance))


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Likelihood of the selected samples over some parameters, static limits as fitted."""

    solution: Solution
    regular: tuple[int, ...]
    first_rounds: tuple[Round, ...]

    def given_others(self, covariance: Floats) -> Floats:
        """Return the matrix that maps errors of all parameters to those left of the regular.

        What is left does not correlate with the errors of the others, which stay as fitted. A
        deviation as small as rounding is that of a jump, and its correlations are rounding.
        """
        of, others = list(self.regular), range(len(covariance))
        given = [j for j in others if j not in of and covariance[j, j] > SMALLEST_STEP**2]
        left: Floats = np.eye(len(covariance))[of]
        across = covariance[np.ix_(of, given)]
        left[:, given] = -across @ np.linalg.pinv(covariance[np.ix_(given, given)])
        return left

    def draw(self, steps: Steps, is_exact: bool = False) -> tuple[Floats, float]:
        """Return draws, and the effective number of points.

        The residuals of an exact fit are rounding: their likelihood means nothing, and the
        draws are those of the normal distribution.
        """
        solution, count = self.solution, len(self.regular)
        rounds = [*self.first_rounds]
        first = rounds[0]
        if is_exact:
            from scipy.special import ndtri

            shares = sobol_points(Design("sobol", DRAWS, count, 0))
            normal = ndtri(np.clip(shares, 1e-15, 1.0 - 1e-15))
            return first.centre + normal @ first.root.T, DRAWS
        x, squares = np.empty((0, count)), np.empty(0)
        for number in range(ROUNDS):
            shares = sobol_points(Design("sobol", POINTS, count + 1, number))
            points = rounds[number].points(shares)
            x = np.concatenate([x, points])
            squares = np.append(squares, self.sums_of_squares(points, steps))
            if not np.isfinite(squares).any():  # all lie beyond narrow bounds
                alone = solution.x[None, list(self.regular)]
                x = np.append(x, alone, axis=0)
                squares = np.append(squares, solution.sum_of_squares)
            densities = [each.log_density(x) for each in rounds[: number + 1]]
            logarithms = -0.5 * squares - np.logaddexp.reduce(densities, axis=0)
            weights = np.exp(logarithms - logarithms.max())
            effective = effective_size(weights)
            is_begun = number + 1 >= len(self.first_rounds)
            if (is_begun and effective >= DRAWS) or number == ROUNDS - 1:
                break
            if is_begun:
                rounds.append(adapted(x, weights, first))
        return self.adjusted_draws(x[resampled(weights)]), effective

    def adjusted_draws(self, drawn: Floats) -> Floats:
        """Return draws of the likelihood, with the errors by noise that it does not contain.

        A value that the errors move beyond a bound stays as drawn, and the others lose the part
        of their errors that correlates with its error.
        """
        solution = self.solution
        plain, robust = solution.covariance, solution.robust_covariance
        if np.array_equal(plain, robust):
            return drawn
        errors = np.zeros((DRAWS, len(plain)))
        if solution.base_errors is not None:
            errors = solution.base_errors
        solved = max(1, int(errors.any(axis=1).sum()))
        white = robust - errors.T @ errors / solved
        left, left_robust = map(self.given_others, (plain, robust))
        matrix = adjustment(left @ plain @ left.T, left_robust @ white @ left_robust.T)
        mean = drawn.mean(axis=0)  # of all modes
        changes = (drawn - mean) @ (matrix - np.eye(len(mean))).T + errors @ left_robust.T
        covariance = left_robust @ robust @ left_robust.T
        low, high = (ends[list(self.regular)] for ends in solution.squares.bounds)
        draws: Floats = drawn + changes
        for i in np.flatnonzero([not self.is_allowed(point) for point in draws]):
            held = np.zeros(len(mean), dtype=bool)
            for _ in mean:
                held |= (draws[i] < low) | (draws[i] > high)
                across = covariance[:, held] @ np.linalg.pinv(covariance[np.ix_(held, held)])
                draws[i] = drawn[i] + np.where(
                    held, 0.0, changes[i] - across @ changes[i, held]
                )
            if not self.is_allowed(draws[i]):
                draws[i] = drawn[i]
        return draws

    def is_allowed(self, point: Floats) -> bool:
        """Return whether a point is within bounds, and static limits above kinetic ones."""
        squares, regular = self.solution.squares, list(self.regular)
        x = self.at(point)
        low, high = squares.bounds
        values = x * squares.scale
        allowed = np.array([*squares.model.point(values).values()])
        inside = (low <= x) & (x <= high) & (allowed <= values + 1e-12 * np.abs(values))
        return bool(inside[regular].all())

    def at(self, point: Floats) -> Floats:
        """Return all parameters, with the regular ones of a point."""
        x: Floats = self.solution.x.copy()
        x[list(self.regular)] = point
        return x

    def sums_of_squares(self, points: Floats, steps: Steps) -> Floats:
        """Return the sums of squares at points; infinite beyond a bound and for no scene."""
        parts = np.array_split(points, -(-len(points) // POINTS_PER_STEP))
        return np.concatenate([*steps.map_in_order(partial(squares_at, self), parts, np.array)])


def squares_at(likelihood: Likelihood, points: Floats) -> Floats:
    """Return the sums of squares at some points."""
    squares, mask, sums = likelihood.solution.squares, likelihood.solution.mask, []
    for point in points:
        is_allowed = likelihood.is_allowed(point)
        solved = squares.solve(likelihood.at(point)) if is_allowed else None
        residuals = None if solved is None else squares.residuals(solved, mask)
        sums.append(np.inf if residuals is None else float(np.sum(residuals**2)))
    return np.array(sums)


def effective_size(weights: Floats) -> float:
    """Return the number of equal weights that estimate a mean as well as these."""
    return float(weights.sum() ** 2 / np.sum(weights**2))


def adapted(x: Floats, weights: Floats, first: Round) -> Round:
    """Return the next round, about the points weighted so far.

    Where few points bear the weight, their covariance would be that of chance: the weights are
    evened out until enough do.
    """
    enough = min(10.0 * (x.shape[1] + 1), 0.5 * np.count_nonzero(weights))
    while effective_size(weights) < enough:
        weights = np.sqrt(weights)
    share = weights / weights.sum()
    centre = share @ x
    spread = (x - centre) * np.sqrt(share)[:, None]
    floor = 1e-6 * first.root @ first.root.T
    return Round(centre, root_of(spread.T @ spread + floor))


def resampled(weights: Floats) -> Any:
    """Return the indices of the draws, by systematic resampling, in random order."""
    total = np.cumsum(weights)
    places = (np.arange(DRAWS) + 0.5) / DRAWS * total[-1]
    chosen = np.minimum(np.searchsorted(total, places), len(weights) - 1)
    return np.random.default_rng(0).permutation(chosen)


def root_of(covariance: Floats) -> Floats:
    """Return a square root of a covariance.

    Values that replace each other make it singular to rounding, so that eigenvalues below 0
    are possible.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    values = np.maximum(values, SINGULAR * values[-1])
    root: Floats = size[:, None] * (vectors * np.sqrt(values)) @ vectors.T
    return root


def adjustment(plain: Floats, robust: Floats) -> Floats:
    """Return the matrix that gives what has the plain covariance the robust one."""
    matrix: Floats = root_of(robust) @ np.linalg.inv(root_of(plain))
    return matrix


def draws_warnings(draws: Draws) -> Iterator[WarningMessage]:
    """Warn of draws that few points bear."""
    if len(draws.values) and draws.effective < POOR:
        sentence = (
            f"the draws of the fitted values rest on {draws.effective:.0f} effective points "
            "only: their intervals, and those of the motion, are rough"
        )
        yield WarningMessage("few-draws", sentence, {"effective": draws.effective})


# The motion of each draw


def with_metrics(
    draws: Draws, case: Case, names: Sequence[str], steps: Steps, noise: float = 0.0
) -> Draws:
    """Return draws with metrics of their motions on the base motion of a case.

    Parameters
    ----------
    draws : Draws
    case : Case
    names : sequence of str
    steps : Steps
    noise : float, optional
        Standard deviation of the noise of the base motion [m/s²].
    """
    points = [
        {key: value for key, value in point.items() if not key.startswith("measured.")}
        for point in draws.points
    ]
    numbered = [*enumerate(points)]
    parts = [numbered[i : i + DRAWS_PER_STEP] for i in range(0, len(numbered), DRAWS_PER_STEP)]
    function = partial(metrics_at, case.scenario, case.motion, tuple(names), noise)
    rows = np.concatenate([*steps.map_in_order(function, parts, np.array)])
    return draws._replace(metrics=dict(zip(names, rows.T, strict=True)))


def metrics_at(
    scenario: Scenario,
    motion: Sines | Samples,
    names: tuple[str, ...],
    noise: float,
    points: Sequence[tuple[int, dict[str, float]]],
) -> Floats:
    """Return metrics of a scenario at numbered points, shape (n, names); NaN where unknown.

    The measured base has its noise once. Noise that is added to it changes a metric as the
    first one did, which is why the change is subtracted.
    """
    rows = []
    for number, point in points:
        scene = scenario.at(point)
        row = metrics_on(scene, motion, names)
        if noise > 0.0:
            assert isinstance(motion, Samples), "noise is that of a record"
            u_dd = np.asarray(motion.u_dd[:])
            u_dd = u_dd + drawn_noise(noise, number, len(u_dd))
            noisy = motion._replace(u_dd=u_dd, u=None, mean_squares=None)
            row = 2.0 * row - metrics_on(scene, noisy, names)
        rows.append(row)
    return np.array(rows)


def metrics_on(scene: Scenario, motion: Sines | Samples, names: Sequence[str]) -> Floats:
    """Return metrics of a scene on a base motion; NaN where unknown."""
    (metrics, _, _), _ = try_measure(scene, lambda _: motion)
    return np.array([metrics.get(name) for name in names], dtype=np.float64)
