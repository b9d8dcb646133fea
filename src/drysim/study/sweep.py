"""Sweep: every case of the sweep block, block by block, gathered into a table.

Threads here, or the workers of a cluster, solve the blocks; the table takes them in the order
of the grid, so it does not depend on who solved them. Blocks that a store holds are not solved
anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from threading import Event
from typing import TYPE_CHECKING

from drysim.approach.solution import FIXED_STEP
from drysim.approach.stick_slip import Exact
from drysim.core import compile
from drysim.errors import Caution
from drysim.scenario.axes import Axis
from drysim.scenario.model import Scenario
from drysim.study.case import Case, prepare, price
from drysim.study.plan import Crew, Piece, Pieces, Plan, approaches_of
from drysim.study.run import count, run_only
from drysim.study.statistics import HELD, Batch, Finished, Rows, most, nothing
from drysim.study.store import Store, Stored
from drysim.study.table import Table, Tally
from drysim.study.warnings import case_strokes, statuses, wide_means
from drysim.system import hands, in_order

if TYPE_CHECKING:
    from drysim.study.cluster import Link


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
    from drysim.study.cluster import solved as solved_far

    compile.settle(compile.PLAIN_STEPS + 1)  # as the workers do
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


STEPS_A_CASE = 2_000
"""What an orbit weighs against loading the compiler, in steps of a plain march."""


def settle(case: Case, scenarios: Sequence[Scenario]) -> None:
    """Settle the engine for so many cases like this one, by the law that costs the most."""
    prices = [price(scenario.solver.member(), scenario.law()) for scenario in scenarios]
    dearest = max(prices, key=lambda one: one.of(case.motion))
    steps = max(case.steps, STEPS_A_CASE) * dearest.of(case.motion)
    compile.settle(steps * most(case.scenario) * count(scenarios), dearest.kernels)


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


# How the finished blocks of a sweep become its table.


def gathered(
    case: Case,
    blocks: Iterator[tuple[Piece, Batch]],
    store: Store | None,
    complete: bool = True,
) -> Table:
    """Give the table of blocks as they come; few are held where a store has them."""
    scenario = case.scenario
    held: list[Batch] = []
    kept: list[Piece] = []

    def passing() -> Iterator[Batch]:
        for piece, batch in blocks:
            kept.append(piece)
            if store is None or piece.first < HELD:
                held.append(batch)
            yield batch

    tallies = Tally.of(passing(), scenario.checks, scenario.word)
    small = len(held) == len(kept)
    batches: Sequence[Batch] = held if small or store is None else Stored(store, kept)
    rows = Rows.of(batches, [piece.end - piece.begin for piece in kept])
    return table_of(scenario, case, rows, tallies, complete=complete)


def table_of(
    scenario: Scenario,
    case: Case,
    rows: Rows,
    tallies: Mapping[str, Tally],
    losses: Iterable[Caution] = (),
    complete: bool = True,
) -> Table:
    """Give the table of a scenario's finished cases, with its verdicts and warnings.

    The case is the scenario by the approach, or the law, that is judged and warned of; tallies
    are what the cases of each approach come to, losses what is to be said before anything else.
    """
    own = tallies.get(case.scenario.word, Tally("", scenario.checks))
    lost, met = statuses(tallies.values(), scenario.sweep), case_strokes(own, scenario)
    means = wide_means(scenario, own.seeds)
    warnings = (*losses, *case.cautions, *run_only(case), *lost, *met, *means)
    motion = case.motion if shared(scenario.sweep) else None
    return Table(
        scenario, scenario.sweep, rows, own.verdicts, warnings, complete, motion, how(case),
        tallies,
    )  # fmt: skip


MOVERS = ("excitation.", "solver.step", "measure.")
"""Beginnings of the keys that change the base motion."""


def shared(axes: Sequence[Axis]) -> bool:
    """Tell whether all cases have one base motion."""
    return not any(axis.key.startswith(MOVERS) for axis in axes)


def how(case: Case) -> dict[str, object]:
    """Give how the cases are solved, as far as they share it."""
    from drysim.approach.scene import core_of

    exact = isinstance(case.approach, Exact)
    core, why = core_of(case.law, case.motion) if exact else (FIXED_STEP, "fixed steps")
    return {"core": core, "why": why, "engine": compile.engine(), "step": case.step}
