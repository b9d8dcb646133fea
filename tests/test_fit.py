"""Fits of friction, damping and stiffness: twins come back, faults are named."""

from __future__ import annotations

import json
import random
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from seat import fields_of, rows_of, tree
from shown import show
from twin import RECORDED, fit_text, fit_twin, keys, values_of, write_columns, write_twin

import drysim
from drysim.parallel import WorkerPool
from drysim.results.fit import describe_interval, summarise
from drysim.scenario.load import load
from drysim.study import fit_base_noise
from drysim.study.fit import count_steps
from drysim.study.fit_law import (
    LawFit,
    Parameter,
    Steps,
    first_alike,
    fit_law,
    ignore_progress,
    profiles_of,
    refit_from_profiles,
    under_base_noise,
)
from drysim.study.fit_least_squares import Differentiable, LeastSquares, final_fit, sizes
from drysim.study.fit_model import build_model, fitted_end
from drysim.study.fit_profiles import ProfilePoint, _profile_end
from drysim.study.fit_warnings import fit_warnings
from drysim.study.store import Store
from fuzz.mutate import damaged

K_X, B, F_FK = 7500.0, 500.0, 20.0
SEAT = f"oscillator: {{mass: 75, stiffness: {K_X}, damping: {B}}}\n"
MASS = "oscillator: {mass: 75}\n"
COULOMB = "friction: {law: coulomb}\n"
SPRING = ("oscillator.damping", "oscillator.stiffness")
PLANT = {"oscillator.damping": B, "oscillator.stiffness": K_X}
KINETIC = {"friction.kinetic": F_FK} | PLANT
WEIGHED = "friction: {law: coulomb, normal: 200 N}\n"


def friction(words: str) -> str:
    """Return a block of Coulomb friction."""
    return f"friction: {{law: coulomb, {words}}}\n"


STICKY = friction("kinetic: 20, static_ratio: 1.5")
FOUR = {"friction.kinetic": F_FK, "friction.static_ratio": 1.5} | PLANT


# Noise-free twins, without a start by the user

BY_RATIO = {"friction.kinetic": F_FK, "friction.static_ratio": 1.5}
TWINS = {
    "kinetic friction alone": (SEAT + friction("kinetic: 20"), MASS + COULOMB, KINETIC),
    "static ratio": (SEAT + STICKY, MASS + COULOMB, FOUR),
    "static limit": (
        SEAT + friction("kinetic: 20, static: 26"), MASS + COULOMB,
        KINETIC | {"friction.static": 26.0},
    ),
    "damping ratio": (
        "oscillator: {mass: 75, stiffness: 7500, damping_ratio: 0.3}\n" + STICKY,
        MASS + COULOMB,
        BY_RATIO | {"oscillator.stiffness": K_X, "oscillator.damping_ratio": 0.3},
    ),
    "natural frequency": (
        "oscillator: {mass: 75, natural_frequency: 1.6, damping_ratio: 0.3}\n" + STICKY,
        MASS + COULOMB,
        BY_RATIO | {"oscillator.natural_frequency": 1.6, "oscillator.damping_ratio": 0.3},
    ),
    "mass beside the natural frequency": (
        "oscillator: {mass: 75, natural_frequency: 1.6, damping: 500}\n" + STICKY,
        "oscillator: {natural_frequency: 1.6, damping: 500}\n" + COULOMB,
        {"oscillator.mass": 75.0} | BY_RATIO,
    ),
    "coefficients under a normal force": (
        SEAT + friction("mu_kinetic: 0.1, mu_static: 0.14, normal: 200 N"),
        MASS + WEIGHED,
        {"friction.mu_kinetic": 0.1, "friction.mu_static": 0.14} | PLANT,
    ),
    "stroke": (SEAT + STICKY, MASS + COULOMB, FOUR, "x_r: x_r"),
    "relative velocity": (SEAT + STICKY, MASS + COULOMB, FOUR, "v_r: v_r"),
    "acceleration and stroke": (SEAT + STICKY, MASS + COULOMB, FOUR, "x_dd: x_dd, x_r: x_r"),
    "mass": (
        SEAT + STICKY, "oscillator: {stiffness: 7500}\n" + COULOMB,
        {"oscillator.mass": 75.0, "oscillator.damping": B} | BY_RATIO,
    ),
    "no friction": (
        SEAT + friction("kinetic: 0"), MASS + COULOMB, KINETIC | {"friction.kinetic": 0.0},
    ),
    "jenkins": (
        SEAT + "friction: {law: jenkins, kinetic: 20, tangential_stiffness: 20e3}\n",
        MASS + "friction: {law: jenkins, tangential_stiffness: 20e3}\n", KINETIC,
    ),
}  # fmt: skip


@pytest.mark.parametrize("twin", TWINS.values(), ids=TWINS)
def test_noise_free_twin_comes_back(tmp_path, twin):
    truth, known, wanted, *measured = twin
    write_twin(tmp_path, truth)
    found = values_of(fit_twin(tmp_path, known, keys(*wanted), *measured))
    assert found == pytest.approx(wanted, rel=1e-8, abs=1e-8)


