"""Table: the outcomes of many cases, without their responses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from drysim.scenario.seeds import SEED
from drysim.study.brief import judged, line, spans
from drysim.study.outcome import exit_code
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.core.motion import Samples, Sines
    from drysim.errors import Caution
    from drysim.metrics import Metrics
    from drysim.scenario import Axis, Scenario
    from drysim.study.sweeps.tally import Tally

OK = "ok"
NOT_SETTLED = "not settled"
NOT_UNIQUE = "not unique"
FAILED = "failed"

LIMIT = "stroke.limit"
"""The key of the stroke limit, which a case has of its own where it is swept."""


@dataclass(frozen=True)
class OverSeeds:
    """What is known of a case that is many seeds, beside the means of its metrics.

    Attributes
    ----------
    count : int
        How many seeds.
    half_widths : mapping
        Half of the 95 % confidence interval, by metric.
    T_a : sequence of float
        By seed: two approaches are compared seed by seed.
    sha256 : str
        Of the hashes of all base accelerations (hex).
    narrow : bool
        Whether the interval is as narrow as `until` asks for, if it does.
    """

    count: int
    half_widths: Mapping[str, float | None] = field(default_factory=dict)
    T_a: Sequence[float | None] = ()
    sha256: str = ""
    narrow: bool = True


@dataclass(frozen=True)
class Row:
    """One case of a sweep, solved by one approach.

    Attributes
    ----------
    point : mapping
        Swept keys and their values in SI, in the order of the axes; a key that the approach has
        no use for (friction under `viscous`) is missing.
    approach : str
        Name on the shelf.
    F_fk, F_fs : float
        Friction forces [N].
    metrics : mapping
        As `drysim.metrics.measure` gives them; all None where the status is not `ok`.
    status : str
        `ok`, `not settled`, `not unique` or `failed`.
    note : str
        What is to be said about a status other than `ok`.
    sha256 : str
        Of the base acceleration (hex), where the case is one seed of many.
    over : OverSeeds or None
        How well the metrics are known, where they are means over many seeds.
    """

    point: Mapping[str, float]
    approach: str
    F_fk: float
    F_fs: float
    metrics: Metrics
    status: str = OK
    note: str = ""
    sha256: str = ""
    over: OverSeeds | None = None

    @property
    def seed(self) -> int:
        """Its seed, where the case is one of many."""
        return int(self.point[SEED])

    @property
    def seeds(self) -> int:
        """How many seeds the metrics are means over."""
        return self.over.count if self.over else 1

    @property
    def half_widths(self) -> Mapping[str, float | None]:
        """Half of the 95 % confidence interval of every metric that is a mean."""
        return self.over.half_widths if self.over else {}


def stroke_limit(scenario: Scenario, row: Row) -> float | None:
    """Give the stroke limit of a case [m]: its own where it is swept; None without one."""
    stroke = scenario.stroke
    return None if stroke is None else row.point.get(LIMIT, stroke.limit)


@dataclass(frozen=True, eq=False)
class Table:
    """All cases of a sweep or of a comparison.

    Attributes
    ----------
    scenario : Scenario
    axes : tuple of Axis
        Swept keys with unit and values; the first varies fastest. Empty for a comparison of one
        case.
    rows : sequence of Row
        Approach by approach, each in the order of the grid.
    checks : tuple of Verdict
    warnings : tuple of Caution
    complete : bool
        Whether every case was computed.
    motion : Sines or Samples or None
        The base motion, where all cases share one.
    numerics : mapping
        How the numbers were made, as far as all cases share it: core, why, engine, ...
    told : mapping
        What the cases of each approach come to, where it was gathered as they were computed.
    """

    scenario: Scenario
    axes: tuple[Axis, ...]
    rows: Sequence[Row]
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[Caution, ...] = ()
    complete: bool = True
    motion: Sines | Samples | None = None
    numerics: Mapping[str, object] = field(default_factory=dict)
    told: Mapping[str, Tally] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give the number of rows."""
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        """Give the rows in order."""
        return iter(self.rows)

    def __getitem__(self, number: int) -> Row:
        """Give one row."""
        return self.rows[number]

    def __repr__(self) -> str:
        """Give what the cases come to, in a line."""
        name, kept = self.scenario.name, judged(self.checks, self.warnings)
        tallies = list(self.tallies.values())
        told = [f"{several(tally.cases, 'case')} by {tally.approach}" for tally in tallies]
        # What a comparison is judged by comes last of those that were asked for.
        own = next((one for one in tallies if one.checks), tallies[0] if tallies else None)
        found = f"{spans(own.ends)}{f' by {own.approach}' * (len(tallies) > 1)}" if own else ""
        return line("Table", name, ", ".join(told), found, kept)

    @property
    def approaches(self) -> tuple[str, ...]:
        """The approaches in the order in which they were asked for."""
        return tuple(self.tallies)

    @cached_property
    def tallies(self) -> Mapping[str, Tally]:
        """What the cases come to, by approach; the one that was asked for comes first."""
        from drysim.study.sweeps.rows import batches_of
        from drysim.study.sweeps.tally import Tally

        return self.told or Tally.of(batches_of(self.rows))

    def exit_code(self, strict: bool = False) -> int:
        """Give 3 when a case failed, 1 when a check did; `strict` counts warnings as checks."""
        lost = any(FAILED in tally.lost for tally in self.tallies.values())
        return exit_code(self.checks, self.warnings, strict, lost)

    @property
    def own(self) -> tuple[Row, ...]:
        """The rows of the approach that was asked for, those of its reference left aside."""
        return tuple(self.of(self.approaches[0])) if self.rows else ()

    def of(self, approach: str) -> Iterator[Row]:
        """Give the rows of one approach."""
        return (row for row in self.rows if row.approach == approach)
