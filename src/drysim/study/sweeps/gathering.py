"""How the finished blocks of a sweep become its table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from drysim.approach.numerics import FIXED_STEP
from drysim.approach.stick_slip import Exact
from drysim.core import compiled
from drysim.study.case import Case
from drysim.study.spectral import run_only
from drysim.study.sweeps import over_seeds
from drysim.study.sweeps.batch import Batch
from drysim.study.sweeps.doubts import statuses, strokes
from drysim.study.sweeps.plan import Piece
from drysim.study.sweeps.rows import HELD, Rows
from drysim.study.sweeps.store import Store, Stored
from drysim.study.sweeps.table import Table
from drysim.study.sweeps.tally import Tally

if TYPE_CHECKING:
    from drysim.errors import Caution
    from drysim.scenario import Axis, Scenario

MOVERS = ("excitation.", "solver.step", "measure.")
"""Beginnings of the keys that change the base motion."""


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
    """Give the table of finished cases, with its verdicts and warnings.

    Parameters
    ----------
    scenario : Scenario
        Whose sweep it is.
    case : Case
        The same by the approach, or the law, that is judged and warned of.
    rows, tallies
        The cases, and what those of each approach come to.
    losses : iterable of Caution
        What is to be said before anything else.
    """
    own = tallies.get(case.scenario.word, Tally("", scenario.checks))
    lost, met = statuses(tallies.values(), scenario.sweep), strokes(own, scenario)
    means = over_seeds.remarks(scenario, own.seeds)
    warnings = (*losses, *case.cautions, *run_only(case), *lost, *met, *means)
    motion = case.motion if shared(scenario.sweep) else None
    return Table(
        scenario, scenario.sweep, rows, own.verdicts, warnings, complete, motion, how(case),
        tallies,
    )  # fmt: skip


def shared(axes: Sequence[Axis]) -> bool:
    """Tell whether all cases have one base motion."""
    return not any(axis.key.startswith(MOVERS) for axis in axes)


def how(case: Case) -> dict[str, object]:
    """Give how the cases are solved, as far as they share it."""
    from drysim.approach.scene import core_of

    exact = isinstance(case.approach, Exact)
    core, why = core_of(case.law, case.motion) if exact else (FIXED_STEP, "fixed steps")
    return {"core": core, "why": why, "engine": compiled.engine(), "step": case.step}
