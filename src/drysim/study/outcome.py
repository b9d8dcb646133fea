"""Outcome of one case: plain values, an exit code and a one-line representation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, overload

import numpy as np

import drysim
from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK, WarningMessage
from drysim.metrics.text import format_metrics
from drysim.wording import format_count, join_words

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
    """What all results share: pictures, tables, files, a report, and an exit code.

    Each of them is that of the kind of result, which lies in a higher layer and is imported
    through the package when it is needed. Two results are equal if they are of the same
    scenario and have the same numbers.
    """

    kind: ClassVar[str]
    """Name of the kind of result in `drysim.results`."""

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed in one of many cases; a single one raises an error."""
        return False

    def __eq__(self, other: object) -> bool:
        """Whether another result is of the same scenario and has the same numbers."""
        return same(self, other)

    def __hash__(self) -> int:
        """Return the hash of the representation, which equal results share."""
        return hash(repr(self))

    def plot(self, picture: str | None = None, ax: Any = None) -> Any:
        """Return a picture of the result, a figure of matplotlib; see `drysim.plot`."""
        return drysim.plot(self, picture, ax)

    def to_frame(self, table: str | None = None) -> Any:
        """Return a table of the result as a DataFrame of pandas.

        Parameters
        ----------
        table : str, optional
            Name of the table, that of its CSV file; default: the main one.

        Returns
        -------
        pandas.DataFrame
            The columns of the CSV file in SI units, NaN where a number is missing.
            `frame.attrs["units"]` has the unit of each column of numbers.

        Raises
        ------
        UsageError
            If pandas is not installed, or the result has no such table or nothing for it.
        """
        return drysim.to_frame(self, table)

    def save(self, folder: str | Path, *, plots: bool = True, report: bool = False) -> Path:
        """Write the files of the result into a folder, as the commands do.

        Parameters
        ----------
        folder : str or Path
            It is replaced, unless it has files that drysim did not write.
        plots : bool, optional
            Whether to draw the pictures.
        report : bool, optional
            Whether to write report.html as well.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        OutputError
            If the folder was not written by drysim, or cannot be written.
        """
        written: Path = drysim.save(self, folder, plots=plots, report=report)
        return written

    @overload
    def report(self, file: None = None) -> str: ...
    @overload
    def report(self, file: str | Path) -> Path: ...
    def report(self, file: str | Path | None = None) -> str | Path:
        """Return the report of the result, or write it into a file; see `drysim.report`."""
        page: str | Path = drysim.report(self, file)
        return page

    def _repr_html_(self) -> str:
        """Return numbers, checks and verdict as HTML, for notebooks."""
        page: str = drysim.to_html(self)
        return page

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


def same(value: Any, other: Any) -> bool:
    """Whether two values hold the same numbers, arrays included; NaN equals NaN.

    Fields of dataclasses with `compare=False` follow from the others and are ignored.
    """
    if type(value) is not type(other):
        return False
    if isinstance(value, np.ndarray):
        return np.array_equal(value, other, equal_nan=value.dtype.kind in "fc")
    if is_dataclass(value):
        names = [field.name for field in fields(value) if field.compare]
        return all(same(getattr(value, name), getattr(other, name)) for name in names)
    if isinstance(value, Mapping):
        return value.keys() == other.keys() and all(
            same(value[key], other[key]) for key in value
        )
    if isinstance(value, Sequence) and not isinstance(value, str):
        return len(value) == len(other) and all(map(same, value, other))
    return bool(value == other or (value != value and other != other))


# One-line representations for notebooks and debuggers.


def count_verdicts(checks: Sequence[Verdict], warnings: Sequence[WarningMessage]) -> str:
    """Return how many checks hold or are skipped, and how many warnings there are."""
    passed = sum(verdict.passed is True for verdict in checks)
    left = sum(verdict.passed is None for verdict in checks)
    parts = [f"{passed} of {format_count(len(checks), 'check')} held"] * bool(checks)
    parts += [f"{left} skipped"] * bool(left)
    parts += [format_count(len(warnings), "warning")] * bool(warnings)
    return join_words(parts) if parts else ""


def format_repr(what: str, name: str, *parts: str) -> str:
    """Return a one-line representation: type, name of the scenario, non-empty parts."""
    return f"<{what} of {name}: {'; '.join(filter(None, parts))}>"
