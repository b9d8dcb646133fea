"""Time the orbits of the paper's Figs. 3 and 4 on one thread and on two.

    python tests/bench/many.py [--repeats 7]

Prints medians of interleaved repeats, in brackets time of the processors in all, which other
work on the machine disturbs less.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from drysim.orbits.coulomb import solve_orbits
from drysim.scenario.axes import count_points, point_columns
from drysim.scenario.load import load
from drysim.study import plan

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
    parser.add_argument("--repeats", type=int, default=7)
    figures(parser.parse_args().repeats)
