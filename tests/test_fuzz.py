"""Damaged input by the thousand: refused in a sentence or read, never anything else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SECONDS = 5
"""What a target gets; `make fuzz` takes its time."""


def fuzzed(*words):
    """Run a campaign; give its table by target."""
    done = subprocess.run(
        [sys.executable, "-m", "fuzz", *map(str, words)],
        cwd=HERE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
    )
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    rows = [line.split("|") for line in done.stdout.splitlines() if line.startswith("|")]
    return {row[1].strip(): [int(cell) for cell in row[2:6]] for row in rows[2:]}


@pytest.mark.slow
def test_damaged_input_is_read_or_refused_and_leaves_nothing_behind():
    table = fuzzed("--seconds", SECONDS, "--inputs", 10**9, "--seed", 2)
    assert all(inputs > 50 and finds == 0 for inputs, _, _, finds in table.values())
    assert all(read > 0 and refused > 0 for _, read, refused, _ in table.values())


def test_input_of_a_campaign_can_be_had_again():
    words = ("--target", "check", "--first", 5, "--inputs", 3)
    assert fuzzed(*words) == fuzzed(*words)
