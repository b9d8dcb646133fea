"""Design studies: optima in closed form, limits, conditions, seeds, files, faults."""

from __future__ import annotations

import re
import shlex
import tracemalloc
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from seat import fields_of, rows_of
from shown import legend

import drysim
from drysim.results.design import best_rows
from drysim.study import plan
from drysim.study.design import (
    DesignResult,
    Study,
    evaluations_of,
    make_candidate,
    optimum_region,
    prepare_design,
)
from drysim.study.statistics import OverSeeds, Row
from drysim.study.store import Store, work_identity
from drysim.study.sweep import on_workers
from drysim.wording import format_number

M, K_X = 75.0, 7500.0
OMEGA = np.sqrt(K_X / M)

SINE = """
oscillator: {mass: 75, stiffness: 7500, damping: 300}
excitation: {kind: harmonic, frequency: 2 Hz, rms: 1}
solver: {step: 2.5e-3}
"""
NOISE = """
oscillator: {mass: 75, stiffness: 7500, damping: 300}
friction: {law: coulomb, kinetic: 10, static_ratio: 1.2}
stroke: {limit: 40 mm}
excitation: {kind: standard, class: EM1, duration: 15 s, seed: 1, seeds: 6}
solver: {step: 5e-3}
measure: {settle: 3 s, direction: vertical}
"""
THREE_HZ = SINE.replace("2 Hz", "3 Hz")
WIDE = "oscillator.damping: {from: 100, to: 3000, scale: log}"
KEY = "oscillator.damping"
STIFFNESS = "oscillator.stiffness: {from: 5000, to: 9000}"
DAMPING = "oscillator.damping: {from: 50, to: 5000, scale: log}"


def text_of(
    scene: str = SINE, vary: str = DAMPING, minimise: str | None = "T_a", **further: object
) -> str:
    """Return the text of a scenario with a design block."""
    keys = {"vary": f"{{{vary}}}", "minimise": minimise, **further}
    lines = [f"  {key}: {value}\n" for key, value in keys.items() if value is not None]
    return "".join([scene, "design:\n", *lines])


def study_of(*words: str, overrides: object = (), **keys: object) -> drysim.Scenario:
    """Return a scenario with a design block."""
    return drysim.scenario(text_of(*words, **keys), overrides)


def design_of(*words: str, **keys: object) -> DesignResult:
    """Return the result of a scenario with a design block."""
    return drysim.design(study_of(*words, **keys))


def write_study(*words: str, **keys: object) -> None:
    """Write a scenario with a design block into the working folder."""
    Path("study.yaml").write_text(text_of(*words, **keys), encoding="utf-8")


def sine_ratios(b, frequency=2.0, k_x=K_X):
    """Return T_a, and peak |x_r| per unit of base amplitude [s²], without dry friction."""
    w = 2.0 * np.pi * frequency
    stiffness = k_x - M * w**2 + 1j * b * w
    return abs((k_x + 1j * b * w) / stiffness), abs(M / stiffness)


def test_damping_of_least_transmission_within_the_stroke_is_that_of_the_closed_form():
    # Above sqrt(2) f_0 less damping transmits less, and moves more: the stroke decides.
    limit = 4.2e-3
    result = design_of(THREE_HZ, within=f"[x_r_peak < {limit}]")
    b = np.geomspace(50, 5000, 200_001)
    T_a, stroke = sine_ratios(b, 3.0)
    least = T_a[np.sqrt(2.0) * stroke < limit].min()
    assert result.converged
    assert result.best is not None
    assert result.best.objectives[0] == pytest.approx(least, rel=1e-3)
    assert result.metrics["x_r_peak"] < limit
    assert [str(one.limit) for one in result.binding] == [f"x_r_peak < {limit}"]
    assert result.binding[0].objective == pytest.approx(T_a.min(), rel=1e-2)
    low, _ = result.flat.ends[KEY]
    assert low == pytest.approx(result.best.values[KEY], rel=1e-2)
    assert result.exit_code() == 0


def test_worst_of_several_frequencies_counts_or_their_mean():
    b = np.geomspace(50, 5000, 20_001)
    several = np.array([sine_ratios(b, f)[0] for f in (1.6, 5.0)])
    for take, exact in (("worst", several.max(axis=0)), ("mean", several.mean(axis=0))):
        result = design_of(over=f"{{excitation.frequency: [1.6, 5], take: {take}}}")
        assert result.best is not None
        assert result.best.objectives[0] == pytest.approx(exact.min(), rel=1e-3), take
        assert len(result.best.rows) == 2


def test_limits_hold_under_every_condition():
    over = "{excitation.frequency: [1.6, 5], take: mean}"
    result = design_of(within="[x_r_peak < 8 mm]", over=over)
    assert result.best is not None
    assert max(row.metrics["x_r_peak"] for row in result.best.rows) < 8e-3
    (verdict,) = result.checks
    assert verdict.where == {"excitation.frequency": 1.6}


