"""A run: one case. Its files, its fields of drysim.json, its pictures and its summary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.approach.solution import EVENT_NAMES
from drysim.core.model import BLOCK_SIZE, EndStops
from drysim.excitation.recorded import Record
from drysim.metrics.table import EXPOSURE, HOURLY_STROKE, METRICS, PEAK_STROKE, WEIGHTING
from drysim.metrics.text import (
    MEANINGS,
    describe_main_numbers,
    describe_residual,
    format_labelled,
    format_value,
    label_of,
)
from drysim.records.options import SUGGESTED_HIGH_PASS
from drysim.results.fields import stored_fields
from drysim.results.kind import File, Kind, Picture, clean_up_lines, judgements
from drysim.results.tables import (
    FLAGS,
    VIOLATION_COLUMNS,
    VIOLATION_METRICS,
    Values,
    column_header,
    format_cell,
    format_rows,
    format_words,
    join_cells,
    write_csv,
)
from drysim.scenario.model import shows_peak_acceleration
from drysim.scenario.text import (
    describe_clean_up,
    describe_limits,
    describe_scene,
    format_times_by_side,
)
from drysim.scenario.window import common_period
from drysim.study.summary import BAD, Row, Summary
from drysim.study.table import HourlyStroke, hourly_stroke_used
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_percent,
    format_range,
)

if TYPE_CHECKING:
    from drysim.approach.solution import Response
    from drysim.metrics.spectra import Spectra
    from drysim.metrics.table import Metrics
    from drysim.results.fields import Fields, Provenance
    from drysim.study.outcome import Outcome

VALUE_WIDTH = 13
"""Columns of the values."""


def summarise(outcome: Outcome) -> Summary:
    """Return the summary of a run."""
    return Summary(
        name=wording.sanitise(outcome.scenario.name),
        about=outcome.scenario.about,
        scene=tuple(run_scene(outcome)),
        groups=(tuple(run_rows(outcome)),),
        width=VALUE_WIDTH,
        checks=judgements(outcome.checks),
        answer=(describe_main_numbers(outcome.metrics),),
    )


NEGLIGIBLE_LOSS = 1e-12
"""Share of the work of the base below which a loss is rounding."""


def run_scene(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was solved, and how."""
    scenario, response = outcome.scenario, outcome.response
    numerics = response.numerics
    peak = outcome.metrics[PEAK_STROKE]
    yield from describe_scene(scenario, response.plant, response.law, peak=peak)
    yield "base", scenario.excitation.describe(response.motion)
    yield from clean_up_lines(describe_clean_up(response.motion, response.law))
    yield "approach", f"{numerics.approach}: {numerics.why}"
    if numerics.period_multiple is not None:
        count = _period_count(outcome, numerics.period_multiple)
        length = format_number(_repetition(outcome), "s", 4)
        long = f"{format_count(count, 'period')}, {length}"
        closure = format_number(numerics.closure, digits=2)
        away = ""
        if numerics.distance is not None:
            away = f", distance to the orbit {format_number(numerics.distance, digits=2)}"
        is_settled = all(warning.slug != "not-settled" for warning in outcome.warnings)
        motion = "the periodic orbit" if is_settled else "a motion that has not settled"
        yield "window", f"one repetition of {motion} ({long}), closure {closure}{away}"
    else:
        yield "window", _describe_window(outcome)
    if (spectra := outcome.spectra) is not None:
        averages = format_count(spectra.segments, "segment")
        each = format_number(spectra.segment, "s", 3)
        yield "spectra", f"{averages} of {each}, half overlapping"


def _period_count(outcome: Outcome, multiple: int) -> int:
    """Return the number of base periods in a repetition; a second force may need several."""
    base = common_period(outcome.scenario.excitation.frequencies)
    return round(_repetition(outcome) / base) if base else multiple


def _repetition(outcome: Outcome) -> float:
    """Return the length of a repetition of the periodic orbit [s]."""
    trajectory = outcome.response.trajectory
    assert trajectory is not None, "the response of an approach has its trajectory"
    return trajectory.end


