"""Shelf of peers: programs that people know, on the same work. One file and one name here.

A peer has the name of the `PACKAGE` that it needs and gives `entries(work)`. None but scipy is
a dependency; those that are not installed are named and left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from types import ModuleType

from drysim.bench import scipy_ivp
from drysim.bench.peers import heyoka, mujoco, pathsim, sundials
from drysim.bench.work import Entry, Work
from drysim.core.model import AnyLaw, Law, Pressed, Stopped

PEERS = (scipy_ivp, heyoka, sundials, pathsim, mujoco)


def present() -> tuple[ModuleType, ...]:
    """Give the peers that are installed."""
    return tuple(peer for peer in PEERS if find_spec(peer.PACKAGE) is not None)


def absent() -> tuple[str, ...]:
    """Give the packages of the peers that are not installed."""
    return tuple(peer.PACKAGE for peer in PEERS if find_spec(peer.PACKAGE) is None)


def entries(work: Work) -> Iterator[Entry]:
    """Give the entries of all peers that are installed."""
    for peer in present():
        yield from peer.entries(work)


def unknown(law: AnyLaw) -> str:
    """Say what the peers do not know: any but Coulomb's friction under a constant force."""
    if isinstance(law, Stopped):
        return "end stops"
    if isinstance(law, Law | Pressed):
        varies = isinstance(law, Pressed) or law.variation
        return "a varying normal force" if varies else ""
    return "this friction law"
