"""Records that are hard: with jitter, and of a hundred million samples."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import pytest
from seat import SEAT

import drysim


def test_jitter_far_below_a_step_is_taken_for_the_rounding_that_it_is(tmp_path):
    base = {"kind": "record", "file": str(tmp_path / "shaken.csv"), "time": "t"}
    changes = {"excitation": base, "solver": None, "measure": None}

    def metrics(late):
        rows = [f"{0.01 * n + late * (n % 2):.8f},{math.sin(0.1 * n):.6f}" for n in range(200)]
        (tmp_path / "shaken.csv").write_text("t [s],u_dd [m/s2]\n" + "\n".join(rows) + "\n")
        return drysim.run(drysim.scenario(SEAT, changes)).metrics

    assert metrics(5e-6)["a_x"] == pytest.approx(metrics(0.0)["a_x"], rel=1e-3)


@pytest.mark.slow
@pytest.mark.by_hand
def test_record_of_a_hundred_million_samples_is_solved_in_bounded_memory(tmp_path):
    # 250,000 s at 400 Hz, drawn and not stored; a process of its own tells its memory.
    (tmp_path / "long.yaml").write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        "friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}\nsolver: {step: 2.5e-3}\n"
        "excitation: {kind: psd, points: [[0.5 Hz, 1], [10 Hz, 1]], rms: 0.67, "
        "duration: 250000 s, seed: 1}\n"
    )
    program = (
        "import drysim, json, resource; o = drysim.run(drysim.load('long.yaml'));"
        "m = dict(o.metrics); m['steps'] = o.response.numerics.steps;"
        "m['memory'] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss; print(json.dumps(m))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found = json.loads(done.stdout)
    assert found["steps"] == 100_000_000
    assert found["energy_residual"] < 1e-9
    assert 0.0 < found["stuck_share"] < 1.0
    assert found["memory"] < 8_000_000  # kilobytes
