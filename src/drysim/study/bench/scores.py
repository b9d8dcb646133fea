"""What a bench gives, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.core.motion import Samples, Sines
    from drysim.errors import Caution
    from drysim.scenario import Scenario


EXACT = 1e-9
"""Error [-] up to which an answer counts as exact: rounding and tight tolerances."""

CERTAIN = 0.1
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
        return off > EXACT and (self.uncertainty or 0.0) > CERTAIN * off


@dataclass(frozen=True, eq=False)
class Panel:
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
    warnings: tuple[Caution, ...]

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
    absent : tuple of str
        Peers that are not installed.
    engine : str
        `plain` or `compiled`.
    """

    panels: tuple[Panel, ...]
    absent: tuple[str, ...]
    engine: str

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """The warnings of all scenes, each sentence once."""
        return tuple(
            {one.sentence: one for panel in self.panels for one in panel.warnings}.values()
        )
