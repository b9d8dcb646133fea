"""Metrics as text: values in their shown units, intervals over seeds, ranges over cases."""

from __future__ import annotations

from collections.abc import Mapping

from drysim.metrics.table import METRICS_BY_NAME, PEAK_STROKE, SHARE, Metrics
from drysim.wording import (
    SIGNIFICANT_DIGITS,
    UNKNOWN,
    display_unit,
    format_interval,
    format_number,
    format_percent,
    format_range,
    interval_digits,
)

KEY_RATIOS = ("T_a", "SEAT", "T_x")
"""Ratios shown beside the stroke, where they are known."""

MEANINGS = {"T_x": "x_r over u"}
"""What a metric is, said where it is printed without a formula."""

RANGE_DIGITS = 3
"""Significant digits of the ends of a range."""


def label_of(name: str) -> str:
    """Return the label of a metric, e.g. `peak |x_r|`."""
    return METRICS_BY_NAME[name].label


def describe_main_numbers(metrics: Metrics) -> str:
    """Return the most important metrics as a sentence, and what T_a means."""
    sentence = f"{format_metrics(metrics)}."
    if (T_a := metrics.get("T_a")) is None:
        return sentence
    effect = "above 1: its mount amplifies" if T_a > 1 else "below 1: its mount isolates"
    if T_a == 1:
        effect = "1: its mount neither amplifies nor isolates"
    return f"{sentence} T_a of the mass is {effect}."


def format_metric(
    name: str, value: float, half_width: float | None = None, greatest: float | None = None
) -> str:
    """Return a metric with its interval over seeds, in a unit that suits the greatest value."""
    factor, unit = display_unit(METRICS_BY_NAME[name].shown, greatest or value)
    width = None if half_width is None else factor * half_width
    return format_interval(factor * value, width, unit)


def format_with_interval(name: str, value: float, low: float, high: float) -> tuple[str, str]:
    """Return a metric and an interval of it, to the digits in which its ends differ."""
    factor, unit = display_unit(METRICS_BY_NAME[name].shown, value)
    digits = interval_digits(high - low, max(abs(low), abs(high)))
    return (
        format_number(factor * value, unit, digits),
        format_range(factor * low, factor * high, unit, digits),
    )


def format_value(name: str, value: float | None, digits: int = SIGNIFICANT_DIGITS) -> str:
    """Return a metric in its shown unit; a share of time as by `format_percent`."""
    metric = METRICS_BY_NAME[name]
    if value is None:
        return UNKNOWN
    if metric.kind == SHARE:
        return format_percent(value)
    factor, unit = display_unit(metric.shown, value)
    return format_number(factor * value, unit, digits)


def format_labelled(name: str, value: float | None) -> str:
    """Return label and value of a metric, e.g. `peak |x_r| 17.26 mm`."""
    return f"{label_of(name)} {format_value(name, value)}"


def format_metrics(metrics: Metrics) -> str:
    """Return the most important metrics."""
    names = [name for name in KEY_RATIOS if metrics.get(name) is not None]
    return ", ".join(format_labelled(name, metrics.get(name)) for name in (*names, PEAK_STROKE))


def format_metric_range(name: str, ends: tuple[float, float]) -> str:
    """Return the range of a metric over cases, in the unit of its greatest value."""
    low, high = ends
    factor, unit = display_unit(METRICS_BY_NAME[name].shown, high)
    return format_range(factor * low, factor * high, unit, RANGE_DIGITS)


RESIDUAL_OF_ROUNDING = 1e-14
"""Residual of the energy balance below which it is rounding, other on each machine [-]."""


def describe_residual(residual: float | None, end: str = "") -> str:
    """Return the residual of the energy balance as a phrase; `end` says which of many it is."""
    if residual is not None and abs(residual) < RESIDUAL_OF_ROUNDING:
        return f"residual below {RESIDUAL_OF_ROUNDING:g}"
    return f"residual {end}{format_number(residual, digits=2)}"


def format_metric_ranges(ends: Mapping[str, tuple[float, float]]) -> str:
    """Return the ranges of the most important metrics, from (least, greatest) by name."""
    return ", ".join(
        f"{label_of(name)} {format_metric_range(name, ends[name])}"
        for name in (*KEY_RATIOS, PEAK_STROKE)
        if name in ends
    )
