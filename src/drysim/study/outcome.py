"""Outcome: everything that one case gives, as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK, Caution
from drysim.study.brief import judged, line, values
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.approach.events import Events
    from drysim.approach.response import Response
    from drysim.checks import Verdict
    from drysim.metrics import Values
    from drysim.scenario import Scenario
    from drysim.spectra import Spectra


@dataclass(frozen=True, eq=False)
class Outcome:
    """A case with its response, its metrics, and what is to be said about them.

    Attributes
    ----------
    scenario : Scenario
        What was asked.
    response : Response
        The motion; one repetition of the periodic orbit when the scenario measures steadily.
    metrics : dict
        Value by name, SI; None where a metric is not known.
    checks : tuple of Verdict
        One for every check of the scenario, in its order.
    warnings : tuple of Caution
        Each slug at most once per place, in the order in which they were found.
    spectra : Spectra or None
        Of base and mass, where the scenario asks for them.
    """

    scenario: Scenario
    response: Response
    metrics: Values
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[Caution, ...] = ()
    spectra: Spectra | None = None

    @property
    def events(self) -> Events:
        """Stops, break-aways and reversals in the order of time."""
        return self.response.events

    def __repr__(self) -> str:
        """Give what came out, in a line."""
        kept, many = judged(self.checks, self.warnings), several(len(self.events), "event")
        return line("Outcome", self.scenario.name, values(self.metrics), many, kept)

    def exit_code(self, strict: bool = False) -> int:
        """Give 0, or 1 when a check failed; `strict` counts a warning as a failed check."""
        return exit_code(self.checks, self.warnings, strict)


def exit_code(
    checks: Sequence[Verdict], warnings: Sequence[Caution], strict: bool, lost: bool = False
) -> int:
    """Give 3 when a case was lost, 1 when a check failed, else 0.

    `strict` counts a warning as a failed check, and a check that was not judged.
    """
    if lost:
        return EXIT_NUMERICS_FAILED
    wanted = (True,) if strict else (True, None)
    failed = not all(verdict.passed in wanted for verdict in checks)
    return EXIT_CHECK_FAILED if failed or (strict and warnings) else EXIT_OK
