"""The pictures of a fit: what is drawn, for good and bad fits."""

from __future__ import annotations

from dataclasses import replace

import golden
import numpy as np
import pytest
from golden import GALLERY

import drysim
from drysim.plots.fit import draw_fit, draw_profiles, measured_force, shown_part
from drysim.plots.style import save_picture
from drysim.study.fit_profiles import CHI_SQUARE_95

NAMES = ("fit-seat", "fit-decay", "fit-rig")


def result_of(name):
    """Return the fit of a scenario of the gallery."""
    return golden.fitted(GALLERY / f"{name}.yaml")


@pytest.fixture
def seat():
    return result_of("fit-seat")


@pytest.fixture
def decay():
    return result_of("fit-decay")


def undetermined(result, at=0):
    """Return a result of which one parameter is not determined."""
    words = "only the ratios of oscillator.stiffness and oscillator.damping follow; " * 3
    nothing = dict.fromkeys(("deviation", "low", "high", "profile_low", "profile_high"), None)
    parameters = list(result.parameters)
    parameters[at] = parameters[at]._replace(**nothing, note=words)
    key = parameters[at].key
    kept = tuple(one for one in result.profiles if one.key != key)
    return replace(result, parameters=tuple(parameters), profiles=kept)


def with_spike(result, size):
    """Return a result with one wrong sample in its first channel."""
    measured, name = result.measurement, result.channels[0].name
    values = measured.channels[name].copy()
    values[100] += size
    channels = measured.channels | {name: values}
    return replace(result, measurement=measured._replace(channels=channels))


def titles(figure):
    """Return the titles of the panels."""
    return [axes.get_title("left") for axes in figure.axes]


def labelled(axes, label):
    """Return the line with a label that has points, or None."""
    lines = axes.lines
    found = [i for i, line in enumerate(lines) if line.get_label() == label]
    line = lines[found[0]]
    return line if len(line.get_xdata()) else lines[found[0] - 1]


SCENES = {
    **{name: lambda name=name: result_of(name) for name in NAMES},
    "not determined": lambda: undetermined(result_of("fit-decay")),
    "a wrong sample": lambda: with_spike(result_of("fit-seat"), 1e3),
    "without noise": lambda: without_noise(result_of("fit-decay")),
}


def without_noise(result):
    """Return a result whose intervals are rounding."""
    tiny = tuple(one._replace(deviation=1e-14 * one.value) for one in result.parameters)
    channels = tuple(one._replace(noise=1e-16) for one in result.channels)
    measured = result.measurement._replace(channels=dict(result.prediction.channels))
    return replace(result, parameters=tiny, channels=channels, measurement=measured)


@pytest.mark.parametrize("draw", [draw_fit, draw_profiles])
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_fit_is_drawn_without_a_warning_and_within_the_picture(scene, draw, tmp_path):
    result, drawn = scene(), []
    save_picture(lambda: drawn.append(draw(result)) or drawn[0], tmp_path / "fit.png")
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
    (figure,) = drawn
    texts = [axes._left_title for axes in figure.axes] + figure.texts
    texts += [text for legend in figure.legends for text in legend.texts]
    texts += [text for axes in figure.axes for text in axes.texts]
    for text in texts:
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.x1


def test_plot_of_a_fit_is_its_picture(decay):
    assert titles(drysim.plot(decay)) == titles(draw_fit(decay)) == titles(decay.plot())


def test_long_record_has_an_overview_and_a_panel_and_residuals_for_each_channel(seat):
    assert [title.partition(",")[0].partition(" [")[0] for title in titles(draw_fit(seat))] == [
        "whole record: ẍ",
        "acceleration of the mass ẍ",
        "relative displacement xᵣ",
        "residual of ẍ",
        "residual of xᵣ",
        "residual / noise",
        "friction force",
    ]


def test_short_record_is_drawn_whole(decay):
    assert len(draw_fit(decay).axes) == 4
    assert shown_part(decay) == slice(0, len(decay.measurement.t))


def test_shown_interval_is_fitted_and_has_the_largest_motion(seat):
    part = shown_part(seat)
    assert part.stop <= len(seat.selected)
    x_dd = seat.measurement.channels["x_dd"]
    assert np.std(x_dd[part]) > np.std(x_dd)


def test_measured_and_fitted_motion_are_those_of_the_result(seat):
    panel = draw_fit(seat).axes[2]
    part = shown_part(seat)
    for label, channels in (("measured", seat.measurement), ("fitted", seat.prediction)):
        wanted = 1e3 * channels.channels["x_r"][part]
        assert labelled(panel, label).get_ydata() == pytest.approx(wanted)


def test_held_out_part_is_shaded_where_there_is_one(seat, decay):
    for panel in draw_fit(seat).axes[3:5]:
        (patch,) = [one for one in panel.patches if one.get_label() == "held out"]
        begin, end = patch.get_x(), patch.get_x() + patch.get_width()
        assert (begin, end) == (seat.fitted_end, seat.measurement.t[-1])
    for panel in draw_fit(decay).axes:
        assert not [one for one in panel.patches if one.get_label() == "held out"]


