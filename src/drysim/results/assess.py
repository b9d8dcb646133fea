"""An evaluation of measured records: its files, fields, picture and summary."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.metrics.comfort import EXPOSURE_LIMITS
from drysim.metrics.spectra import MIN_POWER_SHARE, excited_lines
from drysim.metrics.table import METRICS, PEAK_STROKE
from drysim.metrics.text import format_labelled, format_value, label_of
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, clean_up_lines, judgements
from drysim.results.tables import (
    column_header,
    format_cell,
    format_rows,
    join_cells,
    quote_cell,
    write_csv,
)
from drysim.scenario.text import describe_limits, describe_scene
from drysim.study.assess import (
    AGREEING,
    LARGEST,
    AssessResult,
    Run,
    band_of_coherence,
    band_of_H1,
    base_file,
    combine,
    describe_clean_ups,
)
from drysim.study.summary import BAD, GOOD, Grid, Row, Summary
from drysim.wording import (
    format_count,
    format_deviation,
    format_number,
    format_percent,
    format_range,
    join_words,
)

if TYPE_CHECKING:
    from drysim.metrics.table import Metrics
    from drysim.results.fields import Fields, Provenance

VALUE_WIDTH = 11
"""Width of the values."""

SHOWN = "SEAT", "a_w", "VDV", "MTVV", "T_a", "a_u", PEAK_STROKE
"""Metrics in the table of runs, in this order, those that are known."""

HOURS_OF_A_DAY = 24.0


def summarise(result: AssessResult) -> Summary:
    """Return the summary of an evaluation."""
    tables = [grid for grid in (runs_table(result), axes_table(result)) if grid is not None]
    groups = tuple(measured_rows(result)), tuple(exposure_rows(result))
    return Summary(
        name=wording.sanitise(result.scenario.name),
        about=result.scenario.about,
        scene=tuple(assess_scene(result)),
        table=tables[0] if tables else None,
        groups=tuple(filter(None, groups)),
        width=VALUE_WIDTH,
        checks=judgements(result.checks),
        answer=tuple(answers(result)),
        details=tuple(tables[1:]),
    )


def assess_scene(result: AssessResult) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was measured, and with what it is compared."""
    first, scenario, transfer = result.runs[0], result.scenario, result.transfer
    names = [name for name in ("x_dd", "x_r") if name != "x_r" or first.metrics[PEAK_STROKE]]
    files = join_words([wording.sanitise(run.file) for run in result.runs])
    along = f" along {first.axis}" if first.axis else ""
    axes = [run.axis for run in result.others if run.file == first.file]
    besides = f"; also along {join_words(axes)}" if axes else ""
    base = base_file(scenario)
    of_base = f" of {wording.sanitise(base)}" if base else ""
    yield "measured", f"u_dd{of_base}, {', '.join(names)}{along} of {files}{besides}"
    lengths = [run.length for run in result.runs]
    rate = format_number(round(1.0 / first.dt, 6), "Hz")
    settle = scenario.measure.settle
    settled = f", after {format_number(settle, 's')}" if settle else ""
    yield "window", f"{format_range(min(lengths), max(lengths), 's')} at {rate}{settled}"
    yield from clean_up_lines(describe_clean_ups([*result.runs, *result.others]))
    averages = format_number(transfer.averages, digits=3)
    repeating = [wording.sanitise(run.file) for run in result.runs if run.repeats]
    verbs = "repeats a base and adds" if len(repeating) == 1 else "repeat a base and add"
    repeated = f"; {join_words(repeating)} {verbs} none" if repeating else ""
    yield (
        "spectra",
        f"{format_count(transfer.segments, 'segment')} of "
        f"{format_number(transfer.segment, 's', 3)}, half overlapping: {averages} independent "
        f"averages{repeated}",
    )
    if result.model is not None:
        model = describe_scene(scenario, scenario.oscillator.plant(), scenario.law())
        yield "model", "; ".join(text for _, text in model)


