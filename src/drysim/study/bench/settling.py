"""Settling: cases of a sweep as work to march through, and the orbits they must come to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from drysim.approach.stick_slip import StickSlip
from drysim.core.motion import Sines
from drysim.core.state import State
from drysim.errors import SolverError
from drysim.scenario.sweep.axis import points
from drysim.study.bench.judge import Yardstick
from drysim.study.bench.peers.scipy_ivp import checked, reference
from drysim.study.bench.scores import Score
from drysim.study.bench.work import Answer, Work
from drysim.study.case import assemble
from drysim.study.sweeps import cases

if TYPE_CHECKING:
    from drysim.study.case import Case

PERIODS, A_PERIOD = 100, 256
"""What settling takes: after so many periods of so many samples the start is forgotten."""

FEW = 12
"""Cases of a sweep, evenly spread, through which everything but the orbit search marches."""


@dataclass(frozen=True, eq=False)
class Settling:
    """A case of the sweep as work, one period of it, and the orbit that it must come to."""

    work: Work
    period: Work
    orbit: Yardstick

    def last(self, answer: Answer) -> Answer:
        """Give the last period of an answer."""
        part = slice(-A_PERIOD - 1, None)
        return Answer(answer.x_r[part], answer.v_r[part], lambda: answer.friction()[part])


def settlings(case: Case) -> Iterator[Settling]:
    """Give some cases of a sweep, evenly spread; those whose orbit takes one period."""
    motions, every = cases.Motions.beginning_with(case), list(points(case.scenario.sweep))
    for at in range(min(FEW, len(every))):
        point = every[(2 * at + 1) * len(every) // (2 * min(FEW, len(every)))]
        own = case.scenario.at(point)
        found = assemble(own, motions.of(own))
        assert found.period is not None, "all cases of a steady sweep have a period"
        assert isinstance(found.motion, Sines), "only sines repeat"
        orbit = StickSlip().orbit(
            found.plant, found.law, found.motion, found.start, found.period
        )
        if orbit.settled and orbit.periods == 1:
            scene = (own, found.plant, found.law, found.motion)
            step = found.period / A_PERIOD
            period = Work(*scene, State(*orbit.state[:2]), step, A_PERIOD)
            work = Work(*scene, found.start, step, PERIODS * A_PERIOD)
            yield Settling(work, period, Yardstick.of(period))


def followed(known: Sequence[Settling]) -> Score | None:
    """Give the errors of the reference where it begins on the orbits and follows them once.

    What marches from the start may not have settled after all its periods; an orbit that the
    reference comes back to is one. None where the reference itself fails.
    """
    entry = reference()
    score = Score(entry.approach, f"{entry.setting} from the orbit on", False, None, 0)
    found, apart = [], 0.0
    try:
        for one in known:
            answer = entry.ready(one.period)()
            found.append(one.orbit.errors(one.period, answer))
            apart = max(apart, one.orbit.apart(answer, checked(one.period)))
    except SolverError:
        return None
    off = max(error or 0.0 for error, _ in found)
    T_a = max((error or 0.0 for _, error in found), key=abs)
    score = replace(score, samples=A_PERIOD * len(found), uncertainty=apart)
    return replace(score, error_x_r=off, error_T_a=T_a)
