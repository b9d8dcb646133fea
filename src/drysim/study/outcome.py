"""Outcome of one case: plain values, an exit code and a one-line representation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import drysim
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK, WarningMessage
from drysim.metrics.table import UNITS
from drysim.metrics.text import format_metrics
from drysim.wording import format_count, format_number, format_unit, join_words

if TYPE_CHECKING:
    from drysim.approach.solution import Events, Response
    from drysim.metrics.checks import Verdict
    from drysim.metrics.spectra import Spectra
    from drysim.metrics.table import Values
    from drysim.scenario.model import Scenario


class Judged(Protocol):
    """What an exit code follows from."""

    @property
    def checks(self) -> Sequence[Verdict]:
        """Verdicts on the checks."""

    @property
    def warnings(self) -> Sequence[WarningMessage]:
        """Warnings about the result."""

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed in a case."""


class AnyResult(Judged, Protocol):
    """A result of any kind."""

    kind: ClassVar[str]

    def exit_code(self, strict: bool = False) -> int:
        """Return the exit code."""


class Result:
    """What all results share: a picture, and an exit code."""

    kind: ClassVar[str]
    """Name of the kind of result in `drysim.results`."""

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed in one of many cases; a single one raises an error."""
        return False

    def plot(self: Any) -> Any:
        """Return the main picture of the result, a figure of matplotlib; see `drysim.plot`."""
        return drysim.plot(self)

    def exit_code(self: Judged, strict: bool = False) -> int:
        """Return 3 if one of many cases failed, 1 if a check failed, else 0.

        With `strict`, a warning and a check that was not judged count as failed checks.
        """
        if self.has_failed_cases:
            return EXIT_NUMERICS_FAILED
        wanted = (True,) if strict else (True, None)
        failed = not all(verdict.passed in wanted for verdict in self.checks)
        return EXIT_CHECK_FAILED if failed or (strict and self.warnings) else EXIT_OK


@dataclass(frozen=True, eq=False)
class Outcome(Result):
    """Response, metrics, check verdicts and warnings of one case.

    Attributes
    ----------
    scenario : Scenario
        The scenario that was solved.
    response : Response
        Motion on the output grid; one repetition of the periodic orbit if the scenario measures
        the steady state.
    metrics : dict
        Metrics by name, in SI units; None where a metric is unknown.
    checks : tuple of Verdict
        One verdict per check of the scenario, in the same order.
    warnings : tuple of WarningMessage
        Warnings in the order in which they were found, each slug at most once per place.
    spectra : Spectra or None
        Spectra of base and mass, if the scenario requests them.
    """

    kind: ClassVar[str] = "run"

    scenario: Scenario
    response: Response
    metrics: Values
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    spectra: Spectra | None = None

    @property
    def events(self) -> Events:
        """Stops, break-aways and reversals in order of time."""
        return self.response.events

    def __repr__(self) -> str:
        """Return number of events, key metrics and verdicts in one line."""
        many = format_count(len(self.events), "event")
        verdicts = count_verdicts(self.checks, self.warnings)
        return format_repr(
            "Outcome", self.scenario.name, format_metrics(self.metrics), many, verdicts
        )

    def _repr_html_(self) -> str:
        """Return metrics and verdicts as HTML, for notebooks."""
        rows = [
            (name, format_number(value), format_unit(UNITS[name]))
            for name, value in self.metrics.items()
            if value is not None
        ]
        return html_table(repr(self), ("metric", "value", "unit"), rows, self.checks)


# One-line representations for notebooks and debuggers.


def count_verdicts(checks: Sequence[Verdict], warnings: Sequence[WarningMessage]) -> str:
    """Return how many checks hold or are skipped, and how many warnings there are."""
    passed = sum(verdict.passed is True for verdict in checks)
    left = sum(verdict.passed is None for verdict in checks)
    parts = [f"{passed} of {format_count(len(checks), 'check')} held"] * bool(checks)
    parts += [f"{left} skipped"] * bool(left)
    parts += [format_count(len(warnings), "warning")] * bool(warnings)
    return join_words(parts) if parts else ""


def html_table(
    caption: str,
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    checks: Iterable[Verdict] = (),
    notes: Iterable[str] = (),
) -> str:
    """Return a table as HTML, with notes and verdicts below it."""
    lines = [
        "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
        for tag, cells in (("th", header), *(("td", row) for row in rows))
    ]
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    sentences = [*notes, *(verdict.sentence for verdict in checks)]
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    below = f"<ul>{items}</ul>" if items else ""
    return f"<table><caption>{escape(caption)}</caption>{body}</table>{below}"


def format_repr(what: str, name: str, *parts: str) -> str:
    """Return a one-line representation: type, name of the scenario, non-empty parts."""
    return f"<{what} of {name}: {'; '.join(filter(None, parts))}>"
