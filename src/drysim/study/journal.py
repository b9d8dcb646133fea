"""Journal: the finished cases of a sweep under way, so that a kill loses none of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TextIO

import drysim
from drysim import regular
from drysim.core.compiled import source_digest
from drysim.errors import UsageError
from drysim.study.hashes import hashes_of
from drysim.study.sweeps.table import OverSeeds, Row

if TYPE_CHECKING:
    from types import TracebackType

    from drysim.scenario import Scenario


class Journal:
    """A file whose first line says what is swept, and every other line is a finished case.

    A line cut short by a kill is passed over. Numbers are written so that they read back as
    they were: a sweep that goes on gives the very table of one that was never interrupted.
    """

    def __init__(self, file: Path, what: Mapping[str, Any], resume: bool) -> None:
        self.file = file
        self.what = dict(what)
        self.done: dict[int, Row] = {}
        if resume and _is_there(file):
            self.done = self._read()
        lines = [self.what, *(entry(number, row) for number, row in self.done.items())]
        fresh = self.file.with_suffix(".new")
        fresh.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        fresh.replace(self.file)
        self._stream: TextIO | None = None

    def __enter__(self) -> Self:
        """Open the file for more lines."""
        self._stream = self.file.open("a", encoding="utf-8")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file; what is in it stays."""
        if self._stream is not None:
            self._stream.close()

    def add(self, number: int, row: Row) -> None:
        """Write a finished case."""
        assert self._stream is not None, "a journal is written within its context"
        self._stream.write(json.dumps(entry(number, row)) + "\n")
        self._stream.flush()
        self.done[number] = row

    def _read(self) -> dict[int, Row]:
        """Give the finished cases of the same sweep."""
        lines = self.file.read_text(encoding="utf-8", errors="replace").splitlines()
        if whole(lines[0] if lines else "") != self.what:
            raise of_another(self.file.parent)
        return dict(case for case in map(finished, lines[1:]) if case is not None)


def identity(scenario: Scenario) -> dict[str, Any]:
    """Give what makes two sweeps the same: all words of the scenario, its files, and drysim."""
    words = json.dumps(scenario.resolved(), sort_keys=True)
    digest = hashlib.sha256(words.encode()).hexdigest()
    own = {"drysim": drysim.__version__, "core": source_digest()}
    return own | {"scenario": digest, "files": hashes_of(scenario)}


def of_another(folder: Path) -> UsageError:
    """Give the error for finished cases that are none of this sweep."""
    return UsageError(
        f"{folder} holds cases of another sweep, another record or another drysim",
        "run the command without --resume to begin anew",
    )


def entry(number: int, row: Row) -> dict[str, Any]:
    """Give the line of a case."""
    # Not asdict(), which copies every value of every metric one by one.
    return {"number": number, "row": vars(row) | {"over": row.over and vars(row.over)}}


def whole(line: str) -> Any:
    """Give what a line says, or None where it was cut short or is none of ours."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def finished(line: str) -> tuple[int, Row] | None:
    """Give the case of a line, or None where there is none."""
    try:
        said = whole(line)
        over = said["row"].pop("over")
        return int(said["number"]), Row(**said["row"], over=over and OverSeeds(**over))
    except (AttributeError, KeyError, TypeError, ValueError):
        return None


def _is_there(file: Path) -> bool:
    """Whether there is a journal; a device or a pipe in its place is none."""
    try:
        return regular.size(file) > 0
    except (OSError, regular.Irregular):
        return False
