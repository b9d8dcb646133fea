"""Periodic orbits of Coulomb friction under sines, by the kernels of `drysim.core.orbit`.

Search, measures, monodromy and growth of deviations are in closed form. The kernels solve a
block of scenes in one call: a scene is a row of numbers, which is mostly affine in a parameter
of the scenario (`ParameterRows`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from drysim.approach.base_motion import make_waves
from drysim.approach.buffers import LOG_LENGTH, empty_columns, empty_log, empty_samples
from drysim.approach.solution import Orbit
from drysim.core import lyapunov, orbit
from drysim.core.compile import as_engine_array
from drysim.core.events import Segments
from drysim.core.forcing import F_FK, F_FS, WAVE_COLUMNS
from drysim.core.march import initial_slip_state
from drysim.core.model import AnyState, CoulombLaw, Floats, Plant, Sines, State
from drysim.core.status import Status
from drysim.core.stroke import Crossings

MAX_PERIODS = 5_000
"""Periods after which a motion counts as not settled: thirty times as many as the slowest of
90 drawn orbits took (162, with less than 1 % of critical damping), and 10 to 50 ms."""


def find_coulomb_orbit(
    plant: Plant, law: CoulombLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Return the periodic orbit reached from a start, as `search.find_orbit` does."""
    scene = orbit.SineMarch(plant, law, make_waves(motion, law), empty_log(LOG_LENGTH))
    (x_r, v_r, _), multiple, closure, periods, peak, unique, distance = orbit.converge_to_orbit(
        scene, period, *start[:2], MAX_PERIODS, period_buffers()
    )
    settled = multiple != Status.NOT_SETTLED
    if multiple < 0 and settled:
        raise Status(multiple).error(t=periods * period)
    return Orbit(
        State(x_r, v_r), max(multiple, 1), closure, settled, unique,
        periods * period, peak, distance,
    )  # fmt: skip


def deviation_growth(
    plant: Plant, law: CoulombLaw, motion: Sines, start: AnyState, period: float, periods: int
) -> Floats:
    """Return the logarithmic growth of a deviation in each period, as `lyapunov` defines it."""
    scene = orbit.SineMarch(plant, law, make_waves(motion, law), empty_log(LOG_LENGTH))
    x_r, v_r = start[:2]
    d = int(initial_slip_state(plant, law, scene.waves, x_r, v_r, scene.log).d)
    growth = as_engine_array(np.full(periods, np.nan))
    lyapunov.deviation_growth(scene, period, orbit.PeriodState(x_r, v_r, d), growth)
    return np.asarray(growth)


def solve_orbits(scenes: Floats) -> Floats:
    """Find the periodic orbits of many scenes and compute their metrics.

    Parameters
    ----------
    scenes : ndarray, shape (n, SINES + 3 sines)
        One scene per row, columns as in `drysim.core.orbit.solve_orbits`.

    Returns
    -------
    ndarray, shape (n, ANSWER_COLUMNS)
        One answer per row, columns as defined there.
    """
    answers = np.full((len(scenes), orbit.ANSWER_COLUMNS), np.nan)
    return fill_answers(scenes, answers, MAX_PERIODS)


def measure_orbits(scenes: Floats, periods: Floats) -> Floats:
    """Compute the metrics of known orbits, as `solve_orbits` does.

    Parameters
    ----------
    scenes : ndarray, shape (n, SINES + 3 sines)
        One scene per row; its start is on the orbit.
    periods : ndarray, shape (n,)
        Periods of the excitation per repetition of each orbit.

    Returns
    -------
    ndarray, shape (n, ANSWER_COLUMNS)
    """
    answers = np.full((len(scenes), orbit.ANSWER_COLUMNS), np.nan)
    answers[:, orbit.MULTIPLE] = periods
    return fill_answers(scenes, answers, 0)


def fill_answers(scenes: Floats, answers: Floats, most: int) -> Floats:
    """Call the kernel `solve_orbits`; parameters as there. Returns the answers."""
    rows, filled = as_engine_array(np.ascontiguousarray(scenes)), as_engine_array(answers)
    orbit.solve_orbits(rows, filled, most, workspace(scenes.shape[1]))
    return np.asarray(filled).reshape(answers.shape)  # a list of no rows has no columns


def scene_row(
    plant: Plant, law: CoulombLaw, motion: Sines, start: AnyState, period: float
) -> Floats:
    """Return a scene without stroke limits as a row of `solve_orbits`."""
    sines = [column for sine in zip(*motion, strict=True) for column in sine]
    return np.array([*plant, *law, *start[:2], period, math.inf, math.inf, *sines])


