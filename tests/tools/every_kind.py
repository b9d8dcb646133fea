"""A small result of each kind, computed once when it is first asked for."""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from seat import SEAT
from twin import fit_text, write_twin

import drysim
from drysim.bench import hard_cases, speed_error
from drysim.bench.timing import BenchOptions
from drysim.results import KINDS
from drysim.scenario.model import Scenario
from drysim.study.gallery import find

NOISE = "{kind: psd, points: [[1, 1], [4, 1]], duration: 9, seeds: 3}"
SWEPT = "sweep: {friction.kinetic: [5, 15], oscillator.mass: [70, 80]}\n"
DESIGN = "design: {vary: {oscillator.damping: {from: 100, to: 900}}, minimise: T_a}\n"
KNOWN = "oscillator: {mass: 75, stiffness: 7500, damping: 500}\nfriction: {law: coulomb}\n"
TRUTH = KNOWN.replace("coulomb", "coulomb, kinetic: 20")
BRANCHES = {"measure": None, "sweep": {"friction.kinetic": {"from": 10, "to": 30, "count": 5}}}
COARSE = {"sweep.friction.kinetic.count": 5, "sweep.excitation.frequency.count": 5}
CHECKS = "checks: [T_a < 9]\n"


def loaded(text: str, overrides: Any = ()) -> Scenario:
    """Return the scenario of a text."""
    with TemporaryDirectory() as folder:
        (Path(folder) / "seat.yaml").write_text(text, encoding="utf-8")
        return drysim.load(Path(folder) / "seat.yaml", overrides)


def fitted() -> Any:
    """Return the fit of a short twin."""
    with TemporaryDirectory() as folder:
        write_twin(Path(folder), TRUTH, seconds=2.0, noise={"x_dd": 0.01})
        (Path(folder) / "twin.yaml").write_text(fit_text(KNOWN, "friction.kinetic: {}"))
        return drysim.fit(drysim.load(Path(folder) / "twin.yaml"))


def timed() -> Any:
    """Return a bench of one short time history, without peers."""
    options = BenchOptions(samples=200, repeats=1, patience=0.01, peers=())
    return speed_error.time_history_bench([loaded(SEAT)], options).run(lambda: None)


def judged() -> Any:
    """Return one hard case."""
    return hard_cases.run([loaded(SEAT + CHECKS)], 30.0, lambda: None)


WAYS = {
    "run": lambda: drysim.run(loaded(SEAT + CHECKS)),
    "ensemble": lambda: drysim.run(loaded(SEAT, [f"excitation={NOISE}", "measure=null"])),
    "sweep": lambda: drysim.sweep(loaded(SEAT + SWEPT + CHECKS)),
    "comparison": lambda: drysim.compare(loaded(SEAT + SWEPT), ["signum", "stick-slip"]),
    "bench": timed,
    "hard": judged,
    "fit": fitted,
    "design": lambda: drysim.design(loaded(SEAT + DESIGN + CHECKS)),
    "branches": lambda: drysim.branches(loaded(SEAT, BRANCHES)),
    "map": lambda: drysim.map_regimes(drysim.load(find("regime-map").file, COARSE)),
}
"""How each kind of result is computed."""

assert WAYS.keys() == KINDS.keys()


@cache
def result_of(kind: str) -> Any:
    """Return the result of a kind."""
    return WAYS[kind]()


everything = partial(map, result_of, KINDS)
