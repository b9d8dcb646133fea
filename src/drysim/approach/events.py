"""Events: when the mass stops, breaks away or turns round. Plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from drysim.core.events import Log

Floats = NDArray[np.float64]
Codes = NDArray[np.int8]

EVENT_NAMES = {
    0: "stick", 1: "slip+", -1: "slip-", 2: "reversal+", -2: "reversal-", 3: "lift",
    4: "contact+", -4: "contact-", 5: "release+", -5: "release-", 6: "impact+", -6: "impact-",
}  # fmt: skip
"""Event codes: the sign is the new direction of v_r; a stop that sticks has none."""


@dataclass(frozen=True, eq=False)
class Events:
    """Stops, break-aways and reversals in the order of time; the first is the state at t = 0.

    Attributes
    ----------
    t : ndarray, shape (n_events,)
        Time [s].
    kind : ndarray of int8, shape (n_events,)
        Code, see `EVENT_NAMES`.
    x_r : ndarray, shape (n_events,)
        Relative displacement [m].
    F_L : ndarray, shape (n_events,)
        Limit force m·ü + k_x·x_r [N], Eq. (9).
    """

    t: Floats
    kind: Codes
    x_r: Floats
    F_L: Floats

    def __len__(self) -> int:
        """Give the number of events."""
        return len(self.t)

    def __repr__(self) -> str:
        """Give how many there are and the first few, in a line."""
        first = zip(self.t[:3].tolist(), self.kind[:3].tolist(), strict=True)
        few = ", ".join(f"{EVENT_NAMES[kind]} at {t:.6g} s" for t, kind in first)
        more = ", ..." if len(self) > 3 else ""
        return f"<Events: {len(self)}; {few}{more}>"

    def until(self, t: float) -> Events:
        """Give the events up to an instant [s], itself included."""
        count = int(np.searchsorted(self.t, t, side="right"))
        return Events(self.t[:count], self.kind[:count], self.x_r[:count], self.F_L[:count])

    def chosen(self, which: NDArray[np.bool_]) -> Events:
        """Give some of the events, the first one always among them."""
        which[0] = True
        return Events(self.t[which], self.kind[which], self.x_r[which], self.F_L[which])

    @property
    def names(self) -> list[str]:
        """The names of the events, in order."""
        return [EVENT_NAMES[code] for code in self.kind.tolist()]


def of_log(log: Log, count: int, dt: float) -> Events:
    """Give what a kernel has written into a log, its times by steps of a length [s]."""
    n, s, kind, x_r, F_L = (np.asarray(column[:count]) for column in log)
    return Events(n * dt + s, kind.astype(np.int8), x_r, F_L)
