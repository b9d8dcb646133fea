"""Joint draws of fitted values, and the intervals of the motion that follow from them."""

from __future__ import annotations

import json
import random
import re
import shutil
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from shown import show
from twin import base_motion, fit_text, fit_twin, keys, write_columns, write_twin

import drysim
from drysim.parallel import WorkerPool
from drysim.results.kind import judgements
from drysim.scenario.axes import iter_points
from drysim.scenario.load import load
from drysim.study import fit_draws
from drysim.study.cluster import Payload, open_plan
from drysim.study.fit_draws import Draws, draw, draws_warnings
from drysim.study.fit_law import LawFit, Steps, fit_law, ignore_progress, profiles_of
from drysim.study.fit_model import build_model, fitted_end
from drysim.study.fit_profiles import ParameterProfile
from drysim.wording import format_number

MASS = "oscillator: {mass: 75}\n"
SEAT = "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
COULOMB = "friction: {law: coulomb}\n"
SPRING = ("oscillator.stiffness", "oscillator.damping")
FOUR = (*SPRING, "friction.kinetic", "friction.static_ratio")
UPRIGHT = "measure: {settle: 0.5 s, direction: vertical}\n"


def friction(words: str) -> str:
    """Return a block of Coulomb friction."""
    return f"friction: {{law: coulomb, {words}}}\n"


def law_fit_of(folder: Path, known: str, free: str, measured: str) -> LawFit:
    """Return the least-squares solution of a twin."""
    (folder / "twin.yaml").write_text(fit_text(known, free, measured))
    scenario = drysim.load(folder / "twin.yaml")
    model = build_model(scenario)
    end = fitted_end(scenario, model.measurement)
    with WorkerPool(1) as pool:
        return fit_law(model, end, Steps(pool), ignore_progress)


@pytest.fixture(scope="module")
def linear(tmp_path_factory) -> LawFit:
    """Return the fit of spring and damper without friction, to a noisy stroke."""
    folder = tmp_path_factory.mktemp("linear")
    write_twin(folder, SEAT, noise={"x_r": 3e-4}, seconds=3.0)
    return law_fit_of(folder, MASS, keys(*SPRING), "x_r: x_r")


def drawn(law_fit: LawFit) -> Draws:
    """Return the draws of a fit."""
    with WorkerPool(1) as pool:
        steps = Steps(pool)
        return draw(law_fit, law_fit, profiles_of(law_fit, steps), steps)


