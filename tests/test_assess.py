"""Evaluation of measured records: metrics, transmissibility, runs, axes, exposure, faults."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from seat import SEAT, fields_of
from twin import base_motion, fit_twin, write_columns, write_twin

import drysim
from drysim.metrics.spectra import TransferEstimate, transfer_estimate
from drysim.plots.assess import heading
from drysim.results.assess import ASSESS, format_hours
from drysim.study import gallery
from drysim.study.assess import band_of_coherence, band_of_H1
from drysim.study.validate import describe_scenario

RATE = 200.0
PLANT = "oscillator: {mass: 75, stiffness: 4500, damping: 400}\n"
CLASSES = ("EM1", "EM2", "EM3", "EM4", "EM5", "EM6", "EM7", "EM8", "EM9", "AG2")
MODEL = {"oscillator": {"mass": 75, "stiffness": 4500, "damping": 400}}
SLIDING = {"friction": {"law": "coulomb", "kinetic": 30, "static_ratio": 1.2}}
CHANNELS = {"u_dd": "floor", "x_dd": "seat", "x_r": "stroke"}
UNITS = {"floor": "m/s2", "seat": "m/s2", "stroke": "m"}

Record = dict[str, np.ndarray]


def seat_record(
    base: str | None = None, friction: float = 30.0, noise: float = 0.0, seed: int = 1
) -> Record:
    """Return floor, seat and stroke of a seat on a class of ISO 7096, or on other noise."""
    u_dd = base_motion(20.0, seed, 1.2, RATE)
    if base is not None:
        block = f"excitation: {{kind: standard, class: {base}, duration: 20 s, seed: {seed}}}\n"
        text = PLANT + block + f"solver: {{step: {1 / RATE} s}}\n"
        u_dd = np.asarray(drysim.scenario(text).excitation.motion(1 / RATE).u_dd[:])
    r = drysim.simulate(
        m=75.0, k_x=4500.0, b=400.0, F_fk=friction, F_fs=1.2 * friction, u_dd=u_dd, dt=1 / RATE
    )
    record = {"floor": u_dd, "seat": np.asarray(r.x_dd), "stroke": np.asarray(r.x_r)}
    random = np.random.default_rng(seed)
    return {
        name: values + noise * float(values.std()) * random.normal(size=len(values))
        for name, values in record.items()
    }


def write_record(file: Path, record: Record) -> None:
    """Write a record as CSV, with every digit."""
    n = len(next(iter(record.values())))
    columns = {"t [s]": np.arange(n) / RATE}
    write_columns(
        file, columns | {f"{k} [{UNITS.get(k, 'm/s2')}]": v for k, v in record.items()}
    )


def scenario_of(
    folder: Path, changes: Mapping[str, Any] | None = None, **records: Record
) -> drysim.Scenario:
    """Return the scenario that assesses records, which are written into a folder."""
    files = [str(folder / f"{name}.csv") for name in records]
    for file, record in zip(files, records.values(), strict=True):
        write_record(Path(file), record)
    channels = {k: v for k, v in CHANNELS.items() if v in next(iter(records.values()))}
    measured = {"file": files[0], "more_files": files[1:], "time": "t", **channels}
    blocks = {"measure": {"direction": "vertical"}, "assess": {"measured": measured}}
    return drysim.scenario(blocks, changes or {})


def assess(
    folder: Path, changes: Mapping[str, Any] | None = None, **records: Record
) -> drysim.AssessResult:
    """Return the assessment of records."""
    return drysim.assess(scenario_of(folder, changes, **records))


def warnings_of(result: drysim.AssessResult, slug: str) -> list[str]:
    """Return the sentences of the warnings of a kind."""
    return [warning.sentence for warning in result.warnings if warning.slug == slug]


def rows_of(result: drysim.AssessResult) -> dict[str, str]:
    """Return value and remark of each row of the summary, by its label."""
    rows = [row for group in ASSESS.summary(result).groups for row in group]
    return {row.label: f"{row.value} {row.remark}" for row in rows}


# Metrics


def weighted(values: np.ndarray, which: str) -> np.ndarray:
    """Return the weighted samples, by the polynomials of ISO 2631-1 in s (annex A).

    The series is continued by 40 s of zeros, in which the filters come to rest.
    """
    from scipy import signal

    n = len(values)
    size = n + round(40.0 * RATE)
    f = np.fft.rfftfreq(size, 1 / RATE)
    f3, Q4, *step = {"Wk": (12.5, 0.63, 2.37, 0.91, 3.35, 0.91), "Wd": (2.0, 0.63)}[which]
    w1, w2, w3 = (2 * np.pi * x for x in (0.4, 100.0, f3))
    filters = [
        ([1.0, 0.0, 0.0], [1.0, np.sqrt(2) * w1, w1**2]),
        ([w2**2], [1.0, np.sqrt(2) * w2, w2**2]),
        ([w3, w3**2], [1.0, w3 / Q4, w3**2]),
    ]
    if step:
        w5, w6 = 2 * np.pi * step[0], 2 * np.pi * step[2]
        filters.append(([1.0, w5 / step[1], w5**2], [1.0, w6 / step[3], w6**2]))
    spectrum = np.fft.rfft(values, size)
    for b, a in filters:
        spectrum *= signal.freqs(b, a, 2 * np.pi * f)[1]
    return np.fft.irfft(spectrum, size)[:n]


@pytest.mark.parametrize("friction", [0.0, 45.0])
@pytest.mark.parametrize("base", CLASSES)
def test_weighted_metrics_are_those_of_the_formulas(tmp_path, base, friction):
    record = seat_record(base, friction, noise=0.02)
    metrics = assess(tmp_path, run=record).metrics
    floor, seat = (weighted(record[name], "Wk") for name in ("floor", "seat"))
    rms = [np.sqrt(np.mean(x**2)) for x in (floor, seat)]
    dose = [np.sum(x**4 / RATE) ** 0.25 for x in (floor, seat)]
    wanted = {
        "a_w": rms[1],
        "SEAT": rms[1] / rms[0],
        "VDV": dose[1],
        "SEAT_VDV": dose[1] / dose[0],
        "crest_factor": np.abs(seat).max() / rms[1],
        "MTVV": max(
            np.sqrt(np.mean(seat[i : i + 200] ** 2)) for i in range(len(seat) - 200 + 1)
        ),
        "T_a": np.sqrt(np.mean(record["seat"] ** 2) / np.mean(record["floor"] ** 2)),
        "x_r_peak": np.abs(record["stroke"]).max(),
    }
    rough = {"crest_factor": 1e-5}  # a peak depends on the length of the zeros in the FFT
    for name, value in wanted.items():
        assert metrics[name] == pytest.approx(value, rel=rough.get(name, 1e-6)), name


def test_window_and_horizontal_direction_count(tmp_path):
    record = seat_record()
    changes = {"measure.direction": "horizontal", "measure.settle": 4, "measure.duration": 10}
    result = assess(tmp_path, changes, run=record)
    assert result.runs[0].length == 10.0
    seat = weighted(record["seat"], "Wd")[800:2800]
    assert result.metrics["a_w"] == pytest.approx(1.4 * np.sqrt(np.mean(seat**2)), rel=1e-6)
    assert not warnings_of(result, "recalled")


def test_without_direction_the_unweighted_metrics_are_known(tmp_path):
    result = assess(tmp_path, {"measure": None}, run=seat_record())
    assert result.metrics["SEAT"] is None
    assert result.metrics["T_a"] is not None
    assert not result.exposures
    assert "A(8)" not in result._repr_html_()


# Transmissibility


def test_spectra_are_those_of_scipy(tmp_path):
    from scipy import signal

    record = seat_record(noise=0.05)
    found = assess(tmp_path, run=record).transfer
    u, x = record["floor"], record["seat"]
    options = {"fs": RATE, "nperseg": round(found.segment * RATE)}
    f, G_ux = signal.csd(u, x, **options)
    G_u, G_x = (signal.welch(each, **options)[1] for each in (u, x))
    same = {"rtol": 1e-9, "atol": 0.0}
    np.testing.assert_allclose(found.f, f[1:], **same)
    np.testing.assert_allclose(found.H1, (G_ux / G_u)[1:], **same)
    np.testing.assert_allclose(found.H2, (G_x / np.conj(G_ux))[1:], **same)
    np.testing.assert_allclose(np.abs(found.Hv), np.sqrt(G_x / G_u)[1:], **same)
    np.testing.assert_allclose(
        found.coherence, signal.coherence(u, x, **options)[1][1:], **same
    )


def white_pair(seed: int, n: int, of_base: float, of_mass: float) -> TransferEstimate:
    """Return the estimate of a gain of 0.5, with noise of these ratios to the signals."""
    random = np.random.default_rng(seed)
    u = random.normal(size=n)
    x = 0.5 * u + 0.5 * np.sqrt(of_mass) * random.normal(size=n)
    u = u + np.sqrt(of_base) * random.normal(size=n)
    return transfer_estimate(u, x, 0.01, 1.0)


@pytest.mark.parametrize(
    ("of_base", "of_mass", "H1", "H2"),
    [(0.2, 0.0, 0.5 / 1.2, 0.5), (0.0, 0.3, 0.5, 0.5 * 1.3), (0.2, 0.3, 0.5 / 1.2, 0.65)],
)
def test_noise_lowers_H1_and_raises_H2_as_theory_says(of_base, of_mass, H1, H2):
    found = white_pair(1, 400_000, of_base, of_mass)
    inner = slice(2, -2)  # the ends are those of the window
    assert np.abs(found.H1)[inner].mean() == pytest.approx(H1, rel=2e-3)
    assert np.abs(found.H2)[inner].mean() == pytest.approx(H2, rel=2e-3)
    assert np.abs(found.Hv)[inner].mean() == pytest.approx(np.sqrt(H1 * H2), rel=2e-3)
    assert found.coherence[inner].mean() == pytest.approx(H1 / H2, rel=2e-3)


@pytest.mark.parametrize("of_mass", [0.05, 1.0])
def test_bands_hold_the_truth_as_often_as_they_say(of_mass):
    held, coherent, lines = 0, 0, slice(2, -2)
    for seed in range(200):
        found = white_pair(seed, 3000, 0.0, of_mass)  # 29 averages
        low, high = band_of_H1(found)
        held += np.mean((low[lines] <= 0.5) & (high[lines] >= 0.5))
        low, high = band_of_coherence(found)
        truth = 1.0 / (1.0 + of_mass)
        coherent += np.mean((low[lines] <= truth) & (high[lines] >= truth))
    assert held / 200 == pytest.approx(0.95, abs=0.015)
    assert coherent / 200 == pytest.approx(0.95, abs=0.03)


def test_independent_averages_of_half_overlapping_segments():
    n, found = 40, white_pair(1, 2050, 0.0, 0.1)
    assert found.segments == n
    scatter = [white_pair(seed, 2050, 0.0, 0.1).G_u[2:-2] for seed in range(150)]
    relative = np.var(scatter, axis=0) / np.mean(scatter, axis=0) ** 2
    assert 1.0 / relative.mean() == pytest.approx(found.averages, rel=0.05)


# Runs, axes and the model


def test_several_runs_have_a_mean_a_deviation_and_a_verdict(tmp_path):
    runs = {f"run-{i}": seat_record(seed=i) for i in (1, 2, 3)}
    runs["run-3"] = {name: values[:-1] for name, values in runs["run-3"].items()}
    result = assess(tmp_path, {"assess.agree_within": "20 %"}, **runs)
    single = [assess(tmp_path, run=record).metrics["SEAT"] for record in runs.values()]
    of_runs = {name: [run.metrics[name] for run in result.runs] for name in result.metrics}
    assert of_runs["SEAT"] == single
    for name in ("SEAT", "VDV", "crest_factor"):
        assert result.metrics[name] == pytest.approx(np.mean(of_runs[name])), name
    assert result.metrics["MTVV"] == max(of_runs["MTVV"])
    furthest = max(abs(value / np.mean(single) - 1.0) for value in single)
    assert result.deviation("SEAT") == pytest.approx(furthest)
    assert not warnings_of(result, "runs-disagree")
    assert result.transfer.segments == sum(run.transfer.segments for run in result.runs)
    assert "largest MTVV" in rows_of(result)["a_w"]
    assert "mean crest factor" in rows_of(result)["a_w"]
    assert heading(result).lines[0].startswith("3 runs: SEAT")


def test_runs_that_disagree_are_named(tmp_path):
    runs = {"a": seat_record(seed=1), "b": seat_record(seed=1), "c": seat_record(friction=150)}
    result = assess(tmp_path, **runs)
    sentence = warnings_of(result, "runs-disagree")[0]
    assert sentence.startswith("the runs do not agree within 5 % in SEAT: ")
    assert "c.csv" in sentence
    assert result.exit_code() == 0
    assert result.exit_code(strict=True) == 1


def test_axis_with_the_highest_acceleration_decides(tmp_path):
    record = seat_record()
    record |= {
        "floor x": record["floor"],
        "seat x": 2.0 * record["seat"],
        "seat y": record["seat"],
    }
    axes = {"x": {"u_dd": "floor x", "x_dd": "seat x"}, "y": {"x_dd": "seat y"}}
    changes = {"assess.axes": axes, "measure.exposure": "4 h"}
    result = assess(tmp_path, changes, run=record)
    by_axis = {run.axis: run.metrics for run in (*result.runs, *result.others)}
    assert [*by_axis] == ["z", "x", "y"]
    horizontal = weighted(record["seat"], "Wd")
    assert by_axis["x"]["a_w"] == pytest.approx(2.8 * np.sqrt(np.mean(horizontal**2)), rel=1e-6)
    assert by_axis["y"]["SEAT"] is by_axis["y"]["a_u"] is None
    a_w = max(metrics["a_w"] for metrics in by_axis.values())
    assert result.exposures[0].a_w == a_w
    assert result.metrics["A_8"] == pytest.approx(a_w * np.sqrt(0.5))
    assert result.metrics["a_w"] == by_axis["z"]["a_w"]


def test_hours_until_action_and_limit_value(tmp_path):
    result = assess(tmp_path, {"measure.exposure": "8 h"}, run=seat_record())
    (exposure,) = result.exposures
    assert result.metrics["A_8"] == pytest.approx(exposure.a_w)
    for name, A_8, VDV in (("action value", 0.5, 9.1), ("limit value", 1.15, 21.0)):
        by_rms, by_dose = exposure.hours[name]
        assert exposure.a_w * np.sqrt(by_rms / 8.0) == pytest.approx(A_8)
        day = result.metrics["VDV_day"] * (by_dose / 8.0) ** 0.25
        assert day == pytest.approx(VDV)
    assert [format_hours(x) for x in (0.25, 3.456, 40.0)] == ["15 min", "3.46 h", "over 24 h"]


def test_dose_of_runs_of_different_length_is_that_of_all_of_them(tmp_path):
    record = seat_record()
    short = {name: values[:2000] for name, values in seat_record(seed=2).items()}
    changes = {"measure.exposure": "8 h", "checks": ["VDV < 9"]}
    result = assess(tmp_path, changes, whole=record, half=short)
    doses = [run.metrics["VDV"] for run in result.runs]
    rate = sum(dose**4 for dose in doses) / sum(run.length for run in result.runs)
    assert result.metrics["VDV_day"] == pytest.approx((rate * 8 * 3600) ** 0.25)
    (exposure,) = result.exposures
    assert exposure.hours["action value"][1] == pytest.approx(9.1**4 / rate / 3600)
    assert result.metrics["VDV"] is exposure.VDV is result.deviation("VDV") is None
    assert not result.checks[0].passed
    assert "the runs last 10 to 20 s; a dose grows" in rows_of(result)["VDV"]
    result.save(tmp_path / "out", report=True)


def test_model_on_the_measured_base_stands_beside_it(tmp_path):
    record = seat_record()
    model = MODEL | SLIDING
    result = assess(tmp_path, model, run=record)
    base = {"kind": "record", "file": str(tmp_path / "run.csv"), "time": "t", "column": "floor"}
    run = drysim.run(
        drysim.scenario({**model, "excitation": base}, {"measure.direction": "vertical"})
    )
    for name in ("SEAT", "a_w", "T_a", "x_r_peak", "stuck_share"):
        assert result.model[name] == pytest.approx(run.metrics[name], rel=1e-12)
    assert result.metrics["SEAT"] == pytest.approx(result.model["SEAT"], rel=5e-3)
    assert result.metrics["stuck_share"] is None
    found = result.transfer
    strong = found.G_u > 0.1 * found.G_u.max()
    np.testing.assert_allclose(result.model_H1[strong], found.H1[strong], rtol=0.05)


@pytest.mark.parametrize("count", [1, 2])
def test_model_is_unknown_where_its_base_does_not_move(tmp_path, count):
    record = seat_record()
    sign = (-1.0) ** np.arange(len(record["floor"]))  # whose means over the steps are 0
    runs = {f"run-{i}": {**record, "floor": (1 + i) * sign} for i in range(count)}
    result = assess(tmp_path, MODEL, **runs)
    assert np.isnan(result.model_H1).all()
    result.save(tmp_path / "out")


def test_transmissibility_of_the_model_weighs_runs_by_power_and_segments(tmp_path):
    record = seat_record()
    half = {name: 3.0 * values[:2000] for name, values in record.items()}
    result = assess(tmp_path, MODEL | SLIDING, whole=record, half=half)
    spectra = [run.model_spectra for run in result.runs]
    power = [each.segments * each.G_u for each in spectra]
    wanted = (power[0] * spectra[0].H1 + power[1] * spectra[1].H1) / (power[0] + power[1])
    np.testing.assert_allclose(result.model_H1, wanted, rtol=1e-12)


def test_model_on_a_base_of_velocity_has_the_lines_of_the_measurement(tmp_path):
    record = seat_record()
    velocity = {"t [s]": np.arange(len(record["floor"])) / RATE}
    write_columns(
        tmp_path / "base.csv", velocity | {"v [m/s]": np.cumsum(record["floor"]) / RATE}
    )
    base = {"kind": "record", "file": str(tmp_path / "base.csv"), "time": "t"}
    changes = {
        "assess.measured.u_dd": None,
        "excitation": {**base, "quantity": "velocity"},
        **MODEL,
        **SLIDING,
        "measure.spectra": True,
        "measure.segment": 2.004,
    }
    result = assess(tmp_path, changes, run=record)
    strong = result.transfer.G_u > 0.1 * result.transfer.G_u.max()
    np.testing.assert_allclose(
        np.abs(result.model_H1)[strong], np.abs(result.transfer.H1)[strong], rtol=0.15
    )


def test_rate_is_that_of_the_samples(tmp_path):
    record = seat_record()
    changes = {"measure.spectra": True, "measure.segment": 1.005}  # 201 samples
    result = assess(tmp_path, changes, run=record)
    scene = dict(ASSESS.summary(result).scene)
    assert scene["window"] == "20 s at 200 Hz"


def test_fit_keeps_the_block_for_the_fitted_model(tmp_path):
    plant = "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
    write_twin(tmp_path, plant + "friction: {law: coulomb, kinetic: 20}\n", seconds=3.0)
    block = "assess: {measured: {file: run.csv, time: t, x_dd: x_dd}}\n"
    known = plant + "friction: {law: coulomb}\n" + block
    fitted = fit_twin(tmp_path, known, "friction.kinetic: {}").scenario
    result = drysim.assess(fitted)
    assert result.model["a_x"] == pytest.approx(result.metrics["a_x"], rel=1e-2)


def test_base_may_be_the_record_of_the_excitation(tmp_path):
    record = seat_record()
    apart = assess(tmp_path, run=record).metrics
    write_record(tmp_path / "floor.csv", {"floor": record["floor"]})
    changes = {
        "assess.measured.u_dd": None,
        "excitation": {"kind": "record", "file": str(tmp_path / "floor.csv"), "time": "t"},
    }
    result = assess(tmp_path, changes, run={k: record[k] for k in ("seat", "stroke")} | record)
    assert result.metrics == apart
    assert [each.file for each in result.inputs] != []
    scene = dict(ASSESS.summary(result).scene)
    assert scene["measured"] == "u_dd of floor.csv, x_dd, x_r along z of run.csv"
    notes, _ = describe_scenario(result.scenario)
    assert notes[0].startswith("assessed: run.csv along z on the base of floor.csv, ")


def test_lag_that_is_stated_is_removed(tmp_path):
    record = seat_record()
    late = {
        **record,
        "seat": np.roll(record["seat"], 10),
        "stroke": np.roll(record["stroke"], 10),
    }
    segment = {"measure.spectra": True, "measure.segment": 2}
    result = assess(tmp_path, {**segment, "assess.measured.delay": 10 / RATE}, run=late)
    found, plain = result.transfer, assess(tmp_path, segment, run=record).transfer
    strong = plain.G_u > 0.1 * plain.G_u.max()
    np.testing.assert_allclose(found.H1[strong], plain.H1[strong], rtol=0.1)


@pytest.mark.parametrize("lag", [0, 300])
def test_runs_that_repeat_the_base_narrow_no_band(tmp_path, lag):
    record = seat_record()
    runs = {f"run-{i}": {k: np.roll(v, i * lag) for k, v in record.items()} for i in range(3)}
    segment = {"measure.spectra": True, "measure.segment": 2}
    result = assess(tmp_path, segment, **runs)
    single = result.runs[0].transfer
    assert result.transfer.averages == single.averages
    assert result.transfer.segments == 3 * single.segments
    for band in (band_of_H1, band_of_coherence):
        widths = [high - low for low, high in map(band, (result.transfer, single))]
        strong = single.G_u > 0.1 * single.G_u.max()
        assert np.median(widths[0][strong] / widths[1][strong]) == pytest.approx(1.0, abs=0.2)
    assert [Path(run.repeats).name for run in result.runs] == ["", "run-0.csv", "run-0.csv"]
    scene = dict(ASSESS.summary(result).scene)
    assert "run-2.csv repeat a base and add none" in scene["spectra"]
    fields = fields_of(result.save(tmp_path / "out"))
    assert fields["assess"]["runs"][2]["repeats"] == "run-0.csv"


@pytest.mark.parametrize("base", CLASSES)
def test_runs_on_other_bases_add_their_averages(tmp_path, base):
    runs = {f"run-{i}": seat_record(base, seed=i) for i in (1, 2, 3)}
    result = assess(tmp_path, **runs)
    averages = [run.transfer.averages for run in result.runs]
    assert result.transfer.averages == pytest.approx(sum(averages))


# Faults of channels


FAULTS = {
    "sign": (lambda r: {**r, "seat": -r["seat"]}, "the sign of x_dd"),
    "swapped": (lambda r: {**r, "seat": r["floor"], "floor": r["seat"]}, "swapped"),
    "in g": (lambda r: {**r, "seat": r["seat"] / 9.81}, "9.81 times too small"),
    "not in g": (lambda r: {**r, "seat": r["seat"] * 9.81}, "9.81 times too large"),
    "lag": (lambda r: {**r, "seat": np.roll(r["seat"], 16)}, "lag by about 0.0"),
    "stroke": (lambda r: {**r, "stroke": -r["stroke"]}, "the sign of x_r"),
    "millimetres": (lambda r: {**r, "stroke": 1e3 * r["stroke"]}, "x_r seem to be 1000 t"),
}


@pytest.mark.parametrize("base", ["EM1", "EM5", "EM6"])
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_channels_are_named(tmp_path, base, fault):
    spoil, words = FAULTS[fault]
    record = spoil(seat_record(base, noise=0.02))
    assert words in warnings_of(assess(tmp_path, run=record), "channels-suspect")[0]


@pytest.mark.parametrize("lag", [10, 40, 400, -600])
@pytest.mark.parametrize("base", ["EM2", "EM6", "EM8"])
def test_lag_is_told_to_a_few_samples(tmp_path, base, lag):
    record, n = seat_record(base, noise=0.02), 4001 - abs(lag)
    late, early = max(lag, 0), max(-lag, 0)
    shifted = {"floor": record["floor"][late:], "seat": record["seat"][early:]}
    result = assess(tmp_path, run={name: values[:n] for name, values in shifted.items()})
    sentence = warnings_of(result, "channels-suspect")[0]
    told = re.search(r"lag by about (\S+) s: add it to `measured.delay`", sentence)
    assert float(told[1]) == pytest.approx(lag / RATE, abs=0.02)


@pytest.mark.parametrize("base", ["EM1", "EM5", "EM6", "AG2"])
def test_records_of_different_runs_are_named(tmp_path, base):
    other = seat_record(base, seed=2)["seat"]
    result = assess(tmp_path, run={"floor": seat_record(base)["floor"], "seat": other})
    sentence = warnings_of(result, "channels-suspect")[0]
    assert sentence.startswith("base and mass seem to be unrelated: check files, columns")
    assert result.exit_code(strict=True) == 1


@pytest.mark.parametrize("friction", [0.0, 30.0, 90.0, 200.0])
@pytest.mark.parametrize("base", ["EM1", "EM6", "EM8", "AG2"])
def test_no_fault_is_named_of_good_channels(tmp_path, base, friction):
    record = seat_record(base, friction, noise=0.02)
    assert not warnings_of(assess(tmp_path, run=record), "channels-suspect")


def test_sign_that_is_stated_wrong_is_removed_and_a_stroke_named_as_unmeasured(tmp_path):
    record = seat_record("EM1", noise=0.02)
    del record["stroke"]
    scale = {"assess.measured.x_dd": {"column": "seat", "scale": -1}}
    result = assess(tmp_path, scale | {"checks": ["x_r_peak < 20 mm"]}, run=record)
    assert ": remove `scale: -1`; " in warnings_of(result, "channels-suspect")[0]
    assert result.checks[0].reason == "x_r_peak is not known here: no x_r is measured"


def test_mass_that_moves_with_its_base_is_no_fault(tmp_path):
    record = seat_record()
    held = {"floor": record["floor"], "seat": record["floor"]}
    result = assess(tmp_path, run=held)
    assert result.metrics["SEAT"] == 1.0
    assert not result.warnings


def test_mass_that_stands_still_in_the_window_is_compared_with_nothing(tmp_path):
    record = seat_record()
    still = np.where(np.arange(4001) < 400, record["seat"], 0.0)
    window = {"measure.settle": 4, "measure.duration": 15}
    result = assess(tmp_path, window, run={"floor": record["floor"], "seat": still})
    assert result.metrics["T_a"] == 0.0
    assert not warnings_of(result, "channels-suspect")


def test_base_without_motion_is_an_error(tmp_path):
    record = seat_record()
    with pytest.raises(drysim.RecordError, match="the base is the same in every sample"):
        assess(tmp_path, run={**record, "floor": 0.0 * record["floor"]})


def test_base_that_is_longer_than_the_mass_is_said(tmp_path):
    record = seat_record()
    write_record(tmp_path / "floor.csv", {"floor": record["floor"]})
    base = {"kind": "record", "file": str(tmp_path / "floor.csv"), "time": "t"}
    changes = {"excitation": base}
    shorter = {"seat": record["seat"][:3001]}
    assert warnings_of(assess(tmp_path, changes, run=shorter), "measurement-cut") == [
        "the mass is measured in 15 s of the window of 20 s of the base; the rest is not used"
    ]
    stated = {**changes, "measure.duration": 15}
    assert not warnings_of(assess(tmp_path, stated, run=shorter), "measurement-cut")


def test_two_rates_are_filtered_alike_and_keep_the_band_of_the_slower(tmp_path):
    record = seat_record()
    write_record(tmp_path / "floor.csv", {"floor": record["floor"]})
    base = {"kind": "record", "file": str(tmp_path / "floor.csv"), "time": "t"}
    columns = {"t [s]": np.arange(2001) / 100, "seat [m/s2]": record["seat"][::2]}
    write_columns(tmp_path / "seat.csv", columns)
    measured = {"file": str(tmp_path / "seat.csv"), "time": "t", "x_dd": "seat"}
    text = {"measure": {"direction": "vertical"}, "assess": {"measured": measured}}
    scenario = drysim.scenario(text, {"excitation": base})
    low_pass = {"above": "28.6 Hz"}
    with pytest.raises(drysim.RecordError) as refusal:
        drysim.assess(scenario)
    both = "`remove: {above: 28.6 Hz, order: 2}` to both excitation and `x_dd`"
    assert both in str(refusal.value)
    assert "the base has a step of 0.005 s, the mass 0.01 s" in str(refusal.value)
    slower = base | {"resample": {"step": 0.01, "by": "spline"}, "remove": low_pass}
    alike = {"column": "seat", "remove": low_pass}
    one_sided = drysim.assess(drysim.scenario(text, {"excitation": slower}))
    (sentence,) = warnings_of(one_sided, "filters-differ")
    assert sentence.endswith("`x_dd: {column: seat, remove: {above: 28.6 Hz}}`")
    both_sides = {"excitation": slower, "assess.measured.x_dd": alike}
    assert not warnings_of(drysim.assess(drysim.scenario(text, both_sides)), "filters-differ")
    with pytest.raises(drysim.ScenarioError, match=r"x_dd=\{column: seat, remove: …\}`$"):
        drysim.scenario(text, {"excitation": base, "assess.measured.x_dd.remove": low_pass})
    faster = {"excitation": base, "assess.measured.resample": {"rate": 200, "by": "spline"}}
    assert warnings_of(drysim.assess(drysim.scenario(text, faster)), "coarse-weighting")


def test_clean_up_of_every_channel_and_run_is_told(tmp_path):
    broken = seat_record()
    broken["seat"][[100, 300, 301]] = np.nan
    gaps = {"fill": "spline", "at_most": "20 ms"}
    changes = {
        "assess.measured.gaps": gaps,
        "assess.measured.x_dd": {"column": "seat", "remove": {"trend": "mean"}},
    }
    runs = {"first": broken, "second": seat_record(seed=2)}
    result = assess(tmp_path, changes, **runs)
    told = [text for label, text in ASSESS.summary(result).scene if label in ("cleaned", "")]
    assert [sentence.partition(" filled")[0] for sentence in told[:1]] == [
        "x_dd of first.csv: 2 gaps (3 samples)"
    ]
    assert told[1].startswith("x_dd of first.csv: the mean removed")
    assert told[1].endswith("; 1 more file likewise")
    assert set(told) <= set(describe_scenario(result.scenario)[0])


def test_model_changes_no_measured_spectrum(tmp_path):
    floor = base_motion(60.0, 1, 1.2, RATE)
    record = {"floor": floor, "seat": 0.5 * floor}
    alone, beside = (assess(tmp_path, model, run=record).transfer for model in ({}, MODEL))
    assert (alone.segment, alone.f.tolist()) == (beside.segment, beside.f.tolist())


def test_record_of_too_few_samples_is_an_error(tmp_path):
    short = {name: values[:12] for name, values in seat_record().items()}
    sentence = "it has 12 samples, too few: at least 50 are needed"
    with pytest.raises(drysim.RecordError, match=sentence):
        assess(tmp_path, {"measure": None}, run=short)


def test_interpolation_of_the_base_concerns_only_the_model(tmp_path):
    random = np.random.default_rng(1)
    record = {**seat_record(), "floor": random.normal(size=len(seat_record()["floor"]))}
    assert not warnings_of(assess(tmp_path, run=record), "record-interpolated")
    result = assess(tmp_path, MODEL, run=record, other=seat_record())
    (sentence,) = warnings_of(result, "record-interpolated")
    assert sentence.count("run.csv") == 1
    assert "run.csv along z: linear interpolation" in sentence


def test_measured_stroke_beyond_its_limit_is_a_warning(tmp_path):
    record = seat_record()
    peak = float(np.abs(record["stroke"]).max())
    for share, is_beyond in ((1.01, False), (1.0, True), (0.5, True)):
        result = assess(tmp_path, {"stroke": {"limit": share * peak}}, run=record)
        assert bool(warnings_of(result, "stroke-violated")) == is_beyond


def test_checks_of_seeds_warn(tmp_path):
    checks = ["SEAT p95 < 2", "a_w < 9 with every seed", "SEAT < 2"]
    result = assess(tmp_path, {"checks": checks}, run=seat_record())
    sentences = warnings_of(result, "check-of-one-seed")
    assert [sentence.split("`")[1] for sentence in sentences] == checks[:2]
    assert all(check.passed for check in result.checks)
    without = {"checks": checks[2:], "measure": None}
    (sentence,) = warnings_of(assess(tmp_path, without, run=seat_record()), "check-cannot-hold")
    assert sentence.endswith("without a weighting; give measure.direction or measure.weighting")


def test_gravity_and_clipping_are_seen(tmp_path):
    record = seat_record()
    with pytest.raises(
        drysim.RecordError, match=r"looks like gravity.* in assess\.measured\.x_dd$"
    ):
        assess(tmp_path, run={**record, "seat": record["seat"] + 9.81})
    with pytest.raises(drysim.RecordError, match=r"looks like gravity"):
        assess(tmp_path, run={**record, "floor": record["floor"] + 9.81})
    limit = 0.6 * np.abs(record["seat"]).max()
    result = assess(tmp_path, run={**record, "seat": np.clip(record["seat"], -limit, limit)})
    assert warnings_of(result, "record-clipped")


# Scenarios


def test_only_assess_needs_no_oscillator(tmp_path):
    scenario = scenario_of(tmp_path, run=seat_record())
    assert scenario.missing_blocks == ["oscillator", "excitation"]
    for command in (drysim.run, drysim.fit, drysim.branches, drysim.map_regimes):
        with pytest.raises(drysim.ScenarioError) as fault:
            command(scenario)
        sentence = "required by all commands but `drysim assess`: oscillator"
        assert sentence in fault.value.problems[0].sentence
    with pytest.raises(drysim.UsageError, match="has no assess block"):
        drysim.assess(drysim.scenario(SEAT))


def test_report_without_a_model_says_nothing_of_one(tmp_path):
    record = seat_record()
    for changes, has_model in (({}, False), (MODEL, True)):
        page = drysim.report(assess(tmp_path, changes, run=record))
        for word in ("dry-friction contact", "F_fk", "What was computed", "solver:"):
            assert (word in page) == has_model
        assert "between the grid points" not in page
    page = drysim.report(assess(tmp_path, {"assess.measured.x_r": None}, run=record))
    for symbol, is_shown in {"x_r": False, "T_x": False, "T_a": True}.items():
        assert (f'<th scope="row">{symbol}</th>' in page) == is_shown


def test_rows_select_the_samples(tmp_path):
    record = seat_record()
    first = assess(tmp_path, first={name: x[:2000] for name, x in record.items()})
    selected = assess(tmp_path, {"assess.measured.rows": {"from": 2, "to": 2001}}, run=record)
    assert selected.metrics == first.metrics


def test_code_of_a_missing_sample_is_left_out_as_its_error_advises(tmp_path):
    record = seat_record()
    whole = assess(tmp_path, run=record)
    record["seat"][1000] = -9999.0
    changes = {"assess.measured.gaps": {"fill": "spline", "at_most": "10 ms"}}
    with pytest.raises(drysim.RecordError, match=r"`missing: -9999` leaves it out"):
        assess(tmp_path, changes, run=record)
    filled = assess(tmp_path, {**changes, "assess.measured.missing": -9999}, run=record)
    assert filled.metrics["SEAT"] == pytest.approx(whole.metrics["SEAT"], rel=1e-3)


def test_block_without_an_assess_block_is_required_as_before(tmp_path):
    with pytest.raises(drysim.ScenarioError) as fault:
        drysim.scenario("measure: {direction: vertical}\n")
    assert {problem.key for problem in fault.value.problems} >= {"oscillator", "excitation"}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"assess.measured.x_dd": None}, "assess.measured.x_dd is required"),
        ({"assess.measured.u_dd": None}, "assess.measured.u_dd is required, the base, unless"),
        ({"assess.measured": {"file": "a.csv", "more_files": ["b.csv"], "x_dd": "seat"},
          "excitation": {"kind": "record", "file": "base.csv"}}, "each file has its own base"),
        ({"assess.measured.more_files": ["b.csv", "c.csv", "./b.csv"]},
         "names ./b.csv again; each run has its own file"),
        ({"assess.measured.x_dd": "sofa"}, "no column"),
        ({"assess.measured.unit": "g"}, "in assess.measured; it belongs in x_dd, x_r or u_dd"),
        (
            {"assess.measured.x_dd": 2},  # the floor, which u_dd names
            "assess.measured.x_dd is column 2 (`floor [m/s2]`) of run.csv, and so is "
            "assess.measured.u_dd: each needs its own",
        ),
        ({"assess.axes": {"x": {"x_dd": "seat"}}}, "and so is assess.measured.x_dd"),
        ({"assess.axes": {"z": {"x_dd": "seat"}}}, "assess.axes.z is the axis of `measured`"),
        ({"assess.axes": {"w": {"x_dd": "seat"}}}, "unknown key `w` in assess.axes"),
        ({"assess.axes": {"x": {"x_dd": "seat"}}, "measure": None},
         "assess.axes requires measure.direction"),
        ({"assess.agree_within": 2}, "assess.agree_within must be below 1"),
        ({"measure.settle": 99}, "measure.settle exceeds the end"),
    ],
)  # fmt: skip
def test_faults_of_the_block_are_said(tmp_path, changes, sentence):
    with pytest.raises(drysim.DrysimError) as fault:
        assess(tmp_path, changes, run=seat_record())
    problems = getattr(fault.value, "problems", None) or [fault.value.problem]
    assert any(sentence in problem.sentence for problem in problems)


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("  file: fit-", "  file: no-", "excitation.file: no-seat-synthetic.csv"),
        ("{file: fit-", "{file: no-", "assess.measured.file: no-seat-synthetic.csv"),
        ("time: t, x_dd", "more_files: [b.csv], time: t, x_dd", "more_files #1: b.csv"),
    ],
)
def test_missing_record_is_refused_at_its_place(drysim, refused, tmp_path, old, new, place):
    assert drysim("init", "assess-seat").code == 0
    file = tmp_path / "assess-seat.yaml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    error = refused("assess", file.name)
    assert re.search(rf"\.yaml:\d+:\d+: .*{place}: the record does not exist", error)


def test_results_name_no_absolute_path(tmp_path):
    text = (gallery.find("assess-seat").file).read_text(encoding="utf-8")
    record = gallery.find("assess-seat").file.with_name("fit-seat-synthetic.csv")
    (tmp_path / "seat.yaml").write_text(
        text.replace(record.name, str(record)), encoding="utf-8"
    )
    result = drysim.assess(drysim.load(tmp_path / "seat.yaml"))
    result.save(tmp_path / "out", plots=False)
    for name in ("drysim.json", "assess.csv", "spectra.csv"):
        content = (tmp_path / "out" / name).read_text(encoding="utf-8")
        assert str(record.parent) not in content


def test_result_on_the_disk_can_be_assessed_again(tmp_path):
    runs = {name: seat_record(seed=i, noise=0.01) for i, name in enumerate("ab")}
    result = assess(tmp_path, {"checks": ["SEAT < 2", "stuck_share < 1"]}, **runs)
    folder = result.save(tmp_path / "out", report=True)
    fields = fields_of(folder)
    assert [run["file"] for run in fields["assess"]["runs"]] == ["a.csv", "b.csv"]
    assert fields["assess"]["runs"][0]["metrics"]["SEAT"] == result.runs[0].metrics["SEAT"]
    assert [check["passed"] for check in fields["checks"]] == [True, False]
    again = drysim.assess(drysim.load(folder / "scenario.yaml"))
    assert again.metrics == result.metrics
    page = (folder / "report.html").read_text()
    assert '<body class="sheet">' in page
    assert "name, signature" in page
    table = result.to_frame()
    assert list(table["SEAT"]) == [run.metrics["SEAT"] for run in result.runs]
    curves = result.to_frame("spectra")
    np.testing.assert_allclose(curves["H1"], np.abs(result.transfer.H1), rtol=1e-12)
