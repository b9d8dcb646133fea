"""The periodic orbits of many cases at once: one call of the kernel solves a block of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drysim.approach.stick_slip import Exact
from drysim.averages import energies, means
from drysim.core.motion import Sines
from drysim.core.plant import Plant
from drysim.core.state import State, Totals
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.friction.coulomb import Coulomb
from drysim.scenario.measure import common_period
from drysim.scenario.sweep.axis import columns_of
from drysim.scenario.sweep.columns import Columns, columned
from drysim.study.sweeps.batch import NAMES, STATUSES, Batch
from drysim.study.sweeps.cases import ONE_OF_MANY, Job, Motions, row_of, unsettled
from drysim.study.sweeps.table import FAILED, NOT_SETTLED, NOT_UNIQUE, OK

if TYPE_CHECKING:
    from drysim.scenario import Scenario

Floats = NDArray[np.float64]

AMPLITUDE = "friction.normal_variation.amplitude"


def together(scenario: Scenario) -> bool:
    """Tell whether the cases of a sweep are orbits that one call of the kernel can solve."""
    friction, measure = scenario.acting, scenario.measure
    return (
        measure.steady
        and measure.weights is None
        and scenario.stops is None
        and isinstance(scenario.solver.member(), Exact)
        and isinstance(scenario.excitation, Harmonic | SineSum)
        and (friction is None or (isinstance(friction, Coulomb) and not _lifts(scenario)))
    )


def _lifts(scenario: Scenario) -> bool:
    """Tell whether the normal force of any case may be zero; a recorded one has no orbits."""
    varied = getattr(scenario.acting, "normal_variation", None)
    swept = (axis for axis in scenario.sweep if axis.key == AMPLITUDE)
    most = max((max(axis.values) for axis in swept), default=0.0)
    return max(most, varied.amplitude if varied else 0.0) >= 1.0


def solve(scenario: Scenario, first: int, begin: int, end: int) -> Batch:
    """Give the cases from number `begin` to the one before `end` of a scenario's grid.

    Parameters
    ----------
    scenario : Scenario
        One whose cases are solved `together`.
    first : int
        Number of the first of them among the cases of all approaches.

    Raises
    ------
    ScenarioError
        When the values of a case do not go together.
    """
    from drysim.approach.under_sines import solve_orbits
    from drysim.core.sines.orbits import CROWDED, STATUS

    points = columns_of(scenario.sweep, begin, end)
    scenes, forces = scenes_of(scenario, points, end - begin)
    answers = solve_orbits(scenes)
    status, notes = statuses(answers)
    metrics = measured(scenes, answers, status)
    approach = scenario.word
    batch = Batch(first, approach, points, *forces, metrics, status, notes)
    crowded = answers[:, STATUS] == CROWDED
    return alone(scenario, batch, crowded) if crowded.any() else batch


def alone(scenario: Scenario, batch: Batch, which: NDArray[np.bool_]) -> Batch:
    """Give a batch in which some cases are solved one by one: their events fill the log."""
    rows, motions = list(batch), Motions()
    for i in np.flatnonzero(which).tolist():
        rows[i] = row_of(Job(batch.first + i, scenario, dict(rows[i].point)), motions)
    return Batch.of(batch.first, rows)


def scenes_of(
    scenario: Scenario, points: Columns, length: int
) -> tuple[Floats, tuple[Floats, Floats]]:
    """Give cases as the kernel wants them, and their F_fk and F_fs [N]."""
    from drysim.core.sines.orbits import SINES

    case = columned(scenario, points)
    plant, law = case.oscillator.plant(), case.law()
    limit = np.inf if case.stroke is None else case.stroke.limit
    motion = case.excitation.motion()
    assert isinstance(motion, Sines), "only sines have orbits"
    sines = [column for sine in zip(*motion, strict=True) for column in sine]
    period = periods_of(case, motion.f, length)
    columns = [*plant, *law, *case.start.state(), period, limit, *sines]
    scenes = np.empty((length, SINES + len(sines)))
    for k, column in enumerate(columns):
        scenes[:, k] = column
    refuse_odd(scenario, points, case, scenes)
    return scenes, (full(law.F_fk, length), full(law.F_fs, length))


def full(value: Any, length: int) -> Floats:
    """Give a column, also of a value that all cases share."""
    return np.broadcast_to(np.asarray(value, dtype=float), (length,)).copy()


def periods_of(case: Scenario, frequencies: tuple[Any, ...], length: int) -> Floats:
    """Give the common period of base motion and normal force [s]; NaN where there is none."""
    friction = case.acting
    varied = friction.normal_variation if isinstance(friction, Coulomb) else None
    if varied is None and len(frequencies) == 1:
        return full(1.0 / frequencies[0], length)
    columns = [full(frequency, length) for frequency in frequencies]
    if varied is not None:
        moves = full(varied.amplitude, length) != 0.0
        columns.append(np.where(moves, full(varied.frequency, length), np.nan))
    rows, at = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    found = [common_period(f for f in row if f == f) for row in rows.tolist()]
    return np.array([np.nan if period is None else period for period in found])[at.ravel()]


def refuse_odd(scenario: Scenario, points: Columns, case: Scenario, scenes: Floats) -> None:
    """Let the first case that may break a rule be checked by itself."""
    from drysim.core.sines.orbits import PERIOD
    from drysim.core.sines.scene import F_FK, F_FS, K_X

    odd = (scenes[:, F_FS] < scenes[:, F_FK]) | np.isnan(scenes[:, PERIOD])
    if case.oscillator.damping_ratio is not None:
        odd |= scenes[:, K_X] == 0.0
    for i in np.flatnonzero(odd)[:1].tolist():
        scenario.at({key: column[i].item() for key, column in points.items()})


def statuses(answers: Floats) -> tuple[NDArray[np.int8], dict[int, str]]:
    """Give what became of every case, and what is to be said where that is no orbit."""
    from drysim.approach.scene import overflow, storm
    from drysim.core.sines import orbits as o

    def said(i: int, code: int) -> tuple[str, str]:
        at = float(answers[i, o.TIME])
        if code == o.NOT_SETTLED:
            return NOT_SETTLED, unsettled(at)
        if code == o.NOT_UNIQUE:
            return NOT_UNIQUE, ONE_OF_MANY
        return FAILED, str(storm(at) if code == o.STORM else overflow(at))

    codes = answers[:, o.STATUS].astype(np.int64)
    status, notes = np.zeros(len(codes), dtype=np.int8), {}
    for i in np.flatnonzero(codes != o.SETTLED).tolist():
        word, notes[i] = said(i, int(codes[i]))
        status[i] = STATUSES.index(word)
    return status, notes


def measured(scenes: Floats, answers: Floats, status: NDArray[np.int8]) -> dict[str, Floats]:
    """Give every metric of every case; NaN where it is not known."""
    from drysim.core.sines import orbits as o
    from drysim.core.sines.scene import F_FK, K_X, B, M

    scene, answer = scenes.T, answers.T
    length = answer[o.MULTIPLE] * scene[o.PERIOD]
    totals = Totals(*answer[o.X2 : o.U2 + 1])
    plant = Plant(*scene[[M, K_X, B]])
    ends = State(answer[o.X_BEGIN], answer[o.V_BEGIN]), State(answer[o.X_END], answer[o.V_END])
    with np.errstate(invalid="ignore"):
        found = means(totals, length) | energies(plant, scene[F_FK], totals, *ends)
    peak = answer[o.PEAK]
    found |= {"x_r_peak": peak, "stroke_suffices": peak, "chatter_share": 0.0 * peak}
    found["crossing_rate"] = answer[o.UPCROSSINGS] / length
    limited, none = np.isfinite(scene[o.X_RM]), np.full(len(peak), np.nan)
    first = answer[o.T_FIRST]
    found["stroke_used"] = np.where(limited, peak / scene[o.X_RM], np.nan)
    found["limit_rate"] = np.where(limited, answer[o.ENTRIES] / length, np.nan)
    found["violations"] = np.where(limited, answer[o.TIMES], np.nan)
    found["t_beyond"] = np.where(limited, answer[o.T_BEYOND], np.nan)
    found["t_first_violation"] = np.where(limited & (first >= 0.0), first, np.nan)
    lost = status != STATUSES.index(OK)
    for column in found.values():
        column[lost] = np.nan
    failed = status == STATUSES.index(FAILED)
    found["closure"] = np.where(failed, np.nan, answer[o.CLOSURE])
    return {name: found.get(name, none) for name in NAMES}
