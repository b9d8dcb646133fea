"""An answer in a line or two, as a notebook or a debugger shows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from drysim.wording import length, length_unit, listed, number, several

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.errors import Caution
    from drysim.metrics import Metrics

RATIOS = ("T_a", "SEAT", "T_x")
"""The metrics that are told beside the stroke, where they are known."""


def values(metrics: Metrics) -> str:
    """Give the metrics that people ask for first."""
    known = [
        f"{name} {number(metrics[name])}" for name in RATIOS if metrics.get(name) is not None
    ]
    return ", ".join([*known, f"peak |x_r| {length(metrics.get('x_r_peak'))}"])


def spans(ends: Mapping[str, tuple[float, float]]) -> str:
    """Give what the same metrics lie between, SI, by name."""
    told = [f"{name} {_span(ends[name])}" for name in RATIOS if name in ends]
    if "x_r_peak" in ends:
        low, high = ends["x_r_peak"]
        factor, sign = length_unit(high)
        told.append(f"peak |x_r| {_span((low * factor, high * factor))} {sign}")
    return ", ".join(told)


def judged(checks: Sequence[Verdict], warnings: Sequence[Caution]) -> str:
    """Give how many checks hold, are not judged, and how many warnings there are, if any."""
    held = sum(verdict.passed is True for verdict in checks)
    left = sum(verdict.passed is None for verdict in checks)
    told = [f"{held} of {several(len(checks), 'check')} held"] * bool(checks)
    told += [f"{left} not judged"] * bool(left)
    told += [several(len(warnings), "warning")] * bool(warnings)
    return listed(told) if told else ""


def line(what: str, name: str, *parts: str) -> str:
    """Give the line: what it is, the scenario's name, and the parts that say something."""
    return f"<{what} of {name}: {'; '.join(filter(None, parts))}>"


def _span(ends: tuple[float, float]) -> str:
    low, high = (number(end, digits=3) for end in ends)
    return low if low == high else f"{low} to {high}"
