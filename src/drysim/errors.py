"""Faults and warnings as values: a located `Problem`, a `WarningMessage`, the exceptions, exit codes.

DrysimError, whose `exit_code` is the number behind each line:

    UsageError     2   command-line words that make no sense together
    ScenarioError  2   a scenario file with problems, each located
    RecordError    2   a measured record that cannot be used
    OutputError    2   the output folder is not ours to replace, or cannot be written
    SolverError    3   the numerics failed; the time is named
    ClusterError   3   machines of a cluster were lost on the way; finished blocks stay

The other exit codes: 0 done, 1 a check failed, 70 a bug, 130 interrupted.
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
"""Characters of a sentence: no message retells a file, whatever it quotes."""


@dataclass(frozen=True)
class Problem:
    """One located fault of a file.

    Not to be confused with `WarningMessage`, which travels with an answer: a problem prevents one.
    """

    sentence: str
    file: str = ""
    line: int = 0
    """1-based; 0 when the fault belongs to the file as a whole."""
    column: int = 0
    """1-based, in characters; 0 when unknown."""
    width: int = 1
    """How many characters the caret underlines."""
    source: str = ""
    """The faulty line as it stands in the file, without its line end."""
    key: str = ""
    """Dotted path of the scenario key, e.g. `friction.kinetic`; empty when there is none."""
    severity: str = "error"
    """`error`, `warning`, or `note` of what was done as the scenario asks for it."""

    @property
    def place(self) -> str:
        """Where it is as editors understand it, `file:line:column`, as far as it is known."""
        numbers = [str(number) for number in (self.line, self.column) if number]
        return ":".join([self.file, *numbers])

    def __str__(self) -> str:
        """Give place and sentence."""
        return f"{self.place}: {self.sentence}"

    def __post_init__(self) -> None:
        """Cut a sentence that is endless."""
        if len(self.sentence) > MAX_SENTENCE_LENGTH:
            object.__setattr__(self, "sentence", self.sentence[: MAX_SENTENCE_LENGTH - 1] + "…")


@dataclass(frozen=True)
class WarningMessage:
    """A warning that travels with the outcome, so that every report tells the same story."""

    slug: str
    """Short stable name, e.g. `stroke-violated`."""
    sentence: str
    """What, where and what to do."""
    numbers: Mapping[str, float] = field(default_factory=dict)


class DrysimError(Exception):
    """Root of every fault that drysim raises on purpose."""

    exit_code = EXIT_NOTHING_COMPUTED

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and copy by attributes: an exception is else made from `args` alone."""
        return copyreg.__newobj__, (type(self), *self.args), vars(self)  # type: ignore[attr-defined]


class UsageError(DrysimError):
    """Command-line words that make no sense together."""


class ScenarioError(DrysimError):
    """A scenario file that is not a scenario yet; holds every problem found."""

    def __init__(self, message: str, problems: tuple[Problem, ...], hint: str = "") -> None:
        super().__init__(message, hint)
        self.problems = problems

    def __str__(self) -> str:
        """Give the message and every problem, a line each, as a traceback shows it."""
        return "\n".join([self.message, *map(str, self.problems)])


class RecordError(DrysimError):
    """A measured record that cannot be used; row and column are named in the problem."""

    def __init__(self, problem: Problem, hint: str = "") -> None:
        super().__init__(problem.sentence, hint)
        self.problem = problem

    def __str__(self) -> str:
        """Give the problem with its place."""
        return str(self.problem)


class OutputError(DrysimError):
    """The output folder is not ours to replace, or cannot be written."""


class SolverError(DrysimError):
    """The numerics failed; the message names the time of the failure."""

    exit_code = EXIT_NUMERICS_FAILED


class ClusterError(DrysimError):
    """Machines of a cluster that were lost on the way; what is finished stays."""

    exit_code = EXIT_NUMERICS_FAILED