def test_stroke_limit_and_checks_of_the_file_are_the_default_limits():
    limits = "stroke: {limit: 4.2 mm}\nchecks: [x_r_peak < 4.2 mm]\n"
    result = design_of(THREE_HZ + limits, minimise="a_x")
    assert [str(limit) for limit in result.limits] == ["x_r_peak < 4.2 mm", "stroke_used < 1"]
    assert result.metrics["stroke_used"] < 1.0
    # Neither binds alone, as the other one repeats it.
    (binding,) = result.binding
    assert binding.text == "x_r_peak < 4.2 mm and stroke_used < 1"
    assert binding.objective < 0.99 * result.best.objectives[0]


def test_designs_that_reach_rigid_stops_exceed_the_stroke_limit_as_cases_of_a_sweep_do():
    scene = f"{SINE}stroke: {{limit: 12 mm, stops: {{restitution: 0.5}}}}\n"
    result = design_of(scene, minimise="a_x", evaluations=8)
    reached = [bool(each.rows[0].metrics["violations"]) for each in result.candidates]
    assert {*reached} == {True, False}
    assert max(each.rows[0].metrics["stroke_used"] for each in result.candidates) == 1.0
    assert [not each.is_admissible for each in result.candidates] == reached


def test_study_without_an_admissible_design_names_the_closest_and_fails():
    result = design_of(within="[x_r_peak < 1 um]")
    assert result.best is None
    assert result.closest is not None
    assert result.closest.values == {"oscillator.damping": 5000.0}
    assert [verdict.passed for verdict in result.checks] == [False]
    assert result.exit_code() == 1
    assert "none is admissible" in repr(result)


def test_front_of_transmission_and_stroke_lies_on_the_closed_form():
    result = design_of(THREE_HZ, minimise="[T_a, x_r_peak]", evaluations=120)
    assert len(result.front) > 30
    for one in result.front:
        T_a, stroke = sine_ratios(one.values[KEY], 3.0)
        assert one.objectives == pytest.approx((T_a, np.sqrt(2.0) * stroke), rel=1e-9)
    first = [one.objectives[0] for one in result.front]
    assert first == sorted(first)
    assert result.best in result.front
    assert result.optimum is None


def test_all_seeds_are_the_same_for_every_design_and_give_intervals(monkeypatch):
    observe, drawn = plan.observe_motion, defaultdict(set)

    def noted(case, start):
        drawn[case.plant.b].add(case.motion.u_dd.tobytes())
        return observe(case, start)

    monkeypatch.setattr(plan, "observe_motion", noted)
    scenario = study_of(NOISE, WIDE, "SEAT", within=[])
    result = drysim.design(scenario)
    best = result.best
    assert best is not None
    first, *others = drawn.values()
    assert len(first) == 6
    assert others
    assert all(one == first for one in others)
    assert result.half_widths[0] > 0.0
    low, high = result.optimum.ends[KEY]
    assert low <= best.values[KEY] <= high
    wide = result.flat.ends[KEY]
    assert wide[0] <= low
    assert high <= wide[1]
    # The best of a dense grid under the same seeds is no better, and lies within the interval.
    axis = {"sweep": {KEY: np.geomspace(300, 3000, 60).tolist()}}
    grid = min(drysim.sweep(drysim.scenario(NOISE, axis)), key=lambda row: row.metrics["SEAT"])
    assert best.objectives[0] <= grid.metrics["SEAT"] * (1.0 + 1e-4)
    assert 0.95 * low < grid.point[KEY] < 1.05 * high


def parabolas(
    seeds: int, conditions: int, designs: int, spread: float = 0.1, close: Sequence[float] = ()
) -> DesignResult:
    """Return designs whose SEAT is a parabola with another minimum for every seed.

    The minima have the standard deviation `spread`, as a share of the range; `close` are shares
    of the range at which there are designs besides the even ones.
    """
    over, many = "{oscillator.mass: [60, 90]}", {"excitation.seeds": seeds}
    scenario = study_of(NOISE, WIDE, "SEAT", over=over, overrides=many)
    optima = np.random.default_rng(1).normal(0.5, spread, seeds)
    candidates = []
    for number, share in enumerate([*np.linspace(0.0, 1.0, designs), *close], 1):
        SEAT, used = 1.0 + (share - optima) ** 2, np.full(seeds, share)
        values = {"SEAT": SEAT.tolist(), "stroke_used": used.tolist()}
        means = {name: float(np.mean(several)) for name, several in values.items()}
        rows = [
            Row({"oscillator.mass": 60.0 + i}, "stick-slip", 10.0, 12.0, means,
                over=OverSeeds(seeds, 1, values=values))
            for i in range(conditions)
        ]  # fmt: skip
        damping = {KEY: 100.0 * 30.0**share}
        candidates.append(make_candidate(scenario, number, damping, tuple(rows)))
    return DesignResult(scenario, prepare_design(scenario), tuple(candidates))


