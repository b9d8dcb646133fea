"""Other programs on the work of `drysim bench`, where they are installed; scipy is in it.

`python -m pip install heyoka scikit-sundae pathsim mujoco` brings them all. A peer is one file
here: it has the name of the `PACKAGE` that it needs, and gives `entries(work)`.
"""

from __future__ import annotations

from importlib.util import find_spec

from drysim.bench.work import Peer
from peers import heyoka, mujoco, pathsim, sundials


def installed_peers() -> tuple[Peer, ...]:
    """Give the peers that are installed."""
    known = (heyoka, sundials, pathsim, mujoco)
    return tuple(peer for peer in known if find_spec(peer.PACKAGE) is not None)
