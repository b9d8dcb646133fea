"""Where a sweep is computed: by threads of this process, or by a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.errors import UsageError

if TYPE_CHECKING:
    from drysim.cli.voice import Voice
    from drysim.study.case import Case
    from drysim.study.sweeps.batch import Batch
    from drysim.study.sweeps.store import Store
    from drysim.study.sweeps.table import Table

    Compute = Callable[[Case, Store, Callable[[Batch], None]], Table]


@contextmanager
def place(
    cluster: str | None,
    workers: int | None,
    voice: Voice,
    certificates: tuple[Path | None, Path | None, Path | None],
) -> Iterator[Compute]:
    """Give the function that computes a sweep where it is wanted, as long as it is there.

    Raises
    ------
    UsageError
        When the words do not go together, or no cluster answers at the address.
    """
    from drysim.study.sweeps.sweep import solve, solve_far

    if cluster is None:
        if any(certificates):
            raise UsageError(
                "certificates have no meaning without a cluster", "add --cluster tls://..."
            )
        yield lambda case, store, finished: solve(
            case, workers=workers, store=store, finished=finished
        )
        return
    from drysim import console
    from drysim.study.cluster.link import LOCAL, Certificates, joined

    if workers is not None and cluster != LOCAL:
        raise UsageError(
            "--workers has no meaning beside the address of a cluster",
            "its workers are as many as were started; --cluster local takes --workers",
        )
    own, warn = Certificates(*certificates), console.remark
    with joined(cluster, workers, voice.remark, warn, own) as link:
        yield lambda case, store, finished: solve_far(case, link, store, finished=finished)