def measured_rows(result: AssessResult) -> Iterator[Row]:
    """Yield the measured metrics of all runs."""
    metrics, stroke = result.metrics, result.scenario.stroke
    weights, a_u = result.scenario.measure.weights, format_value("a_u", result.metrics["a_u"])

    def row(name: str, *further: str) -> Row:
        model = (result.model or {}).get(name)
        beside = "" if model is None else f"model {format_value(name, model)}"
        off = f", {difference(result, name)}" if beside else ""
        remark = "; ".join(filter(None, [*further, beside + off]))
        return Row(label_of(name), format_value(name, metrics[name]), remark)

    def listed(*names: str) -> str:
        return ", ".join(format_labelled(name, metrics[name]) for name in names)

    if weights is not None:
        name, k = weights
        yield row("SEAT", listed("SEAT_VDV"))
        how = f"{name}, k {format_number(k)}"
        several = len(result.runs) > 1
        peaks = f"{'largest ' * several}{format_labelled('MTVV', metrics['MTVV'])}"
        crest = f"{'mean ' * several}{format_labelled('crest_factor', metrics['crest_factor'])}"
        yield row("a_w", how, f"{peaks}, {crest}")
        lengths = [run.length for run in result.runs]
        length = format_range(min(lengths), max(lengths), "s")
        of_each = f"the runs last {length}; a dose grows with the length and has no mean here"
        yield row("VDV", of_each if metrics["VDV"] is None else f"in {length}")
    yield row("T_a", f"mass {format_value('a_x', metrics['a_x'])} RMS, base {a_u} RMS")
    if metrics[PEAK_STROKE] is not None:
        used = ""
        if stroke is not None:
            share, peak = format_percent(metrics["stroke_used"]), metrics[PEAK_STROKE]
            used = f"{share} of the stroke limit of {describe_limits(stroke.limits, peak)}"
        yield row(PEAK_STROKE, "largest of the runs" * (len(result.runs) > 1), used)
    yield from transfer_rows(result)
    if len(result.runs) > 1:
        yield agreement_row(result)


def transfer_rows(result: AssessResult) -> Iterator[Row]:
    """Yield the largest transmissibility, and the coherence."""
    transfer = result.transfer
    lines = np.flatnonzero(excited_lines(transfer.G_u))
    if not len(lines):
        return
    size, low, high = np.abs(transfer.H1), *band_of_H1(transfer)
    place = lines[int(np.argmax(size[lines]))]
    band = format_range(float(low[place]), float(high[place]), digits=3)
    frequency = format_number(float(transfer.f[place]), "Hz", 3)
    yield Row(
        "peak |H1|",
        format_number(float(size[place]), digits=4),
        f"at {frequency}, 95 %: {band}",
    )
    coherence = transfer.coherence[lines]
    least = lines[int(np.argmin(coherence))]
    yield Row(
        "coherence",
        format_number(float(np.median(coherence)), digits=3),
        f"median from {format_number(float(transfer.f[lines[0]]), digits=3)} to "
        f"{format_number(float(transfer.f[lines[-1]]), 'Hz', 3)}, where the base PSD is above "
        f"{format_percent(MIN_POWER_SHARE)} of its peak; least "
        f"{format_number(float(coherence.min()), digits=3)} at "
        f"{format_number(float(transfer.f[least]), 'Hz', 3)}",
    )


def agreement_row(result: AssessResult) -> Row:
    """Return whether the runs agree."""
    names = AGREEING[result.scenario.measure.weights is not None]
    deviations = {name: result.deviation(name) for name in names}
    agree = all(
        each is not None and each <= result.agree_within for each in deviations.values()
    )
    listed = join_words([f"{format_percent(each)} in {n}" for n, each in deviations.items()])
    return Row(
        "runs",
        "agree" if agree else "differ",
        f"{format_count(len(result.runs), 'run')}, from their mean by at most {listed}; "
        f"{format_percent(result.agree_within)} permitted",
        GOOD if agree else BAD,
    )