def edited(folder: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Change the table of run.csv."""
    file = folder / "run.csv"
    header = file.read_text().partition("\n")[0]
    table = change(np.loadtxt(file, delimiter=",", skiprows=1))
    write_columns(file, dict(zip(header.split(","), table.T, strict=False)))


def delayed(table: np.ndarray) -> np.ndarray:
    """Return the table with an acceleration that lags by three samples."""
    table[3:, 1] = table[:-3, 1]
    return table


def load_twin(folder: Path, *words: str) -> drysim.Scenario:
    """Return the scenario that fits the twin of a folder."""
    (folder / "twin.yaml").write_text(fit_text(*words))
    return drysim.load(folder / "twin.yaml")


def only(result: drysim.FitResult, slug: str) -> str:
    """Return the sentence of the one warning of a kind."""
    (warning,) = (one for one in result.warnings if one.slug == slug)
    return warning.sentence


def test_static_ratio_at_its_end_of_1_comes_back(tmp_path):
    # Just above 1 the mass slides from rest as x_r'' = 0, so that the effect of the ratio on
    # the motion is quadratic: the root of the rounding is all that can be known.
    write_twin(tmp_path, SEAT + friction("kinetic: 20"))
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    wanted = FOUR | {"friction.static_ratio": 1.0}
    assert values_of(result) == pytest.approx(wanted, rel=1e-6)
    del wanted["friction.static_ratio"]
    found = {key: value for key, value in values_of(result).items() if key in wanted}
    assert found == pytest.approx(wanted, rel=1e-8)
    ratio = static_ratio(result)
    assert ratio.value == ratio.bound == 1.0
    assert describe_interval(ratio) == "at its bound"
    assert only(result, "at-bound") == "friction.static_ratio ends at 1, its least value"


def test_uncertainty_in_percent_is_left_out_where_it_would_mislead():
    at = Parameter("start.v_r", "m/s", 0.2, 0.01, 0.18, 0.22, 0.18, 0.22)
    assert describe_interval(at) == "95 %: 0.18 to 0.22 (±10 %)"
    at = at._replace(low=-0.1, high=0.5, profile_low=-0.1, profile_high=0.5)
    assert describe_interval(at) == "95 %: -0.1 to 0.5"
    at = at._replace(low=0.199, high=0.22, profile_low=0.199, profile_high=0.22)
    assert describe_interval(at) == "95 %: 0.199 to 0.22"


@pytest.mark.parametrize("ratio", [1.12, 1.47, 2.2, 7.7])
def test_motion_at_a_bound_is_solved_whatever_the_scale(tmp_path, ratio):
    # 1 / 1.47 times 1.47 is below 1 after rounding, where no scene has a static ratio.
    write_twin(tmp_path, SEAT + STICKY, seconds=0.5)
    free = keys("friction.static_ratio", *KINETIC)
    model = build_model(load_twin(tmp_path, MASS + COULOMB, free))
    start = np.array([ratio, F_FK, B, K_X])
    squares = LeastSquares.starting_from(model, 0.5, start)
    assert squares.solve(squares.bounds[0] + [0.0, 1.0, 1.0, 1.0]) is not None


def test_free_decay_comes_back_with_its_start(tmp_path):
    rest = (
        "excitation: {kind: rest}\nsolver: {step: 2.5e-3}\n"
        "measure: {steady: false, settle: 0, duration: 4}\n"
    )
    weak = "oscillator: {mass: 75, stiffness: 7500, damping: 40}\n"
    start = "start: {x_r: 0.02, v_r: 0.1}\n"
    write_twin(tmp_path, weak + friction("kinetic: 8, static_ratio: 1.3") + rest + start)
    wanted = {"start.x_r": 0.02, "friction.kinetic": 8.0} | PLANT
    wanted["oscillator.damping"] = 40.0
    known = MASS + COULOMB + rest + "start: {v_r: 0.1}\n"
    result = fit_twin(tmp_path, known, keys(*wanted))
    assert values_of(result) == pytest.approx(wanted, rel=1e-8)
    assert result.metrics["fit_error_held_out"] is None


@pytest.mark.parametrize("law", ["stribeck", "lugre"])
def test_law_with_series_comes_back_from_the_values_of_the_file(tmp_path, law):
    more = ", bristle_stiffness: 1e5, bristle_damping: 10" if law == "lugre" else ""
    words = f"law: {law}, static: 30, stribeck_velocity: 0.02{more}"
    write_twin(tmp_path, SEAT + f"friction: {{{words}, kinetic: 20}}\n", seconds=1.5)
    known = (
        "oscillator: {mass: 75, stiffness: 7500, damping: 450}\n"
        f"friction: {{{words}, kinetic: 15}}\n"
    )
    result = fit_twin(tmp_path, known, keys("friction.kinetic", "oscillator.damping"))
    wanted = {"friction.kinetic": F_FK, "oscillator.damping": B}
    assert values_of(result) == pytest.approx(wanted, rel=1e-5)


def test_stiffness_of_an_elastic_contact_comes_back_from_its_bounds(tmp_path):
    law = "law: jenkins"
    write_twin(
        tmp_path, SEAT + f"friction: {{{law}, kinetic: 20, tangential_stiffness: 20e3}}\n"
    )
    known = f"oscillator: {{mass: 75, stiffness: 7500}}\nfriction: {{{law}}}\n"
    free = "friction.tangential_stiffness: {from: 5e3, to: 80e3}, "
    wanted = {"friction.kinetic": F_FK, "oscillator.damping": B}
    result = fit_twin(tmp_path, known, free + keys(*wanted))
    wanted["friction.tangential_stiffness"] = 20e3
    assert values_of(result) == pytest.approx(wanted, rel=1e-8)


# Times of a decay, and records that begin in mid-motion

DECAY = (
    "excitation: {kind: rest}\nsolver: {step: 5 ms}\n"
    "measure: {steady: false, settle: 0, duration: 2 s}\n"
)
RELEASED = {"oscillator.stiffness": 800.0, "oscillator.damping": 1.2, "friction.kinetic": 1.5}
LET_GO = "oscillator: {mass: 2 kg}\n" + COULOMB + DECAY


def write_decay(folder: Path, clock: float = 0.0, held: int = 0, noise: float = 4e-5) -> None:
    """Write run.csv: 2 s of a mass of 2 kg after its release, held for some samples before."""
    motion = drysim.simulate(
        m=2.0, k_x=800.0, b=1.2, F_fk=1.5, u_dd=np.zeros(401), dt=5e-3, x_r=0.03
    )
    x_r = np.concatenate((np.full(held, 0.03), motion.x_r))
    t = clock + 5e-3 * np.arange(len(x_r))
    x_r += noise * np.random.default_rng(4).normal(size=len(x_r))
    write_columns(folder / "run.csv", {"t [s]": t, "x_r [m]": x_r})


@pytest.mark.parametrize("clock", [100.0, -0.5, 1.7e9])
def test_decay_begins_with_its_first_sample_whatever_its_clock(tmp_path, clock):
    found = []
    late = f", window: {{from: {clock + 0.5}}}"
    for begin, window in ((0.0, ""), (clock, ""), (clock, late)):
        write_decay(tmp_path, begin)
        scenario = load_twin(tmp_path, LET_GO, keys(*RELEASED), f"x_r: x_r{window}")
        found.append(build_model(scenario))
    same, moved, cut = (one.measurement for one in found)
    assert np.allclose(same.t, moved.t, atol=1e-6)
    assert np.allclose(cut.t, same.t[:-100], atol=1e-6)
    assert np.array_equal(same.channels["x_r"], moved.channels["x_r"])
    assert np.array_equal(same.channels["x_r"][100:], cut.channels["x_r"])
    assert np.array_equal(found[0].starts(), found[1].starts())


def test_decay_sampled_unlike_the_step_of_the_solver_is_refused_with_the_step(tmp_path):
    write_decay(tmp_path)
    coarse = LET_GO.replace("step: 5 ms", "step: 8 ms")
    with pytest.raises(drysim.RecordError, match=r"set solver\.step to 0\.005 s"):
        fit_twin(tmp_path, coarse, keys(*RELEASED), "x_r: x_r")
    assert len(fit_twin(tmp_path, LET_GO, keys(*RELEASED), "x_r: x_r").parameters) == 5


def test_decay_of_a_window_comes_back_and_its_scenario_runs_the_same_stretch(tmp_path):
    write_decay(tmp_path, 100.0, held=200)
    result = fit_twin(tmp_path, LET_GO, keys(*RELEASED), "x_r: x_r, window: {from: 101 s}")
    assert [one.key for one in result.parameters] == [*RELEASED, "start.x_r", "start.v_r"]
    for one in result.parameters:
        wanted = RELEASED | {"start.x_r": 0.03, "start.v_r": 0.0}
        assert abs(one.value - wanted[one.key]) < 4.0 * one.deviation
    assert result.warnings == ()
    again = drysim.run(result.scenario).response.x_r
    assert np.array_equal(again, result.prediction.channels["x_r"])
    assert again[0] == pytest.approx(0.03, rel=1e-2)


def test_mass_that_is_held_before_its_release_is_named(tmp_path):
    write_decay(tmp_path, held=200)
    said = only(fit_twin(tmp_path, LET_GO, keys(*RELEASED), "x_r: x_r"), "bad-fit")
    assert re.search(r"held for the first (1|1\.0\d|0\.99\d?) s: let `window` begin", said)


def test_decay_that_begins_amid_a_swing_contradicts_a_stated_start(tmp_path):
    write_decay(tmp_path)
    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    (tmp_path / "run.csv").write_text("\n".join([header, *rows[20:]]))
    known, free = LET_GO + "start: {v_r: 0}\n", keys(*RELEASED, "start.x_r")
    said = only(fit_twin(tmp_path, known, free, "x_r: x_r"), "bad-fit")
    assert "does not begin with the stated start.v_r: without this key in the file" in said
    assert "lag" not in said


@pytest.fixture
def refused_fit(refused, tmp_path):
    """Return the error of a scenario that a command computes and writes nothing of."""

    def error(text, command="fit"):
        (tmp_path / "seat.yaml").write_text(text)
        return refused(command, "seat.yaml")

    return error


@pytest.mark.parametrize("where", ["delay: 5 ms", "free"])
def test_delay_behind_a_base_at_rest_is_refused(refused_fit, tmp_path, where):
    write_decay(tmp_path)
    more = ["measured.delay"] if where == "free" else []
    measured = "x_r: x_r" + ("" if more else f", {where}")
    said = refused_fit(fit_text(LET_GO, keys(*RELEASED, *more), measured))
    assert "measured.delay: nothing lags behind a base at rest; remove it" in said


def test_times_since_1970_under_a_sine_are_named_before_any_work(refused_fit, tmp_path):
    write_decay(tmp_path, 1.7e9)
    sine = "excitation: {kind: harmonic, frequency: 2 Hz, rms: 1}\nsolver: {step: 5 ms}\n"
    known = "oscillator: {mass: 2 kg}\n" + COULOMB + sine
    said = refused_fit(fit_text(known, keys(*RELEASED), "x_r: x_r"))
    assert "its times begin 1.7e9 s after time 0, at which the base motion starts" in said


def cut_records(folder: Path, begin: float) -> dict[str, float]:
    """Cut base.csv and run.csv at a time, which becomes 0; return the state there."""
    state = {}
    for name in ("base", "run"):
        header = (folder / f"{name}.csv").read_text().partition("\n")[0].split(",")
        table = np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1)
        table = table[table[:, 0] > begin - 1e-9]
        state |= {one.split(" ")[0]: float(v) for one, v in zip(header, table[0], strict=True)}
        table[:, 0] -= table[0, 0]
        write_columns(folder / f"{name}.csv", dict(zip(header, table.T, strict=True)))
    return state


@pytest.mark.parametrize("measured", ["x_dd", "x_r"])
def test_record_that_begins_in_mid_motion_comes_back_with_its_start(tmp_path, measured):
    write_twin(tmp_path, SEAT + STICKY)
    state = cut_records(tmp_path, 1.5)
    assert abs(state["v_r"]) > 0.005  # in mid-motion
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), f"{measured}: {measured}")
    wanted = FOUR | {"start.x_r": state["x_r"], "start.v_r": state["v_r"]}
    assert values_of(result) == pytest.approx(wanted, rel=1e-7)
    assert result.warnings == ()
    again = drysim.run(result.scenario).response.x_r
    assert np.array_equal(again, result.prediction.channels["x_r"])


def test_stated_start_that_the_record_contradicts_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_r": 1e-4})
    cut_records(tmp_path, 1.5)
    known = SEAT + COULOMB + "start: {x_r: 0, v_r: 0}\n"
    result = fit_twin(tmp_path, known, keys("friction.kinetic"), "x_r: x_r")
    (kinetic,) = result.parameters
    assert not kinetic.low <= F_FK <= kinetic.high
    told = "does not begin with the stated start.x_r and start.v_r"
    assert told in only(result, "start-differs")


@pytest.mark.parametrize(("begin", "fitted"), [(0.0, ()), (1.5, ("start.x_r", "start.v_r"))])
def test_start_is_at_rest_unless_more_than_noise_of_the_base_shows_it(tmp_path, begin, fitted):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_r": 1e-4}, seed=5)
    cut_records(tmp_path, begin)
    base_with_noise(tmp_path, 0.02)
    scenario = load_twin(tmp_path, MASS + COULOMB, keys(*FOUR), "x_r: x_r")
    model = build_model(scenario).with_free_start(["start.x_r", "start.v_r"])
    with WorkerPool(1) as pool:
        steps = Steps(pool)
        end = fitted_end(scenario, model.measurement)
        law_fit = under_base_noise(fit_law(model, end, steps, ignore_progress), steps)
    assert [p.key for p in law_fit.model.parameters] == [*FOUR, *fitted]
    assert law_fit.base_noise.level == pytest.approx(0.02, rel=0.3)


# Derivatives in closed form

ALL_CHANNELS = "x_dd: x_dd, v_r: v_r, x_r: x_r"
STICK_SLIP = (SEAT + STICKY, MASS + COULOMB, FOUR)
ELASTIC = TWINS["jenkins"]


def squares_at_truth(
    folder: Path, truth: str, known: str, wanted: dict[str, float], rate: float, delay: float
) -> tuple[LeastSquares, np.ndarray]:
    """Return the residuals of a twin with free delay and offsets, and where it is true."""
    write_twin(folder, truth, seconds=2.0, rate=rate)
    free = keys(*wanted, "measured.delay", "measured.offset")
    model = build_model(load_twin(folder, known, free, ALL_CHANNELS))
    at = wanted | {"measured.delay": delay}
    values = np.array([at[one.key] for one in model.parameters])
    squares = LeastSquares.starting_from(model, 2.0, values)
    return squares, values / squares.scale


def errors_of_slopes(function: Differentiable, x: np.ndarray, h: float) -> np.ndarray:
    """Return relative deviations of derivatives from central differences, one a column."""
    columns = [
        (function.value(x + step) - function.value(x - step)) / (2.0 * step.sum())
        for step in np.diag(h * sizes(x))
    ]
    by_differences, slopes = np.stack(columns, axis=1), function.slopes(x)
    errors = np.linalg.norm(slopes - by_differences, axis=0)
    return errors / np.linalg.norm(by_differences, axis=0)


@pytest.mark.parametrize("delay", [4.2e-3, -4.2e-3])
@pytest.mark.parametrize("twin", [STICK_SLIP, ELASTIC], ids=["stick-slip", "elastic"])
def test_slopes_of_samples_between_events_are_those_of_differences(tmp_path, twin, delay):
    squares, x = squares_at_truth(tmp_path, *twin, 400.0, delay)
    h = 1e-4
    mask = squares.unchanged(x, h * sizes(x))
    assert mask.mean() > 0.9
    assert errors_of_slopes(squares.over(mask), x, h).max() < 1e-6


@pytest.mark.parametrize("delay", [4.2e-3, -4.2e-3])
def test_slopes_of_integrals_without_jumps_are_those_of_differences(tmp_path, delay):
    # Behind a spring the acceleration is continuous: what is left is the error of the
    # trapezoidal rule, a few times the share of a step in the time scale of the motion.
    squares, x = squares_at_truth(tmp_path, *ELASTIC, 8000.0, delay)
    assert errors_of_slopes(squares.integrated, x, 1e-3).max() < 2e-3


@pytest.mark.parametrize("delay", [1.3e-4, -1.3e-4])
def test_slopes_of_integrals_with_jumps_are_those_of_wide_differences(tmp_path, delay):
    # A jump counts in a sum of samples once it passes one: the step must move it past many.
    # The static ratio moves few of them, the delay all of the samples at once.
    squares, x = squares_at_truth(tmp_path, *STICK_SLIP, 20_000.0, delay)
    errors = errors_of_slopes(squares.integrated, x, 0.04)
    at_most = {"friction.static_ratio": 0.2, "measured.delay": 1e-3}
    for one, error in zip(squares.model.parameters, errors, strict=True):
        assert error < at_most.get(one.key, 0.08)


# Noise, delay, offset, other axes


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    """Return the fit of a twin with noise, and its folder."""
    folder = tmp_path_factory.mktemp("noisy")
    write_twin(folder, SEAT + STICKY, noise={"x_dd": 0.02})
    checks = "checks: [fit_error < 10 %, fit_error_held_out < 1 %, T_a < 5]\n"
    return fit_twin(folder, MASS + COULOMB, keys(*FOUR), more=checks), folder


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Return the fit of two seconds with noise, and its folder."""
    folder = tmp_path_factory.mktemp("short")
    write_twin(folder, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=2.0)
    checks = "checks: [fit_error_held_out < 1 %]\n"
    return fit_twin(folder, MASS + COULOMB, keys(*FOUR), more=checks), folder


def test_intervals_of_a_noisy_twin_hold_the_truth(noisy):
    result, _ = noisy
    for one in result.parameters:
        if one.key != "friction.static_ratio":
            assert one.low < FOUR[one.key] < one.high
            assert one.profile_low < FOUR[one.key] < one.profile_high
            assert one.deviation < 0.05 * one.value
    assert result.channels[0].noise == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("seed", [9, 10])
def test_stops_that_are_just_made_or_just_missed_narrow_no_interval(tmp_path, seed):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seed=seed)
    for one in fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR)).parameters:
        low = one.profile_low if one.deviation is None else one.value - 4.0 * one.deviation
        high = one.profile_high if one.deviation is None else one.value + 4.0 * one.deviation
        assert low < FOUR[one.key] < high


