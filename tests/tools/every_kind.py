"""A small result of each kind, computed once when it is first asked for."""

from __future__ import annotations

import atexit
import shutil
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from seat import SEAT
from twin import fit_text, write_twin

import drysim
from drysim.bench import hard_cases, speed_error
from drysim.bench.timing import BenchOptions
from drysim.results import KINDS
from drysim.scenario.model import Scenario
from drysim.study.gallery import find

NOISE = {
    "excitation": {"kind": "psd", "points": [[1, 1], [4, 1]], "duration": 9, "seeds": 3},
    "measure": None,
}
SWEPT = "sweep: {friction.kinetic: [5, 15], oscillator.mass: [70, 80]}\n"
DESIGN = "design: {vary: {oscillator.damping: {from: 100, to: 900}}, minimise: T_a}\n"
KNOWN = "oscillator: {mass: 75, stiffness: 7500, damping: 500}\nfriction: {law: coulomb}\n"
TRUTH = KNOWN.replace("coulomb", "coulomb, kinetic: 20")
BRANCHES = {"measure": None, "sweep": {"friction.kinetic": {"from": 10, "to": 30, "count": 5}}}
COARSE = {"sweep.friction.kinetic.count": 5, "sweep.excitation.frequency.count": 5}
CHECKS = "checks: [T_a < 9]\n"


def twin() -> Scenario:
    """Return the scenario of a fit to a short twin."""
    return drysim.load(twin_file())


@cache
def twin_file() -> Path:
    """Return the file of that scenario, beside its records."""
    folder = Path(mkdtemp())
    atexit.register(shutil.rmtree, folder)
    write_twin(folder, TRUTH, seconds=2.0, noise={"x_dd": 0.01})
    (folder / "twin.yaml").write_text(fit_text(KNOWN, "friction.kinetic: {}"))
    return folder / "twin.yaml"


def assessed() -> Scenario:
    """Return the scenario of an assessment of the same twin, beside its model."""
    measured = {"file": "run.csv", "time": "t", "x_dd": "x_dd", "x_r": "x_r"}
    overrides = {
        "fit": None,
        "friction.kinetic": 20,
        "assess": {"measured": measured},
        "checks": ["T_a < 9"],
    }
    return drysim.load(twin_file(), overrides)


def timed() -> Any:
    """Return a bench of one short time history, without peers."""
    options = BenchOptions(samples=200, repeats=1, patience=0.01, peers=())
    return speed_error.time_history_bench([drysim.scenario(SEAT)], options).run(lambda: None)


def judged() -> Any:
    """Return one hard case."""
    return hard_cases.run([drysim.scenario(SEAT + CHECKS)], 30.0, lambda: None)


WAYS = {
    "run": lambda: drysim.run(drysim.scenario(SEAT + CHECKS)),
    "ensemble": lambda: drysim.run(drysim.scenario(SEAT + CHECKS, NOISE)),
    "sweep": lambda: drysim.sweep(drysim.scenario(SEAT + SWEPT + CHECKS)),
    "comparison": lambda: drysim.compare(
        drysim.scenario(SEAT + SWEPT + CHECKS), "signum", "stick-slip"
    ),
    "bench": timed,
    "hard": judged,
    "fit": lambda: drysim.fit(twin()),
    "assess": lambda: drysim.assess(assessed()),
    "design": lambda: drysim.design(drysim.scenario(SEAT + DESIGN + CHECKS)),
    "branches": lambda: drysim.branches(drysim.scenario(SEAT + CHECKS, BRANCHES)),
    "map": lambda: drysim.map_regimes(drysim.load(find("regime-map").file, COARSE)),
}
"""How each kind of result is computed."""

assert WAYS.keys() == KINDS.keys()


@cache
def result_of(kind: str) -> Any:
    """Return the result of a kind."""
    return WAYS[kind]()