def workspace(columns: int) -> orbit.Workspace:
    """Return the work space of `solve_orbits` for scenes with so many columns."""
    log, segments = empty_log(LOG_LENGTH), empty_columns(Segments, LOG_LENGTH + 1)
    return orbit.Workspace(
        scene_buffer(columns),
        period_buffers(),
        log,
        segments,
        empty_columns(Crossings, 2 * LOG_LENGTH),
        empty_samples(2),
        as_engine_array(np.zeros(2)),
    )


def scene_buffer(columns: int) -> Any:
    """Return the work space of kernels for the waves of a scene with so many columns."""
    return as_engine_array(np.zeros(WAVE_COLUMNS * ((columns - orbit.SINES) // 3 + 1)))


def period_buffers() -> orbit.PeriodStarts:
    """Return buffers for the states at the start of the latest periods."""
    x_r, v_r = (as_engine_array(np.zeros(orbit.MAX_MULTIPLE)) for _ in range(2))
    return orbit.PeriodStarts(x_r, v_r)


PROBES = 7
"""Values of the parameter at which columns are compared with an affine function."""

AFFINE_TOLERANCE = 8.0 * np.finfo(float).eps
"""Relative difference up to which they count as equal: rounding."""


class ParameterRows:
    """Scenes of `orbit.solve_orbits` as a function of one parameter.

    Most columns of a scene are affine in the parameter, or do not depend on it. Where all are,
    a row is computed from two of them, about a hundred times faster than from the scenario.

    Parameters
    ----------
    exact : callable
        Returns the rows for an array of values.
    low, high : float
        Range of the parameter.
    """

    def __init__(self, exact: Callable[[Floats], Floats], low: float, high: float) -> None:
        self.exact, self.ends = exact, (low, high)
        probes = np.linspace(low, high, PROBES)
        rows = exact(probes)
        self.has_one_sine = rows.shape[1] == orbit.SINES + 3
        first, last = rows[0], rows[-1]
        changes = first != last
        self.slope, self.base = np.zeros(len(first)), first.copy()
        self.slope[changes] = (last[changes] - first[changes]) / (high - low)
        self.base[changes] -= self.slope[changes] * low
        size = np.abs(rows).max(axis=0)
        # Rounding of the offset of a column that is proportional to the parameter.
        self.base[np.abs(self.base) <= AFFINE_TOLERANCE * size] = 0.0
        self.end_rows = first.copy(), last.copy()
        same = [self.affine(value) for value in probes.tolist()]
        with np.errstate(invalid="ignore"):
            self.is_affine = not (np.abs(same - rows) > AFFINE_TOLERANCE * size).any()

    def affine(self, value: float) -> Floats:
        """Return the row whose columns are affine in the parameter, except the period."""
        row: Floats = self.base + self.slope * value
        if self.has_one_sine:
            row[orbit.PERIOD] = 1.0 / row[orbit.SINES + 1]
        return row

    def at(self, value: float) -> Floats:
        """Return the row of a value."""
        row: Floats
        if not self.is_affine:
            row = self.exact(np.array([value]))[0]
        elif value in self.ends:
            row = self.end_rows[self.ends.index(value)].copy()
        else:
            row = self.affine(value)
        # Rounding must not separate the limits, nor exchange them.
        if abs(row[F_FS] - row[F_FK]) <= AFFINE_TOLERANCE * row[F_FK]:
            row[F_FS] = row[F_FK]
        return row


class CoulombFlow:
    """The kernel `flow_and_monodromy` with its work space."""

    def __init__(self) -> None:
        self.log = empty_log(LOG_LENGTH)
        self.image = as_engine_array(np.zeros(orbit.IMAGE_COLUMNS))

    def __call__(
        self, row: Floats, time: float, state: Floats
    ) -> tuple[list[float], Floats] | None:
        """Return the image of a state, with the columns of the kernel, and its events [s].

        Parameters
        ----------
        row : ndarray, shape (SINES + 3 sines,)
            A scene, as in `scene_row`.
        time : float
            In seconds.
        state : ndarray, shape (2,)
            x_r [m] and v_r [m/s] at t = 0.

        Returns
        -------
        image : list of float
        events : ndarray
            None where the motion cannot be solved, or differentiated.
        """
        x_r, v_r = state.tolist()
        work, image = scene_buffer(len(row)), self.image
        orbit.flow_and_monodromy(as_engine_array(row), work, time, x_r, v_r, self.log, image)
        values = [*map(float, image)]
        if values[orbit.IMAGE_EVENTS] < 0.0 or not math.isfinite(sum(values)):
            return None
        return values, np.array(self.log.s[: int(values[orbit.IMAGE_EVENTS])])