def test_interval_of_the_optimum_is_that_of_the_mean_of_the_optima_of_the_seeds():
    result = parabolas(100, 2, 33)
    region = optimum_region(result, evaluations_of(result.source, result.candidates))
    shares = [np.log(end / 100.0) / np.log(30.0) for end in region.ends[KEY]]
    optima = np.random.default_rng(1).normal(0.5, 0.1, 100)
    half = 1.984 * optima.std(ddof=1) / 10.0
    assert shares == pytest.approx([optima.mean() - half, optima.mean() + half], abs=0.01)


def test_designs_close_to_each_other_do_not_widen_the_interval_of_the_optimum():
    close = 0.5 + np.array([1e-4, -1e-4, 3e-3, 2e-4, -3e-3, -2e-4, 0.02, 3e-4, -0.02, 5e-4])
    result = parabolas(100, 1, 33, 0.01, [*close, *close[::2] + 1e-4])
    region = optimum_region(result, evaluations_of(result.source, result.candidates))
    low, high = (np.log(end / 100.0) / np.log(30.0) for end in region.ends[KEY])
    assert high - low == pytest.approx(2.0 * 1.984 * 0.01 / 10.0, rel=0.3)


def test_interval_of_the_optimum_needs_little_memory():
    result = parabolas(200, 6, 24)
    found = evaluations_of(result.source, result.candidates)
    tracemalloc.start()
    assert optimum_region(result, found) is not None
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 60e6  # all points, conditions and seeds at once are 135 MB


def test_metric_that_some_seeds_do_not_have_gives_no_interval_of_the_optimum():
    result = parabolas(10, 1, 24)
    for one in result.candidates:
        one.rows[0].over.values["SEAT"][3] = None
    found = evaluations_of(result.source, result.candidates)
    assert optimum_region(result, found) is None


def test_end_towards_which_a_limit_with_every_seed_pushes_the_optimum_is_open():
    # More seeds have a larger stroke, which takes more damping; resampling does not show it.
    tight = {"excitation.duration": 80, "stroke.limit": "14 mm"}
    bound = design_of(NOISE, WIDE, "SEAT", overrides=tight)
    free = design_of(NOISE, WIDE, "SEAT")
    low, high = bound.optimum.ends[KEY]
    assert high is None
    assert low <= bound.best.values[KEY]
    assert None not in free.optimum.ends[KEY]
    rows = {row.label: row for row in best_rows(bound)}
    assert "95 %: " in rows["damping"].remark
    assert ", upper end not known from these seeds" in rows["damping"].remark
    # The stroke of single runs is within the limit, that of an hour is not.
    assert re.match(r"1\d\d(\.\d+)? % of the limit", rows["hourly peak"].remark)
    [said] = [one.sentence for one in bound.warnings if one.slug == "stroke-too-short"]
    assert "is expected to be" in said
    assert said.endswith("with the best design")
    assert "stroke-too-short" not in {one.slug for one in free.warnings}


def test_variants_show_what_friction_and_stiffness_do():
    result = design_of(NOISE, WIDE, "SEAT")
    found = {one.name: one.candidate for one in result.variants}
    assert [*found] == [
        "as given", "friction +10 %", "friction -10 %", "stiffness +10 %", "stiffness -10 %",
        "no dry friction",
    ]  # fmt: skip
    assert found["as given"].values == {"oscillator.damping": 300.0}
    scene = drysim.scenario(NOISE, result.shown.values)
    changed = drysim.scenario(NOISE, {**result.shown.values, "friction.kinetic": 11})
    for name, scenario in (
        ("friction +10 %", changed),
        ("no dry friction", scene.with_approach("viscous")),
    ):
        exact = drysim.run(scenario).metrics["SEAT"]
        assert found[name].objectives[0] == pytest.approx(exact, rel=1e-12), name


STUDY = (NOISE, f"{WIDE}, friction.kinetic: {{from: 0, to: 60}}", "SEAT")
"""A study of two keys, of 24 evaluations."""


def test_result_does_not_depend_on_workers_or_on_an_interruption(tmp_path):
    scenario = study_of(*STUDY, evaluations=24)
    whole = drysim.design(scenario, workers=1)
    case = prepare_design(scenario)
    for batches in (1, 20, 26):
        (folder := tmp_path / f"after-{batches}").mkdir()
        left = iter(range(batches))

        def interrupt(_count: int, left=left) -> None:
            if next(left, None) is None:
                raise KeyboardInterrupt

        store = Store(folder / "designs", work_identity(scenario), resume=False)
        with on_workers(2) as execute, pytest.raises(KeyboardInterrupt):
            (study := Study(case, execute, store, interrupt)).solve()
        assert not study.partial().complete
        computed = []
        store = Store(folder / "designs", work_identity(scenario), resume=True)
        with on_workers(3) as execute:
            resumed = Study(case, execute, store, computed.append).solve()
        assert resumed.candidates == whole.candidates
        assert resumed.optimum.ends == whole.optimum.ends
        assert sum(computed) < len(whole.candidates) + len(whole.variants)


