"""Speed of every entry of `drysim bench`, by pytest-benchmark: `make entries` runs this file.

Not to be confused with a test: nothing here fails, and `make test` does not collect it. Saved
runs are compared by `--benchmark-autosave` and `--benchmark-compare`.
"""

from __future__ import annotations

import peers
import pytest

from drysim.bench import scipy_ivp, score, speed_error
from drysim.bench.score import Reference
from drysim.bench.speed_error import score_answer
from drysim.bench.timing import ReadyEntry, lfilter_job
from drysim.bench.work import make_work
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine

SAMPLES = 4_000
"""Samples of the work: the slowest entry takes some seconds on them."""

choose_engine(MAX_PLAIN_STEPS + 1)
WORKS = [make_work(one, SAMPLES) for one in speed_error.load_scenarios(None, [], swept=False)]
CASES = [
    pytest.param(work, entry, id=f"{work.scenario.name}-{entry.approach}-{entry.setting}")
    for work in WORKS
    for shelf in (score, scipy_ivp, *peers.installed_peers())
    for entry in shelf.entries(work)
    if entry.points <= 20
]


@pytest.mark.parametrize("work", WORKS, ids=lambda work: work.scenario.name)
def test_lfilter(work, benchmark):
    benchmark.group = work.scenario.name
    benchmark(lfilter_job(work))


@pytest.mark.parametrize(("work", "entry"), CASES)
def test_entry(work, entry, benchmark):
    benchmark.group = work.scenario.name
    run = entry.ready(work)
    answer = benchmark(run)
    score = score_answer(entry, ReadyEntry(work, run, answer, 0.0), Reference.of(work))
    benchmark.extra_info |= {"verdict": score.verdict, "error_x_r": score.error_x_r}
