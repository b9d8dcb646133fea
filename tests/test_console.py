"""The terminal: what stands on stdout and stderr, and that no user's text drives it."""

from __future__ import annotations

import contextlib
import io
import json
import re
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from grids import axes, comparison, orbits, spoil, sweep
from hang import no_hang
from outcomes import judgement, outcome, record, stand_in
from seat import SEAT
from shown import show

import drysim as package
from drysim import wording
from drysim.cli import COMPILING_MESSAGE, announce_compilation
from drysim.console import problems
from drysim.console import terminal as console_terminal
from drysim.console.summary import print_rows, show_interrupted, show_warnings
from drysim.console.terminal import stdout
from drysim.core.model import CoulombLaw
from drysim.errors import OutputError, Problem, RecordError, ScenarioError, WarningMessage
from drysim.metrics.checks import Check
from drysim.results import sweep as sweep_kind
from drysim.scenario.load import load
from drysim.study import table as tally_table
from drysim.study.statistics import FAILED, NOT_SETTLED
from drysim.study.summary import Row
from drysim.study.sweep import sweep as solved

TYPO = Problem(
    "unknown key `stifness` in oscillator; did you mean `stiffness`?",
    "seat.yaml", 3, 3, 8, "  stifness: 7500", "oscillator.stifness",
)  # fmt: skip
NEGATIVE = Problem(
    "friction.kinetic must be at least 0 N, not -15",
    "seat.yaml", 5, 12, 3, "  kinetic: -15", "friction.kinetic",
)  # fmt: skip
STANDSTILL = Problem("the mass will not move", "still.yaml", severity="warning")

SHOWN = """\
error: seat.yaml: 2 errors

seat.yaml:3:3: unknown key `stifness` in oscillator; did you mean `stiffness`?
  3 │   stifness: 7500
    │   ^^^^^^^^
seat.yaml:5:12: friction.kinetic must be at least 0 N, not -15
  5 │   kinetic: -15
    │            ^^^
"""


pytestmark = pytest.mark.usefixtures("eighty_columns")


@pytest.fixture
def told(capsys):
    """Return what is shown of a result on stdout, with every run of blanks as one."""

    def words(result, folder=None):
        show(result, folder)
        return " ".join(capsys.readouterr().out.split())

    return words


