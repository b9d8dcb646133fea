"""A fit to a measurement: its files, fields, pictures and summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.core.model import Sines
from drysim.manual.words import FIT as FIT_WORD
from drysim.metrics.table import METRICS_BY_NAME
from drysim.metrics.text import (
    describe_main_numbers,
    format_value,
    format_with_interval,
    label_of,
)
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, judgements, write_scenario
from drysim.results.tables import (
    COLUMN_UNITS,
    FLAGS,
    column_header,
    format_cell,
    format_rows,
    format_words,
    join_cells,
    quote_cell,
    write_csv,
)
from drysim.scenario.draws import DRAWS_FILE
from drysim.scenario.fit import CHANNEL_UNITS, Curve
from drysim.scenario.text import describe_scene, short_key
from drysim.study.fit import FitResult, MetricInterval, format_profile_interval
from drysim.study.fit_curves import format_level
from drysim.study.fit_law import EXACT, ChannelFit, Parameter
from drysim.study.fit_spectrum_curves import signal_rms
from drysim.study.summary import BAD, Note, Row, Summary
from drysim.wording import (
    format_count,
    format_number,
    format_percent,
    format_quantity,
    format_range,
    join_words,
)

if TYPE_CHECKING:
    from drysim.results.fields import Fields, Provenance

VALUE_WIDTH = 14
"""Width of the fitted values."""


def summarise(result: FitResult) -> Summary:
    """Return the summary of a fit."""
    faults: tuple[Note, ...] = ()
    groups = [tuple(quality_rows(result)), tuple(law_rows(result))]
    if result.is_useless:
        sentence = "the fitted motion is not the measured one: its values mean nothing"
        faults = (Note("✗ fit", sentence, BAD),)
    else:
        groups[:0] = [tuple(parameter_rows(result)), tuple(metric_rows(result))]
    return Summary(
        name=wording.sanitise(result.source.name),
        about=result.source.about,
        scene=tuple(fit_scene(result)),
        faults=faults,
        groups=groups,
        width=VALUE_WIDTH,
        checks=judgements(result.checks),
        answer=tuple(answers(result)),
    )


def answers(result: FitResult) -> Iterator[str]:
    """Yield the errors of a fit, and the metrics of the fitted motion."""
    for name in ("fit_error", "fit_error_held_out"):
        if (error := result.metrics.get(name)) is not None:
            yield f"{name} {format_percent(error)}: {METRICS_BY_NAME[name].about}."
    if not result.is_useless:
        base = f"At {', '.join(base_of_metrics(result))}: " if result.curves else ""
        yield base + describe_main_numbers(result.metrics)


def base_of_metrics(result: FitResult) -> tuple[str, ...]:
    """Return frequency, of a sine, and level of the base for which curves have metrics."""
    motion = result.motion
    if isinstance(motion, Sines):
        level = format_number(motion.A[0] / sqrt(2.0), "m/s² RMS")
        return format_number(motion.f[0], "Hz"), level
    return (format_number(signal_rms(motion), "m/s² RMS"),)


def fit_scene(result: FitResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was measured, and what was fitted to it."""
    measurement, fit = result.measurement, result.source.fit
    assert fit is not None, "a fit has a fit block"
    if result.curves:
        yield from curve_scene(result)
        return
    names = ", ".join(channel.name for channel in result.channels)
    count = format_count(len(measurement.t), "sample")
    rate = format_number(1.0 / measurement.dt, "Hz")
    yield "measured", f"{names} of {wording.sanitise(fit.response.file)}, {count} at {rate}"
    end = format_number(result.fitted_end, "s")
    held_out = len(measurement.t) - len(result.selected)
    rest = f"; the rest, {format_count(held_out, 'sample')}, is held out" if held_out else ""
    left = len(result.selected) - int(result.selected.sum())
    events = f", without {format_count(left, 'sample')} next to events" if left else ""
    yield "fitted", f"up to {end}{events}{rest}"
    if fit.is_rig:
        force = "; the force contains those of spring and damper" * result.spring_in_force
        yield "motion", f"imposed, as on a friction rig{force}"
    else:
        yield "base", result.source.excitation.describe(result.motion)
    started = [
        parameter
        for parameter in result.parameters
        if parameter.key in result.source.unstated_start
    ]
    if started and result.source.excitation.kind != "rest":
        yield "start", "in mid-motion; its state is fitted, too"
    if result.is_useless:
        return
    scenario = result.scenario
    yield from describe_scene(scenario, scenario.oscillator.plant(), scenario.law())


