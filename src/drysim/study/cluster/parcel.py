"""Parcel: all that a worker needs to compute any block of a sweep. It travels once."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Any, Self
from weakref import finalize

from drysim.core import compiled
from drysim.errors import DrysimError
from drysim.quantity import Block
from drysim.source import dump
from drysim.study.cluster.alike import refuse_late, versions
from drysim.study.sweeps.packing import packed
from drysim.study.sweeps.plan import Plan

if TYPE_CHECKING:
    from drysim.scenario import Scenario

SCENARIO = "scenario.yaml"

SWEEPS_KEPT = 2
"""Sweeps that a worker keeps open: the latest, and one that is worked at beside it."""


@dataclass(frozen=True)
class Parcel:
    """A scenario as words, and the files that it names; no worker reads another disk.

    Attributes
    ----------
    words : str
        The resolved scenario as YAML, its files named as they are here.
    files : tuple of (str, bytes)
        Names and contents.
    versions : tuple of (str, str)
        What runs where the parcel was made up.
    """

    words: str
    files: tuple[tuple[str, bytes], ...]
    versions: tuple[tuple[str, str | None], ...]

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Give the parcel of a scenario whose files are there."""
        words, files = scenario.resolved(), []
        for number, (keys, path) in enumerate(named_files(scenario)):
            name = f"{number}{path.suffix}"
            files.append((name, path.read_bytes()))
            block: Any = words
            for key in keys:
                block = block[key]
            block["file"] = name
        return cls(dump(words), tuple(files), tuple(versions().items()))

    @property
    def digest(self) -> str:
        """The SHA-256 (hex) of everything in it."""
        digest = hashlib.sha256(self.words.encode())
        for name, content in self.files:
            digest.update(f"\0{name}\0{len(content)}\0".encode())
            digest.update(content)
        return digest.hexdigest()


def named_files(block: Block, keys: tuple[str, ...] = ()) -> Iterator[tuple[Any, Path]]:
    """Give the files that a scenario names, with the way to the block that names each."""
    path = getattr(block, "path", None)
    if isinstance(path, Path):
        yield keys, path
    for name in type(block).model_fields:
        if isinstance(inner := getattr(block, name), Block):
            yield from named_files(inner, (*keys, name))


@lru_cache(SWEEPS_KEPT)
def opened(parcel: Parcel) -> Plan:
    """Give the plan that a parcel holds.

    A worker lives longer than a sweep, so it compiles: a small one may not settle for plain.
    """
    from drysim.scenario import load
    from drysim.study.case import prepare
    from drysim.study.sweeps.sweep import approaches_of

    compiled.settle(compiled.PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-"))
    (folder / SCENARIO).write_text(parcel.words, encoding="utf-8")
    for file, content in parcel.files:
        (folder / file).write_bytes(content)
    case = prepare(load(folder / SCENARIO))
    plan = Plan.of(approaches_of(case.scenario), case)
    finalize(plan, rmtree, folder, ignore_errors=True)  # long samples stay in their file
    return plan


def compute(parcel: Parcel, number: int) -> bytes | None:
    """Give a block, packed; None where a case is at fault, as whoever asks can say better.

    Raises
    ------
    ClusterError
        When this worker, which has come late, runs something else.
    """
    refuse_late(dict(parcel.versions))
    try:
        return packed(opened(parcel).block(number))
    except DrysimError:
        return None
