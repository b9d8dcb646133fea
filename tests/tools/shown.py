"""A result on the console, as its command shows it."""

from pathlib import Path

from drysim.console.summary import show_summary
from drysim.results import kind_of


def show(result, folder: Path | None = None):
    """Show a result; `folder` as of `show_summary`."""
    summary = kind_of(result).summary(result)
    complete = getattr(result, "complete", True)
    show_summary(summary, folder if complete else None, result.warnings)
