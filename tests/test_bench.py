"""Bench: what is timed is judged rightly, and a fault of one entry is its own."""

from __future__ import annotations

import json
from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest
from outcomes import stand_in
from peers import heyoka
from seat import fields_of, rows_of

from drysim.approach import APPROACHES_BY_NAME
from drysim.bench import hard_cases, scipy_ivp, score, timing
from drysim.bench.score import Bench, BenchCase, Reference, Score
from drysim.bench.speed_error import score_answer, score_exact, with_uncertainty
from drysim.bench.timing import BenchOptions, time_limit, try_entry, try_within
from drysim.bench.work import Answer, Entry, make_work
from drysim.errors import SolverError

SLIDING = """\
drysim: 1
name: sliding
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
excitation: {kind: harmonic, frequency: 2, rms: 0.75}
solver: {step: 2.5e-3}
"""
NOISE = SLIDING.replace(
    "harmonic, frequency: 2, rms: 0.75",
    "psd, points: [[0.5, 1], [10, 1]], rms: 0.67, duration: 5 s, seed: 5",
)
RECORD = SLIDING.replace(
    "harmonic, frequency: 2, rms: 0.75", "record, file: white.csv, rate: 100, unit: m/s2"
).replace("solver: {step: 2.5e-3}\n", "")
SINES = (
    SLIDING.replace(
        "harmonic, frequency: 2, rms: 0.75",
        "sines, components: [{frequency: 2, amplitude: 1, phase: 0.3}, "
        "{frequency: 3.7, amplitude: 0.5}]",
    )
    + "measure: {duration: 40 s}\n"
)
HELD = SLIDING.replace("frequency: 2, rms: 0.75", "frequency: 5, rms: 0.33")
SMALL = ("--samples", 200, "--repeats", 1, "--patience", 0.01)
OWN = ("stick-slip", "switch", "moreau", "signum", "smooth", "viscous")
TERMS = BenchOptions(samples=400, repeats=1, patience=1.0, peers=())


@pytest.fixture
def works(scenario):
    """Return the work of a scenario given as text."""
    return lambda text, samples=400, **keys: make_work(scenario(text, **keys), samples)


@pytest.fixture
def bench(drysim, tmp_path):
    """Return the answer of a short bench without other programs, of a scenario as text."""

    def answer(text, *options):
        (tmp_path / "sliding.yaml").write_text(text)
        few = () if "--hard" in options else (*SMALL, "--no-peers", "--no-plots")
        return drysim("bench", "sliding.yaml", *few, *options)

    return answer


def score_of(work, name, setting="", terms=TERMS):
    """Return the score of the first entry of this approach and setting."""
    found = [
        one for one in score.entries(work) if (one.approach, one.setting) == (name, setting)
    ]
    return score_answer(found[0], try_entry(found[0], work, terms), Reference.of(work))


def by_reference(work):
    return scipy_ivp.reference_entry().ready(work)()


def by_heyoka(work):
    pytest.importorskip("heyoka")
    return heyoka.with_events(1e-15)(work)()


@pytest.mark.parametrize("text", [SLIDING, NOISE.replace("45}", "45, static: 54}")])
def test_exact_approach_and_restarted_scipy_agree_to_rounding(works, text):
    work = works(text)
    off, T_a = Reference.of(work).errors(work, by_reference(work))
    assert off < 1e-11
    assert abs(T_a) < 1e-12


@pytest.mark.parametrize("solved", [by_reference, by_heyoka])
def test_peers_with_events_see_two_stops_within_one_sample(works, tmp_path, solved):
    white = 3.0 * np.random.default_rng(21).standard_normal(401)
    np.savetxt(tmp_path / "white.csv", white, header="u_dd", comments="")
    work = works(RECORD)
    off, T_a = Reference.of(work).errors(work, solved(work))
    assert off < 1e-11
    assert abs(T_a) < 1e-12


@pytest.mark.parametrize("solved", [by_reference, by_heyoka])
@pytest.mark.parametrize("step", [0.02, 0.03, 0.04])
def test_peers_with_events_see_friction_overcome_between_points_of_the_grid(
    works, solved, step
):
    work = works(SINES.replace("45}", "80, static: 96}"), 1000, solver__step=step)
    off, T_a = Reference.of(work).errors(work, solved(work))
    assert off < 1e-10
    assert abs(T_a) < 1e-11


