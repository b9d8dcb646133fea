"""Metrics of a stored result, whatever its kind, as tables of text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim import wording
from drysim.metrics.table import UNITS
from drysim.wording import format_number

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


def metric_tables(metrics: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the metrics of every approach of a comparison; else one unnamed table."""
    several = all(
        isinstance(entry, Mapping) and "least" not in entry for entry in metrics.values()
    )
    yield from metrics.items() if several else [("", metrics)]


def describe_metrics(fields: Mapping[str, Any]) -> str:
    """Describe over what the metrics were taken, or of which design; empty for a single run."""
    numerics = fields["numerics"]
    if design := fields.get("design", {}).get("metrics_of"):
        return f"values {design}"
    if "ensemble" in fields:
        seeds = fields["ensemble"]["seeds"]
        return f"mean, its 95 % interval, range and quantiles over {seeds} seeds"
    if fields["kind"] == "assess":
        return "of the measured samples; of several runs the mean, or the largest peak"
    if fields["kind"] not in ("sweep", "comparison"):
        return ""
    approach = numerics.get("approach")
    cases = f"the cases by {approach}" if approach else "the cases of each approach"
    means = "; each case is a mean over its seeds" * ("seeds" in numerics)
    return f"range and quantiles over {cases}{means}"


def metric_columns(metrics: Mapping[str, Any]) -> list[list[str]]:
    """Return metrics as a table by columns."""
    rows = [_metric_row(name, entry) for name, entry in metrics.items() if name in UNITS]
    filled = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *filled, strict=True)]
    return [column for column in columns if any(column[1:])]


def _metric_row(name: str, entry: Any) -> tuple[str, ...] | None:
    """Return the cells of a metric, None if it has no value."""
    if entry is None:
        return None
    if not isinstance(entry, Mapping):
        entry = {"value": entry}
    share = entry.get("quantiles", {})
    values = {
        "value": entry.get("value"),
        "mean": entry.get("mean"),
        "±": entry.get("half_width"),
        **{head: entry[end]["value"] for head, end in EXTREME_KEYS.items() if end in entry},
        **{
            head: share.get(key, share.get(other))
            for head, (key, other) in QUANTILE_KEYS.items()
        },
    }
    numbers = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if number is None else format_number(number) for number in numbers)
    return name, wording.format_unit(UNITS[name]), *cells
