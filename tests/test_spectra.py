"""Spectra: response PSD = |T|² G without friction, and what makes an estimate no estimate."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from law_scenes import PAPER, REST
from seat import dotted

import drysim
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Samples, Sines
from drysim.metrics.comfort import averaging_gain, step_means, weighting_gain
from drysim.metrics.spectra import BANDS, spectra, third_octaves, viscous_transmissibility
from drysim.plots.spectra import draw
from drysim.study.preparation import prepare
from drysim.study.welch import segment_length

FLAT = {"kind": "psd", "points": [[0.5, 1], [20, 1]], "duration": 400, "seed": 3}
ASKED = {"settle": 5, "spectra": True, "segment": 10}


def outcome_of(seat, **changes):
    """Run the seat on flat noise with blocks replaced."""
    words = {"excitation": FLAT, "measure": ASKED, "solver.step": 2e-3}
    return drysim.run(drysim.load(seat, words | dotted(changes)))


def inside(found):
    """Return the lines inside the band, where no window leaks over its edges."""
    return (found.f > 1) & (found.f < 18)


def test_psd_and_h1_without_friction_are_those_of_the_transmissibility(seat):
    outcome = outcome_of(seat, friction=None)
    found, (m, k_x, b) = outcome.spectra, outcome.response.plant
    at = inside(found)
    T = viscous_transmissibility(outcome.response.plant, found.f)[at]
    scatter = 1 / np.sqrt(0.95 * found.segments)
    ratio = found.G_x[at] / (T**2 * found.G_u[at])
    # The same noise is in both, so only leakage of the window is left of the scatter.
    assert ratio == pytest.approx(1.0, abs=0.05)
    off = found.G_x[at] / T**2 - 1.0  # the definition: 1 (m/s²)²/Hz
    assert np.abs(off).max() < 4 * scatter
    assert abs(off.mean()) < 0.02
    s = 2j * np.pi * found.f[at]
    T = (k_x + b * s) / (m * s * s + b * s + k_x)
    assert np.abs(found.H1[at] / T - 1).max() < 0.02
    assert found.coherence[at].min() > 0.985


def test_friction_takes_coherence_away(seat):
    found = outcome_of(seat, friction__kinetic=200).spectra
    assert found.coherence[inside(found)].mean() < 0.9


def test_spectra_hold_the_mean_square(seat):
    outcome = outcome_of(seat)
    found = outcome.spectra
    for G, name in ((found.G_u, "a_u"), (found.G_x, "a_x")):
        area = float(G.sum()) / found.segment
        assert area == pytest.approx(outcome.metrics[name] ** 2, rel=0.03)


def test_held_mass_moves_as_its_base(seat):
    found = outcome_of(seat, friction={"law": "coulomb", "kinetic": 5000}).spectra
    assert found.G_x.tolist() == found.G_u.tolist()
    assert np.abs(found.H1 - 1).max() < 1e-12


def test_scaling_motion_and_friction_scales_the_psd_and_leaves_h1(seat):
    once, twice = (
        outcome_of(
            seat, excitation=FLAT | {"rms": rms, "duration": 40}, friction__kinetic=20 * rms
        ).spectra
        for rms in (2.0, 4.0)
    )
    assert twice.G_x == pytest.approx(4 * once.G_x, rel=1e-6)
    at = inside(once)
    assert twice.H1[at] == pytest.approx(once.H1[at], rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "segment"),
    [
        # A record of minutes: 8/f_0, but 5 s at least, and 5 s without a spring.
        ({}, 8 * 2 * np.pi * 0.1),
        ({"oscillator.stiffness": 75e3}, 5.0),
        ({"oscillator.stiffness": 0}, 5.0),
        # A short one: an eighth of the window.
        ({"excitation.duration": 25}, 2.5),
        # Where nothing rubs, three noise bandwidths in the width of the resonance.
        ({"friction": None, "oscillator.damping": 50}, 3 * 1.5 * 2 * np.pi * 75 / 50),
        ({"friction": None}, 8 * 2 * np.pi * 0.1),
        # What a scenario asks for stays.
        ({"measure.segment": 40}, 40.0),
    ],
)
def test_long_window_gives_more_averages_rather_than_more_lines(seat, changes, segment):
    words = {"excitation": FLAT, "measure": {"settle": 5, "spectra": True}} | changes
    case = prepare(drysim.load(seat, words))
    assert segment_length(case) == pytest.approx(segment, rel=1e-12)


def test_summary_states_length_and_number_of_the_segments(drysim, seat):
    done = drysim(
        "run", seat, "--set", f"excitation={FLAT}", "--set", "measure={spectra: true}"
    )
    assert "spectra     158 segments of 5.03 s, half overlapping" in done.out


def test_coherence_has_a_linear_panel_of_its_own(seat):
    figure = draw(outcome_of(seat))
    left, above, below = figure.axes
    assert [axes.get_title("left") for axes in figure.axes[1:]] == [
        "transmissibility H1 [–]",
        "coherence [–]",
    ]
    assert (below.get_yscale(), below.get_ylim()) == ("linear", (0.0, 1.0))
    assert above.get_yscale() == left.get_yscale() == "log"
    assert len(below.lines) == 1
    assert left.get_xlim() == above.get_xlim() == below.get_xlim()


def test_too_few_segments_are_a_warning(seat):
    short = outcome_of(seat, excitation=FLAT | {"duration": 40})
    assert short.spectra.segments == 6
    assert "few-segments" in {warning.slug for warning in short.warnings}


def test_lines_wider_than_the_resonance_are_a_warning(seat):
    wide = outcome_of(seat, friction=None, oscillator__damping=10)
    (warning,) = (one for one in wide.warnings if one.slug == "coarse-spectra")
    assert warning.numbers["width"] == pytest.approx(10 / (2 * np.pi * 75))


@pytest.mark.parametrize(
    ("changes", "key", "sentence"),
    [
        ({"measure.segment": 500}, "measure.segment", "longer than the window of 395 s"),
        ({"measure.segment": 0.01}, "measure.segment", "at least 0.08 s, 16 steps"),
        (
            {"measure.spectra": False},
            "measure.segment",
            "is that of spectra, which `spectra: false` turns off",
        ),
        (
            {"excitation": {"kind": "harmonic", "frequency": 1, "rms": 1}},
            "measure.spectra",
            "does not apply to harmonic",
        ),
    ],
)
def test_spectra_that_cannot_be_had_are_a_fault(seat, changes, key, sentence):
    words = {"excitation": FLAT, "measure": ASKED, "solver.step": 5e-3} | changes
    if "excitation" in changes:
        words["measure"] = {"spectra": True}
    with pytest.raises(drysim.ScenarioError) as fault:
        drysim.run(drysim.load(seat, words))
    (problem,) = fault.value.problems
    assert (problem.key, sentence in problem.sentence) == (key, True)


def test_picture_says_where_it_draws_h1_if_that_is_not_everywhere(seat):
    made = outcome_of(seat)
    white = made.spectra._replace(G_u=np.ones_like(made.spectra.f))
    for one, cut in ((made, True), (replace(made, spectra=white), False)):
        told = " ".join(text.get_text() for text in draw(one).texts)
        assert ("H1 where the base PSD is at least 0.1 % of its peak" in told) is cut


def test_files_of_spectra_are_written_when_asked_for(drysim, seat):
    words = [
        "--set", "excitation={kind: standard, class: EM6, duration: 20, seed: 1}",
        "--set", "friction=null", "--out", "out",
    ]  # fmt: skip
    drysim("run", seat, *words, "--set", "measure={spectra: true}")
    lines = (seat.parent / "out/spectra.csv").read_text().splitlines()
    assert lines[0] == (
        "f [Hz],G_u [(m/s2)2/Hz],G_x [(m/s2)2/Hz],H1 [-],phase [rad],coherence [-]"
    )
    assert float(lines[1].split(",")[0]) == pytest.approx(1 / 2.5, rel=1e-3)
    told = json.loads((seat.parent / "out/drysim.json").read_text())["numerics"]["spectra"]
    assert (told["segment"], told["segments"]) == (2.5, 15)
    assert (seat.parent / "out/spectra.png").stat().st_size > 10_000
    drysim("run", seat, *words, "--set", "measure={}")
    assert not list((seat.parent / "out").glob("spectra*"))


def white(n, dt):
    """Return white noise of a fixed seed as base motion."""
    return Samples(np.random.default_rng(5).standard_normal(n), dt)


def test_squares_of_the_bands_add_up_to_the_mean_square():
    n, dt = 40_000, 2.5e-3
    motion = white(n + 1, dt)
    made = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), motion, REST, dt)
    bands = third_octaves(made, (0.0, n * dt), ("Wk", 1.0))
    for band, series in zip(bands[:2], step_means(made), strict=True):
        found = np.fft.rfft(series)[1 : n // 2] / n
        f = np.arange(1, n // 2) / (n * dt)
        inside = (f >= 10**-0.35) & (f < 10**1.95)
        lines = np.abs(found / averaging_gain(f, dt)) ** 2
        assert np.sum(band**2) == pytest.approx(2.0 * lines[inside].sum(), rel=1e-12)


def test_sine_is_in_the_band_around_it_with_its_weighted_rms():
    A, f, dt = 1.3, 8.0, 1e-3
    motion = Sines((A,), (f,), (0.4,))
    made = StickSlip().solve(PAPER, CoulombLaw(1e5, 1e5), motion, REST, dt, 10.0)
    bands = third_octaves(made, (0.0, 10.0), ("Wd", 1.4))
    at = BANDS.index(8.0)
    weight = 1.4 * abs(weighting_gain("Wd", np.array([f]))[0])
    for series, gain in zip(bands, (1.0, 1.0, weight, weight), strict=True):
        assert series[at] == pytest.approx(gain * A / math.sqrt(2.0), rel=1e-9)
        assert np.nansum(np.delete(series, at)) < 1e-9


def interpolation_gain(f, dt):
    """Return the gain of straight lines between samples, as means over the steps see them."""
    x = math.pi * np.asarray(f) * dt
    return x / np.tan(x)


def bands_of_samples(u_dd, dt, gain=lambda f: 1.0):
    """Return the RMS in bands of samples without their mean, by another way: line by line."""
    lines = np.fft.rfft(u_dd - u_dd.mean()) / len(u_dd)
    f = np.arange(len(lines)) / (len(u_dd) * dt)
    found = []
    for i in range(len(BANDS)):
        low, high = (10.0 ** ((i - 3 + side) / 10.0) for side in (-0.5, 0.5))
        inside = (f >= low) & (f < high)
        found.append(math.sqrt(2.0 * np.sum(np.abs(lines * gain(f))[inside] ** 2)))
    return np.array(found)


def periodic_chirp(n, dt):
    """Return a chirp with an offset that ends as it begins."""
    t = np.arange(n) * dt
    rise = np.sin(np.pi * np.arange(n) / n) ** 2
    return 3.0 + 2.0 * rise * np.sin(2.0 * np.pi * (0.5 * t + 0.5 * 99.0 / (n * dt) * t * t))


def periodic_noise(n, dt):
    """Return periodic noise between 1 and 90 Hz with an offset."""
    rng, f = np.random.default_rng(8), np.fft.rfftfreq(n, dt)
    lines = rng.normal(size=len(f)) + 1j * rng.normal(size=len(f))
    return -1.0 + 40.0 * np.fft.irfft(np.where((f > 1.0) & (f < 90.0), lines, 0.0), n)


@pytest.mark.parametrize("signal", [periodic_chirp, periodic_noise])
@pytest.mark.parametrize("dt", [2e-3, 1e-3])
def test_bands_of_the_base_are_those_of_the_samples_times_the_gain_of_straight_lines(
    signal, dt
):
    n = round(20.0 / dt)
    u_dd = signal(n, dt)
    motion = Samples(np.append(u_dd, u_dd[0]), dt)
    made = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), motion, REST, dt)
    bands = third_octaves(made, (0.0, n * dt), None)

    def gain(f):
        return np.where(f > 0.0, interpolation_gain(np.maximum(f, 1e-9), dt), 1.0)

    expected, samples = bands_of_samples(u_dd, dt, gain), bands_of_samples(u_dd, dt)
    assert bands.a_u == pytest.approx(expected, rel=1e-9, abs=1e-12)
    # What own code of the samples finds more is what the manual says: 9.4 % at 80 Hz, 2 ms.
    at = BANDS.index(80.0)
    more = samples[at] / bands.a_u[at] - 1.0
    assert more == pytest.approx(1.0 / interpolation_gain(80.0, dt) - 1.0, rel=0.15)


def test_an_offset_is_in_no_band_and_in_no_line():
    n, dt = 4000, 5e-3
    u_dd = periodic_noise(n, dt)
    found = []
    for shift in (0.0, 50.0):
        motion = Samples(np.append(u_dd, u_dd[0]) + shift, dt)
        made = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), motion, REST, dt)
        bands, lines = third_octaves(made, (0.0, n * dt), None), spectra(made, (0.0, 20.0), 2.0)
        found.append((bands.a_u, lines.G_u))
    (bands, lines), (shifted, other) = found
    assert shifted == pytest.approx(bands, rel=1e-9, abs=1e-12, nan_ok=True)
    assert other == pytest.approx(lines, rel=1e-6, abs=1e-9)


def test_psd_of_the_base_is_welch_of_the_samples_times_the_gain_of_straight_lines():
    from scipy import signal

    n, dt, segment = 40_000, 2e-3, 4.0
    u_dd = periodic_noise(n, dt)
    motion = Samples(np.append(u_dd, u_dd[0]), dt)
    made = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), motion, REST, dt)
    found, per = spectra(made, (0.0, n * dt), segment), round(segment / dt)
    f, G = signal.welch(u_dd - u_dd.mean(), 1.0 / dt, "hann", per, per // 2, detrend=False)
    gain = interpolation_gain(f[1:], dt) ** 2
    at = (found.f > 2.0) & (found.f < 88.0)
    # Two samples of a mean see the window at slightly different places.
    assert (found.G_u / (G[1:] * gain))[at] == pytest.approx(1.0, abs=0.02)
    assert np.mean((found.G_u / (G[1:] * gain))[at]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("f", [1.0, 4.0, 16.0, 63.0])
def test_a_sine_passes_to_the_band_of_the_mass_as_the_closed_form_says(f):
    dt, A, (m, k_x, b) = 1e-3, 1.7, PAPER
    t = np.arange(round(30.0 / dt) + 1) * dt
    motion = Samples(5.0 + A * np.sin(2.0 * np.pi * f * t + 0.3), dt)
    made = StickSlip().solve(PAPER, CoulombLaw(0.0, 0.0), motion, REST, dt)
    bands, at = third_octaves(made, (20.0, 30.0), None), BANDS.index(f)
    level, x = A / math.sqrt(2.0), math.pi * f * dt
    assert bands.a_u[at] == pytest.approx(level * x / math.tan(x), rel=1e-9)
    s = 2j * math.pi * f
    T = abs((k_x + b * s) / (m * s * s + b * s + k_x))
    # The gain of straight lines is sinc²; folding of images is at most x⁴/15 of the base.
    assert bands.a_x[at] == pytest.approx(T * level * np.sinc(f * dt) ** 2, abs=level * x**4)


def test_bands_that_the_window_or_the_step_cannot_resolve_are_unknown():
    made = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), white(1001, 0.01), REST, 0.01)
    bands = third_octaves(made, (0.0, 5.0), None)
    unknown = np.isnan(bands.a_u)
    # Bands below 0.87 Hz are narrower than 1/(5 s); that of 50 Hz is cut by the step.
    assert [f for f, lost in zip(BANDS, unknown, strict=True) if lost] == [
        0.5, 0.63, 0.8, 50.0, 63.0, 80.0,
    ]  # fmt: skip
    assert np.array_equal(unknown, np.isnan(bands.a_x))
    assert bands.a_w is None


def test_files_of_bands_are_written_when_asked_for(drysim, seat):
    words = [
        "--set", "excitation={kind: standard, class: EM6, duration: 20, seed: 1}",
        "--out", "out",
    ]  # fmt: skip
    for more, columns in (("", 3), (", direction: vertical", 5)):
        drysim(
            "run", seat, *words, "--set", f"measure={{spectra: {{bands: third-octave}}{more}}}"
        )
        lines = (seat.parent / "out/bands.csv").read_text().splitlines()
        assert lines[0].split(",") == [
            "f [Hz]", "a_u [m/s2]", "a_x [m/s2]", "a_wu [m/s2]", "a_w [m/s2]",
        ][:columns]  # fmt: skip
        assert [float(line.split(",")[0]) for line in lines[1:]] == list(BANDS)
        assert (seat.parent / "out/bands.png").stat().st_size > 10_000
    drysim("run", seat, *words, "--set", "measure={spectra: true}")
    assert not list((seat.parent / "out").glob("bands*"))
