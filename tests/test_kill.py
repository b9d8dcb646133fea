"""A sweep that is killed at any instant loses no finished case and tears no file."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

SWEEP = """\
drysim: 1
name: killed
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
sweep:
  excitation.frequency: {from: 0.5, to: 10, step: 0.1}
  friction.kinetic: [5, 15, 25, 35, 45]
reference: viscous
"""

KILLS = 50
"""Processes that are killed at work."""


def command(*words: str) -> list[str]:
    """Give the words that start drysim."""
    return [sys.executable, "-m", "drysim", *words]


@pytest.mark.slow
def test_sweep_killed_at_any_instant_is_resumed_to_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "killed.yaml").write_text(SWEEP)
    words = ("sweep", "killed.yaml", "--no-plots", "--quiet")
    subprocess.run(command(*words, "--out", "whole"), cwd=tmp_path, check=True)
    whole = (tmp_path / "whole" / "transmissibility.csv").read_bytes()
    rng = np.random.Generator(np.random.PCG64(11))
    survived, number, takes = 0, 0, 60.0
    while survived < KILLS:
        number += 1
        out = f"out-{number}"
        began = time.perf_counter()
        running = subprocess.Popen(command(*words, "--out", out), cwd=tmp_path)
        with contextlib.suppress(subprocess.TimeoutExpired):
            # Where it is done before, that is how long it takes beside what else works.
            running.wait(float(rng.uniform(0.1, 1.0)) * takes)
            takes = time.perf_counter() - began
        running.send_signal(signal.SIGKILL)
        survived += running.wait() == -signal.SIGKILL
        if (tmp_path / out).exists():
            assert (tmp_path / out / "transmissibility.csv").read_bytes() == whole
        resumed = command(*words, "--out", out, "--resume")
        subprocess.run(resumed, cwd=tmp_path, check=True)
        assert (tmp_path / out / "transmissibility.csv").read_bytes() == whole
        assert not (tmp_path / f"{out}.partial").exists()
