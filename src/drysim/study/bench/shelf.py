"""The entries of drysim's own shelf: every approach at several steps, methods, sharpnesses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from drysim.approach.moreau import Moreau
from drysim.approach.signum import Signum
from drysim.approach.smooth import Smooth
from drysim.approach.stepped import finer
from drysim.approach.stick_slip import Exact, StickSlip
from drysim.approach.switch import Switch
from drysim.approach.viscous import Viscous
from drysim.core.motion import Samples
from drysim.study.bench.entry import Entry, Run
from drysim.study.bench.work import Answer, Work
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.approach import Approach
    from drysim.core.plant import AnyLaw

FINER = (1, 4, 16, 64)
"""Pieces of a sample that fixed steps are tried with."""


class Setting(NamedTuple):
    """An approach with its options, in words, and the pieces of a sample to try."""

    approach: Approach
    words: str
    finer: tuple[int, ...] = (1,)


def settings() -> Iterator[Setting]:
    """Give every setting of every approach that is worth a row."""
    yield Setting(StickSlip(), "")
    yield Setting(Switch(), "", FINER)
    yield Setting(Moreau(), "", FINER)
    yield Setting(Signum(method="semi-implicit"), "semi-implicit", FINER)
    yield Setting(Signum(method="rk4"), "rk4", FINER)
    yield Setting(Signum(method="euler"), "euler", FINER[1:2])
    yield Setting(Signum(method="heun"), "heun", FINER[1:2])
    for c in (1e2, 1e3, 1e4, 1e5):
        yield Setting(Smooth(sharpness=c), f"tanh, c {number(c)}")
    for c in (1e3, 1e4, 1e5):
        yield Setting(Smooth(form="rational", sharpness=c), f"rational, c {number(c)}")
    yield Setting(Smooth(form="arctan", sharpness=1e4), "arctan, c 10000")
    yield Setting(Smooth(form="erf", sharpness=1e4), "erf, c 10000")
    yield Setting(Smooth(method="rk4"), "tanh, c 1000, rk4", FINER[:2])
    yield Setting(Smooth(method="adaptive"), "tanh, c 1000, LSODA")
    yield Setting(Viscous(), "")


def entries(work: Work) -> Iterator[Entry]:
    """Give the entries of the shelf for a work; what an approach cannot use is left out."""
    for approach, words, pieces in settings():
        name = approach.approach
        law = work.scenario.with_approach(name).law()
        lacks = work.scenario.losses(name)
        for count in pieces:
            yield entry(work, approach, words, law, lacks, count)


def entry(
    work: Work,
    approach: Approach,
    words: str,
    law: AnyLaw,
    lacks: tuple[str, ...],
    count: int,
) -> Entry:
    """Give one approach with one setting, each sample of the work cut into so many pieces."""

    def ready(work: Work) -> Run:
        motion = finer(work.motion, count)
        duration = None if isinstance(motion, Samples) else work.end
        step = work.step / count

        def run() -> Answer:
            found = approach.solve(work.plant, law, motion, work.start, step, duration)
            part = slice(None, None, count)
            return Answer(found.x_r[part], found.v_r[part], lambda: found.F_f[part], found)

        return run

    points = count * approach.pieces(work.plant, law, work.step / count)
    step = None if isinstance(approach, Exact) else work.step / points
    return Entry(approach.approach, words, ready, step, points, True, lacks)