def test_stick_phases_are_shaded(decay):
    (shading,) = draw_fit(decay).axes[0].collections
    stuck = decay.measurement.t[decay.prediction.mode == 0]
    (path,) = shading.get_paths()
    assert path.get_extents().intervalx == pytest.approx([stuck[0], stuck[-1]])


def test_residuals_beyond_the_axis_stand_at_its_end_and_are_counted(seat):
    large, wrong = (draw_fit(with_spike(seat, size)).axes[3] for size in (1e2, 1e3))
    assert wrong.get_ylim()[1] == pytest.approx(large.get_ylim()[1], rel=0.01)
    assert "1 beyond the axis" in wrong.get_title("left")
    drawn = np.concatenate([line.get_ydata() for line in wrong.lines[:6]])
    assert np.abs(drawn).max() <= wrong.get_ylim()[1]


def test_measured_friction_force_is_that_of_the_force_balance(seat):
    m, k_x, b = seat.scenario.oscillator.plant()
    fitted = seat.prediction.channels
    sliding = seat.prediction.mode != 0
    balance = -m * seat.measurement.channels["x_dd"] - k_x * fitted["x_r"] - b * fitted["v_r"]
    assert measured_force(seat)[sliding] == pytest.approx(balance[sliding], abs=1e-6)


def test_friction_force_follows_from_a_displacement_alone(decay):
    sliding = (decay.prediction.mode != 0) & (np.abs(decay.prediction.channels["v_r"]) > 0.05)
    force = np.abs(measured_force(decay)[sliding])
    assert np.median(force) == pytest.approx(1.2, rel=0.05)
    assert np.std(force) < 0.3


def test_measured_friction_force_of_a_rig_is_the_record():
    rig = result_of("fit-rig")
    assert np.array_equal(measured_force(rig), rig.measurement.channels["F_f"])


def test_law_that_is_wrong_shows_in_the_mean_residual_over_velocity():
    rig, seat = result_of("fit-rig"), result_of("fit-seat")
    of_rig = labelled(draw_fit(rig).axes[-2], "mean residual").get_ydata()
    of_seat = labelled(draw_fit(seat).axes[-2], "mean residual of ẍ").get_ydata()
    assert np.abs(of_rig).max() > 1.0 > np.abs(of_seat).max()


def test_profile_reaches_the_limit_at_the_ends_of_the_interval(seat):
    for one, axes in zip(seat.parameters, draw_profiles(seat).axes, strict=True):
        assert axes.get_title("left").startswith(one.key)
        assert axes.get_xlabel().startswith("95 %: ")
        x, y = labelled(axes, "profile").get_data()
        if one.key != "friction.static_ratio":  # of which a change jumps past a sample
            for end in (one.profile_low, one.profile_high):
                assert np.interp(end, x, y) == pytest.approx(CHI_SQUARE_95, rel=0.1)
        x, y = labelled(axes, "parabola of the linear interval").get_data()
        assert np.interp(one.high, x, y) == pytest.approx(CHI_SQUARE_95, rel=1e-3)


def test_profile_that_is_not_known_is_a_note(decay):
    *others, first = draw_profiles(undetermined(decay)).axes
    assert first.texts[0].get_text().startswith("not determined: only the ratios of")
    assert "\n" in first.texts[0].get_text()
    assert not first.lines
    assert all(panel.lines for panel in others)
    (text,) = draw_profiles(without_noise(decay)).axes[0].texts
    assert text.get_text() == "exact to rounding: the record has no noise"


def test_heading_has_the_values_with_their_intervals_and_the_errors(seat):
    title, values, errors = [text.get_text() for text in draw_fit(seat).texts]
    assert title == "fit-seat"
    assert values.startswith("stiffness 4500.6 ± 3.5 N/m; damping 300.21 ± 0.56 N·s/m; kinetic")
    assert errors.startswith("fit error 4.79 %")
    assert "held out 4.7" in errors


def test_ends_of_an_interval_are_told_apart(decay):
    panel = draw_profiles(decay).axes[0]
    assert panel.get_title("left") == "oscillator.stiffness 900.036 ± 0.077 N/m"
    assert panel.get_xlabel() == "95 %: 899.9593 to 900.1134 N/m"


def test_open_interval_has_one_end(decay):
    first, *rest = decay.parameters
    opened = replace(decay, parameters=(first._replace(profile_low=None), *rest))
    assert draw_profiles(opened).axes[0].get_xlabel() == "95 %: at most 900.1134 N/m"


def test_fit_that_is_better_than_the_solution_is_within_the_picture(decay):
    first, *others = decay.profiles
    rise = first.rise.copy()
    rise[0] = -3.0
    lower = replace(decay, profiles=(first._replace(rise=rise), *others))
    panel = draw_profiles(lower).axes[0]
    assert panel.get_ylim()[0] < -3.0
    values, dots = labelled(panel, "fit with this value fixed").get_data()
    assert dots.tolist() == rise.tolist()
    assert np.interp(values, *labelled(panel, "profile").get_data()) == pytest.approx(rise)


def test_value_with_an_end_but_no_deviation_shows_its_end(decay):
    first, *others = decay.parameters
    open_below = first._replace(deviation=None, low=None, high=None, profile_low=None)
    figure = draw_profiles(replace(decay, parameters=(open_below, *others)))
    assert figure.axes[-1].texts[0].get_text().startswith("95 %: at most ")
