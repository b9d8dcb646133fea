"""A case of a sweep that is many seeds: its row holds means, and how well they are known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from drysim.errors import Caution
from drysim.study.ensembles.by_seed import rows_of, threads
from drysim.study.ensembles.seeds import most, narrow, until_of
from drysim.study.ensembles.statistics import statistics
from drysim.study.hashes import sha256_together
from drysim.study.sweeps import cases
from drysim.study.sweeps.table import FAILED, OK, OverSeeds, Row
from drysim.wording import number, place

if TYPE_CHECKING:
    from drysim.scenario import Scenario
    from drysim.study.case import Case
    from drysim.study.sweeps.cases import Job, Motions
    from drysim.study.sweeps.known import Count, Seeds

COUNT = "excitation.seeds"


class Crew(NamedTuple):
    """Who works at a case: how many seeds at a time, and whether anybody still waits for it."""

    seeds: int
    given_up: Callable[[], bool]

    @classmethod
    def at(cls, case: Case, workers: int, count: int, given_up: Callable[[], bool]) -> Crew:
        """Give those of so many cases: where threads are left over, seeds go side by side."""
        return cls(max(1, threads(case, workers) // count), given_up)


ALONE = Crew(1, lambda: False)
"""One thread, which nothing interrupts but the end of the process."""


def row_of(job: Job, motions: Motions, crew: Crew) -> Row:
    """Give the row of a case, of one seed or of many."""
    if most(job.scenario) == 1 and COUNT not in job.point:
        return cases.row_of(job, motions)
    scenario, rows = job.scenario.at(job.point), []
    for row in rows_of(scenario, crew.seeds, motion_of=motions.of):
        if crew.given_up():
            raise CancelledError
        rows.append(row)
    return together(scenario, job.point, rows)


def together(scenario: Scenario, point: Mapping[str, float], rows: Sequence[Row]) -> Row:
    """Give the rows of all seeds of a case as one; one that fails lets the case fail."""
    first, lost = rows[0], [row for row in rows if row.status != OK]
    case = Row(point, first.approach, first.F_fk, first.F_fs, {}, over=OverSeeds(len(rows)))
    if lost:
        which = f"{len(lost)} of {len(rows)} seeds, the first {lost[0].seed}"
        return replace(case, status=FAILED, note=f"{which}: {lost[0].note}")
    found = statistics(rows)
    until = until_of(scenario)
    over = OverSeeds(
        len(rows),
        {name: one.half_width for name, one in found.items() if one},
        tuple(row.metrics.get("T_a") for row in rows),
        sha256_together(row.sha256 for row in rows),
        until is None or narrow(scenario, rows),
    )
    means = {name: one and one.mean for name, one in found.items()}
    return replace(case, metrics=means, over=over)


def remarks(scenario: Scenario, found: Seeds | None) -> Iterator[Caution]:
    """Say which intervals are wider than asked, and which checks are not decided."""
    if found is None:
        return
    until = until_of(scenario)
    if found.wide and until:
        sentence = (
            f"in {found.wide.cases} of {found.cases} cases the interval of {until.metric} is "
            f"wider than ±{number(100 * until.half_width, '%')} of its mean after "
            f"{most(scenario)} seeds, the most there may be{first_of(found.wide, scenario)}"
        )
        yield Caution("interval-wide", sentence, {"cases": found.wide.cases})
    for check, undecided in found.open.items():
        sentence = (
            f"`{check}` is not decided in {undecided.cases} of {found.cases} cases"
            f"{first_of(undecided, scenario)}: the limit lies within the 95 % confidence "
            "interval of the mean; only more seeds can decide"
        )
        yield Caution("check-undecided", sentence, {"cases": undecided.cases})


def first_of(found: Count, scenario: Scenario) -> str:
    """Say where the first of some cases is, unless there is only one place."""
    where = place(found.first.point, scenario.sweep)
    return f", the first at {where}" if where else ""