def test_best_design_runs_with_the_same_metrics(command):
    write_study(*STUDY, evaluations=24)
    done = command("design", "study.yaml", "--quiet")
    assert done.code == 0, done.err
    fields = fields_of("out/study-design")
    best = drysim.load("out/study-design/best.yaml")
    assert best.design is None
    again = drysim.run(best)
    assert again.metrics["SEAT"] == pytest.approx(fields["metrics"]["SEAT"], rel=1e-12)
    assert fields["design"]["best"]["objectives"]["SEAT"] == fields["metrics"]["SEAT"]
    rows = rows_of("out/study-design/design.csv")
    assert len(rows) == fields["numerics"]["evaluations"] == 24
    row = rows[fields["design"]["best"]["design"] - 1]
    assert float(row["SEAT [-]"]) == fields["metrics"]["SEAT"]
    assert row["admissible [-]"] == row["on_front [-]"] == "1"
    assert float(row["oscillator.damping [N*s/m]"]) == best.oscillator.damping
    resolved = drysim.load("out/study-design/scenario.yaml")
    assert resolved.design == drysim.load("study.yaml").design


@pytest.mark.parametrize(
    ("study", "sentence"),
    [
        ({"vary": ""}, "design.vary must be keys such as"),
        ({"minimise": "Ta"}, "unknown metric `Ta`; did you mean"),
        ({"minimise": "[T_a, T_a]"}, "names the same metric twice"),
        ({"minimise": "[[T_a]]"}, "must be text, not a list"),
        ({"minimise": None}, "design.minimise is required"),
        ({"vary": f"{KEY}: {{from: 10, to: 5}}"},
         "design.vary.oscillator.damping.to must be above `from`, 10"),
        ({"vary": f"{KEY}: {{from: 0, to: 5, scale: log}}"},
         "design.vary.oscillator.damping.from must be above 0 on a log scale"),
        ({"vary": f"{KEY}: 5"}, "design.vary.oscillator.damping must be {from, to}, not 5"),
        ({"vary": "oscillator.dampin: {from: 1, to: 5}"},
         "unknown key `oscillator.dampin` in design.vary; did you mean"),
        ({"vary": "excitation.kind: {from: 1, to: 5}"},
         "excitation.kind is not a number, so it cannot be varied"),
        ({"within": "[T_a < 1 at status == ok]"},
         "has a condition, but limits hold for every design; remove `at`"),
        ({"over": f"{{{KEY}: [1, 2]}}"},
         "design.over.oscillator.damping is varied as well; remove one of them"),
        ({"over": "{oscillator.mass: [70], take: best}"},
         "design.over.take must be worst or mean, not `best`"),
        ({"evaluations": 0}, "design.evaluations must be at least 1, not 0"),
        ({"scene": NOISE, "vary": "excitation.seed: {from: 1, to: 5}"},
         "excitation.seed cannot be"),
        ({"minimise": "SEAT"}, "design.minimise: SEAT is not available without a weighting"),
        ({"within": "[stroke_used < 1]"},
         "design.within #1: stroke_used is not available without a stroke limit"),
        ({"minimise": "fit_error"}, "design.minimise: fit_error is known to `drysim fit` only"),
        ({"scene": NOISE.replace("seeds: 6", "until: {metric: SEAT, half_width: 3 %}"),
          "minimise": "SEAT"}, "excitation.until is not supported by design"),
        ({"scene": NOISE, "minimise": "SEAT", "over": "{excitation.seeds: [3, 6]}"},
         "is not a condition"),
        ({"scene": f"{SINE}checks: [T_a < 2 at excitation.frequency >= 8]\n"},
         "has a condition"),
    ],
)  # fmt: skip
def test_faults_are_named_and_nothing_is_written(refused, study, sentence):
    write_study(**study)
    assert sentence in refused("design", "study.yaml")


def test_scenario_without_a_design_block_is_refused(refused, seat):
    told = "design is required: the keys to vary, and the metric to minimise"
    assert told in refused("design", seat)


def test_dry_run_states_the_study_and_computes_nothing(command):
    write_study(*STUDY, evaluations=24)
    done = command("design", "study.yaml", "--dry-run")
    assert done.code == 0
    assert "at most 24 designs, each under 1 condition with 6 seeds" in done.out
    assert not Path("out").exists()


def test_search_that_is_not_finished_says_so():
    result = design_of(evaluations=5)
    assert not result.converged
    assert [warning.slug for warning in result.warnings] == ["search-not-finished"]
    assert result.exit_code(strict=True) == 1


RECORD = """
oscillator: {mass: 75, stiffness: 7500, damping: 300}
excitation: {kind: record, file: floor-1.csv, column: u, time: t}
"""


def write_floor(file: Path, seed: int, duration: float) -> None:
    """Write a record of smoothed noise."""
    t = np.arange(0.0, duration, 0.01)
    u = np.convolve(np.random.default_rng(seed).normal(size=len(t)), np.ones(10) / 10, "same")
    lines = [f"{a:.2f},{b:.6f}" for a, b in zip(t, u, strict=True)]
    file.write_text("t [s],u [m/s2]\n" + "\n".join(lines) + "\n", encoding="utf-8")