def test_reference_whose_two_runs_differ_is_in_doubt_and_not_the_exact_approach(
    bench, monkeypatch
):
    monkeypatch.setattr(scipy_ivp, "REFERENCE_SETTING", ("RK45", 1e-3))
    answer = bench(SLIDING, "--json")
    assert answer.code == 0
    told = json.loads(answer.out)
    assert "reference-in-doubt" in [warning["slug"] for warning in told["warnings"]]
    first, *_, last = told["cases"][0]["scores"]
    assert first["verdict"].startswith("in doubt, two runs of the reference differ by")
    assert first["error_x_r"] is None
    assert last["verdict"] == first["verdict"]
    assert last["uncertainty"] > 0.1 * last["error_x_r"] > 1e-4
    assert "warning: the reference, solve_ivp events RK45, 0.001, is in doubt" in answer.err
    told = "reference   none: solve_ivp events RK45, 0.001 is not reliable itself"
    assert told in bench(SLIDING).out


def test_exact_approach_is_charged_with_what_both_runs_of_the_reference_agree_on(works):
    work = works(SLIDING)
    reference = Reference.of(work)
    wrong = replace(reference, x_r=1.001 * reference.x_r, stops=reference.stops[1:])
    entry = scipy_ivp.reference_entry()
    one = try_entry(entry, work, TERMS)
    score = with_uncertainty(score_answer(entry, one, wrong), one, wrong)
    count = len(reference.stops)
    assert not score.in_doubt
    assert score.verdict == f"fine; {count} stops, {count - 1} by stick-slip"
    assert score_exact(score, score).verdict == "fine"


def test_slip_begins_where_friction_is_overcome_and_not_just_before(works):
    work = works(SLIDING)
    still = scipy_ivp.SlipState(0.0, 0.0, 0.0, 0)
    for limit in np.linspace(1.0, 75.0, 200):
        part = replace(work, law=work.law._replace(F_fs=float(limit)))
        t = scipy_ivp.break_away_time(part, still, 0.0, 0.125)
        assert 0.0 < scipy_ivp.limit_force(part, still._replace(t=t)) - limit < 1e-11


@pytest.mark.parametrize(
    ("name", "setting", "verdict", "error", "tolerance"),
    [("signum", "semi-implicit", "chatters, T_a +8", 0.84, 0.02),
     ("smooth", "tanh, c 100", "creeps", -0.093, 0.01)],
)  # fmt: skip
def test_fixed_steps_are_wrong_where_the_mass_should_stick(
    works, name, setting, verdict, error, tolerance
):
    score = score_of(works(HELD), name, setting)
    assert score.verdict.startswith(verdict)
    assert score.error_T_a == pytest.approx(error, abs=tolerance)


def test_an_approach_that_leaves_the_static_limit_out_solves_another_law(works):
    work = works(NOISE.replace("45}", "45, static: 60}"))
    assert score_of(work, "moreau").verdict.startswith("another law")
    assert score_of(work, "viscous").verdict.startswith("another law")
    assert score_of(work, "switch").verdict.split(",")[0] in ("fine", "coarse")


def test_mass_that_never_moves_has_an_error_relative_to_how_far_it_would(works):
    assert Reference.of(works(HELD)).scale > 1e-5


def raising(work):
    raise ZeroDivisionError("no such luck")


def without_numbers(work):
    nothing = np.full(work.samples + 1, np.nan)
    return lambda: Answer(nothing, nothing, lambda: nothing)


@pytest.mark.parametrize(
    ("ready", "reason"),
    [(raising, "ZeroDivisionError: no such luck"),
     (without_numbers, "the result has missing or non-finite values")],
)  # fmt: skip
def test_entry_without_an_answer_has_failed_and_says_how(works, ready, reason):
    work, entry = works(SLIDING), Entry("broken", "", ready)
    score = score_answer(entry, try_entry(entry, work, TERMS), Reference.of(work))
    assert score.verdict.startswith(f"failed, {reason}")
    assert score.time is None


def test_slow_entry_runs_on_a_shorter_stretch(works):
    work = works(SLIDING, samples=4000)
    runner = try_entry(scipy_ivp.reference_entry(), work, BenchOptions(4000, 1, 0.01, ()))
    assert 200 <= runner.work.samples < 4000
    assert len(runner.answer.x_r) == runner.work.samples + 1


