"""Fit to transmissibility curves that were measured under random base motion.

Problem
    Dry friction is not linear: the transmissibility under noise depends on its level, on its
    spectrum and on the estimator, and differs from that under a sine. The laboratory's signal
    is not known, only its spectrum.

Method
    1. Signals with the stated spectrum are generated for each level, from fixed seeds, and the
       exact motion is solved under them. The estimator is that of `drysim assess`: Welch's
       method and H1, H2 or Hv. The same signals at all values make the ratios smooth functions
       of these, but for small jumps.
    2. Starts as for sines, judged and followed under one short signal of each level.
    3. Least squares under all signals. A row has three sources of error: noise of the
       measurement, white over the rows; the scatter of the estimate over the laboratory's
       finite record; and that of the finite simulation. The latter follows from blocks of
       segments, and the former has the same covariance times the ratio of the two times. This
       ratio and the noise are variance components, by least squares of the products of
       neighbouring residuals.
    4. The scatter is alike in neighbouring lines, and in T_a and T_x of one record, so that the
       covariance of the values is a sandwich, as under noise of a base record.
    5. Profiles and draws use the second-order Taylor polynomial of log T about the solution.

Sources: Bendat and Piersol, Random Data (2010), sections 6.2, 9.2; Rao, MINQUE theory and its
relation to ML and MML estimation of variance components, Sankhya B 41 (1979) 138.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from math import ceil, floor
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.stick_slip import StickSlip
from drysim.core.compile import choose_engine
from drysim.core.model import CoulombLaw, Floats, Samples
from drysim.errors import SolverError
from drysim.excitation.random import RandomMotion
from drysim.metrics.comfort import Complexes, averaging_gain, base_means
from drysim.metrics.spectra import (
    MIN_POWER_SHARE,
    MIN_SEGMENT_TIME,
    MIN_SEGMENTS,
    segment_transforms,
)
from drysim.scenario.fit import RATIOS
from drysim.scenario.model import STATIC_PATHS, Scenario
from drysim.study.fit_curves import (
    CURVES,
    EXCHANGED,
    NOT_FITTED,
    STARTS_TRIED,
    CurveFit,
    CurveModel,
    CurveSquares,
    curve_names,
    curves_of_levels,
    exchange_levels,
    final_fit,
    follow_starts,
    read_model,
    suspects,
    with_level,
)
from drysim.study.fit_law import Steps
from drysim.study.fit_least_squares import (
    Differentiable,
    Solution,
    covariance_of,
    minimise,
    sizes,
)
from drysim.study.fit_model import fit_of
from drysim.study.preparation import base_motion
from drysim.study.statistics import NORMAL_95, student_t
from drysim.study.welch import check_segment
from drysim.wording import format_number, format_range

NYQUIST = 2.0
"""Half the sampling rate of the series that are transformed over the last frequency of the
base, at least: what is folded back changes a ratio by a few thousandths at most."""

SIMULATED_TIME = 2400.0
"""Simulated time of each level, unless the scenario states its number of seeds [s]. That of a
laboratory is some minutes."""

BLOCKS = 80
"""Blocks of segments whose scatter is that of an estimate: its deviation is known to 8 %."""

SEGMENTS_PER_BLOCK = 4
"""Fewest segments of a block, so that overlapping ones in other blocks hardly matter."""

NEAR_LINES = 2.5
"""Lines of the spectra within which the errors of rows are alike, under a Hann window."""

COMPONENT_STEPS = 5
"""Repetitions of the variance components, whose weights depend on them."""

LEVEL_STEP = 0.02
"""Relative step of the derivatives by the level of a curve."""

WRONG_LEVEL, LEAST_CHANGE = 4.0, 0.05
"""Standard deviations from which a level is called wrong, and its least relative change."""

LEVEL_SEEDS, LEVEL_CALLS = 2, 12
"""Signals and evaluations of the fits that tell which level it is, and by what factor."""

GOOD_FIT = 0.2
"""Relative error of curves explained, under few signals: RMS without the worst tenth."""

LEAST_FREEDOM = 5.0
"""Least degrees of freedom of a variance."""

FIRST_TAYLOR_STEP, TAYLOR_STEP, TAYLOR_STEPS = 0.05, 1.5, (0.01, 0.3)
"""Steps of the polynomial: relative, of the first one; in standard deviations of the values, of
the others; and the bounds of these, relative."""

STATIC_STEP = 0.25
"""The same of a static limit, relative: one near kinetic friction has next to no effect, so
that its interval is wider than the deviation tells."""

NEAREST = 0.3
"""Share of a step from which a bound is far enough to be a point of a polynomial."""

REACH = 3.0
"""Steps within which a polynomial leads to the centre of the next one."""

MAX_POLYNOMIALS = 6
"""Number of polynomials, each about the minimum of the one before."""

ESTIMATORS = {"H1": (-1.0, 0.0, 1.0), "H2": (0.0, 1.0, -1.0), "Hv": (-0.5, 0.5, 0.0)}
"""Exponents of G_u, G_x and |G_ux| in the size of a transmissibility."""


class LevelSignals(NamedTuple):
    """Base motions of one level, and what the estimates need of them."""

    motions: tuple[Samples, ...]
    transforms: Complexes
    """Of ü, linear between samples, shape (lines, segments) over all motions."""
    means: Floats
    """Mean of ü in each step of the window, shape (motions, steps) [m/s²]."""


class Scatter(NamedTuple):
    """Signals of a fit under random base motion, and times that its estimates average over."""

    first_seed: int
    signals: int
    simulated: float
    """Simulated time of each level [s]."""
    measured: float | None
    """Time over which the curves seem to be averaged, by their scatter [s]; None if their
    scatter is too small to tell, or all times are stated."""
    is_stated: bool


class Group(NamedTuple):
    """Rows of one level, ratio and estimator."""

    level: int
    ratio: str
    estimator: str
    rows: NDArray[np.intp]
    line: NDArray[np.intp]
    """Index of the line at or below the frequency of each row."""
    share: Floats
    """Distance of the frequency from this line, in lines."""

    def between(self, lines: Floats) -> Floats:
        """Return values at the lines, along the first axis, at the frequencies of the rows."""
        share = self.share.reshape(-1, *[1] * (lines.ndim - 1))
        values: Floats = (1.0 - share) * lines[self.line] + share * lines[self.line + 1]
        return values


@dataclass(frozen=True, eq=False)
class SpectrumModel(CurveModel):
    """The rows of curves measured under random base motion, as a function of the free keys."""

    segment: float = MIN_SEGMENT_TIME
    """Length of a segment of the spectra [s]."""
    seeds: int = 1
    """Number of signals of each level."""

    slope_step: ClassVar[float] = 5e-3  # over the small jumps
    tolerance: ClassVar[float] = 1e-3
    dampings: ClassVar[tuple[float, ...]] = (0.1, 0.3, 0.8)
    static_ratios: ClassVar[tuple[float, ...]] = (1.25,)

    @cached_property
    def levels(self) -> tuple[Floats, NDArray[np.intp]]:
        """Index of the signals and RMS value [m/s²] of each level, shape (2, n); level of rows.

        Curves of one stated level have the same signals, also where the level of one is tried
        at another value.
        """
        stated = [curve.level for curve in fit_of(self.scenario).curves or ()]
        signals = np.array([sorted(set(stated)).index(level) for level in stated])
        pairs = np.stack([signals[self.rows.curve], self.rows.rms])
        levels, inverse = np.unique(pairs, axis=1, return_inverse=True)
        return levels, inverse.ravel()

    @cached_property
    def stride(self) -> int:
        """Steps of the motion in each step of the series that are transformed.

        It divides a segment, whose lines are those of the laboratory.
        """
        excitation, dt = self.scenario.excitation, self.case.step
        assert isinstance(excitation, RandomMotion), "the base motion has a spectrum"
        largest = max(1, floor(0.5 / (NYQUIST * excitation.band[1] * dt)))
        steps = round(self.segment / dt)
        return next(each for each in range(largest, 0, -1) if steps % each == 0)

    @property
    def dt(self) -> float:
        """Step of the series that are transformed [s]."""
        return self.stride * self.case.step

    @property
    def points(self) -> slice:
        """Grid points between which accelerations are means, within the window."""
        begin, end = (round(end / self.case.step) for end in self.case.window)
        return slice(begin, begin + (end - begin) // self.stride * self.stride + 1, self.stride)

    @property
    def time(self) -> float:
        """Simulated time of each level [s]."""
        begin, end = self.case.window
        return self.seeds * (end - begin)

    @cached_property
    def stated_times(self) -> Floats:
        """Ratio of the simulated to the measured time of each row; NaN if it is not stated."""
        curves = fit_of(self.scenario).curves or ()
        stated = [np.nan if each.duration is None else each.duration for each in curves]
        return np.asarray(self.time / np.array(stated)[self.rows.curve])

    @cached_property
    def frequencies(self) -> Floats:
        """Frequencies of the lines that are needed [Hz]."""
        spacing = line_spacing(self.segment, self.dt)
        count = ceil(float(self.rows.frequency.max()) / spacing) + 1
        lines: Floats = spacing * np.arange(1.0, count + 1.0)
        return lines

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The rows by level, ratio and estimator."""
        rows, curves = self.rows, fit_of(self.scenario).curves or ()
        names = np.array([curve.estimator for curve in curves])[rows.curve]
        groups = []
        for level in range(self.levels[0].shape[1]):
            for i, ratio in enumerate(RATIOS):
                for name in ESTIMATORS:
                    here = (self.levels[1] == level) & (rows.ratio == i) & (names == name)
                    if here.any():
                        place = rows.frequency[here] / self.frequencies[0] - 1.0
                        line = np.maximum(place.astype(np.intp), 0)
                        index = np.flatnonzero(here)
                        groups.append(Group(level, ratio, name, index, line, place - line))
        return tuple(groups)

    def transforms(self, series: Floats) -> Complexes:
        """Return the transforms of series, shape (motions, n), as (lines, segments) of all."""
        n = round(self.segment / self.dt)
        lines = segment_transforms(series, n, self.dt)[:, : len(self.frequencies)]
        joined: Complexes = np.moveaxis(lines, 0, 1).reshape(lines.shape[1], -1)
        return joined

    @cached_property
    def gain(self) -> Floats:
        """Gain of the mean over a step at the lines, shape (lines, 1)."""
        gain = averaging_gain(self.frequencies, self.dt)
        return gain[:, None]

    @cached_property
    def signals(self) -> tuple[LevelSignals, ...]:
        """The base motions of all levels, each with seeds of its own."""
        excitation = self.scenario.excitation
        assert isinstance(excitation, RandomMotion), "the base motion has a spectrum"
        signals = []
        for index, level in self.levels[0].T.tolist():
            motions, first = [], excitation.seed + self.seeds * int(index)
            for seed in range(first, first + self.seeds):
                of_seed = self.scenario.copy_with({"excitation": excitation.with_seed(seed)})
                motions.append(scaled(base_motion(of_seed), level))
            steps = slice(self.points.start, self.points.stop - 1)
            means = np.array([base_means(each, each.dt, len(each.u_dd)) for each in motions])
            means = means[:, steps].reshape(self.seeds, -1, self.stride).mean(axis=2)
            transforms = self.transforms(means) / self.gain
            signals.append(LevelSignals(tuple(motions), transforms, means))
        return tuple(signals)

    def responses(self, values: Floats, level: int) -> tuple[dict[str, Complexes], float]:
        """Return the transforms of the response at a level by ratio, and the stuck share.

        They are those of the acceleration of the mass, and of the relative displacement times
        ω², shape (lines, segments).

        Raises
        ------
        SolverError
            If the motion cannot be computed.
        """
        signals, scene = self.signals[level], self.scene(values)
        wanted = {group.ratio for group in self.groups if group.level == level}
        v_r, x_r = [], []
        for motion in signals.motions:
            response = self.case.approach.solve(
                *scene[:2], motion, scene.start, self.case.step, self.case.window[1]
            )
            v_r.append(response.v_r[self.points])
            x_r.append(response.x_r[self.points][:-1])
        transforms = {}
        if "T_a" in wanted:
            means = signals.means + np.diff(np.array(v_r), axis=1) / self.dt
            transforms["T_a"] = self.transforms(means) / self.gain
        if "T_x" in wanted:
            omega = 2.0 * np.pi * self.frequencies[:, None]
            transforms["T_x"] = omega**2 * self.transforms(np.array(x_r))
        return transforms, float(np.mean(np.array(v_r) == 0.0))

    def ratios(self, values: Floats) -> tuple[Floats, Floats]:
        """Return the ratios and the shares of sticking, of shape (k, n), as for sines."""
        ratios = np.full(
            (len(values), len(self.rows.measured)), 10.0 * self.rows.measured.max()
        )
        stuck = np.zeros_like(ratios)
        for k, some in enumerate(values):
            for level, signals in enumerate(self.signals):
                try:
                    responses, share = self.responses(some, level)
                except SolverError:
                    continue
                stuck[k, self.levels[1] == level] = share
                for group in self.groups:
                    if group.level == level:
                        spectra = spectral_matrix(signals.transforms, responses[group.ratio])
                        ratio = size_of_transfer(group.estimator, *spectra)
                        ratios[k, group.rows] = np.maximum(group.between(ratio), LEAST_RATIO)
        return ratios, stuck

    def scatter(self, values: Floats) -> list[tuple[NDArray[np.intp], Floats]]:
        """Return rows of each level, and the relative errors of their estimates.

        The errors E, shape (rows, blocks), have one column for each block of segments; E E' is
        the covariance of an estimate over the simulated time.
        """
        scatter = []
        for level, signals in enumerate(self.signals):
            responses, _ = self.responses(values, level)
            index, errors = [], []
            for group in self.groups:
                if group.level == level:
                    both = signals.transforms, responses[group.ratio]
                    index.append(group.rows)
                    errors.append(relative_errors(group, *both))
            scatter.append((np.concatenate(index), np.concatenate(errors)))
        return scatter

    @property
    def short(self) -> SpectrumModel:
        """The model under one signal of each level, to find and to follow starts."""
        return replace(self, seeds=1)


