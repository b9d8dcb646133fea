"""Many seeds of one scenario: means, intervals, when they are enough, and the files."""

from __future__ import annotations

import hashlib
import json
import shutil
from contextlib import contextmanager, nullcontext
from itertools import pairwise
from math import ceil

import numpy as np
import pytest
from seat import fields_of, rows_of
from shown import legend, show

import drysim as package
from drysim.console import terminal
from drysim.errors import ScenarioError, SolverError
from drysim.metrics.checks import Check
from drysim.plots.ensemble import draw
from drysim.results.ensemble import ensemble_rows
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.load import load
from drysim.scenario.warnings import scenario_warnings
from drysim.study import plan as study_plan
from drysim.study.ensemble import run
from drysim.study.statistics import SEEDS_PER_CHECK, Batch, Row, interval, statistics
from drysim.wording import format_interval, format_number, format_percent

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
stroke: {limit: 5 mm}
excitation: {kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.67, duration: 10, seed: 1}
solver: {step: 5e-3}
"""

UNSTABLE = """\
oscillator: {mass: 1, stiffness: 100, damping: 300}
friction: {law: coulomb, kinetic: 1}
excitation: {kind: psd, points: [[0.5, 1], [10, 1]], duration: 3.4, seeds: 8}
solver: {approach: signum, step: 1e-2, signum: {method: euler}}
"""
"""Grows by Euler's steps until the numbers end: with some seeds before 3.4 s."""

SEEDS = "excitation.seeds"
UNTIL = "excitation.until"


@pytest.fixture
def noisy(tmp_path):
    """Write a small random scenario."""
    file = tmp_path / "noisy.yaml"
    file.write_text(SEAT)
    return file


def same(one, other):
    """Whether two ensembles are one to the last bit."""
    return [vars(row) for row in one.rows] == [vars(row) for row in other.rows] and (
        one.statistics == other.statistics
    )


def test_every_seed_is_the_run_of_that_seed_alone(noisy):
    many = run(load(noisy, {SEEDS: 3, "excitation.seed": 7}))
    assert many.seeds == (7, 8, 9)
    for row, seed in zip(many.rows, many.seeds, strict=True):
        alone = run(load(noisy, {"excitation.seed": seed}))
        assert row.metrics == alone.metrics
    assert many.metrics["T_a"] == interval([row.metrics["T_a"] for row in many.rows])[0]


def test_the_first_seed_is_1_when_none_is_given(noisy):
    scenario = load(noisy, {"excitation.seed": None, SEEDS: 2})
    assert run(scenario).seeds == (1, 2)
    assert scenario.resolved()["excitation"]["seed"] == 1


def test_response_is_that_of_the_first_seed(noisy):
    many, alone = run(load(noisy, {SEEDS: 2})), run(load(noisy))
    assert many.response.x_r.tobytes() == alone.response.x_r.tobytes()
    assert len(many.events) == len(alone.events)
    shown = run(load(noisy, {SEEDS: 2, "measure.spectra": True})).warnings
    assert "spectra-of-one-seed" in [warning.slug for warning in shown]


@pytest.mark.parametrize("wish", [{}, {UNTIL: {"metric": "T_a", "half_width": "0.6 %"}}])
def test_an_ensemble_does_not_depend_on_the_number_of_workers(noisy, wish):
    scenario = load(noisy, {SEEDS: 35} | wish)
    one, two, many = (run(scenario, workers=workers) for workers in (1, 2, 7))
    assert same(one, two)
    assert same(one, many)


def test_until_stops_at_the_first_look_with_a_narrow_interval(noisy):
    wish = {"metric": "x_r_rms", "half_width": "3 %"}
    found = run(load(noisy, {UNTIL: wish}))
    n, values = len(found.rows), [row.metrics["x_r_rms"] for row in found.rows]
    assert n % SEEDS_PER_CHECK == 0
    assert n > SEEDS_PER_CHECK
    mean, half_width = interval(values)
    assert half_width <= 0.03 * mean
    mean, half_width = interval(values[:-SEEDS_PER_CHECK])
    assert half_width > 0.03 * mean
    assert not any(one.slug == "interval-wide" for one in found.warnings)


def test_until_gives_up_at_the_most_seeds_and_says_how_many_it_takes(noisy):
    found = run(load(noisy, {SEEDS: 12, UNTIL: {"metric": "x_r_peak", "half_width": "2 %"}}))
    assert len(found.rows) == 12
    (warning,) = [one for one in found.warnings if one.slug == "interval-wide"]
    assert warning.sentence.startswith("after all 12 seeds the confidence interval of")
    needed = 12 * (warning.numbers["half_width"] / 0.02) ** 2
    assert f"excitation.seeds: {ceil(needed)} would suffice" in warning.sentence


