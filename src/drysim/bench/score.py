"""What a bench gives: scores by the error against the exact answer, verdicts in a few words.

The judge knows the exact answer on the whole work. Below stand the entries of drysim's own
shelf: every approach at several steps, methods and sharpnesses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from drysim.approach.fixed_step import Moreau, Signum, Smooth, Switch
from drysim.approach.stepping import refine_motion
from drysim.approach.stick_slip import ExactApproach, StickSlip, Viscous
from drysim.bench.work import Answer, Entry, Run, Work
from drysim.core.model import Samples
from drysim.errors import SolverError
from drysim.wording import format_number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from drysim.approach import Approach
    from drysim.approach.solution import Floats
    from drysim.core.model import AnyLaw, Sines
    from drysim.errors import WarningMessage
    from drysim.metrics.checks import Verdict
    from drysim.scenario.model import Scenario


EXACT_BELOW = 1e-9
"""Error [-] up to which an answer counts as exact: rounding and tight tolerances."""

MAX_UNCERTAINTY_SHARE = 0.1
"""Share of a deviation below which the reference's own error leaves no doubt whose it is."""


@dataclass(frozen=True)
class Score:
    """One entry, measured.

    Attributes
    ----------
    approach, setting : str
        Which entry it is.
    own : bool
        Whether it stands on drysim's shelf.
    step : float or None
        Step of its march [s]; None where it chooses its own.
    samples : int
        Stretch of the work that it was timed on, from the start on.
    repeats : int
        Runs behind the median; 0 where it failed.
    time : float or None
        Time a sample [ns].
    ratio : float or None
        The same over that of scipy's lfilter [-].
    error_x_r : float or None
        Greatest error of x_r over the peak of |x_r| [-].
    error_T_a : float or None
        Error of T_a on the stretch, relative and signed [-].
    energy_residual : float or None
        What its energy balance leaves [-]; None where it keeps none.
    uncertainty : float or None
        Of the reference: what its two runs differ by [-], relative as `error_x_r` is.
    verdict : str
        `exact`, `close`, `fine`, `coarse`, `wrong`, `chatters`, `creeps`, `another law`,
        `failed` or `in doubt` (not known, as the reference is in doubt), with what is wrong.
    """

    approach: str
    setting: str
    own: bool
    step: float | None
    samples: int
    repeats: int = 0
    time: float | None = None
    ratio: float | None = None
    error_x_r: float | None = None
    error_T_a: float | None = None
    energy_residual: float | None = None
    uncertainty: float | None = None
    verdict: str = ""

    @property
    def in_doubt(self) -> bool:
        """Whether a reference may itself be what it differs by from the exact approach."""
        off = self.error_x_r or 0.0
        return off > EXACT_BELOW and (self.uncertainty or 0.0) > MAX_UNCERTAINTY_SHARE * off


@dataclass(frozen=True, eq=False)
class BenchCase:
    """One scene of a bench with the scores of all entries.

    Attributes
    ----------
    scenario : Scenario
        What was asked.
    motion : Sines or Samples or None
        How the base moved; None where it moved differently from case to case.
    words : tuple of (str, str)
        What every entry solves: heads and sentences.
    scores : tuple of Score
        drysim's shelf first, then the peers.
    lfilter : float
        Time a sample of scipy's lfilter on a record of that length [ns].
    reference : Score or None
        What the exact approach was held to: its errors are those of the reference against it.
    warnings : tuple of Caution
    """

    scenario: Scenario
    motion: Sines | Samples | None
    words: tuple[tuple[str, str], ...]
    scores: tuple[Score, ...]
    lfilter: float
    reference: Score | None
    warnings: tuple[WarningMessage, ...]

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """None: a bench judges approaches, not the scenario."""
        return ()


