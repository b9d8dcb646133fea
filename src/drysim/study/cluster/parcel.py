"""Parcel: all that a worker needs to compute any block of a sweep. It travels once."""

from __future__ import annotations

import hashlib
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Any, Self
from weakref import finalize

from drysim.core import compiled
from drysim.errors import DrysimError
from drysim.source import dump
from drysim.study.cluster.alike import refuse_late, versions
from drysim.study.hashes import named_files
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
    sweep : str
        Digest of the sweep, which its blocks bear.
    """

    words: str
    files: tuple[tuple[str, bytes], ...]
    versions: tuple[tuple[str, str | None], ...]
    sweep: str

    @classmethod
    def of(cls, scenario: Scenario, sweep: str) -> Self:
        """Give the parcel of a scenario whose files are there."""
        words, files = scenario.resolved(), []
        for number, (keys, path) in enumerate(named_files(scenario)):
            name = f"{number}{path.suffix}"
            files.append((name, path.read_bytes()))
            block: Any = words
            for key in keys:
                block = block[key]
            block["file"] = name
        return cls(dump(words), tuple(files), tuple(versions().items()), sweep)

    @property
    def digest(self) -> str:
        """The SHA-256 (hex) of everything in it."""
        digest = hashlib.sha256(f"{self.sweep}\0{self.words}".encode())
        for name, content in self.files:
            digest.update(f"\0{name}\0{len(content)}\0".encode())
            digest.update(content)
        return digest.hexdigest()


@lru_cache(SWEEPS_KEPT)
def opened(parcel: Parcel) -> Plan:
    """Give the plan that a parcel holds.

    A worker lives longer than a sweep, so it compiles: a small one may not settle for plain.
    """
    from drysim.scenario import load
    from drysim.study.case import prepare
    from drysim.study.sweeps.sweep import approaches_of

    compiled.settle(compiled.PLAIN_STEPS + 1)
    folder = Path(tempfile.mkdtemp(prefix="drysim-", dir=own_folder()))
    with ExitStack() as leave:
        leave.callback(rmtree, folder, ignore_errors=True)
        (folder / SCENARIO).write_text(parcel.words, encoding="utf-8")
        for file, content in parcel.files:
            (folder / file).write_bytes(content)
        case = prepare(load(folder / SCENARIO))
        plan = Plan.of(approaches_of(case.scenario), case)
        if parcel.files:  # long samples stay in their file
            finalize(plan, leave.pop_all().close)
    return plan


def own_folder() -> str | None:
    """Give the folder of this worker, None outside of one.

    When a worker was killed, the next one on its machine removes what it has left there.
    """
    from distributed import get_worker

    try:
        return str(get_worker().local_directory)
    except ValueError:
        return None


def compute(parcel: Parcel, numbers: Sequence[int]) -> tuple[list[bytes | None], float]:
    """Give blocks, packed, and the processor time that they took [s].

    A block with a case at fault is None, as whoever asks can say better what is wrong.

    Raises
    ------
    ClusterError
        When this worker, which has come late, runs something else.
    """
    refuse_late(dict(parcel.versions))
    began = time.thread_time()
    return [_block(parcel, number) for number in numbers], time.thread_time() - began


def _block(parcel: Parcel, number: int) -> bytes | None:
    """Give a block, packed; None where a case is at fault."""
    try:
        return packed(opened(parcel).block(number), parcel.sweep)
    except DrysimError:
        return None
