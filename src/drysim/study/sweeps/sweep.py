"""Sweep: every case of the sweep block, block by block, in the order of the grid."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from threading import Event
from typing import TYPE_CHECKING

from drysim.core import compiled
from drysim.errors import ScenarioError
from drysim.study.case import Case, prepare
from drysim.study.effort import price
from drysim.study.ensembles.seeds import most
from drysim.study.hands import hands
from drysim.study.in_order import in_order
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.cases import count
from drysim.study.sweeps.gathering import gathered
from drysim.study.sweeps.over_seeds import Crew
from drysim.study.sweeps.plan import Piece, Pieces, Plan
from drysim.study.sweeps.store import Store
from drysim.study.sweeps.table import Table

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.cluster.link import Link

STEPS_A_CASE = 2_000
"""What an orbit weighs against loading the compiler, in steps of a plain march."""

Finished = Callable[[Batch], None]


def nothing(batch: Batch) -> None:
    """Do nothing with finished cases."""


def sweep(
    scenario: Scenario, *, workers: int | None = None, finished: Finished = nothing
) -> Table:
    """Give the table of every case of a scenario's sweep, the reference last.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block.
    workers : int, optional
        Threads; default: one for each processor. The table does not depend on it.
    finished : callable, optional
        Called with every block of cases as it is computed, in order.

    Returns
    -------
    Table

    Raises
    ------
    ScenarioError
        When the scenario has no sweep block, or a case is at fault.
    RecordError
        When the record of the excitation cannot be used.
    UsageError
        When it is no scenario, or `workers` no number of threads.
    """
    return solve(prepare(scenario), workers=workers, finished=finished)


def solve(
    case: Case,
    *,
    workers: int | None = None,
    store: Store | None = None,
    finished: Finished = nothing,
) -> Table:
    """Give the table of the sweep of a case that is ready to be solved; as `sweep` does.

    Where there is a store, blocks that it holds are not computed anew, and every other one is
    kept there; of a large sweep they are nowhere else.
    """
    scenarios = approaches_of(case.scenario)
    settle(case, scenarios)
    return gathered(case, solved(scenarios, case, workers, store, finished), store)


def solve_far(case: Case, link: Link, store: Store, *, finished: Finished = nothing) -> Table:
    """Give the same table as `solve`, its blocks computed by the workers of a cluster."""
    from drysim.study.cluster.far import solved as solved_far

    compiled.settle(compiled.PLAIN_STEPS + 1)  # as the workers do
    plan = Plan.of(approaches_of(case.scenario), case)
    return gathered(case, solved_far(plan, case.scenario, link, store, finished), store)


def leftover(case: Case, store: Store) -> Table:
    """Give the table of what an interrupted sweep has finished."""
    found = (
        (piece, batch)
        for piece in Pieces(approaches_of(case.scenario))
        if (batch := store.read(piece)) is not None
    )
    return gathered(case, found, store, complete=False)


def settle(case: Case, scenarios: Sequence[Scenario]) -> None:
    """Settle the engine for so many cases like this one, by the law that costs the most."""
    prices = [price(scenario.solver.member(), scenario.law()) for scenario in scenarios]
    dearest = max(prices, key=lambda one: one.of(case.motion))
    steps = max(case.steps, STEPS_A_CASE) * dearest.of(case.motion)
    compiled.settle(steps * most(case.scenario) * count(scenarios), dearest.kernels)


def approaches_of(scenario: Scenario) -> tuple[Scenario, ...]:
    """Give the scenario, and its reference where one is asked for.

    Raises
    ------
    ScenarioError
        When it has no sweep block.
    """
    if not scenario.sweep:
        problem = scenario.problem(
            "sweep is required: which keys to vary, and over what", "sweep"
        )
        raise ScenarioError(f"{scenario.name} has nothing to sweep: 1 problem", (problem,))
    reference = scenario.reference
    return (scenario, scenario.with_approach(reference)) if reference else (scenario,)


def solved(
    scenarios: Sequence[Scenario],
    case: Case,
    workers: int | None,
    store: Store | None = None,
    finished: Finished = nothing,
) -> Iterator[tuple[Piece, Batch]]:
    """Give the cases of every piece in order; those that are done are not done again."""
    plan, given_up = Plan.of(scenarios, case), Event()
    threads = hands(workers)
    crew = Crew.at(case, threads, count(scenarios), given_up.is_set)

    def made(number: int) -> tuple[Piece, Batch, bool]:
        piece = plan.pieces[number]
        if store is not None and (batch := store.read(piece)) is not None:
            return piece, batch, False
        batch = plan.block(number, crew)
        if store is not None:
            store.write(piece, batch)
        return piece, batch, True

    try:
        for piece, batch, new in in_order(made, range(len(plan.pieces)), threads):
            if new:
                finished(batch)
            yield piece, batch
    finally:
        given_up.set()
