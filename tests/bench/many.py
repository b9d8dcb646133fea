"""Time seeds measured side by side and the orbits of the paper's Figs. 3 and 4 beside lfilter.

    python tests/bench/many.py [--records 1000] [--samples 24000] [--repeats 7]

Prints nanoseconds a sample, medians of interleaved repeats. lfilter runs on one core; the
ratio that counts is that of two threads to it. In brackets time of the processors in all,
which other work on the machine disturbs less.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from drysim.approach.coulomb import solve_orbits
from drysim.approach.many_records import RecordBatch, make_batch, measure_batch
from drysim.core.model import CoulombLaw, Plant, Samples, State
from drysim.excitation.random import random_signal, spectral_lines
from drysim.scenario.axes import count_points, point_columns
from drysim.scenario.load import load
from drysim.study import plan
from drysim.study.ensemble import MAX_SEEDS_PER_BLOCK

DT = 2.5e-3
PLANT, REST = Plant(75.0, 7500.0, 500.0), State(0.0, 0.0)
FRICTION = ((0.0, 0.0), (15.0, 15.0), (45.0, 45.0), (45.0, 54.0), (80.0, 96.0))
FIGURES = Path(__file__).parents[2] / "scenarios"


def medians(
    jobs: dict[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Return the median time of every job [s], all of them in turn."""
    times: dict[str, list[float]] = {name: [] for name in jobs}
    for turn in range(repeats + 1):
        for name, job in jobs.items():
            began = clock()
            job()
            if turn:  # the first compiles
                times[name].append(clock() - began)
    return {name: statistics.median(each) for name, each in times.items()}


def ensembles(records: int, samples: int, repeats: int) -> None:
    """Time records in blocks, on one thread and on two."""
    wanted = spectral_lines(lambda f: np.ones_like(f), (0.5, 10.0), 0.67**2, samples * DT)
    motions = [random_signal(wanted, DT, seed, 0.67) for seed in range(records)]
    bare = [Samples(motion.u_dd, DT) for motion in motions]
    parts = [
        bare[at : at + MAX_SEEDS_PER_BLOCK] for at in range(0, records, MAX_SEEDS_PER_BLOCK)
    ]
    blocks = [make_batch(part, len(part), (0, samples)) for part in parts]
    from scipy.signal import lfilter

    hands, work = ThreadPoolExecutor(2), records * samples * 1e-9
    for F in FRICTION:

        def block(given: RecordBatch, F: tuple[float, float] = F) -> object:
            return measure_batch(PLANT, CoulombLaw(*F), given, REST)

        jobs = {
            "one": lambda block=block: [*map(block, blocks)],
            "two": lambda block=block: [*hands.map(block, blocks)],
            "lfilter": lambda: [
                lfilter([1.0, 0.5, 0.2], [1.0, -1.8, 0.9], motion.u_dd) for motion in bare
            ],
        }
        wall, spent = medians(jobs, repeats), medians(jobs, repeats, time.process_time)
        one, two, linear = (
            f"{wall[name] / work:.2f} ({spent[name] / work:.2f})" for name in jobs
        )
        print(
            f"F_fk {F[0]:.0f} F_fs {F[1]:.0f} N, ns a sample: one thread {one}, two {two}, "
            f"lfilter {linear}; ratio of two {wall['two'] / wall['lfilter']:.2f}"
        )


def figures(repeats: int) -> None:
    """Time the cases of Figs. 3 and 4 with reference: the kernels alone."""
    files = [FIGURES / f"paper-{name}-friction.yaml" for name in ("low", "high")]
    asked = [load(file) for file in files]
    curve = len(asked[0].sweep[0].values)
    parts = [(each, count_points(each.sweep)) for each in asked]
    parts.append((asked[0].with_approach("viscous"), curve))  # one curve serves both figures
    scenes = []
    for scenario, count in parts:
        found, _ = plan.scene_array(scenario, point_columns(scenario.sweep, 0, count), count)
        scenes += [found[: count // 2], found[count // 2 :]]
    hands = ThreadPoolExecutor(2)
    cases = sum(map(len, scenes))
    jobs = {
        "one": lambda: [*map(solve_orbits, scenes)],
        "two": lambda: [*hands.map(solve_orbits, scenes)],
    }
    wall, work = medians(jobs, repeats), medians(jobs, repeats, time.process_time)
    print(
        f"Figs. 3 and 4, {cases} cases: one thread {1e3 * wall['one']:.1f} ms "
        f"({1e3 * work['one']:.1f}), two {1e3 * wall['two']:.1f} ms ({1e3 * work['two']:.1f})"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for option, value in (("--records", 1_000), ("--samples", 24_000), ("--repeats", 7)):
        parser.add_argument(option, type=int, default=value)
    options = parser.parse_args()
    figures(options.repeats)
    ensembles(options.records, options.samples, options.repeats)