def scaled(motion: object, rms: float) -> Samples:
    """Return a random signal with this RMS value [m/s²]."""
    assert isinstance(motion, Samples), "random base motion is sampled"
    factor = rms / signal_rms(motion)
    return motion._replace(u_dd=factor * np.asarray(motion.u_dd), u=None, mean_squares=None)


def signal_rms(motion: Samples) -> float:
    """Return the RMS value of a random signal, linear between its samples [m/s²]."""
    rms = motion.realised["rms"]
    assert isinstance(rms, float), "a generated signal has an RMS value"
    return rms


def line_spacing(segment: float, dt: float) -> float:
    """Return the distance of the lines of segments of a whole number of steps [Hz]."""
    return 1.0 / (round(segment / dt) * dt)


def size_of_transfer(estimator: str, G_u: Floats, G_x: Floats, G_ux: Complexes) -> Floats:
    """Return |H1|, |H2| or |Hv| [-]; 0 where the response is at rest."""
    a, b, c = ESTIMATORS[estimator]
    moves = np.abs(G_ux) > 0.0
    size: Floats = G_u**a * G_x**b * np.where(moves, np.abs(G_ux), 1.0) ** c
    return np.where(moves, size, 0.0)


def spectral_matrix(U: Complexes, X: Complexes) -> tuple[Floats, Floats, Complexes]:
    """Return G_u, G_x and G_ux at lines, given transforms of shape (lines, segments)."""

    def mean(a: Complexes, b: Complexes) -> Complexes:
        product: Complexes = np.einsum("ij,ij->i", np.conj(a), b) / a.shape[1]
        return product

    return mean(U, U).real, mean(X, X).real, mean(U, X)


