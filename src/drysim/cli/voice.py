"""How a command speaks: in words, by one JSON object, or not at all."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from drysim.cli.streams import reader_may_leave
from drysim.errors import EXIT_INTERRUPTED, EXIT_OK, Caution

if TYPE_CHECKING:
    from drysim.report import Claim


def typed(context: typer.Context) -> str:
    """Give the command line, quoted as for a shell."""
    return shlex.join(["drysim", *context.obj])


class Voice(NamedTuple):
    """What `--json` and `--quiet` leave of the words; faults are shown in any case."""

    as_json: bool
    quiet: bool

    def answer(
        self,
        told: Mapping[str, Any],
        show: Callable[[], None],
        warnings: Sequence[Caution],
        folder: Path | None = None,
        code: int = EXIT_OK,
    ) -> int:
        """Tell what came out, and give the exit code.

        Parameters
        ----------
        told : mapping
            What `--json` prints.
        show : callable
            Says it in words, warnings included.
        warnings : sequence of Caution
            Go to stderr beside the JSON.
        folder : Path, optional
            Where the results are by now; `code` is the exit code of the work.
        """
        from drysim import console, report

        with reader_may_leave(folder, code):
            if self.as_json:
                typer.echo(report.text(told), nl=False)
            elif not self.quiet:
                show()
            elif code not in (EXIT_OK, EXIT_INTERRUPTED):  # of which more was said before
                self._excuse(told, warnings)
            if self.as_json and not self.quiet:
                console.show_warnings(warnings)
        return code

    def _excuse(self, told: Mapping[str, Any], warnings: Sequence[Caution]) -> None:
        """Say on stderr what makes the exit code, where nothing else is said."""
        from drysim import console

        checks = list(console.told_checks(told))
        failed = [words for passed, words in checks if passed is False]
        for words in failed:
            console.remark(f"check failed: {words}")
        if failed:
            return
        for words in (words for passed, words in checks if passed is None):
            console.remark(f"check not judged: {words}")
        console.show_warnings(warnings)

    def plan(
        self, fields: Mapping[str, Any], sentences: Sequence[str], cautions: Sequence[Caution]
    ) -> int:
        """Tell what would be done, and that nothing was."""
        from drysim import console

        def show() -> None:
            console.say("\n".join(sentences))
            console.say(f"would be written to {fields['folder']}")
            console.say("dry run: nothing was computed, nothing was written")
            console.show_warnings(cautions)

        return self.answer({"dry_run": True, **fields}, show, cautions)

    def remark(self, sentence: str) -> None:
        """Say something on stderr while the work goes on."""
        if not self.quiet:
            from drysim import console

            console.remark(sentence)

    @contextmanager
    def claimed(self, folder: Path, resume: bool, what: str) -> Iterator[Claim]:
        """Claim an output folder; say which finished work, `seeds` or `cases`, is given up."""
        from drysim import report

        anew = not resume and report.resumable(folder)
        with report.claim_partial(folder, resume) as claim:
            if anew:
                self.remark(
                    f"beginning anew: the finished {what} in {folder}.partial are given up"
                )
            yield claim