def test_fit_goes_on_from_a_lower_minimum_that_a_profile_finds(tmp_path, monkeypatch):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seed=9)
    scenario = load_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    model = build_model(scenario)
    ends = zip(model.parameters, model.bounds[0], strict=True)
    start = np.array([low if "ratio" in p.key else FOUR[p.key] for p, low in ends])
    first = LeastSquares.starting_from(model, fitted_end(scenario, model.measurement), start)
    start /= first.scale
    stuck = LawFit(model, first, (start,), final_fit(first, start))
    # Without a static limit above kinetic friction the mass never stops long enough.
    assert model.point(stuck.values)["friction.static_ratio"] < 1.01
    profiles = profiles_of(stuck, Steps(WorkerPool(1)))
    assert min(point.rise for one in profiles.values() for point in one.points) < -100.0
    better = refit_from_profiles(stuck, profiles)
    assert better is not None
    assert model.point(better.values)["friction.static_ratio"] == pytest.approx(1.5, rel=0.03)
    assert better.error < stuck.error
    assert refit_from_profiles(better, profiles_of(better, Steps(WorkerPool(1)))) is None

    # The fit itself goes on, a bounded number of times.
    monkeypatch.setattr("drysim.study.fit.fit_law", lambda *_: stuck)
    ratio = static_ratio(drysim.fit(scenario))
    assert ratio.profile_low < 1.5 < ratio.profile_high