@pytest.fixture
def colour(monkeypatch):
    """Force colours."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)


# summary


def test_summaries_fit_80_columns_and_are_plain_when_piped(capsys):
    made = outcome(
        CoulombLaw(15.0, 15.0), record(2_000), None, limit=0.001,
        checks=["x_r_peak < 25 mm", "T_a < 0.1", "T_x < 1"],
    )  # fmt: skip
    table = judged(spoil(small(limit=0.015), FAILED, 1, note="a " * 60), "T_a < 1 at x.y >= 8")
    for result in (made, table):
        show(result, Path("out/seat"))
        out, err = capsys.readouterr()
        assert max(map(len, out.splitlines())) <= 80
        assert {sign for sign in out if not sign.isprintable()} == {"\n"}
        assert err == ""


def test_summary_says_what_matters_in_words_and_millimetres(told):
    checks = ["x_r_peak < 25 mm", "T_x < 0.1"]
    made = outcome(CoulombLaw(15.0, 15.0), limit=0.005, checks=checks)
    out = told(made, Path("out/seat"))
    peak = made.metrics["x_r_peak"] * 1e3
    for words in (
        "m 75 kg, k_x 7500 N/m, b 500 N·s/m, f_0 1.592 Hz, ξ 0.333",
        "F_fk 15 N, F_fs 15 N (not given: F_fs = F_fk)",
        "harmonic 1.6 Hz, 1.061 m/s² RMS",
        made.response.numerics.why,
        f"peak |x_r| {peak:.4g} mm",
        "of the stroke limit of 5 mm",
        "limit exceeded 3 times",
        f"✓ holds x_r_peak < 25 mm, with {peak:.6g} mm",
        "✗ fails T_x < 0.1, with ",
        "written out/seat",
    ):
        assert words in out


@pytest.mark.parametrize(
    ("check", "scale", "unit"),
    [("x_r_peak < 5 cm", 1e2, " cm"), ("x_r_peak < 5", 1.0, " m"),
     ("a_u > 0.05 g", 1 / 9.80665, " g"), ("a_u < 50 m/s2", 1.0, " m/s²"),
     ("stuck_share < 90 %", 1e2, " %"), ("T_a < 9", 1.0, "")],
)  # fmt: skip
def test_value_is_told_in_the_unit_of_its_check(capsys, check, scale, unit):
    made = outcome(CoulombLaw(15.0, 15.0), checks=[check])
    show(made, None)
    value = wording.format_number(made.metrics[check.split()[0]] * scale, digits=6)
    assert f"✓ holds     {check}, with {value}{unit}\n" in capsys.readouterr().out


LENGTH = re.compile(r"(?<=[\d.] )(?:µm|mm|m)\b(?!/)")


def in_all_outputs(words, folder):
    """Return the units of length in the summary, the warnings and the picture of a case."""
    made = package.run(load(folder / "seat.yaml", words))
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        show(made)
    figure = made.plot()
    figure.draw_without_rendering()
    texts = [one.sentence for one in made.warnings if one.slug == "stroke-violated"]
    assert texts
    texts += [text.get_text() for text in figure.texts]
    texts += [text.get_text() for one in figure.legends for text in one.get_texts()]
    texts += [f"1 {axes.get_title('left')[-3:-1].strip(' [')}" for axes in figure.axes]
    return {*LENGTH.findall("\n".join([out.getvalue(), *texts]))}


@pytest.mark.parametrize(
    ("words", "unit"),
    [
        ({"excitation.rms": 800, "stroke.limit": 0.025}, "m"),
        ({"excitation.rms": 800, "stroke.limit": 9.0}, "m"),
        ({"excitation.rms": 1.0, "stroke.limit": 0.002}, "mm"),
        ({"excitation.rms": 1e-4, "friction": None, "stroke.limit": 1e-7}, "µm"),
        ({"excitation.rms": 800, "stroke": {"limit": 9.9, "stops": {"stiffness": 1e4}}}, "m"),
    ],
)
def test_lengths_of_a_run_have_one_unit_wherever_they_are_told(seat, words, unit):
    assert in_all_outputs({"name": "seat", **words}, seat.parent) == {unit}


def test_metric_that_is_not_known_is_said_to_be_so(capsys):
    show(outcome(motion=record(700), duration=None, checks=["T_x < 1"]))
    out = capsys.readouterr().out
    assert "T_x         not known" in out
    assert "T_x < 1, with not known" not in out
    assert "✗ fails     T_x < 1; T_x is not known here" in out


def test_steady_orbit_shows_how_well_it_closes(capsys):
    made = outcome()
    numerics = replace(made.response.numerics, closure=1.23e-13, period_multiple=2)
    show(replace(made, response=replace(made.response, numerics=numerics)))
    assert re.search(r"\(2 periods, [.\d]+ s\), closure\s+1.2e-13", capsys.readouterr().out)


def test_warnings_go_to_stderr_one_a_line_when_piped(capsys):
    long = "the stroke limit is met " + "again and " * 20 + "again"
    table = replace(small(), warnings=(WarningMessage("slug", long),))
    for result in (outcome(warnings=[long]), table):
        show(result)
        out, err = capsys.readouterr()
        assert "again" not in out
        assert err == f"warning: {long}\n"


def test_no_user_text_drives_the_terminal_nor_the_markup(capsys, colour):
    evil = "[bold red]\x1b[2J\x1b]0;owned\x07\x9b31m\u202e:smile:\r\n[/]"
    scene = stand_in("harmonic", name=evil, about=evil, sweep=small().axes, reference=None)
    table = spoil(replace(small(), scenario=scene), FAILED, 1, note=evil)
    compared = orbits(["signum", "stick-slip"])
    for result in (
        outcome(name=evil, about=evil, warnings=[evil]),
        table,
        replace(table, complete=False),
        replace(compared, table=replace(compared.table, scenario=scene)),
        replace(compared, verdict=(evil,)),
    ):
        show(result, Path(f"out/{evil}"))
    problem = Problem(evil, evil, 1, 3, 4, evil)
    problems.show_error(ScenarioError(evil, (problem,), evil))
    problems.show_problems({evil: (problem,)})
    problems.show_problems({evil: (problem,)}, "github")
    shown = "".join(capsys.readouterr())
    assert "[bold red]" in shown
    assert ":smile:" in shown
    left = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert {sign for sign in left if not sign.isprintable()} == {"\n"}


def test_colour_is_there_when_forced_and_gone_when_refused(capsys, colour, monkeypatch):
    made = outcome(checks=["T_a < 0.01"])
    show(made)
    assert "\x1b[1;31m" in capsys.readouterr().out
    monkeypatch.setenv("NO_COLOR", "1")
    show(made)
    assert not re.search(r"\x1b\[[0-9;]*3[0-7]", capsys.readouterr().out)


def test_stream_that_knows_no_greek_gets_question_marks(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    show(outcome(checks=["T_a < 9"]))
    stream.flush()
    assert b"? holds" in stream.buffer.getvalue()


# faults and problems


def test_problems_are_shown_as_the_contract_has_them(capsys):
    problems.show_problems({"seat.yaml": (TYPO, NEGATIVE)})
    assert capsys.readouterr() == (SHOWN, "")


@pytest.mark.parametrize(
    ("fault", "shown"),
    [
        (ScenarioError("seat.yaml: 2 errors", (TYPO, NEGATIVE), "mend it"),
         f"{SHOWN}\nmend it\n"),
        (RecordError(Problem("`abc` is not a number", "road.csv", 12, 3, 3, "1\tabc")),
         "error: road.csv: 1 error\n\nroad.csv:12:3: `abc` is not a number\n"
         "  12 │ 1 abc\n     │   ^^^\n"),
        (RecordError(Problem("no column", "road.csv", 1, named_at=Problem("-", "seat.yaml"))),
         "error: seat.yaml: 1 error\n\nroad.csv:1: no column\n"),
        (OutputError("out is a file, not a folder", "move it away"),
         "error: out is a file, not a folder\n\nmove it away\n"),
    ],
)  # fmt: skip
def test_fault_is_shown_once_on_stderr_at_its_place_if_any(capsys, fault, shown):
    problems.show_error(fault)
    assert capsys.readouterr() == ("", shown)


def test_every_file_gets_its_verdict(capsys):
    files = {"seat.yaml": (TYPO,), "ok.yaml": (), "still.yaml": (STANDSTILL,)}
    problems.show_problems(files)
    out = capsys.readouterr().out
    assert "error: seat.yaml: 1 error\n" in out
    assert "ok: ok.yaml\n" in out
    assert "ok: still.yaml: 1 warning\n" in out
    assert "still.yaml: warning: the mass will not move\n" in out
    problems.show_problems(files, strict=True)
    assert "fails: still.yaml: 1 warning under --strict\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("before", "after", "wide"),
    [("日本\t\x1b: ", "", 2), ("x: 1, " * 10_000, ": 7500" + ", y: 2" * 10_000, 0)],
)
def test_caret_stands_below_the_fault_behind_wide_signs_and_in_an_endless_line(
    capsys, before, after, wide
):
    problem = replace(TYPO, source=f"{before}stifness{after}", column=len(before) + 1)
    problems.show_problems({"seat.yaml": (problem,)})
    above, below = capsys.readouterr().out.splitlines()[-2:]
    assert below.index("^") == above.index("stifness") + wide
    assert below.count("^") == len("stifness")
    assert len(above) < 120


def test_problems_as_json_are_one_object(capsys):
    problems.show_problems({"seat.yaml": (TYPO,), "still.yaml": (STANDSTILL,)}, "json")
    told = json.loads(capsys.readouterr().out)
    seat, still = told["files"]
    assert (seat["file"], seat["sound"], still["sound"]) == ("seat.yaml", False, True)
    assert seat["problems"][0] == {
        "severity": "error", "file": "seat.yaml", "line": 3, "column": 3, "width": 8,
        "key": "oscillator.stifness", "sentence": TYPO.sentence, "source": TYPO.source,
        "remark": "",
    }  # fmt: skip
    assert still["problems"][0]["severity"] == "warning"


def test_problems_for_github_are_annotations(capsys):
    odd = replace(NEGATIVE, file="a,b:c.yaml", sentence="50 % too much\nat once")
    problems.show_problems({"seat.yaml": (TYPO, odd), "still.yaml": (STANDSTILL,)}, "github")
    assert capsys.readouterr().out.splitlines() == [
        f"::error file=seat.yaml,line=3,col=3::{TYPO.sentence}",
        "::error file=a%2Cb%3Ac.yaml,line=5,col=12::50 %25 too much%0Aat once",
        "::warning file=still.yaml::the mass will not move",
    ]
    problems.show_problems({"still.yaml": (STANDSTILL,)}, "github", strict=True)
    assert capsys.readouterr().out == "::error file=still.yaml::the mass will not move\n"


@pytest.mark.parametrize("step", [0.3, 0.7])
def test_window_is_that_of_the_metrics_on_a_grid_that_misses_its_end(seat, capsys, step):
    """A step of 0.3 s draws up to 1.8 s of the 2 s; the metrics are of all of them."""
    times = ["measure={settle: 1 s, duration: 1 s}", f"solver.step={step}"]
    made = package.run(package.load(seat, times))
    fine = package.run(package.load(seat, times[:1]))
    show(made)
    assert "window      1 s after settling for 1 s" in capsys.readouterr().out
    assert made.metrics["a_u"] == pytest.approx(fine.metrics["a_u"], rel=1e-9)


def test_repetition_is_counted_in_periods_of_the_base(seat, capsys):
    """5 Hz under a normal force of 9 Hz repeats after 1 s: `a period` was said of five."""
    words = ["measure=null", "excitation.frequency=5", "solver.step=1e-3"]
    varied = "friction.normal_variation={amplitude: 0.4, frequency: 9}"
    show(package.run(package.load(seat, [*words, varied])))
    assert "periodic orbit (5 periods, " in capsys.readouterr().out
    for step in (1e-3, 1.0):  # one longer than the period makes it no shorter
        words[-1] = f"solver.step={step}"
        show(package.run(package.load(seat, words)))
        assert "periodic orbit (1 period, " in capsys.readouterr().out


def test_comparison_tells_the_base_motion_as_a_run_does(seat, capsys):
    made = package.compare(package.load(seat), ("signum", "stick-slip"))
    show(made)
    assert "base        harmonic 1.6 Hz, 1 m/s² RMS" in capsys.readouterr().out


# The terminal after a sweep or a comparison, and while it lasts.


def judged(table, *texts):
    """Return the table with verdicts on its rows."""
    rows = [(row.point, row.metrics) for row in table.own]
    return replace(table, checks=tuple(judgement(Check.parse(text), rows) for text in texts))


def small(**options):
    return sweep(*axes(frequency=[1, 2, 4], rms=[0.5, 1.0]), **options)


RMS = [0.4, 0.5, 0.6, 0.7, 0.8, 1.0]


# sweeps


def test_extremes_that_differ_by_rounding_are_the_same(scenario, told):
    """Wherever a steady orbit begins, its metrics are the same but for rounding."""
    phases = {"sweep": {"excitation.phase": [0, 0.5, 1, 2, 3]}, "measure": {"steady": True}}
    table = solved(scenario(SEAT, phases))
    ends = next(iter(table.tallies.values())).extremes["T_a"]
    assert ends[0].row.point != ends[1].row.point
    out = told(table)
    for name in ("T_a", "T_x", "peak |x_r|"):
        assert re.search(
            rf"{re.escape(name)} [\d.]+( mm)? (.* limit, |x_r over u; )?the same in every case",
            out,
        )
    assert " minimum at " not in out
    assert "minimum at" in told(spoil(small(), FAILED, 1))


def test_sweep_says_what_was_swept_and_where_the_extremes_are(told):
    table = judged(small(), "x_r_peak < 25 mm", "T_a < 1.2", "T_a < 9 at no.key >= 1")
    out = told(table, Path("out/seat"))
    best = max(table.own, key=lambda row: row.metrics["T_a"])
    assert best.point["excitation.frequency"] == 1.0
    peak = max(row.metrics["x_r_peak"] for row in table.own) * 1e3
    for said in (
        "F_fk 15 N, F_fs 15 N (not given: F_fs = F_fk)",
        "swept excitation.frequency 1, 2, 4 Hz excitation.rms 0.5, 1 m/s²",
        "cases 6 by stick-slip, 6 by viscous",
        f"to {best.metrics['T_a']:.3g} minimum at frequency 4 Hz, rms 1 m/s², "
        "maximum at frequency 1 Hz, rms 1 m/s²",
        f"peak |x_r| {peak:.4g} mm 68.2 % of the stroke limit, at frequency 1 Hz, rms 1 m/s²",
        "isolation from 4 Hz T_a stays below 1",
        f"✓ holds x_r_peak < 25 mm, with {peak:.6g} mm at frequency 1 Hz, rms 1 m/s²",
        f"✗ fails T_a < 1.2, with {best.metrics['T_a']:.6g} at frequency 1 Hz, rms 1 m/s²",
        "✗ fails T_a < 9 at no.key >= 1; no case meets the condition",
        "written out/seat",
    ):
        assert said in out
    assert "not settled" not in out
    assert "exceeded" not in out


def test_base_motion_that_all_cases_share_is_told(capsys):
    table = replace(sweep(*axes(force=[0, 15]), kind="record"), motion=record(700))
    show(table)
    assert "base        record road.csv, 700 samples at 400 Hz" in capsys.readouterr().out


def test_stroke_violations_are_counted_with_how_much(told):
    table = small(limit=0.015)
    out = told(table)
    met = [row for row in table.own if row.metrics["violations"]]
    far = (max(row.metrics["x_r_peak"] for row in met) - 0.015) * 1e3
    assert f"limit in {len(met)} of 6 cases exceeded by up to {far:.4g} mm" in out


def test_limit_met_while_settling_is_not_said_to_be_met_by_the_peak(told):
    table = small(limit=0.1)
    settling = {"violations": 1, "stroke_suffices": 0.12, "stroke_used": 1.2}
    rows = tuple(replace(row, metrics={**row.metrics, **settling}) for row in table.rows)
    out = told(replace(table, rows=rows))
    assert "limit in 6 of 6 cases exceeded by up to 20 mm" in out
    assert "while settling" in out


def test_cases_without_numbers_are_counted_and_the_first_is_named(told):
    table = spoil(small(), NOT_SETTLED, 1, 2, note="after 600 s")
    out = told(spoil(table, FAILED, 4, note=""))
    assert "not settled 2 cases first at frequency 2 Hz, rms 0.5 m/s²: after 600 s" in out
    assert "failed 1 case first at frequency 2 Hz, rms 1 m/s²" in out


@pytest.mark.parametrize(
    ("force", "lost", "said"),
    [
        (0.0, (), "isolation from 4 Hz T_a stays below 1 peak"),
        (500.0, (), "isolation nowhere"),
        (27.0, (), "rms 0.5 m/s² from 2 Hz; rms 1 m/s² from 4 Hz"),
        (0.0, (2,), "rms 0.5 m/s² nowhere; rms 1 m/s² from 4 Hz"),
    ],
    ids=["everywhere alike", "stuck", "differs", "not known at the end"],
)
def test_isolation_is_told_for_every_curve(told, force, lost, said):
    table = spoil(small(force=force, reference=None), NOT_SETTLED, *lost)
    assert said in told(table)


def test_isolation_of_many_curves_is_told_from_where_all_isolate(told):
    """A sample said `from 2 to 4 Hz` where more than half of the cases exceed 1 at 2 Hz."""
    table = sweep(*axes(frequency=[1, 2, 4], rms=RMS), force=27.0, reference=None)
    out = told(table)
    early = {row.point["excitation.rms"] for row in table.own if is_early(row)}
    assert 0 < len(early) < len(RMS)
    said = "isolation from 4 Hz T_a stays below 1 on all 6 curves; on"
    assert f"{said} {len(early)} of them from 2 Hz" in out
    assert "below 1 on 5 of 6 curves, nowhere on the others" in told(
        spoil(table, NOT_SETTLED, 2)
    )


def is_early(row):
    """Return whether a case isolates at 2 Hz already."""
    return row.point["excitation.frequency"] == 2.0 and row.metrics["T_a"] < 1.0


def test_isolation_of_too_many_cases_is_said_to_be_unknown(told, monkeypatch):
    for module in (sweep_kind, tally_table):
        monkeypatch.setattr(module, "MAX_ISOLATION_CASES", 5)
    out = told(small(reference=None))
    assert "isolation not known not determined, as there are more than 5 cases" in out


def test_isolation_is_told_neither_of_a_sample_of_frequencies_nor_without_numbers(told):
    frequency, *rest = axes(frequency=[2, 4], rms=[0.5])
    sample = sweep(replace(frequency, group="sample"), *rest, reference=None)
    table = small(reference=None)
    for result in (sample, spoil(table, NOT_SETTLED, *range(len(table)))):
        assert "isolation" not in told(result)


def test_interrupted_sweep_is_incomplete(capsys):
    table = small()
    show(replace(table, rows=table.rows[:8], complete=False), Path("out/seat"))
    out, _ = capsys.readouterr()
    assert "  state       incomplete: 8 of 12 cases\n" in out
    assert "written" not in out


@pytest.mark.parametrize(
    ("count", "is_all", "said"),
    [
        (8, False, ": 8 finished cases are kept in out/seat.partial; the same command with "
         "--resume computes only the rest"),
        (12, True, " after the last of 12 cases: kept in out/seat.partial; the same command "
         "with --resume writes the result"),
        (0, False, " before any case was finished"),
    ],
)  # fmt: skip
def test_interruption_says_how_to_go_on(capsys, count, is_all, said):
    show_interrupted(count, "case", Path("out/seat"), is_all=is_all)
    assert capsys.readouterr().err == f"interrupted{said}\n"


# comparisons

SENTENCES = ("signum is off: " + "far and " * 12 + "away", "a smaller step will not help")


def test_comparison_is_aligned_columns_when_piped(capsys):
    made = replace(orbits(["signum", "stick-slip"]), verdict=SENTENCES)
    show(made, Path("out/seat"))
    out, err = capsys.readouterr()
    rows = [line.split("  ") for line in out.splitlines()]
    table = [[cell.strip() for cell in row if cell.strip()] for row in rows]
    at = next(i for i, row in enumerate(table) if row[:1] == ["approach"])
    assert table[at] == [
        "approach", "T_a", "deviation", "T_x", "peak |x_r| mm", "stuck %", "chatter %"
    ]  # fmt: skip
    assert [row[0] for row in table[at + 1 : at + 4]] == ["signum", "stick-slip", "viscous"]
    signum, exact = made.table.rows[:2]
    assert table[at + 1][1] == f"{signum.metrics['T_a']:.4g}"
    assert table[at + 1][2] == f"{100 * made.deviation(signum):+.3g} %"
    assert table[at + 2][2] == "–"
    assert table[at + 2][5] == f"{100 * exact.metrics['stuck_share']:.3g}"
    assert " ".join(" ".join(SENTENCES).split()) in " ".join(out.split())
    assert "reference   stick-slip" in out
    assert max(map(len, out.splitlines())) <= 80
    assert err == ""


def test_stroke_of_a_small_comparison_is_told_in_micrometres(capsys):
    made = orbits(["signum", "stick-slip"], rms=5e-6, force=15e-5)
    show(made)
    out = capsys.readouterr().out
    heading, *_ = (line for line in out.splitlines() if line.startswith("approach"))
    assert "peak |x_r| µm" in heading
    peak = made.table.rows[1].metrics["x_r_peak"]
    (row,) = (line for line in out.splitlines() if line.startswith("stick-slip"))
    assert f"  {1e6 * peak:.3g}  " in row


def test_comparison_over_a_sweep_gives_ranges_and_the_worst_with_where(capsys):
    swept = axes(force=[0, 15, 45], rms=[0.33, 0.67])
    made = comparison(["signum", "stick-slip"], *swept, n=900)
    show(made)
    out = capsys.readouterr().out
    T_a = [row.metrics["T_a"] for row in made.table.of("signum")]
    worst = max(100 * made.deviation(row) for row in made.table.of("signum"))
    (row,) = (line for line in out.splitlines() if line.startswith("signum"))
    assert f"{min(T_a):.4g}–{max(T_a):.4g}" in row
    assert f"{worst:+.3g} %" in row
    assert "worst signum at kinetic 45 N, rms 0.33 m/s²" in " ".join(out.split())
    # A record does not know the displacement of its base.
    assert "T_x" not in out


def test_comparison_is_a_ruled_table_at_a_terminal_of_80_columns(capsys, colour):
    swept = axes(force=[0, 15, 45], rms=[0.33, 0.67])
    made = comparison(["signum", "stick-slip"], *swept, n=900)
    rows = tuple(
        replace(row, metrics={**row.metrics, "T_x": 0.01234 * (at + 1)})
        for at, row in enumerate(made.table.rows)
    )
    show(replace(made, table=replace(made.table, rows=rows)))
    out = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out)
    assert "─────" in out
    assert "…" not in out
    assert "T_x" not in out
    assert "chatter %" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


# progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


def terminal(monkeypatch):
    """Put a terminal in the place of stderr."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    return stream