def relative_errors(group: Group, U: Complexes, X: Complexes) -> Floats:
    """Return the relative errors of the rows of a group by blocks of segments.

    They are those of `SpectrumModel.scatter`: to first order in the spectra of each block.
    """
    whole, segments = spectral_matrix(U, X), U.shape[1]
    blocks = int(np.clip(segments // SEGMENTS_PER_BLOCK, 2, BLOCKS))
    if not X.any():  # a mass that never slides has no scatter
        return np.zeros((len(group.rows), blocks))
    edges = np.round(np.linspace(0, segments, blocks + 1)).astype(np.intp).tolist()
    ratio, changes = size_of_transfer(group.estimator, *whole), np.zeros((len(U), blocks))
    for b in range(blocks):
        part = slice(edges[b], edges[b + 1])
        for power, mean, of_block in zip(
            ESTIMATORS[group.estimator], whole, spectral_matrix(U[:, part], X[:, part]),
            strict=True,
        ):  # fmt: skip
            changes[:, b] += power * ((of_block / mean).real - 1.0)
    errors = group.between(ratio[:, None] * changes) / group.between(ratio)[:, None]
    errors -= errors.mean(axis=1, keepdims=True)
    return np.asarray(errors / np.sqrt(blocks * (blocks - 1.0)))


def build_spectrum_model(scenario: Scenario) -> SpectrumModel:
    """Read the curves of a fit block that were measured under random base motion.

    Raises
    ------
    RecordError
        If a file cannot be used.
    ScenarioError
        If the scenario has no such motions, or the spectrum does not reach a frequency.
    """
    excitation, curves = scenario.excitation, fit_of(scenario).curves or ()
    assert isinstance(excitation, RandomMotion), "the base motion has a spectrum"
    for i, curve in enumerate(curves):
        if curve.rms is None:
            key, _ = curve.level
            sentence = (
                f"fit.curves #{i + 1}: {key} is that of a sine, but the base motion is random; "
                "give rms, the RMS value of its acceleration"
            )
            raise scenario.error(sentence, ("fit", "curves", i, key))
    law = scenario.law()
    is_exact = isinstance(scenario.solver.member(), StickSlip)
    if not is_exact or not isinstance(law, CoulombLaw) or law.stops is not None:
        raise scenario.error(NOT_FITTED, ("fit", "curves"))
    model, rows = read_model(scenario)
    choose_engine(10**9, model.case.kernels)
    begin, end = model.case.window
    segment = scenario.measure.segment or min(MIN_SEGMENT_TIME, (end - begin) / MIN_SEGMENTS)
    check_segment(model.case, segment)
    spectrum = SpectrumModel.of(model, rows)
    seeds = excitation.seeds or ceil(SIMULATED_TIME / (end - begin))
    spectrum = replace(spectrum, segment=segment, seeds=seeds)
    check_frequencies(spectrum)
    return spectrum


def check_frequencies(model: SpectrumModel) -> None:
    """Raise ScenarioError for rows at which the spectrum has no power."""
    rows, excitation = model.rows, model.scenario.excitation
    assert isinstance(excitation, RandomMotion), "the base motion has a spectrum"
    G_u = np.mean(np.square(np.abs(model.short.signals[0].transforms)), axis=1)
    excited = model.frequencies[G_u > MIN_POWER_SHARE * G_u.max()]
    low, high = excitation.band
    low, high = max(low, float(excited[0])), min(high, float(excited[-1]))
    outside = (rows.frequency < low * (1.0 - EDGE)) | (rows.frequency > high * (1.0 + EDGE))
    if outside.any():
        first = int(np.argmax(outside))
        i, frequency = int(rows.curve[first]), format_number(rows.frequency[first], "Hz")
        sentence = (
            f"fit.curves #{i + 1}: the base hardly moves at {frequency}: its spectrum with "
            f"segments of {format_number(model.segment, 's')} is from "
            f"{format_range(low, high, 'Hz')}; leave other rows out by `rows`"
        )
        raise model.scenario.error(sentence, ("fit", "curves", i))


LEAST_RATIO = 1e-9
"""Least ratio, whose logarithm is still a number."""

EDGE = 1e-6
"""Relative distance of a frequency from the edge of a band that is rounding."""


# The errors of the rows


class Components(NamedTuple):
    """What the errors of the rows consist of; relative, in shares of each ratio."""

    noise: Floats
    """Standard deviation of the white noise of each of `RATIOS`."""
    times: Floats
    """Ratio of the simulated time to that of the measurement of each row."""
    times_variance: float
    """Variance of an estimated ratio of times; 0 if all times are stated."""
    rows: Floats
    """Standard deviation of all errors of each row but rounding."""
    scatter: list[tuple[NDArray[np.intp], Floats]]
    """As of `SpectrumModel.scatter`, of measurement and simulation together."""

    def covariance_through(self, matrix: Floats, white: Floats) -> Floats:
        """Return A M A', with M the covariance of the rows.

        Parameters
        ----------
        matrix : ndarray, shape (p, n)
            A.
        white : ndarray, shape (n,)
            Variance of noise and rounding of each row.
        """
        covariance: Floats = (matrix * white) @ matrix.T
        for index, errors in self.scatter:
            part = matrix[:, index] @ errors
            covariance += part @ part.T
        return covariance

    def widening(self, matrix: Floats, white: Floats) -> Floats:
        """Return the ratio of Student's t to the normal quantile, as the scatter is estimated.

        Degrees of freedom by Satterthwaite (1946), as for noise of a base record; arguments as
        of `covariance_through`.
        """
        parts = [np.sum((matrix[:, i] @ errors) ** 2, axis=1) for i, errors in self.scatter]
        scatter = np.sum(parts, axis=0)
        whole = scatter + (matrix**2) @ white
        # Blocks of one level tell the same for all its rows; the ratio of times is one for all.
        relative = self.times_variance / (1.0 + float(self.times.max())) ** 2
        of_blocks = [2.0 / (errors.shape[1] - 1) for _, errors in self.scatter]
        variance = scatter**2 * relative + of_blocks @ np.square(parts)
        freedom = 2.0 * whole**2 / np.maximum(variance, 1e-300)
        quantiles = [student_t(each) for each in np.maximum(freedom, LEAST_FREEDOM).tolist()]
        return np.array(quantiles) / NORMAL_95


def components_of(model: SpectrumModel, solution: Solution) -> Components:
    """Return what the residuals of a solution consist of.

    Residuals e of least squares have the covariance P M P', with M that of the errors and P
    the projection that takes away what the values explain. The products of near rows have the
    means s² (P P')_ij + (1 + λ) (P C P')_ij, with s the noise of a kind of ratio, C the
    covariance of the simulated estimates and λ the ratio of the simulated time to the measured
    one, where that is not stated. s² and λ are at least 0.
    """
    from scipy.optimize import nnls

    rows, mask = model.rows, solution.mask
    values = solution.x * solution.squares.scale
    ratios, scatter = model.ratios(values[None])[0][0], model.scatter(values)
    rounding = np.square(rows.rounding / ratios)
    weights = 1.0 / np.sqrt(np.square(model.noise) + rounding)
    residuals = (np.log(rows.measured / ratios) * weights)[mask]
    count, stated = len(residuals), model.stated_times
    projection = np.eye(count) - solution.jacobian @ solution.covariance @ solution.jacobian.T

    def of_white(variance: Floats) -> Floats:
        """Return the covariance of the residuals by white errors."""
        white: Floats = (projection * (variance * weights**2)[mask]) @ projection.T
        return white

    def of_scatter(factor: Floats) -> Floats:
        """Return the covariance of the residuals by the scatter, times a factor of each row."""
        covariance = np.zeros((count, count))
        for index, errors in scatter:
            wide = np.zeros((len(ratios), errors.shape[1]))
            wide[index] = (weights * np.sqrt(factor))[index, None] * errors
            projected = projection @ wide[mask]
            covariance += projected @ projected.T
        return covariance

    is_unknown = np.isnan(stated)
    terms = np.array(
        [*(of_white(rows.ratio == i) for i in range(len(RATIOS))), of_scatter(is_unknown)]
    )
    fixed = of_white(rounding) + of_scatter(1.0 + np.where(is_unknown, 0.0, stated))
    f, level = rows.frequency[mask], rows.rms[mask]
    is_near = np.abs(np.subtract.outer(f, f)) * model.segment < NEAR_LINES
    i, j = np.nonzero(np.triu(is_near & np.equal.outer(level, level)))
    products, pairs = residuals[i] * residuals[j] - fixed[i, j], terms[:, i, j]
    shares = np.full(len(terms), float(np.mean(np.square(residuals))) / len(terms))
    for _ in range(COMPONENT_STEPS):
        expected = np.diagonal(np.tensordot(shares, terms, axes=1) + fixed)
        weight = 1.0 / np.sqrt(expected[i] * expected[j])
        shares = nnls((pairs * weight).T, products * weight)[0]
    information = (pairs * weight).T
    spread = 2.0 * np.linalg.pinv(information.T @ information)[-1, -1]
    times = np.where(is_unknown, shares[-1], stated)
    both = [(index, np.sqrt(1.0 + times[index])[:, None] * errors) for index, errors in scatter]
    variance = shares[:-1][rows.ratio]
    for index, errors in both:
        variance[index] += np.sum(np.square(errors), axis=1)
    return Components(
        noise=np.sqrt(shares[:-1]),
        times=times,
        times_variance=float(spread) if is_unknown.any() else 0.0,
        rows=np.sqrt(variance),
        scatter=both,
    )


# The solution


@dataclass(frozen=True, eq=False)
class LocalModel(CurveModel):
    """The Taylor polynomial of log T about some values, for profiles and draws."""

    centre: Floats
    size: Floats
    """Values about which it is, and their steps, shape (p,)."""
    coefficients: Floats
    """Those of `basis`, shape (terms, n)."""
    reach: float = np.inf
    """Steps from the centre within which a solution may lie."""

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the values."""
        low, high = super().bounds
        reach = self.reach * self.size
        return np.maximum(low, self.centre - reach), np.minimum(high, self.centre + reach)

    @classmethod
    def about(cls, model: SpectrumModel, centre: Floats, size: Floats) -> LocalModel:
        """Return the polynomial through ratios at steps of each value, and of each pair."""
        low, high = model.bounds
        unit, count = np.eye(len(centre)), len(centre)
        size = np.minimum(size, 0.5 * (high - low))
        # Both sides, as far as the bounds allow, or the other side if a bound is too near.
        up, down = (high - centre) / size, (centre - low) / size
        far = np.where(up >= down, np.minimum(up, 2.0), -np.minimum(down, 2.0))
        is_between = np.minimum(up, down) >= NEAREST
        first = np.where(is_between, np.minimum(up, 1.0), 0.5 * far)
        second = np.where(is_between, -np.minimum(down, 1.0), far)
        steps = [np.zeros(count), *(first[:, None] * unit), *(second[:, None] * unit)]
        steps += [
            first[i] * unit[i] + first[j] * unit[j] for i in range(count) for j in range(i)
        ]
        places = np.array(steps)
        ratios = model.ratios(centre + places * size)[0]
        coefficients: Floats = np.asarray(np.linalg.solve(basis(places), np.log(ratios)))
        shared = (model.scenario, model.motion, model.measurement, model.parameters, model.case)
        return cls(*shared, model.rows, model.noise, centre, size, coefficients)

    def ratios(self, values: Floats) -> tuple[Floats, Floats]:
        """Return the ratios, of shape (k, n); the shares of sticking are not known."""
        logarithms = basis((values - self.centre) / self.size) @ self.coefficients
        ratios: Floats = np.exp(np.clip(logarithms, -LARGEST_LOGARITHM, LARGEST_LOGARITHM))
        return ratios, np.full_like(ratios, np.nan)


LARGEST_LOGARITHM = 20.0
"""Largest logarithm of a ratio by the polynomial, which grows without limits."""


def basis(places: Floats) -> Floats:
    """Return 1, the places of shape (k, p), and their products, shape (k, terms)."""
    count = places.shape[1]
    products = [places[:, i] * places[:, j] for i in range(count) for j in range(i + 1)]
    return np.column_stack([np.ones(len(places)), places, *products])


@dataclass(frozen=True, eq=False, kw_only=True)
class SpectrumFit(CurveFit):
    """Solution of a fit to curves under random base motion; `first` is under all signals."""

    model: SpectrumModel
    trial: CurveSquares
    """Residuals under one signal of each level, by which starts are compared."""
    components: Components
    is_settled: bool
    """Whether the solution is near the centre of its polynomial."""

    @cached_property
    def starts(self) -> tuple[int, int]:
        """How many starts led to the solution, and how many there were.

        They were followed under other signals: those count that ended near the best of them,
        or with nearly its cost. Static limits do not count.
        """
        costs = [self.trial.cost(x) for x in self.ends]
        best = self.ends[int(np.argmin(costs))]
        variances = np.diag(self.solution.robust_covariance)
        near = [
            AGREE * np.sqrt(variance) if not p.key.startswith(STATIC_PATHS) else np.inf
            for p, variance in zip(self.model.parameters, variances.tolist(), strict=True)
        ]
        agree = sum(
            cost <= ALIKE * min(costs) or bool(np.all(np.abs(x - best) <= near))
            for x, cost in zip(self.ends, costs, strict=True)
        )
        return agree, len(self.ends)

    def with_solution(self, solution: Solution) -> SpectrumFit:
        """Return the fit with another solution, and its covariance by all errors."""
        wide = with_wide_slopes(solution, static_limits(self.model))
        robust = replace(self, solution=wide).robust_covariance()
        return replace(self, solution=wide._replace(robust_covariance=robust))

    @property
    def equal_ends(self) -> tuple[Floats, ...]:
        """None: starts are followed under other signals than the solution."""
        return ()

    @property
    def scatter(self) -> Scatter:
        """What the scatter of the estimates is that of."""
        model, times = self.model, self.components.times
        excitation = model.scenario.excitation
        assert isinstance(excitation, RandomMotion), "the base motion has a spectrum"
        count = model.seeds * model.levels[0].shape[1]
        estimated = times[np.isnan(model.stated_times)]
        measured = None
        if len(estimated) and estimated[0] > LEAST_TIMES:
            measured = model.time / float(estimated[0])
        return Scatter(excitation.seed, count, model.time, measured, not len(estimated))

    @cached_property
    def white(self) -> Floats:
        """Variance of noise and rounding of each row, relative."""
        rows = self.model.rows
        rounding = np.square(rows.rounding / self.solved.ratios)
        return np.asarray(np.square(self.components.noise)[rows.ratio] + rounding)

    @cached_property
    def weights(self) -> Floats:
        """Reciprocal of the deviation of each row, relative."""
        rounding = np.square(self.model.rows.rounding / self.solved.ratios)
        return np.asarray(1.0 / np.sqrt(np.square(self.components.rows) + rounding))

    @cached_property
    def neighbour_correlation(self) -> float:
        """Expected correlation of neighbouring residuals."""
        across, whole = 0.0, float(np.sum(self.white * np.square(self.weights)))
        for index, errors in self.components.scatter:
            scaled_errors = self.weights[index, None] * errors
            whole += float(np.sum(np.square(scaled_errors)))
            next_to = np.diff(index) == 1
            both = np.sum(scaled_errors[1:] * scaled_errors[:-1], axis=1)
            across += float(np.sum(both[next_to]))
        return across / whole

    def covariance_through(self, matrix: Floats) -> Floats:
        """Return A M A', with M the covariance of the fitted residuals, in units of noise."""
        noise = self.solution.squares.noise[CURVES]
        covariance = self.components.covariance_through(self.over_rows(matrix), self.white)
        return np.asarray(max(noise, 1.0) ** 2 * covariance)

    def over_rows(self, matrix: Floats) -> Floats:
        """Return a matrix over the fitted residuals as one over all rows, relative."""
        mask, noise = self.solution.mask, self.solution.squares.noise[CURVES]
        wide = np.zeros((len(matrix), len(mask)))
        wide[:, mask] = matrix * self.weights[mask] / noise
        return wide

    def robust_covariance(self) -> Floats:
        """Return the covariance of the values by all errors of the rows, which is widened."""
        matrix = self.solution.covariance @ self.solution.jacobian.T
        wider = self.components.widening(self.over_rows(matrix), self.white)
        return self.covariance_through(matrix) * np.outer(wider, wider)

    @cached_property
    def wrong_level(self) -> str:
        """Which level is wrong, or which two are exchanged; empty if none is.

        Each curve in turn has a level to be fitted, by linear least squares. If one matters,
        the best of all fits with another level, or with exchanged ones, says which.
        """
        solution = self.solution
        mask, slopes = solution.mask, solution.jacobian
        (difference,) = solution.squares.differences(
            solution.squares.solve(solution.x)
        ).values()
        residuals = difference[mask] / solution.squares.noise[CURVES]
        suspected = suspects(self)
        is_wrong, together = False, curves_of_levels(self.model, suspected)
        for curves in together:
            column = self.slope_by_level(curves)[mask]
            column -= slopes @ (solution.covariance @ (slopes.T @ column))
            size = float(column @ column)
            if size == 0.0:
                continue
            change = -float(column @ residuals) / size
            deviation = float(np.sqrt(self.covariance_through(column[None] / size)[0, 0]))
            is_wrong |= abs(change) > max(WRONG_LEVEL * deviation, LEAST_CHANGE)
        if not is_wrong and self.error <= GOOD_FIT:
            return ""
        fits = [self.free_level(curves) for curves in together]
        fits += [self.exchanged_levels(i, j) for i, j in combinations(suspected, 2)]
        _, error, fault = min(fits)
        return fault if error <= GOOD_FIT else ""

    @property
    def quick(self) -> CurveSquares:
        """Residuals under few signals."""
        return replace(self.trial, model=replace(self.model, seeds=LEVEL_SEEDS))

    def free_level(self, curves: tuple[int, ...]) -> tuple[float, float, str]:
        """Return cost and error of the best fit with another level of curves; the fault."""
        quick = self.quick
        bounds = [
            np.append(ends, np.log(10.0) * sign)
            for ends, sign in zip(quick.bounds, (-1.0, 1.0), strict=True)
        ]

        def residuals(z: Floats) -> Floats:
            other = with_level(quick, curves, float(np.exp(z[-1])))
            return other.residuals(other.solve(z[:-1]), other.all_samples)

        function = Differentiable(residuals, lambda z: None)
        start, step = np.append(self.solution.x, 0.0), SpectrumModel.slope_step
        z = minimise(function, start, step, (bounds[0], bounds[1]), LEVEL_CALLS, None, 1e-3)
        factor = float(np.exp(z[-1]))
        fault = (
            f"the level of {curve_names(curves)} seems to be wrong: with {factor:.2g} times "
            "the stated one all curves fit better"
        )
        error = with_level(quick, curves, factor).relative_error(z[:-1])
        return float(np.sum(residuals(z) ** 2)), error, fault

    def exchanged_levels(self, i: int, j: int) -> tuple[float, float, str]:
        """Return cost and error of the best fit with two levels exchanged; the fault."""
        quick, block = self.quick, fit_of(self.model.scenario).curves or ()
        rows = exchange_levels(quick.model.rows, block, i, j)
        other = replace(quick, model=replace(quick.model, rows=rows))
        function, step = other.over(other.all_samples), SpectrumModel.slope_step
        starts = [self.solution.x]
        if self.error > GOOD_FIT:  # the fault may have led the fit far away
            near = other.model.short.starts()[:STARTS_TRIED]
            starts += [start / other.scale for start in near]
        fits = []
        for start in starts:
            x = minimise(function, start, step, other.bounds, LEVEL_CALLS, None, 1e-3)
            fits.append((float(np.sum(function.value(x) ** 2)), other.relative_error(x)))
        return *min(fits), EXCHANGED.format(curve_names((i, j)))

    def slope_by_level(self, curves: tuple[int, ...]) -> Floats:
        """Return the derivative of the residuals by the logarithm of the level of curves."""
        model = self.model.short
        values = self.values[None]
        levels = (1.0, 1.0 + LEVEL_STEP)
        rows = [with_level(self.trial, curves, factor).model for factor in levels]
        low, high = (model.channel(each.ratios(values)[0][0]) for each in rows)
        return np.asarray((high - low) / LEVEL_STEP / self.solution.squares.noise[CURVES])


AGREE, ALIKE = 3.0, 1.05
"""Standard deviations within which two starts agree, and ratio of their costs."""

LEAST_TIMES = 0.05
"""Ratio of simulated to measured time below which the latter is not known."""


def with_wide_slopes(solution: Solution, is_static: NDArray[np.bool_]) -> Solution:
    """Return the solution with the mean slopes over a step of static limits.

    Next to kinetic friction a static limit has no slope, but values that are not far have an
    effect: it then counts as a value that the curves determine.
    """
    squares, slopes = solution.squares, solution.jacobian.copy()
    for j in np.flatnonzero(is_static).tolist():
        ends = np.array([solution.x, solution.x])
        step = STATIC_STEP * float(sizes(solution.x)[j])
        ends[:, j] = np.clip(
            solution.x[j] + np.array([-step, step]), *(end[j] for end in squares.bounds)
        )
        low, high = (squares.residuals(squares.solve(x), solution.mask) for x in ends)
        slopes[:, j] = (high - low) / (ends[1, j] - ends[0, j])
    covariance = covariance_of(slopes)
    return solution._replace(
        jacobian=slopes, covariance=covariance, robust_covariance=covariance
    )


def fit_spectrum_curves(
    model: SpectrumModel, steps: Steps, finished: Callable[[int], None]
) -> SpectrumFit:
    """Return the best solution from all starts; `finished` is called with 1 for each.

    Raises
    ------
    SolverError
        If no start can be solved.
    """
    trial, ends, x = follow_starts(model.short, steps, finished)
    squares, weighted = replace(trial, model=model), model
    is_static = static_limits(model)
    step = np.where(is_static, STATIC_STEP, FIRST_TAYLOR_STEP) * sizes(x)
    for _ in range(MAX_POLYNOMIALS):
        centre = x
        local = LocalModel.about(weighted, centre * squares.scale, step * squares.scale)
        near = replace(squares, model=replace(local, reach=REACH))
        solution = final_fit(near, centre)
        x = solution.x
        components = components_of(weighted, solution)
        weighted = model.with_rows(model.rows, components.rows)
        local = local.with_rows(model.rows, components.rows)
        solution = final_fit(replace(squares, model=local), x)
        is_settled = bool(np.all(np.abs(x - centre) < step))
        fitted = SpectrumFit(
            model=weighted, first=replace(squares, model=weighted), ends=ends,
            solution=solution, trial=trial, components=components, is_settled=is_settled,
        ).with_solution(solution)  # fmt: skip
        if is_settled:
            break
        deviations = np.sqrt(np.diag(fitted.solution.robust_covariance))
        step = np.clip(TAYLOR_STEP * deviations / sizes(x), *TAYLOR_STEPS)
        step = np.where(is_static, STATIC_STEP, step) * sizes(x)
    return fitted


def static_limits(model: SpectrumModel) -> NDArray[np.bool_]:
    """Return which of the free keys are static limits."""
    return np.array([p.key.startswith(STATIC_PATHS) for p in model.parameters])
