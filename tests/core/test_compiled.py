"""The engines: how one is settled, and where compiled kernels are kept."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from drysim.core import compiled


@pytest.mark.parametrize(
    ("word", "engine"), [("plain", "plain"), ("compiled", "compiled"), ("auto", "compiled")]
)
def test_environment_names_the_engine(
    monkeypatch: pytest.MonkeyPatch, word: str, engine: str
) -> None:
    monkeypatch.setenv(compiled.VARIABLE, word)
    assert compiled.engine() == engine


def test_another_word_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(compiled.VARIABLE, "turbo")
    with pytest.raises(ValueError, match="plain, compiled or auto, not 'turbo'"):
        compiled.engine()


def test_kernels_are_kept_in_the_users_cache_under_a_name_of_their_source(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled.cache_folder.cache_clear()
    try:
        folder = compiled.cache_folder()
        assert folder == tmp_path / "drysim" / f"kernels-{compiled.source_key()}"
        assert folder.is_dir()
    finally:
        compiled.cache_folder.cache_clear()


def test_cache_that_cannot_be_made_falls_back_to_the_temporary_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    compiled.cache_folder.cache_clear()
    try:
        folder = compiled.cache_folder()
        assert folder is not None
        assert folder.is_relative_to(tmp_path)
    finally:
        compiled.cache_folder.cache_clear()


@pytest.fixture
def settled(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Callable[..., str]]:
    """Give the engine that `auto` settles on in a process that has loaded no kernel yet."""

    def engine(steps: int, *kernels: str) -> str:
        monkeypatch.setenv(compiled.VARIABLE, compiled.AUTO)
        monkeypatch.delitem(sys.modules, "drysim.core.flow", raising=False)
        compiled.settle(steps, *kernels)
        return os.environ[compiled.VARIABLE]

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled.cache_folder.cache_clear()
    yield engine
    compiled.cache_folder.cache_clear()


def test_short_job_stays_plain_and_a_long_one_is_compiled(
    settled: Callable[..., str],
) -> None:
    assert settled(compiled.PLAIN_STEPS) == compiled.PLAIN
    assert settled(compiled.PLAIN_STEPS + 1) == compiled.COMPILED


def test_kernels_of_a_law_are_compiled_for_the_first_time_only_where_it_pays(
    settled: Callable[..., str],
) -> None:
    middling, much = 2 * compiled.PLAIN_STEPS, 11 * compiled.PLAIN_STEPS
    assert settled(middling, "dynamic_laws") == compiled.PLAIN
    assert settled(much, "dynamic_laws") == compiled.COMPILED
    folder = compiled.cache_folder()
    assert folder is not None
    (folder / "dynamic_laws_0").mkdir()
    (folder / "dynamic_laws_0" / "trace.nbi").touch()
    assert settled(middling, "dynamic_laws") == compiled.COMPILED
    assert settled(middling, "contacts") == compiled.PLAIN