def test_peer_whose_stops_follow_each_other_without_end_is_stopped(works):
    def slide(begin, d, x_out, v_out):
        return begin._replace(v_r=0.0), True

    work = works(SLIDING, 400, start__v_r=1.0, friction__kinetic=1e-9)
    with pytest.raises(SolverError, match="events accumulate"):
        scipy_ivp.integrate_stick_slip(work, slide)


def test_work_that_lasts_too_long_is_given_up():
    def forever():
        while True:
            pass

    with pytest.raises(SolverError, match=r"time limit of 0\.05 s exceeded"), time_limit(0.05):
        forever()


def test_compiling_is_no_part_of_the_work_and_is_not_interrupted(monkeypatch):
    monkeypatch.setattr(timing, "is_compiling", lambda: perf_counter() < begin + 0.15)
    begin = perf_counter()

    def work():
        while perf_counter() < begin + 5.0:
            pass

    with pytest.raises(SolverError), time_limit(0.1):
        work()
    assert 0.15 < perf_counter() - begin < 4.0


def test_slow_jobs_are_repeated_less_and_all_take_turns():
    turns = []
    jobs = [lambda: turns.append("a"), lambda: turns.append("b")]
    timing.interleaved_medians(jobs, [3, 2])
    assert turns == ["a", "b", "a", "b", "a"]
    assert [timing.repeat_count(once, 15, 0.1) for once in (1e-6, 0.02, 1.0)] == [15, 5, 3]


@pytest.mark.parametrize(
    ("errors", "word"),
    [((1e-12, -1e-13), "exact"), ((1e-6, 0.0), "close"), ((0.0, -5e-3), "fine"),
     ((0.05, 0.01), "coarse, x_r 5 %"), ((0.05, 0.24), "wrong, T_a +24 %"),
     ((0.2, None), "wrong, x_r 20 %")],
)  # fmt: skip
def test_verdict_names_the_greater_error(errors, word):
    assert score.verdict(errors, (False, False), False) == word


def test_bench_writes_a_row_for_every_entry(drysim, tmp_path):
    (tmp_path / "sliding.yaml").write_text(SLIDING)
    answer = drysim("bench", "sliding.yaml", *SMALL, "--no-peers")
    assert answer.code == 0
    folder = tmp_path / "out" / "sliding-bench"
    rows = rows_of(folder / "speed_error.csv")
    first = ["approach", "setting", "step [s]", "time_per_sample [ns]"]
    then = ["error_x_r [-]", "error_T_a [-]", "energy_residual [-]", "verdict"]
    assert list(rows[0])[:8] == [*first, *then]
    assert {row["approach"] for row in rows} == {*APPROACHES_BY_NAME, "solve_ivp events"}
    assert rows[0]["verdict"] == "exact"
    assert not [row for row in rows if row["verdict"].startswith("failed")]
    assert {file.name for file in folder.iterdir()} == {
        "scenario.yaml", "drysim.json", "speed_error.csv", "speed_error.png"
    }  # fmt: skip


def test_bench_of_nothing_named_takes_two_scenes_of_the_gallery(drysim):
    told = json.loads(drysim("bench", "--dry-run", "--json").out)
    assert [case["name"] for case in told["cases"]] == ["paper-high-friction", "paper-random"]
    assert [case["samples"] for case in told["cases"]] == [24000, 24000]
    assert told["folder"] == "out/bench"
    told = json.loads(drysim("bench", "--hard", "--dry-run", "--json").out)
    assert len(told["cases"]) > 20
    assert told["folder"] == "out/hard"


def test_json_holds_every_score_and_what_the_exact_approach_came_to(bench):
    told = json.loads(bench(NOISE, "--json").out)
    assert told["metrics"]["sliding"]["error_x_r"] < 1e-11
    assert told["cases"][0]["scores"][0]["approach"] == "stick-slip"
    assert told["cases"][0]["excitation"]["seed"] == 5
    assert "speed_error.csv" in told["files"]


def test_failure_of_one_approach_is_a_row_and_exit_code_0(bench, monkeypatch):
    def entries(work):
        yield next(iter(shelf_entries(work)))
        yield Entry("hapless", "", lambda work: 1 / 0)

    shelf_entries = score.entries
    monkeypatch.setattr(score, "entries", entries)
    answer = bench(SLIDING)
    assert answer.code == 0
    assert "hapless: ZeroDivisionError" in answer.out


