"""Sweep: every case of the sweep block, in threads, in the order of the grid."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from drysim.approach.numerics import FIXED_STEP
from drysim.core import compiled
from drysim.errors import Caution, ScenarioError
from drysim.study.case import Case, prepare
from drysim.study.cases import Motions, count
from drysim.study.in_order import Finished, in_order, nothing
from drysim.study.pieces import Piece, pieces, solve_piece
from drysim.study.spectral import run_only
from drysim.study.table import FAILED, OK, Row, Table
from drysim.wording import millimetres

if TYPE_CHECKING:
    from drysim.scenario import Axis, Scenario

STEPS_A_CASE = 2_000
"""What an orbit weighs against loading the compiler, in steps of a plain march."""

MOVERS = ("excitation.", "solver.step", "measure.")
"""Beginnings of the keys that change the base motion."""


def sweep(
    scenario: Scenario,
    *,
    workers: int | None = None,
    done: Mapping[int, Row] | None = None,
    finished: Finished = nothing,
) -> Table:
    """Give the table of every case of a scenario's sweep, the reference last.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block.
    workers : int, optional
        Threads; default: one for each processor. The table does not depend on it.
    done : mapping, optional
        Rows by number that an interrupted sweep has left.
    finished : callable, optional
        Called with number and row of every case as it is computed, in order.

    Returns
    -------
    Table

    Raises
    ------
    ScenarioError
        When the scenario has no sweep block, or a case is at fault.
    RecordError
        When the record of the excitation cannot be used.
    """
    return solve(prepare(scenario), workers=workers, done=done, finished=finished)


def solve(
    case: Case,
    *,
    workers: int | None = None,
    done: Mapping[int, Row] | None = None,
    finished: Finished = nothing,
) -> Table:
    """Give the table of the sweep of a case that is ready to be solved; as `sweep` does."""
    scenarios = approaches_of(case.scenario)
    settle(case, scenarios)
    motions = Motions.beginning_with(case)
    rows = tuple(solved(scenarios, motions, workers, done or {}, finished))
    return table_of(case, rows)


def settle(case: Case, scenarios: Sequence[Scenario]) -> None:
    """Settle the engine for so many cases like this one."""
    compiled.settle(max(case.steps, STEPS_A_CASE) * count(scenarios))


def approaches_of(scenario: Scenario) -> tuple[Scenario, ...]:
    """Give the scenario, and its reference where one is asked for."""
    if not scenario.axes:
        problem = scenario.problem(
            "sweep is required: which keys to vary, and over what", "sweep"
        )
        raise ScenarioError(f"{scenario.name} has nothing to sweep: 1 problem", (problem,))
    reference = scenario.reference
    return (scenario, scenario.with_approach(reference)) if reference else (scenario,)


def solved(
    scenarios: Sequence[Scenario],
    motions: Motions,
    workers: int | None,
    done: Mapping[int, Row],
    finished: Finished,
) -> Iterator[Row]:
    """Give the rows of every case in order; those that are done already are not done again."""

    def rows(piece: Piece) -> list[Row]:
        numbers = range(piece.first, piece.first + piece.end - piece.begin)
        if all(number in done for number in numbers):
            return [done[number] for number in numbers]
        return list(solve_piece(piece, motions))

    number = 0
    for piece in in_order(rows, pieces(scenarios), workers or os.cpu_count() or 1):
        for row in piece:
            if number not in done:
                finished(number, row)
            yield row
            number += 1


def table_of(case: Case, rows: tuple[Row, ...], complete: bool = True) -> Table:
    """Give the table of finished rows, with its verdicts and warnings."""
    scenario = case.scenario
    own = [row for row in rows if row.approach == scenario.solver.approach]
    good = [(row.point, row.metrics) for row in own if row.status == OK]
    checks = tuple(check.judge_all(good) for check in scenario.checks)
    warnings = (*case.cautions, *run_only(case), *statuses(rows), *strokes(own, scenario))
    own_motion = case.motion if shared(scenario.axes) else None
    return Table(
        scenario, scenario.axes, rows, checks, warnings, complete, own_motion, how(case)
    )


def shared(axes: Sequence[Axis]) -> bool:
    """Tell whether all cases have one base motion."""
    return not any(axis.key.startswith(MOVERS) for axis in axes)


def how(case: Case) -> dict[str, object]:
    """Give how the cases are solved, as far as they share it."""
    from drysim.approach.scene import core_of

    exact = hasattr(case.approach, "track")
    core, why = core_of(case.law, case.motion) if exact else (FIXED_STEP, "fixed steps")
    return {"core": core, "why": why, "engine": compiled.engine(), "step": case.step}


def statuses(rows: Sequence[Row]) -> Iterator[Caution]:
    """Say how many cases of each approach have no numbers, and why the first has none."""
    lost = [row for row in rows if row.status != OK]
    for approach, status in dict.fromkeys((row.approach, row.status) for row in lost):
        found = [row for row in lost if (row.approach, row.status) == (approach, status)]
        cases = sum(row.approach == approach for row in rows)
        first = f"the first at {where(found[0])}: " if found[0].point else ""
        sentence = (
            f"{len(found)} of {cases} cases by {approach}: {status}; {first}{found[0].note}"
        )
        slug = "case-failed" if status == FAILED else status.replace(" ", "-")
        yield Caution(slug, sentence, {"cases": len(found)})


def strokes(rows: Sequence[Row], scenario: Scenario) -> Iterator[Caution]:
    """Say in how many cases the stroke limit is met, and where the most."""
    beyond = [row for row in rows if row.metrics.get("violations")]
    if beyond and scenario.stroke is not None:
        worst = max(beyond, key=lambda row: row.metrics.get("x_r_peak") or 0.0)
        peak = worst.metrics.get("x_r_peak") or 0.0
        sentence = (
            f"the stroke limit of {millimetres(scenario.stroke.limit)} is met in {len(beyond)} "
            f"of {len(rows)} cases; |x_r| reaches {millimetres(peak)} at {where(worst)}"
        )
        numbers = {"limit": scenario.stroke.limit, "x_r_peak": peak, "cases": len(beyond)}
        yield Caution("stroke-violated", sentence, numbers)


def where(row: Row) -> str:
    """Give the point of a row in words."""
    return ", ".join(f"{key} = {value:g}" for key, value in row.point.items())