def test_starts_agree_unless_they_differ_in_more_than_the_static_limit(short):
    folder = short[1]
    scenario = drysim.load(folder / "twin.yaml")
    model = build_model(scenario)
    end = fitted_end(scenario, model.measurement)
    first = LeastSquares.starting_from(model, end, np.array(list(FOUR.values())))
    solution = final_fit(first, np.ones(len(FOUR)))

    def near(key: str, factor: float) -> np.ndarray:
        return solution.x * [factor if p.key == key else 1.0 for p in model.parameters]

    assert [p.key for p in model.parameters] == list(FOUR)
    same = tuple(near("friction.static_ratio", factor) for factor in (0.7, 0.9, 1.0, 1.3))
    others = tuple(near(key, 1.3) for key in ("friction.kinetic", *SPRING))
    assert LawFit(model, first, same, solution).starts == (4, 4)
    assert LawFit(model, first, others, solution).starts == (0, 3)
    one_alone = LawFit(model, first, same[:1] + others, solution)
    assert one_alone.starts == (1, 4)
    warned = {
        each.slug: each.sentence for each in fit_warnings(one_alone, short[0].parameters, ())
    }
    assert warned["starts-disagree"].startswith("only 1 of 4 starts led to this solution")


def test_starts_that_meet_in_the_parts_of_a_record_are_followed_as_the_first_of_them():
    x = np.array([1.0, 0.5, 0.0])
    assert first_alike([x, 2.0 * x, x + 1e-9, x + 1e-3, 2.0 * x]) == [0, 1, 0, 3, 1]


def test_noise_whose_neighbours_are_alike_makes_the_intervals_too_narrow(short, tmp_path):
    assert not any(one.slug == "residuals-not-white" for one in short[0].warnings)
    response = write_twin(tmp_path, SEAT + STICKY, seconds=2.0)
    t, x_dd = np.asarray(response.t), np.asarray(response.x_dd)
    noise = np.convolve(np.random.default_rng(1).normal(size=len(t) + 3), np.ones(4), "valid")
    columns = {"t [s]": t, "x_dd [m/s2]": x_dd + 0.01 * noise}
    write_columns(tmp_path / "run.csv", columns)
    sentence = only(fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR)), "residuals-not-white")
    (correlation,) = re.findall(r"x_dd are not white .*neighbours (.*)\)", sentence)
    assert float(correlation) == pytest.approx(0.75, abs=0.1)  # three of four terms are shared
    assert "too narrow, by a factor of at least 2" in sentence


def test_noise_of_the_file_sets_the_intervals(noisy, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02})
    more = "  noise: {x_dd: 0.04 m/s2}\n"
    wide = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), more=more)
    assert wide.channels[0].noise == pytest.approx(0.02, rel=0.1)  # that of the record
    for one, other in zip(wide.parameters, noisy[0].parameters, strict=True):
        if one.key in PLANT:
            assert one.deviation == pytest.approx(2.0 * other.deviation, rel=0.3)


def base_with_noise(folder: Path, noise: float) -> None:
    """Add white noise to base.csv."""
    t, u_dd = np.loadtxt(folder / "base.csv", delimiter=",", skiprows=1, unpack=True)
    u_dd = u_dd + noise * np.random.default_rng(8).normal(size=len(t))
    write_columns(folder / "base.csv", {"t [s]": t, "u_dd [m/s2]": u_dd})


def test_intervals_contain_the_noise_of_the_base(drysim, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.005})
    base_with_noise(tmp_path, 0.02)
    results = {
        stated: fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), more=stated)
        for stated in (
            *("", "  noise: {u_dd: 0.02 m/s2}\n"),
            "  noise: {u_dd: 0.02 m/s2, x_dd: 0.005 m/s2}\n",
            "  noise: {u_dd: 0 m/s2}\n",
        )
    }
    estimated, stated, each, exact = results.values()
    for one, other in zip(each.parameters, stated.parameters, strict=True):
        assert one.deviation == pytest.approx(other.deviation, rel=0.1)
    assert estimated.base_noise.level == pytest.approx(0.02, rel=0.3)
    assert (stated.base_noise.level, stated.base_noise.is_stated) == (0.02, True)
    for key in PLANT:
        wide, least = (
            next(one.deviation for one in result.parameters if one.key == key)
            for result in (stated, exact)
        )
        assert wide > 1.3 * least, key
    assert "residuals-not-white" in {warning.slug for warning in exact.warnings}
    assert "residuals-not-white" not in {warning.slug for warning in estimated.warnings}
    done = drysim("fit", "twin.yaml", "--out", "out")
    assert "noise u_dd" not in done.out  # taken as exact
    (tmp_path / "twin.yaml").write_text(
        fit_text(MASS + COULOMB, keys(*FOUR), more="  noise: {u_dd: 0.02 m/s2}\n")
    )
    done = drysim("fit", "twin.yaml", "--out", "out")
    sentence = "noise u_dd 0.02 m/s² of the base, stated; the intervals contain it"
    assert sentence in " ".join(done.out.split())


def test_motion_of_high_frequency_is_no_noise_of_the_base(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    base_with_noise(tmp_path, 0.05)
    write_twin(tmp_path, SEAT + STICKY + RECORDED, noise={"x_dd": 0.005})
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert result.base_noise.level < 0.01


def test_noise_of_the_base_under_which_nothing_can_be_solved_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(fit_base_noise, "change_under", lambda *_: None)
    write_twin(tmp_path, SEAT + STICKY)
    base_with_noise(tmp_path, 0.02)
    write_twin(tmp_path, SEAT + STICKY + RECORDED, noise={"x_dd": 0.005})
    more = "  noise: {u_dd: 0.02 m/s2}\n"
    with pytest.raises(drysim.SolverError, match=r"noise of the base of 0\.02 m/s²; `fit\."):
        fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), more=more, workers=1)


@pytest.mark.parametrize(
    ("known", "measured", "sentence"),
    [
        ("excitation: {kind: harmonic, frequency: 2, rms: 1}\nsolver: {step: 2.5 ms}\n",
         "x_dd: x_dd", "the base motion is none"),
        ("", "F_f: F_f, v_r: v_r", "is that of a base, which a rig has not"),
    ],
)  # fmt: skip
def test_noise_of_a_base_that_is_no_record_is_refused(
    drysim, tmp_path, known, measured, sentence
):
    write_twin(tmp_path, SEAT + STICKY)
    more = "  noise: {u_dd: 0.02 m/s2}\n"
    text = fit_text(SEAT + COULOMB + known, keys("friction.kinetic"), measured, more)
    (tmp_path / "twin.yaml").write_text(text)
    done = drysim("fit", "twin.yaml")
    assert done.code == 2
    assert sentence in " ".join(done.err.split())


def test_free_delay_and_offset_come_back(tmp_path):
    def changed(table):
        table[:, 1] = 0.3 + np.interp(table[:, 0] - 4.2e-3, table[:, 0], table[:, 1])
        return table

    write_twin(tmp_path, SEAT + STICKY)
    edited(tmp_path, changed)
    free = keys(*FOUR, "measured.delay", "measured.offset")
    result = fit_twin(tmp_path, MASS + COULOMB, free)
    assert values_of(result) == pytest.approx(FOUR | {"measured.delay": 4.2e-3}, rel=1e-6)
    assert result.channels[0].offset == pytest.approx(0.3, rel=1e-6)
    assert result.metrics["fit_error"] < 1e-4  # without the samples before the motion


def test_known_delay_is_taken_from_the_file(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    edited(tmp_path, delayed)
    measured = "x_dd: x_dd, delay: 7.5 ms, window: {from: 0.1 s}"
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), measured)
    assert values_of(result) == pytest.approx(FOUR, rel=1e-8)