def test_bench_of_many_seeds_is_that_of_the_first(bench):
    answer = bench(NOISE.replace("seed: 5", "seeds: 5"), "--json")
    assert [each["slug"] for each in json.loads(answer.out)["warnings"]] == ["one-seed"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (SLIDING.replace("45}", "45, normal_variation: {amplitude: 0.3, frequency: 1.7}}"),
         ["no other program supports a varying normal force: only drysim's"]),
        (f"{SLIDING}stroke: {{limit: 3 mm, stops: {{stiffness: 1e5}}}}\n",
         ["end stops   at ±3 mm, 100000 N/m, 0 N·s/m",
          "no other program supports end stops: only drysim's approaches run"]),
    ],
    ids=["varying normal force", "end stops"],
)  # fmt: skip
def test_scene_that_no_peer_knows_is_said_to_be_one(drysim, tmp_path, text, told):
    (tmp_path / "sliding.yaml").write_text(text)
    answer = drysim("bench", "sliding.yaml", *SMALL, "--no-plots")
    assert answer.code == 0
    assert all(sentence in answer.out + answer.err for sentence in told)
    warnings = fields_of(tmp_path / "out/sliding-bench")["warnings"]
    assert "no-peers" in [warning["slug"] for warning in warnings]
    table = (tmp_path / "out/sliding-bench/speed_error.csv").read_text()
    assert "exact by its energy balance" in table


def test_law_solved_by_series_is_held_to_the_error_that_it_states(bench):
    law = "lugre, bristle_stiffness: 1e5, bristle_damping: 300, stribeck_velocity: 0.01"
    answer = bench(SLIDING.replace("coulomb", law), "--json")
    first = json.loads(answer.out)["cases"][0]["scores"][0]
    assert first["verdict"] == "exact, by its own error estimate"
    assert 0 < first["error_x_r"] < 1e-9


@pytest.mark.parametrize(
    "words",
    [("nowhere.yaml",), ("--set", "friction.kinetik=3"), ("--samples", "0"),
     ("--repeats", "none"), ("--steady", "--hard", "--dry-run")],
)  # fmt: skip
def test_bad_words_compute_nothing(refused, words):
    assert refused("bench", *words).startswith("error: ")


def test_legend_of_a_crowded_picture_tells_all_entries_apart_below_the_panels():
    from drysim.plots.speed_error import draw
    from drysim.plots.style import legend_entries

    own = [Score(name, "", True, 1e-3, 9, time=5.0, error_x_r=0.1) for name in OWN]
    peers = [Score(f"p{at}", "", False, 1e-3, 9, time=9.0, error_x_r=0.2) for at in range(8)]
    case = BenchCase(stand_in("harmonic"), None, (), (*own, *peers), 7.0, None, ())
    figure = draw(Bench((case,), "plain"))
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert sorted(told) == sorted([*OWN, *(one.approach for one in peers), "lfilter of scipy"])
    styles = {
        (line.get_color(), line.get_marker(), line.get_linestyle())
        for line in legend_entries(figure.axes).values()
    }
    assert len(styles) == len(told)
    figure.draw_without_rendering()
    box, panels = legend.get_window_extent(), [one.get_tightbbox() for one in figure.axes]
    assert all(box.y1 < panel.y0 for panel in panels)
    assert (box.x0 > 0.0, box.x1 < figure.bbox.x1) == (True, True)


def test_steady_states_are_the_same_orbits_by_search_and_by_marching(drysim, tmp_path):
    words = SLIDING + "sweep: {excitation.frequency: [2, 4]}\n"
    (tmp_path / "sliding.yaml").write_text(words)
    few = ("--repeats", 1, "--patience", 0.5, "--no-peers", "--no-plots", "--json")
    told = json.loads(drysim("bench", "--steady", "sliding.yaml", *few).out)
    scores = told["cases"][0]["scores"]
    assert scores[0]["setting"] == "periodic orbits"
    assert scores[0]["error_x_r"] < 1e-11
    assert scores[0]["samples"] == 2 * 100 * 256
    assert {one["approach"] for one in scores} == {*APPROACHES_BY_NAME, "solve_ivp events"}


