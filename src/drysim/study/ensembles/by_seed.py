"""The rows of an ensemble, seed by seed in their order: many are measured together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import chain
from typing import TYPE_CHECKING

from drysim import machine
from drysim.core import compiled
from drysim.core.motion import Samples
from drysim.scenario.seeds import SEED
from drysim.study import memory
from drysim.study.base_motion import base_motion
from drysim.study.case import Case, assemble
from drysim.study.ensembles.seeds import asked, enough, of_seed
from drysim.study.hands import hands
from drysim.study.hashes import sha256_of
from drysim.study.in_order import in_order
from drysim.study.sweeps.cases import attempted
from drysim.study.sweeps.table import Row

if TYPE_CHECKING:
    from drysim.core.motion import Sines
    from drysim.scenario import Scenario

    MotionOf = Callable[[Scenario], Sines | Samples]


def rows_of(
    scenario: Scenario,
    threads: int,
    done: Mapping[int, Row] | None = None,
    motion_of: MotionOf = base_motion,
) -> Iterator[Row]:
    """Give the row of every seed that a scenario needs, in order."""
    from drysim.study.ensembles.blocks import length_of

    seeds, kept = asked(scenario), done or {}
    alone = of_seed(scenario, seeds[0])
    first = assemble(alone, motion_of(alone))
    step = length_of(first, len(seeds))

    def block(begin: int) -> list[Row]:
        every = seeds[begin : begin + step]
        missing = [seed for seed in every if seed - seeds[0] not in kept]
        new = dict(zip(missing, rows_of_block(first, missing, motion_of), strict=True))
        return [new[seed] if seed in new else kept[seed - seeds[0]] for seed in every]

    rows: list[Row] = []
    with closing(in_order(block, range(0, len(seeds), step), threads)) as found:
        for one in chain.from_iterable(found):
            rows.append(one)
            yield one
            if enough(scenario, rows):
                return


def rows_of_block(case: Case, seeds: Sequence[int], motion_of: MotionOf) -> Iterator[Row]:
    """Give the rows of some seeds, which are measured together where there are several."""
    from drysim.study.ensembles.blocks import measured_block

    scenario, law = case.scenario, case.law
    if len(seeds) < 2:
        yield from (row_of_seed(scenario, seed, motion_of) for seed in seeds)
        return
    digests: list[str] = []

    def drawn() -> Iterator[Samples]:
        for seed in seeds:
            motion = sampled(motion_of(of_seed(scenario, seed)))
            digests.append(sha256_of(motion.u_dd))
            yield motion

    same, found = (scenario.word, law.F_fk, law.F_fs), measured_block(case, drawn(), len(seeds))
    for i, (seed, metrics) in enumerate(zip(seeds, found, strict=True)):
        if metrics is None:
            yield row_of_seed(scenario, seed, motion_of)
        else:
            yield Row({SEED: seed}, *same, metrics, sha256=digests[i])


def row_of_seed(scenario: Scenario, seed: int, motion_of: MotionOf = base_motion) -> Row:
    """Give the row of one seed; a failure of the numerics is a status, not an end."""
    alone, law = of_seed(scenario, seed), scenario.law()
    motion = sampled(motion_of(alone))
    found = attempted(alone, lambda _: motion)
    sha256 = sha256_of(motion.u_dd)
    return Row({SEED: seed}, scenario.word, law.F_fk, law.F_fs, *found, sha256)


def sampled(motion: Sines | Samples) -> Samples:
    """Give a motion that was drawn, which is samples."""
    assert isinstance(motion, Samples), "what is drawn is samples"
    return motion


def threads(case: Case, workers: int | None) -> int:
    """Give how many seeds may be under way at a time: as many as fit into the memory."""
    wanted = hands(workers)
    if compiled.engine() == compiled.PLAIN:
        return 1  # plain Python does one thing at a time
    room = int(
        machine.memory() // memory.bytes_of(case.steps, bool(case.scenario.measure.weights))
    )
    return max(1, min(wanted, room))
