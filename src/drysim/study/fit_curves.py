"""Fit to transmissibility curves: measured T_a or T_x over the frequency, at several levels.

Problem
    Laboratories hand out curves instead of records. At each frequency the base motion is a sine
    of a stated level, and the measured ratio is that of the steady motion. Friction makes the
    curves of different levels differ, which is what identifies it.

Method
    1. The steady motion at each frequency and level is the periodic orbit from the start state
       of the scenario, as a sweep finds it (`study.plan`): some 20 µs.
    2. Starting values are the best of a coarse grid of natural frequency, damping, friction and
       static ratio, each judged by some of the rows.
    3. Least squares with one scale of noise for all rows: a ratio T with relative noise s and
       rounding r becomes asinh(s T/r)/s, whose noise is the same for all T. s follows from the
       residuals of each kind of ratio, r from the printed digits.
    4. A static limit decides whether the mass breaks away at a level: the sum of squares jumps
       there. Other static limits are tried. Profiles and intervals are those of a fit to a
       record (`fit_profiles`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.core.compile import choose_engine
from drysim.core.model import Floats, Input, State
from drysim.errors import ScenarioError, SolverError
from drysim.excitation.harmonic import Harmonic
from drysim.records.record import read_ratios
from drysim.scenario.fit import FIT_KEY, LEVEL_UNITS, RATIOS, Curve
from drysim.scenario.model import STATIC_PATHS, Scenario
from drysim.scenario.validation import spoken_name
from drysim.study.fit_law import AGREE, EXACT, ChannelFit, LawFit, Steps, restored_end
from drysim.study.fit_least_squares import (
    FINAL_CALLS,
    LeastSquares,
    Solution,
    covariance_of,
    minimise,
    perturbed,
    rms,
    without_outliers,
)
from drysim.study.fit_model import (
    FitModel,
    Measurement,
    Prediction,
    Trial,
    fit_of,
    is_valid_scene,
)
from drysim.study.fit_profiles import CHI_SQUARE_95
from drysim.study.plan import can_solve_together, orbit_metrics, orbit_statuses, scene_array
from drysim.study.preparation import assemble, base_motion, locating_records
from drysim.wording import format_count, format_number, join_words
from drysim.yaml_document import KeyPath

CURVES = "curves"
"""Name of the one channel of all rows together."""

RELATIVE_NOISE = 0.02
"""Relative noise of a ratio before it follows from the residuals."""

NOISE_RANGE = 1e-5, 1.0
"""Bounds of the relative noise."""

ROUNDING = 1e-9
"""Rounding of a ratio relative to the largest one, if its digits show a smaller one."""

LEAST_NOISE = 1e-9
"""Least noise of the stabilised ratios, whose usual noise is one: rounding."""

SLOPE_STEP = 1e-6
"""Relative step of the derivatives by orbits."""

NULL_SHARE = 10.0 * SLOPE_STEP
"""Ratio of singular values below which a direction has no effect: forward differences have an
error of about their step."""

ROWS_PER_VALUE = 2
"""Number of rows for each free value below which nothing is fitted."""

FEW_FREQUENCIES = 8
"""Number of frequencies of each curve that judge the starts."""

DAMPING_RATIOS = (0.05, 0.15, 0.35, 0.8)
FRICTION_SHARES = (0.05, 0.9)
STATIC_RATIOS = (1.0, 1.25, 1.6)
"""Starts: damping ratios, ends of kinetic friction relative to the force m A at the weakest and
the strongest level, and static relative to kinetic friction."""

NATURAL_FREQUENCIES, FRICTIONS = 8, 6
"""Numbers of natural frequencies and of kinetic limits among the starts."""

STATIC_CHANGES = np.linspace(-0.4, 0.6, 26).tolist()
"""Relative changes of a static limit that are tried."""

LEVEL_FACTORS = (0.5, 0.5**0.5, 0.8, 0.9, 1.1, 1.25, 2.0**0.5, 2.0, 9.80665, 1.0 / 9.80665)
"""Factors on the level of one curve that are tried where the curves do not fit together: RMS
taken for the amplitude or the other way round, g for m/s², and small ones."""

MUCH_BETTER = 0.6
"""Ratio of the sums of squares from which another level explains the curves."""

GOOD_FIT, STARTS_TRIED = 0.1, 2
"""Relative error of curves that are explained, RMS without their worst tenth; and starts that
are followed where a fault has led the fit far away."""

MAX_SUSPECTS, MAX_WITNESSES = 5, 5
"""Number of curves, those of the largest residuals, whose levels and columns are tried, and of
others beside which they are fitted again: the number of pairs grows with the square of the
former, the time of each fit with their sum."""

STATICS_FOLLOWED = 3
"""Number of changed static limits from which all values are fitted again."""

STARTS_PER_RATIO = 2
"""Number of starts that are followed for each static ratio."""

ROBUST_SHARE = 0.1
"""Relative difference of a ratio above which the score of a start grows slowly."""

STEADY_METRICS = (*RATIOS, "stuck_share")
"""Metrics of each orbit."""

ONE_RATIO = 1e-3
"""Distance of T_a from 1 within which the base and a mass that sticks move alike."""


class CurveRows(NamedTuple):
    """Measured ratios of all curves as columns of length n."""

    curve: NDArray[np.intp]
    """Index of the curve in the fit block."""
    ratio: NDArray[np.intp]
    """Index of the ratio in `RATIOS`."""
    frequency: Floats
    """Frequencies [Hz]."""
    rms: Floats
    """RMS value of the base acceleration [m/s²]."""
    measured: Floats
    rounding: Floats
    """Standard deviation of the rounding of the printed digits."""

    def part(self, mask: NDArray[np.bool_]) -> CurveRows:
        """Return some of the rows."""
        columns: Any = (column[mask] for column in self)
        return CurveRows(*columns)

    def stabilised(self, ratios: Floats, noise: Floats) -> Floats:
        """Return ratios, of shape (..., n), in units in which the noise of all rows is one.

        `noise` is the relative noise of each row.
        """
        stable: Floats = np.arcsinh(noise * ratios / self.rounding) / noise
        return stable


class FittedCurve(NamedTuple):
    """A measured ratio over the frequency at one level, and the fitted one."""

    ratio: str
    """T_a or T_x."""
    level: str
    """Key and value of the level, in words."""
    rms: Floats
    """RMS value of the base acceleration [m/s²]."""
    frequency: Floats
    """Frequencies [Hz]."""
    measured: Floats
    fitted: Floats
    stuck: Floats
    """Share of a period for which the fitted mass sticks."""


@dataclass(frozen=True, eq=False)
class SolvedCurves:
    """The ratios with some values of the free keys."""

    model: CurveModel
    values: Floats
    """Values of the free keys, shape (p,)."""
    ratios: Floats
    """Ratios, shape (n,)."""
    stuck: Floats
    """Share of a period for which the mass sticks."""

    @property
    def modes(self) -> NDArray[np.int8]:
        """One mode for all rows: none is left out of a fit."""
        return np.ones(len(self.ratios), dtype=np.int8)

    def prediction(self, names: tuple[str, ...]) -> Prediction:
        """Return the rows as the channel `CURVES`."""
        return Prediction({CURVES: self.model.channel(self.ratios)}, self.modes)

    def slopes(
        self, sizes: Floats, names: tuple[str, ...], integrated: bool = False
    ) -> dict[str, Floats] | None:
        """Return the derivatives of the rows by the values, as forward differences."""
        steps = self.model.slope_step * sizes
        steps = np.where(self.values + steps <= self.model.bounds[1], steps, -steps)
        near = self.values + np.diag(steps)
        ratios, _ = self.model.ratios(near)
        change = self.model.channel(ratios) - self.model.channel(self.ratios)
        return {CURVES: change / steps[:, None]}


@dataclass(frozen=True, eq=False)
class CurveModel(FitModel):
    """The rows of measured curves as a function of the free keys."""

    rows: CurveRows
    noise: Floats
    """Relative noise of each row."""

    slope_step: ClassVar[float] = SLOPE_STEP
    """Relative step of the derivatives: orbits are exact to rounding."""
    tolerance: ClassVar[float] = 1e-6
    """Relative change of the cost, and of the values, at which the fit of a start ends."""
    dampings: ClassVar[tuple[float, ...]] = DAMPING_RATIOS
    static_ratios: ClassVar[tuple[float, ...]] = STATIC_RATIOS
    """Damping ratios, and ratios of static to kinetic friction, among the starts."""

    @classmethod
    def of(cls, model: FitModel, rows: CurveRows) -> Self:
        """Return the model of a scenario with these rows."""
        shared = (model.scenario, model.motion, model.measurement, model.parameters, model.case)
        noise = np.full(len(rows.measured), RELATIVE_NOISE)
        return cls(*shared, rows, noise).with_rows(rows, noise)

    def with_rows(self, rows: CurveRows, noise: Floats) -> Self:
        """Return the model with other rows, and the relative noise of each."""
        stable = rows.stabilised(rows.measured, noise)
        channels, t = {CURVES: stable - stable.mean()}, np.arange(float(len(stable)))
        measurement = self.measurement._replace(channels=channels, t=t)
        return replace(self, measurement=measurement, rows=rows, noise=noise)

    @property
    def fixed_start(self) -> tuple[str, ...]:
        """No key of the start state: the motion is steady."""
        return ()

    @property
    def short(self) -> CurveModel:
        """The model by which starts are judged."""
        return self

    @property
    def extent(self) -> str:
        """The levels that are measured, for the remarks on what they do not determine."""
        return "at these levels"

    @property
    def subject(self) -> str:
        """What is measured, for the same remarks."""
        return "these curves"

    @cached_property
    def harmonic(self) -> Scenario:
        """The scenario without what a steady motion does not need."""
        return self.scenario.copy_with({"sweep": (), "checks": (), "stroke": None})

    @cached_property
    def cases(self) -> tuple[Floats, NDArray[np.intp]]:
        """Frequency and RMS acceleration of each orbit, shape (2, c); the orbit of each row."""
        pairs = np.stack([self.rows.frequency, self.rows.rms])
        cases, inverse = np.unique(pairs, axis=1, return_inverse=True)
        return cases, inverse.ravel()

    @cached_property
    def mean(self) -> float:
        """Mean of the measured ratios, as `channel` has them."""
        return float(self.rows.stabilised(self.rows.measured, self.noise).mean())

    def channel(self, ratios: Floats) -> Floats:
        """Return ratios as the channel `CURVES`, whose measured mean is 0."""
        channel: Floats = self.rows.stabilised(ratios, self.noise) - self.mean
        return channel

    def ratios(self, values: Floats) -> tuple[Floats, Floats]:
        """Return the ratios and the shares of sticking, of shape (k, n).

        Parameters
        ----------
        values : ndarray, shape (k, p)
            Values of the free keys. They are not validated.

        Notes
        -----
        Both ratios of a row of a file are those of one orbit. A ratio without an orbit is ten
        times the largest measured one.
        """
        rows, count = self.rows, len(values)
        cases, inverse = self.cases
        each = cases.shape[1]
        columns = np.repeat(values.T, each, axis=1)
        points = self.point(columns)
        excitation = self.scenario.excitation
        assert isinstance(excitation, Harmonic), "the base motion of a curve is a sine"
        factor = np.sqrt(2.0) if excitation.amplitude is not None else 1.0
        level = "amplitude" if excitation.amplitude is not None else "rms"
        points["excitation.frequency"] = np.tile(cases[0], count)
        points[f"excitation.{level}"] = factor * np.tile(cases[1], count)
        metrics = steady_metrics(self.harmonic, points, count * each)
        both = np.array([metrics[name].reshape(count, each) for name in STEADY_METRICS])
        of_rows = both[:, :, inverse]
        ratios: Floats = np.where(rows.ratio == 0, of_rows[0], of_rows[1])
        lost = ~np.isfinite(ratios)
        return np.where(lost, 10.0 * rows.measured.max(), ratios), np.where(
            lost, 0.0, of_rows[2]
        )

    def solve(self, values: Floats, end: float | None = None) -> SolvedCurves | None:
        """Return the ratios with some values of the free keys; None if these do not agree."""
        scene: Trial = self.scene(values)
        if not is_valid_scene(scene.law, State(0.0, 0.0)):
            return None
        try:
            ratios, stuck = self.ratios(values[None])
        except ScenarioError:
            return None
        return SolvedCurves(self, values, ratios[0], stuck[0])

    def _closed_forms(self) -> list[dict[str, float]]:
        """Return the starting values with the best scores over some of the frequencies."""
        m, k_x, b = self.case.plant
        keys = {p.key.partition(".")[2] for p in self.parameters}
        lowest, highest = float(self.rows.frequency.min()), float(self.rows.frequency.max())
        natural = np.geomspace(lowest / 1.5, highest, NATURAL_FREQUENCIES)
        stiffnesses = [k_x] * (k_x > 0.0)
        if keys & {"stiffness", "natural_frequency"} or not stiffnesses:
            stiffnesses = (m * (2.0 * np.pi * natural) ** 2).tolist()
        peak = np.sqrt(2.0) * m * self.rows.rms
        limits = [self.case.law.F_fk]
        if keys & {"kinetic", "mu_kinetic"}:
            low, high = FRICTION_SHARES
            ends = low * float(peak.min()), high * float(peak.max())
            limits = np.geomspace(*ends, FRICTIONS).tolist()
        ratios = list(self.static_ratios)
        if not keys & {"static", "static_ratio", "mu_static"}:
            ratios = [self.case.law.F_fs / (self.case.law.F_fk or 1.0)]
        starts = []
        for stiffness, limit, ratio in product(stiffnesses, limits, ratios):
            dampings = [b]
            if keys & {"damping", "damping_ratio"}:
                dampings = [2.0 * each * np.sqrt(stiffness * m) for each in self.dampings]
            starts += [
                {"m": m, "k_x": stiffness, "b": each, "F_fk": limit, "static_ratio": ratio}
                for each in dampings
            ]
        return self._best_of(starts, ratios)

    def _first_state(self, closed_form: Mapping[str, float]) -> State:
        """Return rest: the start state of a steady motion is not fitted."""
        return State(0.0, 0.0)

    def _best_of(
        self, starts: list[dict[str, float]], ratios: Sequence[float]
    ) -> list[dict[str, float]]:
        """Return the starts with the best scores, some for each static ratio."""
        values = np.array(
            [[self._start_of(p, start, False) for p in self.parameters] for start in starts]
        )
        values = np.clip(values, *self.bounds)
        few = self.short.with_rows(self.rows.part(self._is_judge), self.noise[self._is_judge])
        difference = few.channel(few.ratios(values)[0]) - few.measurement.channels[CURVES]
        robust = ROBUST_SHARE / RELATIVE_NOISE
        scores = np.sum(np.sqrt(1.0 + (difference / robust) ** 2), axis=1)
        best: list[dict[str, float]] = []
        order = np.argsort(scores, kind="stable").tolist()
        for ratio in ratios:
            alike = [starts[i] for i in order if starts[i]["static_ratio"] == ratio]
            best += alike[:STARTS_PER_RATIO]
        return sorted(best, key=lambda start: float(scores[starts.index(start)]))

    @cached_property
    def _is_judge(self) -> NDArray[np.bool_]:
        """Whether a row judges the starts: those at some frequencies of each curve."""
        judges = np.zeros(len(self.rows.frequency), dtype=bool)
        for curve in np.unique(self.rows.curve).tolist():
            here = self.rows.curve == curve
            frequencies = np.unique(self.rows.frequency[here])
            places = np.linspace(
                0, len(frequencies) - 1, min(FEW_FREQUENCIES, len(frequencies))
            )
            chosen = frequencies[np.round(places).astype(int)]
            judges |= here & np.isin(self.rows.frequency, chosen)
        return judges


def steady_metrics(
    scenario: Scenario, points: dict[str, Floats], count: int
) -> dict[str, Floats]:
    """Return the metrics of the steady motion of cases, NaN where there is none."""
    from drysim.orbits.coulomb import solve_orbits

    scenes, _ = scene_array(scenario, points, count)
    results = solve_orbits(scenes)
    status, _ = orbit_statuses(results)
    return orbit_metrics(scenes, results, status, STEADY_METRICS)


@dataclass(frozen=True, eq=False)
class CurveSquares(LeastSquares):
    """Residuals of curves: few rows, all of which count from the beginning."""

    model: CurveModel

    leaves_out_events = False
    null_share = NULL_SHARE

    def coarse(self, x: Floats) -> Floats:
        """Return the start, which is the best of a grid."""
        return x

    def refine(self, x: Floats, steps: Sequence[float]) -> Floats:
        """Return the solution of a robust fit of all rows."""
        function = self.over(self.all_samples)
        robust = max(self.robust_level(), 1.5 * float(np.median(np.abs(function.value(x)))))
        end = self.model.tolerance
        return minimise(function, x, SLOPE_STEP, self.bounds, FINAL_CALLS, robust, end)

    def relative_error(self, x: Floats) -> float:
        """Return the relative error of the ratios, RMS without the worst tenth."""
        rows = self.model.rows
        ratios, _ = self.model.ratios((x * self.scale)[None])
        size = np.maximum(rows.measured, rows.rounding)
        errors = np.sort(np.abs(ratios[0] - rows.measured) / size)
        return rms(errors[: max(1, round(0.9 * len(errors)))])


@dataclass(frozen=True, eq=False)
class CurveFit(LawFit):
    """Solution of a fit to curves."""

    model: CurveModel

    @cached_property
    def solved(self) -> SolvedCurves:
        """The fitted ratios."""
        solved = self.model.solve(self.values)
        assert solved is not None, "the solution was solved before"
        return solved

    @cached_property
    def prediction(self) -> Prediction:
        """The fitted rows."""
        return self.solved.prediction(())

    @property
    def sticks(self) -> bool:
        """Whether the fitted mass sticks at some frequency and level where it also slides."""
        return bool((self.solved.stuck > 0.0).any())

    @property
    def slides(self) -> bool:
        """Whether the fitted mass slides at all."""
        return bool((self.solved.stuck < 1.0).any())

    @cached_property
    def channels(self) -> tuple[ChannelFit, ...]:
        """How well each kind of ratio is fitted: errors are relative to each measured value."""
        rows, fits = self.model.rows, []
        for i, name in enumerate(RATIOS):
            if (here := rows.ratio == i).any():
                difference = (self.solved.ratios - rows.measured)[here]
                size = np.maximum(rows.measured, rows.rounding)[here]
                noise = rms(self.model.noise[here])
                fits.append(ChannelFit(name, noise, rms(difference / size), None, None))
        return tuple(fits)

    @cached_property
    def starts(self) -> tuple[int, int]:
        """How many starts led to the solution, and how many there were.

        Static limits do not count: other ones were tried last.
        """
        solution, keys = self.solution, [p.key for p in self.model.parameters]
        static = [key.startswith(STATIC_PATHS) for key in keys]
        ends = [np.where(static, solution.x, x) for x in self.ends]
        costs = [solution.squares.fine(x)[0] for x in ends]
        lowest = solution.squares.cost(solution.x)
        return sum(cost <= AGREE * lowest + 1e-9 for cost in costs), len(costs)

    @cached_property
    def equal_ends(self) -> tuple[Floats, ...]:
        """Where starts led to a fit that is as good as the solution, at 95 %."""
        solution = self.solution
        squares, most = solution.squares, solution.sum_of_squares + CHI_SQUARE_95
        sums = [
            np.sum(squares.residuals(squares.solve(x), solution.mask) ** 2) for x in self.ends
        ]
        return tuple(x for x, total in zip(self.ends, sums, strict=True) if total < most)

    @property
    def curves(self) -> Iterator[FittedCurve]:
        """Each curve as measured and as fitted, by frequency."""
        rows, block = self.model.rows, fit_of(self.model.scenario).curves or ()
        for index, curve in enumerate(block):
            for i, name in enumerate(RATIOS):
                here = np.flatnonzero((rows.curve == index) & (rows.ratio == i))
                if len(here):
                    columns = (rows.rms, rows.frequency, rows.measured, self.solved.ratios)
                    parts = (column[here] for column in (*columns, self.solved.stuck))
                    key, value = curve.level
                    yield FittedCurve(name, format_level(key, format_number(value)), *parts)


def format_level(key: str, values: str) -> str:
    """Return one or several values of a key of a level in words."""
    return f"{values} {LEVEL_UNITS[key]} {LEVEL_WORDS[key]}"


LEVEL_WORDS = {
    "rms": "RMS",
    "amplitude": "amplitude",
    "velocity": "velocity amplitude",
    "displacement": "displacement amplitude",
}
"""What a level is."""


def build_curve_model(scenario: Scenario) -> CurveModel:
    """Read the curves of a fit block that were measured under sines, and return the model.

    Raises
    ------
    RecordError
        If a file cannot be used.
    ScenarioError
        If the scenario has no orbits that are solved together, or a free key has no start.
    """
    check_steady(scenario)
    choose_engine(10**9, "orbit.solve_orbits")
    return CurveModel.of(*read_model(scenario))


def read_model(scenario: Scenario) -> tuple[FitModel, CurveRows]:
    """Return the scenario as a model, and the rows of its curves.

    Raises
    ------
    RecordError
        If a file cannot be used.
    ScenarioError
        If there are too few rows.
    """
    from drysim.study.fit_model import free_parameters

    rows, inputs = read_curves(scenario)
    count = len(rows.measured)
    parameters = free_parameters(scenario)
    least = ROWS_PER_VALUE * len(parameters)
    if count < least:
        sentence = (
            f"fit.curves: {format_count(count, 'value')} of curves are too few for "
            f"{format_count(len(parameters), 'free key')}; at least {least} are needed"
        )
        raise scenario.error(sentence, ("fit", "curves"))
    motion = base_motion(scenario)
    measurement = Measurement({}, np.arange(float(count)), 0, 1, inputs, ())
    model = FitModel(scenario, motion, measurement, parameters, assemble(scenario, motion))
    return model, rows


def check_steady(scenario: Scenario) -> None:
    """Raise ScenarioError for a scenario without steady motions that are solved together."""
    if not isinstance(scenario.excitation, Harmonic):
        sentence = (
            "excitation.kind: the base motion of a measured curve is a sine, or random: write "
            "`excitation: {kind: harmonic, frequency: 2 Hz, rms: 0.5 m/s2}`, or psd, standard "
            "or road with the spectrum of the measurement; levels, and the frequencies of "
            "sines, are those of the curves"
        )
        raise scenario.error(sentence, ("excitation", "kind"))
    measure = scenario.measure.without_weights()
    if not can_solve_together(scenario.copy_with({"measure": measure, "sweep": ()})):
        raise scenario.error(NOT_FITTED, ("fit", "curves"))
    for i, curve in enumerate(fit_of(scenario).curves or ()):
        for key in {"estimator", "duration"} & curve.model_fields_set:
            sentence = (
                f"fit.curves #{i + 1}: {key} has no meaning under a sine, whose ratios are "
                "those of RMS values; remove it"
            )
            raise scenario.error(sentence, ("fit", "curves", i, key))


NOT_FITTED = (
    "fit.curves: curves are fitted under Coulomb friction by stick-slip, without end stops, "
    "values by direction and lift-off; fit a record instead"
)
"""What is wrong with a scenario whose motions are others."""


def read_curves(scenario: Scenario) -> tuple[CurveRows, tuple[Input, ...]]:
    """Return the rows of all curves, and their files."""
    parts, inputs, paths = [], [], dict[tuple[object, ...], KeyPath]()
    for index, curve in enumerate(fit_of(scenario).curves or ()):
        present = [i for i, name in enumerate(RATIOS) if getattr(curve, name) is not None]
        with locating_records(scenario):
            read, source = read_ratios(curve, [getattr(curve, RATIOS[i]) for i in present])
        inputs.append(source)
        for i, ratios in zip(present, read, strict=True):
            path: KeyPath = (FIT_KEY, "curves", index, RATIOS[i])
            other = paths.setdefault((curve.path, repr(curve.rows), ratios.column), path)
            if other != path:
                sentence = f"{spoken_name(path)} is column {ratios.column + 1} of {curve.file}"
                rule = f"and so is {spoken_name(other)}: each needs its own"
                raise scenario.error(f"{sentence}, {rule}", path)
            # In order, so that neighbouring residuals are those of neighbouring frequencies.
            order, count = np.argsort(ratios.frequency, kind="stable"), len(ratios.values)
            least = ROUNDING * float(ratios.values.max(initial=0.0))
            rounding = max(ratios.resolution / np.sqrt(12.0), least)
            parts.append(
                CurveRows(
                    np.full(count, index),
                    np.full(count, i),
                    ratios.frequency[order],
                    curve.base_rms(ratios.frequency[order]),
                    ratios.values[order],
                    np.full(count, rounding),
                )
            )
    rows = CurveRows(*map(np.concatenate, zip(*parts, strict=True)))
    return rows, tuple({each.file: each for each in inputs}.values())


def check_sliding(model: CurveModel) -> None:
    """Raise SolverError if the mass moves with the base in all rows, within their noise."""
    rows = model.rows
    alike = np.where(
        rows.ratio == 0,
        np.abs(rows.measured - 1.0) <= np.maximum(ONE_RATIO, 2.0 * rows.rounding),
        rows.measured <= ONE_RATIO,
    )
    if alike.all():
        sentence = (
            "the mass moves with the base in all rows of the curves: nothing can be fitted; "
            "measure at a level at which it slides"
        )
        raise SolverError(sentence)


def fit_curves(model: CurveModel, steps: Steps, finished: Callable[[int], None]) -> CurveFit:
    """Return the best solution from all starts; `finished` is called with 1 for each.

    Raises
    ------
    SolverError
        If no start can be solved.
    """
    first, ends, x = follow_starts(model, steps, finished)
    fitted = CurveFit(model, first, ends, final_fit(first, x))
    if first.error(x) < EXACT:
        return fitted
    weighted = model.with_rows(model.rows, noise_of(fitted))
    squares = replace(first, model=weighted)
    solution = final_fit(squares, best_static(squares, fitted.solution.x))
    return replace(fitted, model=weighted, first=squares, solution=solution)


def follow_starts(
    model: CurveModel, steps: Steps, finished: Callable[[int], None]
) -> tuple[CurveSquares, tuple[Floats, ...], Floats]:
    """Return the residuals, and the scaled parameters at the end of each start and of the best.

    Raises
    ------
    SolverError
        If no start can be solved.
    """
    starts = model.starts()
    first = CurveSquares.starting_from(model, np.inf, starts[0])
    if first.solve(starts[0] / first.scale) is None:
        model.at(starts[0])  # raises what is wrong with the values
    followed = []
    for end_point in steps.map_in_order(
        first.fine, [start / first.scale for start in starts], restored_end
    ):
        followed.append(end_point)
        finished(1)
    _, x = min(followed, key=lambda pair: pair[0])
    return first, tuple(x for _, x in followed), x


def final_fit(squares: CurveSquares, x: Floats) -> Solution:
    """Return the least-squares solution near x, without outliers; its noise is one."""
    every = squares.all_samples
    x = squares.refine(x, ())
    mask = without_outliers(squares, x, every)
    x = minimise(squares.over(mask), x, SLOPE_STEP, squares.bounds, FINAL_CALLS)
    (difference,) = squares.differences(squares.solve(x)).values()
    freedom = max(1, int(mask.sum()) - len(x))
    noise = float(np.sqrt(np.sum(difference[mask] ** 2) / freedom))
    squares = replace(squares, noise={CURVES: max(noise, LEAST_NOISE)})
    smooth = squares.over(mask)
    slopes = smooth.jacobian(x, SLOPE_STEP, squares.bounds)
    total = float(np.sum(smooth.value(x) ** 2))
    covariance = covariance_of(slopes)
    return Solution(squares, x, covariance, covariance, slopes, every, mask, total)


def best_static(squares: CurveSquares, x: Floats) -> Floats:
    """Return scaled parameters with other static limits, if that is better after a fit.

    The sum of squares jumps where the mass breaks away at a level, and where it begins to stop.
    """
    for j, p in enumerate(squares.model.parameters):
        if p.key.startswith(STATIC_PATHS):
            changes = perturbed(squares, x, j, STATIC_CHANGES)
            likely = sorted(changes, key=squares.cost)[:STATICS_FOLLOWED]
            ends = [(squares.cost(x), x), *(squares.fine(near) for near in likely)]
            x = min(ends, key=lambda pair: pair[0])[1]
    return x


def likely_fault(fitted: CurveFit) -> str:
    """Return what seems to be wrong if the curves fit well, and much better, without it.

    A common factor of all levels cannot be seen: it is that of the friction.
    """
    squares = fitted.solution.squares
    assert isinstance(squares, CurveSquares), "curves are fitted"
    squares = beside_witnesses(squares, suspects(fitted))
    model = squares.model
    best, cause = MUCH_BETTER * squares.cost(fitted.solution.x), ""
    for fault, rows, is_far in possible_faults(model, suspects(fitted)):
        other = replace(squares, model=replace(model, rows=rows))
        starts = [fitted.solution.x]
        if is_far:
            starts = [start / squares.scale for start in other.model.starts()[:STARTS_TRIED]]
        for start in starts:
            cost, x = other.fine(start)
            if cost < best and other.relative_error(x) < GOOD_FIT:
                best, cause = cost, fault
    compared, total = (len(np.unique(rows.curve)) for rows in (model.rows, fitted.model.rows))
    tried = f"; this was tried on {compared} of {total} curves only"
    return cause + tried * bool(cause and compared < total)


def suspects(fitted: CurveFit) -> list[int]:
    """Return the curves of the largest residuals, in order; all if there are few."""
    squares, curve = fitted.solution.squares, fitted.model.rows.curve
    (difference,) = squares.differences(squares.solve(fitted.solution.x)).values()
    residuals = np.bincount(curve, np.abs(difference)) / np.bincount(curve)
    return sorted(np.argsort(-residuals, kind="stable")[:MAX_SUSPECTS].tolist())


def untried(fitted: CurveFit) -> str:
    """Return which curves were suspected, as the end of a message; empty if all were."""
    suspected = suspects(fitted)
    if set(suspected) >= set(fitted.model.rows.curve.tolist()):
        return ""
    return (
        f"; other levels and columns were tried for {curve_names(suspected)} only, those of "
        "the largest residuals"
    )


def beside_witnesses(squares: CurveSquares, suspected: Sequence[int]) -> CurveSquares:
    """Return the residuals of some curves and of a few others, evenly spaced in their level."""
    rows = squares.model.rows
    level = np.bincount(rows.curve, rows.rms) / np.bincount(rows.curve)
    others = [i for i in np.argsort(level, kind="stable").tolist() if i not in suspected]
    places = np.linspace(0, len(others) - 1, min(MAX_WITNESSES, len(others)))
    kept = [*suspected, *(others[round(place)] for place in places.tolist())]
    mask = np.isin(rows.curve, kept)
    model = squares.model.with_rows(rows.part(mask), squares.model.noise[mask])
    return replace(squares, model=model)


def possible_faults(
    model: CurveModel, suspected: Sequence[int]
) -> Iterator[tuple[str, CurveRows, bool]]:
    """Yield usual faults of curves in words, the rows without it, and if the values are far."""
    rows = model.rows
    for curves, factor in product(curves_of_levels(model, suspected), LEVEL_FACTORS):
        fault = (
            f"the level of {curve_names(curves)} seems to be wrong: with {factor:.3g} times "
            "the stated one the curves fit much better"
        )
        level = np.where(np.isin(rows.curve, curves), factor * rows.rms, rows.rms)
        yield fault, rows._replace(rms=level), False
    block = fit_of(model.scenario).curves or ()
    for i, j in combinations(suspected, 2):
        yield EXCHANGED.format(curve_names((i, j))), exchange_levels(rows, block, i, j), True
    every = tuple(range(len(block)))
    for curves in sorted({every, *((i,) for i in suspected)}):
        fault = f"T_a and T_x of {curve_names(curves)} seem to be exchanged"
        ratio = np.where(np.isin(rows.curve, curves), 1 - rows.ratio, rows.ratio)
        yield fault, rows._replace(ratio=ratio), True


EXCHANGED = "the levels of {} seem to be exchanged"
"""Fault of two curves."""


def exchange_levels(rows: CurveRows, curves: Sequence[Curve], i: int, j: int) -> CurveRows:
    """Return the rows of all curves, two of them with the level of each other."""
    level = rows.rms.copy()
    for curve, other in ((i, j), (j, i)):
        here = rows.curve == curve
        level[here] = curves[other].base_rms(rows.frequency[here])
    return rows._replace(rms=level)


def curves_of_levels(model: CurveModel, suspected: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the curves whose level may be wrong: each, and those of one stated level together.

    A common factor of all levels cannot be seen.
    """
    stated = [curve.level for curve in fit_of(model.scenario).curves or ()]
    together = {
        tuple(i for i, other in enumerate(stated) if other == stated[j]) for j in suspected
    }
    each = {(i,) for i in suspected}
    return sorted(curves for curves in each | together if len(curves) < len(stated))


