"""Errors and warnings: located problems, warning messages, the exceptions and the exit codes.

Every exception that drysim raises on purpose derives from `DrysimError`. Its `exit_code` is the
number in the second column:

    UsageError     2   arguments that contradict each other
    ScenarioError  2   a scenario file with errors, each with its location
    RecordError    2   a measured record that cannot be used
    OutputError    2   an output folder that drysim may not replace or cannot write
    SolverError    3   a numerical failure; the message contains the time
    ClusterError   3   workers of a cluster were lost; finished blocks are kept

The other exit codes are 0 (done), 1 (a check failed), 70 (a bug) and 130 (interrupted).
"""

from __future__ import annotations

import copyreg
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

EXIT_OK = 0
EXIT_CHECK_FAILED = 1
EXIT_NOTHING_COMPUTED = 2
EXIT_NUMERICS_FAILED = 3
EXIT_BUG = 70
EXIT_INTERRUPTED = 130


MAX_SENTENCE_LENGTH = 1000
"""Characters of a sentence. It bounds messages that quote the contents of a file."""


@dataclass(frozen=True)
class Problem:
    """One error, warning or note with its location in a file.

    Not to be confused with `WarningMessage`, which belongs to a result: a problem of severity
    `error` prevents the result.
    """

    sentence: str
    file: str = ""
    line: int = 0
    """1-based; 0 if the problem concerns the file as a whole."""
    column: int = 0
    """1-based, in characters; 0 when unknown."""
    width: int = 1
    """Number of characters that the caret underlines."""
    source: str = ""
    """The line of the file, without its line ending."""
    key: str = ""
    """Dotted path of the scenario key, e.g. `friction.kinetic`; empty if there is none."""
    severity: str = "error"
    """`error`, `warning`, or `note` for a step that the scenario requested."""
    remark: str = ""
    """What stands at the place if the key is missing, such as the block in which it belongs."""
    named_at: Problem | None = None
    """Where the scenario names the file, of a fault in a record."""

    @property
    def place(self) -> str:
        """Location in the form that editors understand, `file:line:column`, as far as known."""
        numbers = [str(number) for number in (self.line, self.column) if number]
        return ":".join([self.file, *numbers])

    def __str__(self) -> str:
        """Return location, or else the key, and sentence."""
        place = self.place or self.key
        return self.sentence if place in self.sentence else f"{place}: {self.sentence}"

    def __post_init__(self) -> None:
        """Cut a sentence that exceeds `MAX_SENTENCE_LENGTH`."""
        if len(self.sentence) > MAX_SENTENCE_LENGTH:
            object.__setattr__(self, "sentence", self.sentence[: MAX_SENTENCE_LENGTH - 1] + "…")


@dataclass(frozen=True)
class WarningMessage:
    """A warning stored with a result, so that every report contains the same text."""

    slug: str
    """Short stable identifier, e.g. `stroke-violated`."""
    sentence: str
    """What happened, where, and what to do."""
    numbers: Mapping[str, float] = field(default_factory=dict)


class DrysimError(Exception):
    """Base class of all exceptions that drysim raises on purpose.

    Parameters
    ----------
    message : str
        One sentence.
    hint : str, optional
        What to do about it. In Python it stands below the message, as a note.
    """

    exit_code = EXIT_NOTHING_COMPUTED

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        if hint:
            self.add_note(hint)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and copy by attributes.

        By default an exception is rebuilt from `args` alone, which fails for subclasses whose
        constructors have other arguments.
        """
        return copyreg.__newobj__, (type(self), *self.args), vars(self)  # type: ignore[attr-defined]


class UsageError(DrysimError):
    """Arguments that contradict each other or have an invalid value."""


class ScenarioError(DrysimError):
    """A scenario file with errors; holds every problem that was found.

    Parameters
    ----------
    message : str
        One sentence for all problems together.
    problems : tuple of Problem
    hint : str, optional
    """

    def __init__(self, message: str, problems: tuple[Problem, ...], hint: str = "") -> None:
        super().__init__(message, hint)
        self.problems = problems

    def __str__(self) -> str:
        """Return the message and every problem, one per line."""
        return "\n".join([self.message, *map(str, self.problems)])


class RecordError(DrysimError):
    """A measured record that cannot be used.

    Parameters
    ----------
    problem : Problem
        Names row and column where they are known.
    hint : str, optional
    """

    def __init__(self, problem: Problem, hint: str = "") -> None:
        super().__init__(problem.sentence, hint)
        self.problem = problem

    def __str__(self) -> str:
        """Return the problem with its location."""
        return str(self.problem)


class OutputError(DrysimError):
    """An output folder that drysim may not replace or cannot write."""


class SolverError(DrysimError):
    """A numerical failure; the message contains the time at which it occurred."""

    exit_code = EXIT_NUMERICS_FAILED


class ClusterError(DrysimError):
    """Workers of a cluster were lost during the computation; finished blocks are kept."""

    exit_code = EXIT_NUMERICS_FAILED
