"""Blocks on the disk that something has spoiled: unfinished, or refused in a sentence."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from seat import SEAT

from drysim.console import terminal
from drysim.errors import OutputError
from drysim.scenario.load import load
from drysim.study import store as store_module
from drysim.study.plan import CaseRange, CaseRanges, approaches_of, solve_range
from drysim.study.run import MotionCache
from drysim.study.store import CASES_SUFFIX, IDENTITY_FILE, Store, StoredBatches, work_identity
from fuzz.mutate import damaged

SWEEP = "sweep: {friction.kinetic: [10, 20, 30, 40, 50]}\n"
STEADY = SEAT.replace("measure: {steady: false, settle: 0, duration: 2}\n", "") + SWEEP


@pytest.fixture
def kept(tmp_path: Path) -> tuple[Store, CaseRange, Path]:
    """Keep one block; give its store, its piece and its file."""
    file = tmp_path / "seat.yaml"
    file.write_text(STEADY)
    scenario = load(file)
    store = Store(tmp_path / "cases", work_identity(scenario), resume=False)
    (case_range,) = CaseRanges(approaches_of(scenario))
    store.write(case_range, solve_range(case_range, MotionCache()))
    return store, case_range, next(store.folder.glob("*.cases"))


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


def test_damaged_block_is_unfinished(kept: tuple[Store, CaseRange, Path]) -> None:
    store, case_range, file = kept
    sound, read = file.read_bytes(), list(store.read(case_range) or ())
    assert len(read) == 5
    for number in range(3000):
        words = damaged([sound], random.Random(number))
        file.write_bytes(words)
        found = store.read(case_range)
        assert list(found or ()) == (read if words.startswith(sound) else [])


def test_block_cut_short_anywhere_is_unfinished(kept: tuple[Store, CaseRange, Path]) -> None:
    store, case_range, file = kept
    sound = file.read_bytes()
    for size in (*range(0, len(sound), 7), len(sound) - 1):
        file.write_bytes(sound[:size])
        assert store.read(case_range) is None
        assert not resumed(store).has(case_range)
        assert resumed(store).read(case_range) is None


def test_block_that_somebody_takes_away_is_missed_in_a_sentence(
    kept: tuple[Store, CaseRange, Path],
) -> None:
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
        (tmp_path / "seat.yaml").write_text(MARCHED)
        overrides = {key.replace("__", "."): value for key, value in changes.items()}
        scenario = load(tmp_path / "seat.yaml", overrides)
        store = Store(tmp_path / name, work_identity(scenario), resume=False)
        every = CaseRanges(approaches_of(scenario))
        assert len(every) == 40
        for case_range in every:
            store.write(case_range, solve_range(case_range, MotionCache()))
        return store, every

    return made


def test_many_small_blocks_lie_in_few_files(marched: Marched, monkeypatch: Any) -> None:
    store, every = marched()
    (file,) = store.folder.glob(f"*{CASES_SUFFIX}")
    monkeypatch.setattr(store_module, "MAX_FILE_BYTES", file.stat().st_size // 4)
    several, _ = marched("several")
    assert len(list(several.folder.glob(f"*{CASES_SUFFIX}"))) == 4
    for one in (store, several, resumed(store), resumed(several)):
        assert [len(one.read(case_range) or ()) for case_range in every] == [1] * 40


def test_file_cut_short_anywhere_loses_no_block_before_the_cut(marched: Marched) -> None:
    store, every = marched()
    (file,) = store.folder.glob(f"*{CASES_SUFFIX}")
    sound, rows = (
        file.read_bytes(),
        [list(store.read(case_range) or ()) for case_range in every],
    )
    ends = [place.begin + place.size for place in store._locations.values()]
    for size in range(0, len(sound), 997):
        file.write_bytes(sound[:size])
        again = resumed(store)
        whole = sum(end <= size for end in ends)
        assert [again.has(case_range) for case_range in every] == [True] * whole + [False] * (
            40 - whole
        )
        assert [list(again.read(case_range) or ()) for case_range in every[:whole]] == rows[
            :whole
        ]


def test_block_after_a_kill_goes_to_another_file_and_counts(marched: Marched) -> None:
    store, every = marched()
    (file,) = store.folder.glob(f"*{CASES_SUFFIX}")
    file.write_bytes(file.read_bytes()[:-17])
    again = resumed(store)
    again.write(every[39], solve_range(every[39], MotionCache()))
    assert len(list(store.folder.glob(f"*{CASES_SUFFIX}"))) == 2
    assert all(resumed(store).has(case_range) for case_range in every)
    assert list(resumed(store).read(every[39]) or ()) == list(again.read(every[39]) or ())


def test_intact_block_in_the_place_of_another_is_unfinished(marched: Marched) -> None:
    store, every = marched()
    store._locations[0], store._locations[1] = store._locations[1], store._locations[0]
    assert store.read(every[0]) is store.read(every[1]) is None
    assert store.read(every[2]) is not None


def test_intact_block_of_another_sweep_is_unfinished(marched: Marched) -> None:
    store, every = marched()
    other, _ = marched("others", oscillator__mass=76)
    for file in store.folder.glob(f"*{CASES_SUFFIX}"):
        file.unlink()
    for file in other.folder.glob(f"*{CASES_SUFFIX}"):
        shutil.copy(file, store.folder)
    again = resumed(store)
    assert not any(again.has(case_range) for case_range in every)
    store._locations = other._locations
    assert all(store.read(case_range) is None for case_range in every)


def test_folders_and_pipes_among_the_blocks_are_passed_over(marched: Marched) -> None:
    store, every = marched()
    (store.folder / f"000000-0{CASES_SUFFIX}").mkdir()
    os.mkfifo(store.folder / f"000001-0{CASES_SUFFIX}")
    again = resumed(store)
    assert all(again.has(case_range) for case_range in every)
    again.write(every[0], solve_range(every[0], MotionCache()))


@pytest.mark.parametrize("what", ["folder", "file"])
def test_store_that_is_removed_says_so_at_the_next_block(marched: Marched, what: str) -> None:
    store, every = marched()
    if what == "folder":
        shutil.rmtree(store.folder)
    else:
        next(store.folder.glob(f"*{CASES_SUFFIX}")).unlink()
    with pytest.raises(OutputError, match="was removed, in whole or in part, while"):
        store.write(every[0], solve_range(every[0], MotionCache()))


def test_partial_that_is_removed_during_a_sweep_is_named(
    drysim: Any, tmp_path: Path, monkeypatch: Any
) -> None:
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


def test_spoiled_partial_is_resumed_to_the_very_same_table(
    drysim: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    (tmp_path / "seat.yaml").write_text(MARCHED)
    words = ("sweep", "seat.yaml", "--no-plots", "-q", "--workers", 1)
    assert drysim(*words, "-o", "whole").code == 0
    for name, mass in (("other", 76), ("out", 75)):
        with monkeypatch.context() as patched:
            interrupted_after(patched, 12)
            assert drysim(*words, "-o", name, "--set", f"oscillator.mass={mass}").code == 130
    (file,) = (tmp_path / "out.partial/cases").glob(f"*{CASES_SUFFIX}")
    sound, begins = file.read_bytes(), [*re.finditer(rb'{"sweep": ', file.read_bytes())]
    a, b, c = (one.start() for one in begins[:3])
    file.write_bytes(sound[b:c] + sound[a:b] + sound[c:])
    (other,) = (tmp_path / "other.partial/cases").glob(f"*{CASES_SUFFIX}")
    shutil.copy(other, file.with_name(f"999999-0{CASES_SUFFIX}"))
    (file.parent / f"999998-0{CASES_SUFFIX}").mkdir()
    assert drysim(*words, "-o", "out", "--resume") == (0, "", "")
    tables = [tmp_path / name / "transmissibility.csv" for name in ("whole", "out")]
    assert tables[0].read_bytes() == tables[1].read_bytes()
    assert not (tmp_path / "out.partial").exists()