def test_until_never_holds_for_a_metric_that_some_seed_does_not_know(noisy):
    wish = {"metric": "t_first_violation", "half_width": "50 %"}
    found = run(load(noisy, {SEEDS: 20, UNTIL: wish}))
    assert 0 < found.statistics["t_first_violation"].seeds < 20
    assert any("`until` cannot be met" in one.sentence for one in found.warnings)


def test_until_holds_at_once_for_what_does_not_scatter(noisy):
    found = run(load(noisy, {UNTIL: {"metric": "chatter_share", "half_width": "1 %"}}))
    assert len(found.rows) == SEEDS_PER_CHECK


def test_stroke_violations_are_counted_over_the_seeds(noisy):
    found = run(load(noisy, {SEEDS: 20, "measure": {"settle": 2}}))
    beyond = [row for row in found.rows if row.metrics["violations"]]
    assert 0 < len(beyond) < 20
    worst = max(found.rows, key=lambda row: row.metrics["stroke_suffices"])
    (warning,) = [one for one in found.warnings if one.slug == "stroke-violated"]
    assert f"is exceeded for {len(beyond)} of 20 seeds" in warning.sentence
    assert warning.sentence.endswith(f"for seed {worst.point['excitation.seed']}")


@pytest.mark.parametrize(("size", "unit"), [(1e-5, "µm"), (1.0, "mm"), (1e5, "m")])
def test_stroke_over_seeds_is_told_and_drawn_in_the_unit_that_suits_it(
    noisy, capsys, size, unit
):
    forces = {"friction.kinetic": 45 * size, "stroke.limit": 0.005 * size}
    made = run(load(noisy, {SEEDS: 3, "excitation.rms": 0.67 * size, **forces}))
    show(made)
    (told,) = [row for row in capsys.readouterr().out.splitlines() if "peak |x_r|" in row]
    scale = {"µm": 1e6, "mm": 1e3, "m": 1.0}[unit]
    most = made.statistics["x_r_peak"].greatest[0] * scale
    assert f"{format_number(most, unit)}; largest with seed" in " ".join(told.split())
    figure = draw(made)
    titles = [panel.get_title("left") for panel in figure.axes]
    assert f"peak |xᵣ| [{unit}]: running mean" in titles
    low, high = figure.axes[-1].get_ylim()
    assert low < most < high
    assert any(f" {unit}" in text.get_text() for text in figure.texts)


def test_values_below_a_distribution_do_not_touch(noisy):
    figure = draw(run(load(noisy, {SEEDS: 5, "excitation.duration": 20})))
    figure.draw_without_rendering()
    for panel in figure.axes[::2]:
        low, high = panel.get_xlim()
        ticks = zip(panel.get_xticks(), panel.get_xticklabels(), strict=True)
        boxes = [label.get_window_extent() for at, label in ticks if low <= at <= high]
        assert len(boxes) > 1
        for one, other in pairwise(boxes):
            assert one.x1 < other.x0


def test_heading_over_seeds_names_results_before_the_law(noisy):
    lugre = {
        "law": "lugre", "kinetic": 45, "static_ratio": 1.2, "stribeck_velocity": 0.005,
        "bristle_stiffness": 100000, "bristle_damping": 300, "viscous": 0.4,
    }  # fmt: skip
    made = run(load(noisy, {SEEDS: 2, "friction": lugre, "excitation.duration": 2}))
    heading = " ".join(text.get_text() for text in draw(made).texts[1:])
    order = ("peak |xᵣ|", "seeds 2, from 1 to 2", "law lugre")
    assert -1 < heading.find(order[0]) < heading.find(order[1]) < heading.find(order[2])


def test_checks_judge_the_mean_and_say_so(noisy):
    found = run(load(noisy, {SEEDS: 10, "checks": ["T_a < 0.9", "x_r_peak < 1 mm"]}))
    passed, failed = found.checks
    assert (passed.passed, failed.passed, found.exit_code()) == (True, False, 1)
    assert passed.value == found.statistics["T_a"].mean
    assert passed.half_width == found.statistics["T_a"].half_width
    assert ", mean of 10 seeds" in passed.sentence
    assert not any(one.slug == "check-undecided" for one in found.warnings)


