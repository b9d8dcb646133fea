"""The tests of drysim, and the command line as a fixture, in this process or one of its own.

`test_*.py`: one module for each module of the package, or for what users meet: bad input,
hostile files, streams, kills, the README. `core/`: the numeric core under both engines
(`kernel`). `independent/`: solutions in 50 digits and hard cases. `properties/`: laws on drawn
scenes. `fuzz/`: damaged inputs to every reader. `bench/`: `make bench` and timings. `tools/`:
what tests share, and programs: `golden.py` keeps what the gallery gives, `mutate.py` changes
the core, `proof.py` and `readme.py` write parts of the README.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pytest
from seat import SEAT, load_text, tree

from drysim.cli import main
from drysim.core.compile import COMPILED, ENGINE_VARIABLE
from drysim.scenario.model import Scenario

with pytest.MonkeyPatch.context() as patch:
    # The engine is compiled, whatever is solved first.
    patch.setenv(ENGINE_VARIABLE, os.environ.get(ENGINE_VARIABLE, COMPILED))
    importlib.import_module("drysim.core.oscillator")


class Answer(NamedTuple):
    """What a command leaves: exit code, stdout, stderr."""

    code: int
    out: str
    err: str


Command = Callable[..., Answer]


@pytest.fixture
def seat(tmp_path: Path) -> Path:
    """Write a small sound scenario into an empty folder, and work there."""
    file = tmp_path / "seat.yaml"
    file.write_text(SEAT)
    return file


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every terminal the same: no colour, 100 columns."""
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "100")


@pytest.fixture
def eighty_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every terminal as narrow as they come."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[..., Scenario]:
    """Return `load_text` in an empty folder: `scenario(text, overrides, **keys)`."""
    return partial(load_text, tmp_path)


@pytest.fixture
def drysim(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    """Return `drysim` as a function, run in this process and in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def command(*words: object) -> Answer:
        code = main([str(word) for word in words])
        return Answer(code, *capsys.readouterr())

    return command


@pytest.fixture
def command(drysim: Command) -> Command:
    """Return `drysim` under another name, for modules that import the package."""
    return drysim


@pytest.fixture
def refused(drysim: Command, tmp_path: Path) -> Callable[..., str]:
    """Return `drysim` as a function that returns the error of a command that exits with 2,
    prints no result and no traceback, and leaves every file as it was."""

    def error(*words: object) -> str:
        before = tree(tmp_path)
        answer = drysim(*words)
        assert (answer.code, answer.out) == (2, ""), answer
        assert "error: " in answer.err
        assert "Traceback" not in answer.err
        assert tree(tmp_path) == before
        return answer.err

    return error


@pytest.fixture
def process(tmp_path: Path) -> Command:
    """Return `drysim` as a function, run in a process of its own and in an empty folder."""

    def command(*words: object, **environment: str) -> Answer:
        done = subprocess.run(
            [sys.executable, "-m", "drysim", *map(str, words)],
            cwd=tmp_path,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            check=False,
        )
        return Answer(done.returncode, done.stdout, done.stderr)

    return command
