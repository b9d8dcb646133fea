"""The pictures of sweeps of very many cases, drawn of few: bands, maps and their axes."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from drysim.plots import sweep as sweep_plots
from drysim.plots.style import T_A, T_X, peak
from drysim.plots.sweep import draw_transmissibility
from drysim.scenario.load import load
from drysim.study.rows import FAILED, batches_of
from drysim.study.sweep import sweep
from grids import axes as axes_of
from grids import spoil
from grids import sweep as stand_in

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
def table(tmp_path):
    """Give a function that computes the table of a sweep block."""

    def swept(block, seat=SEAT):
        file = tmp_path / "seat.yaml"
        file.write_text(f"{seat}sweep: {block}\n")
        return sweep(load(file))

    return swept


def band(panel, words):
    """Give the lower and upper ends of a band, by x."""
    (found,) = [one for one in panel.collections if one.get_label() == words]
    ends = {}
    for x, y in found.get_paths()[0].vertices:
        low, high = ends.get(x, (np.inf, -np.inf))
        ends[x] = min(low, y), max(high, y)
    return [ends[x] for x in sorted(ends)]


def line(panel, words):
    """Give the curve of a label."""
    (found,) = [one for one in panel.lines if one.get_label() == words]
    return found.get_xdata(), found.get_ydata()


def mesh(panel):
    """Give the map of a panel."""
    (found,) = [one for one in panel.collections if hasattr(one, "get_coordinates")]
    return found


def test_bands_lie_within_each_other_around_the_median(table):
    bands, *_ = sweep_plots.draw_many(table(GRID), BOTH).axes
    outer, inner = band(bands, "90 % of the cases"), band(bands, "half of them")
    x, median = line(bands, "median")
    assert x.tolist() == [1, 2, 4, 8]
    for (low, high), (first, third), middle in zip(outer, inner, median, strict=True):
        assert 0 < low <= first <= middle <= third <= high
    assert line(bands, "median without dry friction")[1][1] > median[1]


def test_axes_of_many_cases_are_named_and_share_their_range(table):
    figure = sweep_plots.draw_many(table(GRID), BOTH)
    bands, mapped = figure.axes[0], figure.axes[1]
    assert mapped.get_xlabel() == "frequency $f$ [Hz]"
    assert mapped.get_ylabel() == "kinetic friction force $F_{fk}$ [N]"
    assert bands.get_xlabel() == ""
    # Whole cells, those of the least and the greatest value, too.
    assert bands.get_xlim() == mapped.get_xlim() == (0.5, 10)
    assert mapped.get_ylim() == (0, 60)
    assert bands.get_ylim()[0] == 0


def test_colours_of_a_map_reach_from_its_least_to_its_greatest_mean(table):
    swept = table(GRID)
    figure = sweep_plots.draw_many(swept, BOTH)
    known = [row.metrics["T_x"] for row in swept.of("stick-slip")]
    found = mesh(figure.axes[1])
    assert found.get_clim() == pytest.approx((min(known), max(known)))
    values = found.get_array().reshape(3, 4)
    assert values.ravel().tolist() == pytest.approx(known)


def test_cells_of_a_logarithmic_map_are_even_in_its_scale(table):
    forces = "friction.kinetic: {from: 1, to: 45, count: 10}"
    block = f"{{excitation.frequency: {{from: 0.1, to: 100, count: 7, scale: log}}, {forces}}}"
    mapped = sweep_plots.draw_many(table(block), BOTH).axes[1]
    assert (mapped.get_xscale(), mapped.get_yscale()) == ("log", "log")
    x = mesh(mapped).get_coordinates()[0, :, 0]
    assert np.diff(np.log(x)).tolist() == pytest.approx([np.log(10) / 2] * 7)
    # An axis of equal steps does not reach down to zero, where no case is.
    assert 0.4 < mapped.get_ylim()[0] < 1


def test_a_coefficient_of_friction_is_not_called_a_force(table):
    block = "{excitation.frequency: [1, 2], friction.mu_kinetic: [0.01, 0.02]}"
    swept = table(block, SEAT.replace("kinetic: 15", "mu_kinetic: 0.02"))
    assert sweep_plots.draw_many(swept, BOTH).axes[1].get_ylabel() == "mu kinetic $\\mu_k$ [–]"


def test_sample_is_drawn_over_its_frequency_with_a_map_of_its_mass(table):
    swept = table(SAMPLE)
    figure = draw_transmissibility(swept)
    bands, mapped = figure.axes[0], figure.axes[1]
    assert mapped.get_ylabel() == "mass $m$ [kg]"
    # The picture reaches as far as the sample does, its curves and its cells, too.
    x, median = line(bands, "median")
    assert bands.get_xlim() == mapped.get_xlim() == (x[0], x[-1]) == (0.5, 10)
    assert median[0] == median[1]
    counts = sweep_plots.Scatter("T_a", sweep_plots.Bins.of(swept.axes[0]), None)
    sweep_plots.gathered(batches_of(swept.rows), "stick-slip", [counts])
    assert counts.counts.sum() == 60
    # White where no case is: the map is masked there and nowhere else.
    masked = np.ma.getmaskarray(mesh(mapped).get_array())
    assert 0 < np.count_nonzero(~masked) <= 60


def test_stroke_of_many_cases_is_drawn_beneath_its_limit(table):
    figure = sweep_plots.draw_many(table(GRID), [peak(0.01)])
    assert line(figure.axes[0], "stroke limit 25 mm")[1] == [25, 25]
    assert figure.axes[0].get_ylim()[1] >= 25


def test_numbers_beside_a_map_are_within_the_picture(table):
    small = SEAT.replace("rms: 1.0", "rms: 1e-5").replace("15}", "15e-5}")
    rms = "{excitation.frequency: [1, 1.4, 4, 8], excitation.rms: [0.5e-5, 0.75e-5, 1e-5]}"
    figure = sweep_plots.draw_many(table(rms, small), [peak(2e-7)])
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
    figure = sweep_plots.draw_many(table(block), BOTH)
    figure.draw_without_rendering()
    left, right = figure.axes[1], figure.axes[3]
    assert left.get_ylabel() == right.get_ylabel() == "stiffness $k_x$ [N/m]"
    numbers = [one for one in right.get_yticklabels() if one.get_text()]
    assert [one.get_text() for one in numbers] == [
        one.get_text() for one in left.get_yticklabels()
    ]
    (bar,) = left.child_axes
    end = max(one.get_window_extent().x1 for one in bar.get_yticklabels())
    assert end < right.yaxis.label.get_window_extent().x0


def test_one_case_and_one_key_make_a_picture(table):
    single = sweep_plots.draw_many(table("{friction.kinetic: [15]}"), BOTH)
    assert line(single.axes[0], "median")[1][0] == pytest.approx(1.3, abs=0.1)
    assert len(sweep_plots.draw_many(table("{friction.kinetic: [5, 15]}"), BOTH).axes) == 2


def test_cases_without_numbers_leave_an_empty_panel():
    lost = spoil(stand_in(*axes_of(frequency=[1, 2], force=[5, 15])), FAILED, *range(8))
    figure = sweep_plots.draw_many(lost, BOTH)
    assert figure.axes[0].get_ylim()[0] == 0
    assert np.isnan(line(figure.axes[0], "median")[1]).all()


def test_quantiles_of_a_picture_are_those_of_the_cases():
    values = np.random.Generator(np.random.PCG64(2)).lognormal(size=5000)
    bins = sweep_plots.Bins.of(axes_of(frequency=[1, 2])[0])
    one = sweep_plots.Scatter("T_a", bins, None)

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
    assert by_difference.fences[[0, -1]].tolist() == pytest.approx([0.5, 60])
    assert np.ptp(np.diff(by_difference.middles)) == pytest.approx(0, abs=1e-9)
    assert by_ratio.fences[[0, -1]].tolist() == pytest.approx([10, 500])
    assert (by_difference.even_in_ratio, by_ratio.even_in_ratio) == (False, True)


def test_values_listed_in_any_order_have_bins_from_the_least_to_the_greatest():
    values = np.random.Generator(np.random.PCG64(3)).permutation(np.linspace(1, 6, 151))
    bins = sweep_plots.Bins.of(axes_of(frequency=values)[0])
    assert bins.fences[[0, -1]].tolist() == [1, 6]
    assert np.all(np.diff(bins.fences) > 0)


def test_bins_between_which_a_range_has_no_value_are_one():
    values = np.linspace(0.5, 10, 210)
    bins = sweep_plots.Bins.of(axes_of(frequency=values)[0])
    assert bins.even_in_ratio
    assert bins.fences[[0, -1]].tolist() == [0.5, 10]
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