def curve_scene(result: FitResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: the measured curves, and what was fitted to them."""
    fit, curves = result.source.fit, result.curves
    assert fit is not None, "a fit has a fit block"
    ratios = join_words([*dict.fromkeys(curve.ratio for curve in curves)])
    files = join_words([*dict.fromkeys(each.file for each in result.inputs)])
    count = format_count(sum(len(curve.measured) for curve in curves), "value")
    yield "measured", f"{ratios} of {wording.sanitise(files)}, {count}"
    levels = describe_levels(fit.curves or ())
    ends = [float(f) for curve in curves for f in curve.frequency[[0, -1]]]
    band = format_range(min(ends), max(ends), "Hz")
    excitation, scatter = result.source.excitation, result.scatter
    motion = "sines"
    if scatter is not None:
        motion = f"{excitation.kind} {excitation.parameters()}".strip()
    yield "base", f"{motion} of {levels}, {band}"
    left = len(result.selected) - int(result.selected.sum())
    outliers = f", without {format_count(left, 'outlier')}" if left else ""
    at_rest = (result.source.start.x_r, result.source.start.v_r) == (0.0, 0.0)
    start = "from rest" if at_rest else "from the stated start"
    if scatter is None:
        yield "fitted", f"the steady motion {start}{outliers}"
    else:
        names = join_words([*dict.fromkeys(curve.estimator for curve in fit.curves or ())])
        length = format_number(scatter.simulated, "s")
        last = scatter.first_seed + scatter.signals - 1
        yield (
            "fitted",
            (
                f"{names} over {length} of motion at each level, seeds {scatter.first_seed} to "
                f"{last}{outliers}"
            ),
        )
    if not result.is_useless:
        scenario = result.scenario
        yield from describe_scene(scenario, scenario.oscillator.plant(), scenario.law())


def describe_levels(curves: Sequence[Curve]) -> str:
    """Return the levels of curves, those of one kind together: `0.5 and 1 m/s² RMS`."""
    values: dict[str, list[float]] = {}
    for curve in curves:
        key, value = curve.level
        values.setdefault(key, []).append(value)
    named = {
        key: join_words([format_number(value) for value in dict.fromkeys(several)])
        for key, several in values.items()
    }
    return join_words([format_level(key, listed) for key, listed in named.items()])


def parameter_rows(result: FitResult) -> Iterator[Row]:
    """Yield the fitted values with their intervals."""
    keys = [parameter.key for parameter in result.parameters]
    for parameter in result.parameters:
        name = short_key(parameter.key, keys)
        shown = parameter.displayed
        value = "–" if parameter.note else format_fitted(shown, shown.value)
        yield Row(name, value, describe_interval(shown))


def metric_rows(result: FitResult) -> Iterator[Row]:
    """Yield metrics of the fitted motion with their intervals; the first says if none is known.

    The digits are those in which the ends of the interval differ.
    """
    if result.curves:
        first, *level = base_of_metrics(result)
        base = "sine" if level else "signal"
        yield Row("at", first, ", ".join([*level, f"the {base} of `excitation`"]))
    unknown = f"95 %: not known: {result.draws.reason}" if result.draws.reason else ""
    for name, value, low, high in result.motion_intervals:
        if low is None or high is None:
            yield Row(label_of(name), format_value(name, value), unknown)
            unknown = ""
            continue
        shown, interval = format_with_interval(name, value, low, high)
        remark = _with_accuracy(f"95 %: {interval}", value, low, high)
        yield Row(label_of(name), shown, remark)


MAX_LOPSIDED = 2.0
"""Ratio of the two sides of an interval beyond which one ± would mislead."""


def _with_accuracy(interval: str, value: float, low: float, high: float) -> str:
    """Return an interval with its half-width relative to the value, where that says enough."""
    small, large = sorted((value - low, high - value))
    share = large / (abs(value) or 1.0)
    if share < EXACT:
        return "to rounding"
    # A share of a value that may be zero means nothing.
    if share >= 1.0 or large > MAX_LOPSIDED * small:
        return interval
    return f"{interval} (±{format_number(100.0 * share, '%', 2)})"


def format_fitted(parameter: Parameter, value: float) -> str:
    """Return a value of a parameter with its unit, to the digits that its deviation allows."""
    digits = 4
    if parameter.deviation and value:
        digits = min(max(2 + len(f"{abs(value) / parameter.deviation:.0f}"), 3), 10)
    return format_number(value, parameter.unit, digits)


def describe_interval(parameter: Parameter) -> str:
    """Describe the 95 % interval of a parameter."""
    if parameter.note:
        return "not determined, see the warning"
    interval = format_profile_interval(parameter, 1)
    if parameter.bound is not None:
        ends = [
            end for end in (parameter.profile_low, parameter.profile_high) if end is not None
        ]
        differ = [end for end in ends if abs(end - parameter.bound) > EXACT * abs(end)]
        return f"at its bound, 95 %: {interval}" if differ else "at its bound"
    if parameter.deviation is None or not parameter.value:
        return f"95 %: {interval}"
    if parameter.profile_low is None or parameter.profile_high is None:
        return f"95 %: {interval}"
    return _with_accuracy(
        f"95 %: {interval}", parameter.value, parameter.profile_low, parameter.profile_high
    )


def quality_rows(result: FitResult) -> Iterator[Row]:
    """Yield errors, noise, starts and correlations."""
    for channel in result.channels:
        yield Row(
            f"error {channel.name}", format_percent(channel.error), _describe_error(channel)
        )
        if channel.offset is not None:
            unit = CHANNEL_UNITS[channel.name]
            yield Row(f"offset {channel.name}", format_quantity(channel.offset, unit))
    if result.is_useless:
        return
    if (noise := result.base_noise) is not None and noise.level > 0.0:
        source = "stated" if noise.is_stated else "estimated"
        remark = f"of the base, {source}; the intervals contain it"
        yield Row("noise u_dd", format_number(noise.level, "m/s²", 3), remark)
    if result.scatter is not None and not result.scatter.is_stated:
        time = result.scatter.measured
        length = "small" if time is None else f"as of {format_number(time, 's', 2)}"
        yield Row("scatter", length, "of the estimates; the intervals contain it")
    agree, total = result.starts
    yield Row("starts", f"{agree} of {total}", "led to this solution")
    keys = [parameter.key for parameter in result.parameters]
    for a, b, value in result.correlations:
        both = f"of {short_key(a, keys)} and {short_key(b, keys)}"
        yield Row("correlation", f"{value:.3f}", both)


def _describe_error(channel: ChannelFit) -> str:
    """Describe the error on held-out data and the noise."""
    parts = []
    if channel.error_held_out is not None:
        parts.append(f"held out {format_percent(channel.error_held_out)}")
    if channel.error > EXACT and channel.name not in CHANNEL_UNITS:  # of curves
        parts.append(f"noise {format_percent(channel.noise)} of each value")
    elif channel.error > EXACT:
        noise = format_quantity(channel.noise, CHANNEL_UNITS[channel.name], 3)
        parts.append(f"residuals {noise} RMS beside events")
    return "; ".join(parts)


def law_rows(result: FitResult) -> Iterator[Row]:
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
        yield Row(f"law {score.law}", f"error {format_percent(error)}", remark)


FIT_COLUMNS = (
    "key", "unit", "value", "deviation", "low", "high", "profile_low", "profile_high", "note",
)  # fmt: skip
"""Columns of fit.csv; each row has a unit of its own."""

FIT_NUMBERS = FIT_COLUMNS[2:8]
"""Columns of numbers in fit.csv."""


def write_fit_csv(result: FitResult, file: Path) -> None:
    """Write fit.csv: the fitted values, and metrics of their motion, with 95 % intervals."""
    rows = [
        [quote_cell(parameter.key), quote_cell(parameter.unit)]
        + [format_cell(getattr(parameter, name)) for name in FIT_NUMBERS]
        + [quote_cell(parameter.note)]
        for parameter in (*result.parameters, *map(as_parameter, result.motion_intervals))
    ]
    write_csv(file, FIT_COLUMNS, [join_cells(rows)])


def as_parameter(interval: MetricInterval) -> Parameter:
    """Return the row of a metric in fit.csv."""
    name, value, low, high = interval
    return Parameter(name, COLUMN_UNITS[name], value, None, low, high, None, None)


def write_draws_csv(result: FitResult, file: Path) -> None:
    """Write draws.csv: joint draws of the fitted values with metrics of their motions."""
    draws = result.draws
    if not len(draws.values):
        return
    units = dict(zip(draws.keys, draws.units, strict=True))
    columns = dict(zip(draws.keys, draws.values.T, strict=True)) | dict(draws.metrics)
    headers = [column_header(name, units.get(name)) for name in columns]
    write_csv(file, headers, [format_rows(columns.values())])


CURVE_COLUMNS = (
    "ratio", "a_u", "frequency", "measured", "fitted", "residual", "stuck_share",
)  # fmt: skip
"""Columns of curves.csv."""


def write_curves_csv(result: FitResult, file: Path) -> None:
    """Write curves.csv of a fit to curves: each value as measured and as fitted."""
    if not result.curves:
        return
    rows = [
        [quote_cell(curve.ratio), *map(format_cell, map(float, numbers))]
        for curve in result.curves
        for numbers in zip(
            curve.rms, curve.frequency, curve.measured, curve.fitted,
            curve.measured - curve.fitted, curve.stuck, strict=True,
        )
    ]  # fmt: skip
    units = ("", "m/s2", "Hz", "-", "-", "-", "-")
    header = [
        f"{name} [{unit}]" if unit else name
        for name, unit in zip(CURVE_COLUMNS, units, strict=True)
    ]
    write_csv(file, header, [join_cells(rows)])


def write_residuals_csv(result: FitResult, file: Path) -> None:
    """Write residuals.csv: each channel as measured and as fitted, and which samples count."""
    if result.curves:
        return
    measurement, columns = result.measurement, {"t [s]": result.measurement.t}
    for channel in result.channels:
        name, unit = channel.name, COLUMN_UNITS[channel.name]
        measured = measurement.channels[name]
        fitted = result.prediction.channels[name] + (channel.offset or 0.0)
        columns[f"{name} [{unit}]"] = measured
        columns[f"{name}_fitted [{unit}]"] = fitted
        columns[f"{name}_residual [{unit}]"] = measured - fitted
    selected = np.zeros(len(measurement.t), dtype=bool)
    selected[: len(result.selected)] = result.selected
    held_out = np.arange(len(measurement.t)) >= len(result.selected)
    cells = [format_words(FLAGS, flags) for flags in (selected, held_out)]
    rows = format_rows([*columns.values(), *cells])
    write_csv(file, [*columns, "selected [-]", "held_out [-]"], [rows])


def base_noise_fields(result: FitResult) -> Fields | None:
    """Return the noise of the base record that the intervals contain; None without a record."""
    noise = result.base_noise
    return noise and {"u_dd": noise.level, "stated": noise.is_stated}


def fit_fields(result: FitResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a fit."""
    agree, total = result.starts
    numerics = {
        "method": "least squares on the exact motion",
        "step": result.measurement.dt,
        "samples": len(result.measurement.t),
        "selected": int(result.selected.sum()),
        "held_out_from": result.fitted_end,
        "starts": {"total": total, "agree": agree},
    }
    if result.curves:
        numerics["method"] = "least squares on periodic orbits"
        if result.scatter is not None:
            numerics["method"] = "least squares on spectra of the exact motion"
        del numerics["step"], numerics["held_out_from"]
    fields = {
        "parameters": [parameter._asdict() for parameter in result.parameters],
        "correlations": [
            {"keys": [a, b], "correlation": value} for a, b, value in result.correlations
        ],
        "channels": [channel._asdict() for channel in result.channels],
        "base_noise": base_noise_fields(result),
        "scatter": result.scatter and result.scatter._asdict(),
        "laws": [score._asdict() for score in result.laws],
        "motion": [interval._asdict() for interval in result.motion_intervals],
        "draws": {
            "count": len(result.draws.values),
            "effective": result.draws.effective,
            "reason": result.draws.reason,
        },
    }
    return stored_fields(
        result, result.motion, numerics, result.metrics, provenance, fit=fields
    )


FITTED_FILE = "fitted.yaml"
"""The scenario with the values that a fit found."""

FIT = Kind(
    name="fit",
    what="a fit",
    files=(
        File("fit.csv", write_fit_csv, numbers=FIT_NUMBERS),
        File("residuals.csv", write_residuals_csv),
        File(DRAWS_FILE, write_draws_csv),
        File("curves.csv", write_curves_csv),
        File(FITTED_FILE, lambda result, file: write_scenario(result.scenario, file)),
    ),
    pictures=(
        Picture(
            "fit", "fit.draw_fit", "Measured and fitted motion, and the residuals between them"
        ),
        Picture(
            "profiles",
            "fit.draw_profiles",
            "Rise of the sum of squares over each fitted value",
            fits_axes=True,
        ),
    ),
    fields=fit_fields,
    summary=summarise,
    scenario=lambda result: result.source,
    legend=FIT_WORD,
)
