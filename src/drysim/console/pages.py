"""Pages of the manual, and explanations of words, in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from io import StringIO
from typing import TYPE_CHECKING, ClassVar

from drysim.console import terminal
from drysim.manual import SECTIONS, Page, for_terminal, pages
from drysim.manual.words import GROUPS, KEY, Entry, entries, known_entries

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.markdown import Markdown

    from drysim.console.terminal import AnyConsole


def show_page(page: Page) -> None:
    """Show a page: set by rich at a terminal, as Markdown in a pipe."""
    text, console = for_terminal(page), terminal.stdout()
    if isinstance(console, terminal.PlainConsole):
        terminal.print_stdout(text.rstrip("\n"))
        return
    width = min(console.width, terminal.MAX_WIDTH)
    console.print(folding_markdown(text), width=width, soft_wrap=False)


def folding_markdown(text: str) -> Markdown:
    """Return Markdown whose tables fold long words, such as names of tests; rich cuts them."""
    from rich.markdown import Markdown, TableElement
    from rich.table import Table

    class FoldingTable(TableElement):
        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            for table in super().__rich_console__(console, options):
                if isinstance(table, Table):
                    for column in table.columns:
                        column.overflow = "fold"
                yield table

    class FoldingMarkdown(Markdown):
        elements: ClassVar = {**Markdown.elements, "table_open": FoldingTable}

    return FoldingMarkdown(text)


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
        A key of scenarios, a metric, symbol, column, warning, law, command, option, standard
        or another word that `drysim explain --list` shows.

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


def show_entries(meanings: Iterable[Entry], console: AnyConsole) -> None:
    """Show what a word means; several meanings follow each other."""
    for i, entry in enumerate(meanings):
        if i:
            terminal.print_line(console)
        unit = f" [{entry.unit}]" if entry.unit and entry.unit not in "-–" else ""
        kind = f"{entry.kind}, {entry.type}" if entry.type else entry.kind
        terminal.print_line(console, f"{entry.word}{unit}: {kind}")
        terminal.print_paragraph(console, "  ", entry.text)
        described = any(meaning for _, meaning in entry.choices)
        facts = {
            "default": entry.default,
            "choices": "" if described else ", ".join(name for name, _ in entry.choices),
            "keys": ", ".join(entry.keys),
            "where": entry.where,
        }
        for name, fact in facts.items():
            if fact:
                terminal.print_paragraph(console, f"  {name + ':':<9}", fact)
        if described:
            terminal.print_line(console, "  choices:")
            width = 2 + max(len(name) for name, _ in entry.choices)
            for name, meaning in entry.choices:
                terminal.print_paragraph(console, f"    {name:<{width}}", meaning)
        if entry.example:
            terminal.print_paragraph(console, "  example: ", entry.example)


def list_words() -> None:
    """Show the words that `explain` knows, by group; of keys the blocks and their keys."""
    console = terminal.stdout()
    for group, kinds in GROUPS.items():
        members = [entry for entry in entries() if entry.kind in kinds]
        names = [entry.word for entry in members if KEY not in kinds or "." not in entry.word]
        terminal.print_line(console, group)
        terminal.print_paragraph(console, "  ", ", ".join(dict.fromkeys(names)))
    terminal.print_line(console)
    count = sum(entry.kind == KEY and "." in entry.word for entry in entries())
    text = f"and {count} keys in blocks: `drysim explain oscillator` lists those of a block"
    terminal.print_paragraph(console, "", text)
