"""Far: a sweep whose blocks other machines compute, while they are kept and told here."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from typing import TYPE_CHECKING

from drysim.study.cluster.flight import computed
from drysim.study.cluster.parcel import Parcel
from drysim.study.sweeps.packing import packed

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.cluster.link import Link
    from drysim.study.sweeps.batch import Batch
    from drysim.study.sweeps.plan import Piece, Plan
    from drysim.study.sweeps.store import Store


def solved(
    plan: Plan, scenario: Scenario, link: Link, store: Store, finished: Callable[[Batch], None]
) -> Iterator[tuple[Piece, Batch]]:
    """Give the cases of every piece in order, as `study.sweeps.sweep.solved` does.

    A block is kept as soon as it comes, whatever its turn: whoever is killed here loses no more
    than is under way. In its turn it is read again, so that none is held meanwhile.
    """
    wanted = (k for k, piece in enumerate(plan.pieces) if not store.holds(piece))
    come: set[int] = set()
    parcel = Parcel.of(scenario, store.sweep)
    with closing(computed(link, parcel, wanted, len(plan.pieces))) as flight:
        for turn, piece in enumerate(plan.pieces):
            while (batch := store.read(piece)) is None:
                # A fault of a case is met again here, where its file and line are known.
                number, words = next(flight, (turn, None))
                store.keep(
                    plan.pieces[number], words or packed(plan.block(number), store.sweep)
                )
                come.add(number)
            if turn in come:
                come.remove(turn)
                finished(batch)
            yield piece, batch