def test_checks_over_seeds_say_what_they_judge(drysim, noisy):
    seeds = run(load(noisy, {SEEDS: 20}))
    values = sorted(row.metrics["x_r_peak"] for row in seeds.rows)
    worst = seeds.statistics["x_r_peak"].greatest[1]
    limit = 0.5 * sum(values[-4:-2])  # three seeds exceed it, the mean does not
    written = f"{1e3 * limit:.6f} mm"
    texts = [f"x_r_peak < {written}", f"x_r_peak p95 < {written}"]
    texts += [f"x_r_peak < {written} with every seed", "x_r_peak < 1 m with every seed"]
    words = ["--set", f"{SEEDS}=20", "--set", f"checks={json.dumps(texts)}"]
    done = drysim("run", noisy, *words, "--no-plots", "-o", "out")
    assert done.code == 1
    said = " ".join(done.out.split())
    for sentence in (
        f"✓ holds {texts[0]}, with",
        "mean of 20 seeds (3 fail)",
        f"✗ fails {texts[1]}, with",
        "p95 of 20 seeds (3 fail)",
        f"✗ fails {texts[2]}: 3 of 20 seeds fail, worst with "
        f"{format_number(1e3 * values[-1], 'mm', 6)} for seed {worst}",
        f"✓ holds {texts[3]}, with {format_number(values[-1], 'm', 6)}, the worst of 20 seeds",
    ):
        assert sentence in said
    checks = fields_of("out")["checks"]
    assert [check["judges"] for check in checks] == ["mean", "p95", *["every seed"] * 2]
    assert [check.get("failed_seeds", 0) for check in checks] == [3, 3, 3, 0]
    assert [check.get("worst_seed") for check in checks] == [None, None, worst, None]
    assert checks[2]["value"] == values[-1]


def test_check_over_seeds_judges_each_case_of_a_sweep(drysim, noisy):
    sweep = "sweep={friction.kinetic: [0, 45]}"
    words = ["--set", f"{SEEDS}=6", "--set", sweep]
    text = "x_r_peak < 1 mm with every seed at friction.kinetic < 50"
    done = drysim("sweep", noisy, *words, "--set", f"checks=[{text}]", "--no-plots")
    said = " ".join(done.out.split())
    assert f"✗ fails {text} in 2 of 2 cases, worst with" in said
    ensemble = run(load(noisy, {SEEDS: 6, "friction.kinetic": 0}))
    worst = ensemble.statistics["x_r_peak"].greatest[1]
    assert f" mm over 6 seeds, for seed {worst} at kinetic 0 N" in said
    assert "the worst of" not in said


def test_swept_stroke_beyond_its_limit_is_told_of_the_worst_seed(drysim, noisy):
    ensemble = run(load(noisy, {SEEDS: 6, "friction.kinetic": 0}))
    peaks = ensemble.rows.batches[0].metrics["x_r_peak"]
    limit = 0.5 * sum(sorted(peaks.tolist())[-2:])
    words = ["--set", f"{SEEDS}=6", "--set", f"stroke.limit={limit}", "--no-plots"]
    done = drysim("sweep", noisy, *words, "--set", "sweep={friction.kinetic: [0]}")
    share = format_percent(max(peaks) / limit)
    warning = f"exceeded in the only case; up to {share} of it is used at kinetic 0 N"
    assert f"{warning}, where it is exceeded for 1 of 6 seeds" in " ".join(done.err.split())
    assert "for 1 of 6 seeds at kinetic 0 N" in " ".join(done.out.split())


def test_seeds_without_a_value_neither_fail_nor_count_in_the_mean_of_a_sweep(drysim, noisy):
    frictionless = {SEEDS: 6, "friction.kinetic": 0}
    peak = run(load(noisy, frictionless)).statistics["x_r_peak"].mean
    settings = {**frictionless, "stroke.limit": peak, "checks": ["t_first_violation > 0 s"]}
    words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    verdicts = []
    for command in (["run"], ["sweep", "--set", "sweep={friction.kinetic: [0]}"]):
        out = noisy.with_name(command[0])
        drysim(*command, noisy, *words, "--no-plots", "-o", out)
        fields = fields_of(out)
        verdicts.append([fields["checks"][0].get(key, 0) for key in ("failed_seeds", "seeds")])
    assert verdicts[0] == verdicts[1]
    assert verdicts[0][0] == 0
    assert 0 < verdicts[0][1] < 6