@dataclass(frozen=True, eq=False)
class Bench:
    """Speed against error of every approach, on one scene or several.

    Attributes
    ----------
    panels : tuple of Panel
    engine : str
        `plain` or `compiled`.
    """

    cases: tuple[BenchCase, ...]
    engine: str

    @property
    def warnings(self) -> tuple[WarningMessage, ...]:
        """The warnings of all scenes, each sentence once."""
        return tuple(
            {one.sentence: one for panel in self.cases for one in panel.warnings}.values()
        )


CLOSE_BELOW, FINE_BELOW, COARSE_BELOW = 1e-4, 1e-2, 1e-1
"""Errors [-] up to which an answer counts as close, fine and coarse: what no measurement tells
apart, what nobody minds, what misleads nobody."""

SATURATION_SHARE, CHATTER_SHARE = 0.99, 0.5
"""Share of F_fk [-] that counts as all of it, and of the time that counts as most of it."""

STOP_KINDS = (0, 2, -2)
"""Kinds of events at which the mass comes to a stop: it sticks or turns."""

ErrorPair = tuple[float | None, float | None]
"""Of x_r and of T_a [-]."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The exact answer on the whole work, and what errors are relative to.

    Attributes
    ----------
    x_r, x_dd : ndarray, shape (samples + 1,)
        Relative displacement [m], absolute acceleration [m/s²].
    stuck : ndarray of bool, shape (samples + 1,)
    scale : float
        Greatest |x_r| [m], or where the mass never moves that without dry friction.
    stops : ndarray
        Instants at which the mass comes to a stop [s].
    """

    x_r: Floats
    x_dd: Floats
    stuck: NDArray[np.bool_]
    scale: float
    stops: Floats

    @classmethod
    def of(cls, work: Work) -> Self:
        """Give the exact answer to a work."""
        scene = (work.motion, work.start, work.step)
        duration = None if isinstance(work.motion, Samples) else work.end
        exact = StickSlip().solve(work.plant, work.law, *scene, duration)
        scale = float(np.abs(exact.x_r).max())
        if not scale:
            free = Viscous().solve(work.plant, work.law, *scene, duration)
            scale = float(np.abs(free.x_r).max())
        stops = exact.events.t[1:][np.isin(exact.events.kind[1:], STOP_KINDS)]
        return cls(exact.x_r, exact.x_dd, exact.stuck, scale or 1.0, stops)

    def errors(self, work: Work, answer: Answer) -> ErrorPair:
        """Give the errors of an answer on a stretch of the work.

        Raises
        ------
        SolverError
            When the answer is no row of numbers of the right length.
        """
        points = work.samples + 1
        if answer.x_r.shape != (points,) or not np.isfinite(answer.x_r).all():
            raise SolverError("the answer is not a finite number at every sample")
        off = float(np.abs(answer.x_r - self.x_r[:points]).max()) / self.scale
        own, exact = _rms(work.acceleration(answer)), _rms(self.x_dd[:points])
        return off, own / exact - 1.0 if exact else None

    def max_difference(self, one: Answer, other: Answer) -> float:
        """Return how far x_r of two answers is apart at most [-], relative as errors are."""
        return float(np.abs(one.x_r - other.x_r).max()) / self.scale

    def symptoms(self, work: Work, answer: Answer) -> tuple[bool, bool]:
        """Tell whether an answer chatters, and whether it moves, where the mass should stick.

        Friction balances what pulls there. It is as large as it can be only where it drives
        the mass to and fro.
        """
        stuck = self.stuck[: work.samples + 1]
        if not stuck.any():
            return False, False
        full = np.abs(answer.friction()[stuck]) > SATURATION_SHARE * work.law.F_fk
        chatters = work.law.F_fk > 0.0 and float(full.mean()) > CHATTER_SHARE
        return chatters, bool((answer.v_r[stuck] != 0.0).any())