def test_design_is_judged_by_the_worst_of_several_records(tmp_path, command):
    for seed, duration in ((1, 10.0), (2, 14.0)):
        write_floor(tmp_path / f"floor-{seed}.csv", seed, duration)
    write_study(RECORD, DAMPING, "a_x", over="{excitation.file: floor-?.csv}")
    result = drysim.design(drysim.load("study.yaml"))
    assert [one.file for one in result.inputs] == ["floor-1.csv", "floor-2.csv"]
    alone = [
        drysim.run(drysim.load("study.yaml", {**result.best.values, "excitation.file": file}))
        for file in ("floor-1.csv", "floor-2.csv")
    ]
    worst = max(one.metrics["a_x"] for one in alone)
    assert result.best.objectives[0] == pytest.approx(worst, rel=1e-12)
    assert result.optimum is None
    heading = result.plot().texts[2].get_text()
    assert re.match("worst of 2 conditions; record from 2 files, 9.99 to 13.99 s, ", heading)
    # The written scenario finds the records from its own folder.
    assert command("design", "study.yaml", "--quiet", "--no-plots").code == 0
    written = "out/study-design/scenario.yaml"
    assert command("design", written, "--quiet", "--no-plots", "--out", "out/again").code == 0
    done = command("design", "study.yaml", "--set", "design.over.excitation.file=[floor-9.csv]")
    assert done.code == 2
    assert "design.over.excitation.file #1: floor-9.csv: the record does not exist" in done.err


@pytest.mark.parametrize(
    ("scene", "metric", "sentence"),
    [
        (SINE, "x_dd_peak", "x_dd_peak is not known"),
        (
            SINE.replace("harmonic, frequency: 2 Hz, rms: 1", "rest")
            + "start: {x_r: 1 mm}\nmeasure: {duration: 1 s}\n",
            "T_a",
            "T_a is not known for the motion of any of the first designs",
        ),
    ],
)
def test_metric_that_no_design_has_is_named_at_once(scene, metric, sentence):
    with pytest.raises(drysim.SolverError, match=sentence):
        design_of(scene, minimise=metric)


def test_contradicting_values_are_passed_over():
    # Static friction cannot be below the kinetic one.
    scene = f"{SINE}friction: {{kinetic: 20, static: 25}}\n"
    vary = f"{DAMPING}, friction.static: {{from: 10, to: 60}}"
    result = design_of(scene, vary, evaluations=40)
    lost = [one for one in result.candidates if not one.is_known]
    assert lost
    assert all(one.values["friction.static"] < 20.0 for one in lost)
    assert "static must be at least the kinetic" in lost[0].rows[0].note
    assert result.best is not None
    assert "designs-lost" in [warning.slug for warning in result.warnings]


def test_variants_of_a_varied_ratio_change_the_forces_only():
    scene = f"{SINE}friction: {{kinetic: 20, static_ratio: 1.02}}\n"
    result = design_of(scene, "friction.static_ratio: {from: 1, to: 1.05}", evaluations=10)
    found = {one.name: one.candidate for one in result.variants}
    (row,) = found["friction -10 %"].rows
    assert row.F_fk == pytest.approx(18.0)
    assert row.F_fs == pytest.approx(18.0 * result.best.values["friction.static_ratio"])


@pytest.mark.parametrize("key", ["friction.kinetic", "friction.static"])
def test_range_beyond_a_stated_value_is_named_before_the_study(key):
    def warned(vary):
        study = study_of(f"{SINE}friction: {{kinetic: 20, static: 25}}\n", vary)
        warnings = prepare_design(study).warnings
        return [each.sentence for each in warnings if each.slug == "contradicting-range"]

    (sentence,) = warned(f"{key}: {{from: 10, to: 60}}")
    assert "static must be at least the kinetic" in sentence
    assert not warned("friction.kinetic: {from: 10, to: 24}")


def test_variants_of_stiffness_keep_the_damper_that_a_ratio_states():
    def objectives(damper):
        scene = SINE.replace("damping: 300", damper) + "friction: {kinetic: 5}\n"
        result = design_of(scene, "friction.kinetic: {from: 4, to: 5}", evaluations=8)
        return {one.name: one.candidate.objectives[0] for one in result.variants}

    one, other = objectives("damping: 300"), objectives("damping_ratio: 0.2")
    for name in ("stiffness +10 %", "stiffness -10 %"):
        assert other[name] == pytest.approx(one[name], rel=1e-9)


def test_strict_limit_does_not_hold_at_its_value():
    scene = f"{SINE}friction: {{kinetic: 5}}\n"
    result = design_of(scene, within="[stuck_share > 0]", evaluations=12)
    for one in result.candidates:
        assert one.is_admissible is (one.rows[0].metrics["stuck_share"] > 0.0)


