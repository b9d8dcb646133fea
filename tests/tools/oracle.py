"""The tests that a change of the core is put to: which run it, and how long they take."""

from __future__ import annotations

import ast
import math
import signal
import time
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import pytest
from coverage import Coverage

ORACLE = (
    "tests/core", "tests/independent", "tests/properties", "tests/test_approaches.py",
    "tests/test_coulomb.py", "tests/test_dynamic_friction.py", "tests/test_elastic.py",
    "tests/test_friction.py", "tests/test_leuven.py", "tests/test_normal_force.py",
    "tests/test_steady_state.py", "tests/test_stops.py",
)  # fmt: skip
OWN = {"compile": ("tests/core/test_compile.py",)}
"""For files of the core that the plain engine does not run."""

SLOW = ("minor_loop", "full_memory", "fast", "compiled", "engines_agree", "agree_bit", "twins")
"""Parts of the names of tests that take minutes in plain Python, or the compiler."""

WORDS = (
    "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "-k",
    f"not ({' or '.join(SLOW)})",
)  # fmt: skip
"""Of pytest."""

BUDGET = 30.0
"""Seconds of tests that a change is put to; a change that none of them notices survives.
All seconds here are those of the processor, so that the load of the machine decides nothing."""

LONG = 5.0
"""Seconds after which a test is broken off and left out: quicker ones fill the budget."""

PATIENCE = 5.0
"""Times what the tests take without the change, after which one that never ends is noticed."""

Known = tuple[dict[str, float], dict[str, dict[int, list[str]]]]
"""Seconds of every test; for every file of the core the tests that run each of its lines."""


def running(lines: dict[int, list[str]], source: str, row: int) -> set[str]:
    """Return the tests that run a line; those of all functions for a line that is in none."""
    functions = [
        node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)
    ]
    inner = [range(node.body[0].lineno, (node.end_lineno or 0) + 1) for node in functions]
    mine = [rows for rows in inner if row in rows] or inner
    # A statement over many lines is known by its first one: it is the function that counts.
    return {name for rows in mine for i in rows for name in lines.get(i, ()) if name}


class Lines:
    """What every test runs of the core, and how long it takes, as a plugin of pytest."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.parents[1]
        self.coverage = Coverage(data_file=None, config_file=False, source=[str(folder)])
        self.seconds: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Note the lines of a test under its name."""
        self.coverage.switch_context(item.nodeid)
        signal.signal(signal.SIGPROF, lambda *_: pytest.skip("takes long"))
        signal.setitimer(signal.ITIMER_PROF, LONG)
        began = time.process_time()
        answer = yield
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        seconds = time.process_time() - began
        self.seconds[item.nodeid] = seconds if seconds < LONG else math.inf
        return answer

    def known(self) -> Known:
        """Return the seconds of every test, and the tests of every line of every file."""
        found = self.coverage.get_data()
        files = {
            str(Path(file).relative_to(self.folder)): file for file in found.measured_files()
        }
        return self.seconds, {
            name: found.contexts_by_lineno(file) for name, file in files.items()
        }


class Choice:
    """Tests that a change is put to, the quickest of those that run its line first."""

    def __init__(self, running: set[str], seconds: dict[str, float]) -> None:
        self.seconds = seconds
        files = {name.partition("::")[0] for name in running}
        self.names = [name for name in seconds if name.partition("::")[0] in files]
        self.names.sort(key=lambda name: (name not in running, seconds[name]))
        spent = accumulate(seconds[name] for name in self.names)
        self.names = [
            name for name, so_far in zip(self.names, spent, strict=True) if so_far < BUDGET
        ]
        self.paths = sorted({name.partition("::")[0] for name in self.names})

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """End it all where a test does not come to an end."""
        signal.setitimer(signal.ITIMER_PROF, PATIENCE * (1.0 + self.seconds[item.nodeid]))
        return (yield)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what was left out without a change."""
        place = {name: i for i, name in enumerate(self.names)}
        items[:] = sorted(
            (item for item in items if item.nodeid in place),
            key=lambda item: place[item.nodeid],
        )
