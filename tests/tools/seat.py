"""A small sound scenario, from which others are made; records to choose from; how tests say
overrides, read results and folders."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from drysim.scenario.load import load
from drysim.scenario.model import Scenario

SEAT = """\
drysim: 1
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
measure: {steady: false, settle: 0, duration: 2}
"""

EM6_SEAT = """\
oscillator: {mass: 75 kg, stiffness: 3500 N/m, damping: 250}
friction: {law: coulomb, kinetic: 20 N}
stroke: {limit: 8 mm}
excitation: {kind: standard, class: EM6, duration: 10 s, seed: 1}
solver: {step: 5 ms}
measure: {direction: vertical}
"""
"""A seat on weighted vibration, without its sweep and checks."""


def write_records(folder: Path, count: int) -> list[str]:
    """Write records of different lengths and levels into a folder; return their names."""
    folder.mkdir()
    random = np.random.default_rng(1)
    names = []
    for number in range(count):
        u_dd = np.cumsum(random.normal(size=300 + 40 * number)) * 0.1
        u_dd -= u_dd.mean()
        rows = "".join(f"{k / 100:.2f},{u:.6f}\n" for k, u in enumerate(u_dd))
        file = folder / f"run-{number:02d}.csv"
        file.write_text("t [s],u_dd [m/s2]\n" + rows)
        names.append(f"{folder.name}/{file.name}")
    return names


def seeds(few: int, many: int) -> list:
    """Return the seeds of a random draw, all but a few of them for the slow tests."""
    rest = (pytest.param(seed, marks=pytest.mark.slow) for seed in range(few, many))
    return [*range(few), *rest]


def ranges(few: int, many: int) -> list:
    """Return two ranges of seeds of a random draw, the second for the slow tests."""
    return [range(few), pytest.param(range(few, many), marks=pytest.mark.slow)]


def dotted(words: Mapping[str, object]) -> dict[str, object]:
    """Return overrides by their keys; a double underscore stands for the dot of a key."""
    return {key.replace("__", "."): value for key, value in words.items()}


def load_text(
    folder: Path, text: str = SEAT, overrides: object = (), **keys: object
) -> Scenario:
    """Return the scenario of a text, from `seat.yaml` in a folder; see `dotted` for `keys`."""
    file = folder / "seat.yaml"
    file.write_text(text, encoding="utf-8")
    return load(file, {**dict(overrides), **dotted(keys)} if keys else overrides)


def fields_of(folder: Path) -> dict[str, object]:
    """Return what `drysim.json` of a folder of results says."""
    return json.loads((Path(folder) / "drysim.json").read_text(encoding="utf-8"))


def rows_of(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file by the names of their columns."""
    return list(csv.DictReader(Path(file).read_text(encoding="utf-8").splitlines()))


def tree(folder: Path) -> dict[str, bytes]:
    """Return the content of every file below a folder by its path there."""
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }
