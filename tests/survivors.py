"""Changes of the core that `mutate.py` makes and no test can notice, each with its reason."""

from __future__ import annotations

EXPLAINED = {
    ("flow.py", "if rate > -0.0625:"): "more terms of a series than double precision shows",
    ("orbit.py", "if events <= 0 or events + ROOM >= capacity:"): (
        "a log that is full to the last line stands for one that is too small"
    ),
    ("orbit.py", "scale = peak if peak > 0.0 else -1.0"): (
        "a mass that has not moved changes by nothing, whatever that is compared to"
    ),
}
"""By file and line as changed."""