def test_narrow_range_is_searched_with_digits_enough():
    result = design_of(vary="oscillator.damping: {from: 20, to: 20.004, scale: log}")
    assert len({one.values[KEY] for one in result.candidates}) > 10


def test_more_evaluations_may_be_allowed_to_an_interrupted_study(monkeypatch, command):
    write_study(*STUDY, evaluations=24)
    words = "design", "study.yaml", "--quiet", "--no-plots"
    advance = Study.evaluate

    def interrupted(self, points):
        if self.candidates:
            raise KeyboardInterrupt
        return advance(self, points)

    with monkeypatch.context() as patched:
        patched.setattr(Study, "evaluate", interrupted)
        assert command(*words).code == 130
    done = command(*words, "--resume", "--set", "design.evaluations=28")
    assert done.code == 0, done.err
    rows = Path("out/study-design/design.csv").read_text("utf-8").splitlines()
    assert len(rows) == 1 + 28


def test_stroke_limit_that_is_replaced_and_exceeded_is_warned_of():
    limit = {"stroke.limit": "14 mm"}
    result = design_of(NOISE, WIDE, "SEAT", within="[x_r_peak < 12 mm]", overrides=limit)
    slugs = [warning.slug for warning in result.warnings]
    assert "stroke-violated" in slugs
    assert "check-undecided" in slugs
    assert result.exit_code() == 0
    assert result.exit_code(strict=True) == 1


@pytest.mark.parametrize(
    ("within", "sentence"),
    [
        (
            "[x_r_peak < 10 mm, x_r_peak > 20 mm]",
            "design.within #2: no design can keep both `x_r_peak < 10 mm` and `x_r_peak > 20",
        ),
        ("[T_a < 2, x_r_peak < 0]", "design.within #2: no design can keep `x_r_peak < 0`"),
    ],
)
def test_limits_that_no_design_can_keep_are_located(within, sentence):
    with pytest.raises(drysim.ScenarioError, match=re.escape(sentence)) as caught:
        design_of(within=within)
    (problem,) = caught.value.problems
    assert problem.line == 8, problem


def test_checks_that_contradict_each_other_or_the_stroke_limit_are_no_limits():
    for checks in ("[T_a < 1, T_a > 2]", "[T_a < 2, stroke_used > 1]"):
        scene = f"{SINE}stroke: {{limit: 12 mm}}\nchecks: {checks}\n"
        with pytest.raises(drysim.ScenarioError, match="checks #2: no design can keep both"):
            design_of(scene, minimise="a_x")


def test_limits_of_a_study_are_checked_for_units():
    result = design_of(within="[x_r_peak < 25]")
    (warning,) = (one for one in result.warnings if one.slug == "looks-like-millimetres")
    assert "the limit `x_r_peak < 25` of design.within is 25 m" in warning.sentence
    assert "write `25 mm`" in warning.sentence


def test_varied_length_of_either_sign_is_checked_for_units():
    scenario = study_of(vary="start.x_r: {from: -30, to: -25}")
    sentences = [problem.sentence for problem in drysim.validate(scenario)]
    assert "start.x_r is 30 m; if it is in millimetres, write `30 mm`" in sentences


def test_stroke_limit_of_every_seed_is_not_the_limit_of_their_mean():
    # Of 6 seeds the mean keeps the limit with less damping than each of them.
    scene = NOISE.replace("40 mm", "14 mm")
    strict = design_of(scene, WIDE, "SEAT")
    mean = design_of(scene, WIDE, "SEAT", within="[stroke_used < 1]")
    assert [str(one) for one in strict.limits] == ["stroke_used < 1 with every seed"]
    assert [str(one) for one in mean.limits] == ["stroke_used < 1"]
    assert mean.best.objectives[0] < strict.best.objectives[0]
    slugs = [[one.slug for one in result.warnings] for result in (strict, mean)]
    assert ["stroke-violated" in one for one in slugs] == [False, True]
    (row,) = strict.best.rows
    assert 0.9 < max(row.over.values["stroke_used"]) <= 1.0  # settling included
    assert row.metrics["stroke_used"] < max(row.over.values["stroke_used"])


def test_name_of_the_stroke_limit_is_the_same_everywhere(command):
    write_study(NOISE, WIDE, "SEAT", evaluations=20)
    done = command("design", "study.yaml", "--no-plots")
    name = "stroke_used < 1 with every seed"
    assert done.code == 0, done.err
    assert f"within      {name}" in done.out
    assert f"holds     {name}, with 0." in done.out
    fields = fields_of("out/study-design")
    assert fields["design"]["within"] == [name]
    for row in rows_of("out/study-design/design.csv"):
        kept = float(row["stroke_used_max [-]"]) <= 1.0
        assert row["admissible [-]"] == str(int(kept))
        assert float(row["stroke_used [-]"]) <= float(row["stroke_used_max [-]"])


