"""Blocks on the disk that something has spoiled: unfinished, or refused in a sentence."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from seat import SEAT, load_text

from drysim.console import terminal
from drysim.errors import OutputError, UsageError
from drysim.study import sweep
from drysim.study.plan import CaseRange, CaseRanges, Plan, approaches_of, solve_range
from drysim.study.run import MotionCache
from drysim.study.store import IDENTITY_FILE, Store, StoredBatches, is_resumable, work_identity
from fuzz.mutate import damaged

SWEEP = "sweep: {friction.kinetic: [10, 20, 30, 40, 50]}\n"
STEADY = SEAT.replace("measure: {steady: false, settle: 0, duration: 2}\n", "") + SWEEP


@pytest.fixture
def kept(tmp_path: Path) -> tuple[Store, CaseRange, Path]:
    """Keep one block; give its store, its piece and its file."""
    scenario = load_text(tmp_path, STEADY)
    store = Store(tmp_path / "cases", work_identity(scenario), resume=False)
    (case_range,) = CaseRanges(approaches_of(scenario))
    store.write(case_range, solve_range(case_range, MotionCache()))
    return store, case_range, store.file(case_range)


def interrupted_after(monkeypatch: Any, blocks: int) -> None:
    """Interrupt a sweep after a number of finished blocks."""
    left = [blocks]

    def advance(n: int) -> None:
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(terminal, "progress", lambda *_: nullcontext(advance))


def resumed(store: Store) -> Store:
    """Return the same store as the next process finds it."""
    return Store(
        store.folder, json.loads((store.folder / IDENTITY_FILE).read_text()), resume=True
    )


def test_damaged_block_is_unfinished_or_reads_the_same(kept):
    """Some bytes of an archive do not matter, such as a date."""
    store, case_range, file = kept
    sound, read, refused = file.read_bytes(), list(store.read(case_range) or ()), 0
    assert len(read) == 5
    for number in range(3000):
        file.write_bytes(damaged([sound], random.Random(number)))
        found = store.read(case_range)
        assert found is None or list(found) == read
        refused += found is None
    assert refused > 2500


def test_blocks_are_kept_as_they_come_and_yielded_in_order(tmp_path, monkeypatch):
    """Few early ones wait in memory, an invalid one is solved again when it is due."""
    scenario = load_text(tmp_path, SEAT + SWEEP)
    plan = Plan(CaseRanges(approaches_of(scenario)))
    monkeypatch.setattr(sweep, "MAX_EARLY", 2)
    asked: list[list[int]] = []

    def backwards(numbers: Sequence[int], interrupted: bool) -> Any:
        asked.append([*numbers])
        for number in reversed(numbers):
            if interrupted and number == 1:
                raise KeyboardInterrupt
            yield number, None if number == 3 else plan.block(number)

    def solved(store: Store | None, interrupted: bool = False) -> list[tuple[int, list[Any]]]:
        solve_all = partial(backwards, interrupted=interrupted)
        work = sweep.solve_ranges(plan.ranges, plan.block, solve_all, store, first.append)
        return [(case_range.first, list(batch)) for case_range, batch in work]

    first: list[Any] = []
    whole = [(number, list(plan.block(number))) for number in range(5)]
    assert solved(None) == whole
    store = Store(tmp_path / "cases", work_identity(scenario), resume=False)
    first.clear()
    with pytest.raises(KeyboardInterrupt):
        solved(store, interrupted=True)
    assert (len(store), first) == (2, [])
    assert solved(resumed(store)) == whole
    assert [batch.first for batch in first] == [0, 1, 3]
    assert asked == [[0, 1, 2, 3, 4]] * 2 + [[0, 1, 3]]


def test_block_is_an_archive_of_arrays(kept):
    store, case_range, file = kept
    batch, arrays = store.read(case_range), np.load(file)
    assert batch is not None
    assert np.array_equal(arrays["numbers"], batch.numbers, equal_nan=True)
    assert np.array_equal(arrays["status"], batch.status)


def test_block_that_somebody_takes_away_is_missed_in_a_sentence(kept):
    store, case_range, file = kept
    assert len(StoredBatches(store, [case_range])[0]) == 5
    file.unlink()
    with pytest.raises(OutputError, match="cases are missing from") as fault:
        StoredBatches(store, [case_range])[0]
    assert "--resume" in fault.value.hint


Marched = Callable[..., tuple[Store, CaseRanges]]
GRID = "sweep: {friction.kinetic: {from: 1, to: 40, step: 1}}\n"
MARCHED = SEAT.replace("duration: 2", "duration: 0.5") + GRID


@pytest.fixture
def marched(tmp_path: Path) -> Marched:
    """Return a function that keeps the 40 blocks of a marched sweep in a new store."""

    def made(name: str = "cases", **changes: object) -> tuple[Store, CaseRanges]:
        scenario = load_text(tmp_path, MARCHED, **changes)
        store = Store(tmp_path / name, work_identity(scenario), resume=False)
        every = CaseRanges(approaches_of(scenario))
        assert len(every) == 40
        for case_range in every:
            store.write(case_range, solve_range(case_range, MotionCache()))
        return store, every

    return made


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_block_that_is_not_written_to_its_end_leaves_nothing(marched, monkeypatch, fault):
    store, every = marched()
    batch, names = store.read(every[3]), {file.name for file in store.folder.iterdir()}
    assert batch is not None

    def half(file: Path, content: bytes) -> int:
        with file.open("wb") as stream:
            stream.write(content[: len(content) // 2])
        raise fault

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(type(fault)):
        store.write(every[3], batch)
    assert {file.name for file in store.folder.iterdir()} == names
    assert list(resumed(store).read(every[3]) or ()) == list(batch)


def test_kill_while_a_block_is_written_loses_no_other(marched):
    store, every = marched()
    file = store.file(every[39])
    file.rename(file.with_suffix(".new"))
    again = resumed(store)
    assert [again.has(case_range) for case_range in every] == [True] * 39 + [False]
    assert again.read(every[39]) is None
    again.write(every[39], solve_range(every[39], MotionCache()))
    assert not list(store.folder.glob("*.new"))
    assert all(resumed(store).read(case_range) for case_range in every)


def test_intact_block_in_the_place_of_another_is_unfinished(marched):
    store, every = marched()
    first, second, third = map(store.file, every[:3])
    first.rename(third)
    second.rename(first)
    assert store.read(every[0]) is store.read(every[1]) is store.read(every[2]) is None
    assert store.read(every[3]) is not None


def test_intact_block_of_another_sweep_is_unfinished(marched):
    store, every = marched()
    other, _ = marched("others", oscillator__mass=76)
    for case_range in every:
        shutil.copy(other.file(case_range), store.file(case_range))
    assert all(resumed(store).read(case_range) is None for case_range in every)


def test_folders_and_pipes_in_the_place_of_blocks_are_unfinished(marched):
    store, every = marched()
    for case_range in every[:2]:
        store.file(case_range).unlink()
    store.file(every[0]).mkdir()
    os.mkfifo(store.file(every[1]))
    again = resumed(store)
    assert again.read(every[0]) is again.read(every[1]) is None
    assert all(again.read(case_range) for case_range in every[2:])


def test_partial_that_is_removed_during_a_sweep_is_named(drysim, tmp_path, monkeypatch):
    def progress(*_: object) -> Any:
        return nullcontext(lambda n: shutil.rmtree("out/seat.partial", ignore_errors=True))

    monkeypatch.setattr(terminal, "progress", progress)
    (tmp_path / "seat.yaml").write_text(MARCHED)
    done = drysim("sweep", "seat.yaml", "--no-plots", "--workers", 1)
    assert done.code == 2
    said = (
        "error: out/seat.partial was removed, in whole or in part, while drysim was writing it"
    )
    assert done.err.startswith(said)
    assert "--out" not in done.err
    assert not (tmp_path / "out/seat.partial").exists()


def test_spoiled_partial_is_resumed_to_the_very_same_table(drysim, tmp_path, monkeypatch):
    (tmp_path / "seat.yaml").write_text(MARCHED)
    words = ("sweep", "seat.yaml", "--no-plots", "-q", "--workers", 1)
    assert drysim(*words, "-o", "whole").code == 0
    for name, mass in (("other", 76), ("out", 75)):
        with monkeypatch.context() as patched:
            interrupted_after(patched, 12)
            assert drysim(*words, "-o", name, "--set", f"oscillator.mass={mass}").code == 130
    first, second, third, fourth, *_ = sorted((tmp_path / "out.partial/cases").glob("*.npz"))
    first.rename(second)
    other = tmp_path / "other.partial/cases" / third.name
    shutil.copy(other, third)
    fourth.write_bytes(fourth.read_bytes()[:-17])
    assert drysim(*words, "-o", "out", "--resume") == (0, "", "")
    tables = [tmp_path / name / "transmissibility.csv" for name in ("whole", "out")]
    assert tables[0].read_bytes() == tables[1].read_bytes()
    assert not (tmp_path / "out.partial").exists()


def test_work_of_a_program_with_another_byte_is_not_resumed(tmp_path, monkeypatch):
    scenario = load_text(tmp_path, STEADY)
    program = tmp_path / "program"
    (program / "study").mkdir(parents=True)
    (program / "study" / "fit.py").write_text("TOLERANCE = 1e-10\n")
    monkeypatch.setattr("drysim.study.store.drysim.__file__", str(program / "__init__.py"))
    identity = work_identity(scenario)
    Store(tmp_path / "cases", identity, resume=False)
    (program / "study" / "fit.py").write_text("TOLERANCE = 1e-11\n")
    with pytest.raises(UsageError, match="another scenario, record or version"):
        is_resumable(tmp_path / "cases", work_identity(scenario))
