"""Metrics of a stored result, whatever its kind, as tables of text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.metrics.table import UNITS
from drysim.wording import format_number

if TYPE_CHECKING:
    from drysim.results.fields import Fields

HEADINGS = (
    "metric", "unit", "value", "mean", "±", "minimum", "5 %", "median", "95 %", "maximum"
)  # fmt: skip
"""Columns of a metric: its value in a run, mean over seeds, or range over cases."""


EXTREME_KEYS = {"minimum": "least", "maximum": "greatest"}
"""Keys of the extremes in drysim.json."""


QUANTILE_KEYS = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Keys of the quantiles in drysim.json: of a sweep, and of an ensemble."""


OPTIONAL_COLUMNS = ("5 %", "95 %", "unit")
"""Columns that a narrow terminal omits, in this order."""


def metric_tables(metrics: Fields) -> Iterator[tuple[str, Fields]]:
    """Yield the metrics of every approach of a comparison; else one unnamed table."""
    several = all(isinstance(one, Mapping) and "least" not in one for one in metrics.values())
    yield from metrics.items() if several else [("", metrics)]


def metric_columns(metrics: Fields) -> list[list[str]]:
    """Return metrics as a table by columns."""
    rows = [_metric_row(name, found) for name, found in metrics.items() if name in UNITS]
    known = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *known, strict=True)]
    return [column for column in columns if any(column[1:])]


def _metric_row(name: str, found: Any) -> tuple[str, ...] | None:
    """Return the cells of a metric, None if it has no value."""
    if found is None:
        return None
    if not isinstance(found, Mapping):
        found = {"value": found}
    share = found.get("quantiles", {})
    values = {
        "value": found.get("value"),
        "mean": found.get("mean"),
        "±": found.get("half_width"),
        **{head: found[end]["value"] for head, end in EXTREME_KEYS.items() if end in found},
        **{
            head: share.get(one, share.get(other))
            for head, (one, other) in QUANTILE_KEYS.items()
        },
    }
    known = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if one is None else format_number(one) for one in known)
    return name, wording.format_unit(UNITS[name]), *cells
