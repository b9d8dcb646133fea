"""Records that are hard: with holes, with jitter, and of a hundred million samples."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import pytest

import drysim
from drysim.errors import RecordError

RECORD = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: shaken.csv, time: t, column: u_dd}
"""


@pytest.fixture
def recorded(tmp_path):
    """Return a scene on a record of a sine, in which one row may be another."""

    def scene(row=None, text="", late=0.0):
        rows = [f"{0.01 * n + late * (n % 2):.8f},{math.sin(0.1 * n):.6f}" for n in range(200)]
        if row is not None:
            rows[row] = text
        (tmp_path / "shaken.csv").write_text("t [s],u_dd [m/s2]\n" + "\n".join(rows) + "\n")
        (tmp_path / "shaken.yaml").write_text(f"drysim: 1\nname: shaken\n{RECORD}")
        return drysim.run(drysim.load(tmp_path / "shaken.yaml"))

    return scene


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1.00000000,nan", "row 102, column 2"),
        ("1.00000000,", "the record has a gap"),
        ("", "row 102 is empty: the record has a gap"),
        ("1.00500000,0.5", "uneven"),
        ("0.99000000,0.5", "time repeats"),
    ],
)
def test_record_with_a_hole_is_refused_and_the_row_named(recorded, text, words):
    with pytest.raises(RecordError) as refused:
        recorded(100, text)
    assert words in str(refused.value)
    assert "102" in str(refused.value) or "103" in str(refused.value)


def test_jitter_far_below_a_step_is_taken_for_the_rounding_that_it_is(recorded):
    even, jittery = recorded(), recorded(late=5e-6)
    assert jittery.metrics["a_x"] == pytest.approx(even.metrics["a_x"], rel=1e-3)


def test_jitter_of_a_tenth_of_a_step_is_refused(recorded):
    with pytest.raises(RecordError, match="the time steps are uneven"):
        recorded(late=1e-3)


@pytest.mark.slow
@pytest.mark.by_hand
def test_record_of_a_hundred_million_samples_is_solved_in_bounded_memory(tmp_path):
    # 250,000 s at 400 Hz, drawn and not stored; a process of its own tells its memory.
    (tmp_path / "long.yaml").write_text(
        "drysim: 1\nname: long\noscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
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
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    assert found["steps"] == 100_000_000
    assert found["energy_residual"] < 1e-9
    assert 0.0 < found["stuck_share"] < 1.0
    assert found["memory"] < 8_000_000  # kilobytes
