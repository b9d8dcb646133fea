"""Other programs on the work of `drysim bench`, if installed; scipy is part of the benchmark.

`python -m pip install heyoka scikit-sundae pathsim mujoco` installs all of them. A peer is one
module here, with the name of its `PACKAGE` and a function `entries(work)`.
"""

from __future__ import annotations

from importlib.util import find_spec

from drysim.bench.work import Peer
from peers import heyoka, mujoco, pathsim, sundials


def installed_peers() -> tuple[Peer, ...]:
    """Return the peers that are installed."""
    known = (heyoka, sundials, pathsim, mujoco)
    return tuple(peer for peer in known if find_spec(peer.PACKAGE) is not None)
