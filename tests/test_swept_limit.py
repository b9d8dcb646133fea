"""A stroke limit that is swept: every case is judged by its own, never by that of the file."""

from __future__ import annotations

import pytest

from drysim.console import many
from drysim.plots.sweep import draw_stroke
from drysim.scenario.load import load
from drysim.study.sweep import sweep

SEAT = """\
name: seat
oscillator: {mass: 80, stiffness: 6000, damping: 250}
friction: {law: coulomb, kinetic: 30, static: 40}
stroke: {limit: 15 mm}
excitation: {kind: harmonic, frequency: 1.7 Hz, rms: 1.5 m/s2}
solver: {step: 2 ms}
"""
PEAK = 34.42  # mm, whatever the limit


@pytest.fixture
def swept(tmp_path):
    """Give the table of the seat over some swept keys, stops as a file says them."""

    def solved(words, stops=""):
        file = tmp_path / "seat.yaml"
        file.write_text(SEAT.replace("15 mm", f"15 mm{stops}") + f"sweep: {words}\n")
        return sweep(load(file))

    return solved


def said(table, capsys):
    """Give the summary of a table, every run of blanks as one."""
    many.show_table(table)
    return " ".join(capsys.readouterr().out.split())


def limits(figure):
    """Give the stroke limits that a picture draws, as the points of each curve."""
    dashed = [
        line for axes in figure.axes for line in axes.lines if line.get_linestyle() == "--"
    ]
    level = [line for line in dashed if len({*line.get_xdata()}) > 1]
    return [list(map(float, line.get_ydata())) for line in level]


def test_summary_holds_every_case_to_its_own_limit(swept, capsys):
    table = swept("{stroke.limit: [10 mm, 20 mm, 50 mm, 100 mm]}")
    out = said(table, capsys)
    assert f"peak |x_r| {PEAK} mm 344 % of the stroke limit, at limit 0.01 m" in out
    assert f"limit met 2 cases of 4, {PEAK - 10:.2f} mm too far at the worst" in out
    (warning,) = [one for one in table.warnings if one.slug == "stroke-violated"]
    assert warning.sentence == (
        f"the stroke limit is met in 2 of 4 cases; |x_r| reaches {PEAK} mm at limit 0.01 m"
    )
    assert warning.numbers["limit"] == 0.01


def test_case_that_uses_the_most_of_its_own_limit_is_told_beside_the_peak(swept, capsys):
    out = said(swept("{stroke.limit: [100 mm, 10 mm]}"), capsys)
    assert f"peak |x_r| {PEAK} mm 34.4 % of the stroke limit, at limit 0.1 m" in out
    assert "344 % of the stroke limit at the most, at limit 0.01 m" in out
    assert f"{PEAK - 10:.2f} mm too far at the worst" in out


def test_rigid_stops_use_all_of_any_limit_and_no_more(swept, capsys):
    out = said(swept("{stroke.limit: [6 mm, 30 mm]}", ", stops: {restitution: 0.4}"), capsys)
    assert "peak |x_r| 30 mm 100 % of the stroke limit, at limit 0.03 m" in out
    assert "at the most" not in out


def test_limit_with_one_value_is_not_told_as_that_of_the_file(swept, capsys):
    out = said(swept("{stroke.limit: [30 mm]}", ", stops: {restitution: 0.4}"), capsys)
    assert "15 mm" not in out


def test_picture_draws_a_swept_limit_as_the_curve_that_it_is(swept):
    figure = draw_stroke(swept("{stroke.limit: [10 mm, 20 mm, 50 mm, 500 mm]}"))
    assert limits(figure) == [pytest.approx([10.0, 20.0, 50.0])]


def test_picture_draws_the_own_limit_of_every_line(swept):
    words = "{excitation.frequency: [1, 1.5, 2, 3, 4], stroke.limit: [10 mm, 30 mm]}"
    figure = draw_stroke(swept(words))
    assert [set(line) for line in limits(figure)] == [{10.0}, {30.0}]
    many = ", ".join(f"{limit} mm" for limit in range(10, 20))
    assert not limits(draw_stroke(swept(words.replace("10 mm, 30 mm", many))))
