"""Whether the workers of a cluster run what runs here: else their numbers might differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from drysim.errors import ClusterError, UsageError

Versions = Mapping[str, str | None]

PACKAGES = ("drysim", "numpy", "scipy", "numba", "distributed")
"""Whatever a number or its way may depend on."""


def teller() -> Callable[[], dict[str, str | None]]:
    """Give a function that tells the versions of everything that numbers depend on.

    It carries all that it needs, so that it also runs where there is no drysim, or another.
    """
    names = PACKAGES

    def told() -> dict[str, str | None]:
        import hashlib
        import importlib
        import pathlib
        import platform

        found: dict[str, str | None] = {"Python": ".".join(platform.python_version_tuple()[:2])}
        for name in names:
            try:
                found[name] = str(importlib.import_module(name).__version__)
            except Exception:
                found[name] = None
        found["source of drysim"] = None
        if found["drysim"] is not None:
            home = pathlib.Path(str(importlib.import_module("drysim").__file__)).parent
            files = sorted(home.rglob("*.py"), key=lambda file: file.relative_to(home).parts)
            content = b"".join(file.read_bytes() for file in files)
            found["source of drysim"] = hashlib.sha256(content).hexdigest()[:12]
        return found

    return told


@cache
def versions() -> Versions:
    """Give the versions of what runs here."""
    return teller()()


def refuse_others(there: Mapping[str, Any]) -> None:
    """Make sure that all workers run what runs here.

    Parameters
    ----------
    there : mapping
        By the address of a worker what it tells, or the exception that it gives instead.

    Raises
    ------
    UsageError
        Names a worker and what is other there.
    """
    for worker, told in there.items():
        if isinstance(told, BaseException):
            raise UsageError(f"the worker {worker} cannot be asked: {told}", remedy(versions()))
        if other := difference(told, versions()):
            raise UsageError(f"the worker {worker} {other}", remedy(versions()))


def refuse_late(asked: Versions) -> None:
    """Make sure that this worker runs what runs where its work comes from.

    Raises
    ------
    ClusterError
    """
    if other := difference(versions(), asked):
        from distributed import get_worker

        worker = f"the worker {get_worker().address}, which has come late,"
        raise ClusterError(f"{worker} {other}", f"{remedy(asked)}; --resume goes on")


def difference(there: Versions, here: Versions) -> str:
    """Say what is other there; empty where nothing is."""
    for name, version in here.items():
        if there.get(name) != version:
            has = f"has {name} {there[name]}" if there.get(name) else f"has no {name}"
            return f"{has}, here is {version}"
    return ""


def remedy(here: Versions) -> str:
    """Say how to make all machines alike."""
    words = " ".join(f"{name}=={here[name]}" for name in PACKAGES)
    return f"install the same on all machines, pip install {words}, and start the workers anew"
