"""What a result on the disk says: extremes, quantiles and checks, from its drysim.json."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim import wording
from drysim.checks import Check, Verdict
from drysim.console.columns import show_columns
from drysim.console.paper import line, stdout
from drysim.console.parts import finding, headed, judged, show_scene
from drysim.metrics import UNITS
from drysim.wording import number

HEADINGS = (
    "metric", "unit", "value", "mean", "±", "least", "5 %", "median", "95 %", "greatest"
)  # fmt: skip
"""What may be told of a metric: of a run its value, of seeds their mean, of cases a range."""

SHARES = {"5 %": ("0.05", "5 %"), "median": ("0.5", "50 %"), "95 %": ("0.95", "95 %")}
"""Quantiles by what a sweep and what many seeds call them."""

SPARED = ("5 %", "95 %", "unit")
"""What a narrow terminal does without."""

Fields = Mapping[str, Any]


def show_retold(told: Fields) -> None:
    """Show what drysim.json tells of a run, a sweep or a comparison.

    Parameters
    ----------
    told : mapping
        As the file has it.
    """
    paper = stdout()
    line(paper, (wording.clean(str(told["scenario"]["name"])), "bold"))
    show_scene(paper, _scene(told))
    # Of many seeds the plain metrics are means; beside them stands how they scatter.
    found = told.get("ensemble", told)["metrics"]
    for approach, metrics in _tables(found):
        line(paper)
        if approach:
            line(paper, (f"  {approach}", "bold"))
        show_columns(paper, _columns(metrics), ("metric", "unit"), SPARED)
    if told["checks"]:
        line(paper)
    for passed, words in told_checks(told):
        mark, style = judged(passed)
        headed(paper, mark, words, style)


def _scene(told: Fields) -> Iterator[tuple[str, str]]:
    """Give what was computed, in words."""
    numerics = told["numerics"]
    yield "command", str(told["command"])
    for at, axis in enumerate(numerics.get("swept", ())):
        yield "" if at else "swept", f"{axis['key']} ({axis['values']} values)"
    if "ensemble" in told:
        seeds = told["ensemble"]
        yield "seeds", f"{seeds['seeds']}, from {seeds['first']} to {seeds['last']}"
        if seeds["failed"]:
            yield "failed", str(seeds["failed"])
    else:
        yield from _cases(numerics)
    if not told["complete"]:
        yield "state", "incomplete"


def _cases(numerics: Fields) -> Iterator[tuple[str, str]]:
    """Give how many cases there are, and what became of them."""
    cases = numerics.get("cases", 1)
    statuses = numerics.get("statuses") or {}
    lost = [f"{count} {status}" for status, count in statuses.items() if status != "ok"]
    yield "cases", ", ".join([str(cases), *lost])


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
    if found is None:
        return None
    if not isinstance(found, Mapping):
        found = {"value": found}
    share = found.get("quantiles", {})
    values = {
        "value": found.get("value"),
        "mean": found.get("mean"),
        "±": found.get("half_width"),
        **{end: found[end]["value"] for end in ("least", "greatest") if end in found},
        **{head: share.get(one, share.get(other)) for head, (one, other) in SHARES.items()},
    }
    known = (values.get(head) for head in HEADINGS[2:])
    cells = ("" if one is None else number(one) for one in known)
    return name, wording.pretty(UNITS[name]), *cells


def told_checks(told: Fields) -> Iterator[tuple[bool | None, str]]:
    """Give what became of every check, and in words what came out and where."""
    numerics = told.get("numerics", {})
    units = {axis["key"]: axis["unit"] for axis in numerics.get("swept", ())}
    for check in told.get("checks", ()):
        yield check["passed"], finding(_verdict(check), units, numerics.get("yardstick", ""))


def _verdict(check: Fields) -> Verdict:
    """Give the verdict that a file tells."""
    known = {key: check[key] for key in ("half_width", "seeds", "reason") if key in check}
    promise = Check.promise(check["check"])
    return Verdict(promise, check["passed"], check["value"], check.get("where"), **known)