@pytest.mark.parametrize("form", ["x_r_peak p95 < 45 mm", "x_r_peak < 45 mm with every seed"])
def test_check_over_seeds_of_a_single_motion_is_a_warning(noisy, form):
    def slugs(overrides):
        warnings = scenario_warnings(load(noisy, {"checks": [form], **overrides}))
        return [warning.slug for warning in warnings]

    assert "check-of-one-seed" in slugs({})
    assert "check-of-one-seed" not in slugs({SEEDS: 4})


@pytest.mark.parametrize(
    ("quantile", "seeds"), [("p95", 20), ("p5", 20), ("p90", 10), ("p50", 2), ("p99.9", 1000)]
)
def test_check_of_a_quantile_of_few_seeds_is_a_warning(noisy, quantile, seeds):
    text = f"x_r_peak {quantile} < 45 mm"
    assert Check.parse(text).least_seeds == seeds

    def sentences(count, is_swept=True, **changes):
        scenario = load(noisy, {"checks": [text], SEEDS: count, **changes})
        warnings = scenario_warnings(scenario, swept=is_swept)
        return [one.sentence for one in warnings if one.slug == "quantile-of-few-seeds"]

    assert not sentences(seeds)
    swept = {SEEDS: [max(2, seeds - 1), 2 * seeds]}
    assert bool(sentences(seeds, sweep=swept)) == (seeds > 2)
    assert not sentences(seeds, is_swept=False, sweep=swept)  # of `drysim run`
    if seeds > 2:
        design = {"vary": {"oscillator.damping": {"from": 100, "to": 900}}, "minimise": "T_a"}
        limits = {"checks": [], "design": design | {"within": [text]}}
        (sentence,) = {*sentences(seeds - 1), *sentences(seeds - 1, **limits)}
        assert f"judges the {quantile} of {seeds - 1} seeds, " in sentence
        assert f"give excitation.seeds: {seeds} or more" in sentence


def test_seeds_that_a_stopping_rule_leaves_out_are_too_few_for_a_quantile(noisy):
    changes = {SEEDS: 40, "excitation.until": {"metric": "T_a", "half_width": 0.5}}
    changes["checks"] = ["T_a p95 < 9"]
    scenario = load(noisy, changes)
    assert not [one for one in scenario_warnings(scenario) if "quantile" in one.slug]
    swept = load(noisy, changes | {"sweep": {"friction.kinetic": [30, 45]}})
    for result in (run(scenario), package.sweep(swept)):
        (warning,) = [one for one in result.warnings if "quantile" in one.slug]
        assert warning.slug == "quantile-of-few-seeds"
        assert "the p95 of 10 seeds by the rule `excitation.until`" in warning.sentence


def test_picture_of_few_seeds_has_no_quantile_that_they_do_not_support(noisy):
    entries = legend(draw(run(load(noisy, {SEEDS: 6}))))
    assert "median" in entries
    entries = legend(draw(run(load(noisy, {SEEDS: 20}))))
    assert "5, 50, 95 % quantiles" in entries


def test_T_x_is_explained_in_summaries_pictures_and_report(drysim, noisy):
    swept = ["--set", "sweep={friction.kinetic: [10, 20]}"]
    for name, words in (("run", []), ("sweep", swept)):
        done = drysim(name, noisy, "--report", "--set", f"{SEEDS}=4", *words, "-o", name)
        (line,) = [line for line in done.out.splitlines() if line.startswith("  T_x ")]
        assert "x_r over u; " in line
        report = (noisy.parent / name / "report.html").read_text("utf-8")
        assert "relative displacement transmissibility RMS" in report
    table = package.sweep(load(noisy, {"sweep": {"friction.kinetic": [10, 20]}}))
    figure = table.plot()
    assert "Tₓ = xᵣ/u [–]" in figure.axes[0].get_title(loc="left")
    assert "Tₓ (xᵣ over u) " in " ".join(text.get_text() for text in figure.texts)


def test_a_check_whose_limit_lies_within_the_interval_is_a_warning(noisy):
    mean = run(load(noisy, {SEEDS: 10})).statistics["T_a"].mean
    found = run(load(noisy, {SEEDS: 10, "checks": [f"T_a < {mean + 1e-4}"]}))
    (warning,) = [one for one in found.warnings if one.slug == "check-undecided"]
    assert "holds for the mean of 10 seeds" in warning.sentence
    assert (found.exit_code(), found.exit_code(strict=True)) == (0, 1)


