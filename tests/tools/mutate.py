"""Change the core in one place at a time, and see whether the tests notice.

    python tests/tools/mutate.py [COUNT [FILE ...]]

COUNT changes are drawn in each file of the core (default 10), always the same; each is made in
a copy of the source and put to the tests that run its function under the plain engine, found by
coverage without any change, which is kept until the source or the tests change. They run in a
fork of a process that has loaded what they need.
What they do not notice is printed, with the counts; what nothing can notice stands with its
reason in survivors.py.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import tempfile
from functools import partial
from pathlib import Path
from random import Random

import pytest
from changes import mutants
from covered import covered
from forked import forked
from oracle import OWN, WORDS, Choice, Known, running
from survivors import EXPLAINED

HOME = Path(__file__).parents[2]
CORE = HOME / "src" / "drysim" / "core"
WAITING = 900
"""Seconds by the clock for all tests of a change: a kernel that never ends hears no alarm."""


def survivors(folder: Path, file: Path, known: Known, count: int) -> tuple[int, int, int]:
    """Try the drawn changes of a file and print those that live; how many, lived, told."""
    seconds, every = known
    copy = folder / file.relative_to(HOME / "src")
    text, lines = copy.read_text(), every.get(str(copy.relative_to(folder)), {})
    changes = list(mutants(text))
    drawn = Random(1).sample(changes, min(count, len(changes)))
    lived, told = 0, 0
    own = tests_of(file)
    for row, line, source in drawn:
        # What runs when it is imported, as the fields of a tuple, is put to all tests.
        choice = Choice(running(lines, text, row) or set(seconds), seconds)
        copy.write_text(source)
        job = partial(pytest.main, [*WORDS, *choice.paths], plugins=[choice])
        if own:
            job = partial(pytest.main, [*WORDS[:4], *own])
        if not forked(folder, job, WAITING):
            continue
        why = EXPLAINED.get((file.name, line))
        lived, told = lived + (why is None), told + (why is not None)
        print(f"{file.name}:{row}: {line}" + (f" ({why})" if why else ""), flush=True)
    copy.write_text(text)
    return len(drawn), lived, told


def tests_of(file: Path) -> tuple[str, ...]:
    """Return the tests that a file of the core has to itself, if it has."""
    return OWN.get(file.stem, ())


def main(count: int, names: list[str]) -> None:
    """Try the drawn changes of every file, and say which survive."""
    # Two changes within a second may be alike in size and time: no byte code is kept.
    sys.dont_write_bytecode = True
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    files = sorted(CORE.rglob("[a-z]*.py"))
    files = [file for file in files if not names or file.stem in names]
    without = shutil.ignore_patterns("__pycache__", "pictures")
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "src"
        for part in ("src", "tests", "scenarios"):
            shutil.copytree(HOME / part, folder.parent / part, ignore=without)
        for part in ("pyproject.toml", "README.md"):
            shutil.copy(HOME / part, home)
        known = ({}, {}) if all(map(tests_of, files)) else covered(folder)
        tried, lived, told = 0, 0, 0
        for file in files:
            of_file = survivors(folder, file, known, count)
            tried, lived, told = tried + of_file[0], lived + of_file[1], told + of_file[2]
            so_far = f"{tried} changes so far, {lived} not noticed"
            print(f"{file.name}: {so_far}, and {told} that nothing can notice", flush=True)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, sys.argv[2:])
