"""How much a run writes, told before it is done: its response has a row for every step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from drysim.errors import Caution
from drysim.study.memory import GIGA
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.study.case import Case

LARGE = "large-response"
"""The slug of the caution."""

ROW = 100
"""Bytes of a row of response.csv as a rule."""

LEAST_SHARE = 0.4
"""Share of them that is certain: a row is as short where the mass holds still."""

MUCH = 1e9
"""Bytes from which on somebody should know."""


def bytes_of(case: Case) -> float:
    """Give about how much response.csv will hold [bytes]."""
    return float(ROW * (case.steps + 1))


def cautions(case: Case) -> Iterator[Caution]:
    """Say when the response that a run writes is large; a sweep writes none."""
    volume = bytes_of(case)
    if volume > MUCH and not case.scenario.sweep:
        sentence = (
            f"a run writes response.csv with {case.steps + 1:.3g} rows, some "
            f"{volume / GIGA:.3g} GB; a step longer than {number(case.step, 's')} or a shorter "
            "duration makes it smaller"
        )
        yield Caution(LARGE, sentence, {"rows": case.steps + 1, "bytes": volume})
