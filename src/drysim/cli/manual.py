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
ListWords = Annotated[bool, typer.Option("--list", help="List the words, by group.")]
Word = Annotated[
    str | None,
    typer.Argument(
        metavar="WORD",
        autocompletion=options.complete_words,
        help=(
            "Scenario key, metric, symbol, column, warning, exit code, approach, law, event, "
            "option, standard, word of a summary."
        ),
    ),
]


def manual(name: Name = None, listed: List = False) -> int:
    """Show a page of the manual."""
    from drysim.console.pages import list_pages, show_page
    from drysim.manual import FIRST, pages

    all_pages = pages()
    if name is not None and name not in all_pages:
        from drysim.messages import closest_match, did_you_mean

        hint = did_you_mean(closest_match(name, all_pages))
        sentence = f"no page `{name}` in the manual{hint}"
        raise UsageError(sentence, "`drysim manual --list` shows all pages")
    with tolerate_closed_pipe():
        if listed:
            list_pages()
        else:
            show_page(all_pages[name or FIRST])
    return EXIT_OK


def explain(word: Word = None, listed: ListWords = False) -> int:
    """Explain a word: key, metric, symbol, column, warning, law."""
    from drysim.console.pages import list_words, show_entries
    from drysim.console.terminal import stdout
    from drysim.manual.words import known_entries

    if word is None and not listed:
        raise UsageError("name a word", "`drysim explain --list` shows all words")
    matches = known_entries(word) if word is not None else []
    with tolerate_closed_pipe():
        if listed:
            list_words()
        show_entries(matches, stdout())
    return EXIT_OK
