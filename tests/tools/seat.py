"""A small sound scenario, from which others are made; how tests say overrides, read tables."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

SEAT = """\
drysim: 1
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
measure: {steady: false, settle: 0, duration: 2}
"""


def dotted(words: Mapping[str, object]) -> dict[str, object]:
    """Return overrides by their keys; a double underscore stands for the dot of a key."""
    return {key.replace("__", "."): value for key, value in words.items()}


def rows_of(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file by the names of their columns."""
    return list(csv.DictReader(Path(file).read_text(encoding="utf-8").splitlines()))