def verdict(errors: ErrorPair, symptoms: tuple[bool, bool], omitted: bool) -> str:
    """Give the verdict on an answer in a few words.

    Parameters
    ----------
    errors : tuple
        Of x_r and T_a [-]; None where there is none.
    symptoms : tuple of bool
        Whether it chatters, and moves, where the mass should stick.
    lacks : bool
        Whether it leaves something of the scene out.
    """
    off, T_a = errors[0] or 0.0, errors[1] or 0.0
    worst = max(off, abs(T_a))
    for limit, word in ((EXACT_BELOW, "exact"), (CLOSE_BELOW, "close"), (FINE_BELOW, "fine")):
        if worst <= limit:
            return word
    how = (
        f"T_a {100 * T_a:+.2g} %"
        if abs(T_a) >= off
        else f"x_r {format_number(100 * off, '%', 2)}"
    )
    chatters, moves = symptoms
    if chatters:
        return f"chatters, {how}"
    if omitted:
        return f"another law, {how}"
    if moves:
        return f"creeps, {how}"
    return f"{'coarse' if worst <= COARSE_BELOW else 'wrong'}, {how}"


def _rms(series: Floats) -> float:
    return sqrt(float(np.dot(series, series)) / len(series)) if len(series) else 0.0


SUBSTEPS = (1, 4, 16, 64)
"""Pieces of a sample that fixed steps are tried with."""


class Setting(NamedTuple):
    """An approach with its options, in words, and the pieces of a sample to try."""

    approach: Approach
    words: str
    finer: tuple[int, ...] = (1,)


def approach_settings() -> Iterator[Setting]:
    """Give every setting of every approach that is worth a row."""
    yield Setting(StickSlip(), "")
    yield Setting(Switch(), "", SUBSTEPS)
    yield Setting(Moreau(), "", SUBSTEPS)
    yield Setting(Signum(method="semi-implicit"), "semi-implicit", SUBSTEPS)
    yield Setting(Signum(method="rk4"), "rk4", SUBSTEPS)
    yield Setting(Signum(method="euler"), "euler", SUBSTEPS[1:2])
    yield Setting(Signum(method="heun"), "heun", SUBSTEPS[1:2])
    for c in (1e2, 1e3, 1e4, 1e5):
        yield Setting(Smooth(sharpness=c), f"tanh, c {format_number(c)}")
    for c in (1e3, 1e4, 1e5):
        yield Setting(Smooth(form="rational", sharpness=c), f"rational, c {format_number(c)}")
    yield Setting(Smooth(form="arctan", sharpness=1e4), "arctan, c 10000")
    yield Setting(Smooth(form="erf", sharpness=1e4), "erf, c 10000")
    yield Setting(Smooth(method="rk4"), "tanh, c 1000, rk4", SUBSTEPS[:2])
    yield Setting(Smooth(method="adaptive"), "tanh, c 1000, LSODA")
    yield Setting(Viscous(), "")


def entries(work: Work) -> Iterator[Entry]:
    """Give the entries of the shelf for a work; what an approach cannot use is left out."""
    for approach, words, substeps in approach_settings():
        name = approach.approach
        law = work.scenario.with_approach(name).law()
        omitted = work.scenario.omissions(name)
        for count in substeps:
            yield make_entry(work, approach, words, law, omitted, count)


def make_entry(
    work: Work,
    approach: Approach,
    words: str,
    law: AnyLaw,
    omitted: tuple[str, ...],
    count: int,
) -> Entry:
    """Give one approach with one setting, each sample of the work cut into so many pieces."""

    def ready(work: Work) -> Run:
        motion = refine_motion(work.motion, count)
        duration = None if isinstance(motion, Samples) else work.end
        step = work.step / count

        def run() -> Answer:
            found = approach.solve(work.plant, law, motion, work.start, step, duration)
            part = slice(None, None, count)
            return Answer(found.x_r[part], found.v_r[part], lambda: found.F_f[part], found)

        return run

    points = count * approach.substeps(work.plant, law, work.step / count)
    step = None if isinstance(approach, ExactApproach) else work.step / points
    return Entry(approach.approach, words, ready, step, points, True, omitted)