def test_a_mass_that_rests_with_the_first_seed_only_is_not_said_to_rest(noisy):
    rest = {"friction.kinetic": 118, "friction.static_ratio": 1, "excitation.rms": 0.5}
    alone = run(load(noisy, rest))
    assert alone.metrics["stuck_share"] == 1.0
    assert [one.slug for one in alone.warnings] == ["will-not-move"]
    found = run(load(noisy, rest | {SEEDS: 20}))
    assert found.statistics["stuck_share"].least[0] < 1.0
    assert found.warnings == ()


WORDS = {
    "seeds: 0": "excitation.seeds must be at least 2, as one seed has no confidence interval",
    "seeds: -4": "excitation.seeds must be at least 2",
    "seeds: 1": "excitation.seeds must be at least 2",
    "seeds: 2.5": "excitation.seeds must be a whole number, not 2.5",
    "seeds: true": "excitation.seeds must be a whole number, not true",
    "seeds: 1e12": "excitation.seeds must be at most 1000000000",
    "seeds: 1, until: {metric: T_a, half_width: 1 %}": "excitation.seeds must be at least 2",
    "until: {metric: T_b, half_width: 1 %}": "excitation.until.metric: unknown metric `T_b`; ",
    "until: {metric: SEAT, half_width: 1 %}": "excitation.until.metric: `SEAT` is not",
    "until: {metric: closure, half_width: 1 %}": "excitation.until.metric: `closure` is",
    "until: {metric: T_a, half_width: 0}": "excitation.until.half_width must be above 0",
    "until: {metric: T_a, half_width: -1 %}": "excitation.until.half_width must be above 0",
    "until: {metric: T_a, half_width: 1 mm}": "excitation.until.half_width: `mm` is a unit of",
    "until: {metric: T_a}": "excitation.until.half_width is required",
    "until: {half_width: 1 %}": "excitation.until.metric is required",
    "until: 1 %": "excitation.until must be a block of keys, not `1 %`",
}


@pytest.mark.parametrize(("words", "sentence"), WORDS.items(), ids=WORDS)
def test_faulty_words_are_refused_at_their_place(noisy, words, sentence):
    noisy.write_text(SEAT.replace("seed: 1", words))
    with pytest.raises(ScenarioError) as fault:
        load(noisy)
    (problem,) = fault.value.problems
    assert problem.sentence.startswith(sentence)
    assert problem.line == 4


REFUSED = [
    ({UNTIL: {"metric": "stroke_used", "half_width": 0.01}, "stroke": None},
     "`stroke_used` is not available without a stroke limit; give stroke.limit"),
    ({"excitation": {"kind": "harmonic", "frequency": 1, "rms": 1, "seeds": 4}},
     "unknown key `seeds` in excitation of kind harmonic"),
    ({SEEDS: 3, "sweep": {"excitation.seed": [1, 2]}},
     "excitation.seed cannot be swept with excitation.seeds"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), REFUSED)
def test_seeds_that_contradict_another_block_are_refused(noisy, changes, sentence):
    with pytest.raises(ScenarioError) as fault:
        load(noisy, changes)
    (problem,) = fault.value.problems
    assert sentence in problem.sentence


def test_more_seeds_than_the_memory_holds_are_refused(noisy):
    with pytest.raises(ScenarioError) as fault:
        run(load(noisy, {SEEDS: 900_000_000}))
    assert "seeds need" in fault.value.problems[0].sentence


def test_seeds_in_which_the_numerics_fail_are_left_out_of_the_means(drysim, tmp_path):
    (tmp_path / "unstable.yaml").write_text(UNSTABLE)
    answer = drysim("run", "unstable.yaml", "--no-plots")
    assert answer.code == 3
    told = fields_of("out/unstable")
    failed = told["ensemble"]["failed"]
    assert 0 < failed < 8
    assert told["complete"] is False
    assert told["ensemble"]["metrics"]["T_a"]["seeds"] == 8 - failed
    assert f"the numerics failed for {failed} of 8 seeds" in answer.err


def test_numerics_that_fail_with_every_seed_leave_nothing(tmp_path):
    file = tmp_path / "unstable.yaml"
    file.write_text(UNSTABLE.replace("3.4", "10"))
    with pytest.raises(SolverError, match="fail for every seed; the first: signum"):
        run(load(file))