def test_only_long_work_at_a_terminal_that_can_draw_shows_a_bar(capsys, monkeypatch):
    def work(**words):
        with console_terminal.progress(3, "cases", **words) as advance:
            advance()
            advance(2)

    monkeypatch.setenv("FORCE_COLOR", "1")
    with monkeypatch.context() as piped:
        piped.setattr(console_terminal, "PROGRESS_DELAY", -1.0)
        work()
    assert capsys.readouterr() == ("", "")
    screen = terminal(monkeypatch)
    work()  # short
    monkeypatch.setattr(console_terminal, "PROGRESS_DELAY", -1.0)
    work(quiet=True)
    monkeypatch.setenv("TERM", "dumb")
    work()
    assert screen.getvalue() == ""


def test_work_that_lasts_shows_a_bar_and_takes_it_away(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(console_terminal, "PROGRESS_DELAY", 0.0)
    with console_terminal.progress(30, "cases") as advance:
        time.sleep(0.001)
        advance(12)
    shown = screen.getvalue()
    assert "cases" in shown
    assert "12/30" in shown
    assert shown.endswith("\x1b[2K")


@pytest.mark.parametrize(
    ("done", "blocks", "seconds", "shown"),
    [
        (1, 1083, 1.0, "1 cases/s"),
        (30, 1083, 40.0, "0.75 cases/s"),
        (9_000, 300, 2.0, "1/300 blocks, 4,500 cases/s"),
        (64, 17, 7.0, "1/17 blocks, 9.1 cases/s"),
    ],
)
def test_blocks_are_shown_where_they_are_not_the_cases(
    monkeypatch, done, blocks, seconds, shown
):
    clock = [0.0]
    monkeypatch.setattr(console_terminal.time, "monotonic", lambda: clock[0])
    pace = console_terminal._ProgressBar(1083 if done < 100 else 10_000, "cases", blocks)
    clock[0] = seconds
    pace._done, pace._blocks_done = done, 1
    assert pace._describe_rate() == shown


def test_compilation_is_said_at_a_terminal_only(capsys, monkeypatch):
    announce_compilation()
    assert capsys.readouterr() == ("", "")
    screen = terminal(monkeypatch)
    announce_compilation()
    assert screen.getvalue() == f"{COMPILING_MESSAGE}\n"
    screen = terminal(monkeypatch)
    monkeypatch.setenv("TERM", "dumb")  # as in the manual, whose screens are those of any run
    announce_compilation()
    assert screen.getvalue() == ""


def test_interrupt_gives_the_terminal_back(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(console_terminal, "PROGRESS_DELAY", -1.0)

    def interrupted():
        with console_terminal.progress(30, "cases") as advance:
            advance()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert screen.getvalue().count("\x1b[?25h") == screen.getvalue().count("\x1b[?25l") == 1


def test_counting_costs_next_to_nothing_where_nobody_watches():
    with console_terminal.progress(1_000_000, "cases") as advance, no_hang():
        for _ in range(1_000_000):
            advance()


@pytest.mark.parametrize(
    "number", ["45 N", "0.5 m/s²", "1.189 m/s^1.75", "43.1 ± 1.3 mm", "±0.86 %", "500 N·s/m"]
)
def test_number_stays_with_its_unit_at_every_width(number):
    for length in range(60, 85):
        text = f"{'x' * length} {number}; {number}, and 26 cases"
        lines = console_terminal.wrap(stdout(), text, 0)
        assert " ".join(lines) == text
        assert sum(line.count(number) for line in lines) == 2


def test_long_label_and_long_range_stay_apart_from_what_follows(capsys):
    rows = [
        Row("T_a", "1.2", "least"),
        Row("no dry friction", "below 0.1 % to 23.6 %", "most at 1 Hz"),
    ]
    print_rows(stdout(), rows, 20)
    short, long = capsys.readouterr().out.splitlines()[1:]
    assert "no dry friction  below 0.1 % to 23.6 %  most at 1 Hz" in long
    assert short.index("least") == long.index("most")


@pytest.mark.parametrize(
    ("over", "changes", "said"),
    [
        ({"excitation.frequency": [1, 2]}, {}, ["base harmonic, 1 m/s² RMS"]),
        ({"excitation.rms": [1, 2]}, {}, ["base harmonic 1.6 Hz"]),
        ({"oscillator.stiffness": [5000, 7500]}, {},
         ["oscillator m 75 kg, b 500 N·s/m", "base harmonic 1.6 Hz, 1 m/s² RMS"]),
        ({"oscillator.mass": [50, 75]},
         {"oscillator.damping": None, "oscillator.damping_ratio": 0.3},
         ["oscillator k_x 7500 N/m, ξ 0.3"]),
        ({"friction.kinetic": [15, 45]}, {"friction.static_ratio": 1.2}, ["F_fs/F_fk 1.2"]),
        ({"friction.kinetic": [0, 15]}, {},
         ["friction F_fs = F_fk (not given) ", "swept friction.kinetic 0, 15 N "]),
        ({"friction.static_ratio": [1, 1.2]}, {}, ["friction F_fk 15 N base "]),
    ],
)  # fmt: skip
def test_sweep_tells_what_all_its_cases_share(told, scenario, over, changes, said):
    out = told(solved(scenario(SEAT, {**changes, "sweep": over})))
    assert all(sentence in out for sentence in said)
    assert ("isolation" in out) == ("excitation.frequency" in over)


def test_sweep_of_a_record_names_its_file(tmp_path, scenario, told):
    (tmp_path / "r.csv").write_text("a [m/s2]\n" + "1\n-1\n" * 20)
    base = {"kind": "record", "file": "r.csv", "rate": 100}
    changes = {"excitation": base, "solver": None, "measure": None, "friction": None}
    sweep = {"excitation.scale": [1, 2]}
    assert " base record r.csv " in told(solved(scenario(SEAT, changes | {"sweep": sweep})))


def test_at_most_three_warnings_of_one_kind_are_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    alike = [WarningMessage("record-mean", f"record {i} has a mean") for i in range(20)]
    show_warnings([*alike, WarningMessage("chatter", "it chatters")])
    shown = capsys.readouterr().err.splitlines()
    assert shown == [
        "warning: record 0 has a mean",
        "warning: record 1 has a mean",
        "warning: record 2 has a mean",
        "warning: it chatters",
        "warning: 17 more warnings of the kind record-mean: see drysim.json",
    ]
