"""The summary of an outcome: scene, approach, metrics, verdicts, warnings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.paper import stdout
from drysim.console.parts import (
    Row,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
    steps,
)
from drysim.core.plant import AnyLaw, Stopped
from drysim.excitation.record import Record
from drysim.excitation.record.cautions import HIGH_PASS
from drysim.excitation.record.spoken import Removal
from drysim.scenario.measure import common_period
from drysim.wording import length, number, percent, several, times

if TYPE_CHECKING:
    from drysim.metrics import Metrics
    from drysim.study.outcome import Outcome

RECORD = "record"
VALUE = 13
"""Columns of the values beside the names."""


def show_outcome(outcome: Outcome, folder: Path | None = None) -> None:
    """Show what came out: the scene, how it was solved, metrics, verdicts, warnings.

    Parameters
    ----------
    outcome : Outcome
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    show_title(paper, outcome.scenario)
    show_scene(paper, scene(outcome))
    show_rows(paper, _rows(outcome), VALUE)
    show_verdicts(paper, outcome.checks)
    show_folder(paper, folder)
    show_warnings(outcome.warnings)


def scene(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Give in words what was solved, and how."""
    scenario, response = outcome.scenario, outcome.response
    numerics = response.numerics
    defaulted = not scenario.static_given
    peak = outcome.metrics["x_r_peak"]
    terms = scenario.terms
    yield from wording.scene(response.plant, response.law, defaulted, terms, peak=peak)
    yield "base", wording.excitation(scenario.excitation, response.motion)
    yield from steps(wording.clean_up(response.motion, response.law))
    yield "approach", f"{numerics.approach}, {numerics.core} core: {numerics.why}"
    if numerics.period_multiple is not None:
        count = _periods(outcome, numerics.period_multiple)
        long = "a period" if count == 1 else several(count, "period")
        closure = number(numerics.closure, digits=2)
        yield "window", f"one repetition of the steady orbit ({long}), closes to {closure}"
    else:
        yield "window", _window(outcome)
    if (found := outcome.spectra) is not None:
        averages = several(found.segments, "segment")
        each = number(found.segment, "s", 3)
        yield "spectra", f"{averages} of {each}, half overlapping"


def _periods(outcome: Outcome, multiple: int) -> int:
    """Give how many periods of the base a repetition takes; other forces may need several."""
    base, track = common_period(outcome.scenario.excitation.frequencies), outcome.response.track
    assert track is not None, "an approach gives its response with its track"
    return round(track.end / base) if base else multiple


def _window(outcome: Outcome) -> str:
    """Give the stretch of time that the metrics are of; the output grid may miss its end."""
    settle, duration = outcome.scenario.measure.settle, outcome.scenario.measure.duration
    if duration is None:  # a record ends it, on its grid
        duration = (len(outcome.response) - 1) * outcome.response.dt - settle
    settled = f" after settling for {number(settle, 's')}" if settle else ""
    return f"{number(duration, 's')}{settled}"


def _felt(outcome: Outcome) -> Iterator[Row]:
    """Give the weighted metrics, where they were asked for."""
    metrics, weights = outcome.metrics, outcome.scenario.measure.weights
    if weights is None or metrics["a_w"] is None:
        return
    SEAT, dose = number(metrics["SEAT"]), number(metrics["VDV"], "m/s^1.75")
    yield Row("SEAT", SEAT, f"by dose {number(metrics['SEAT_VDV'])}, VDV {dose}")
    how = f"{weights[0]}, k {number(weights[1])}"
    highest, crest = number(metrics["MTVV"], "m/s²"), number(metrics["crest_factor"])
    yield Row(
        "a_w", number(metrics["a_w"], "m/s²"), f"{how}; MTVV {highest}, crest factor {crest}"
    )


def _hits(metrics: Metrics) -> Iterator[Row]:
    """Give how often and how hard the mass came to its end stops."""
    if not metrics["contacts"]:
        yield Row("end stops", "not met")
        return
    hardest = f"at up to {number(metrics['impact_speed'], 'm/s')}, "
    if metrics["stop_force_peak"] is None:
        hardest += f"{number(metrics['impulse_peak'], 'N·s')}"
    else:
        hardest += f"pushing with up to {number(metrics['stop_force_peak'], 'N')}"
    lost = f"; they take {number(metrics['energy_stops'], 'J')}"
    yield Row("stops met", times(metrics["contacts"]), hardest + lost, "bold red")


def _hourly(stroke: float, law: AnyLaw, peak: float | None) -> Row:
    """Give the stroke that is met once an hour, or the rigid stops that end it."""
    how = "met once, extrapolated from the greatest peaks"
    if isinstance(law, Stopped) and law.rigid and stroke == law.x_rM:
        how = "as far as the rigid stops let it"
    return Row("in an hour", length(stroke, peak), how)


def _high_pass(outcome: Outcome) -> str:
    """Say what makes the displacement of a record of acceleration or velocity known."""
    excitation = outcome.scenario.excitation
    removal = excitation.remove if isinstance(excitation, Record) else Removal()
    return f"for that, state a high-pass: {removal.with_too(below=HIGH_PASS)}"


def _rows(outcome: Outcome) -> Iterator[Row]:
    """Give the metrics that matter most, in the units of an engineer."""
    metrics, stroke = outcome.metrics, outcome.scenario.stroke
    a_x, a_u = number(metrics["a_x"], "m/s²"), number(metrics["a_u"], "m/s²")
    yield Row("T_a", number(metrics["T_a"]), f"mass {a_x} RMS, base {a_u} RMS")
    yield from _felt(outcome)
    peak = metrics["x_r_peak"]
    x_r, u = length(metrics["x_r_rms"], peak), length(metrics["u_rms"], peak)
    record = outcome.scenario.excitation.kind == RECORD
    way = f"; {_high_pass(outcome)}" if record and metrics["u_rms"] is None else ""
    yield Row("T_x", number(metrics["T_x"]), f"x_r {x_r} RMS, base displacement {u}{way}")
    used = percent(metrics["stroke_used"])
    limit = f"{used} of the stroke limit of {length(stroke.limit, peak)}" if stroke else ""
    yield Row("peak |x_r|", length(peak), limit)
    if metrics["stroke_once_an_hour"] is not None:
        yield _hourly(metrics["stroke_once_an_hour"], outcome.response.law, peak)
    if isinstance(outcome.response.law, Stopped):
        yield from _hits(metrics)
    elif metrics["violations"]:
        first = number(metrics["t_first_violation"], "s")
        when = f"first at {first}, beyond for {number(metrics['t_beyond'], 's')}"
        yield Row("limit met", times(metrics["violations"]), when, "bold red")
    events = several(len(outcome.response.events), "event")
    yield Row("stuck", percent(metrics["stuck_share"]), events)
    residual = number(metrics["energy_residual"], digits=2)
    yield Row("energy", residual, "is what the energy balance leaves, relative")
    if (error := outcome.response.numerics.error) is not None:
        bound = "at most, relative to its peak, is the error of x_r"
        yield Row("error", number(error, digits=2), bound)
