"""Blocks on the disk that something has spoiled: unfinished, or refused in a sentence."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from drysim.errors import OutputError
from drysim.scenario import load
from drysim.study.identity import identity
from drysim.study.sweeps.cases import Motions
from drysim.study.sweeps.plan import Piece, Pieces, solve_piece
from drysim.study.sweeps.store import Store, Stored
from drysim.study.sweeps.sweep import approaches_of
from fuzz.mutate import damaged
from seat import SEAT

SWEEP = "sweep: {friction.kinetic: [10, 20, 30, 40, 50]}\n"
STEADY = SEAT.replace("measure: {steady: false, settle: 0, duration: 2}\n", "") + SWEEP


@pytest.fixture
def kept(tmp_path: Path) -> tuple[Store, Piece, Path]:
    """Keep one block; give its store, its piece and its file."""
    file = tmp_path / "seat.yaml"
    file.write_text(STEADY)
    scenario = load(file)
    store = Store(tmp_path / "cases", identity(scenario), resume=False)
    (piece,) = Pieces(approaches_of(scenario))
    store.write(piece, solve_piece(piece, Motions()))
    return store, piece, next(store.folder.glob("*.cases"))


def test_damaged_block_is_unfinished(kept: tuple[Store, Piece, Path]) -> None:
    store, piece, file = kept
    sound, read = file.read_bytes(), list(store.read(piece) or ())
    assert len(read) == 5
    for number in range(3000):
        words = damaged([sound], random.Random(number))
        file.write_bytes(words)
        found = store.read(piece)
        assert list(found or ()) == (read if words == sound else [])


def test_block_cut_short_anywhere_is_unfinished(kept: tuple[Store, Piece, Path]) -> None:
    store, piece, file = kept
    sound = file.read_bytes()
    for size in (*range(0, len(sound), 7), len(sound) - 1):
        file.write_bytes(sound[:size])
        assert not store.holds(piece)
        assert store.read(piece) is None


def test_block_that_somebody_takes_away_is_missed_in_a_sentence(
    kept: tuple[Store, Piece, Path],
) -> None:
    store, piece, file = kept
    assert len(Stored(store, [piece])[0]) == 5
    file.unlink()
    with pytest.raises(OutputError, match="lost cases that were kept there") as fault:
        Stored(store, [piece])[0]
    assert "--resume" in fault.value.hint