def test_limits_may_be_those_of_every_seed_or_of_a_quantile():
    scene = NOISE.replace("40 mm", "14 mm")
    mean, quantile, every, stroke = (
        design_of(scene, WIDE, "SEAT", within=f"[{text}]").best.objectives[0]
        for text in (
            "x_r_peak < 14 mm",
            "x_r_peak p75 < 14 mm",
            "x_r_peak < 14 mm with every seed",
            "stroke_used < 1 with every seed",
        )
    )
    assert mean < quantile < every <= stroke  # the stroke counts while settling, too


def test_best_design_runs_with_the_limits_as_its_checks():
    found = design_of(NOISE, WIDE, "SEAT", evaluations=20)
    assert found.scenario.checks == found.limits
    (check,) = drysim.run(found.scenario).checks
    assert (str(check.check), check.passed) == ("stroke_used < 1 with every seed", True)
    assert check.value == pytest.approx(found.checks[0].value)


def test_hourly_stroke_and_damping_name_the_mass_and_bounds_are_binding():
    scene = NOISE.replace("duration: 15 s", "duration: 80 s")
    scene = scene.replace("damping: 300", "damping_ratio: 0.3").replace("40 mm", "200 mm")
    vary, over = "oscillator.damping_ratio: {from: 0.1, to: 0.2}", "{oscillator.mass: [60, 90]}"
    found = design_of(scene, vary, "x_r_peak", evaluations=12, over=over)
    rows = list(best_rows(found))
    by_label = {row.label: row for row in rows}
    k_x = found.scenario.oscillator.plant().k_x
    low, high = (2 * 0.2 * (k_x * mass) ** 0.5 for mass in (60, 90))
    assert by_label["damping_ratio"].value == "0.2"
    between = f"damping {format_number(low)} to {format_number(high)} N·s/m"
    assert between in by_label["damping_ratio"].remark
    assert " of the limit at mass 90 kg; reached once an hour" in by_label["hourly peak"].remark
    assert rows[-1].value == "damping_ratio <= 0.2"
    assert rows[-1].remark == "upper end of its range; a better design may lie beyond"


@pytest.mark.parametrize(
    ("key", "low", "high", "metric", "is_said"),
    [
        ("stroke.offset", 0, 0.02, "stroke_used", True),
        ("friction.kinetic", 10, 40, "T_a", True),
        ("friction.kinetic", 0, 40, "T_a", False),
    ],
)
def test_zero_binds_a_design_only_if_its_key_can_be_negative(key, low, high, metric, is_said):
    scene = SINE.replace("2 Hz", "4 Hz") + "friction: {kinetic: 10}\n"
    scene += "stroke: {limit: 90 mm, offset: 0}\n"
    found = design_of(scene, f"{key}: {{from: {low}, to: {high}}}", metric, evaluations=12)
    assert found.best.values[key] == low
    said = "lower end of its range; a better design may lie beyond"
    assert any(said in row.remark for row in best_rows(found)) == is_said


def test_closest_design_at_its_bound_is_said_to_be_there(command):
    write_study(vary=WIDE, within="[x_r_peak < 1 mm]")
    done = command("design", "study.yaml", "--no-plots")
    assert done.code == 1
    assert "at its upper bound" in done.out
    fields = fields_of("out/study-design")
    assert fields["design"]["at_bounds"] == {"oscillator.damping": "upper"}
    has_best = Path("out/study-design/best.yaml").is_file()
    following = "next: drysim run out/study-design/best.yaml\n"
    assert done.err.endswith(following) is has_best


@pytest.mark.parametrize(
    ("frequencies", "has_knee"), [("[1.6, 5], take: mean", True), ("[3]", False)]
)
def test_ends_and_knee_of_a_front_are_listed(command, frequencies, has_knee):
    over = f"{{excitation.frequency: {frequencies}}}"
    write_study(minimise="[T_a, x_r_peak]", evaluations=60, over=over)
    done = command("design", "study.yaml", "--no-plots")
    assert done.code == 0, done.err
    rows = [line.split() for line in done.out.splitlines()]
    damping = [
        float(row[row.index("damping") + 1]) for row in rows if row[:1] in (["least"], ["knee"])
    ]
    assert damping == sorted(damping)
    assert len(damping) == 2 + has_knee
    over = "excitation.frequency=1.6,5" if has_knee else "'excitation.frequency=[3]'"
    following = f"sweep out/study-design/best.yaml --over {over}"
    assert done.err.endswith(f"next: drysim {following}\n")
    assert command(*shlex.split(following), "--no-plots", "--out", "out/each").code == 0
    assert ("end of the front, which has no knee" in done.out) is not has_knee
    assert ("knee of the front" in done.out) is has_knee


def stars(figure) -> list[tuple[str, str, tuple[float, float]]]:
    """Return label, face colour and place of the marked designs of a figure."""
    return [
        (line.get_label(), line.get_markerfacecolor(), (*line.get_xdata(), *line.get_ydata()))
        for axes in figure.axes
        for line in axes.lines
        if line.get_marker() == "*"
    ]


