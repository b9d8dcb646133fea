"""What a reader of means over many seeds should know: warnings as values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

from drysim.core.plant import Stopped
from drysim.errors import Caution
from drysim.study.cautions import RESIDUAL, energy_open, impacts_left_out
from drysim.study.ensembles.seeds import most, narrow, until_of, width_of
from drysim.study.sweeps.table import FAILED
from drysim.wording import length, number

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.study.case import Case
    from drysim.study.ensembles.statistics import Statistic
    from drysim.study.outcome import Outcome
    from drysim.study.sweeps.table import Row

    Found = Mapping[str, Statistic | None]

OF_ALL = {"energy-open", "stroke-violated", "impacts-left-out"}
"""Warnings about a single seed in whose place stand those about all of them."""


def of_statistic(verdict: Verdict, found: Statistic | None) -> Verdict:
    """Give a verdict with what is known of the mean that it is about."""
    return about_mean(verdict, found.half_width, found.seeds) if found else verdict


def about_mean(verdict: Verdict, half_width: float | None, seeds: int) -> Verdict:
    """Give a verdict with what is known of the mean that it is about, if it applies."""
    if verdict.passed is None:
        return verdict
    return replace(verdict, half_width=half_width, seeds=seeds)


def remarks(
    case: Case, rows: Sequence[Row], found: Found, verdicts: Sequence[Verdict], shown: Outcome
) -> Iterator[Caution]:
    """Give every warning about an ensemble, those of its case first."""
    moves = any((row.metrics.get("stuck_share") or 0.0) < 1.0 for row in rows)
    for caution in case.cautions:
        # It was said of the first seed; another one may do what that does not.
        if not (moves and caution.slug == "will-not-move"):
            yield caution
    yield from failures(rows)
    yield from (caution for caution in shown.warnings if caution.slug not in OF_ALL)
    if case.limit is not None:
        yield from strokes(rows, found, case.limit)
    if isinstance(case.law, Stopped) and case.law.rigid and contacts(found):
        yield impacts_left_out()
    residual = found.get("energy_residual")
    if residual and residual.greatest[0] > RESIDUAL and "energy-open" in slugs(shown):
        yield energy_open(residual.greatest[0])
    yield from wide(case, rows)
    yield from undecided(verdicts)
    if case.scenario.measure.spectra:
        sentence = f"spectra.csv and spectra.png are of seed {rows[0].seed} alone"
        yield Caution("spectra-of-one-seed", sentence)


def slugs(shown: Outcome) -> set[str]:
    """Give the names of the warnings of a run."""
    return {caution.slug for caution in shown.warnings}


def failures(rows: Sequence[Row]) -> Iterator[Caution]:
    """Say with how many seeds the numerics failed, and why with the first of them."""
    lost = [row for row in rows if row.status == FAILED]
    if lost:
        sentence = (
            f"the numerics failed with {len(lost)} of {len(rows)} seeds, which the means leave "
            f"out; the first is seed {lost[0].seed}: {lost[0].note}"
        )
        yield Caution("case-failed", sentence, {"seeds": len(lost)})


def strokes(rows: Sequence[Row], found: Found, limit: float) -> Iterator[Caution]:
    """Say with how many seeds the stroke limit is met, and where the most."""
    beyond = sum(bool(row.metrics.get("violations")) for row in rows)
    most_of_all, hits = found["stroke_suffices"], found.get("impact_speed")
    if beyond and hits and contacts(found):
        fastest, seed = hits.greatest
        sentence = (
            f"the mass comes to its end stops with {beyond} of {len(rows)} seeds, with up to "
            f"{number(fastest, 'm/s')} with seed {seed}"
        )
        numbers = {"impact_speed": fastest, "seed": seed, "seeds": beyond}
        yield Caution("stroke-violated", sentence, numbers)
    elif beyond and most_of_all:
        peak, seed = most_of_all.greatest
        sentence = (
            f"the stroke limit of {length(limit, peak)} is met with {beyond} of {len(rows)} "
            f"seeds; |x_r| reaches {length(peak)} with seed {seed}"
        )
        numbers = {"limit": limit, "x_r_peak": peak, "seed": seed, "seeds": beyond}
        yield Caution("stroke-violated", sentence, numbers)


def contacts(found: Found) -> bool:
    """Tell whether the mass comes to end stops within the window of any seed."""
    hits = found.get("contacts")
    return hits is not None and hits.greatest[0] > 0


def wide(case: Case, rows: Sequence[Row]) -> Iterator[Caution]:
    """Say when the interval is not as narrow as asked after all seeds that there may be."""
    until = until_of(case.scenario)
    if until is None or len(rows) < most(case.scenario) or narrow(case.scenario, rows):
        return
    mean, half_width, known = width_of(rows, until.metric)
    n, name, asked = len(rows), until.metric, number(100 * until.half_width, "%")
    if known < n:
        sentence = f"{name} is known with {known} of {n} seeds only, so until never holds"
        yield Caution("interval-wide", sentence, {"seeds": n, "known": known})
    elif not mean or half_width is None:
        sentence = (
            f"the mean of {name} is 0 after {n} seeds, and no interval is {asked} of that"
        )
        yield Caution("interval-wide", sentence, {"seeds": n})
    else:
        share = half_width / abs(mean)
        needed = ceil(n * (share / until.half_width) ** 2)
        sentence = (
            f"after {n} seeds, the most there may be, the interval of {name} is "
            f"±{number(100 * share, '%', 3)} of its mean, not ±{asked}: "
            f"excitation.seeds: {number(needed, digits=2)} would do"
        )
        yield Caution("interval-wide", sentence, {"half_width": share, "seeds": n})


def undecided(verdicts: Sequence[Verdict]) -> Iterator[Caution]:
    """Say of every check whose limit lies within the interval that it is not decided."""
    for verdict in verdicts:
        if verdict.undecided:
            sentence = (
                f"`{verdict.check}` {'holds' if verdict.passed else 'fails'} by the mean of "
                f"{verdict.seeds} seeds, but the limit lies within its 95 % confidence "
                "interval: only more seeds can decide"
            )
            numbers = {"value": verdict.value or 0.0, "half_width": verdict.half_width or 0.0}
            yield Caution("check-undecided", sentence, numbers)
