"""A root between two bounds: where Newton's method may go, and bisection where it may not."""

from __future__ import annotations

from drysim.core.compiled import inlined

BISECTIONS = 100
"""Newton needs about 4 rounds; a halved bracket is down to one float after 60."""


@inlined
def kept_between(low, high, s):
    """Give a guess of a root that lies between two bounds, else the middle of them.

    What is not between them then, either, is next to `high`: one float is left.
    """
    return s if low < s < high else 0.5 * (low + high)
