"""Outcome: what one case gives, as plain values, its exit code, and a line about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drysim.errors import EXIT_CHECK_FAILED, EXIT_NUMERICS_FAILED, EXIT_OK, WarningMessage
from drysim.wording import format_count, format_length, format_number, join_words, length_unit

if TYPE_CHECKING:
    from drysim.approach.solution import Events, Response
    from drysim.metrics.checks import Verdict
    from drysim.metrics.spectra import Spectra
    from drysim.metrics.stroke import Values
    from drysim.metrics.table import Metrics
    from drysim.scenario.model import Scenario


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
    warnings: tuple[WarningMessage, ...] = ()
    spectra: Spectra | None = None

    @property
    def events(self) -> Events:
        """Stops, break-aways and reversals in the order of time."""
        return self.response.events

    def __repr__(self) -> str:
        """Give what came out, in a line."""
        verdicts, many = (
            count_verdicts(self.checks, self.warnings),
            format_count(len(self.events), "event"),
        )
        return format_repr(
            "Outcome", self.scenario.name, format_metrics(self.metrics), many, verdicts
        )

    def exit_code(self, strict: bool = False) -> int:
        """Give 0, or 1 when a check failed; `strict` counts a warning as a failed check."""
        return exit_code(self.checks, self.warnings, strict)


def exit_code(
    checks: Sequence[Verdict],
    warnings: Sequence[WarningMessage],
    strict: bool,
    lost: bool = False,
) -> int:
    """Give 3 when a case was lost, 1 when a check failed, else 0.

    `strict` counts a warning as a failed check, and a check that was not judged.
    """
    if lost:
        return EXIT_NUMERICS_FAILED
    wanted = (True,) if strict else (True, None)
    failed = not all(verdict.passed in wanted for verdict in checks)
    return EXIT_CHECK_FAILED if failed or (strict and warnings) else EXIT_OK


# An answer in a line or two, as a notebook or a debugger shows it.

KEY_RATIOS = ("T_a", "SEAT", "T_x")
"""The metrics that are told beside the stroke, where they are known."""


def format_metrics(metrics: Metrics) -> str:
    """Give the metrics that people ask for first."""
    known = [
        f"{name} {format_number(metrics[name])}"
        for name in KEY_RATIOS
        if metrics.get(name) is not None
    ]
    return ", ".join([*known, f"peak |x_r| {format_length(metrics.get('x_r_peak'))}"])


def format_metric_ranges(ends: Mapping[str, tuple[float, float]]) -> str:
    """Give what the same metrics lie between, SI, by name."""
    parts = [f"{name} {_format_range(ends[name])}" for name in KEY_RATIOS if name in ends]
    if "x_r_peak" in ends:
        low, high = ends["x_r_peak"]
        factor, sign = length_unit(high)
        parts.append(f"peak |x_r| {_format_range((low * factor, high * factor))} {sign}")
    return ", ".join(parts)


def _format_range(ends: tuple[float, float]) -> str:
    low, high = (format_number(end, digits=3) for end in ends)
    return low if low == high else f"{low} to {high}"


def count_verdicts(checks: Sequence[Verdict], warnings: Sequence[WarningMessage]) -> str:
    """Give how many checks hold, are not judged, and how many warnings there are, if any."""
    passed = sum(verdict.passed is True for verdict in checks)
    left = sum(verdict.passed is None for verdict in checks)
    parts = [f"{passed} of {format_count(len(checks), 'check')} held"] * bool(checks)
    parts += [f"{left} not judged"] * bool(left)
    parts += [format_count(len(warnings), "warning")] * bool(warnings)
    return join_words(parts) if parts else ""


def format_repr(what: str, name: str, *parts: str) -> str:
    """Give the line: what it is, the scenario's name, and the parts that say something."""
    return f"<{what} of {name}: {'; '.join(filter(None, parts))}>"