def test_window_of_the_measurement_is_placed_on_the_base_motion(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    measured = "x_dd: x_dd, window: {from: 1 s, to: 5 s}"
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), measured)
    assert values_of(result) == pytest.approx(FOUR, rel=1e-8)
    assert result.measurement.t[[0, -1]] == pytest.approx([1.0, 5.0])


def test_measurement_may_have_every_other_sample_of_the_base(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    edited(tmp_path, lambda table: table[::2])
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert values_of(result) == pytest.approx(FOUR, rel=1e-8)
    assert result.measurement.dt == pytest.approx(5e-3)


# Friction rigs

RIG = SEAT + "friction: {law: coulomb, normal: 100 N}\nexcitation: {kind: rest}\n"
RIG += "solver: {step: 5 ms}\nmeasure: {steady: false, settle: 0, duration: 1}\n"


@pytest.mark.parametrize("motion", ["v_r", "x_r"])
def test_coefficient_of_a_rig_is_the_mean_of_its_force(tmp_path, motion):
    t = np.arange(1600) * 5e-3
    x = 0.02 * np.sin(2 * np.pi * 0.7 * t) + 0.005 * np.sin(2 * np.pi * 1.9 * t + 1.0)
    v = np.gradient(x, 5e-3)
    force = 15.0 * np.sign(v) + np.random.default_rng(5).normal(size=len(t))
    columns = {"t [s]": t, "x_r [m]": x, "v_r [m/s]": v, "F_f [N]": force}
    write_columns(tmp_path / "run.csv", columns)
    measured = f"{motion}: {motion}, F_f: F_f"
    result = fit_twin(tmp_path, RIG, keys("friction.mu_kinetic"), measured)
    (mu,) = result.parameters
    assert mu.value == pytest.approx(np.mean(force * np.sign(v)) / 100.0, rel=5e-3)
    assert mu.profile_low < 0.15 < mu.profile_high
    assert mu.deviation == pytest.approx(0.01 / np.sqrt(len(t)), rel=0.1)


@pytest.mark.parametrize("motion", ["v_r", "x_r"])
@pytest.mark.parametrize("is_free", [False, True])
def test_force_of_a_rig_may_contain_those_of_its_spring_and_damper(tmp_path, motion, is_free):
    # A cosine: the imposed motion begins with an acceleration, and its spline with a slope.
    t = np.arange(800) * 5e-3
    x = 0.02 * np.cos(2 * np.pi * 0.7 * t) + 0.005 * np.cos(2 * np.pi * 1.9 * t + 1.0)
    v = -0.028 * np.pi * np.sin(1.4 * np.pi * t)
    v -= 0.019 * np.pi * np.sin(3.8 * np.pi * t + 1.0)
    noise = 0.3 * np.random.default_rng(5).normal(size=len(t))
    force = 2000.0 * x + 150.0 * v + 20.0 * np.sign(v) + noise
    columns = {"t [s]": t, "x_r [m]": x, "v_r [m/s]": v, "F_f [N]": force}
    write_columns(tmp_path / "run.csv", columns)
    known = "oscillator: {mass: 10, stiffness: 2000, damping: 150}\n" + friction("kinetic: 1")
    free = ("friction.kinetic", *SPRING) if is_free else ("friction.kinetic",)
    known += f"start: {{x_r: {float(x[0])!r}}}\n" + RIG.split("\n", 2)[2]
    result = fit_twin(tmp_path, known, keys(*free), f"{motion}: {motion}, F_f: F_f")
    wanted = dict(zip(("friction.kinetic", *SPRING), (20.0, 150.0, 2000.0), strict=True))
    for one in result.parameters:
        assert abs(one.value - wanted[one.key]) < 4.0 * one.deviation
        assert one.value == pytest.approx(wanted[one.key], rel=0.03)
    assert result.warnings == ()


def test_forces_of_a_rig_are_placed_on_the_grid_of_its_motion(tmp_path):
    # Uneven times of 2.3 ms, and a window that begins between two of them.
    t = np.arange(700) * 2.3e-3 + 100.0
    v = 0.1 * np.sin(2 * np.pi * 0.7 * (t - 100.0))
    columns = {"t [s]": t, "v_r [m/s]": v, "F_f [N]": 15.0 * np.sign(v)}
    write_columns(tmp_path / "run.csv", columns)
    measured = "v_r: v_r, F_f: F_f, window: {from: 100.1 s}, resample: {step: 1 ms, by: line}"
    model = build_model(load_twin(tmp_path, RIG, keys("friction.mu_kinetic"), measured))
    first = t[t >= 100.1][0]
    assert model.measurement.t[0] == pytest.approx(first - 100.1, abs=1e-9)
    found = model.solve(np.array([0.15])).prediction(("v_r",))
    expected = v[t >= 100.1][found.covers]
    assert len(expected) > 650
    assert found.channels["v_r"][found.covers] == pytest.approx(expected, abs=1e-4)


# Laws


@pytest.mark.parametrize("law", ["coulomb", "jenkins"])
def test_law_of_the_twin_is_the_best_on_held_out_data(tmp_path, law):
    words = {"coulomb": "static_ratio: 1.5", "jenkins": "tangential_stiffness: 20e3"}
    truth = SEAT + f"friction: {{law: {law}, kinetic: 20, {words[law]}}}\n"
    write_twin(tmp_path, truth, noise={"x_dd": 0.02}, seconds=5.0)
    known = MASS + "friction: {law: coulomb, jenkins: {tangential_stiffness: 20e3}}\n"
    more = f"  laws: [{'jenkins, coulomb' if law == 'coulomb' else 'coulomb, jenkins'}]\n"
    result = fit_twin(tmp_path, known, keys(*FOUR), more=more)
    assert result.laws[0].law == law
    assert [one.tied for one in result.laws] == [False, False]
    assert result.scenario.friction.law == law


def test_laws_that_cannot_be_told_apart_are_said_to_be_and_the_simpler_one_is_taken(tmp_path):
    write_twin(tmp_path, SEAT + friction("kinetic: 20"), noise={"x_dd": 0.02}, seconds=5.0)
    known = MASS + "friction: {law: coulomb, jenkins: {tangential_stiffness: 1e8}}\n"
    more = "  laws: [coulomb, jenkins]\n"
    result = fit_twin(tmp_path, known, keys("friction.kinetic", *PLANT), more=more)
    laws = [(one.law, one.tied) for one in result.laws]
    assert laws == [("coulomb", True), ("jenkins", True)]


# What a record does not tell


def test_only_ratios_follow_if_the_mass_and_all_forces_are_free(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    result = fit_twin(tmp_path, COULOMB, keys("oscillator.mass", *FOUR))
    assert only(result, "not-determined") == (
        "only the ratios of oscillator.mass, friction.kinetic, oscillator.damping and "
        "oscillator.stiffness follow; state one of them, usually the mass"
    )
    values = values_of(result)
    assert values["oscillator.stiffness"] / values["oscillator.mass"] == pytest.approx(100.0)
    known = [one.key for one in result.parameters if one.deviation is not None]
    assert known == ["friction.static_ratio"]


def test_static_ratio_has_no_value_without_a_stop(tmp_path):
    write_twin(tmp_path, SEAT + friction("kinetic: 2, static_ratio: 1.5"), rms=3.0)
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert only(result, "not-determined") == (
        "friction.static_ratio: the mass never sticks in 6 s, so that its value does not "
        "matter here"
    )
    found = values_of(result)
    assert found["friction.kinetic"] == pytest.approx(2.0, rel=1e-8)


def static_ratio(result: drysim.FitResult) -> Parameter:
    """Return the fitted static ratio."""
    return next(one for one in result.parameters if one.key == "friction.static_ratio")


def ratio_of_first_stop(result: drysim.FitResult) -> float:
    """Return the least ratio at which the fitted mass, which never sticks, would stop."""
    events = drysim.run(result.scenario).response.events
    # A mass at rest may not even begin to slide.
    return float(np.abs(events.F_L).min() / result.scenario.law().F_fk)


BY_HAND = (pytest.mark.slow, pytest.mark.by_hand)


@pytest.mark.parametrize(
    "seed", [3, 10, *(pytest.param(seed, marks=BY_HAND) for seed in range(20, 50))]
)
def test_static_ratio_of_a_mass_that_never_sticks_is_told_up_to_its_first_stop(tmp_path, seed):
    """If by any."""
    random = np.random.default_rng(seed)
    kinetic, noise = random.uniform(1.0, 4.0), random.uniform(0.05, 0.35)
    truth = SEAT + friction(f"kinetic: {kinetic}")
    write_twin(tmp_path, truth, noise={"x_dd": noise}, rms=3.0, seconds=4.0, seed=seed)
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    ratio = static_ratio(result)
    edited(tmp_path, lambda table: table * (1.0 + 1e-13 * random.normal(size=table.shape)))
    again = static_ratio(fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR)))
    for one in (ratio, again):
        assert (one.deviation, one.low, one.high, one.profile_low) == (None,) * 4
    assert (ratio.profile_high is None) == (again.profile_high is None)
    if ratio.value > 1.0:  # a stop may suit the noise
        return
    assert ratio.note.startswith("the mass never sticks in 4 s, so that its value does not")
    (profile,) = (one for one in result.profiles if one.key == "friction.static_ratio")
    first = ratio_of_first_stop(result)
    for factor in (0.1, 0.98):
        scenario = result.scenario.at({"friction.static_ratio": max(1.0, factor * first)})
        x_r = drysim.run(scenario).response.x_r
        assert np.array_equal(x_r, result.prediction.channels["x_r"])
    if ratio.profile_high is None:  # without friction no ratio matters
        assert next(iter(result.parameters)).profile_low is None
        return
    assert ratio.note.endswith(f"up to {ratio.profile_high:.4g}")
    assert ratio.profile_high > 0.98 * first
    assert (profile.rise[profile.values > ratio.profile_high] > 3.84).all()
    assert (profile.values > ratio.profile_high).any()


