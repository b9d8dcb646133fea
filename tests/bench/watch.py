"""Instructions of a few fixed jobs per sample and per case: `make bench` says what changed.

    python tests/bench/watch.py [--store]

Each job runs in two sizes, whose difference contains neither start-up nor compiling. Callgrind
(valgrind) counts the instructions, which are the same whatever else the machine does. Without
it the job is timed beside scipy's lfilter: processor time as a multiple of that of a sample.

`watch.json` has the last stored counts of each kind, with their revision and versions. What
differs from them by more than 2 % is named; nothing is judged.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

STORE = Path(__file__).with_name("watch.json")

CHANGE = 0.02
"""Relative change that is named."""

REPEATS = 9
"""Repeats of timed jobs, all in turn."""

FILTERED = 1_000_000
"""Samples that lfilter is timed on."""

PLANT = "drysim: 1\nname: watch\noscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
COULOMB = "friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}\n"
LUGRE = (
    "friction: {law: lugre, kinetic: 45, static_ratio: 1.2, stribeck_velocity: 5 mm/s, "
    "bristle_stiffness: 100 kN/m, bristle_damping: 300}\n"
)
BUMPERS = "stroke: {limit: 10 mm, stops: {stiffness: 200 kN/m, damping: 300}}\n"
SINE = "excitation: {kind: harmonic, frequency: 1.6, rms: 1.5}\nsolver: {step: 2.5e-3}\n"
TRANSIENT = "measure: {steady: false, settle: 0, duration: {{time}}}\n"
SEEDS = (
    "excitation: {kind: standard, class: EM3, duration: 60 s, seed: 1, seeds: {{count}}}\n"
    "solver: {step: 2.5e-3}\nmeasure: {settle: 5 s}\n"
)
SWEEP = (
    "sweep:\n  excitation.frequency: {from: 0.5, to: 10, count: {{tenth}}}\n"
    "  friction.kinetic: {from: 5, to: 45, count: 10}\n"
)


class Job(NamedTuple):
    """What is counted: a function of the number of samples or cases, two numbers, a unit."""

    run: Callable[[int], object]
    small: int
    large: int
    unit: str


def scenario_job(words: str, command: str, small: int, large: int, unit: str) -> Job:
    """Return the job of a command on a scenario, in which {{count}} and {{time}} are set."""
    import drysim

    def run(count: int) -> object:
        with tempfile.TemporaryDirectory() as folder:
            values = {"count": count, "tenth": count // 10, "time": count * 2.5e-3}
            text = PLANT + words
            for name, value in values.items():
                text = text.replace(f"{{{{{name}}}}}", str(value))
            file = Path(folder, "watch.yaml")
            file.write_text(text, encoding="utf-8")
            return getattr(drysim, command)(drysim.load(file), workers=1)

    return Job(run, small, large, unit)


def jobs() -> dict[str, Job]:
    """Return the jobs: the kernels, and the Python around them."""
    import drysim
    from drysim.approach.sensitivity import linearise
    from drysim.core.variational import DAMPER, KINETIC, NUMBERS, SPRING, UP

    rates = np.eye(NUMBERS)[:, (SPRING, UP + KINETIC, UP + DAMPER)]
    noise = np.convolve(np.random.default_rng(1).normal(size=70_000), np.ones(20), "same")

    def march(count: int) -> Any:
        u_dd = noise[:count]
        return drysim.simulate(m=75, k_x=7500, b=500, F_fk=45, F_fs=54, u_dd=u_dd, dt=2.5e-3)

    def sensitivities(count: int) -> object:
        return linearise(march(count), rates)

    return {
        "march with Coulomb friction": Job(march, 20_000, 60_000, "sample"),
        "march with sensitivities": Job(sensitivities, 5_000, 15_000, "sample"),
        "run with bumpers": scenario_job(
            COULOMB + BUMPERS + SINE + TRANSIENT, "run", 8_000, 24_000, "sample"
        ),
        "run with LuGre friction": scenario_job(
            LUGRE + SINE + TRANSIENT, "run", 800, 2_400, "sample"
        ),
        "seeds of a random signal": scenario_job(COULOMB + SEEDS, "run", 20, 60, "seed"),
        "sweep of orbits": scenario_job(COULOMB + SINE + SWEEP, "sweep", 500, 1_500, "case"),
    }


# Counting


def mark() -> None:
    """Mark the end of what is counted: callgrind dumps its counts at this function of libc."""
    os.getloadavg()


def run_marked() -> None:
    """Run each job in both sizes between marks, after a first time that compiles."""
    for job in jobs().values():
        job.run(job.small)
        mark()
        for count in (job.small, job.large):
            job.run(count)
            mark()


def count_instructions() -> dict[str, float]:
    """Return the instructions of each job per sample or case, by callgrind."""
    # The same code on each processor, and in each process.
    fixed = {"NUMBA_CPU_NAME": "generic", "DRYSIM_ENGINE": "compiled", "PYTHONHASHSEED": "0"}
    fixed["OPENBLAS_NUM_THREADS"] = "1"
    command = [sys.executable, __file__, "--marked"]
    subprocess.run(command, env=os.environ | fixed, check=True)  # fills the cache of kernels
    with tempfile.TemporaryDirectory() as folder:
        tool = ["valgrind", "--tool=callgrind", "--dump-before=getloadavg", "--quiet"]
        tool.append(f"--callgrind-out-file={folder}/counts")
        subprocess.run([*tool, *command], env=os.environ | fixed, check=True)
        files = sorted(Path(folder).glob("counts.*"), key=lambda file: int(file.suffix[1:]))
        totals = [read_total(file.read_text(encoding="utf-8")) for file in files]
    works = jobs()
    assert len(totals) == 3 * len(works), "a mark is missing"
    return {
        name: (totals[3 * i + 2] - totals[3 * i + 1]) / (job.large - job.small)
        for i, (name, job) in enumerate(works.items())
    }


def read_total(dump: str) -> int:
    """Return the instructions of a dump of callgrind."""
    (total,) = (line for line in dump.splitlines() if line.startswith("totals:"))
    return int(total.split()[1])


def count_time() -> dict[str, float]:
    """Return the processor time of each job per sample or case, in samples of lfilter."""
    from scipy.signal import lfilter

    works, noise = jobs(), np.random.default_rng(1).normal(size=FILTERED)
    tasks: dict[tuple[str, int], Callable[[], object]] = {
        ("", 0): lambda: lfilter([1.0, 0.5, 0.2], [1.0, -1.8, 0.9], noise)
    }
    for name, job in works.items():
        for count in (job.small, job.large):
            tasks[name, count] = lambda job=job, count=count: job.run(count)
    times: dict[tuple[str, int], list[float]] = {key: [] for key in tasks}
    for turn in range(REPEATS + 1):
        for key, task in tasks.items():
            began = time.process_time()
            task()
            if turn:  # the first compiles
                times[key].append(time.process_time() - began)
    filtered = median(times["", 0]) / FILTERED
    return {
        name: (median(times[name, job.large]) - median(times[name, job.small]))
        / ((job.large - job.small) * filtered)
        for name, job in works.items()
    }


# What changed


def format_count(value: float) -> str:
    """Return a count to four digits, or whole."""
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.4g}"


def compare(stored: Mapping[str, float], now: Mapping[str, float]) -> list[str]:
    """Return what changed, a sentence for each job that did."""
    lines = []
    for name in sorted(stored.keys() | now.keys()):
        if name not in now or name not in stored:
            lines.append(f"{name}: {'new' if name in now else 'no longer counted'}")
        elif abs(now[name] - stored[name]) > CHANGE * stored[name]:
            percent = 100.0 * (now[name] / stored[name] - 1.0)
            ends = f"from {format_count(stored[name])} to {format_count(now[name])}"
            lines.append(f"{name}: {percent:+.1f} %, {ends}")
    return lines


def revision() -> str:
    """Return the commit that is counted."""
    command = ["git", "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty"]
    found = subprocess.run(command, capture_output=True, text=True, cwd=STORE.parent)
    return found.stdout.strip() or "unknown"


def main() -> None:
    """Count the jobs, print the counts and what changed, and store them if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--store", action="store_true", help="keep these counts to compare with"
    )
    parser.add_argument("--marked", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.marked:
        run_marked()
        return
    counted, counted_revision = shutil.which("valgrind") is not None, revision()
    os.environ.setdefault("DRYSIM_ENGINE", "compiled")
    now = count_instructions() if counted else count_time()
    what = "instructions" if counted else "samples of lfilter"
    kind = f"{what}, {platform.machine()}"
    for name, job in jobs().items():
        print(f"{name:30} {format_count(now[name]):>12} {what} a {job.unit}")
    stores = json.loads(STORE.read_text(encoding="utf-8")) if STORE.exists() else {}
    versions = {name: version(name) for name in ("numpy", "scipy", "numba")}
    versions["python"] = platform.python_version()
    if last := stores.get(kind):
        changed = compare(last["counts"], now)
        print(f"since {last['revision']}: " + ("" if changed else "no change above 2 %"))
        print(*(f"  {line}" for line in changed), sep="\n", end="")
        other = {k: v for k, v in versions.items() if v != last["versions"].get(k)}
        if other:
            print(f"other versions than then: {other}")
    if options.store or not last:
        counts = {name: float(f"{value:.5g}") for name, value in now.items()}
        stores[kind] = {"revision": counted_revision, "versions": versions, "counts": counts}
        STORE.write_text(json.dumps(stores, indent=2) + "\n", encoding="utf-8")
        print(f"stored in {STORE}")


if __name__ == "__main__":
    main()
