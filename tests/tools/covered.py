"""What every test runs of the core as it is, and how long it takes: found once, then kept."""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Iterator
from functools import partial
from hashlib import sha256
from pathlib import Path

import pytest
from forked import forked, said
from oracle import ORACLE, WORDS, Known, Lines

HOUR = 3600
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "drysim-mutate"
"""A file there for every file of tests, by what it, its helpers and the source hold."""

UNREAD = ("mutate.py", "changes.py", "survivors.py", "covered.py", "forked.py")
"""Files beside the tests that none of them imports."""


def covered(folder: Path) -> Known:
    """Run the tests on the source as it is, where they were not before; give what they tell."""
    CACHE.mkdir(parents=True, exist_ok=True)
    seconds: dict[str, float] = {}
    every: dict[str, dict[int, list[str]]] = {}
    for tests, digest in digests(folder.parent):
        note = CACHE / digest
        if not note.exists() and not forked(folder, partial(told, folder, tests, note), HOUR):
            sys.exit(f"{said(folder).read_text()}\n{tests} fails without any change.")
        times, lines = pickle.loads(note.read_bytes())
        seconds |= times
        for file, rows in lines.items():
            for row, names in rows.items():
                every.setdefault(file, {}).setdefault(row, []).extend(names)
    return seconds, every


def digests(home: Path) -> Iterator[tuple[Path, str]]:
    """Return every file of tests, and a name for all that its answer depends on."""
    paths = [home / path for path in ORACLE]
    tests = [file for path in paths for file in sorted(path.rglob("test_*.py")) or [path]]
    beside = sorted((home / "tests").rglob("*.py"))
    beside = [file for file in beside if not file.name.startswith(("test_", *UNREAD))]
    common = sha256()
    for file in [*sorted((home / "src").rglob("*.py")), *beside]:
        common.update(file.read_bytes())
    for file in tests:
        own = common.copy()
        own.update(str(file.relative_to(home)).encode() + file.read_bytes())
        yield file.relative_to(home), own.hexdigest()


def told(folder: Path, tests: Path, note: Path) -> int:
    """Run a file of tests and note what it tells; gives 0 if none of them fails."""
    lines = Lines(folder / "drysim" / "core")
    lines.coverage.start()
    code = pytest.main([*WORDS, str(tests)], plugins=[lines])
    lines.coverage.stop()
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        return int(code)
    fresh = note.with_suffix(".new")
    fresh.write_bytes(pickle.dumps(lines.known()))
    fresh.rename(note)
    return 0
