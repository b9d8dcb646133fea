"""What a result on the disk says: extremes, quantiles and checks, from its drysim.json."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim import wording
from drysim.console.columns import show_columns
from drysim.console.paper import line, paragraph, result
from drysim.console.parts import HEAD
from drysim.metrics import METRICS
from drysim.wording import number

UNITS = {metric.name: wording.pretty(metric.unit) for metric in METRICS}

HEADINGS = ("metric", "unit", "least", "5 %", "median", "95 %", "greatest")
SPARED = ("5 %", "95 %", "unit")
"""What a narrow terminal does without."""

Fields = Mapping[str, Any]


def show_result(told: Fields) -> None:
    """Show what drysim.json tells of a run, a sweep or a comparison.

    Parameters
    ----------
    told : mapping
        As the file has it.
    """
    paper = result()
    line(paper, (wording.clean(str(told["scenario"]["name"])), "bold"))
    line(paper)
    for name, words in _scene(told):
        paragraph(paper, f"  {name}".ljust(HEAD), words, "dim")
    for approach, metrics in _tables(told["metrics"]):
        line(paper)
        if approach:
            line(paper, (f"  {approach}", "bold"))
        show_columns(paper, _columns(metrics), ("metric", "unit"), SPARED)
    if told["checks"]:
        line(paper)
    for check in told["checks"]:
        mark, style = ("✓ holds", "green") if check["passed"] else ("✗ fails", "bold red")
        paragraph(paper, f"  {mark}".ljust(HEAD), _judged(check), style)


def _scene(told: Fields) -> Iterator[tuple[str, str]]:
    """Give what was computed, in words."""
    numerics = told["numerics"]
    yield "command", str(told["command"])
    for at, axis in enumerate(numerics.get("swept", ())):
        yield "" if at else "swept", f"{axis['key']} ({axis['values']} values)"
    cases = numerics.get("cases", 1)
    statuses = numerics.get("statuses") or {}
    lost = [f"{count} {status}" for status, count in statuses.items() if status != "ok"]
    yield "cases", ", ".join([str(cases), *lost])
    if not told["complete"]:
        yield "state", "incomplete"


def _tables(metrics: Fields) -> Iterator[tuple[str, Fields]]:
    """Give the metrics of every approach of a comparison; of anything else without a name."""
    several = all(isinstance(one, Mapping) and "least" not in one for one in metrics.values())
    yield from metrics.items() if several and metrics else [("", metrics)]


def _columns(metrics: Fields) -> list[list[str]]:
    """Give metrics as a table, column by column."""
    rows = [_row(name, found) for name, found in metrics.items() if name in UNITS]
    known = [row for row in rows if row is not None]
    columns = [list(column) for column in zip(HEADINGS, *known, strict=True)]
    return [column for column in columns if any(column[1:])]


def _row(name: str, found: Any) -> tuple[str, ...] | None:
    """Give the cells of a metric; None where it is not known."""
    if not isinstance(found, Mapping):
        return None if found is None else (name, UNITS[name], number(found), "", "", "", "")
    share = found.get("quantiles", {})
    cells = (share.get("0.05"), share.get("0.5"), share.get("0.95"))
    least, *inner, most = (found["least"]["value"], *cells, found["greatest"]["value"])
    values = ("" if value is None else number(value) for value in (least, *inner, most))
    return name, UNITS[name], *values


def _judged(check: Fields) -> str:
    """Give a check with its value, and where that was met."""
    where = check.get("where") or {}
    place = ", ".join(f"{key} = {number(value)}" for key, value in where.items())
    value = check["value"]
    found = "not known" if value is None else f"with {number(value, digits=6)}"
    return f"{check['check']}, {found}{f' at {place}' if place else ''}"