def test_files_hold_every_seed_and_what_they_have_in_common(drysim, noisy, tmp_path):
    answer = drysim("run", noisy, "--set", f"{SEEDS}=12", "--set", "checks=[T_a < 1]")
    assert (answer.code, answer.err.count("warning")) == (0, 1), answer.err
    assert "seeds       12, from 1 to 12; values are mean" in answer.out
    folder = tmp_path / "out" / "noisy"
    names = {file.name for file in folder.iterdir()}
    assert {"ensemble.csv", "ensemble.png", "response.csv", "response.png"} < names
    found = rows_of(folder / "ensemble.csv")
    assert [row["excitation.seed [-]"] for row in found] == [str(n) for n in range(1, 13)]
    values = [float(row["T_a [-]"]) for row in found]
    told = fields_of(folder)
    mean, half_width = interval(values)
    assert told["metrics"]["T_a"] == told["ensemble"]["metrics"]["T_a"]["mean"] == mean
    assert told["ensemble"]["metrics"]["T_a"]["half_width"] == half_width
    assert told["checks"][0]["half_width"] == half_width
    u_dd = run(load(noisy)).response.motion.u_dd
    assert told["excitation"]["seed"] == 1
    assert told["excitation"]["sha256"] == hashlib.sha256(u_dd.astype("<f8").data).hexdigest()
    beyond = rows_of(folder / "stroke_violations.csv")
    assert len(beyond) == sum(float(row["violations [-]"]) > 0 for row in found)


def test_the_resolved_scenario_gives_the_same_ensemble(drysim, noisy, tmp_path):
    drysim("run", noisy, "--set", f"{SEEDS}=3", "--no-plots")
    again = load(tmp_path / "out" / "noisy" / "scenario.yaml")
    assert same(run(again), run(load(noisy, {SEEDS: 3})))


def test_a_dry_run_tells_the_seeds(drysim, noisy):
    words = ("run", noisy, "--dry-run", "--set", f"{SEEDS}=20")
    assert "noisy: 20 seeds, 2000 steps" in drysim(*words).out
    assert json.loads(drysim(*words, "--json").out)["seeds"] == 20
    wish = f"{UNTIL}={{metric: T_a, half_width: 1 %}}"
    assert "noisy: up to 400 seeds" in drysim("run", noisy, "--dry-run", "--set", wish).out


@pytest.mark.parametrize("option", [("--workers", 2), ("--resume",)])
def test_what_only_seeds_can_use_is_refused_without_them(refused, noisy, option):
    assert "needs several seeds" in refused("run", noisy, *option)


@contextmanager
def stopped(monkeypatch):
    """Interrupt a run of nine seeds at its last."""
    solve_seeds = study_plan.solve_seeds

    def interrupted(case, case_range, motions):
        if case_range.end == 9:
            raise KeyboardInterrupt
        return solve_seeds(case, case_range, motions)

    with monkeypatch.context() as patched:
        patched.setattr(study_plan, "solve_seeds", interrupted)
        yield


def test_an_interrupted_run_keeps_its_seeds_and_goes_on(drysim, noisy, tmp_path, monkeypatch):
    check = "--set", "checks=[T_a < 1e9]"
    words = ("run", noisy, "--set", f"{SEEDS}=9", *check, "--no-plots", "--out")
    assert drysim(*words, "whole").code == 0
    with stopped(monkeypatch):
        answer = drysim(*words, "part", "--workers", 1)
    assert answer.code == 130
    assert "T_a < 1e9; not decided before all seeds are computed" in answer.out
    assert "8 finished seeds are kept in part.partial" in answer.err
    assert "  state       incomplete: 8 of 9 seeds\n" in answer.out
    told = fields_of("part.partial")
    assert (told["complete"], told["ensemble"]["seeds"]) == (False, 8)
    (tmp_path / "part.partial" / "drysim.json").write_text('{"format": 2, "complete": false}')
    for place, sentence in (
        ("part.partial", "part.partial/drysim.json has no finished result"),
        ("part", "part is not finished: its parts are in part.partial"),
    ):
        answer = drysim("summarise", place)
        assert answer.err.startswith(f"error: {sentence}")
        told = "finish it with its command and --resume, `drysim run ... --resume`"
        assert told in answer.err
    planned = drysim(*words, "part", "--dry-run")
    assert "finished seeds in part.partial would be discarded without --resume" in planned.err
    answer = drysim(*words, "part", "--resume")
    assert (answer.code, answer.err.count("\n")) == (0, answer.err.count("warning: ") + 1)
    assert answer.err.startswith("--resume: continuing after 8 seeds in part.partial\n")
    answer = drysim(*words, "part", "--resume")
    assert answer.err.startswith(
        "--resume: no finished seeds in part.partial, starting from the beginning; part is "
        "finished and is computed again"
    )
    assert not (tmp_path / "part.partial").exists()
    for name in ("ensemble.csv", "response.csv"):
        parts = [(tmp_path / folder / name).read_bytes() for folder in ("part", "whole")]
        assert parts[0] == parts[1]