@pytest.mark.parametrize("end", [3.0, 30.0])
def test_static_ratio_that_the_record_does_not_tell_has_an_open_interval(tmp_path, end):
    # Its first stop is at a ratio of 44.
    write_twin(tmp_path, SEAT + friction("kinetic: 2"), noise={"x_dd": 0.3}, rms=3.0)
    free = keys(*KINETIC) + f", friction.static_ratio: {{to: {end}}}"
    ratio = static_ratio(fit_twin(tmp_path, MASS + COULOMB, free))
    assert (ratio.deviation, ratio.low, ratio.high) == (None, None, None)
    assert (ratio.profile_low, ratio.profile_high) == (None, None)
    assert ratio.note.endswith("its value does not matter here")


# Ends of a profile, of a rise that is stated

RISES: dict[str, Callable[[float, float], float]] = {
    "parabola": lambda d, scale: (d / scale) ** 2,
    "line": lambda d, scale: d / scale,
    "slow": lambda d, scale: np.log1p(d / scale),
    "saturates": lambda d, scale: 3.6 * d / (d + scale),
    "saturates above": lambda d, scale: 6.0 * d / (d + scale),
    "jump": lambda d, scale: 50.0 * (d > scale),
    "small jump": lambda d, scale: (d / scale) ** 2 / 5.0 + 4.0 * (d > scale),
    "wall": lambda d, scale: float(np.expm1(min(d / scale, 8.0) ** 3)),
    "none": lambda d, scale: 0.0,
    "lower minimum": lambda d, scale: (d / scale) ** 2 - 3.0 * (d / scale),
}


@pytest.mark.parametrize("rise", RISES.values(), ids=RISES)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_end_of_a_profile_is_excluded_and_open_only_where_nothing_is(monkeypatch, rise, sign):
    random = np.random.default_rng(7)
    for _ in range(200):
        x, scale = random.uniform(0.5, 2.0), 10.0 ** random.uniform(-6, 2)
        step = min(x, scale * 10.0 ** random.uniform(-2, 2))
        bound = x + sign * random.choice([10.0 ** random.uniform(-6, 3), np.inf])
        bounds = np.array([min(bound, x - sign * np.inf)]), np.array([max(bound, x)])
        monkeypatch.setattr(
            "drysim.study.fit_profiles._profile_point",
            lambda solution, others, j, at: ProfilePoint(
                at, rise(abs(at - solution.x[j]), solution.scale), solution.x
            ),
        )
        squares = SimpleNamespace(bounds=bounds)
        solution = SimpleNamespace(squares=squares, x=np.array([x]), scale=scale)
        end, points = _profile_end(solution, [], 0, sign * step)
        if end is None:
            farthest = min(abs(bound - x), 1e3 * x)
            assert rise(farthest, scale) < 3.85
            assert max(abs(one.value - x) for one in points) >= farthest
            continue
        distance = abs(end - x)
        assert (end - x) * sign > 0.0
        assert distance <= abs(bound - x)
        assert rise(distance, scale) > 0.95 * 3.84
        assert min(rise(share * distance, scale) for share in (0.5, 0.7, 0.9)) < 3.84
        assert len(points) <= 40


def test_reported_static_limit_is_the_lowest_point_of_its_one_profile(noisy):
    result, _ = noisy
    ratio = static_ratio(result)
    (profile,) = (one for one in result.profiles if one.key == "friction.static_ratio")
    lowest = profile.values[profile.rise.argmin()]
    assert profile.rise.min() == 0.0
    assert ratio.value == pytest.approx(lowest, rel=1e-12)
    assert ratio.profile_low < 1.5 < ratio.profile_high
    # Each value outside of the interval is worse by what 95 % allow.
    beyond = (profile.values < ratio.profile_low) | (profile.values > ratio.profile_high)
    assert (profile.rise[beyond] > 3.84).all()
    assert beyond.any()


STUCK = SEAT + friction("kinetic: 500")


@pytest.mark.parametrize("noise", [0.0, 0.01, 10.0])
def test_record_without_sliding_is_refused(drysim, tmp_path, noise):
    write_twin(tmp_path, STUCK, noise={"x_dd": noise}, seconds=2.0)
    (tmp_path / "seat.yaml").write_text(fit_text(MASS + COULOMB, keys(*FOUR)))
    before = tree(tmp_path)
    done = drysim("fit", "seat.yaml", "--no-plots")
    assert (done.code, done.out) == (3, "")
    assert "base and mass differ by less than the noise: nothing can be fitted" in done.err
    assert tree(tmp_path) == before


# Results


def test_result_shows_its_values_and_the_code_of_its_checks(noisy):
    result, _ = noisy
    assert repr(result).startswith("<FitResult of twin: friction.kinetic ")
    html = result._repr_html_()
    assert "95 %: " in html
    assert all(one.key in repr(result) for one in result.parameters)
    assert [one.passed for one in result.checks] == [True, False, True]
    assert result.exit_code() == 1


def test_summary_keeps_long_keys_apart_from_their_values(noisy, capsys):
    show(noisy[0])
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("  static_ratio  1.") for line in lines)
    assert any(line.startswith("  kinetic       19.9") for line in lines)


def test_fitted_scenario_runs_and_gives_the_fitted_motion(noisy):
    result, _ = noisy
    assert result.scenario.fit is None
    assert [str(check) for check in result.scenario.checks] == ["T_a < 5"]
    again = drysim.run(result.scenario).response
    assert np.array_equal(again.x_dd, result.prediction.channels["x_dd"])


def test_command_writes_files_that_run_and_can_be_fitted_again(drysim, short, tmp_path):
    result, _ = short
    copy_twin(short, tmp_path)
    done = drysim("fit", "twin.yaml", "--no-plots")
    assert done.code == 1
    assert done.err.splitlines()[-1] == "next: drysim run out/twin-fit/fitted.yaml"
    out = tmp_path / "out" / "twin-fit"
    names = "draws.csv drysim.json fit.csv fitted.yaml residuals.csv scenario.yaml"
    assert sorted(file.name for file in out.iterdir()) == names.split()
    rows = rows_of(out / "fit.csv")
    motion = {interval.name: interval.value for interval in result.motion_intervals}
    assert {row["key"]: float(row["value"]) for row in rows} == values_of(result) | motion
    columns = rows_of(out / "residuals.csv")[0]
    names = ["x_dd [m/s2]", "x_dd_fitted [m/s2]", "x_dd_residual [m/s2]"]
    assert list(columns) == ["t [s]", *names, "selected [-]", "held_out [-]"]
    assert [one["key"] for one in fields_of(out)["fit"]["parameters"]] == list(FOUR)
    assert drysim("run", "out/twin-fit/fitted.yaml", "--no-plots").code == 0
    again = drysim("fit", out / "scenario.yaml", "--no-plots", "--quiet", "--out", "out/again")
    assert again.code == 1
    again = tmp_path / "out" / "again" / "fit.csv"
    assert again.read_bytes() == (out / "fit.csv").read_bytes()