def mean_and_covariance(law_fit: LawFit) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and covariance of the draws of a fit, in its standard deviations."""
    solution = law_fit.solution
    scaled = drawn(law_fit).values / law_fit.first.scale - solution.x
    scaled /= np.sqrt(np.diag(solution.covariance))
    return scaled.mean(axis=0), np.cov(scaled.T)


def test_draws_of_a_linear_fit_are_those_of_the_normal_distribution(linear):
    deviations = np.sqrt(np.diag(linear.solution.covariance))
    wanted = linear.solution.covariance / np.outer(deviations, deviations)
    mean, covariance = mean_and_covariance(linear)
    assert mean == pytest.approx([0.0, 0.0], abs=0.2)
    assert covariance == pytest.approx(wanted, abs=0.25)


def test_draws_have_the_robust_covariance(linear):
    robust = np.diag([3.0, 0.5]) @ linear.solution.covariance @ np.diag([3.0, 0.5])
    noisy = replace(linear, solution=linear.solution._replace(robust_covariance=robust))
    deviations = np.sqrt(np.diag(linear.solution.covariance))
    _, covariance = mean_and_covariance(noisy)
    assert covariance == pytest.approx(
        robust / np.outer(deviations, deviations), rel=0.1, abs=0.1
    )


def test_static_limit_at_a_jump_says_nothing_of_the_other_values(linear):
    covariance = np.diag([1e-4, 4e-4, 1e-20])
    covariance[:2, 2] = covariance[2, :2] = 1e-12  # rounding
    given = fit_draws.Likelihood(linear.solution, (0, 1), ())
    left = given.given_others(covariance)
    assert left @ covariance @ left.T == pytest.approx(covariance[:2, :2])


def test_draws_keep_the_bounds_that_the_likelihood_is_cut_by(linear):
    value, deviation = linear.values[1], linear.first.scale[1] * linear.solution.deviation(1)
    low, high = value - 0.5 * deviation, value + deviation
    parameters = (
        linear.model.parameters[0],
        replace(linear.model.parameters[1], low=low, high=high),
    )
    model = replace(linear.model, parameters=parameters)
    squares = replace(linear.solution.squares, model=model)
    cut = replace(linear, model=model, solution=linear.solution._replace(squares=squares))
    damping = drawn(cut).values[:, 1]
    assert low <= damping.min() < low + 0.1 * deviation
    assert high - 0.1 * deviation < damping.max() <= high
    # Between -0.5 and 1 standard deviations the normal distribution has the mean 0.207.
    assert (damping.mean() - value) / deviation == pytest.approx(0.207, abs=0.1)


def under_base_noise(law_fit: LawFit, variance: float) -> LawFit:
    """Return a fit with errors that noise of the base adds, of a variance relative to white."""
    solution = law_fit.solution
    normal = np.random.default_rng(3).normal(size=(fit_draws.DRAWS, len(solution.x)))
    errors = normal @ np.linalg.cholesky(variance * solution.covariance).T
    robust = solution.covariance + errors.T @ errors / len(errors)
    noisy = solution._replace(robust_covariance=robust, base_errors=errors)
    return replace(law_fit, solution=noisy)


def test_errors_by_noise_of_the_base_are_in_the_draw_of_the_same_number(linear):
    noisy = under_base_noise(linear, 100.0)
    errors = noisy.solution.base_errors
    scaled = drawn(noisy).values / linear.first.scale - linear.solution.x
    rest = (scaled - errors) / np.sqrt(np.diag(linear.solution.covariance))
    assert rest.std(axis=0) == pytest.approx([1.0, 1.0], rel=0.15)


def test_value_between_narrow_bounds_takes_no_more_error_of_the_others_than_it_explains(linear):
    noisy = under_base_noise(linear, 100.0)
    solution, value = noisy.solution, linear.values[1]
    narrow = replace(linear.model.parameters[1], low=value * 0.999999, high=value * 1.000001)
    model = replace(linear.model, parameters=(linear.model.parameters[0], narrow))
    squares = replace(solution.squares, model=model)
    bounded = replace(noisy, model=model, solution=solution._replace(squares=squares))
    robust = solution.robust_covariance
    given = np.sqrt(robust[0, 0] - robust[0, 1] ** 2 / robust[1, 1]) * linear.first.scale[0]
    assert drawn(bounded).values[:, 0].std() == pytest.approx(given, rel=0.15)


@pytest.mark.parametrize(("width", "noise"), [(1e-3, 0.0), (1e-3, 4.0), (0.3, 4.0)])
def test_draws_are_uniform_within_bounds_that_the_record_hardly_sees(linear, width, noise):
    linear = under_base_noise(linear, noise) if noise else linear
    deviations = width * linear.first.scale * np.sqrt(np.diag(linear.solution.covariance))
    parameters = tuple(
        replace(parameter, low=value - deviation, high=value + deviation)
        for parameter, value, deviation in zip(
            linear.model.parameters, linear.values, deviations, strict=True
        )
    )
    model = replace(linear.model, parameters=parameters)
    squares = replace(linear.solution.squares, model=model)
    draws = drawn(
        replace(linear, model=model, solution=linear.solution._replace(squares=squares))
    )
    within = (draws.values - linear.values) / deviations
    assert draws.effective > fit_draws.DRAWS
    assert np.abs(within).max() < 1.0  # none of them was moved to a bound
    assert (
        pytest.approx(np.tile([-0.5, 0.0, 0.5], (2, 1)), abs=0.12)
        == np.quantile(within, (0.25, 0.5, 0.75), axis=0).T
    )


def test_value_whose_bounds_are_narrow_is_not_said_to_be_without_effect(tmp_path):
    write_twin(tmp_path, SEAT + friction("kinetic: 30"), noise={"x_dd": 0.05}, seconds=3.0)
    free = f"{keys('oscillator.stiffness')}, friction.kinetic: {{from: 29.99, to: 30.01}}"
    known = "oscillator: {mass: 75, damping: 500}\n" + COULOMB
    kinetic = fit_twin(tmp_path, known, free).parameters[1]
    assert kinetic.note == "its bounds are narrower than its interval from this record"


@pytest.fixture(scope="module")
def unstuck(tmp_path_factory) -> Path:
    """Return a folder with a record in which the mass never sticks; its first stop is far."""
    folder = tmp_path_factory.mktemp("unstuck")
    truth = SEAT + friction("kinetic: 2")
    write_twin(folder, truth, noise={"x_dd": 0.3}, rms=3.0, seconds=3.0)
    return folder


def test_value_without_an_end_is_named_instead_of_drawn(linear):
    ends = {0: ParameterProfile(0.9, None, []), 1: ParameterProfile(0.9, 1.1, [])}
    with WorkerPool(1) as pool:
        draws = draw(linear, linear, ends, Steps(pool))
    assert len(draws.values) == 0
    assert draws.reason == (
        "the record sets no end to oscillator.stiffness; give `to` for it in fit.free"
    )


def test_summary_says_why_the_intervals_of_the_motion_are_not_known(unstuck, capsys):
    result = fit_twin(unstuck, SEAT + COULOMB, keys("friction.kinetic"), more=UPRIGHT)
    unknown = result.draws._replace(values=np.empty((0, 1)), metrics={}, reason="no end")
    assert [name for name, *_ in result.motion_intervals] == ["T_a", "SEAT", "x_r_peak"]
    show(replace(result, draws=unknown))
    shown = capsys.readouterr().out
    assert shown.count("95 %: not known: no end") == 1
    assert " 95 %: " not in shown.partition("not known")[2].partition("error")[0]


def test_value_that_the_record_does_not_tell_is_uniform_over_its_bounds(unstuck):
    free = keys(*SPRING, "friction.kinetic") + ", friction.static_ratio: {to: 3}"
    draws = fit_twin(unstuck, MASS + COULOMB, free).draws
    ratio = np.sort(draws.values[:, draws.keys.index("friction.static_ratio")])
    assert ratio == pytest.approx(np.linspace(1.0, 3.0, len(ratio)), abs=0.01)


def test_only_ratios_have_no_draws(linear, monkeypatch):
    monkeypatch.setitem(linear.__dict__, "undetermined", {0: (0, 1), 1: (0, 1)})
    assert drawn(linear).reason == (
        "only the ratios of oscillator.stiffness and oscillator.damping follow; "
        "state one of them"
    )


def test_few_points_are_said(linear):
    draws = drawn(linear)
    assert not [*draws_warnings(draws)]
    (warning,) = draws_warnings(draws._replace(effective=45.4))
    assert warning.slug == "few-draws"
    assert "rest on 45 effective points only" in warning.sentence


@pytest.mark.parametrize("profiled", [True, False])
def test_draws_reach_a_likelihood_that_the_covariance_misses(linear, profiled):
    narrow = 0.02 * linear.solution.covariance
    missed = replace(
        linear,
        solution=linear.solution._replace(covariance=narrow, robust_covariance=narrow),
    )
    with WorkerPool(1) as pool:
        steps = Steps(pool)
        profiles = profiles_of(missed, steps) if profiled else {}
        draws = draw(missed, missed, profiles, steps)
    wanted = linear.first.scale * np.sqrt(np.diag(linear.solution.covariance))
    assert draws.effective > fit_draws.DRAWS
    assert draws.values.std(axis=0) == pytest.approx(wanted, rel=0.2)


def test_static_limit_is_drawn_with_the_other_values(tmp_path):
    truth = SEAT + friction("kinetic: 20, static_ratio: 1.5")
    write_twin(tmp_path, truth, noise={"x_dd": 0.005}, seconds=8.0, seed=5, rate=200.0)
    law_fit = law_fit_of(tmp_path, MASS + COULOMB, keys(*FOUR), "x_dd: x_dd")
    deviations = np.sqrt(np.diag(law_fit.solution.covariance))
    wanted = law_fit.solution.covariance / np.outer(deviations, deviations)
    _, covariance = mean_and_covariance(law_fit)
    assert covariance == pytest.approx(wanted, abs=0.25)


# Draws as cases of a sweep and conditions of a design

SINE = "excitation: {kind: harmonic, frequency: 1.6 Hz, rms: 0.9}\n"
SCENE = SEAT + friction("kinetic: 20, static_ratio: 1.5") + SINE


@pytest.fixture(scope="module")
def fitted(tmp_path_factory) -> tuple[drysim.FitResult, Path]:
    """Return the fit of a short record, and the folder with its result in out/fit."""
    folder = tmp_path_factory.mktemp("fitted")
    truth = SEAT + friction("kinetic: 20, static_ratio: 1.5")
    write_twin(folder, truth, noise={"x_dd": 0.02}, seconds=2.0)
    result = fit_twin(folder, MASS + COULOMB, keys(*FOUR))
    result.save(folder / "out" / "fit", plots=False)
    return result, folder


def loaded(folder: Path, blocks: str, scene: str = SCENE) -> drysim.Scenario:
    """Return a scenario with further blocks, read from a folder."""
    (folder / "scene.yaml").write_text(scene + blocks)
    return drysim.load(folder / "scene.yaml")


def test_draws_without_a_metric_are_taken(fitted, tmp_path):
    result, _ = fitted
    empty = np.full(len(result.draws.values), np.nan)
    draws = result.draws._replace(metrics={**result.draws.metrics, "T_a": empty})
    replace(result, draws=draws).save(tmp_path / "out" / "fit", plots=False)
    scenario = loaded(tmp_path, "sweep: {sample: {from_fit: out/fit}}")
    assert len([*iter_points(scenario.sweep)]) == len(empty)


def test_sample_takes_the_draws_of_a_fit_jointly(fitted):
    result, folder = fitted
    scenario = loaded(folder, "sweep: {sample: {from_fit: out/fit}}")
    wanted = [dict(sorted(point.items())) for point in result.draws.points]
    assert [dict(sorted(point.items())) for point in iter_points(scenario.sweep)] == wanted
    table = drysim.sweep(scenario, workers=1)
    assert [row.F_fk for row in table.rows] == [
        point["friction.kinetic"] for point in result.draws.points
    ]


def test_sweep_of_draws_alone_shows_what_they_leave_open(fitted, capsys):
    _, folder = fitted
    block = "stroke: {limit: 1 m}\nsweep: {sample: {from_fit: out/fit, count: %d}}"
    table = drysim.sweep(loaded(folder, block % 40), workers=1)
    assert table.best is None
    T_a = table.values_of("T_a")
    ends = np.quantile(T_a, (0.025, 0.975), method="hazen")
    show(table)
    shown = capsys.readouterr().out
    median, low, high = map(
        float, re.search(r"T_a +(\S+) +95 %: (\S+) to (\S+)\n", shown).groups()
    )
    assert (median, low, high) == pytest.approx((np.median(T_a), *ends), rel=1e-3)
    assert "at most" in shown.partition("peak |x_r|")[2]
    low, high = table.plot("transmissibility").axes[1].get_xlim()
    assert low < T_a.min() < T_a.max() < high < 1.2 * T_a.max() - 0.2 * T_a.min()
    (stroke,) = table.plot("stroke").axes
    assert stroke.get_ylim() == (0.0, 100.0)
    for count, text in ((3, "all 3 draws"), (1, "1 draw")):
        few = drysim.sweep(loaded(folder, block % count), workers=1)
        show(few)
        assert f" {text}: " in capsys.readouterr().out
        (span, *_) = few.plot("transmissibility").axes[1].patches
        assert span.get_label() == text


def test_draws_go_with_other_keys_and_leave_swept_ones_alone(fitted):
    result, folder = fitted
    sample = "kind: latin, count: 8, seed: 1, over: {oscillator.mass: {from: 60, to: 90}}"
    scenario = loaded(
        folder,
        f"sweep: {{oscillator.damping: [100, 200], sample: {{from_fit: out/fit, {sample}}}}}",
    )
    points = [*iter_points(scenario.sweep)]
    assert [point["oscillator.damping"] for point in points] == 8 * [100.0, 200.0]
    kinetic = [point["friction.kinetic"] for point in result.draws.points[:8]]
    assert [point["friction.kinetic"] for point in points[::2]] == kinetic
    assert len({point["oscillator.mass"] for point in points}) == 8


def test_result_names_the_draws_and_can_be_computed_again(fitted, drysim, tmp_path):
    _, folder = fitted
    shutil.copytree(folder / "out", tmp_path / "out")
    (tmp_path / "scene.yaml").write_text(
        SCENE + "sweep: {sample: {from_fit: out/fit, count: 4}}"
    )
    done = drysim("sweep", "scene.yaml", "--no-plots")
    assert done.code == 0, done.err
    assert "friction.static_ratio" in done.out
    assert "(4 draws of out/fit)" in done.out
    stored = tmp_path / "out" / "scene"
    (used,) = json.loads((stored / "drysim.json").read_text())["inputs"]
    file = tmp_path / "out" / "fit" / "draws.csv"
    assert used == {
        "file": "out/fit/draws.csv",
        "sha256": sha256(file.read_bytes()).hexdigest(),
        "size": file.stat().st_size,
    }
    again = load(stored / "scenario.yaml")
    assert [*iter_points(again.sweep)] == [*iter_points(load(tmp_path / "scene.yaml").sweep)]


def test_checks_over_draws_judge_each_or_a_quantile_of_them(fitted):
    _, folder = fitted
    block = "sweep: {{sample: {{from_fit: out/fit, count: {}}}}}\nchecks: [{}]"
    T_a = drysim.sweep(loaded(folder, block.format(40, "T_a > 0")), workers=1).values_of("T_a")
    limit, level = np.sort(T_a)[-4] + 1e-9, np.quantile(T_a, 0.95, method="median_unbiased")
    checks = ", ".join(f"T_a{at} < {limit:.17g}" for at in ("", " p5", " p95")) + ", T_a < 9"
    table = drysim.sweep(loaded(folder, block.format(40, checks)), workers=1)
    every, _, high, _ = table.checks
    assert [check.passed for check in table.checks] == [False, True, False, True]
    assert (every.value, high.value) == (T_a.max(), pytest.approx(level, rel=1e-12))
    lines = [each.sentence.partition("<")[2] for each in judgements(table.checks, table.axes)]
    assert lines[0].endswith(f" in 3 of 40 draws, worst {every.described_value}")
    assert lines[1].endswith("p5 of 40 draws (3 fail)")
    assert lines[3].endswith(
        f"with {format_number(T_a.max(), digits=6)}, the worst of 40 draws"
    )
    assert "judges the p95 of 19 draws, which is about an extreme of them; give count: 20" in (
        " ".join(map(str, drysim.validate(loaded(folder, block.format(19, "T_a p95 < 1")))))
    )


@pytest.mark.parametrize("form", ["T_a p95 < 9", "T_a < 9 with every seed"])
def test_check_of_draws_is_a_warning_where_it_judges_one_motion(fitted, form):
    _, folder = fitted
    block = "sweep: {{sample: {{from_fit: out/fit, count: 20}}}}\nchecks: [{}]"
    scenario = loaded(folder, block.format(form))
    sentence = "judges a single motion; `drysim sweep` the draws"
    alone, swept = (
        [each.sentence for each in result.warnings if each.slug == "check-of-one-seed"]
        for result in (drysim.run(scenario), drysim.sweep(scenario, workers=1))
    )
    assert alone == [f"the check `{form}` {sentence}"]
    judged = [f"the check `{form}` judges every draw, also without `with every seed`"]
    assert swept == (judged if "every seed" in form else [])


def test_workers_elsewhere_have_the_same_draws(fitted):
    _, folder = fitted
    scenario = loaded(folder, "sweep: {sample: {from_fit: out/fit, count: 4}}")
    (elsewhere,) = open_plan(Payload.of(scenario)).ranges.scenarios
    assert [*iter_points(elsewhere.sweep)] == [*iter_points(scenario.sweep)]


FAULTS = {
    "nowhere": ("out/nope", "names a folder that does not exist: `out/nope`"),
    "no result": ("out", "names no result of drysim: out has no drysim.json"),
    "damaged": ("out/damaged", "names a damaged result: out/damaged/drysim.json; repeat"),
    "other kind": ("out/run", "names the result of `drysim run`, not of a fit: out/run"),
    "changed": ("out/changed", "names a fit whose draws.csv was changed: out/changed; repeat"),
    "missing": ("out/missing", "names a fit whose draws.csv is missing: out/missing; repeat"),
    "none": ("out/none", "names a fit without draws, out/none: no end, and fit again"),
    "earlier": ("out/earlier", "names a fit without draws, out/earlier: it has no draws.csv"),
    "number": ("5", "must be the folder of a fit, such as `out/fit-seat`, not 5"),
    "many": ("out/fit, count: 300", "is 300, but the fit has 256 draws"),
    "few": ("out/fit, count: 0", "must be a whole number of at least 1, not 0"),
    "seed": (
        "out/fit, count: 4, seed: 1",
        "seed has no meaning with from_fit, only with over; remove",
    ),
}


@pytest.mark.parametrize(("value", "sentence"), FAULTS.values(), ids=FAULTS)
def test_fit_that_cannot_be_used_is_named_at_its_place(fitted, tmp_path, value, sentence):
    _, folder = fitted
    out = tmp_path / "out"
    marker = json.loads((folder / "out" / "fit" / "drysim.json").read_text())
    without = {name: digest for name, digest in marker["files"].items() if "draws" not in name}
    reason = {**marker["fit"], "draws": {"reason": "no end"}}
    markers = {
        "fit": marker,
        "missing": marker,
        "changed": marker,
        "run": {"kind": "run"},
        "none": marker | {"files": without, "fit": reason},
        "earlier": marker | {"files": without, "fit": {}},
        "damaged": 5,
    }
    for name, fields in markers.items():
        shutil.copytree(folder / "out" / "fit", out / name)
        (out / name / "drysim.json").write_text(json.dumps(fields))
    (out / "missing" / "draws.csv").unlink()
    with (out / "changed" / "draws.csv").open("a") as file:
        file.write("1\n")
    with pytest.raises(drysim.ScenarioError) as caught:
        loaded(tmp_path, f"sweep: {{sample: {{from_fit: {value}}}}}")
    (problem,) = caught.value.problems
    assert sentence in problem.sentence
    assert problem.line == SCENE.count("\n") + 1
    assert problem.key.startswith("sweep.sample.")


@pytest.mark.parametrize("block", ["sweep: {sample: {%s}}", "design: {%s}"])
def test_keys_that_a_scenario_lacks_are_named(fitted, block):
    _, folder = fitted
    inside = "from_fit: out/fit"
    if "design" in block:
        vary = "vary: {oscillator.mass: {from: 60, to: 90}}, minimise: T_a"
        inside = f"{vary}, over: {{{inside}}}"
    with pytest.raises(drysim.ScenarioError) as caught:
        loaded(folder, block % inside, SEAT + SINE)
    assert [problem.sentence.partition(": ")[2] for problem in caught.value.problems] == [
        "names a fit of friction.kinetic and friction.static_ratio, which this scenario lacks"
    ]


@pytest.mark.parametrize(
    ("count", "text"),
    [(1, "(1 draw of out/fit, friction"), (2, ", friction.kinetic as given, not as drawn)")],
)
def test_key_that_is_given_beside_the_draws_is_named_in_their_text(fitted, count, text):
    _, folder = fitted
    draws = f"from_fit: out/fit, count: {count}"
    vary = "vary: {oscillator.damping: {from: 300, to: 900}}, minimise: T_a"
    for block in (
        f"sweep: {{friction.kinetic: [30, 40], sample: {{{draws}}}}}",
        f"design: {{{vary}, over: {{friction.kinetic: [30, 40], {draws}}}}}",
    ):
        scenario = loaded(folder, block)
        axes = scenario.sweep or scenario.design.over.axes
        assert any(text in axis.description for axis in axes)


def test_key_that_excludes_one_of_the_fit_is_named(fitted):
    _, folder = fitted
    scene = SCENE.replace("stiffness: 7500", "natural_frequency: 1.6")
    with pytest.raises(drysim.ScenarioError, match=r"give stiffness instead, which the draws"):
        loaded(folder, "sweep: {sample: {from_fit: out/fit}}", scene)


def test_design_is_judged_under_the_draws_of_a_fit(fitted):
    result, folder = fitted
    vary = "vary: {oscillator.damping: {from: 300, to: 900}}, minimise: T_a, evaluations: 4"
    study = drysim.design(
        loaded(folder, f"design: {{{vary}, over: {{from_fit: out/fit, count: 3}}}}"), workers=1
    )
    kinetic = [point["friction.kinetic"] for point in result.draws.points[:3]]
    assert [row.F_fk for row in study.several_rows] == kinetic
    assert len({row.point["oscillator.damping"] for row in study.several_rows}) == 1
    few = loaded(folder, f"design: {{{vary}, over: {{from_fit: out/fit}}}}").design.conditions
    assert {len(axis.values) for axis in few.axes} == {16}
    assert "oscillator.damping" not in {axis.key for axis in few.axes}


def test_design_over_draws_proposes_no_grid_of_their_values(fitted, drysim, tmp_path):
    shutil.copytree(fitted[1] / "out", tmp_path / "out")
    vary = "vary: {oscillator.damping: {from: 300, to: 900}}, minimise: T_a, evaluations: 4"
    text = f"{SCENE}design: {{{vary}, over: {{from_fit: out/fit, count: 3}}}}"
    (tmp_path / "scene.yaml").write_text(text)
    done = drysim("design", "scene.yaml", "--no-plots", "--out", "best")
    assert done.err.endswith("next: drysim run best/best.yaml\n")


# Coverage


def twin_intervals(
    folder: Path, seed: int, base_noise: float = 0.0
) -> dict[str, tuple[float, float, float, float]]:
    """Return true value, fitted value and interval of metrics and parameters of a twin."""
    chance = random.Random(seed)
    truth = {
        "oscillator.stiffness": chance.uniform(4000.0, 9000.0),
        "oscillator.damping": chance.uniform(200.0, 700.0),
        "friction.kinetic": chance.uniform(10.0, 35.0),
        "friction.static_ratio": chance.uniform(1.0, 2.5),
    }
    k_x, b, kinetic, ratio = truth.values()
    scene = (
        f"oscillator: {{mass: 75, stiffness: {k_x}, damping: {b}}}\n"
        + friction(f"kinetic: {kinetic}, static_ratio: {ratio}")
        + UPRIGHT
    )
    noise = chance.uniform(0.01, 0.06)
    measured = chance.choice(["x_dd: x_dd", "x_dd: x_dd, x_r: x_r"])
    write_twin(
        folder, scene, noise={"x_dd": noise, "x_r": 3e-3 * noise}, seed=seed, seconds=8.0,
        rate=200.0,
    )  # fmt: skip
    metrics = drysim.run(drysim.load(folder / "truth.yaml")).metrics
    u_dd = base_motion(8.0, seed, rate=200.0)
    u_dd += base_noise * np.random.default_rng((seed, 1)).normal(size=len(u_dd))
    write_columns(
        folder / "base.csv", {"t [s]": np.arange(len(u_dd)) / 200.0, "u_dd [m/s2]": u_dd}
    )
    result = fit_twin(folder, MASS + COULOMB, keys(*FOUR), measured, more=UPRIGHT)
    intervals = {
        name: (float(metrics[name] or 0.0), value, low, high)
        for name, value, low, high in result.motion_intervals
        if low is not None and high is not None
    }
    for parameter in result.parameters:
        if parameter.key in truth:
            low, high = parameter.profile_low, parameter.profile_high
            intervals[parameter.key] = (
                truth[parameter.key],
                parameter.value,
                -np.inf if low is None else low,
                np.inf if high is None else high,
            )
    return intervals


def held(interval: tuple[float, float, float, float], width: float = 1.0) -> bool:
    """Return whether an interval, made narrower about the fitted value, holds the truth."""
    true, value, low, high = interval
    rounding = 1e-9 * abs(true)
    return (
        value + width * (low - value) - rounding
        <= true
        <= value + width * (high - value) + rounding
    )


@pytest.mark.parametrize("base_noise", [0.0, 0.013])
def test_intervals_of_the_motion_hold_the_truth_and_are_not_wide(tmp_path, base_noise):
    twins = [twin_intervals(tmp_path, seed, base_noise) for seed in range(4)]
    for name in ("T_a", "SEAT", "x_r_peak"):
        assert all(held(twin[name], 1.5) for twin in twins)
        assert not all(held(twin[name], 0.2) for twin in twins)


def test_static_limit_that_the_samples_between_events_leave_open_is_not_taken_as_fitted(
    tmp_path,
):
    # The fit has 1.0, next to a jump of the motion; up to 2.1 all samples are as probable.
    interval = twin_intervals(tmp_path, 2001)["friction.static_ratio"]
    assert interval[0] == pytest.approx(1.98, abs=0.01)
    assert held(interval)


@pytest.mark.slow
@pytest.mark.by_hand
@pytest.mark.parametrize("base_noise", [0.0, 0.013])
def test_intervals_hold_the_truth_in_95_percent_of_twins(tmp_path, base_noise):
    twins = [twin_intervals(tmp_path, seed, base_noise) for seed in range(1000, 1300)]
    for name in ("T_a", "SEAT", "x_r_peak", *FOUR):
        shares = [
            np.mean([held(twin[name], width) for twin in twins if name in twin])
            for width in (1.0, 0.7)
        ]
        print(f"{name:22} {shares[0]:.3f}, at 0.7 of the width {shares[1]:.3f}")
        assert shares[0] >= 0.93
        assert shares[1] < 0.93
        assert name.startswith("friction") or shares[0] <= 0.97
