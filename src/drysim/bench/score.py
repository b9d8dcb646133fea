"""Results of a benchmark: scores from the error against the exact solution, and verdicts.

`Reference` holds the exact solution of the whole work. `entries` yields drysim's own entries:
every approach with several steps, methods and sharpnesses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import numpy as np

from drysim.approach.fixed_step import Moreau, Signum, Smooth, Switch
from drysim.approach.stepping import refine_motion
from drysim.approach.stick_slip import ExactApproach, StickSlip, Viscous
from drysim.bench.work import Answer, Entry, Run, Work
from drysim.core.model import Samples
from drysim.errors import SolverError
from drysim.study.outcome import Result, format_repr
from drysim.wording import format_deviation, format_number, join_words

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from drysim.approach import Approach
    from drysim.core.model import Floats, Sines
    from drysim.errors import WarningMessage
    from drysim.metrics.checks import Verdict
    from drysim.scenario.model import Scenario


EXACT_BELOW = 1e-9
"""Error up to which an answer is exact [-]: rounding and tight tolerances."""

MAX_UNCERTAINTY_SHARE = 0.1
"""Uncertainty of the reference over a deviation, up to which the deviation is attributed to the
exact approach [-]."""


@dataclass(frozen=True)
class Score:
    """Measured time and error of an entry.

    Attributes
    ----------
    approach, setting : str
        The entry.
    by_drysim : bool
        Whether it is an approach of drysim.
    step : float or None
        Time step [s]; None if adaptive.
    samples : int
        Number of samples it was timed on, from the start of the work.
    repeats : int
        Number of runs of the median; 0 if it failed.
    time : float or None
        Computing time per sample [ns].
    ratio : float or None
        `time` over that of scipy's lfilter [-].
    error_x_r : float or None
        Maximum error of x_r over the peak of |x_r| [-].
    error_T_a : float or None
        Relative error of T_a over these samples, signed [-].
    energy_residual : float or None
        Relative residual of the energy balance [-]; None if not computed.
    uncertainty : float or None
        Of the reference: difference of its two runs, relative as `error_x_r` [-].
    verdict : str
        `exact`, `close`, `fine`, `coarse`, `wrong`, `chatters`, `creeps`, `another law`,
        `failed` or `in doubt` (unknown, as the reference is uncertain), with the reason.
    """

    approach: str
    setting: str
    by_drysim: bool
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
        """Whether the error of the reference itself may explain its deviation."""
        off = self.error_x_r or 0.0
        return off > EXACT_BELOW and (self.uncertainty or 0.0) > MAX_UNCERTAINTY_SHARE * off


@dataclass(frozen=True, eq=False)
class BenchCase:
    """A scenario of a benchmark with the scores of all entries.

    Attributes
    ----------
    scenario : Scenario
    motion : Sines or Samples or None
        Base motion; None if it differs from case to case.
    scene : tuple of (str, str)
        Description of the work: labels and text.
    scores : tuple of Score
        drysim's approaches first, then the peers.
    lfilter : float
        Computing time per sample of scipy's lfilter on a record of the same length [ns].
    reference : Score or None
        Score of the reference; its errors are relative to the exact approach.
    warnings : tuple of WarningMessage
    """

    kind: ClassVar[str] = "bench"

    scenario: Scenario
    motion: Sines | Samples | None = field(compare=False)
    scene: tuple[tuple[str, str], ...]
    scores: tuple[Score, ...]
    lfilter: float
    reference: Score | None
    warnings: tuple[WarningMessage, ...]

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """Empty: a benchmark judges approaches, not the scenario."""
        return ()


@dataclass(frozen=True, eq=False)
class Bench(Result):
    """Speed and error of every approach on one or several scenarios.

    Attributes
    ----------
    cases : tuple of BenchCase
    engine : str
        `plain` or `compiled`.
    """

    kind: ClassVar[str] = "bench"

    cases: tuple[BenchCase, ...]
    engine: str

    def __repr__(self) -> str:
        """Return the number of scores in one line."""
        names = join_words([panel.scenario.name for panel in self.cases])
        count = sum(len(panel.scores) for panel in self.cases)
        return format_repr("Bench", names, f"{count} entries")

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """Empty: a benchmark judges approaches, not the scenario."""
        return ()

    @property
    def warnings(self) -> tuple[WarningMessage, ...]:
        """Warnings of all cases, without duplicates."""
        return tuple(
            {
                warning.sentence: warning for panel in self.cases for warning in panel.warnings
            }.values()
        )


CLOSE_BELOW, FINE_BELOW, COARSE_BELOW = 1e-4, 1e-2, 1e-1
"""Errors up to which an answer is close (below any measurement error), fine (negligible in
practice) and coarse (conclusions still hold) [-]."""

SATURATION_SHARE, CHATTER_SHARE = 0.99, 0.5
"""An answer chatters where |F_f| exceeds the first share of F_fk in more than the second share
of the stuck samples [-]."""

STOP_KINDS = (0, 2, -2)
"""Kinds of events at which v_r reaches zero: stick or reversal."""

ErrorPair = tuple[float | None, float | None]
"""Errors of x_r and T_a [-]."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Exact solution of a work, from which errors are computed.

    Attributes
    ----------
    x_r, x_dd : ndarray, shape (samples + 1,)
        Relative displacement [m], absolute acceleration [m/s²].
    stuck : ndarray of bool, shape (samples + 1,)
    scale : float
        Peak of |x_r| [m]; of a mass that never moves the peak without dry friction.
    stops : ndarray
        Times at which v_r reaches zero [s].
    """

    x_r: Floats
    x_dd: Floats
    stuck: NDArray[np.bool_]
    scale: float
    stops: Floats

    @classmethod
    def of(cls, work: Work) -> Self:
        """Solve a work exactly."""
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
        """Return the errors of x_r and T_a of an answer to the first samples of the work [-].

        Raises
        ------
        SolverError
            If the answer has the wrong length or is not finite.
        """
        points = work.samples + 1
        if answer.x_r.shape != (points,) or not np.isfinite(answer.x_r).all():
            raise SolverError("the result has missing or non-finite values")
        off = float(np.abs(answer.x_r - self.x_r[:points]).max()) / self.scale
        rms, exact = _rms(work.acceleration(answer)), _rms(self.x_dd[:points])
        return off, rms / exact - 1.0 if exact else None

    def max_difference(self, answer: Answer, other: Answer) -> float:
        """Return the maximum difference of x_r of two answers, relative to `scale` [-]."""
        return float(np.abs(answer.x_r - other.x_r).max()) / self.scale

    def symptoms(self, work: Work, answer: Answer) -> tuple[bool, bool]:
        """Return whether an answer chatters and whether it moves in stick phases.

        In stick the friction force balances the limit force. It has its full kinetic value
        only in an answer whose velocity alternates in sign.
        """
        stuck = self.stuck[: work.samples + 1]
        if not stuck.any():
            return False, False
        full = np.abs(answer.friction()[stuck]) > SATURATION_SHARE * work.law.F_fk
        chatters = work.law.F_fk > 0.0 and float(full.mean()) > CHATTER_SHARE
        return chatters, bool((answer.v_r[stuck] != 0.0).any())


def verdict(errors: ErrorPair, symptoms: tuple[bool, bool], other_law: bool) -> str:
    """Return the verdict on an answer.

    Parameters
    ----------
    errors : tuple
        Errors of x_r and T_a [-]; None where unknown.
    symptoms : tuple of bool
        Whether it chatters, and whether it moves, in stick phases.
    other_law : bool
        Whether the entry solves another law than that of the scene.
    """
    off, T_a = errors[0] or 0.0, errors[1] or 0.0
    worst = max(off, abs(T_a))
    for limit, word in ((EXACT_BELOW, "exact"), (CLOSE_BELOW, "close"), (FINE_BELOW, "fine")):
        if worst <= limit:
            return word
    how = (
        f"T_a {format_deviation(T_a, digits=2)}"
        if abs(T_a) >= off
        else f"x_r {format_number(100 * off, '%', 2)}"
    )
    chatters, moves = symptoms
    if chatters:
        return f"chatters, {how}"
    if other_law:
        return f"another law, {how}"
    if moves:
        return f"creeps, {how}"
    return f"{'coarse' if worst <= COARSE_BELOW else 'wrong'}, {how}"


def _rms(series: Floats) -> float:
    return sqrt(float(np.dot(series, series)) / len(series)) if len(series) else 0.0


SUBSTEPS = (1, 4, 16, 64)
"""Numbers of fixed steps per sample."""


class Setting(NamedTuple):
    """An approach, its options as text, and the numbers of steps per sample."""

    approach: Approach
    options: str
    finer: tuple[int, ...] = (1,)


def approach_settings() -> Iterator[Setting]:
    """Yield all settings of all approaches in a benchmark."""
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
    """Yield drysim's entries for a work; each solves the law its approach supports."""
    for approach, options, substeps in approach_settings():
        for count in substeps:
            yield make_entry(work, approach, options, count)


def make_entry(work: Work, approach: Approach, setting: str, count: int) -> Entry:
    """Return the entry of an approach with one setting, in words, and `count` steps per sample.

    It solves the law that the approach supports.
    """
    name = approach.approach
    law = work.scenario.with_approach(name).law()

    def ready(work: Work) -> Run:
        motion = refine_motion(work.motion, count)
        duration = None if isinstance(motion, Samples) else work.end
        step = work.step / count

        def run() -> Answer:
            response = approach.solve(work.plant, law, motion, work.start, step, duration)
            part = slice(None, None, count)
            return Answer(
                response.x_r[part], response.v_r[part], lambda: response.F_f[part], response
            )

        return run

    points = count * approach.substeps(work.plant, law, work.step / count)
    step = None if isinstance(approach, ExactApproach) else work.step / points
    other_law = bool(work.scenario.omissions(name)) or not approach.supports_friction
    return Entry(name, setting, ready, step, points, True, other_law)
