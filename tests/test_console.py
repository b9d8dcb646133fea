"""The terminal: what stands on stdout and stderr, and that no user's text drives it."""

from __future__ import annotations

import contextlib
import io
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import drysim as package
from drysim import wording
from drysim.console import many, problems, summaries
from drysim.core.model import Law
from drysim.errors import OutputError, Problem, RecordError, ScenarioError
from outcomes import outcome, record

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
error: seat.yaml is not a scenario yet: 2 problems

seat.yaml:3:3: unknown key `stifness` in oscillator; did you mean `stiffness`?
  3 │   stifness: 7500
    │   ^^^^^^^^
seat.yaml:5:12: friction.kinetic must be at least 0 N, not -15
  5 │   kinetic: -15
    │            ^^^
"""


pytestmark = pytest.mark.usefixtures("eighty_columns")


# summary


def test_summary_fits_80_columns_and_is_plain_when_piped(capsys):
    made = outcome(
        Law(15.0, 15.0), record(2_000), None, limit=0.001,
        checks=["x_r_peak < 25 mm", "T_a < 0.1", "T_x < 1"],
    )  # fmt: skip
    summaries.show_outcome(made, Path("out/seat"))
    out, err = capsys.readouterr()
    assert max(map(len, out.splitlines())) <= 80
    assert {sign for sign in out if not sign.isprintable()} == {"\n"}
    assert err == ""


def test_summary_says_what_matters_in_words_and_millimetres(capsys):
    made = outcome(Law(15.0, 15.0), limit=0.005, checks=["x_r_peak < 25 mm", "T_x < 0.1"])
    summaries.show_outcome(made, Path("out/seat"))
    out = " ".join(capsys.readouterr().out.split())
    peak = made.metrics["x_r_peak"] * 1e3
    for words in (
        "m 75 kg, k_x 7500 N/m, b 500 N·s/m, f_0 1.592 Hz, ξ 0.333",
        "F_fk 15 N, F_fs 15 N (not given: F_fs = F_fk)",
        "harmonic 1.6 Hz, 1.061 m/s² RMS",
        made.response.numerics.why,
        f"peak |x_r| {peak:.4g} mm",
        "of the stroke limit of 5 mm",
        "limit met 3 times",
        f"✓ holds x_r_peak < 25 mm, with {peak:.6g} mm",
        "✗ fails T_x < 0.1, with ",
        "written out/seat",
    ):
        assert words in out


@pytest.mark.parametrize(
    ("check", "scale", "unit"),
    [
        ("x_r_peak < 5 cm", 1e2, " cm"),
        ("x_r_peak < 5", 1.0, " m"),
        ("a_u > 0.05 g", 1 / 9.80665, " g"),
        ("a_u < 50 m/s2", 1.0, " m/s²"),
        ("stuck_share < 90 %", 1e2, " %"),
        ("T_a < 9", 1.0, ""),
    ],
)
def test_value_is_told_in_the_unit_of_its_check(capsys, check, scale, unit):
    made = outcome(Law(15.0, 15.0), checks=[check])
    summaries.show_outcome(made, None)
    value = wording.number(made.metrics[check.split()[0]] * scale, digits=6)
    assert f"✓ holds     {check}, with {value}{unit}\n" in capsys.readouterr().out


LENGTH = re.compile(r"(?<=[\d.] )(?:µm|mm|m)\b(?!/)")


def in_all_outputs(words, folder):
    """Return the units of length in the summary, the warnings and the picture of a case."""
    from drysim.plots.response import draw
    from drysim.scenario.load import load
    from drysim.study.ensemble import run

    made = run(load(folder / "seat.yaml", words))
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        summaries.show_outcome(made)
    figure = draw(made)
    figure.draw_without_rendering()
    told = [one.sentence for one in made.warnings if one.slug == "stroke-violated"]
    assert told
    told += [text.get_text() for text in figure.texts]
    told += [text.get_text() for one in figure.legends for text in one.get_texts()]
    told += [f"1 {axes.get_title('left')[-3:-1].strip(' [')}" for axes in figure.axes]
    return {*LENGTH.findall("\n".join([out.getvalue(), *told]))}


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
    summaries.show_outcome(outcome(motion=record(700), duration=None, checks=["T_x < 1"]))
    out = capsys.readouterr().out
    assert "T_x         not known" in out
    assert "T_x < 1, with not known" not in out
    assert "✗ fails     T_x < 1; T_x is not known here" in out


def test_steady_orbit_shows_how_well_it_closes(capsys):
    made = outcome()
    numerics = replace(made.response.numerics, closure=1.23e-13, period_multiple=2)
    summaries.show_outcome(replace(made, response=replace(made.response, how=lambda: numerics)))
    assert "steady orbit (2 periods), closes to 1.2e-13" in capsys.readouterr().out


def test_warnings_go_to_stderr_one_a_line_when_piped(capsys):
    long = "the stroke limit is met " + "again and " * 20 + "again"
    summaries.show_outcome(outcome(warnings=[long]))
    out, err = capsys.readouterr()
    assert "again" not in out
    assert err == f"warning: {long}\n"


def test_no_user_text_drives_the_terminal_nor_the_markup(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    evil = "[bold red]\x1b[2J\x1b]0;owned\x07\x9b31m\u202e:smile:\r\n[/]"
    made = outcome(name=evil, about=evil, warnings=[evil])
    summaries.show_outcome(made, Path(f"out/{evil}"))
    problem = Problem(evil, evil, 1, 3, 4, evil)
    problems.show_fault(ScenarioError(evil, (problem,), evil))
    problems.show_problems({evil: (problem,)})
    problems.show_problems({evil: (problem,)}, "github")
    shown = "".join(capsys.readouterr())
    assert "[bold red]" in shown
    assert ":smile:" in shown
    left = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert {sign for sign in left if not sign.isprintable()} == {"\n"}
    assert "\x1b[2J" not in shown


def test_colour_is_there_when_forced_and_gone_when_refused(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    made = outcome(checks=["T_a < 0.01"])
    summaries.show_outcome(made)
    assert "\x1b[1;31m" in capsys.readouterr().out
    monkeypatch.setenv("NO_COLOR", "1")
    summaries.show_outcome(made)
    assert not re.search(r"\x1b\[[0-9;]*3[0-7]", capsys.readouterr().out)


def test_stream_that_knows_no_greek_gets_question_marks(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    summaries.show_outcome(outcome(checks=["T_a < 9"]))
    stream.flush()
    assert b"? holds" in stream.buffer.getvalue()


# faults and problems


def test_problems_are_shown_as_the_contract_has_them(capsys):
    problems.show_problems({"seat.yaml": (TYPO, NEGATIVE)})
    assert capsys.readouterr() == (SHOWN, "")


def test_fault_shows_its_problems_on_stderr(capsys):
    sentence = "seat.yaml is not a scenario yet: 2 problems"
    problems.show_fault(ScenarioError(sentence, (TYPO, NEGATIVE), "mend it"))
    assert capsys.readouterr() == ("", SHOWN + "\nmend it\n")


def test_fault_of_a_record_is_said_once_at_its_place(capsys):
    problem = Problem("`abc` is not a number", "road.csv", 12, 3, 3, "1\tabc")
    problems.show_fault(RecordError(problem))
    assert capsys.readouterr().err == (
        "error: road.csv cannot be used\n\nroad.csv:12:3: `abc` is not a number\n"
        "  12 │ 1 abc\n     │   ^^^\n"
    )


def test_fault_without_a_place_is_a_sentence_and_a_hint(capsys):
    problems.show_fault(OutputError("out is a file, not a folder", "move it away"))
    assert capsys.readouterr().err == "error: out is a file, not a folder\n\nmove it away\n"


def test_every_file_gets_its_verdict(capsys):
    problems.show_problems({"seat.yaml": (TYPO,), "ok.yaml": (), "still.yaml": (STANDSTILL,)})
    out = capsys.readouterr().out
    assert "error: seat.yaml is not a scenario yet: 1 problem\n" in out
    assert "ok: ok.yaml is a scenario\n" in out
    assert "ok: still.yaml is a scenario, with 1 warning\n" in out
    assert "still.yaml: warning: the mass will not move\n" in out


def test_caret_stands_below_the_fault_also_behind_wide_and_odd_signs(capsys):
    source = "日本\t\x1b: stifness"
    problem = replace(TYPO, source=source, column=source.index("stif") + 1)
    problems.show_problems({"seat.yaml": (problem,)})
    above, below = capsys.readouterr().out.splitlines()[-2:]
    # Each of the two signs before is two cells wide.
    assert below.index("^") == above.index("stifness") + 2
    assert below.count("^") == len("stifness")


def test_endless_source_line_is_cut_around_the_fault(capsys):
    source = "x: 1, " * 10_000 + "stifness: 7500" + ", y: 2" * 10_000
    problem = replace(TYPO, source=source, column=source.index("stif") + 1)
    problems.show_problems({"seat.yaml": (problem,)})
    above, below = capsys.readouterr().out.splitlines()[-2:]
    assert len(above) < 120
    assert above.index("stifness") == below.index("^")


def test_problems_as_json_are_one_object(capsys):
    problems.show_problems({"seat.yaml": (TYPO,), "still.yaml": (STANDSTILL,)}, "json")
    told = json.loads(capsys.readouterr().out)
    seat, still = told["files"]
    assert (seat["file"], seat["sound"], still["sound"]) == ("seat.yaml", False, True)
    assert seat["problems"][0] == {
        "severity": "error", "file": "seat.yaml", "line": 3, "column": 3, "width": 8,
        "key": "oscillator.stifness", "sentence": TYPO.sentence, "source": TYPO.source,
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


@pytest.mark.parametrize("step", [0.3, 0.7])
def test_window_is_that_of_the_metrics_on_a_grid_that_misses_its_end(seat, capsys, step):
    """A step of 0.3 s draws up to 1.8 s of the 2 s; the metrics are of all of them."""
    times = ["measure={settle: 1 s, duration: 1 s}", f"solver.step={step}"]
    made = package.run(package.load(seat, times))
    fine = package.run(package.load(seat, times[:1]))
    summaries.show_outcome(made)
    assert "window      1 s after settling for 1 s" in capsys.readouterr().out
    assert made.metrics["a_u"] == pytest.approx(fine.metrics["a_u"], rel=1e-9)


def test_repetition_is_counted_in_periods_of_the_base(seat, capsys):
    """5 Hz under a normal force of 9 Hz repeats after 1 s: `a period` was said of five."""
    words = ["measure=null", "excitation.frequency=5", "solver.step=1e-3"]
    varied = "friction.normal_variation={amplitude: 0.4, frequency: 9}"
    summaries.show_outcome(package.run(package.load(seat, [*words, varied])))
    assert "steady orbit (5 periods)" in capsys.readouterr().out
    for step in (1e-3, 1.0):  # one longer than the period makes it no shorter
        words[-1] = f"solver.step={step}"
        summaries.show_outcome(package.run(package.load(seat, words)))
        assert "steady orbit (a period)" in capsys.readouterr().out


def test_comparison_tells_the_base_motion_as_a_run_does(seat, capsys):
    made = package.compare(package.load(seat), ("signum", "stick-slip"))
    many.show_comparison(made)
    assert "base        harmonic 1.6 Hz, 1 m/s² RMS" in capsys.readouterr().out
