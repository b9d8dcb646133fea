"""Pages of the manual, and explanations of words, in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from io import StringIO
from typing import TYPE_CHECKING

from drysim.console import terminal
from drysim.manual import SECTIONS, Page, for_terminal, pages
from drysim.manual.words import Entry, known_entries

if TYPE_CHECKING:
    from drysim.console.terminal import AnyConsole


def show_page(page: Page) -> None:
    """Show a page: set by rich at a terminal, as Markdown in a pipe."""
    text, console = for_terminal(page), terminal.stdout()
    if isinstance(console, terminal.PlainConsole):
        terminal.print_stdout(text.rstrip("\n"))
        return
    from rich.markdown import Markdown

    console.print(Markdown(text), width=min(console.width, terminal.MAX_WIDTH), soft_wrap=False)


def list_pages() -> None:
    """Show the names and titles of all pages, by section."""
    all_pages = pages()
    width = 2 + max(map(len, all_pages))
    for section, names in SECTIONS.items():
        terminal.print_stdout(section)
        for name in names:
            terminal.print_stdout(f"  {name:<{width}}{all_pages[name].title}")


def explain(word: str) -> str:
    """Return what a word means, as `drysim explain` shows it.

    Parameters
    ----------
    word : str
        A key of scenarios, a metric, symbol, column, warning, law, command or option.

    Returns
    -------
    str
        Its meanings; several follow each other.

    Raises
    ------
    UsageError
        When nothing is known about it; suggests the closest word.
    """
    text = StringIO()
    show_entries(known_entries(word), terminal.PlainConsole(text))
    return text.getvalue().rstrip("\n")


def show_entries(entries: Iterable[Entry], console: AnyConsole) -> None:
    """Show what a word means; several meanings follow each other."""
    for i, entry in enumerate(entries):
        if i:
            terminal.print_line(console)
        unit = f" [{entry.unit}]" if entry.unit and entry.unit not in "-–" else ""
        terminal.print_line(console, f"{entry.word}{unit}: {entry.kind}")
        terminal.print_paragraph(console, "  ", entry.text)
        facts = {"default": entry.default, "where": entry.where, "example": entry.example}
        for name, fact in facts.items():
            if fact:
                terminal.print_paragraph(console, f"  {name + ':':<9}", fact)
