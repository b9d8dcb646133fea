"""The pictures of sweeps and comparisons: what is drawn, and that every table can be."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from grids import FORCE, FREQUENCY, RMS, UNKNOWN, axes, comparison, orbits, points, spoil, sweep
from outcomes import outcome, stand_in
from seat import EM6_SEAT, load_text, write_records
from shown import labelled, legend, show

from drysim import wording
from drysim.bench.score import Bench, BenchCase, Score
from drysim.metrics.checks import COMPARISONS, LEAST_EXCESS, Check
from drysim.plots import comparison as comparison_plot
from drysim.plots import metric_map, style
from drysim.plots import sweep as sweep_plots
from drysim.plots.comparison import draw as draw_comparison
from drysim.plots.speed_error import draw as draw_bench
from drysim.plots.style import T_A, T_X, plotted, save_picture
from drysim.plots.sweep import draw_map, draw_stroke, draw_transmissibility
from drysim.scenario.axes import Axis
from drysim.scenario.load import load
from drysim.study.compare import compare
from drysim.study.statistics import FAILED, NOT_SETTLED, NOT_UNIQUE, as_batches
from drysim.study.sweep import sweep as solved
from drysim.study.table import Table, Tally
from drysim.study.warnings import table_stroke_warnings

MASS = Axis("oscillator.mass", "kg", (50.0, 75.0, 100.0))


def along(key, *values, unit="-"):
    """Return a table over any key, its numbers borrowed from one case."""
    row = sweep(*axes(frequency=[2.0]), reference=None).rows[0]
    axis = Axis(key, unit, tuple(map(float, values)))
    rows = tuple(replace(row, point={key: value}) for value in axis.values)
    return Table(stand_in("harmonic", 0.025), (axis,), rows)


SCENES = {
    "paper": lambda: sweep(*axes(frequency=[0.5, 1, 2, 4, 8], rms=[0.5, 1.0])),
    "friction": lambda: sweep(*axes(force=[0, 15, 45], rms=[0.33, 0.67])),
    "one case": lambda: sweep(*axes(frequency=[2.0])),
    "two axes, many lines": lambda: sweep(*axes(frequency=[1, 2], rms=np.linspace(0.2, 2, 12))),
    "three axes": lambda: sweep(*axes(frequency=[1, 2], rms=[1, 2], force=[0, 5, 15, 20, 45])),
    "nothing is known": lambda: spoil(sweep(*axes(frequency=[1, 2])), FAILED, *range(4)),
    "a long curve of which nothing is known": lambda: spoil(
        sweep(*axes(frequency=np.linspace(1, 2, 24), rms=[1, 2])), NOT_SETTLED, *range(24)
    ),
    "gaps": lambda: spoil(sweep(*axes(frequency=[1, 2, 3, 4])), NOT_SETTLED, 0, 2),
    "no limit": lambda: sweep(*axes(frequency=[1, 2]), limit=None),
    "violated": lambda: sweep(*axes(frequency=[1, 2]), limit=0.001),
    "all stuck": lambda: sweep(*axes(frequency=[1, 2, 4]), force=500.0),
    "falling": lambda: sweep(*axes(frequency=[8, 4, 2, 1], rms=[1.0, 0.5])),
    "mass": lambda: replace(along(MASS.key, *MASS.values, unit="kg"), axes=(MASS,)),
    "negative": lambda: along("excitation.phase", -1.0, 0.0, 1.0, unit="rad"),
    "seed": lambda: along("excitation.seed", 1, 2, 3),
    "odd words": lambda: replace(
        sweep(*axes(frequency=[1, 2])),
        scenario=stand_in("psd", name="$x_{ 日本\x1b[31m", about="$" * 500),
    ),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_sweep_is_drawn_without_a_warning(scene, tmp_path):
    table = scene()
    save_picture(lambda: draw_transmissibility(table), tmp_path / "transmissibility.png")
    save_picture(lambda: draw_stroke(table), tmp_path / "stroke.png")
    for name in ("transmissibility.png", "stroke.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_panel_of_a_metric_that_no_case_knows_says_so():
    said = {
        name: [
            "not known" in [text.get_text() for text in panel.texts] for panel in figure.axes
        ]
        for name in ("nothing is known", "one case")
        for figure in [draw_transmissibility(SCENES[name]())]
    }
    assert said == {"nothing is known": [True], "one case": [False, False]}


def test_displacement_stands_left_and_acceleration_right_over_a_logarithmic_frequency():
    table = SCENES["paper"]()
    figure = draw_transmissibility(table)
    left, right = figure.axes
    assert "Tₓ = xᵣ/u [–]" in left.get_title("left")
    assert "Tₐ [–]" in right.get_title("left")
    rows = [row for row in table.own if row.point[RMS] == 1.0]
    for panel, metric in ((left, "T_x"), (right, "T_a")):
        assert panel.get_xscale() == "log"
        assert panel.get_xlim() == (0.5, 8.0)
        assert panel.get_xlabel() == "frequency [Hz]"
        assert panel.get_ylim()[0] == 0.0
        (curve,) = labelled(panel, "aᵤ 1 m/s²")
        assert list(curve.get_xdata()) == [row.point[FREQUENCY] for row in rows]
        assert list(curve.get_ydata()) == [row.metrics[metric] for row in rows]
    assert legend(figure) == ["aᵤ 0.5 m/s²", "aᵤ 1 m/s²", "viscous, no dry friction"]


def test_reference_is_drawn_once_where_it_is_the_same_for_all_lines():
    table = SCENES["paper"]()
    for panel in draw_transmissibility(table).axes:
        assert len(labelled(panel, "viscous, no dry friction")) == 1
        curves = [line for line in panel.lines if len(line.get_xdata()) == 5]
        assert [line.get_linestyle() for line in curves] == ["-", "-", "--"]
    (panel,) = draw_stroke(table).axes
    own = [line for line in panel.lines if len(line.get_xdata()) == 5]
    colours = {line.get_linestyle(): [] for line in own}
    for line in own:
        colours[line.get_linestyle()].append(str(line.get_color()))
    # The stroke of the reference goes with the intensity: it is dashed in the line's colour,
    # and in the legend in none of them.
    assert colours["--"] == colours["-"]
    (told,) = labelled(panel, "viscous, no dry friction")
    assert told.get_color() not in colours["-"]


def test_friction_is_drawn_as_force_and_a_reference_without_it_as_a_level():
    figure = draw_transmissibility(SCENES["friction"]())
    _, right = figure.axes
    assert right.get_xlabel() == "kinetic friction force F_fk [N]"
    assert right.get_xscale() == "linear"
    (level,) = labelled(right, "viscous, no dry friction")
    assert len(set(level.get_ydata())) == 1


def test_only_the_acceleration_is_drawn_where_the_base_displacement_is_not_known():
    table = SCENES["paper"]()
    rows = tuple(replace(row, metrics={**row.metrics, "T_x": None}) for row in table.rows)
    (panel,) = draw_transmissibility(replace(table, rows=rows)).axes
    assert "Tₐ" in panel.get_title("left")


def test_gap_is_left_and_marked_where_there_is_no_number():
    table = spoil(sweep(*axes(frequency=[1, 2, 3, 4]), reference=None), NOT_SETTLED, 1)
    figure = draw_transmissibility(spoil(table, NOT_UNIQUE, 3))
    for panel in figure.axes:
        line = panel.lines[0]
        assert np.isnan(line.get_ydata()).tolist() == [False, True, False, True]
        (mark,) = labelled(panel, "not settled")
        assert list(mark.get_xdata()) == [2.0]
        # A point between two gaps has no line to show it.
        assert any(list(other.get_xdata()) == [1.0, 3.0] for other in panel.lines[1:])
    assert {"not settled", "not unique"} < set(legend(figure))


def test_natural_frequency_is_marked_unless_the_oscillator_is_swept():
    def marks(table):
        return [
            text.get_text()
            for panel in draw_transmissibility(table).axes
            for text in panel.texts
        ]

    table = SCENES["paper"]()
    assert marks(table) == ["f₀", "√2 f₀"] * 2
    assert marks(replace(table, axes=(*table.axes, MASS))) == []
    assert marks(SCENES["friction"]()) == []


def second_key(key, unit, *ends):
    """Return a table over a frequency and 25 values of any key, its numbers borrowed."""
    row = sweep(*axes(frequency=[2.0]), reference=None).rows[0]
    swept = (*axes(frequency=[1.0, 2.0]), Axis(key, unit, tuple(np.linspace(*ends, 25))))
    rows = tuple(replace(row, point=point) for point in points(swept))
    return Table(stand_in("harmonic", 0.025), swept, rows)


@pytest.mark.parametrize(
    ("key", "unit", "low", "high"),
    [
        (FORCE, "N", 1.0, 73.0),
        ("oscillator.stiffness", "N/m", 1e3, 730005.0),
        ("oscillator.damping", "N*s/m", 1e-5, 9e-5),
        ("start.x_r", "m", -0.123, 0.07),
        ("start.x_r", "m", 0.0001, 0.0007),
        ("friction.options.stribeck_velocity", "m/s", 1234567.0, 1234569.0),
    ],
)
def test_scale_of_colours_with_its_label_lies_within_the_picture(key, unit, low, high):
    for figure in (
        draw_transmissibility(table := second_key(key, unit, low, high)),
        draw_stroke(table),
    ):
        figure.draw_without_rendering()
        *panels, bar = figure.axes
        box, whole = bar.get_tightbbox(), figure.bbox
        assert box.x0 > max(panel.get_tightbbox().x1 for panel in panels)
        assert box.x1 < whole.x1
        assert (box.y0 > 0.0, box.y1 < whole.y1) == (True, True)


def test_many_lines_are_coloured_by_their_value():
    figure = draw_transmissibility(SCENES["two axes, many lines"]())
    assert len(figure.axes) == 3
    assert figure.axes[-1].get_ylabel() == "base acceleration aᵤ RMS [m/s²]"
    assert legend(figure) == ["viscous, no dry friction"]
    colours = {str(line.get_color()) for line in figure.axes[0].lines}
    assert len(colours) > 12


def test_third_axis_gets_panels_of_its_own_on_one_scale():
    table = SCENES["three axes"]()
    view = sweep_plots.sweep_view(table)
    # The longest of the other axes tells lines apart.
    assert view.line.key == FORCE
    assert [panel.title for panel in view.panels] == ["aᵤ 1 m/s²", "aᵤ 2 m/s²"]
    figure = draw_transmissibility(table)
    assert len(figure.axes) == 4
    assert len({panel.get_ylim() for panel in figure.axes[:2]}) == 1
    assert sum(bool(panel.get_xlabel()) for panel in figure.axes) == 2


def test_panel_of_nothing_but_zeros_has_a_scale_of_one_and_no_other():
    stuck = sweep(*axes(frequency=[1, 2, 4]), force=500.0, reference=None)
    assert draw_stroke(stuck).axes[0].get_ylim() == (0, 1)
    lost = spoil(stuck, NOT_SETTLED, *range(3))
    assert draw_stroke(lost).axes[0].get_ylim() == (0, 1)
    beside = draw_stroke(sweep(*axes(frequency=[1, 2, 4]), force=500.0)).axes[0]
    assert beside.get_ylim()[1] > max(
        labelled(beside, "viscous, no dry friction")[0].get_ydata()
    )


def test_every_curve_lies_within_its_panel_where_a_lower_row_reaches_higher():
    force, rms = [45, 2], [0.5, 0.6, 0.7]
    table = sweep(*axes(frequency=[1, 1.6, 2], force=force, rms=rms), reference=None)
    for figure in (draw_transmissibility(table), draw_stroke(table)):
        for panel in figure.axes:
            top = panel.get_ylim()[1]
            assert all(np.max(line.get_ydata()) <= top for line in panel.lines)
    steep = sweep(*axes(frequency=[1, 10, 400], force=[45, 0], rms=[1, 2, 3]), reference=None)
    columns = [panel.get_yscale() for panel in draw_transmissibility(steep).axes]
    assert columns == ["linear", "linear", "log", "log"]


ZIPPED = (
    "name: seat\noscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
    "friction: {law: coulomb, kinetic: 15}\nstroke: {limit: 25 mm}\n"
    "excitation: {kind: harmonic, frequency: 2, rms: 1}\nsolver: {step: 2.5e-3}\n"
)


def zipped(folder, block):
    """Return a scenario with a sweep in which keys walk together."""
    return load_text(folder, f"{ZIPPED}sweep: {{{block}}}\n")


FORCES_AND_LIMITS = "zip: {friction.kinetic: [45, 15, 5], stroke.limit: [6 mm, 12 mm, 9 mm]}"


def test_keys_that_walk_together_are_one_line_for_each_place(tmp_path):
    made = zipped(tmp_path, f"excitation.frequency: [1, 2, 3, 4, 5], {FORCES_AND_LIMITS}")
    (panel,) = draw_stroke(solved(made)).axes
    (bare,) = labelled(panel, "F_fk 5 N, limit 9 mm")
    assert panel.get_xlabel() == "frequency [Hz]"
    assert len(bare.get_xdata()) == 5
    dashed = labelled(panel, "stroke limit per line")
    assert [set(line.get_ydata()) for line in dashed] == [{6.0}, {12.0}, {9.0}]


def test_stroke_limit_that_walks_with_the_axis_is_a_curve(tmp_path):
    made = zipped(tmp_path, "zip: {friction.kinetic: [15, 45], stroke.limit: [12 mm, 5 mm]}")
    (panel,) = draw_stroke(solved(made)).axes
    curve, limit, *_ = panel.lines
    assert list(curve.get_xdata()) == list(limit.get_xdata()) == [15, 45]
    assert list(limit.get_ydata()) == [12, 5]


def test_comparison_has_a_panel_for_each_place_of_keys_that_walk_together(tmp_path):
    made = zipped(tmp_path, f"excitation.frequency: [1, 2, 3, 4, 5], {FORCES_AND_LIMITS}")
    _, *panels = draw_comparison(compare(made, "switch vs stick-slip")).axes
    assert len(panels) == 6
    for panel in panels[::2]:
        assert len(labelled(panel, "stick-slip")[0].get_xdata()) == 5


def test_comparison_of_a_sample_draws_points_and_no_line_between_them(tmp_path):
    over = "{excitation.frequency: {from: 1, to: 5}, oscillator.mass: {from: 50, to: 90}}"
    made = zipped(tmp_path, f"sample: {{kind: latin, count: 20, seed: 1, over: {over}}}")
    _, *panels = draw_comparison(compare(made, "switch vs stick-slip")).axes
    assert len(panels) == 2
    (points,) = labelled(panels[0], "stick-slip")
    assert (points.get_linestyle(), points.get_marker()) == ("None", ".")
    assert len(points.get_xdata()) == 20


@pytest.mark.parametrize(
    "words", ["mmmm WWWW, " * 20, "iiii llll; " * 30, "m" * 150, "T_a 1, " * 45, "$" * 150]
)
def test_heading_never_leaves_the_picture(words):
    with style.picture_style():
        figure, _ = style.panel_grid(1, 1)
        style.finish_figure(figure, style.make_heading(stand_in("psd"), words, words, words))
    rendered(figure)
    titles = [text.get_window_extent() for text in figure.texts]
    assert 2 < len(titles) <= 1 + 2 * style.MAX_WRAPPED_LINES
    assert apart(titles)
    assert max(box.x1 for box in titles) <= figure.bbox.x1
    assert max(box.x1 for box in titles) > 0.8 * figure.bbox.x1


@pytest.mark.parametrize("count", [8, 20])
def test_heading_is_wrapped_and_cut_between_a_number_and_the_next_name(count):
    words = ", ".join(f"oscillator.{'x' * key} 50 N·s/m" for key in range(count))
    lines = style.make_heading(stand_in("psd"), words, "m 75 kg", words).lines
    assert len(lines) == 6 if count == 20 else " ".join(lines).count(words) == 2
    for line in lines:
        assert line.endswith(("50 N·s/m", "50 N·s/m,", "50 N·s/m, …"))
    assert sum("…" in line for line in lines) == 2 * (count == 20)


def test_legend_has_no_entry_of_what_is_out_of_view():
    figure, grid = style.panel_grid(1, 1)
    axes = figure.add_subplot(grid[0, 0])
    axes.plot([0, 10], [5, -5], label="a line that crosses the panel")
    axes.plot([0, 10], [5, -5], "o", label="dots beside it")
    axes.plot([0, np.nan, 10], [5, np.nan, 5], label="a line above it")
    axes.plot([5.9, np.nan], [0.0, np.nan], "o", label="a dot on its edge")
    axes.axhline(2.0, label="a limit above it")
    axes.axhline(0.5, label="a limit in it")
    axes.plot([], [], label="a stand-in")
    axes.set_xlim(4.5, 5.9)
    axes.set_ylim(-1, 1)
    style.finish_figure(figure, style.Heading("", ()))
    assert legend(figure) == [
        "a line that crosses the panel", "a dot on its edge", "a limit in it", "a stand-in"
    ]  # fmt: skip


@pytest.mark.parametrize("which", ["x", "y"])
def test_ticks_of_a_short_axis_far_from_zero_are_written_in_full(which):
    with style.picture_style():
        figure, grid = style.panel_grid(1, 1)
        axes = figure.add_subplot(grid[0, 0])
        ends = [1.2999, 1.2999 + 1e-9]
        axes.plot(*([ends, [0, 1]] if which == "x" else [[0, 1], ends]))
        axis = getattr(axes, f"{which}axis")
        if which == "x":
            style.set_ticks(axis)
        figure.draw_without_rendering()
        assert not axis.get_offset_text().get_text()
        labels = [tick.label1.get_text() for tick in axis.get_major_ticks()]
    assert len({*labels}) == len(labels) > 1
    assert all(float(label) == pytest.approx(1.2999, abs=2e-9) for label in labels)


@pytest.mark.parametrize(
    ("metres", "label", "ticks"), [([0.002, 0.008], "mm", "2"), ([20.0, 80.0], "m", "20")]
)
def test_axis_over_a_length_is_in_the_unit_of_the_console(metres, label, ticks):
    axis = Axis("stroke.limit", "m", tuple(metres))
    figure, grid = style.panel_grid(1, 1)
    axes = figure.add_subplot(grid[0, 0])
    style.set_axis(axes, "x", style.axis_label(axis), *metres, False)
    assert axes.get_xlabel() == f"stroke.limit [{label}]"
    assert axes.xaxis.get_ticklabels()[0].get_text() == ticks


def test_no_text_of_a_picture_is_a_formula(tmp_path):
    from matplotlib.text import Text

    drawn = []
    table = sweep(*axes(frequency=[1.0, 2.0, 4.0]))
    save_picture(
        lambda: drawn.append(draw_transmissibility(table)) or drawn[0], tmp_path / "a.png"
    )
    assert not any(text.get_parse_math() for text in drawn[0].findobj(Text))
    for file in Path(style.__file__).parent.glob("*.py"):
        assert "$" not in file.read_text(encoding="utf-8"), file.name


def test_answer_stands_in_the_heading():
    weighted = outcome()
    metrics = weighted.metrics | {"T_a": 0.5, "SEAT": 0.25, "a_w": 0.125}
    first, second = style.response_heading(replace(weighted, metrics=metrics)).lines
    assert first.startswith("Tₐ 0.5, SEAT 0.25, a_w 0.125 m/s², ")
    assert second.startswith("m 75 kg, ")


def test_what_is_not_drawn_is_said():
    table = sweep(*axes(frequency=[1, 2], force=range(7), rms=range(1, 7)), reference=None)
    view = sweep_plots.sweep_view(table)
    assert len(view.panels) == sweep_plots.MAX_PANELS
    assert view.left_out == 2 * 7
    words = " ".join(text.get_text() for text in draw_transmissibility(table).texts)
    assert "14 curves not drawn" in words


def test_sweep_is_drawn_over_the_frequency_whatever_varies_fastest():
    table = sweep(*axes(rms=[0.5, 1.0], frequency=[1, 2, 3, 4, 5]), reference=None)
    assert sweep_plots.sweep_view(table).key == FREQUENCY
    few = sweep(*axes(rms=[0.5, 1.0], frequency=[1, 2]), reference=None)
    assert sweep_plots.sweep_view(few).key == RMS


def test_steep_transmissibility_is_drawn_logarithmically():
    table = sweep(*axes(frequency=[1, 10, 100, 400]), force=0.0, reference=None)
    _, right = draw_transmissibility(table).axes
    assert right.get_yscale() == "log"
    right.figure.canvas.draw()
    assert {"1", "0.1", "0.01"} <= {tick.get_text() for tick in right.get_yticklabels()}
    (panel,) = draw_stroke(table).axes
    assert panel.get_yscale() == "linear"


def test_stroke_shows_its_limit_and_marks_every_case_that_meets_it():
    table = sweep(*axes(frequency=[1, 2, 4], rms=[0.5, 1.0]), limit=0.012)
    figure = draw_stroke(table)
    (panel,) = figure.axes
    assert "[mm]" in panel.get_title("left")
    (limit,) = labelled(panel, "stroke limit 12 mm")
    assert set(limit.get_ydata()) == {12.0}
    (met,) = labelled(panel, "limit exceeded")
    beyond = [row for row in table.own if row.metrics["violations"]]
    assert len(met.get_xdata()) == len(beyond) > 0
    assert all(peak >= 12.0 for peak in met.get_ydata())


def test_stroke_limit_that_is_too_far_away_to_be_drawn_is_told():
    for limit, words in ((5.0, "stroke limit 5000 mm"), (0.012, "stroke limit 12 mm")):
        figure = draw_stroke(sweep(*axes(frequency=[1, 2]), limit=limit))
        assert any(words in text.get_text() for text in figure.texts)
        assert (words in legend(figure)) == (limit < 1)
    swept = draw_stroke(sweep(*axes(frequency=[1, 2]), limit=None))
    assert not any("limit" in text.get_text() for text in swept.texts)


# comparisons

SWEPT = {
    "friction": lambda: comparison(
        ["signum", "smooth", "stick-slip"], *axes(force=[0, 15, 45], rms=[0.33, 0.67]), n=1500
    ),
    "one case": lambda: orbits(["signum", "switch", "smooth", "stick-slip"]),
    "frictionless reference": lambda: comparison(
        ["stick-slip", "viscous"], *axes(force=[0, 45]), n=900, shown={}
    ),
    "no reference value": lambda: without(orbits(["signum", "stick-slip"]), "stick-slip"),
    "one point": lambda: comparison(["smooth", "stick-slip"], *axes(force=[15]), n=900),
    "slow": lambda: orbits(["smooth", "stick-slip"], frequency=0.5),
    "always stuck": lambda: orbits(["smooth", "stick-slip"], force=500.0),
    "never stuck": lambda: orbits(["smooth", "stick-slip"], force=1.0),
}


def without(made, name):
    """Return a comparison in which an approach has no numbers."""
    rows = tuple(
        replace(row, metrics=UNKNOWN, status=FAILED) if row.approach == name else row
        for row in made.table.rows
    )
    return replace(made, table=replace(made.table, rows=rows))


@pytest.mark.parametrize("scene", SWEPT.values(), ids=SWEPT)
def test_comparison_is_drawn_without_a_warning(scene, tmp_path):
    save_picture(lambda: draw_comparison(scene()), tmp_path / "comparison.png")
    assert (tmp_path / "comparison.png").read_bytes().startswith(b"\x89PNG")


def test_comparison_shows_motion_transmissibility_and_deviation():
    made = SWEPT["friction"]()
    figure = draw_comparison(made)
    motion, *panels = figure.axes
    assert motion.get_title("left").startswith("acceleration of the mass ẍ [m/s²]: F_fk 0 N")
    assert motion.get_xlabel() == "time [s]"
    assert len(panels) == 4
    assert "aᵤ 0.33 m/s²: Tₐ [–]" in panels[0].get_title("left")
    assert "aᵤ 0.33 m/s²: deviation of Tₐ [%]" in panels[1].get_title("left")
    (line,) = labelled(panels[1], "signum")
    found = [row for row in made.table.of("signum") if row.point[RMS] == 0.33]
    assert list(line.get_ydata()) == [100 * made.deviation(row) for row in found]
    assert not labelled(panels[1], "stick-slip")
    assert len(labelled(panels[1], "viscous")[0].get_xdata()) == 3
    assert {"signum", "smooth", "stick-slip", "viscous", "within ±5 %"} <= set(legend(figure))


def test_comparison_of_one_case_shows_bars_with_their_numbers():
    made = SWEPT["one case"]()
    figure = draw_comparison(made)
    _, left, right = figure.axes
    assert [label.get_text() for label in left.get_yticklabels()] == list(made.table.approaches)
    assert len(left.patches) == 5
    words = [text.get_text() for text in right.texts]
    assert words[0].startswith("+23.")
    assert len(words) == 4


def test_comparison_where_no_deviation_is_known_shows_the_motion_alone_and_says_why(scenario):
    decay = ZIPPED.replace("kind: harmonic, frequency: 2, rms: 1", "kind: rest")
    words = f"{decay}start: {{x_r: 15 mm}}\nmeasure: {{duration: 1}}\n"
    for changes in ({}, {"sweep": {"friction.kinetic": [5, 15]}}):
        made = compare(scenario(words, changes), "signum vs stick-slip")
        (verdict,) = made.verdict
        assert verdict.startswith("T_a of stick-slip, the reference, is unknown: the base does")
        figure = draw_comparison(made)
        assert len(figure.axes) == 1
        assert figure.texts[1].get_text() == verdict.replace("T_a", "Tₐ")
        assert {"signum", "stick-slip"} < set(legend(figure))


def test_case_that_is_shown_has_its_panel():
    swept = axes(force=[15, 45], rms=[0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
    made = comparison(["stick-slip"], *swept, n=300, shown={FORCE: 45.0, RMS: 0.4})
    titles = [panel.title for panel in sweep_plots.comparison_view(made).panels]
    assert len(titles) == sweep_plots.MAX_COMPARED_PANELS
    assert "aᵤ 0.4 m/s²" in titles


def test_stretch_that_is_shown_holds_a_stop_of_the_reference():
    made = orbits(["signum", "stick-slip"])
    reference = made.responses["stick-slip"]
    begin, end = comparison_plot.choose_interval(reference, [made.responses["signum"]], 0.4)
    assert 0.4 <= begin < end <= reference.trajectory.end
    inside = (reference.t >= begin) & (reference.t <= end)
    assert 0 < reference.stuck[inside].mean() < 1


def test_stretch_without_a_stop_holds_the_greatest_deviation():
    made = orbits(["smooth", "stick-slip"], force=1.0)
    reference, other = made.responses["stick-slip"], made.responses["smooth"]
    gap = comparison_plot.acceleration_difference(reference, other, 0.2)
    begin, end = comparison_plot.choose_interval(reference, [other], 0.2)
    assert begin <= 0.2 + gap.argmax() * reference.dt <= end


def test_short_orbit_goes_on_beside_one_that_is_twice_as_long(scenario):
    # The varying normal force makes the orbit of stick-slip last two periods; signum has no
    # use for it.
    varied = "kinetic: 45, normal_variation: {amplitude: 0.5, frequency: 3}"
    made = compare(
        scenario(ZIPPED.replace("kinetic: 15", varied)), "signum coulomb vs stick-slip"
    )
    short = made.responses["signum"]
    assert comparison_plot.repeat_time(short) == 0.5
    assert comparison_plot.repeat_time(made.responses["coulomb"]) == 1
    motion, loops, *_ = draw_comparison(made).axes
    assert motion.get_xlim()[0] > 0.5
    (thin,) = (
        one for one in motion.lines if one.get_linewidth() < 3 and one.get_linestyle() == "-"
    )
    t, x_dd = np.array(thin.get_data())
    assert t[0] <= motion.get_xlim()[0] < motion.get_xlim()[1] <= t[-1]
    assert x_dd == pytest.approx(np.interp(t - 0.5, short.t, short.x_dd))
    for line in loops.lines:  # closed, a point or two beyond
        x_r = line.get_xdata()
        assert np.abs(x_r[-3:] - x_r[0]).min() == pytest.approx(0, abs=1e-6)


def test_lengths_of_a_sweep_have_one_unit_wherever_they_are_told(capsys):
    table = sweep(*axes(frequency=[1.0, 1.6], rms=[800.0]), limit=9.0, reference=None)
    warnings = tuple(table_stroke_warnings(table.tallies["stick-slip"], table.scenario))
    show(replace(table, warnings=warnings))
    figure = draw_stroke(table)
    told = [*capsys.readouterr(), *(text.get_text() for text in figure.texts), *legend(figure)]
    assert len(warnings) == 1
    assert "stroke limit 9 m" in legend(figure)
    assert set(re.findall(r"\d (µm|mm|m)\b(?!/)", "\n".join(told))) == {"m"}


def test_numbers_of_bars_stand_within_their_panel_of_two_or_three_columns(scenario):
    weighted = compare(scenario(SEAT_SCENE, {"sweep": None}), "signum vs stick-slip")
    for made in (orbits(["signum", "switch", "stick-slip"]), weighted):
        figure = draw_comparison(made)
        figure.draw_without_rendering()
        for panel in figure.axes[1:]:
            room = panel.get_window_extent()
            assert len(panel.texts) > 0
            for number in panel.texts:
                box = number.get_window_extent()
                assert room.x0 <= box.x0
                assert box.x1 <= room.x1


def test_exact_entry_without_an_error_stands_below_all_others_and_says_so():
    exact = Score("stick-slip", "", True, None, 1, time=150.0, verdict="exact by its balance")
    coarse = Score("signum", "", True, 1e-3, 1, time=50.0, error_x_r=0.4, error_T_a=-0.4)
    panel = BenchCase(stand_in("harmonic"), None, (), (exact, coarse), 7.0, None, ())
    figure = draw_bench(Bench((panel,), "plain"))
    for shown in figure.axes:
        lowest = min(
            y for line in shown.lines if line.get_marker() in "*^" for y in line.get_ydata()
        )
        assert lowest == pytest.approx(0.04)
    assert "stick-slip: exact" in legend(figure)


def test_hits_of_end_stops_are_drawn_if_there_are_any(scenario):
    changes = {"friction": None, "stroke.limit": "10 mm", "sweep": {"excitation.rms": [1, 2]}}
    cases = (("restitution", 0.4, "impact speed"), ("stiffness", 1e5, "peak force"))
    for key, value, title in cases:
        scene = scenario(ZIPPED, changes | {"stroke.stops": {key: value}})
        _, hits = draw_stroke(solved(scene)).axes
        assert title in hits.get_title("left")
        (curve,) = [line for line in hits.lines if len(line.get_xdata()) == 2]
        assert 0 < curve.get_ydata()[0] < curve.get_ydata()[1]
        scene = scenario(
            ZIPPED, changes | {"stroke.limit": "1 m", "stroke.stops": {key: value}}
        )
        assert len(draw_stroke(solved(scene)).axes) == 1


@pytest.mark.parametrize(
    ("size", "unit", "limit"), [(1e-5, "µm", 0.25), (1.0, "mm", 25.0), (1e4, "m", 250.0)]
)
def test_stroke_of_a_sweep_is_drawn_in_the_unit_in_which_its_peak_is_told(
    scenario, capsys, size, unit, limit
):
    changes = {"excitation.rms": size, "stroke.limit": 0.025 * size}
    changes |= {"friction.kinetic": 15 * size, "sweep": {"excitation.frequency": [1, 1.4, 2]}}
    table = solved(scenario(ZIPPED, changes))
    (panel,) = draw_stroke(table).axes
    assert panel.get_title("left").endswith(f"[{unit}]")
    assert labelled(panel, f"stroke limit {limit:g} {unit}")[0].get_ydata()[0] == pytest.approx(
        limit
    )
    show(table)
    (told,) = [row for row in capsys.readouterr().out.splitlines() if "peak |x_r|" in row]
    peak = max(labelled(panel, "stick-slip")[0].get_ydata())
    assert told.split()[2:4] == [wording.format_number(peak), unit]
    assert f"{wording.format_number(peak, digits=3)} {unit}" in repr(table)


@pytest.mark.parametrize(
    ("table", "least"),
    [
        (lambda: along("friction.bristle_stiffness", 1e3, 1e4, 1e6, unit="N/m"), 4),
        (lambda: along("start.x_r", -0.015, 0.0, 0.02, unit="m"), 3),
    ],
    ids=["long logarithmic", "negative"],
)
def test_numbers_below_an_axis_do_not_touch(table, least):
    figure = draw_transmissibility(table())
    figure.draw_without_rendering()
    for panel in figure.axes:
        low, high = panel.get_xlim()
        ticks = [one for one in panel.xaxis.get_major_ticks() if low <= one.get_loc() <= high]
        ends = [one.label1.get_window_extent() for one in ticks]
        assert len(ends) >= least
        assert all(one.x1 < other.x0 for one, other in pairwise(ends))
        assert ends[-1].x1 <= figure.bbox.x1


def test_stroke_limit_that_rises_above_the_panel_leaves_it_at_the_top(tmp_path):
    table = solved(zipped(tmp_path, "stroke.limit: [10 mm, 20 mm, 500 mm]"))
    (panel,) = draw_stroke(table).axes
    (limit,) = labelled(panel, "stroke limit")
    peak = 1e3 * table.rows[0].metrics["x_r_peak"]
    assert list(limit.get_ydata()) == pytest.approx([10, 20, 500])
    assert 3.0 * peak < panel.get_ylim()[1] < 4.0 * peak


# The pictures of sweeps of very many cases, drawn of few: bands, maps and their axes.


SEAT = """\
drysim: 1
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
stroke: {limit: 25 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
reference: viscous
"""
BOTH = [T_X, T_A]
GRID = "{excitation.frequency: [1, 2, 4, 8], friction.kinetic: [5, 15, 45]}"
SAMPLE = """
  sample:
    {kind: sobol, count: 60, seed: 1, over: {
      excitation.frequency: {from: 0.5, to: 10},
      oscillator.mass: {distribution: normal, mean: 75, sd: 5, from: 50}}}
"""


@pytest.fixture
def table(scenario):
    """Return a function that computes the table of a sweep block."""
    return lambda block, seat=SEAT: solved(scenario(f"{seat}sweep: {block}\n"))


def band(panel, words):
    """Return the lower and upper ends of a band, by x."""
    (found,) = [one for one in panel.collections if one.get_label() == words]
    ends = {}
    for x, y in found.get_paths()[0].vertices:
        low, high = ends.get(x, (np.inf, -np.inf))
        ends[x] = min(low, y), max(high, y)
    return [ends[x] for x in sorted(ends)]


def line(panel, words):
    """Return the curve of a label."""
    (found,) = [one for one in panel.lines if one.get_label() == words]
    return found.get_xdata(), found.get_ydata()


def mesh(panel):
    """Return the map of a panel."""
    (found,) = [one for one in panel.collections if hasattr(one, "get_coordinates")]
    return found


def test_bands_lie_within_each_other_around_the_median_beside_a_map_of_the_means(table):
    swept = table(GRID)
    bands, mapped, *_ = sweep_plots.draw_quantiles(swept, BOTH).axes
    outer, inner = band(bands, "90 % of the cases"), band(bands, "50 % of the cases")
    x, median = line(bands, "median")
    assert x.tolist() == [1, 2, 4, 8]
    for (low, high), (first, third), middle in zip(outer, inner, median, strict=True):
        assert 0 < low <= first <= middle <= third <= high
    assert line(bands, "median without dry friction")[1][1] > median[1]
    known = [row.metrics["T_x"] for row in swept.of("stick-slip")]
    assert mesh(mapped).get_clim() == pytest.approx((min(known), max(known)))
    assert mesh(mapped).get_array().ravel().tolist() == pytest.approx(known)
    assert mapped.get_xlabel() == "frequency [Hz]"
    assert mapped.get_ylabel() == "kinetic friction force F_fk [N]"
    assert bands.get_xlabel() == ""
    # Whole cells, those of the least and the greatest value, too.
    assert bands.get_xlim() == mapped.get_xlim() == (0.5, 10)
    assert mapped.get_ylim() == (0, 60)
    assert bands.get_ylim()[0] == 0


def test_cells_of_a_logarithmic_map_are_even_in_its_scale(table):
    forces = "friction.kinetic: {from: 1, to: 45, count: 10}"
    block = f"{{excitation.frequency: {{from: 0.1, to: 100, count: 7, scale: log}}, {forces}}}"
    mapped = sweep_plots.draw_quantiles(table(block), BOTH).axes[1]
    assert (mapped.get_xscale(), mapped.get_yscale()) == ("log", "log")
    x = mesh(mapped).get_coordinates()[0, :, 0]
    assert np.diff(np.log(x)).tolist() == pytest.approx([np.log(10) / 2] * 7)
    # An axis of equal steps does not reach down to zero, where no case is.
    assert 0.4 < mapped.get_ylim()[0] < 1


def test_a_coefficient_of_friction_is_not_called_a_force(table):
    block = "{excitation.frequency: [1, 2], friction.mu_kinetic: [0.01, 0.02]}"
    swept = table(block, SEAT.replace("kinetic: 15", "mu_kinetic: 0.02"))
    assert sweep_plots.draw_quantiles(swept, BOTH).axes[1].get_ylabel() == "mu kinetic µₖ [–]"


def test_sample_is_drawn_over_its_frequency_with_a_map_of_its_mass(table):
    swept = table(SAMPLE)
    figure = draw_transmissibility(swept)
    bands, mapped = figure.axes[0], figure.axes[1]
    assert mapped.get_ylabel() == "mass m [kg]"
    # The picture reaches as far as the sample does, its curves and its cells, too.
    x, median = line(bands, "median")
    assert bands.get_xlim() == mapped.get_xlim() == (x[0], x[-1]) == (0.5, 10)
    assert median[0] == median[1]
    counts = sweep_plots.Histogram("T_a", sweep_plots.Bins.of(swept.axes[0]), None)
    sweep_plots.count_cases(as_batches(swept.rows), "stick-slip", [counts])
    assert counts.counts.sum() == 60
    # White where no case is: the map is masked there and nowhere else.
    masked = np.ma.getmaskarray(mesh(mapped).get_array())
    assert 0 < np.count_nonzero(~masked) <= 60


def test_stroke_of_many_cases_is_drawn_beneath_its_limit(table):
    figure = sweep_plots.draw_quantiles(table(GRID), [plotted("x_r_peak", 0.01)])
    assert line(figure.axes[0], "stroke limit 25 mm")[1] == [25, 25]
    assert figure.axes[0].get_ylim()[1] >= 25


def test_only_ratios_are_compared_with_one_over_many_cases(table):
    acceleration = plotted("a_x")
    metrics = [*BOTH, acceleration, plotted("x_r_peak", 0.01)]
    panels = sweep_plots.draw_quantiles(table(GRID), metrics).axes[::2]
    for metric, panel in zip(metrics, panels, strict=True):
        assert panel.get_title("left").endswith(metric.symbol)
        heights = [list(curve.get_ydata()) for curve in panel.lines]
        assert ([1, 1] in heights) == (metric in BOTH), metric.name


def test_numbers_beside_a_map_are_within_the_picture(table):
    small = SEAT.replace("rms: 1.0", "rms: 1e-5").replace("15}", "15e-5}")
    rms = "{excitation.frequency: [1, 1.4, 4, 8], excitation.rms: [0.5e-5, 0.75e-5, 1e-5]}"
    figure = sweep_plots.draw_quantiles(table(rms, small), [plotted("x_r_peak", 2e-7)])
    figure.draw_without_rendering()
    _, mapped = figure.axes
    (bar,) = mapped.child_axes
    ends = [one.get_window_extent().x1 for one in bar.get_yticklabels()]
    assert len(ends) > 2
    assert max(ends) <= figure.bbox.x1
    factor, title = mapped.yaxis.get_offset_text(), mapped.title
    assert not factor.get_window_extent().overlaps(title.get_window_extent())


def test_bar_of_a_map_is_no_axis_of_the_next_which_names_and_numbers_its_own(table):
    block = "{excitation.frequency: [1, 2, 4], oscillator.stiffness: [7500, 7600.25, 7700.5]}"
    figure = sweep_plots.draw_quantiles(table(block), BOTH)
    figure.draw_without_rendering()
    left, right = figure.axes[1], figure.axes[3]
    assert left.get_ylabel() == right.get_ylabel() == "stiffness kₓ [N/m]"
    numbers = [one for one in right.get_yticklabels() if one.get_text()]
    assert [one.get_text() for one in numbers] == [
        one.get_text() for one in left.get_yticklabels()
    ]
    (bar,) = left.child_axes
    end = max(one.get_window_extent().x1 for one in bar.get_yticklabels())
    assert end < right.yaxis.label.get_window_extent().x0


def test_one_case_and_one_key_make_a_picture(table):
    single = sweep_plots.draw_quantiles(table("{friction.kinetic: [15]}"), BOTH)
    assert line(single.axes[0], "median")[1][0] == pytest.approx(1.3, abs=0.1)
    assert len(sweep_plots.draw_quantiles(table("{friction.kinetic: [5, 15]}"), BOTH).axes) == 2


def test_cases_without_numbers_leave_an_empty_panel():
    lost = spoil(sweep(*axes(frequency=[1, 2], force=[5, 15])), FAILED, *range(8))
    figure = sweep_plots.draw_quantiles(lost, BOTH)
    assert figure.axes[0].get_ylim()[0] == 0
    assert np.isnan(line(figure.axes[0], "median")[1]).all()


def test_quantiles_of_a_picture_are_those_of_the_cases():
    values = np.random.Generator(np.random.PCG64(2)).lognormal(size=5000)
    bins = sweep_plots.Bins.of(axes(frequency=[1, 2])[0])
    one = sweep_plots.Histogram("T_a", bins, None)

    class Batch:
        metrics, points = {"T_a": values}, {"excitation.frequency": np.ones(5000)}

    one.add(Batch)
    for level in (0.05, 0.25, 0.5, 0.75, 0.95):
        assert one.quantile(level)[0] == pytest.approx(np.quantile(values, level), rel=4e-3)
        assert np.isnan(one.quantile(level)[1])
    assert Counter(one.counts.sum(axis=1).tolist()) == {5000: 1, 0: 1}


def test_range_that_is_drawn_by_difference_has_even_bins_to_its_end(table):
    force = "friction.kinetic: {from: 0.5, to: 60}"
    mass = "oscillator.mass: {from: 10, to: 500, scale: log}"
    sample = f"{{kind: latin, count: 60, seed: 2, over: {{{force}, {mass}}}}}"
    by_difference, by_ratio = (
        sweep_plots.Bins.of(axis) for axis in table(f"{{sample: {sample}}}").axes
    )
    assert by_difference.edges[[0, -1]].tolist() == pytest.approx([0.5, 60])
    assert np.ptp(np.diff(by_difference.centers)) == pytest.approx(0, abs=1e-9)
    assert by_ratio.edges[[0, -1]].tolist() == pytest.approx([10, 500])
    assert (by_difference.is_log, by_ratio.is_log) == (False, True)


def test_values_listed_in_any_order_have_bins_from_the_least_to_the_greatest():
    values = np.random.Generator(np.random.PCG64(3)).permutation(np.linspace(1, 6, 151))
    bins = sweep_plots.Bins.of(axes(frequency=values)[0])
    assert bins.edges[[0, -1]].tolist() == [1, 6]
    assert np.all(np.diff(bins.edges) > 0)


def test_bins_between_which_a_range_has_no_value_are_one():
    values = np.linspace(0.5, 10, 210)
    bins = sweep_plots.Bins.of(axes(frequency=values)[0])
    assert bins.is_log
    assert bins.edges[[0, -1]].tolist() == [0.5, 10]
    assert np.bincount(bins.find(values), minlength=len(bins)).min() == 1


def test_sample_of_a_decade_by_ratio_has_a_logarithmic_axis_with_every_number_in_full(table):
    stiffness = "oscillator.stiffness: {from: 5 kN/m, to: 50 kN/m"
    over = "excitation.frequency: {from: 1, to: 5}"
    for words, scale in (("", "linear"), (", scale: log", "log")):
        sample = f"{{kind: latin, count: 60, seed: 2, over: {{{over}, {stiffness}{words}}}}}}}"
        figure = draw_transmissibility(table(f"{{sample: {sample}}}"))
        figure.draw_without_rendering()
        mapped = figure.axes[1]
        assert mapped.get_yscale() == scale
        assert mapped.get_ylim() == pytest.approx((5e3, 5e4))
        assert {"10000", "20000"} <= {one.get_text() for one in mapped.get_yticklabels()}
        assert mapped.yaxis.get_offset_text().get_text() == ""
        assert mapped.yaxis.label.get_window_extent().x0 > 0


# The answer in a picture: SEAT, the admissible range and the best case.

SEAT_SCENE = f"""\
{EM6_SEAT}
sweep: {{friction.kinetic: [0, 10, 20, 30, 40, 60]}}
checks: [SEAT < 0.5]
"""


@pytest.fixture
def seat_table(scenario):
    return solved(scenario(SEAT_SCENE))


def test_weighted_sweep_shows_SEAT_its_admissible_range_and_its_best_case(seat_table):
    figure = draw_transmissibility(seat_table)
    panel = figure.axes[-1]
    assert panel.get_title(loc="left") == "SEAT [–]"
    best = seat_table.best.row
    (star,) = (line for line in panel.lines if line.get_marker() == "*")
    assert star.get_xdata() == [best.point["friction.kinetic"]]
    assert star.get_ydata() == [best.metrics["SEAT"]]
    assert f"best case: least SEAT {best.metrics['SEAT']:.4g} at " in " ".join(legend(figure))
    admissible = [
        row.point["friction.kinetic"]
        for row in seat_table.own
        if not row.metrics["violations"] and row.metrics["SEAT"] < 0.5
    ]
    assert 1 < len(admissible) < 6
    for panel in figure.axes:
        (shade,) = panel.patches
        ends = shade.get_extents().transformed(panel.transData.inverted()).intervalx
        assert ends == pytest.approx([min(admissible), max(admissible)])


TWO_KEYS = (
    "{friction.kinetic: {from: 0, to: 60, count: 6}, "
    "oscillator.damping: {from: 100, to: 1600, count: 5, scale: log}}"
)


def test_sweep_of_two_keys_is_drawn_as_a_map_with_limit_and_best_case(tmp_path):
    table = solved(seat(tmp_path, TWO_KEYS, "[SEAT < 0.5]"))
    figure = draw_map(table)
    panel, bar = figure.axes
    assert (panel.get_xscale(), panel.get_yscale()) == ("linear", "log")
    assert panel.get_xlabel() == "kinetic friction force F_fk [N]"
    assert panel.get_ylabel() == "damping b [N·s/m]"
    assert bar.get_ylabel() == "SEAT [–]"
    mesh, hatched, edges = (one for one in panel.collections if one.get_label()[0] == "_")
    rows = [row.metrics for row in table.own]
    assert mesh.get_array().ravel().tolist() == [row["SEAT"] for row in rows]
    # Every admissible case is on one side of the line, every other one hatched on the other.
    good = [row["SEAT"] < 0.5 and not row["violations"] for row in rows]
    assert 0 < len(hatched.get_paths()) == good.count(False) < len(rows)
    grid = np.array(good).reshape(5, 6)
    between = (grid[1:] != grid[:-1]).sum() + (grid[:, 1:] != grid[:, :-1]).sum()
    assert len(edges.get_paths()) == between
    (star,) = (line for line in panel.lines if line.get_marker() == "*")
    assert [*star.get_xdata(), *star.get_ydata()] == [*table.best.row.point.values()]
    entries = legend(figure)
    assert entries[:2] == ["exceeds a limit", "limit"]
    assert entries[2].startswith("best case: least SEAT ")
    heading = " ".join(text.get_text() for text in figure.texts)
    assert "checks SEAT < 0.5; " in heading


FIVE = [1, 2, 3, 4, 5]


@pytest.mark.parametrize("seed", range(20))
def test_hatched_cells_are_the_cases_that_fail_also_at_the_limit(seed):
    random = np.random.default_rng(seed)
    table = sweep(*axes(frequency=FIVE, rms=FIVE), reference=None)
    numbers, exceeds = random.integers(0, 4, 25), random.random(25) < 0.2
    rows = tuple(
        replace(row, metrics=row.metrics | {"stroke_used": 1.0 if v else 0.5, "contacts": n})
        for row, n, v in zip(table.rows, numbers.tolist(), exceeds.tolist(), strict=True)
    )
    check = Check.parse(f"contacts {random.choice([*COMPARISONS])} {random.integers(1, 3)}")
    table.scenario.checks = (check,)
    table = Table(table.scenario, table.axes, rows)
    fails = ~check.holds(numbers)
    (tally,) = Tally.of(as_batches(rows), table.scenario, "stick-slip").values()
    assert tally.verdicts[0].failed == fails.sum()
    panel = draw_map(table).axes[0]
    (hatched,) = (
        drawn for drawn in panel.collections if drawn.get_hatch() and drawn.get_paths()
    )
    left, bottom = np.array([path.vertices.min(axis=0) for path in hatched.get_paths()]).T
    cells = np.searchsorted(FIVE, bottom), np.searchsorted(FIVE, left)
    shown = np.zeros((5, 5), dtype=bool)
    shown[cells] = True
    assert shown.ravel().tolist() == (fails | exceeds).tolist()


def test_map_of_many_values_is_interpolated_unless_a_case_has_no_value():
    def fine(limit):
        values = np.linspace(0, 40, 13), np.linspace(0.5, 2, 12)
        return sweep(*axes(force=values[0], rms=values[1]), limit=limit, reference=None)

    figure = draw_map(fine(0.01))
    panel = figure.axes[0]
    assert [text.get_text() for text in panel.texts]  # levels, named on their lines
    assert legend(figure) == ["exceeds a limit", "limit"]
    assert legend(draw_map(fine(1e-9))) == ["exceeds a limit"]
    figure = draw_map(fine(None))  # without a limit
    assert figure.axes[0].texts
    assert not legend(figure)
    figure = draw_map(spoil(fine(0.01), FAILED, 5))
    assert not figure.axes[0].texts
    assert legend(figure) == ["no case with a value", "exceeds a limit", "limit"]


@pytest.mark.parametrize("failed", [LEAST_EXCESS, 1.0])
@pytest.mark.parametrize("kept", [0.0, -1.0])
def test_interpolated_map_hatches_cases_beyond_a_limit_only(kept, failed):
    from matplotlib.figure import Figure

    x = np.arange(12.0)
    values = np.add.outer(x, x)
    panel = Figure().add_subplot()
    metric_map.draw_levels(panel, x, x, values, np.where(values > 12, failed, kept))
    (region,) = (drawn for drawn in panel.collections if any(getattr(drawn, "hatches", ())))
    inner = [(a, b) for a in range(1, 11) for b in range(1, 11) if a + b != 12]  # off the line
    hatched = region.get_paths()[0].contains_points(inner)
    assert hatched.tolist() == [a + b > 12 for a, b in inner]


@pytest.mark.parametrize(
    "table",
    [
        lambda: sweep(*axes(frequency=[1, 2, 3, 4])),
        lambda: sweep(*axes(frequency=FIVE, rms=[1, 2, 3, 4])),
        lambda: sweep(*axes(frequency=FIVE, rms=FIVE, force=FIVE)),
        lambda: spoil(sweep(*axes(frequency=FIVE, rms=FIVE)), FAILED, *range(50)),
    ],
)
def test_sweep_without_two_ranges_of_known_numbers_has_no_map(table):
    assert draw_map(table()) is None


def test_map_shows_what_is_checked_and_else_T_a():
    table = sweep(*axes(frequency=FIVE, rms=FIVE))
    assert draw_map(table).axes[1].get_ylabel() == "Tₐ [–]"
    table.scenario.checks = (Check.parse("x_r_rms < 1 mm"),)
    assert draw_map(table).axes[1].get_ylabel().startswith("x_r_rms [")


def test_best_design_over_all_records_is_marked_in_the_picture(tmp_path):
    write_records(tmp_path / "runs", 3)
    record = "{kind: record, file: runs/run-00.csv, time: t, column: u_dd}"
    (tmp_path / "seat.yaml").write_text(
        f"oscillator: {{mass: 75, stiffness: 3500, damping: 250}}\nexcitation: {record}\n"
        "friction: {law: coulomb, kinetic: 20}\nchecks: [T_a < 2]\n"
        "sweep: {excitation.file: runs/*.csv, friction.kinetic: [0, 40]}\n"
    )
    table = solved(load(tmp_path / "seat.yaml"))
    figure = draw_transmissibility(table)
    stars = [line for line in figure.axes[-1].lines if line.get_marker() == "*"]
    found = [table.best.value, table.best.over_records.value]
    assert [star.get_ydata()[0] for star in stars] == found
    assert f"best for all records: least Tₐ {found[1]:.4g} at " in " ".join(legend(figure))


def test_sweep_without_limits_has_no_best_case(tmp_path):
    free = load_text(tmp_path, SEAT_SCENE, {"stroke": None, "checks": None})
    for panel in draw_transmissibility(solved(free)).axes:
        assert not panel.patches
        assert not [line for line in panel.lines if line.get_marker() == "*"]


def test_weighted_comparison_shows_SEAT(tmp_path):
    for changes in ({}, {"sweep": None}):
        made = compare(load_text(tmp_path, SEAT_SCENE, changes), "signum vs stick-slip")
        panel = draw_comparison(made).axes[-1]
        assert panel.get_title(loc="left") == "SEAT [–]"


def test_titles_of_three_columns_do_not_touch_and_empty_cells_are_explained(tmp_path):
    over = "{friction.kinetic: {from: 0, to: 60}, oscillator.mass: {from: 50, to: 90}}"
    sample = f"{{sample: {{kind: uniform, count: 30, seed: 1, over: {over}}}}}"
    for block, explained in ((sample, True), ("{friction.kinetic: [0, 10, 20]}", False)):
        figure = draw_transmissibility(solved(seat(tmp_path, block)))
        titles, _ = rendered(figure)
        assert apart(titles)
        assert ("no case with a value" in legend(figure)) == explained


# No text leaves a picture or touches another.

MANY_KEYS = """
  oscillator.stiffness: [2000, 3500]
  oscillator.mass: [60, 90]
  oscillator.damping: [100.5, 200.25]
"""


def apart(boxes):
    """Whether no two of the boxes overlap."""
    return not any(
        one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 and other.y0 < one.y1
        for at, one in enumerate(boxes)
        for other in boxes[:at]
    )


def rendered(figure):
    """Draw a figure and return the extents of its titles and of its legend within it."""
    figure.draw_without_rendering()
    titles = [axes._left_title.get_window_extent() for axes in figure.axes]
    return titles, [text.get_window_extent() for one in figure.legends for text in one.texts]


def seat(folder, sweep, checks="[SEAT < 0.5]"):
    """Return the seat with another sweep."""
    text = re.sub(r"sweep: .*\n", f"sweep: {sweep}\n", SEAT_SCENE)
    return load_text(folder, text.replace("[SEAT < 0.5]", checks))


def test_long_titles_of_rows_stand_above_their_first_panel(tmp_path):
    scenario = seat(tmp_path, "\n  friction.kinetic: [0, 20, 40]" + MANY_KEYS)
    made = compare(scenario, "signum vs stick-slip")
    for figure in (draw_transmissibility(solved(scenario)), draw_comparison(made)):
        titles, _ = rendered(figure)
        assert max(box.x1 for box in titles) <= figure.bbox.x1
        above = ["\n" in panel.get_title(loc="left") for panel in figure.axes]
        assert sum(above) >= 3
        # The first line of two may be as long as the picture, for the others have one line.
        for lines in (True, False):
            assert apart([box for box, two in zip(titles, above, strict=True) if two is lines])


def test_best_case_of_many_keys_stays_within_the_legend(tmp_path):
    over = ", ".join(
        f"{key}: {{from: {low}, to: {2 * low}}}"
        for key, low in {
            "friction.kinetic": 10, "friction.static_ratio": 1.0123, "oscillator.mass": 60,
            "oscillator.stiffness": 2000, "oscillator.damping": 100, "stroke.limit": 0.02,
            "start.x_r": 0.0001234, "start.v_r": 0.001234,
        }.items()
    )  # fmt: skip
    sample = f"{{sample: {{kind: latin, count: 20, seed: 1, over: {{{over}}}}}}}"
    figure = draw_transmissibility(solved(seat(tmp_path, sample)))
    assert "best case: least " in " ".join(legend(figure))
    _, entries = rendered(figure)
    assert apart(entries)
    assert min(box.x0 for box in entries) >= 0
    assert max(box.x1 for box in entries) <= figure.bbox.x1


def test_motion_of_laws_is_wide_beside_their_loops(tmp_path):
    seat(tmp_path, "{friction.kinetic: [10, 40]}")
    scenario = load(tmp_path / "seat.yaml", {"friction.dahl.bristle_stiffness": 60000})
    figure = draw_comparison(compare(scenario, "dahl vs coulomb"))
    titles, _ = rendered(figure)
    motion, loops = (panel.get_window_extent() for panel in figure.axes[:2])
    assert motion.width > 1.5 * loops.width
    assert apart(titles)


@pytest.mark.parametrize("letters", [(9, 40, 9), (90,), (30,) * 12, (3,) * 7])
def test_legend_of_any_words_stays_within_the_picture(letters):
    figure, grid = style.panel_grid(1, 1)
    axes = figure.add_subplot(grid[0, 0])
    for at, n in enumerate(letters):
        axes.plot([0], [0], label=f"{at} {'e' * n}")
    style.finish_figure(figure, style.Heading("", ()))
    _, entries = rendered(figure)
    assert apart(entries)
    assert len(entries) == len(letters)
    assert max(box.x1 for box in entries) <= figure.bbox.x1
    assert min(box.y0 for box in entries) >= 0


def test_sweep_without_an_admissible_case_says_so(tmp_path, seat_table):
    none = solved(seat(tmp_path, "{friction.kinetic: [0, 10]}", "[SEAT < 0.001]"))
    for draw in (draw_transmissibility, draw_stroke):
        words = draw(none).texts[1].get_text()
        assert words.startswith("no case of 2 is admissible; the closest fails SEAT < 0.001")
        assert words.count("admissible") == 1
        assert "admissible" not in draw(seat_table).texts[1].get_text()


def test_heading_of_a_scene_without_shared_values_begins_with_the_base():
    assert style.make_heading(stand_in("psd"), "T_a 1", "", "psd").lines[1] == "psd"


def test_every_logarithmic_deviation_is_announced_with_ticks_apart(tmp_path):
    scenario = seat(
        tmp_path, "{friction.kinetic: [0, 20, 60], oscillator.mass: [50, 100, 150]}"
    )
    figure = draw_comparison(compare(scenario, "signum vs stick-slip"))
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_yscale() == "symlog"]
    assert labels == ["logarithmic beyond ±5 %"] * 3


@pytest.mark.parametrize("largest", [25.0, 180.0, 4000.0, 90_000.0])
def test_ticks_of_deviations_do_not_touch(largest):
    figure, grid = style.panel_grid(2, 2)
    axes = figure.add_subplot(grid[1, 0])
    axes.plot([0, 1], [-50.0, largest])
    comparison_plot._set_deviation_scale(axes, [-50.0, largest])
    figure.draw_without_rendering()
    low, high = axes.get_ylim()
    ticks = zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    assert apart([label.get_window_extent() for at, label in ticks if low <= at <= high])


def test_numbers_below_a_single_case_do_not_touch(tmp_path):
    figure = draw_transmissibility(solved(seat(tmp_path, "{friction.kinetic: [20]}")))
    figure.draw_without_rendering()
    for panel in figure.axes:
        low, high = panel.get_xlim()
        assert low < 20 < high
        ticks = zip(panel.get_xticks(), panel.get_xticklabels(), strict=True)
        assert apart([label.get_window_extent() for at, label in ticks if low <= at <= high])


@pytest.mark.parametrize(
    ("text", "typeset"),
    [
        ("T_a 1.2, F_fk 3 N", "Tₐ 1.2, F_fk 3 N"),
        ("peak |x_r| 5 mm", "peak |xᵣ| 5 mm"),
        ("k_x 7500 N/m, f_0 1.6 Hz, v_s 0.1 m/s", "kₓ 7500 N/m, f₀ 1.6 Hz, vₛ 0.1 m/s"),
        ("x_r_min -1 mm, x_dd_peak", "x_r_min -1 mm, x_dd_peak"),
    ],
)
def test_only_whole_words_are_typeset_as_symbols(text, typeset):
    assert wording.typeset(text) == typeset


@pytest.mark.parametrize(
    ("name", "greatest", "symbol"),
    [
        ("T_a", 2.0, "Tₐ [–]"),
        ("x_r_peak", 0.02, "peak |xᵣ| [mm]"),
        ("x_r_rms", 0.02, "x_r_rms [mm]"),
        ("stuck_share", 0.5, "stuck [%]"),
        ("VDV", 2.0, "VDV [m/s^1.75]"),
    ],
)
def test_a_metric_is_drawn_with_its_symbol_and_shown_unit(name, greatest, symbol):
    assert plotted(name, greatest).symbol == symbol