def exposure_rows(result: AssessResult) -> Iterator[Row]:
    """Yield the daily exposure and the hours until the limits of directive 2002/44/EC."""
    if not result.exposures:
        return
    metrics, exposure = result.metrics, result.scenario.measure.exposure
    if exposure is not None:
        hours = format_number(exposure / 3600.0, "h")
        for name in ("A_8", "VDV_day"):
            value = metrics[name] or 0.0
            above = [
                f"above the {limit.name}"
                for limit in EXPOSURE_LIMITS
                if value > (limit.A_8 if name == "A_8" else limit.VDV)
            ]
            remark = f"{hours} a day; {above[-1] if above else 'below the action value'}"
            yield Row(label_of(name), format_value(name, value), remark, BAD if above else "")
    for limit in EXPOSURE_LIMITS:
        by_rms, by_dose = (
            min(each.hours[limit.name][i] for each in result.exposures) for i in (0, 1)
        )
        A_8, VDV = format_value("A_8", limit.A_8), format_value("VDV", limit.VDV)
        remark = (
            f"a day until A(8) reaches {A_8}; {format_hours(by_dose)} until VDV reaches {VDV}"
        )
        yield Row(limit.name, format_hours(by_rms), remark)
    if len(result.exposures) > 1:
        first, *rest = result.exposures
        others = join_words([f"{each.axis} {format_value('a_w', each.a_w)}" for each in rest])
        remark = f"of the highest a_w: {format_value('a_w', first.a_w)}, {others}; k included"
        yield Row("axis", first.axis, remark)


def format_hours(hours: float) -> str:
    """Return hours of a day, in minutes below one."""
    if hours > HOURS_OF_A_DAY:
        return "over 24 h"
    return (
        format_number(60.0 * hours, "min", 2) if hours < 1.0 else format_number(hours, "h", 3)
    )


def answers(result: AssessResult) -> Iterator[str]:
    """Yield the main measured numbers, and whether the runs agree."""
    names = AGREEING[result.scenario.measure.weights is not None]
    yield f"Measured: {', '.join(format_labelled(n, result.metrics[n]) for n in names)}."
    if len(result.runs) > 1:
        row = agreement_row(result)
        yield f"The runs {row.value}: {row.remark}."


def runs_table(result: AssessResult) -> Grid | None:
    """Return the runs side by side, with their mean and the model; None for a single run."""
    if len(result.runs) < 2:
        return None
    names = [name for name in SHOWN if result.metrics[name] is not None]

    def texts(heading: str, metrics: Metrics, several: bool = False) -> list[str]:
        ends = (" max" * (several and name in LARGEST) for name in names)
        values = (format_value(name, metrics[name]) for name in names)
        return [heading, *(value + end for value, end in zip(values, ends, strict=True))]

    stems = [Path(wording.sanitise(run.file)).stem for run in result.runs]
    columns = [
        ["metric", *map(label_of, names)],
        *(texts(stem, run.metrics) for stem, run in zip(stems, result.runs, strict=True)),
        texts("mean", result.metrics, several=True),
        ["deviation", *(format_percent(result.deviation(name)) for name in names)],
    ]
    if result.model is not None:
        columns.append(texts("model", result.model, several=True))
    return Grid(columns, ("metric",), optional=stems, title="The runs side by side")


def difference(result: AssessResult, name: str) -> str:
    """Return the difference of the model from the mean of the runs."""
    measured, model = result.metrics[name], (result.model or {}).get(name)
    if model is None or not measured:
        return "difference unknown"
    return format_deviation(model / measured - 1.0, digits=2)


def axes_table(result: AssessResult) -> Grid | None:
    """Return the axes of a seat side by side; None for a single axis."""
    if not result.others:
        return None
    names = ("SEAT", "a_w", "VDV", "MTVV", "a_u")
    columns = [["metric", *map(label_of, names)]]
    for exposure in sorted(result.exposures, key=lambda each: each.axis):
        runs = [run for run in (*result.runs, *result.others) if run.axis == exposure.axis]
        means = combine(runs)
        columns.append([exposure.axis, *(format_value(name, means[name]) for name in names)])
    return Grid(columns, ("metric",), title="The axes side by side, k included")


ASSESS_COLUMNS = "file", "axis", "source", "length"
"""First columns of assess.csv; the others are metrics."""


