"""The commands `manual` and `explain`."""

from __future__ import annotations

from typing import Annotated

import typer

from drysim.cli import options
from drysim.cli.process import tolerate_closed_pipe
from drysim.errors import EXIT_OK, UsageError

Name = Annotated[
    str | None,
    typer.Argument(
        metavar="PAGE", autocompletion=options.complete_pages, help="Page; default: symbols."
    ),
]
List = Annotated[bool, typer.Option("--list", help="List the pages.")]
Word = Annotated[
    str,
    typer.Argument(
        metavar="WORD",
        autocompletion=options.complete_words,
        help="Scenario key, metric, symbol, column, warning, exit code, approach, law, event.",
    ),
]


def manual(name: Name = None, listed: List = False) -> int:
    """Show a page of the manual."""
    from drysim.console.pages import list_pages, show_page
    from drysim.manual import FIRST, pages

    known = pages()
    if name is not None and name not in known:
        from difflib import get_close_matches

        close = get_close_matches(name, known, 1)
        hint = f"did you mean `{close[0]}`? " if close else ""
        raise UsageError(f"no page `{name}` in the manual", f"{hint}see `drysim manual --list`")
    with tolerate_closed_pipe():
        if listed:
            list_pages()
        else:
            show_page(known[name or FIRST])
    return EXIT_OK


def explain(word: Word) -> int:
    """Explain a word: key, metric, symbol, column, warning, law."""
    from drysim.console.pages import show_entries
    from drysim.manual.words import explain as meanings
    from drysim.manual.words import similar

    found = meanings(word)
    if not found:
        close = ", ".join(f"`{other}`" for other in similar(word))
        hint = (
            f"did you mean {close}?" if close else "`drysim manual symbols` lists the symbols"
        )
        raise UsageError(f"nothing is known about `{word}`", hint)
    with tolerate_closed_pipe():
        show_entries(found)
    return EXIT_OK
