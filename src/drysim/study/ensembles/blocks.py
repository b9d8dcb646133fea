"""Seeds of one case by blocks: one call of the kernel measures a block of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach import EXACT
from drysim.averages import energies, means
from drysim.core.compiled import COMPILED, engine
from drysim.core.motion import Samples
from drysim.core.plant import Law
from drysim.metrics import METRICS, Values
from drysim.peaks import stroke_statistics
from drysim.stroke import excursions
from drysim.study.ensembles.seeds import until_of
from drysim.study.sweeps.cases import track_of

if TYPE_CHECKING:
    from drysim.approach.many import Measured
    from drysim.study.case import Case

MOST, FEWEST = 128, 8
"""Seeds of a block: as many as the kernel marches together, and a group of them."""

PARTS = 4
"""Blocks at least, so that threads can share the work of few seeds."""

TO_BE_JUDGED = 32
"""Seeds of a block at most where an interval decides how many are needed."""

NUMBERS = 1 << 22
"""Samples of a block at most: 100 MB with what is made of them."""


def length_of(case: Case, seeds: int) -> int:
    """Give how many of so many seeds a block holds; 1 where each is solved by itself.

    The one place that says which scenes go by blocks. It does not depend on the number of
    threads, nor do results: what a seed comes to does not depend on those beside it.
    """
    room = min(MOST, NUMBERS // max(case.steps, 1))
    if until_of(case.scenario):
        room = min(room, TO_BE_JUDGED)
    if room < FEWEST or seeds < FEWEST or not fits(case):
        return 1
    share = -(-seeds // PARTS)
    return min(room, max(FEWEST, share + -share % FEWEST))


def fits(case: Case) -> bool:
    """Tell whether the exact solution of a case can be measured side by side with others."""
    from drysim.approach.many import measurable

    return (
        engine() == COMPILED
        and case.approach.approach == EXACT
        and case.period is None
        and case.scenario.measure.weights is None
        and isinstance(case.motion, Samples)
        and samples_of(case) is not None
        and measurable(case.plant, case.law, case.step)
    )


def samples_of(case: Case) -> tuple[int, int] | None:
    """Give the samples at which the window begins and ends; None where it does between two."""
    from drysim.approach.scene import ON_GRID

    shares = [t / case.step for t in case.window]
    begin, end = map(round, shares)
    near = all(abs(t - round(t)) <= ON_GRID * max(1.0, t) for t in shares)
    return (begin, end) if near and begin < end else None


def measured_block(
    case: Case, motions: Iterable[Samples], count: int
) -> Iterator[Values | None]:
    """Give the metrics of a case under each of so many base motions.

    None stands for one that must be solved by itself: its numerics fail.
    """
    from drysim.approach.many import abreast, measure_many

    window = samples_of(case)
    assert type(case.law) is Law, "asked for of what `fits` only"
    assert window is not None, "asked for of what `fits` only"
    given = abreast(motions, count, window)
    many = measure_many(case.plant, case.law, given, case.start)
    length = case.window[1] - case.window[0]
    columns = means(many.totals, length)
    columns |= energies(case.plant, case.law.F_fk, many.totals, many.first, many.last)
    known = {name: numbers(column, count) for name, column in columns.items()}
    for i, found in enumerate(many.found.tolist()):
        if not found:
            yield None
            continue
        values: Values = {name: column[i] for name, column in known.items()}
        values |= of_stroke(case, given.motion(i), many, i)
        yield {metric.name: values.get(metric.name) for metric in METRICS}


def numbers(column: object, count: int) -> list[float | None]:
    """Give the numbers of a column, None for what is not known."""
    if not isinstance(column, np.ndarray):
        return [None] * count
    return [None if value != value else value for value in column.tolist()]


def of_stroke(case: Case, motion: Samples, many: Measured, i: int) -> Values:
    """Give the metrics of one seed that are read off its way from stop to stop."""
    way, suffices, x_rM = many.paths[i], float(many.suffices[i]), case.limit
    length = case.window[1] - case.window[0]
    peak = float(np.abs(way).max())
    values: Values = {"x_r_peak": peak, "stroke_suffices": suffices, "chatter_share": 0.0}
    values |= stroke_statistics(way, length, x_rM, case.goes_on)
    if x_rM is not None:
        times, t_first, t_beyond = 0, None, 0.0
        if suffices >= x_rM:
            track = track_of(
                replace(case, motion=motion), case.start, case.step, case.window[1]
            )
            path = track.path((0.0, track.end), x_rM)
            times, t_first, t_beyond = excursions(track, path, x_rM)
        values |= {"stroke_used": peak / x_rM, "violations": times, "t_beyond": t_beyond}
        values["t_first_violation"] = t_first
    return values