def _describe_window(outcome: Outcome) -> str:
    """Describe the time window of the metrics."""
    settle, duration = outcome.scenario.measure.settle, outcome.scenario.measure.duration
    response = outcome.response
    dt, motion = response.dt, response.motion
    end = (len(response) - 1) * dt
    if duration is None:  # a record ends the window, on the output grid
        duration = end - settle - getattr(motion, "rest", 0) * dt
    settled = f" after settling for {format_number(settle, 's')}" if settle else ""
    sentence, left = f"{format_number(duration, 's')}{settled}", end - settle - duration
    if left > 0.5 * dt:
        sentence += (
            f", then {format_number(left, 's')} of ring-down with the base at rest, which "
            "counts in peaks and stroke"
        )
    return sentence


def run_rows(outcome: Outcome) -> Iterator[Row]:
    """Yield the main metrics."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = (format_value(name, metrics[name]) for name in ("a_x", "a_u"))
    if metrics["a_u"] != 0.0:  # a base at rest transmits nothing
        yield _metric_value_row(metrics, "T_a", f"mass {a_x} RMS, base {a_u} RMS")
    yield from _comfort_rows(outcome)
    peak = metrics[PEAK_STROKE]
    x_r, u = format_length(metrics["x_r_rms"], peak), format_length(metrics["u_rms"], peak)
    excitation = outcome.scenario.excitation
    advice = ""
    duration = (len(outcome.response) - 1) * outcome.response.dt
    if (
        isinstance(excitation, Record)
        and metrics["u_rms"] is None
        and duration * SUGGESTED_HIGH_PASS >= 1.0  # a shorter record has no such frequency
    ):
        high_pass = excitation.remove.yaml_with(below=SUGGESTED_HIGH_PASS)
        advice = f"; it needs a high-pass: {high_pass}"
    if metrics["u_rms"] != 0.0:
        remark = f"{MEANINGS['T_x']}: x_r {x_r} RMS, base displacement {u}{advice}"
        yield _metric_value_row(metrics, "T_x", remark)
    used = format_percent(metrics["stroke_used"])
    limit = ""
    if stroke:
        limit = f"{used} of the stroke limit of {describe_limits(stroke.limits, peak)}"
        if (reached := metrics["stroke_suffices"] or 0.0) > (peak or 0.0):
            limit += f", by {format_length(reached, peak)} while settling"
        if stroke.limits.up != stroke.limits.down:
            low, high = (format_length(metrics[name], peak) for name in ("x_r_min", "x_r_max"))
            limit = f"x_r from {format_range(low, high)}; {limit}"
    if metrics["x_dd_peak"] is not None and shows_peak_acceleration(outcome.scenario):
        yield _metric_value_row(metrics, "x_dd_peak", "both sides of every jump included")
    yield _metric_value_row(metrics, PEAK_STROKE, limit)
    if metrics[HOURLY_STROKE] is not None:
        yield _hourly_stroke_row(outcome, peak)
    if outcome.response.law.stops is not None:
        yield from _end_stop_rows(metrics, outcome.response.law.stops)
    elif stroke and metrics["violations"]:
        first = format_number(metrics["t_first_violation"], "s")
        when = f"first at {first}, for a total of {format_number(metrics['t_beyond'], 's')}"
        count = format_times_by_side(metrics, "violations", stroke.limits)
        yield Row("limit", f"exceeded {count}", when, BAD)
    events = format_count(len(outcome.response.events), "event")
    yield _metric_value_row(metrics, "stuck_share", events)
    yield Row("energy", describe_residual(metrics["energy_residual"]))
    if (error := outcome.response.numerics.error) is not None:
        what = "estimated error of x_r, relative to its peak"
        yield Row("error", format_number(error, digits=2), what)
    if (exponent := outcome.response.numerics.lyapunov) is not None:
        interval = format_range(exponent.low, exponent.high)
        over = f"95 % interval {interval} over {format_count(exponent.periods, 'period')}"
        rate = format_number(exponent.value, "1/s")
        yield Row("lyapunov", rate, f"{exponent.verdict}; {over}")


def _metric_value_row(metrics: Metrics, name: str, remark: str) -> Row:
    """Return a row with the label and the value of a metric."""
    return Row(label_of(name), format_value(name, metrics[name]), remark)


COMFORT_ROWS = ("SEAT", "SEAT_VDV", "VDV", "a_w", "MTVV", "crest_factor")
"""Weighted metrics in the two rows of every weighted run; others have a row of their own."""


def _comfort_rows(outcome: Outcome) -> Iterator[Row]:
    """Yield the frequency-weighted metrics, if requested."""
    metrics, weights = outcome.metrics, outcome.scenario.measure.weights
    if weights is None or metrics["a_w"] is None:
        return

    def listed(*names: str) -> str:
        return ", ".join(format_labelled(name, metrics[name]) for name in names)

    yield _metric_value_row(metrics, "SEAT", listed("SEAT_VDV", "VDV"))
    how = f"{weights[0]}, k {format_number(weights[1])}"
    yield _metric_value_row(metrics, "a_w", f"{how}; {listed('MTVV', 'crest_factor')}")
    for metric in METRICS:
        value = metrics[metric.name]
        if WEIGHTING in metric.needs and metric.name not in COMFORT_ROWS and value is not None:
            about, exposure = metric.about.partition(":")[0], outcome.scenario.measure.exposure
            if EXPOSURE in metric.needs and exposure is not None:
                about += f" for {format_number(exposure / 3600, 'h')} a day"
            yield _metric_value_row(metrics, metric.name, about)


def _hourly_stroke_row(outcome: Outcome, peak: float | None) -> Row:
    """Return the stroke that is reached once an hour, or the rigid stops that limit it."""
    how, tone = "reached once an hour, extrapolated from the largest peaks", ""
    if outcome.metrics[HOURLY_STROKE] == peak:
        how = "reached already; the largest peaks extrapolate to less"
    stops, block = outcome.response.law.stops, outcome.scenario.stroke
    stroke = outcome.metrics[HOURLY_STROKE]
    if stops is not None and stops.rigid and stroke == max(stops.limits):
        how = "limited by the rigid stops"
    elif block is not None and stops is None:
        used = hourly_stroke_used(outcome.metrics, block.limits)
        how = f"{describe_hourly_use(used, peak)}; {how}"
        tone = BAD if used.share > 1.0 else tone
    return Row(label_of(HOURLY_STROKE), format_length(stroke, peak), how, tone)


def describe_hourly_use(used: HourlyStroke, peak: float | None = None) -> str:
    """Describe the share of a limit reached once an hour, of unequal limits with its place."""
    place = "" if used.limit == "the limit" else f" at {format_length(used.x_r, peak)}"
    return f"{format_percent(used.share)} of {used.limit}{place}"


def _end_stop_rows(metrics: Metrics, stops: EndStops) -> Iterator[Row]:
    """Yield how often and how hard the mass hit its end stops."""
    if not metrics["contacts"]:
        yield Row("end stops", "not hit")
        return
    impact = f"at up to {format_value('impact_speed', metrics['impact_speed'])}, "
    if metrics["stop_force_peak"] is None:
        impact += format_value("impulse_peak", metrics["impulse_peak"])
    else:
        impact += f"force up to {format_value('stop_force_peak', metrics['stop_force_peak'])}"
    lost = ""
    if (metrics["energy_stops"] or 0.0) > NEGLIGIBLE_LOSS * abs(metrics["energy_input"] or 0.0):
        lost = f"; energy dissipated {format_value('energy_stops', metrics['energy_stops'])}"
    times = format_times_by_side(metrics, "contacts", stops.limits)
    yield Row("stops hit", times, impact + lost, BAD)


RESPONSE_COLUMNS = ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck")


EVENT_COLUMNS = ("t", "event", "x_r", "F_L")


EVENT_CODES = sorted(EVENT_NAMES)


def write_response_csv(outcome: Outcome, file: Path) -> None:
    """Write response.csv: the motion on the output grid, with the force of end stops if any."""
    motion = outcome.response
    stops = motion.law.stops is not None
    names = (*RESPONSE_COLUMNS, "F_stop") if stops else RESPONSE_COLUMNS
    rows = (format_rows(_response_block(motion, part, stops)) for part in motion.parts())
    write_csv(file, [*map(column_header, names)], rows)


def _response_block(motion: Response, part: slice, stops: bool) -> list[Values]:
    """Return one block of response.csv by columns."""
    x_r, v_r, d, *_ = motion.points(part)
    t = np.arange(part.start, part.stop) * motion.dt
    stuck = format_words(FLAGS, d == 0)
    series = [t, motion.base(part), x_r, v_r, motion.acceleration(part), motion.friction(part)]
    return [*series, stuck, motion.stop(part)] if stops else [*series, stuck]


def write_events_csv(outcome: Outcome, file: Path) -> None:
    """Write events.csv: stops, break-aways, reversals; the first row is the state at t = 0."""
    events = outcome.response.events
    names = [EVENT_NAMES[code] for code in EVENT_CODES]

    def rows() -> Iterator[bytes]:
        for start in range(0, len(events), BLOCK_SIZE):
            part = slice(start, start + BLOCK_SIZE)
            kinds = format_words(names, np.searchsorted(EVENT_CODES, events.kind[part]))
            yield format_rows([events.t[part], kinds, events.x_r[part], events.F_L[part]])

    write_csv(file, [*map(column_header, EVENT_COLUMNS)], rows())


def write_violations_csv(outcome: Outcome, file: Path) -> None:
    """Write stroke_violations.csv, if the stroke limit was exceeded."""
    metrics = dict(outcome.metrics)
    if not metrics["violations"]:
        return
    for warning in outcome.warnings:
        # The metrics cover their window only; the limit may have been exceeded before it.
        if warning.slug == "stroke-violated":
            metrics |= warning.numbers
    cells = [format_cell(metrics[name]) for name in VIOLATION_METRICS]
    headers = [*map(column_header, VIOLATION_COLUMNS)]
    write_csv(file, headers, [join_cells([cells])])


def write_spectra_csv(outcome: Outcome, file: Path) -> None:
    """Write spectra.csv, if spectra were requested."""
    spectra = outcome.spectra
    if spectra is None:
        return
    columns = {
        "f [Hz]": spectra.f,
        "G_u [(m/s2)2/Hz]": spectra.G_u,
        "G_x [(m/s2)2/Hz]": spectra.G_x,
        "H1 [-]": np.abs(spectra.H1),
        "phase [rad]": np.angle(spectra.H1),
        "coherence [-]": spectra.coherence,
    }
    write_csv(file, list(columns), [format_rows(columns.values())])


def write_bands_csv(outcome: Outcome, file: Path) -> None:
    """Write bands.csv, if one-third-octave bands were requested."""
    if outcome.spectra is None or outcome.spectra.bands is None:
        return
    from drysim.metrics.spectra import BANDS

    a_u, a_x, a_wu, a_w = outcome.spectra.bands
    columns = {"f [Hz]": np.array(BANDS), "a_u [m/s2]": a_u, "a_x [m/s2]": a_x}
    if a_wu is not None and a_w is not None:
        columns |= {"a_wu [m/s2]": a_wu, "a_w [m/s2]": a_w}
    write_csv(file, list(columns), [format_rows(columns.values())])


def run_fields(outcome: Outcome, provenance: Provenance) -> Fields:
    """Return the content of drysim.json for a run.

    Values that are not finite become None.
    """
    numerics = {
        **asdict(outcome.response.numerics),
        "step": outcome.response.dt,
        "cases": 1,
        "energy_residual": outcome.metrics["energy_residual"],
        "law_residual": outcome.metrics["law_residual"],
    }
    if outcome.spectra is not None:
        numerics["spectra"] = _spectra_fields(outcome.spectra)
    return stored_fields(
        outcome, outcome.response.motion, numerics, outcome.metrics, provenance
    )


def _spectra_fields(spectra: Spectra) -> Fields:
    """Return the parameters of the spectral estimate."""
    return {
        "method": "Welch, Hann window, half overlapping, mean of the window removed",
        "series": "means over each step, corrected for their attenuation with frequency",
        "segment": spectra.segment,
        "segments": spectra.segments,
        "resolution": 1.0 / spectra.segment,
    }


RUN = Kind(
    name="run",
    what="one case",
    files=(
        File("response.csv", write_response_csv),
        File("events.csv", write_events_csv),
        File("spectra.csv", write_spectra_csv),
        File("bands.csv", write_bands_csv),
        File("stroke_violations.csv", write_violations_csv),
    ),
    pictures=(
        Picture(
            "response",
            "response.draw",
            "Motion: accelerations of base and mass, relative displacement, and the force of "
            "the contact over it",
        ),
        Picture(
            "spectra",
            "spectra.draw",
            "Spectra of base and mass, and the transmissibility between them",
        ),
        Picture(
            "bands",
            "spectra.draw_bands",
            "Accelerations of base and mass in one-third-octave bands",
            fits_axes=True,
        ),
    ),
    fields=run_fields,
    summary=summarise,
)