@pytest.fixture
def values(process, tmp_path):
    """Return a metric of every seed, by a process of its own: this one may be plain Python."""

    def of(file, metric, *changes):
        sets = [word for change in changes for word in ("--set", change)]
        words = ("run", file, "--no-plots", "--quiet", "--out", "many", *sets)
        assert process(*words, DRYSIM_ENGINE="compiled").code == 0
        rows = rows_of(tmp_path / "many" / "ensemble.csv")
        return np.array([float(row[metric]) for row in rows])

    return of


def test_without_friction_the_mean_is_that_of_the_spectrum(noisy, values):
    """Only phases are random, so the mean square of ẍ over any window is that of the lines."""
    long = ("friction=null", "excitation.duration=50", "measure={settle: 10}", f"{SEEDS}=60")
    a_x = values(noisy, "a_x [m/s2]", *long)
    f = np.arange(25, 501) / 50.0
    s = 2j * np.pi * f
    T = (500 * s + 7500) / (75 * s**2 + 500 * s + 7500)
    exact = 0.67**2 * np.mean(np.abs(T) ** 2)
    mean, half_width = interval((a_x**2).tolist())
    assert half_width < 0.02 * exact
    assert abs(mean - exact) < half_width


def laplace(b, limit):
    """Mean of v_r² by the density exp(-(b v²/2 + F|v|)), F = 1 N, m = 1 kg, D = 1."""
    v = np.linspace(0.0, limit, 1_000_001)
    density = np.exp(-(0.5 * b * v * v + v))
    return float((v * v * density).sum() / density.sum())


@pytest.fixture
def on_white_noise(values, tmp_path):
    """Return v_r² of each seed of a block on noise of two-sided intensity 2D, D = 1 m²/s³."""

    def squares(b, step, duration, seeds):
        file = tmp_path / "block.yaml"
        file.write_text(
            f"oscillator: {{mass: 1, stiffness: 0, damping: {b}}}\n"
            "friction: {law: coulomb, kinetic: 1}\n"
            f"excitation: {{kind: psd, points: [[{0.5 / duration}, 4], [{0.49 / step}, 4]],\n"
            f"  duration: {duration}, seeds: {seeds}}}\n"
            f"solver: {{step: {step}}}\nmeasure: {{settle: 50}}\n"
        )
        return values(file, "v_r_rms [m/s]") ** 2

    return squares


def test_a_block_on_white_noise_has_the_laplace_law_within_its_own_interval(on_white_noise):
    """The noise ends at 12 Hz, which takes 1 % away by its trend; the interval is ±5 %."""
    mean, half_width = interval(on_white_noise(0, 0.04, 1000, 30).tolist())
    assert half_width < 0.06 * laplace(0, 60)
    assert abs(mean - laplace(0, 60)) < half_width


@pytest.mark.slow
def test_a_damped_block_on_white_noise_has_its_law_within_one_percent(on_white_noise):
    """What the end of the band takes goes with the step, so two steps tell it for no step."""
    coarse, fine = (on_white_noise(1, step, 500, 200) for step in (0.02, 0.01))
    mean, half_width = interval((2 * fine - coarse).tolist())
    assert half_width < 0.01 * laplace(1, 20)
    assert abs(mean - laplace(1, 20)) < half_width
    rough, narrow = interval(coarse.tolist())
    assert abs(rough - laplace(1, 20)) > narrow, "without that the interval misses the law"