def test_fitted_scenario_keeps_sweep_checks_and_design(drysim, short, tmp_path):
    copy_twin(short, tmp_path)
    words = ["fit", "twin.yaml", "--no-plots", "--out", "out"]
    for block in (
        "sweep={oscillator.damping: [300, 400]}",
        "checks=[T_a < 5, T_a < 4 at oscillator.damping >= 350]",
        "design={vary: {oscillator.damping: {from: 100, to: 900}}, minimise: T_a, within: []}",
    ):
        words += ["--set", block]
        done = drysim(*words)
        command = "design" if "design" in block else "sweep"
        assert done.err.splitlines()[-1] == f"next: drysim {command} out/fitted.yaml"
        assert drysim("validate", "out/fitted.yaml").code == 0
    fitted = load("out/fitted.yaml")
    assert len(fitted.checks) == 2
    assert list(fitted.sweep[0].values) == [300.0, 400.0]
    assert fitted.design.minimise == ("T_a",)


def test_number_of_workers_changes_no_byte(drysim, short, tmp_path):
    copy_twin(short, tmp_path)
    base_with_noise(tmp_path, 0.02)
    results = [fitted_files(drysim, tmp_path, "--workers", workers) for workers in (1, 3)]
    assert results[0] == results[1]


def test_progress_counts_every_step(short):
    scenario, counts = drysim.load(short[1] / "twin.yaml"), list[int]()
    drysim.fit(scenario, workers=1, finished=counts.append)
    assert sum(counts) == count_steps(scenario)


@pytest.mark.parametrize("kept", [1, 9, 15])
def test_interrupted_fit_resumes_to_the_same_result(drysim, short, tmp_path, monkeypatch, kept):
    copy_twin(short, tmp_path)
    base_with_noise(tmp_path, 0.02)
    whole, write = fitted_files(drysim, tmp_path), Store.write_value

    def write_some(store, number, value):
        if number == kept:
            raise KeyboardInterrupt
        write(store, number, value)

    with monkeypatch.context() as patched:
        patched.setattr(Store, "write_value", write_some)
        done = drysim("fit", "twin.yaml", "--no-plots", "--out", "out")
    assert done.code == 130
    assert "the same command with --resume continues from here" in done.err
    files = sorted((tmp_path / "out.partial" / "steps").glob("*.npz"))
    assert len(files) == kept
    spoiled = files[kept // 2]
    spoiled.write_bytes(damaged([spoiled.read_bytes()], random.Random(kept)))
    written = []

    def write_counted(store, number, value):
        written.append(number)
        write(store, number, value)

    monkeypatch.setattr(Store, "write_value", write_counted)
    assert fitted_files(drysim, tmp_path, "--resume") == whole
    assert written[0] == kept // 2
    assert not (tmp_path / "out" / "steps").exists()


def copy_twin(short, folder: Path) -> None:
    """Copy the files of a twin into a folder."""
    for name in ("base.csv", "run.csv", "twin.yaml"):
        shutil.copy(short[1] / name, folder)


def fitted_files(drysim, folder: Path, *words: object) -> tuple[dict[str, bytes], Any]:
    """Fit a twin; return its files, drysim.json without what differs between runs."""
    words = ("--no-plots", "--quiet", *words, "--out", "out")
    assert drysim("fit", "twin.yaml", *words).code == 1
    files = tree(folder / "out")
    (name,) = (file for file in files if file.endswith("drysim.json"))
    fields = json.loads(files.pop(name))
    del fields["created"], fields["command"], fields["sha256"]
    return files, fields


def test_refused_fit_leaves_no_folder(drysim, short, tmp_path):
    copy_twin(short, tmp_path)
    text = (tmp_path / "twin.yaml").read_text()
    faults = {
        "record": text.replace("run.csv", "ran.csv"),
        "law": text.replace("free:", "laws: [coulomb, lugre]\n  free:"),
        "motion": text.replace("run.csv, ", "base.csv, ").replace("x_dd: x_dd", "x_dd: u_dd"),
    }
    for name, fault in faults.items():
        assert fault != text
        (tmp_path / f"{name}.yaml").write_text(fault)
        assert drysim("fit", f"{name}.yaml").code in (2, 3), name
        assert not (tmp_path / "out").exists(), name


def test_checks_on_the_fit_are_refused_elsewhere(refused_fit, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    text = SEAT + STICKY + RECORDED + "checks: [fit_error < 1 %]\n"
    told = "fit_error is known to `drysim fit` only; remove the check"
    assert told in refused_fit(text, "run")


# Faults of the records


MEASURED = {
    "missing file": ("x_dd: x_dd, file: none.csv", "none.csv: the record does not exist"),
    "missing column": ("x_dd: x_ddd", "there is no column `x_ddd`; did you mean `x_dd`?"),
    "same column": ("x_dd: x_dd, x_r: 2", "of run.csv, and so is fit.measured.x_dd: each"),
    "no unit": (
        "x_dd: {column: bare}",
        "column 6 (`bare`) has no unit; write `unit: m/s²` in the scenario's "
        "`fit.measured.x_dd` block, or `[m/s²]` into the header",
    ),
    "constant": (
        "x_dd: {column: bare, unit: m/s2}",
        "x_dd is 3 m/s² in every sample of column `bare`: no motion was recorded",
    ),
    "unit": ("x_dd: x_r", "`m` is a unit of length, not acceleration [m/s²]"),
    "step": (
        "x_dd: x_dd, step: 3 ms",
        "the measured response has a step of 0.003 s, the base motion 0.0025 s; add "
        "`resample: {step: 0.0025 s, by: line}` to fit.measured",
    ),
}


@pytest.mark.parametrize(("measured", "sentence"), MEASURED.values(), ids=MEASURED)
def test_measurement_that_cannot_be_used_is_refused(
    refused_fit, drysim, tmp_path, measured, sentence
):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    lines = [f"{header},bare", *(f"{row},3" for row in rows)]
    (tmp_path / "run.csv").write_text("\n".join(lines) + "\n")
    text = fit_text(MASS + COULOMB, keys(*FOUR), measured)
    if "file:" in measured:
        text = text.replace("file: run.csv, ", "")
    if "step:" in measured:
        text = text.replace("time: t, x_dd", "x_dd")
    assert sentence in refused_fit(text)
    assert drysim("validate", "seat.yaml").code == 2


@pytest.mark.parametrize(
    ("late", "told"),
    [(1e-3, "its samples lie between those of the base motion, by 0.001 s"),
     (5.0, "only 0 of 401 samples lie within the base motion; the two records need")],
)  # fmt: skip
def test_measurement_at_other_times_than_the_base_is_refused(refused_fit, tmp_path, late, told):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    edited(tmp_path, lambda table: table + np.eye(1, table.shape[1]) * late)
    assert told in refused_fit(fit_text(MASS + COULOMB, keys(*FOUR)))


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_values_that_only_a_fit_gives_are_missing_elsewhere(refused_fit, tmp_path, command):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    swept = "sweep: {oscillator.mass: [70, 80]}\n" if command == "sweep" else ""
    told = (
        "friction.kinetic has no value, as it is free in `fit`; use `drysim fit`, and then the "
        "fitted.yaml that it writes"
    )
    assert told in refused_fit(fit_text(MASS + COULOMB + swept, keys(*FOUR)), command)


def test_scenario_without_a_fit_block_is_refused(refused_fit, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    said = refused_fit(SEAT + STICKY + RECORDED)
    assert "seat has no fit block" in said


def test_key_without_a_start_is_named(refused_fit, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    known = MASS + "friction: {law: stribeck, static: 30}\n"
    free = keys("friction.kinetic", "friction.stribeck_velocity", *PLANT)
    said = refused_fit(fit_text(known, free))
    assert "friction.stribeck_velocity needs a start, as no closed form gives one" in said


def test_options_that_a_compared_law_lacks_are_named(refused_fit, drysim, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    text = fit_text(MASS + COULOMB, keys(*FOUR), more="  laws: [coulomb, jenkins]\n")
    said = refused_fit(text)
    assert "law jenkins needs friction.jenkins.tangential_stiffness" in said
    assert drysim("validate", "seat.yaml").code == 2


def test_dry_run_and_override_of_a_free_key(drysim, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    (tmp_path / "seat.yaml").write_text(fit_text(MASS + COULOMB, keys(*FOUR)))
    before = tree(tmp_path)
    change = "fit.free.friction.kinetic={start: 33 N}"
    done = drysim("fit", "seat.yaml", "--dry-run", "--set", change)
    assert done.code == 0
    assert "friction.kinetic 33 N" in done.out
    assert tree(tmp_path) == before


# Warnings that name the cause


def test_swapped_columns_are_named(tmp_path):
    response = write_twin(tmp_path, SEAT + STICKY, seconds=4.0)
    for name, values in (("base", response.x_dd), ("run", response.motion.u_dd[:])):
        column = "u_dd [m/s2]" if name == "base" else "x_dd [m/s2]"
        write_columns(tmp_path / f"{name}.csv", {"t [s]": response.t, column: values})
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert "base and mass seem to be swapped" in only(result, "bad-fit")


def test_wrong_sign_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    measured = "x_dd: {column: x_dd, scale: -1}"
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), measured)
    assert "the sign of x_dd seems to be wrong: remove `scale: -1`" in only(result, "bad-fit")


def test_delay_of_three_samples_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    edited(tmp_path, delayed)
    said = only(fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR)), "bad-fit")
    lag = re.search(r"seems to lag by (\S+) s: free `measured.delay`", said)
    assert float(lag[1]) == pytest.approx(7.5e-3, abs=0.5e-3)


def test_stated_delay_that_is_wrong_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), "x_dd: x_dd, delay: 0.03")
    assert ", not by the stated 0.03 s: free `measured.delay`" in only(result, "bad-fit")


