"""Records and runs that end before the response: the run goes on, or a warning says so."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import yaml
from seat import ranges

import drysim
from drysim.cli import main

PEAKS = (
    "x_r_peak", "x_r_max", "x_r_min", "x_dd_peak", "stroke_used", "stroke_suffices",
    "t_first_violation",
)  # fmt: skip
"""Metrics that a longer silence must not change."""

FRICTION = {
    "none": None,
    "coulomb": {"law": "coulomb", "kinetic": 4, "static_ratio": 1.3},
    "by direction": {"law": "coulomb", "kinetic": {"extension": 3, "compression": 6}},
    "elastic": {"law": "jenkins", "kinetic": 5, "tangential_stiffness": 4e4},
}
STOPS = {"stiffness": 5e4, "damping": 20}


@pytest.fixture
def solved(tmp_path):
    """Return a function that runs a 5 kg mount under samples of ü [m/s²]."""
    count = iter(range(10_000))

    def solve(u_dd, dt, frequency=5.0, command=drysim.run, window=None, **blocks):
        name = f"case{next(count)}"
        t = np.arange(len(u_dd)) * dt
        rows = "".join(f"{float(at)!r},{float(u)!r}\n" for at, u in zip(t, u_dd, strict=True))
        (tmp_path / f"{name}.csv").write_text("t [s],a [m/s2]\n" + rows)
        words = {
            "drysim": 1,
            "name": name,
            "oscillator": {"mass": 5, "natural_frequency": frequency, "damping_ratio": 0.08},
            "stroke": {"limit": 0.01},
            "excitation": {"kind": "record", "file": f"{name}.csv", "time": "t", "column": "a"},
        } | blocks
        if window:
            words["excitation"]["window"] = window
        file = tmp_path / f"{name}.yaml"
        file.write_text(yaml.safe_dump({key: one for key, one in words.items() if one}))
        return command(drysim.load(file))

    return solve


def slugs(result):
    return [warning.slug for warning in result.warnings]


def pulse(rng, dt):
    """Return a drawn shock that ends at rest, after a drawn silence."""
    n = int(rng.integers(8, 60))
    at = np.arange(n + 1) / n
    shapes = (
        np.sin(math.pi * at),
        np.sin(math.pi * at) ** 2,
        np.sin(2 * math.pi * at),
        np.minimum(1.0, np.minimum(5 * at, 5 * (1 - at))),
        np.sin(9 * at) * np.sin(math.pi * at),
    )
    height = rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(0.8, 2.2)
    silence = np.zeros(int(rng.integers(0, 4) * rng.integers(0, 200)))
    tail = np.zeros(int(rng.integers(0, 3) * rng.integers(0, 40)))
    return np.concatenate((silence, height * shapes[rng.integers(len(shapes))], tail))


@pytest.mark.parametrize("law", FRICTION)
def test_a_shock_that_ends_at_rest_has_the_peaks_of_one_that_is_followed_by_silence(
    law, solved
):
    rng = np.random.default_rng([7, *law.encode()])
    for _ in range(6):
        dt = 10.0 ** rng.uniform(-3.7, -3.0)
        u_dd, frequency = pulse(rng, dt), 10.0 ** rng.uniform(0.3, 1.5)
        blocks = {"friction": FRICTION[law], "checks": ["x_dd_peak > 0"]}
        padded = np.append(u_dd, np.zeros(math.ceil(3.0 / frequency / dt)))
        one, other = (solved(each, dt, frequency, **blocks) for each in (u_dd, padded))
        for name in PEAKS:
            expected = other.metrics[name]
            near = pytest.approx(expected, rel=1e-9, abs=1e-12) if expected else expected
            assert one.metrics[name] == near, name
        assert bool(one.metrics["violations"]) == bool(other.metrics["violations"])
        assert one.response.t[-1] <= other.response.t[-1]


def test_bumpers_hit_after_the_end_of_a_record_are_counted(solved):
    u_dd = 150.0 * np.sin(np.linspace(0.0, math.pi, 41))
    stroke = {"limit": 0.01, "stops": STOPS}
    one, other = (
        solved(each, 2.5e-4, stroke=stroke) for each in (u_dd, np.append(u_dd, np.zeros(4000)))
    )
    for name in ("x_r_peak", "impact_speed", "stop_force_peak"):
        assert one.metrics[name] == pytest.approx(other.metrics[name], rel=1e-9)
    assert one.metrics["contacts"] > 0


@pytest.mark.parametrize("ratio", [0.05, 0.6, 1.0, 3.0])
def test_the_stroke_after_an_impulse_is_that_of_the_closed_form(ratio, solved):
    # An impulse of triangular shape, much shorter than the period: x_r starts with -Δv.
    dt, omega, peak = 1e-5, 2 * math.pi * 2.0, 1e4
    outcome = solved(
        np.array([0.0, peak, 0.0]), dt,
        oscillator={"mass": 5, "natural_frequency": 2.0, "damping_ratio": ratio},
    )  # fmt: skip
    if ratio < 1.0:
        damped = math.sqrt(1.0 - ratio**2)
        turn = math.exp(-ratio / damped * math.acos(ratio))
    elif ratio == 1.0:
        turn = math.exp(-1.0)
    else:
        root = math.sqrt(ratio**2 - 1.0)
        turn = math.exp(-ratio / root * math.acosh(ratio))
    assert outcome.metrics["x_r_peak"] == pytest.approx(peak * dt / omega * turn, rel=2e-3)


@pytest.mark.parametrize("kind", ["shock", "rest"])
def test_a_short_run_has_the_peaks_of_a_long_one(kind, tmp_path):
    base = {
        "shock": {"kind": "shock", "pulse": "half-sine", "amplitude": 98.0665,
                  "duration": 0.011},
        "rest": {"kind": "rest"},
    }  # fmt: skip
    found = []
    for duration in (0.02, 1.0):
        words = {
            "drysim": 1,
            "name": "short",
            "oscillator": {"mass": 5, "natural_frequency": 5, "damping_ratio": 0.1},
            "friction": {"kinetic": 5},
            "stroke": {"limit": 0.02},
            "start": {"v_r": 0.4} if kind == "rest" else {},
            "excitation": base[kind],
            "solver": {"step": 1e-4},
            "measure": {"duration": duration},
        }
        file = tmp_path / "short.yaml"
        file.write_text(yaml.safe_dump(words))
        found.append(drysim.run(drysim.load(file)).metrics)
    short, long = found
    for name in ("x_r_peak", "x_dd_peak", "stroke_used", "stroke_suffices"):
        if long[name] is not None:  # x_dd_peak, of samples only
            assert short[name] == pytest.approx(long[name], rel=1e-12)
    assert short["a_u"] != long["a_u"] or kind == "rest"


def test_every_command_counts_the_ring_down(tmp_path, solved):
    u_dd = 100.0 * np.sin(np.linspace(0.0, math.pi, 111))
    peak = solved(u_dd, 1e-4).metrics["x_r_peak"]
    sweep = {"sweep": {"srs": [5, 10]}, "checks": ["x_dd_peak > 0"]}
    table = solved(u_dd, 1e-4, command=drysim.sweep, **sweep)
    assert table[0].metrics["x_r_peak"] == peak
    assert table[0].metrics["x_dd_peak"] == pytest.approx(
        solved(u_dd, 1e-4, checks=["x_dd_peak > 0"]).metrics["x_dd_peak"], rel=1e-12
    )
    friction = {"friction": {"kinetic": 4}}
    compared = solved(
        u_dd, 1e-4, command=lambda one: drysim.compare(one, "moreau vs stick-slip"), **friction
    )
    exact = solved(u_dd, 1e-4, **friction).metrics["x_r_peak"]
    rows = {row.approach: row.metrics["x_r_peak"] for row in compared.table}
    assert rows["stick-slip"] == exact
    assert rows["moreau"] == pytest.approx(exact, rel=1e-2)
    ends = {name: response.t[-1] for name, response in compared.responses.items()}
    assert len({*ends.values()}) == 1


def test_the_weighted_metrics_and_the_spectra_cover_the_window_alone(solved):
    rng = np.random.default_rng(5)
    u_dd = np.append(rng.normal(size=2000) * np.hanning(2000), np.zeros(30))
    blocks = {"measure": {"direction": "vertical", "spectra": True}}
    one = solved(u_dd, 5e-3, frequency=0.4, **blocks)
    within = {"duration": 2029 * 5e-3, "segment": one.spectra.segment}
    other = solved(
        np.append(u_dd, np.zeros(900)), 5e-3, 0.4, measure={**blocks["measure"], **within}
    )
    assert len(one.response.t) > 2030
    for name in ("a_u", "a_x", "T_a", "SEAT", "a_w", "VDV", "stuck_share"):
        # The transform behind the weighting has another length.
        assert one.metrics[name] == pytest.approx(other.metrics[name], rel=1e-4), name
    assert np.allclose(one.spectra.G_u, other.spectra.G_u, rtol=1e-9)


def cut_pulses(seed):
    """Yield drawn shocks that are cut while the base moves, in long silences too."""
    rng = np.random.default_rng(seed)
    for _ in range(12):
        n = int(rng.integers(30, 200))
        u_dd = 80.0 * np.sin(np.linspace(0.0, math.pi, n + 1))[: int(rng.uniform(0.3, 0.9) * n)]
        yield np.append(np.zeros(int(rng.integers(0, 5000))), u_dd)


def test_a_record_that_is_cut_in_the_middle_of_a_shock_is_named(solved):
    for u_dd in cut_pulses(3):
        outcome = solved(u_dd, 1e-4)
        assert "response-cut" in slugs(outcome)
        [one] = [each for each in outcome.warnings if each.slug == "response-cut"]
        assert "record ends" in one.sentence
        assert "while the base moves" in one.sentence


def test_a_record_that_begins_inside_a_shock_is_named(solved):
    rng = np.random.default_rng(5)
    for _ in range(12):
        whole = pulse(rng, 1e-4)
        loud = np.flatnonzero(np.abs(whole) > 0.3 * np.abs(whole).max())
        begin = int(rng.choice(loud))
        tail = np.zeros(2000)
        outcome = solved(np.append(whole[begin:], tail), 1e-4)
        if abs(whole[begin]) > 0.2 * np.abs(whole[begin:]).max():
            [one] = [each for each in outcome.warnings if each.slug == "response-cut"]
            assert "the record begins at" in one.sentence
        assert "response-cut" not in slugs(solved(np.append(whole, tail), 1e-4))


def vibrations_cut_at_zero(seed):
    """Yield vibrations from rest or in motion, and a sample of each that is nearly zero.

    Sums of sines, fading ones and bands of noise, cut after four or more half cycles.
    """
    rng = np.random.default_rng(seed)
    for _ in range(16):
        n = int(rng.integers(200, 2000))
        t, u_dd = np.arange(n), np.zeros(n)
        low, count = rng.uniform(5.0, 20.0) / n, int(rng.integers(1, 30))
        for frequency in rng.uniform(low, low * rng.uniform(1.0, 5.0), count):
            u_dd += rng.normal() * np.sin(2 * math.pi * (frequency * t + rng.uniform()))
        u_dd *= np.exp(-rng.choice((0.0, 1.0)) * t / n)
        u_dd *= np.minimum(1.0, t / rng.choice((1.0, 0.2 * n)))
        small = np.abs(u_dd) <= rng.choice((0.05, 0.01)) * np.abs(u_dd).max()
        ends = [i for i in np.flatnonzero(small) if 2.5 / low < i < n - 2]
        if ends:
            yield u_dd, int(rng.choice(ends))


def cut_of(outcome):
    """Return the only warning of a motion that is cut, after which no ring-down is invented."""
    [warning] = [each for each in outcome.warnings if each.slug == "response-cut"]
    assert not outcome.response.motion.rest
    return warning.sentence


def test_a_vibration_that_is_cut_at_a_zero_is_not_at_rest(solved):
    dt, count = 5e-3, 0
    for seed in range(4):
        for u_dd, last in vibrations_cut_at_zero(seed):
            frequency = 2.9 / (len(u_dd) * dt)  # a single event
            outcome = solved(u_dd[: last + 1], dt, frequency)
            assert "the record ends" in cut_of(outcome), (seed, last)
            assert len(outcome.response.t) == last + 1
            count += 1
    assert count > 50


def test_a_vibration_that_is_followed_by_silence_rings_down(solved):
    dt = 5e-3
    for u_dd, last in vibrations_cut_at_zero(11):
        frequency = 1.0 / (len(u_dd) * dt)
        silent = np.append(u_dd[: last + 1], np.zeros(last))
        outcome = solved(silent, dt, frequency)
        assert "response-cut" not in slugs(outcome)
        assert outcome.response.motion.rest > 0


@pytest.mark.parametrize("block", ["excitation", "measure"])
def test_a_window_that_ends_at_a_zero_of_a_longer_record_is_not_at_rest(block, solved):
    dt = 5e-3
    for u_dd, last in vibrations_cut_at_zero(5):
        frequency, end = 2.9 / (len(u_dd) * dt), last * dt
        outcome = solved(u_dd, dt, frequency, **until(end, block))
        assert f"window ends at {end:.4g}"[:-1] in cut_of(outcome)
        assert cut_of(outcome).endswith(CURES[block])


CURES = {
    "excitation": "use a later excitation.window.to",
    "measure": "use a longer measure.duration",
}


def until(end, block):
    """Return the blocks of a scenario whose window ends at a time [s]."""
    if block == "measure":
        return {"measure": {"duration": end}}
    return {"window": {"to": end}}


@pytest.mark.parametrize("block", ["excitation", "measure"])
@pytest.mark.parametrize("end", [0.011, 0.02])
def test_a_window_that_ends_with_a_pulse_or_before_the_ring_down_is_named(block, end, solved):
    u_dd = np.append(100.0 * np.sin(np.linspace(0.0, math.pi, 111)), np.zeros(5000))
    sentence = cut_of(solved(u_dd, 1e-4, **until(end, block)))
    assert f"window ends at {end:g} s" in sentence
    assert "after |ü| was last above 5 % of its peak" in sentence
    assert sentence.endswith(CURES[block])
    assert "response-cut" not in slugs(solved(u_dd, 1e-4, **until(0.3, block)))


def stationary(seed, n, dt):
    """Return band-limited noise of drawn bandwidth; some of it quantised or modulated."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(n, dt)
    low = 10.0 ** rng.uniform(-0.5, 1.0)
    lines = rng.normal(size=len(f)) + 1j * rng.normal(size=len(f))
    u_dd = np.fft.irfft(np.where((f >= low) & (f <= low * rng.uniform(1.5, 20.0)), lines, 0), n)
    u_dd *= 1.0 + 0.5 * np.sin(2 * math.pi * np.arange(n) / n * rng.integers(1, 9))
    u_dd /= u_dd.std()
    step = rng.choice((0.0, 0.05, 0.3))
    return np.round(u_dd / step) * step if step else u_dd


@pytest.mark.parametrize("seeds", ranges(40, 1000))
def test_a_stationary_record_ends_as_it_is_and_gives_no_warning(solved, seeds):
    for seed in seeds:
        u_dd = stationary(seed, 2000, 5e-3)
        outcome = solved(u_dd, 5e-3)
        assert len(outcome.response.t) == len(u_dd), seed
        assert "response-cut" not in slugs(outcome), seed


def test_the_summary_says_that_the_run_goes_on(tmp_path, capsys, solved):
    solved(100.0 * np.sin(np.linspace(0.0, math.pi, 111)), 1e-4)
    file = next(tmp_path.glob("*.yaml"))
    assert main(["run", str(file), "--out", str(tmp_path / "out"), "--no-plots"]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert re.search(r"window 0.011 s, then 0.2\d* s of ring-down with the base at rest", words)
    assert "111 samples at 10000 Hz, 0.011 s" in words