def curve_names(curves: Sequence[int]) -> str:
    """Return the names of curves in a message."""
    return f"curves {join_words([f'#{i + 1}' for i in curves])}"


def with_level(squares: CurveSquares, curves: Sequence[int], factor: float) -> CurveSquares:
    """Return the residuals with another level of some curves."""
    rows = squares.model.rows
    rms = np.where(np.isin(rows.curve, curves), factor * rows.rms, rows.rms)
    return replace(squares, model=replace(squares.model, rows=rows._replace(rms=rms)))


def noise_of(fitted: CurveFit) -> Floats:
    """Return the relative noise of each row, one of each kind of ratio, from the residuals.

    Their squares, divided by the variance of noise and rounding, are one on average.
    """
    rows, noise = fitted.model.rows, fitted.model.noise.copy()
    difference = fitted.solved.ratios - rows.measured
    freedom = max(1.0 - len(fitted.model.parameters) / len(difference), 0.1)
    for i in range(len(RATIOS)):
        if not (here := rows.ratio == i).any():
            continue
        low, high = NOISE_RANGE
        for _ in range(40):
            share = float(np.sqrt(low * high))
            variance = (share * rows.measured[here]) ** 2 + rows.rounding[here] ** 2
            is_more = float(np.mean(difference[here] ** 2 / variance)) > freedom
            low, high = (share, high) if is_more else (low, share)
        noise[here] = low
    return noise
