"""What Python shows of an answer, and of a fault: a line or two, never a wall of numbers."""

from __future__ import annotations

import numpy as np
import pytest

import drysim

SEAT = """
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
excitation: {kind: harmonic, frequency: 2, rms: 0.75}
solver: {step: 2.5e-3}
sweep: {friction.kinetic: [0, 45]}
checks: [x_r_peak < 1 mm, T_a < 2]
"""
NOISE = {"kind": "standard", "class": "EM3", "duration": 10, "seeds": 3}


@pytest.fixture
def seat(tmp_path):
    """Give the path of a seat's scenario."""
    (tmp_path / "seat.yaml").write_text(SEAT)
    return tmp_path / "seat.yaml"


def test_outcome_shows_itself_in_a_line(seat):
    outcome = drysim.run(drysim.load(seat))
    assert repr(outcome) == (
        "<Outcome of seat: T_a 0.976, T_x 0.4485, peak |x_r| 2.794 mm; 5 events; "
        "1 of 2 checks held>"
    )
    elsewhere = {"checks": ["T_a < 2", "T_a < 1 at friction.kinetic < 1"]}
    told = repr(drysim.run(drysim.load(seat, elsewhere)))
    assert told.endswith("1 of 2 checks held and 1 not judged>")
    assert repr(outcome.response) == "<Response: 201 points at 0.0025 s, 5 events>"
    assert repr(outcome.events).startswith("<Events: 5; ")


def test_answers_of_many_cases_show_themselves_in_a_line(seat):
    table = drysim.sweep(drysim.load(seat))
    assert repr(table) == (
        "<Table of seat: 2 cases by stick-slip; T_a 0.976 to 1.28, T_x 0.449 to 1.55, "
        "peak |x_r| 2.79 to 10.4 mm; 1 of 2 checks held>"
    )
    comparison = drysim.compare(drysim.load(seat), "signum vs stick-slip")
    assert repr(comparison).startswith(
        "<Comparison of seat: signum, stick-slip, viscous against stick-slip; signum "
    )
    own = repr(drysim.sweep(drysim.load(seat))).partition("; ")[2].partition("; ")[0]
    assert f"; {own} by stick-slip; 1 of 2 checks held" in repr(comparison.table)
    many = drysim.run(drysim.load(seat, {"excitation": NOISE}))
    assert repr(many).startswith("<Ensemble of seat: 3 seeds; T_a 1.0")
    assert len(repr(many)) < 200


def test_comparison_takes_its_words_as_a_text_or_as_a_list(seat):
    scenario = drysim.load(seat)
    one = drysim.compare(scenario, "signum vs stick-slip")
    for words in (["signum", "stick-slip"], ["signum vs stick-slip"]):
        assert drysim.compare(scenario, words).verdict == one.verdict
    for words in (None, 5, [5, 6]):
        with pytest.raises(drysim.UsageError, match="takes words, such as"):
            drysim.compare(scenario, words)


def test_what_is_no_scenario_no_row_and_no_number_of_threads_earns_a_sentence(seat):
    scenario = drysim.load(seat)
    for solve in (drysim.run, drysim.sweep, lambda one: drysim.compare(one, "signum viscous")):
        with pytest.raises(drysim.UsageError, match="what is solved is a scenario"):
            solve(str(seat))
    many = drysim.load(seat, {"excitation": NOISE})
    for workers in ("2", 0, -1, 2.5, True):
        for solve, one in (
            (drysim.sweep, scenario),
            (drysim.run, many),
            (drysim.run, scenario),
        ):
            with pytest.raises(drysim.UsageError, match="workers must be a whole number of at"):
                solve(one, workers=workers)
    comparison = drysim.compare(scenario, "signum vs stick-slip", workers=np.int64(2))
    with pytest.raises(drysim.UsageError, match="that of a row of the table, not of 'x'"):
        comparison.deviation("x")
    slower = drysim.load(seat, {"oscillator.damping": 900})
    with pytest.raises(drysim.UsageError, match=r"of a row of the table, not of `?Row"):
        comparison.deviation(drysim.sweep(slower)[0])
    assert comparison.deviation(comparison.table[1]) == comparison.deviation(
        drysim.compare(scenario, "signum vs stick-slip").table[1]
    )
    table = comparison.table
    assert table[-1] == table[4] == list(table)[4]
    assert table[1:3] == list(table)[1:3]
    for number in (5, -6):
        with pytest.raises(IndexError, match=f"there is no number {number} among 5"):
            table[number]


def test_fault_shows_every_problem_with_its_place(seat):
    seat.write_text(SEAT.replace("mass: 75", "mas: 75").replace("kinetic: 45}", "kinetic: -1}"))
    with pytest.raises(drysim.ScenarioError) as caught:
        drysim.load(seat)
    assert str(caught.value).splitlines() == [
        f"{seat} is not a scenario yet: 2 problems",
        f"{seat}:3:14: unknown key `mas` in oscillator; did you mean `mass`?",
        f"{seat}:4:35: friction.kinetic must be at least 0 N, not -1",
    ]


def test_fault_of_a_record_shows_its_place(seat):
    record = {"kind": "record", "file": "r.csv", "rate": 400}
    (seat.parent / "r.csv").write_text("a [g]\n1\noops\n")
    scenario = drysim.load(seat, {"excitation": record, "solver": None})
    with pytest.raises(drysim.RecordError) as caught:
        drysim.run(scenario)
    where = seat.parent / "r.csv"
    assert (
        str(caught.value) == f"{where}:3:1: row 3, column 1 (`a [g]`): `oops` is not a number"
    )


def test_what_is_no_scenario_is_told_in_a_sentence(seat):
    for ask in (drysim.run, drysim.sweep):
        with pytest.raises(
            drysim.UsageError, match=r"as `drysim\.load` gives it, not 'seat\.ya"
        ):
            ask("seat.yaml")
    with pytest.raises(drysim.UsageError, match="m must be above 0, not -1"):
        drysim.simulate(m=-1.0, k_x=1.0, b=0.0, u_dd=np.zeros(3), dt=0.1)