def test_picture_over_one_key_marks_the_limit_and_the_best_design():
    result = design_of(THREE_HZ, within="[x_r_peak < 4.2 mm]")
    figure = result.plot()
    ((label, _, place),) = stars(figure)
    assert (label, place) == ("best", (result.best.values[KEY], result.best.objectives[0]))
    assert figure.axes[0].get_ylabel() == "Tₐ [–]"
    (boundary,) = (line for line in figure.axes[0].lines if line.get_color() == "black")
    assert boundary.get_xdata()[0] == pytest.approx(result.best.values[KEY], rel=0.02)


@pytest.mark.parametrize("keys", [1, 2])
@pytest.mark.parametrize("minimise", ["T_a", "[T_a, x_r_peak]"])
def test_picture_without_an_admissible_design_marks_the_closest(keys, minimise):
    vary = ", ".join((WIDE, STIFFNESS)[:keys])
    result = design_of(SINE, vary, minimise, evaluations=24, within="[x_r_peak < 1 mm]")
    figure = result.plot()
    assert {star[:2] for star in stars(figure)} == {("closest", "white")}
    assert "closest" in legend(figure)
    assert "exceeds a limit" not in legend(figure) or keys == 1
    heading = " ".join(text.get_text() for text in figure.texts)
    assert "no design keeps all limits; the closest: " in heading
    assert "at the bounds of damping" in heading


def test_map_has_a_line_around_its_inadmissible_region():
    result = design_of(THREE_HZ, f"{DAMPING}, {STIFFNESS}", within="[x_r_peak < 4.2 mm]")
    figure = result.plot()
    panel = figure.axes[0]
    (boundary,) = (one for one in panel.collections if list(one.get_linewidths()) == [1.4])
    assert boundary.get_paths()[0].vertices.size
    pixels = [panel.transData.transform(text.get_position()) for text in panel.texts]
    assert len({tuple(place) for place in pixels}) == len(pixels)
    assert "exceeds a limit" in legend(figure)


def test_star_of_the_best_design_lies_above_all_other_marks():
    from drysim.plots import design

    others = [style for name, style in vars(design).items() if name.endswith("_STYLE")]
    highest = max(style.get("zorder", 2) for style in others if style is not design.BEST_STYLE)
    assert design.BEST_STYLE["zorder"] > highest


def test_picture_of_a_front_marks_its_ends():
    over = "{excitation.frequency: [1.6, 5], take: mean}"
    result = design_of(minimise="[T_a, x_r_peak]", evaluations=40, over=over)
    figure = result.plot()
    assert {star[0] for star in stars(figure)} == {"knee"}
    (ends,) = (one for one in figure.axes[0].lines if one.get_label() == "ends of the front")
    T_a = [one.objectives[0] for one in (result.front[0], result.front[-1])]
    assert ends.get_xdata().tolist() == T_a


def test_study_interrupted_in_its_first_round_names_resume(monkeypatch, command):
    write_study()
    with monkeypatch.context() as patched:
        patched.setattr("drysim.cli.process.raise_if_interrupted", interrupt)
        done = command("design", "study.yaml", "--no-plots")
    assert done.code == 130
    assert "the same command with --resume continues from here" in done.err
    done = command("design", "study.yaml", "--no-plots", "--resume")
    assert done.code == 0, done.err
    assert "starting over" not in done.err


def interrupt() -> None:
    raise KeyboardInterrupt


def test_records_of_the_conditions_are_validated(command):
    write_floor(Path("good.csv"), 1, 10.0)
    record = "{kind: record, file: good.csv, time: t, column: u}"
    scene = f"oscillator: {{mass: 75, stiffness: 3500, damping: 250}}\nexcitation: {record}\n"
    files = "{excitation.file: [good.csv, missing.csv]}"
    write_study(scene, WIDE, over=files)
    for name in ("design", "validate"):
        done = command(name, "study.yaml")
        assert done.code == 2
        assert "missing.csv: the record does not exist" in done.err + done.out


def test_warnings_about_the_conditions_are_found_by_validating(tmp_path, command):
    for seed in (1, 2):
        write_floor(tmp_path / f"floor-{seed}.csv", seed, 10.0)
    over = "excitation.file: floor-?.csv, oscillator.mass: [60, 75000]"
    write_study(RECORD, DAMPING, "a_x", over=f"{{{over}}}")
    done = command("validate", "study.yaml")
    assert done.code == 0, done.err
    assert done.out.count("note: base: ") == 1
    assert "note: base: record from 2 files, 9.99 s, " in done.out
    for words in (
        "the natural frequency is 0.0503 Hz",
        "warning: floor-2.csv: linear interpol",
    ):
        assert done.out.count(words) == 1, words
    assert command("validate", "study.yaml", "--strict").code == 1


def test_key_without_a_value_in_the_file_can_be_varied():
    scene = SINE + "friction: {kinetic: 20}\nstroke: {limit: 20 mm}\n"
    result = design_of(scene, "stroke.offset: {from: -5 mm, to: 5 mm}", evaluations=6)
    names = [variant.name for variant in result.variants]
    assert "as given" not in names
    assert "stiffness +10 %" in names
