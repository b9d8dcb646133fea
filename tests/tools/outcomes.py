"""Outcomes to be reported: small real responses with a stand-in for their scenario."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Input, Plant, Samples, Sines, State, StrokeLimits
from drysim.errors import WarningMessage
from drysim.excitation.harmonic import Harmonic, Rest
from drysim.excitation.random import Psd
from drysim.excitation.recorded import Record
from drysim.metrics.checks import Check
from drysim.metrics.table import measure
from drysim.scenario.blocks import Stroke
from drysim.study.outcome import Outcome

PAPER = Plant(75.0, 7500.0, 500.0)
SINE = Sines((1.5,), (1.6,), (0.0,))
STICKY = CoulombLaw(45.0, 54.0)


DESCRIBED = {
    "harmonic": Harmonic(kind="harmonic", frequency=1.6, amplitude=1.5),
    "psd": Psd(kind="psd", points=[[1, 1], [8, 1]], duration=10.0, seed=1),
    "record": Record(kind="record", file="road.csv"),
    "rest": Rest(kind="rest"),
}
"""Excitations that describe the base motion of a stand-in."""


def noise(n, rms=1.0):
    """Return smooth base acceleration [m/s²] of a fixed seed."""
    rough = np.random.Generator(np.random.PCG64(1)).standard_normal(n + 40)
    smooth = np.convolve(rough, np.hanning(41), "valid")
    return smooth * (rms / np.sqrt(np.mean(smooth**2)))


def record(n, rms=1.0):
    """Return a base motion that came from a file."""
    return Samples(noise(n, rms), 2.5e-3, inputs=(Input("road.csv", "ab" * 32, 1234),))


def limits_of(limit):
    """Return the same limit on both sides; None for none."""
    return None if limit is None else StrokeLimits(limit, limit)


def stand_in(kind, limit=None, law=STICKY, **words):
    """Return what reports ask of a scenario; further words replace or add attributes."""
    usual = {
        "name": "seat",
        "about": "A seat on its suspension.",
        "oscillator": SimpleNamespace(plant=lambda: PAPER),
        "law": lambda: law,
        "stops": None,
        "stroke": None if limit is None else Stroke(limit=limit),
        "has_sides": False,
        "checks": (),
        "sweep": (),
        "excitation": SimpleNamespace(
            kind=kind,
            periodic=False,
            has_own_end=False,
            frequencies=(),
            describe=DESCRIBED[kind].describe,
            describe_cases=DESCRIBED[kind].describe_cases,
        ),
        "friction": SimpleNamespace(static_given=False),
        "static_given": False,
        "terms": (),
        "ratios": {},
        "solver": SimpleNamespace(step=2.5e-3, approach="stick-slip"),
        "measure": SimpleNamespace(settle=0.0, duration=None, steady=True, weights=None),
        "origin": {"file": "seat.yaml", "sha256": "cd" * 32, "overrides": {}},
        "resolved": lambda relative_to: {"drysim": 1, "name": "seat"},
    }
    return SimpleNamespace(**usual | words)


def outcome(
    law=STICKY,
    motion=SINE,
    duration=1.0,
    limit=None,
    start=State(0.0, 0.0),  # noqa: B008
    checks=(),
    warnings=(),
    **scenario,
):
    """Return an outcome; further words become attributes of the scenario."""
    response = StickSlip().solve(PAPER, law, motion, start, 2.5e-3, duration)
    window = (0.0, (len(response.x_r) - 1) * response.dt)
    metrics = measure(response.trajectory, window, limits_of(limit))
    kind = "record" if isinstance(motion, Samples) else "harmonic" if motion.A else "rest"
    words = stand_in(kind, limit, law, **scenario)
    verdicts = tuple(Check.parse(text).judge(metrics) for text in checks)
    cautions = tuple(WarningMessage("slug", sentence) for sentence in warnings)
    return Outcome(words, response, metrics, verdicts, cautions)


def judgement(check, rows):
    """Return the verdict of a check on the cases of a sweep, as pairs of point and metrics."""
    points, metrics = zip(*rows, strict=True)
    keys = {one.key for one in check.conditions}
    here = {key: column([point.get(key) for point in points]) for key in keys}
    judged = check.applicable(here, len(points))
    at = check.worst(judged, column([one.get(check.metric) for one in metrics]))
    if at is None:
        return check.no_case_verdict()
    return check.verdict(metrics[at].get(check.metric), points[at])


def column(values):
    """Return values as an array, NaN for not known."""
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def names(folder):
    """Return the names of the files in a folder."""
    return sorted(path.name for path in Path(folder).iterdir())
