"""Summary of a fit: measurement, fitted values with intervals, errors, laws."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drysim import wording
from drysim.console.summaries import SummaryRow, show_summary
from drysim.scenario.fit import CHANNEL_UNITS
from drysim.study.fit import (
    EXACT,
    ChannelFit,
    FitResult,
    Parameter,
    format_profile_interval,
)
from drysim.wording import format_count, format_number, format_percent, format_unit, short_key

VALUE_WIDTH = 14
"""Width of the fitted values."""


def show_fit(result: FitResult, folder: Path | None = None) -> None:
    """Show the summary of a fit: what was measured, fitted values, verdicts, warnings."""
    groups, fault = [quality_rows(result), law_rows(result)], None
    if result.is_useless:
        fault = "✗ fit", "the fitted motion is not the measured one: its values mean nothing"
    else:
        groups.insert(0, parameter_rows(result))
    show_summary(result, fit_scene(result), groups, VALUE_WIDTH, folder, fault=fault)


def fit_scene(result: FitResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was measured, and what was fitted to it."""
    found, fit = result.measurement, result.source.fit
    assert fit is not None, "a fit has a fit block"
    names = ", ".join(channel.name for channel in result.channels)
    count = format_count(len(found.t), "sample")
    rate = format_number(1.0 / found.dt, "Hz")
    yield "measured", f"{names} of {wording.sanitise(fit.measured.file)}, {count} at {rate}"
    end = format_number(result.fitted_end, "s")
    held_out = len(found.t) - len(result.selected)
    rest = f"; the rest, {format_count(held_out, 'sample')}, is held out" if held_out else ""
    left = len(result.selected) - int(result.selected.sum())
    events = f", without {format_count(left, 'sample')} next to events" if left else ""
    yield "fitted", f"up to {end}{events}{rest}"
    if fit.measured.is_rig:
        force = "; the force contains those of spring and damper" * result.spring_in_force
        yield "motion", f"imposed, as on a friction rig{force}"
    else:
        yield "base", result.source.excitation.describe(result.motion)
    started = [one for one in result.parameters if one.key in result.source.unstated_start]
    if started and result.source.excitation.kind != "rest":
        yield "start", "in mid-motion; its state is fitted, too"
    if result.is_useless:
        return
    known = result.scenario
    yield from wording.describe_scene(known, known.oscillator.plant(), known.law())


def parameter_rows(result: FitResult) -> Iterator[SummaryRow]:
    """Yield the fitted values with their intervals."""
    keys = [one.key for one in result.parameters]
    for one in result.parameters:
        name = short_key(one.key, keys)
        value = "–" if one.note else format_fitted(one, one.value)
        yield SummaryRow(name, value, describe_interval(one))


def format_fitted(one: Parameter, value: float) -> str:
    """Return a value of a parameter with its unit, to the digits that its deviation allows."""
    digits = 4
    if one.deviation and value:
        digits = min(max(2 + len(f"{abs(value) / one.deviation:.0f}"), 3), 10)
    return f"{format_number(value, digits=digits)} {format_unit(one.unit)}".strip()


def describe_interval(one: Parameter) -> str:
    """Describe the 95 % interval of a parameter."""
    if one.note:
        return "not determined, see the warning"
    interval = format_profile_interval(one, 1)
    if one.bound is not None:
        ends = [end for end in (one.profile_low, one.profile_high) if end is not None]
        differ = [end for end in ends if abs(end - one.bound) > EXACT * abs(end)]
        return f"at its bound, 95 %: {interval}" if differ else "at its bound"
    if one.deviation is None or not one.value:
        return f"95 %: {interval}"
    if one.profile_low is None or one.profile_high is None:
        return f"95 %: {interval}"
    share = max(one.value - one.profile_low, one.profile_high - one.value) / abs(one.value)
    if share < EXACT:
        return "to rounding"
    if share >= 1.0:  # a share of a value that may be zero means nothing
        return f"95 %: {interval}"
    return f"95 %: {interval} (±{format_number(100.0 * share, '%', 2)})"


def quality_rows(result: FitResult) -> Iterator[SummaryRow]:
    """Yield errors, noise, starts and correlations."""
    for channel in result.channels:
        yield SummaryRow(
            f"error {channel.name}", format_percent(channel.error), _describe_error(channel)
        )
        if channel.offset is not None:
            unit = CHANNEL_UNITS[channel.name]
            yield SummaryRow(f"offset {channel.name}", format_number(channel.offset, unit))
    if result.is_useless:
        return
    agree, total = result.starts
    yield SummaryRow("starts", f"{agree} of {total}", "led to this solution")
    keys = [one.key for one in result.parameters]
    for a, b, value in result.correlations:
        both = f"of {short_key(a, keys)} and {short_key(b, keys)}"
        yield SummaryRow("correlation", f"{value:.3f}", both)


def _describe_error(channel: ChannelFit) -> str:
    """Describe the error on held-out data and the noise."""
    parts = []
    if channel.error_held_out is not None:
        parts.append(f"held out {format_percent(channel.error_held_out)}")
    if channel.error > EXACT:
        noise = format_number(channel.noise, CHANNEL_UNITS[channel.name], 3)
        parts.append(f"residuals {noise} RMS beside events")
    return "; ".join(parts)


def law_rows(result: FitResult) -> Iterator[SummaryRow]:
    """Yield the compared laws, the one that was taken first."""
    for score in result.laws:
        held_out = score.error_held_out is not None
        error = score.error_held_out if held_out else score.error
        remark = f"on {'held-out' if held_out else 'fitted'} data"
        if score is result.laws[0]:
            remark += "; taken"
            if score.tied:
                remark += ", as the simplest of those that cannot be told apart"
        elif score.tied:
            remark += "; cannot be told apart from the law taken"
        yield SummaryRow(f"law {score.law}", f"error {format_percent(error)}", remark)
