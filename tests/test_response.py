"""The picture of a run: events, loops, zoom, envelope, characteristic, what is left out."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from law_scenes import elastic_law
from outcomes import PAPER, SINE, STICKY, outcome, record
from shown import labelled, legend

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    BRISTLE,
    STRIBECK,
    CoulombLaw,
    DynamicLaw,
    EndStops,
    PiecewiseLaw,
    Sines,
    State,
    StrokeLimits,
)
from drysim.plots import style
from drysim.plots.response import (
    CROWDED_MARKERS,
    MASS_STYLE,
    THIN_LINEWIDTH,
    VIOLATION_STYLE,
    characteristic,
    curve_with_events,
    draw,
    envelope,
    excursions,
    mass_style,
    stuck_intervals,
    zoom_slice,
)

pytestmark = pytest.mark.usefixtures("place")


def test_events_stand_upright_in_the_friction_loop():
    made = outcome()
    drawn = curve_with_events(made.response, slice(None))
    inside = len(made.events) - 1
    assert len(drawn.t) == len(made.response.x_r) + 2 * inside
    assert np.all(np.diff(drawn.t) >= 0)
    steps = np.abs(np.diff(drawn.F_f)) > 40
    assert steps.any()
    assert np.all(np.diff(drawn.x_r)[steps] == 0)
    assert np.abs(drawn.F_f).max() == pytest.approx(54.0)


def test_acceleration_before_and_after_an_event_differs_by_the_force():
    made = outcome(CoulombLaw(15.0, 15.0))
    drawn = curve_with_events(made.response, slice(None))
    jump = np.abs(np.diff(drawn.x_dd)).max()
    assert jump == pytest.approx(2 * 15.0 / 75.0, rel=1e-9)


@pytest.mark.parametrize("multiple", [None, 1])
def test_loop_of_a_steady_orbit_is_closed(multiple):
    made = outcome()
    numerics = replace(made.response.numerics, period_multiple=multiple)
    steady = replace(made, response=replace(made.response, numerics=numerics))
    *_, loop, over_velocity = (panel.lines[0].get_xydata() for panel in draw(steady).axes)
    assert (over_velocity[0] == over_velocity[-1]).all() == (multiple is not None)
    assert (loop[0] == loop[-1]).all() == (multiple is not None)


def test_motion_is_drawn_to_its_end_where_steps_are_longer_than_all_of_it():
    response = StickSlip().solve(PAPER, STICKY, SINE, State(0.0, 0.1), 5.0, 1.0)
    figure = draw(replace(outcome(), response=response))
    above, below, *_ = figure.axes
    intervals = stuck_intervals(response, 0.0, 1.0)
    assert above.get_xlim() == (0.0, 1.0)
    assert len(below.lines[0].get_xdata()) == 1 + 2 * (len(response.events) - 1) > 5
    for panel in (above, below):
        (shading,) = panel.collections
        shaded = [tuple(path.get_extents().intervalx) for path in shading.get_paths()]
        assert shaded == [(at, at + length) for at, length in intervals] != []


def test_stuck_stretches_end_with_the_next_slip():
    made = outcome()
    end = made.response.t[-1]
    stretches = stuck_intervals(made.response, 0.0, end)
    share = sum(length for _, length in stretches) / end
    assert share == pytest.approx(made.metrics["stuck_share"], rel=1e-9)
    assert stuck_intervals(outcome(CoulombLaw(0.0, 0.0)).response, 0.0, 1.0) == []


def test_zoom_holds_the_largest_stroke_and_fits_the_response():
    made = outcome(CoulombLaw(15.0, 15.0), record(9_000), None).response
    peak = np.abs(made.x_r)
    for settled in (0, 5_000, 8_999):
        part = zoom_slice(made, settled * made.dt)
        assert peak[part].max() >= peak[settled:].max()
        assert 0 <= part.start < part.stop <= len(made.x_r)


def test_envelope_holds_every_value():
    series = np.sin(np.arange(30_000) * 0.7)
    _, low, high = envelope(series.__getitem__, len(series))
    assert (low.min(), high.max()) == (series.min(), series.max())
    assert np.all(low <= high)


def test_excursions_are_found_at_their_largest():
    made = outcome(limit=0.005)
    peaks = excursions(made.response, StrokeLimits(0.005, 0.005))
    assert len(peaks) == made.metrics["violations"]
    t, x_r = np.array(peaks).T
    assert np.array_equal(made.response.x_r[np.rint(t / made.response.dt).astype(int)], x_r)
    assert np.all(np.abs(x_r) >= 0.005)


SCENES = {
    "steady": {},
    "stuck": {"law": CoulombLaw(500.0, 500.0), "limit": 0.025},
    "frictionless": {"law": CoulombLaw(0.0, 0.0)},
    "free": {"motion": Sines((), (), ()), "start": State(0.02, 0.0)},
    "at rest": {"motion": Sines((), (), ()), "limit": 0.025},
    "one step": {"duration": 2.5e-3},
    "violating": {"limit": 0.005},
    "unusual words": {"name": "$x_{ [bold] 日本\x1b[31m\n%s", "about": "$" * 500},
    "nothing about": {"about": ""},
    "settling": {"measure": SimpleNamespace(settle=0.5)},
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_picture_is_drawn_without_a_warning(scene, tmp_path):
    style.save_picture(lambda: draw(outcome(**scene)), tmp_path / "response.png")
    assert (tmp_path / "response.png").read_bytes().startswith(b"\x89PNG")


def test_long_record_gets_a_zoomed_view_and_every_axis_its_unit():
    figure = draw(outcome(CoulombLaw(15.0, 15.0), record(24_000), None, limit=0.01))
    assert len(figure.axes) == 6
    for panel in figure.axes:
        assert panel.get_title("left").endswith("]")
    below = [panel.get_xlabel() for panel in figure.axes if panel.get_xlabel()]
    assert len(below) == 4
    assert all("[" in label for label in below)
    shown = legend(figure)
    assert len(shown) == len(set(shown))
    assert {"mass ẍ", "base ü", "stroke limit ±10 mm"} <= set(shown)


@pytest.mark.parametrize("made", [outcome(), outcome(motion=record(24_000), duration=None)])
def test_mass_is_drawn_above_a_lighter_and_thinner_base(made):
    from matplotlib.colors import to_rgb

    above = draw(made).axes[-4]
    (mass,), (base,) = labelled(above, "mass ẍ"), labelled(above, "base ü")
    assert mass.get_zorder() > base.get_zorder()
    assert mass.get_linewidth() > base.get_linewidth()
    assert sum(to_rgb(mass.get_color())) < 0.5 * sum(to_rgb(base.get_color()))


def test_base_that_would_flatten_the_mass_is_cut_off():
    rough = np.diff(np.random.Generator(np.random.PCG64(1)).standard_normal(24_002), 2)
    smooth = np.cumsum(np.cumsum(rough)) / 100
    for samples in (rough, smooth):
        motion = record(24_000)._replace(u_dd=samples)
        made = outcome(CoulombLaw(1.0, 1.0), motion, duration=None)
        cut = made.metrics["T_a"] < 0.1
        assert cut is (samples is rough)
        for panel in draw(made).axes[0], draw(made).axes[2]:
            assert panel.get_title("left").endswith("(base cut off) [m/s²]") is cut
            if cut:
                peak = np.abs(made.response.x_dd).max()
                assert panel.get_ylim()[1] <= 4.0 * peak < np.abs(samples).max()


def test_line_with_very_many_turning_points_is_thin():
    rough = np.random.Generator(np.random.PCG64(1)).standard_normal(2_000)
    made = outcome(motion=record(2_000)._replace(u_dd=rough), duration=None)
    smooth = outcome()
    widths = [
        labelled(draw(one).axes[-4], "mass ẍ")[0].get_linewidth() for one in (made, smooth)
    ]
    assert widths == [THIN_LINEWIDTH, MASS_STYLE["linewidth"]]
    level = np.where(np.arange(4_000) % 2, 45.0, np.nextafter(45.0, 0.0))
    assert mass_style(np.append(level, -45.0)) == MASS_STYLE
    assert mass_style(level[:1]) == mass_style(np.array([np.nan])) == MASS_STYLE


def test_contact_that_is_a_spring_holds_while_the_mass_is_never_stuck():
    made = outcome(elastic_law(30.0, 20e3))
    assert made.metrics["stuck_share"] == 0.0
    assert {"no slip", "friction limit"} <= {*legend(draw(made))}
    assert {"stuck", "static limit"} <= {*legend(draw(outcome(CoulombLaw(45.0, 54.0))))}


LAWS = {
    "coulomb": (CoulombLaw(30.0, 45.0), 30.0, 45.0),
    "stribeck": (DynamicLaw(30.0, 45.0, STRIBECK, v_s=0.005), 30.0, 45.0),
    "lugre": (
        DynamicLaw(30.0, 45.0, BRISTLE, v_s=0.005, sigma_0=1e5, sigma_1=300.0, sigma_2=2.0),
        30.2,
        45.0,
    ),
    "jenkins": (elastic_law(30.0, 20e3), 30.0, 30.0),
}


@pytest.mark.parametrize(("law", "sliding", "at_rest"), LAWS.values(), ids=LAWS)
def test_characteristic_is_vertical_at_rest_and_the_sliding_force_beside_it(
    law, sliding, at_rest
):
    v, force = characteristic(law, -0.05, 0.1)
    assert (v[0], v[-1]) == (-0.05, 0.1)
    assert np.all(np.diff(v) >= 0)
    assert force[-1] == pytest.approx(sliding, rel=1e-12)
    still = force[v == 0.0]
    assert (still.min(), still.max()) == pytest.approx((-at_rest, at_rest), rel=1e-12)


def test_characteristic_has_the_forces_of_both_directions():
    law = PiecewiseLaw(30.0, 40.0, compression=(20.0, 25.0))
    v, force = characteristic(law, -1.0, 1.0)
    assert (force[0], force[-1]) == (-20.0, 30.0)
    assert (force[v == 0].min(), force[v == 0].max()) == (-25.0, 40.0)


def test_force_over_velocity_follows_the_characteristic_and_sticks_within_it():
    over_velocity = draw(outcome(CoulombLaw(30.0, 45.0))).axes[-1]
    assert over_velocity.get_xlabel() == "relative velocity vᵣ [mm/s]"
    v, force = over_velocity.lines[0].get_xydata().T
    slides = np.abs(v) > 1e-9
    assert np.allclose(force[slides], 30.0 * np.sign(v[slides]))
    assert 30.0 < np.abs(force[~slides]).max() <= 45.0


@pytest.mark.parametrize("law", [CoulombLaw(0.0, 0.0), CoulombLaw(500.0, 500.0)])
def test_without_friction_or_motion_no_force_is_drawn_over_the_velocity(law):
    labels = [panel.get_xlabel() for panel in draw(outcome(law)).axes]
    assert not any("velocity" in label for label in labels)
    assert len(labels) == 3


def test_varying_normal_force_has_no_characteristic():
    over_velocity = draw(outcome(CoulombLaw(30.0, 36.0, 0.5, 6.0, 0.0))).axes[-1]
    assert "velocity" in over_velocity.get_xlabel()
    assert len(over_velocity.lines) == 1


def test_impact_on_a_rigid_stop_leaves_a_gap_in_the_force_over_velocity():
    law = CoulombLaw(15.0, 15.0).as_piecewise()
    stops = EndStops(StrokeLimits(0.005, 0.005), e=0.5)
    over_velocity = draw(outcome(law._replace(stops=stops))).axes[-1]
    v = over_velocity.lines[0].get_xdata()
    assert np.isnan(v).any()


def test_framed_stretch_is_less_than_half_of_the_run():
    made = outcome(CoulombLaw(15.0, 15.0), record(1_000), None)
    part = zoom_slice(made.response, 0.0)
    assert 150 < part.stop - part.start < 500


def test_crosses_of_many_violations_are_small_enough_to_show_the_peaks():
    figure = draw(outcome(CoulombLaw(15.0, 15.0), record(24_000), None, limit=0.001))
    crosses = [
        line
        for axes in figure.axes
        for line in axes.lines
        if line.get_label() == "limit exceeded"
    ]
    sizes = {len(line.get_xdata()) > CROWDED_MARKERS: line.get_markersize() for line in crosses}
    assert sizes[True] < VIOLATION_STYLE["markersize"]


@pytest.mark.parametrize("name", ["W" * 90, "W" * 3_000, "a long name " * 12, "i" * 85, "seat"])
def test_name_fits_the_picture_and_is_never_left_out_whole(name):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = draw(outcome(name=name))
    title = figure.texts[0]
    assert title.get_window_extent(FigureCanvasAgg(figure).get_renderer()).x1 < figure.bbox.x1
    shown = title.get_text().removesuffix(" …")
    assert name.startswith(shown)
    assert len(shown) >= min(len(name), 40)


def test_picture_does_not_depend_on_somebody_s_matplotlibrc(tmp_path):
    import matplotlib

    made = outcome()
    style.save_picture(lambda: draw(made), tmp_path / "response.png")
    first = (tmp_path / "response.png").read_bytes()
    with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "red", "text.usetex": True}):
        style.save_picture(lambda: draw(made), tmp_path / "response.png")
    assert (tmp_path / "response.png").read_bytes() == first


def test_limit_far_beyond_the_motion_is_left_out():
    def drawn(limit):
        (legend,) = draw(outcome(limit=limit)).legends
        return any("stroke limit" in text.get_text() for text in legend.get_texts())

    assert drawn(0.012)
    assert not drawn(0.5)