def test_clipped_record_is_named(tmp_path):
    def clipped(table):
        table[:, 1] = np.clip(table[:, 1], -0.6, 0.6)
        return table

    write_twin(tmp_path, SEAT + STICKY, seconds=4.0)
    edited(tmp_path, clipped)
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert "record-clipped" in {one.slug for one in result.warnings}


def test_shorter_base_record_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY)
    lines = (tmp_path / "base.csv").read_text().splitlines(keepends=True)
    (tmp_path / "base.csv").write_text("".join(lines[:1801]))
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR))
    assert values_of(result) == pytest.approx(FOUR, rel=1e-8)
    assert only(result, "measurement-cut") == (
        "601 of 2401 measured samples lie outside the base motion and are not used"
    )


def test_unit_that_is_wrong_by_the_acceleration_of_gravity_is_named(tmp_path, capsys):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    measured = "x_dd: {column: x_dd, scale: 9.80665}"
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), measured)
    assert [one.slug for one in result.warnings] == ["bad-fit"]  # and not what follows from it
    said = only(result, "bad-fit")
    assert "x_dd seem to be 9.81 times too large: their unit is not the one stated" in said
    assert result.is_useless
    assert result.exit_code() == 1
    assert "its mount" not in " ".join(summarise(result).answer)
    show(result)
    shown = capsys.readouterr().out
    assert "its values mean nothing" in shown
    assert "error x_dd" in shown
    assert "kinetic" not in shown
    assert "F_fk" not in shown


def test_gravity_in_the_response_is_removed_or_fitted_or_refused(refused_fit, drysim, tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=1.0)
    edited(tmp_path, lambda table: table + 9.81 * np.eye(1, table.shape[1], 1))
    said = refused_fit(fit_text(MASS + COULOMB, keys(*FOUR)))
    assert re.search(r"the mean of x_dd is 9\.8\d* m/s², which looks like gravity", said)
    assert "`remove: mean` in fit.measured.x_dd" in said
    for free, measured in (
        (keys(*FOUR), "x_dd: {column: x_dd, remove: mean}"),
        (keys(*FOUR, "measured.offset"), "x_dd: x_dd"),
    ):
        (tmp_path / "seat.yaml").write_text(fit_text(MASS + COULOMB, free, measured))
        assert drysim("validate", "seat.yaml").code == 0


def test_value_that_ends_at_its_bound_is_named(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    free = f"{keys(*SPRING)}, friction.kinetic: {{to: {0.7 * F_FK}}}"
    result = fit_twin(tmp_path, MASS + COULOMB, free)
    assert only(result, "at-bound").startswith("friction.kinetic ends at its bound of 14 N")


def test_value_that_ends_at_zero_is_named(tmp_path):
    write_twin(tmp_path, SEAT + friction("kinetic: 0"), noise={"x_dd": 0.02}, seconds=4.0)
    damped = SEAT.replace(str(B), "560")
    result = fit_twin(tmp_path, damped + COULOMB, keys("friction.kinetic"))
    assert only(result, "at-bound") == (
        "friction.kinetic ends at 0, its least value: this record shows none of it"
    )


def test_kinetic_friction_is_at_most_the_static_limit_of_the_file(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, noise={"x_dd": 0.02}, seconds=4.0)
    result = fit_twin(tmp_path, SEAT + friction("static: 17"), keys("friction.kinetic"))
    assert values_of(result)["friction.kinetic"] == pytest.approx(17.0)
    assert only(result, "at-bound") == "friction.kinetic ends at 17 N, its largest value"


def test_free_start_without_value_needs_no_room_between_stops(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=4.0)
    stops = "stroke: {limit: 100 mm, stops: {restitution: 0.3}}\n"
    free = keys("friction.kinetic", "start.x_r", *SPRING)
    assert load_twin(tmp_path, MASS + COULOMB + stops, free).start.x_r == 0.0


def test_stated_delay_of_a_second_leaves_no_error(tmp_path):
    write_twin(tmp_path, SEAT + STICKY, seconds=6.0)
    names, *rows = (tmp_path / "run.csv").read_text().splitlines()
    shifted = [f"{float(row.split(',')[0]) + 1.0!r},{row.split(',', 1)[1]}" for row in rows]
    (tmp_path / "run.csv").write_text("\n".join([names, *shifted]) + "\n")
    result = fit_twin(tmp_path, MASS + COULOMB, keys(*FOUR), "x_dd: x_dd, delay: 1 s")
    assert result.metrics["fit_error"] < 1e-8
    assert result.metrics["fit_error_held_out"] < 1e-8


def test_reported_static_limit_is_that_of_the_fitted_scenario(tmp_path):
    write_twin(tmp_path, SEAT + friction("kinetic: 20"), noise={"x_dd": 0.02}, seconds=4.0)
    free = keys("friction.kinetic", *SPRING) + ", friction.static: {to: 18, start: 15}"
    result = fit_twin(tmp_path, MASS + COULOMB, free)
    assert values_of(result)["friction.static"] == result.scenario.law().F_fs


SEEDS = (
    "excitation: {kind: standard, class: EM3, duration: 4 s, seeds: 3}\n"
    "solver: {step: 2.5e-3}\nmeasure: {settle: 0}\n"
)
"""Base motions of which a record can be the response to one only."""


@pytest.mark.parametrize(
    ("known", "more", "sentence"),
    [
        (COULOMB, "  hold_out: 99 %\n", "fit.hold_out leaves 16 of 1601 samples"),
        (COULOMB + "solver: {approach: smooth}\n", "", "not by approach smooth"),
        (COULOMB + SEEDS, "", "excitation.seeds: a measured response belongs to one base"),
    ],
)
def test_what_a_fit_cannot_use_is_refused_before_it(tmp_path, known, more, sentence):
    write_twin(tmp_path, SEAT + STICKY, seconds=4.0)
    (tmp_path / "twin.yaml").write_text(fit_text(MASS + known, keys(*FOUR), more=more))
    with pytest.raises(drysim.ScenarioError) as fault:
        drysim.fit(drysim.load(tmp_path / "twin.yaml"))
    assert sentence in fault.value.problems[0].sentence
