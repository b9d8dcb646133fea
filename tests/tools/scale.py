"""What a case of a large sweep costs, in threads and on a cluster: `make scale` prints it.

The manual's plan for 1e6, 1e9 and 1e12 cases stands on these figures.
"""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from pathlib import Path

from drysim.results.sweep import write_transmissibility_csv, write_transmissibility_parquet
from drysim.scenario.load import load
from drysim.study.cluster import connect
from drysim.study.plan import CaseRanges, Plan, approaches_of, range_length
from drysim.study.preparation import prepare
from drysim.study.store import Store, pack, work_identity
from drysim.study.sweep import on_cluster, solve

SWEEP = """\
drysim: 1
name: large
oscillator: {{mass: 75, stiffness: 7500, damping: 500}}
friction: {{law: coulomb, kinetic: 15}}
stroke: {{limit: 25 mm}}
excitation: {{kind: harmonic, frequency: 1.6, rms: 1.0}}
solver: {{approach: stick-slip, step: 2.5e-3}}
sweep:
  excitation.frequency: {{from: 0.5, to: 10, count: {count}}}
  friction.kinetic: {{from: 1, to: 45, count: {forces}}}
"""

SMALL, MIDDLE, LARGE = (50, 20), (1000, 200), (1000, 1000)
"""Values of the two keys: the same range of scenes by 1,000, 200,000 and 1,000,000 cases."""

REPEATS, PAIRS = 15, 2
"""Times that 1,000 cases are computed before and after 1,000,000; and that threads and workers
compute these in turn."""


class Clock:
    """Wall time, processor time of this process, and that of its main thread [s]."""

    def __init__(self) -> None:
        self._began = self._now()

    @staticmethod
    def _now() -> tuple[float, float, float]:
        return time.perf_counter(), time.process_time(), time.thread_time()

    def read(self) -> tuple[float, float, float]:
        """Return what has passed."""
        wall, cpu, main = (b - a for a, b in zip(self._began, self._now(), strict=True))
        return wall, cpu, main


class Bench:
    """A sweep of so many cases in a folder of its own."""

    def __init__(self, folder: Path, sizes: tuple[int, int]) -> None:
        count, forces = sizes
        file = folder / "large.yaml"
        file.write_text(SWEEP.format(count=count, forces=forces))
        self.folder, self.cases = folder, count * forces
        self.case = prepare(load(file))

    def store(self) -> Store:
        """Return an empty store."""
        return Store(self.folder / "cases", work_identity(self.case.scenario), resume=False)

    def threads(self, workers: int) -> tuple[float, float, float]:
        """Compute it by threads."""
        store, clock = self.store(), Clock()
        solve(self.case, workers=workers, store=store)
        return clock.read()


def main(words: list[str]) -> None:
    """Measure what is asked for, everything by default."""
    asked = words or ["bytes", "threads", "cluster"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        Bench(folder, MIDDLE).threads(2)  # compiles, where nobody has yet
        for word in asked:
            globals()[f"of_{word}"](folder)


def of_bytes(folder: Path) -> None:
    """Print what a case takes on the disk and on the way."""
    bench = Bench(folder, LARGE)
    plan = Plan(CaseRanges(approaches_of(bench.case.scenario)))
    case_range, batch = plan.ranges[100], plan.block(100)
    print(f"bytes a case, packed: {len(pack(batch, bench.store().sweep)) / len(batch):.0f}")
    table = solve(Bench(folder, MIDDLE).case)
    for name, write in (
        ("csv", write_transmissibility_csv),
        ("parquet", write_transmissibility_parquet),
    ):
        write(table, folder / "transmissibility.csv" if name == "csv" else folder)
        files = [file for file in folder.rglob(f"*.{name}") if file.is_file()]
        size = sum(file.stat().st_size for file in files)
        clock = Clock()
        write(table, folder / "transmissibility.csv" if name == "csv" else folder)
        takes = 1e6 * clock.read()[0] / len(table)
        print(f"bytes a case, {name}: {size / len(table):.0f}, written in {takes:.1f} µs")
    size = case_range.end - case_range.begin
    print(f"cases per block: {size}, of 1e9 {range_length(10**9, True)}")


def of_threads(folder: Path) -> None:
    """Print cases a second a core of few cases and of many, side by side."""
    small, large = Bench(folder, SMALL), Bench(folder, LARGE)
    before = [small.threads(1) for _ in range(REPEATS)]
    many = large.threads(2)
    after = [small.threads(1) for _ in range(REPEATS)]
    cpu = statistics.median(one[1] for one in before + after)
    print(f"1,000 cases, a thread: {small.cases / cpu:.0f} a second of processor time")
    print(
        f"1,000,000 cases, two threads: {large.cases / many[1]:.0f} a second of processor time"
    )
    print(f"wall {many[0]:.1f} s, {large.cases / many[0]:.0f} cases a second")
    print(f"main thread (told, kept): {1e6 * many[2] / large.cases:.2f} µs a case")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(f"memory at most: {most:.0f} MB")


def of_cluster(folder: Path) -> None:
    """Print the same of two worker processes, side by side with two threads."""
    large, walls = Bench(folder, LARGE), []
    with connect("local", 2, print, print) as link:
        warm = Bench(folder, MIDDLE)
        solve(warm.case, execute=on_cluster(link), store=warm.store())
        for _ in range(PAIRS):
            near = large.threads(2)
            busy = sum(link.client.run(time.process_time).values())
            store, clock = large.store(), Clock()
            solve(large.case, execute=on_cluster(link), store=store)
            wall, cpu, main = clock.read()
            busy = sum(link.client.run(time.process_time).values()) - busy
            walls.append((wall, near[0], wall / near[0], (busy + cpu) / near[1]))
    wall, of_threads, ratio, work = (statistics.median(one) for one in zip(*walls, strict=True))
    blocks = len(CaseRanges(approaches_of(large.case.scenario)))
    print(f"two workers: wall {wall:.1f} s, {large.cases / wall:.0f} cases a second")
    print(
        f"two threads beside them: wall {of_threads:.1f} s; workers take {ratio:.2f} times it"
    )
    print(f"processor time of all, over that of two threads: {work:.2f}")
    print(f"workers: {large.cases / busy:.0f} a second of their processor time")
    print(f"with the client: {large.cases / (busy + cpu):.0f} a second of processor time")
    print(f"client, main thread: {1e6 * main / large.cases:.2f} µs a case")
    print(f"scheduler and transport: {1e3 * (cpu - main) / blocks:.1f} ms a block")


if __name__ == "__main__":
    main(sys.argv[1:])
