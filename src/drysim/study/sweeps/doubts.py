"""What a reader of many cases should know: warnings as values, found after the work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from drysim.errors import Caution
from drysim.study.cautions import impacts_left_out
from drysim.study.sweeps.table import FAILED, LIMIT, stroke_limit
from drysim.wording import length, number, place, several

if TYPE_CHECKING:
    from drysim.scenario import Axis, Scenario
    from drysim.study.sweeps.table import Row
    from drysim.study.sweeps.tally import Tally


def statuses(tallies: Iterable[Tally], axes: Sequence[Axis]) -> Iterator[Caution]:
    """Say how many cases of each approach have no numbers, and why the first has none."""
    for tally in tallies:
        for status, (lost, row) in tally.lost.items():
            first = f"the first at {place(row.point, axes)}: " if row.point else ""
            sentence = (
                f"{lost} of {several(tally.cases, 'case')} by {tally.approach}: {status}; "
                f"{first}{row.note}"
            )
            slug = "case-failed" if status == FAILED else status.replace(" ", "-")
            yield Caution(slug, sentence, {"cases": lost})


def strokes(tally: Tally, scenario: Scenario) -> Iterator[Caution]:
    """Say in how many cases the stroke limit is met, and where the most."""
    worst, hits = tally.worst, tally.extremes.get("impact_speed")
    axes = scenario.sweep
    if hits is not None and hits[1].value and worst is not None:
        # Where there are end stops, |x_r| hardly tells one case from another.
        fastest, row = hits[1]
        sentence = (
            f"the mass comes to its end stops in {tally.beyond} of {tally.cases} cases, "
            f"with up to {number(fastest, 'm/s')}{at(row, axes)}"
        )
        numbers = {"impact_speed": fastest, "cases": tally.beyond}
        yield Caution("stroke-violated", sentence, numbers)
        if scenario.stops and scenario.stops.stiffness is None:
            yield impacts_left_out()
    elif worst is not None and (limit := stroke_limit(scenario, worst)) is not None:
        peak = worst.metrics.get("x_r_peak") or 0.0
        some, mean = (", with some seeds", " in the mean") if worst.over else ("", "")
        beside = tally.greatest("x_r_peak") or peak
        which = "" if LIMIT in worst.point else f" of {length(limit, beside)}"
        sentence = (
            f"the stroke limit{which} is met in {tally.beyond} of {tally.cases} cases{some}; "
            f"|x_r| reaches {length(peak, beside)}{mean}{at(worst, axes)}"
        )
        numbers = {"limit": limit, "x_r_peak": peak, "cases": tally.beyond}
        yield Caution("stroke-violated", sentence, numbers)


def at(row: Row, axes: Sequence[Axis]) -> str:
    """Give the point of a row as the end of a sentence, if there is more than one."""
    return f" at {place(row.point, axes)}" if row.point else ""