def test_seeds_of_another_run_are_refused_and_damaged_ones_computed_again(
    drysim, noisy, monkeypatch
):
    """The seeds lie in a store like the cases of a sweep, which test_store damages."""
    words = ("run", noisy, "--set", f"{SEEDS}=9", "--no-plots", "-q", "--workers", 1)
    with stopped(monkeypatch):
        assert drysim(*words, "-o", "part").code == 130
    assert drysim(*words, "-o", "whole").code == 0
    partial = noisy.parent / "part.partial"
    before = {file: file.read_bytes() for file in partial.rglob("*") if file.is_file()}
    assert partial / "ensemble.csv" in before
    other = drysim(*words, "-o", "part", "--resume", "--set", "oscillator.mass=76")
    assert other.code == 2
    assert before == {file: file.read_bytes() for file in partial.rglob("*") if file.is_file()}
    told = "part.partial holds cases of other work: another scenario, record or version"
    assert told in other.err
    store = partial / "seeds"
    first, second, *others = sorted(store.glob("*.npz"))
    assert len(others) > 3
    content = bytearray(first.read_bytes())
    content[len(content) // 2] ^= 1
    first.write_bytes(content)
    second.write_bytes(second.read_bytes()[:-9])
    assert drysim(*words, "-o", "part", "--resume") == (0, "", "")
    assert not store.parent.exists()
    folders = noisy.parent / "part", noisy.parent / "whole"
    assert len({(folder / "ensemble.csv").read_bytes() for folder in folders}) == 1


def test_partial_that_is_removed_during_a_run_is_named(drysim, noisy, monkeypatch):
    def progress(*_):
        return nullcontext(lambda n: shutil.rmtree("part.partial", ignore_errors=True))

    monkeypatch.setattr(terminal, "progress", progress)
    done = drysim("run", noisy, "--set", f"{SEEDS}=9", "--no-plots", "-o", "part")
    assert done.code == 2
    assert done.err.startswith("error: part.partial was removed, in whole or in part, while")
    assert not list(noisy.parent.glob("part*"))


# Means over many values: their interval, quantiles and extremes.


def test_interval_is_that_of_students_t():
    from scipy import stats

    values = [0.98, 1.01, 1.03, 0.97, 1.0]
    mean, half_width = interval(values)
    low, high = stats.t.interval(0.95, 4, np.mean(values), stats.sem(values))
    assert (mean - half_width, mean + half_width) == pytest.approx((low, high), rel=1e-12)


def test_interval_holds_the_true_mean_in_95_of_100_cases():
    random = np.random.Generator(np.random.PCG64(2))
    held = 0
    for values in random.normal(3.0, 2.0, (4000, 6)):
        mean, half_width = interval(values.tolist())
        held += abs(mean - 3.0) <= half_width
    # The share itself scatters by 0.35 %.
    assert held / 4000 == pytest.approx(0.95, abs=0.012)


def test_interval_does_not_depend_on_the_order_of_the_values():
    values = np.random.Generator(np.random.PCG64(4)).normal(0.0, 1.0, 50)
    assert interval(values.tolist()) == interval(values[::-1].tolist())


def T_a_of(*values, first=1):
    """Return the statistics of seeds with these values of T_a."""
    rows = [
        Row({SEED_KEY: seed}, "stick-slip", 0.0, 0.0, {"T_a": value})
        for seed, value in enumerate(values, first)
    ]
    return statistics(Batch.of(0, rows))["T_a"]


def test_statistics_of_seeds_are_those_of_their_values():
    single = T_a_of(2.5)
    assert (single.mean, single.half_width, single.std) == (2.5, None, None)
    equal = T_a_of(0.1, 0.1, 0.1)
    assert (equal.mean, equal.half_width, equal.quantiles) == (0.1, 0.0, (0.1, 0.1, 0.1))
    several = T_a_of(3.0, 1.0, 7.0, 1.0, first=11)
    assert (several.least, several.greatest) == ((1.0, 12), (7.0, 13))
    even = T_a_of(*np.linspace(0, 1, 1001))
    assert even.quantiles == pytest.approx((0.05, 0.5, 0.95), abs=1e-3)
    incomplete = T_a_of(1.0, None, 3.0)
    assert (incomplete.seeds, incomplete.mean) == (2, 2.0)
    assert T_a_of(None, None) is None


@pytest.mark.parametrize(
    ("mean", "half_width", "words"),
    [
        (0.837619, 0.00137, "0.8376 ± 0.0014 mm"),
        (5.88168, 0.487, "5.88 ± 0.49 mm"),
        (47.087, 3.2, "47.1 ± 3.2 mm"),
        (1234.5, 96.0, "1234 ± 96 mm"),
        (12345.0, 960.0, "12345 ± 960 mm"),
        (3e-16, 1e-16, "3e-16 ± 1e-16 mm"),
        (0.67, 0.0, "0.67 mm"),
        (0.67, 1e-17, "0.67 mm"),
        (0.67, None, "0.67 mm"),
        (None, None, "not known"),
    ],
)
def test_a_mean_ends_where_its_interval_begins(mean, half_width, words):
    assert format_interval(mean, half_width, "mm") == words


def test_metric_of_the_stopping_rule_is_shown_with_its_unit(noisy):
    until = {"metric": "x_r_rms", "half_width": 0.5}
    result = run(load(noisy, {SEEDS: 6, UNTIL: until}))
    [row] = [row for row in ensemble_rows(result) if row.label == "x_r_rms"]
    assert row.value.endswith(" mm")