def write_assess_csv(result: AssessResult, file: Path) -> None:
    """Write assess.csv: the metrics of every run along every axis, and those of the model."""
    shown = [run.metrics for run in (*result.runs, *result.others)]
    names = [m.name for m in METRICS if any(each[m.name] is not None for each in shown)]

    def cells(run: Run, source: str, metrics: Metrics) -> list[str]:
        texts = map(quote_cell, (run.file, run.axis, source))
        return [*texts, format_cell(run.length), *(format_cell(metrics[n]) for n in names)]

    rows = []
    for run in (*result.runs, *result.others):
        rows.append(cells(run, "measured", run.metrics))
        if run.model is not None:
            rows.append(cells(run, "model", run.model))
    headers = [*ASSESS_COLUMNS[:3], "length [s]", *map(column_header, names)]
    write_csv(file, headers, [join_cells(rows)])


def write_spectra_csv(result: AssessResult, file: Path) -> None:
    """Write spectra.csv: spectra, H1, H2, Hv and coherence with their bands."""
    transfer = result.transfer
    (H1_low, H1_high), (low, high) = band_of_H1(transfer), band_of_coherence(transfer)
    columns = {
        "f [Hz]": transfer.f,
        "G_u [(m/s2)2/Hz]": transfer.G_u,
        "G_x [(m/s2)2/Hz]": transfer.G_x,
        "H1 [-]": np.abs(transfer.H1),
        "phase [rad]": np.angle(transfer.H1),
        "coherence [-]": transfer.coherence,
        "H2 [-]": np.abs(transfer.H2),
        "Hv [-]": np.abs(transfer.Hv),
        "H1_low [-]": H1_low,
        "H1_high [-]": H1_high,
        "coherence_low [-]": low,
        "coherence_high [-]": high,
    }
    if (model := result.model_H1) is not None:
        columns["H1_model [-]"] = np.abs(model)
    write_csv(file, list(columns), [format_rows(columns.values())])


def assess_fields(result: AssessResult, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for an evaluation."""
    transfer = result.transfer
    numerics = {
        "method": "metrics of the samples; frequency weighting and spectra by FFT",
        "spectra": {
            "method": "Welch, Hann window, half overlapping, mean of each segment removed",
            "segment": transfer.segment,
            "segments": transfer.segments,
            "averages": transfer.averages,
            "resolution": 1.0 / transfer.segment,
        },
    }
    names = [metric.name for metric in METRICS]
    assessed = {
        "runs": [run_fields(run) for run in (*result.runs, *result.others)],
        "agree_within": result.agree_within,
        "deviations": {
            name: each for name in names if (each := result.deviation(name)) is not None
        },
        "model": result.model,
        "exposures": [
            {
                **each._asdict(),
                "hours": {
                    name: {"A_8": by_rms, "VDV": by_dose}
                    for name, (by_rms, by_dose) in each.hours.items()
                },
            }
            for each in result.exposures
        ],
    }
    return stored_fields(
        result, result.motion, numerics, result.metrics, provenance, assess=assessed
    )


def run_fields(run: Run) -> Fields:
    """Return the metrics of a run that are known."""
    fields = {"file": wording.sanitise(run.file), "axis": run.axis, "length": run.length}
    if run.repeats:
        fields["repeats"] = wording.sanitise(run.repeats)
    if run.clean_up:
        fields["clean_up"] = [{"channel": name, **step} for name, step in run.clean_up]
    for name, metrics in (("metrics", run.metrics), ("model", run.model)):
        if metrics is not None:
            fields[name] = {key: each for key, each in metrics.items() if each is not None}
    return fields


ASSESS = Kind(
    name="assess",
    what="an evaluation of measurements",
    files=(
        File("assess.csv", write_assess_csv),
        File("spectra.csv", write_spectra_csv),
    ),
    pictures=(
        Picture(
            "assess",
            "assess.draw",
            "Measured spectra of base and mass, the transmissibility between them with its "
            "95 % band, and the coherence",
        ),
    ),
    fields=assess_fields,
    summary=summarise,
    is_sheet=True,
)