def test_steady_states_are_those_of_a_sweep_and_swept_friction_is_told_as_such(
    drysim, refused, tmp_path
):
    (tmp_path / "sliding.yaml").write_text(SLIDING)
    few = ("--repeats", 1, "--patience", 0.01, "--no-peers", "--no-plots")
    words = ("bench", "--steady", "sliding.yaml", *few)
    assert "sliding has no sweep of steady states" in refused(*words)
    swept = SLIDING + "sweep: {friction.kinetic: [30, 40]}\n"
    (tmp_path / "sliding.yaml").write_text(swept)
    told = " ".join(drysim(*words).out.split())
    assert "friction F_fs = F_fk (not given) base harmonic 2 Hz, 0.75 m/s² RMS swept" in told


# The hard cases: the exact approach is held to their checks, the others to it.


@pytest.fixture
def ordeal(scenario):
    """Return the hard-case results of a scenario given as text, by approach."""

    def results(text, **keys):
        case = hard_cases.run_case(scenario(text, **keys), 30.0, lambda: None)
        return {result.approach: result for result in case.results}

    return results


def test_exact_approach_holds_and_others_are_wrong_where_the_mass_should_stick(bench, tmp_path):
    answer = bench(HELD + "checks: [T_a == 1, x_r_peak == 0]\n", "--hard")
    assert answer.code == 0
    table = rows_of(tmp_path / "out/sliding-hard/hard_cases.csv")
    rows = {row["approach"]: row for row in table}
    assert {name: row["verdict"] for name, row in rows.items()} == {
        "stick-slip": "held", "switch": "held", "moreau": "held", "signum": "wrong",
        "smooth": "wrong", "viscous": "wrong",
    }  # fmt: skip
    assert rows["signum"]["how"] == "T_a +84 %"
    assert float(rows["signum"]["T_a_deviation [-]"]) == pytest.approx(0.84, abs=0.01)


def test_exact_approach_that_breaks_a_check_makes_the_exit_code_1(bench):
    answer = bench(HELD + "checks: [T_a == 1, x_r_peak > 1 mm]\n", "--hard", "--json")
    assert answer.code == 1
    first = json.loads(answer.out)["cases"][0]["trials"][0]
    assert (first["word"], first["how"]) == ("wrong", "1 of 2 checks fail")


def test_without_checks_the_exact_approach_holds_nothing(bench, tmp_path):
    answer = bench(HELD, "--hard")
    assert answer.code == 0
    assert "no checks   sliding: stick-slip cannot be verified" in answer.out
    table = rows_of(tmp_path / "out/sliding-hard/hard_cases.csv")
    verdicts = {row["approach"]: row["verdict"] for row in table}
    assert verdicts["stick-slip"] == "no checks"
    assert verdicts["signum"] == "wrong"


def test_approach_that_asks_for_too_much_has_failed_and_says_why(ordeal):
    words = SLIDING + "measure: {steady: false, settle: 0, duration: 10 s}\n"
    results = ordeal(words, solver__smooth__sharpness=1e12)
    assert results["smooth"].verdict == "failed"
    assert "GB of memory" in results["smooth"].reason
    assert results["moreau"].verdict == "held"


def test_time_limit_within_any_kernel_ends_in_its_message(scenario):
    """A signal that comes during a kernel raises when Python runs again, not while it boxes."""
    held = scenario(HELD)
    hard_cases.solve_case(held, "moreau")

    def endless():
        while True:
            hard_cases.solve_case(held, "moreau")

    for seconds in np.random.default_rng(3).uniform(1e-5, 5e-3, 300).tolist():
        assert try_within(endless, seconds).startswith("time limit of")


def test_every_point_of_a_swept_hard_case_counts(ordeal):
    words = HELD + "sweep: {excitation.rms: [0.33, 0.5]}\nchecks: [T_a > 0.9]\n"
    exact = ordeal(words)["stick-slip"]
    assert (exact.verdict, exact.checks, exact.passed) == ("held", 2, 2)


@pytest.mark.parametrize(
    ("metric", "off", "words"),
    [("T_a", 0.84, "T_a +84 %"), ("x_r_peak", -1.0, "peak -100 %"),
     ("x_r_rms", 51.0, "x_r ×52"), ("x_r_rms", 1e9, "blows up")],
)  # fmt: skip
def test_deviation_is_spoken(metric, off, words):
    assert hard_cases.describe_deviation(metric, off) == words


@pytest.mark.slow
def test_exact_approach_holds_every_hard_case(process):
    answer = process("bench", "--hard", "--json", "--patience", 120)
    assert answer.code == 0
    counts = json.loads(answer.out)["metrics"]
    assert set(counts["stick-slip"]) == {"held"}
    assert counts["signum"]["wrong"] > 5
