"""A result on the disk, as `drysim summarise` shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from drysim.console.summary import print_labelled, print_summary
from drysim.console.terminal import print_line, print_table
from drysim.errors import WarningMessage
from drysim.results.stored import (
    OPTIONAL_COLUMNS,
    describe_metrics,
    metric_columns,
    metric_tables,
)
from drysim.study.summary import from_fields

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole


def stored_warnings(fields: Mapping[str, Any]) -> list[WarningMessage]:
    """Return the warnings in drysim.json.

    Raises
    ------
    ValueError
        When one is not text.
    """
    warnings = [WarningMessage(each["slug"], each["sentence"]) for each in fields["warnings"]]
    for warning in warnings:
        if not isinstance(warning.slug, str) or not isinstance(warning.sentence, str):
            raise ValueError(f"no warning: {warning.sentence!r}")
    return warnings


def show_stored(fields: Mapping[str, Any], console: AnyConsole) -> None:
    """Show the summary in drysim.json, and all metrics.

    Raises
    ------
    ValueError
        When it has a value of a wrong type.
    """
    print_labelled(console, "command", str(fields["command"]) or "none: written from Python")
    print_line(console)
    print_summary(console, from_fields(fields["summary"]))
    if description := describe_metrics(fields):
        print_line(console)
        print_labelled(console, "metrics", description)
    # Of several seeds the plain metrics are means; `ensemble` has their scatter, too.
    for approach, metrics in metric_tables(fields.get("ensemble", fields)["metrics"]):
        if not (columns := metric_columns(metrics)):
            continue
        if approach:
            print_line(console)
            print_line(console, (f"  {approach}", "bold"))
        print_table(console, columns, ("metric", "unit"), OPTIONAL_COLUMNS)
