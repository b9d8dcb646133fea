"""Peak acceleration of the mass: exact over the whole motion, jumps included."""

from __future__ import annotations

from itertools import pairwise
from math import exp, pi, sqrt

import numpy as np
import pytest
from segments import every_segment

import drysim
from drysim.approach.stepping import refine_motion
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    State,
    StrokeLimits,
)
from drysim.core.peak import Decay, interior_peak
from drysim.core.trajectory import motion_in_segment, resume_segment, segment_window
from drysim.metrics.table import METRICS_BY_NAME
from drysim.plots.sweep import draw_spectra, draw_stroke
from drysim.results.tables import optional_metrics

PULSE, HEIGHT = 0.011, 98.0665
REST = State(0.0, 0.0)


def peak_acceleration(trajectory, begin: float, end: float) -> float:
    """Return the largest |x_dd| in a window [m/s²]."""
    return trajectory.totals(begin, end).x_dd_peak


def largest_of_curve(value, rate, end: float, count: int = 20_000) -> float:
    """Return the largest |value| on [0, end], its maxima located as roots of the rate."""
    from scipy.optimize import brentq

    t = np.linspace(0.0, end, count)
    rates = np.array([rate(s) for s in t])
    turns = np.flatnonzero(rates[:-1] * rates[1:] < 0.0)
    roots = [brentq(rate, t[i], t[i + 1], xtol=1e-15, rtol=1e-14) for i in turns]
    return max(abs(value(s)) for s in (0.0, *roots, end))


def half_sine_spectrum(f_0: float, xi: float) -> tuple[float, float]:
    """Return peak acceleration and peak stroke of a linear mount under a half-sine.

    During the pulse x_r = X sin(Ωt) + Y cos(Ωt) + free vibration, and free vibration after it.
    """
    w, Omega = 2 * pi * f_0, pi / PULSE
    w_d = w * sqrt(1 - xi * xi)
    below, across = w * w - Omega * Omega, 2 * xi * w * Omega
    X = -HEIGHT * below / (below**2 + across**2)
    Y = HEIGHT * across / (below**2 + across**2)

    def free(x: float, v: float, t: float) -> tuple[float, float]:
        B, decay = (v + xi * w * x) / w_d, exp(-xi * w * t)
        sine, cosine = np.sin(w_d * t), np.cos(w_d * t)
        rate = (w_d * B - xi * w * x) * cosine - (w_d * x + xi * w * B) * sine
        return decay * (x * cosine + B * sine), decay * rate

    def during(t: float) -> tuple[float, float, float]:
        x, v = free(-Y, -X * Omega, t)
        sine, cosine = np.sin(Omega * t), np.cos(Omega * t)
        return x + X * sine + Y * cosine, v + Omega * (X * cosine - Y * sine), HEIGHT * sine

    end = during(PULSE)[:2]

    def after(t: float) -> tuple[float, float, float]:
        return *free(*end, t), 0.0

    def x_dd(state: tuple[float, float, float]) -> float:
        return -w * w * state[0] - 2 * xi * w * state[1]

    def rate(state: tuple[float, float, float]) -> float:
        return -w * w * state[1] - 2 * xi * w * (x_dd(state) - state[2])

    def peak(value, rate) -> float:
        spans = (during, PULSE), (after, 1.0 / f_0)
        return max(
            largest_of_curve(lambda t, of=of: value(of(t)), lambda t, of=of: rate(of(t)), span)
            for of, span in spans
        )

    return peak(x_dd, rate), peak(lambda state: state[0], lambda state: state[1])


@pytest.mark.parametrize(
    "law",
    [
        CoulombLaw(30.0, 40.0),
        PiecewiseLaw(30.0, 40.0, stops=EndStops(StrokeLimits(0.004, 0.005))),
        PiecewiseLaw(30.0, 30.0, k_t=2e4),
    ],
    ids=["coulomb", "stops", "elastic"],
)
def test_measuring_a_motion_leaves_it_as_it_is(law):
    noise = np.random.default_rng(3).normal(size=4000)
    u_dd = np.convolve(noise, np.ones(8) / 3, "same")
    response = StickSlip().solve(
        Plant(75.0, 7500.0, 300.0), law, Samples(u_dd, 0.005), REST, 1.0
    )
    trajectory = response.trajectory
    windows = (0.0, trajectory.end), (3.3, 17.7), (10.0, trajectory.end)

    def measured():
        return [(trajectory.totals(*window), trajectory.state(window[1])) for window in windows]

    first = measured()
    assert measured() == first
    assert measured() == first


@pytest.mark.parametrize("xi", [0.0, 0.05, 1.0, 3.0])
@pytest.mark.parametrize("f_0", [0.1, 3.0, 40.0, 230.0])
def test_maxima_between_coarse_samples_are_not_missed(f_0, xi):
    # State and ramp of the base in one matrix exponential: no formula of the program.
    from scipy.linalg import expm
    from scipy.optimize import brentq

    w, dt = 2 * pi * f_0, 0.01
    u_dd = 20 * np.random.default_rng(3).standard_normal(31)
    plant, motion = Plant(1.0, w * w, 2 * xi * w), Samples(u_dd, dt)
    law = CoulombLaw(0.0, 0.0)
    trajectory = StickSlip().trajectory(plant, law, motion, State(1e-3, 0.1), 0.3)
    matrix = np.zeros((4, 4))
    matrix[0, 1], matrix[1], matrix[2, 3] = 1.0, (-w * w, -2 * xi * w, -1.0, 0.0), 1.0
    of_x_dd = np.array([-w * w, -2 * xi * w, 0.0, 0.0])
    fine = 60
    flow, state, expected = expm(matrix * dt / fine), np.array([1e-3, 0.1, 0.0, 0.0]), 0.0
    for before, behind in pairwise(u_dd.tolist()):
        state[2:] = before, (behind - before) / dt
        for _ in range(fine):
            last, state = state, flow @ state
            rates = of_x_dd @ matrix @ last, of_x_dd @ matrix @ state
            top = last
            if rates[0] * rates[1] < 0.0:

                def rate(s: float, last=last) -> float:
                    return float(of_x_dd @ matrix @ expm(matrix * s) @ last)

                if max(abs(of_x_dd @ last), abs(of_x_dd @ state)) > 0.97 * expected:
                    top = expm(matrix * brentq(rate, 0.0, dt / fine, xtol=1e-17)) @ last
            expected = max(expected, *(abs(of_x_dd @ one) for one in (last, top, state)))
    assert peak_acceleration(trajectory, 0.0, 0.3) == pytest.approx(expected, rel=1e-9)


def test_peak_of_a_mass_that_breaks_away_is_its_friction_limit():
    # A soft mount: the spring adds nothing, and no sample lies where the mass breaks away.
    u_dd = HEIGHT * np.sin(pi / 110 * np.arange(111))
    plant, law, motion = Plant(5.0, 1e-9, 0.0), CoulombLaw(150.0, 180.0), Samples(u_dd, 1e-4)
    trajectory = StickSlip().trajectory(plant, law, motion, REST, 110 * 1e-4)
    assert peak_acceleration(trajectory, 0.0, 110 * 1e-4) == pytest.approx(36.0, rel=1e-12)


COULOMB = CoulombLaw(20.0, 24.0)
STOPS = StrokeLimits(0.01, 0.015)
LAWS = {
    "no friction": CoulombLaw(0.0, 0.0),
    "coulomb": COULOMB,
    "jenkins": PiecewiseLaw(20.0, 20.0, 5e4),
    "bumpers": COULOMB.as_piecewise()._replace(
        stops=EndStops(STOPS, ((0.0, 4e4), (0.005, 1e5)), 50.0)
    ),
    "bumpers on jenkins": PiecewiseLaw(20.0, 20.0, 5e4)._replace(
        stops=EndStops(STOPS, ((0.0, 4e4),), 50.0)
    ),
    "rigid stops": COULOMB.as_piecewise()._replace(stops=EndStops(STOPS, (), 0.0, 0.5)),
    "stops out of reach": COULOMB.as_piecewise()._replace(
        stops=EndStops(StrokeLimits(9.0, 9.0), (), 0.0, 0.5)
    ),
    "damper by direction": COULOMB.as_piecewise()._replace(damping=(30.0, 10.0)),
    "friction by direction": COULOMB.as_piecewise()._replace(compression=(10.0, 12.0)),
}


@pytest.mark.parametrize("dt", [5e-3, 2e-2])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_peak_in_a_window_is_the_limit_of_ever_finer_grids(law, dt):
    plant, start, end = Plant(5.0, 8000.0, 20.0), State(0.002, 0.3), 0.6
    motion = Samples(20 * np.random.default_rng(1).standard_normal(round(end / dt) + 1), dt)
    begin, until = 0.1234567, 0.5371
    solved = StickSlip().trajectory(plant, law, motion, start, until)
    peak = peak_acceleration(solved, begin, until)
    finer = round(dt / 1e-5)
    grid = refine_motion(motion, finer)
    response = StickSlip().solve(plant, law, grid, start, dt / finer, until)
    inside = (response.t >= begin) & (response.t <= until)
    on_grid = float(np.abs(response.x_dd[inside]).max())
    # One step of the grid changes x_dd by 0.1 m/s² at most.
    assert on_grid * (1 - 1e-9) <= peak <= on_grid + 0.1
    assert peak_acceleration(solved, 0.0, until) >= peak


@pytest.mark.parametrize("radians", [0.02, 0.2, 1.0, 4.0])
def test_steps_left_out_never_hold_the_peak(radians):
    """Drawn scenes and windows: all steps searched give the same peak."""
    rng = np.random.default_rng(7)
    for _ in range(12):
        f_0, xi, n = 10 ** rng.uniform(-0.5, 1.0), rng.choice([0.0, 0.02, 0.3, 2.0]), 400
        plant = Plant(5.0, 5.0 * (2 * pi * f_0) ** 2, 2.0 * xi * 5.0 * 2 * pi * f_0)
        F, dt = 5.0 * rng.choice([0.0, 0.05, 0.3, 0.8]), radians / (2 * pi * f_0)
        u_dd = np.convolve(rng.standard_normal(n), np.ones(rng.integers(1, 9)) / 2.0, "same")
        motion, law = Samples(u_dd, dt), CoulombLaw(F, F * rng.choice([1.0, 1.3]))
        solved = StickSlip().trajectory(plant, law, motion, State(0.01, 0.0))
        ends = rng.uniform(0.0, solved.end, 2), dt * rng.integers(0, n - 1, 2)
        for begin, end in ((0.0, solved.end), *(np.sort(window).tolist() for window in ends)):
            expected = peak_of_every_segment(solved, begin, end)
            assert peak_acceleration(solved, begin, end) == pytest.approx(expected, rel=1e-14)


def peak_of_every_segment(trajectory, begin: float, end: float) -> float:
    """Return the peak of a motion in one block, from all segments, each searched."""
    whole, peak = every_segment(trajectory.march.block(0).solution), 0.0
    scene = whole.scene
    for i in range(len(whole.segments.n)):
        lo, hi = segment_window(whole.segments, scene.dt, i, begin, end)
        if hi < lo or (hi == lo and begin < end):
            continue
        part = resume_segment(whole, i)
        u_0, u_1 = (part.u_0 + part.slope * s for s in (lo, hi))
        if part.mode.direction == 0:
            peak = max(peak, abs(u_0), abs(u_1))
            continue
        c, w, g, r = part.equation
        (x, v), (x_1, v_1) = (motion_in_segment(scene.waves, part, s) for s in (lo, hi))
        e, e_end = g + r * lo - c * v - w * x, g + r * hi - c * v_1 - w * x_1
        decay = Decay(c, w, u_0, part.slope, e, r - c * e - w * v)
        inside = interior_peak(decay, hi - lo)
        peak = max(peak, abs(u_0 + e), abs(u_1 + e_end), inside)
    return peak


SEAT = {
    "oscillator": {"mass": 5, "natural_frequency": 20, "damping_ratio": 0.05},
    "friction": {"law": "coulomb", "kinetic": 20},
    "excitation": {"kind": "shock", "pulse": "half-sine", "amplitude": 30, "duration": 0.01},
    "solver": {"step": 1e-3},
    "measure": {"duration": 0.2},
}
NOISE = {"kind": "psd", "points": [[1, 1], [10, 1]], "duration": 1, "seed": 1}
LUGRE = {
    "law": "lugre", "kinetic": 20, "bristle_stiffness": 1e5, "bristle_damping": 300,
    "stribeck_velocity": 0.01,
}  # fmt: skip
VARYING = {
    "law": "coulomb", "kinetic": 20, "normal_variation": {"amplitude": 0.4, "frequency": 7}
}  # fmt: skip


def scene(**blocks: object) -> drysim.Scenario:
    """Return the scenario with other blocks."""
    return drysim.scenario(SEAT, blocks)


@pytest.mark.parametrize(
    "blocks",
    [
        {"excitation": {"kind": "harmonic", "frequency": 2, "rms": 1}, "measure": None},
        {"friction": LUGRE},
        {"friction": VARYING},
    ],
    ids=["sines", "lugre", "varying normal force"],
)
def test_a_peak_that_is_not_exact_is_not_known(blocks):
    assert drysim.run(scene(**blocks)).metrics["x_dd_peak"] is None


def test_a_fixed_step_knows_its_grid_points():
    outcome = drysim.run(scene(solver={"step": 1e-3, "approach": "moreau"}))
    assert outcome.metrics["x_dd_peak"] == np.abs(outcome.response.x_dd).max()


def test_a_swept_shock_shows_its_response_spectra():
    swept = {"oscillator.natural_frequency": [5, 50], "friction.kinetic": [0, 20]}
    table = drysim.sweep(scene(sweep=swept, stroke={"limit": 1}))
    assert optional_metrics(table.scenario) == ("x_dd_peak",)
    least = min(row.metrics["x_dd_peak"] for row in table.rows)
    assert (table.best.objective, table.best.value) == ("x_dd_peak", least)
    assert table.best.result.endswith("m/s²")
    titles = [axes.get_title(loc="left") for axes in draw_stroke(table).axes]
    assert "|ẍ|" in titles[0]
    assert "xᵣ" in titles[1]


def test_spectrum_without_friction_is_that_of_a_linear_mount():
    # A pulse joined by straight lines deviates by π²/8/n² of its height: 3e-10.
    table = drysim.sweep(
        scene(
            excitation=SEAT["excitation"] | {"amplitude": HEIGHT, "duration": PULSE},
            friction={"law": "coulomb", "kinetic": 0},
            solver={"step": PULSE / 60_000},
            measure={"duration": 0.09},
            sweep={"srs": [8, 40, 72.39, 250, 500]},
        )
    )
    frequencies = [row.point["oscillator.natural_frequency"] for row in table.rows]
    assert frequencies == [8, 40, 72.39, 250, 500]
    for f_0, row in zip(frequencies, table.rows, strict=True):
        found = row.metrics["x_dd_peak"], row.metrics["x_r_peak"]
        assert found == pytest.approx(half_sine_spectrum(f_0, 0.05), rel=1e-9)


def test_spectra_are_a_sweep_of_the_natural_frequency_with_a_picture_of_their_own():
    friction = {"friction.kinetic": [0, 5, 20]}
    spread = {"from": 5, "to": 50, "count": 2}
    table = drysim.sweep(scene(sweep=friction | {"srs": spread}, stroke={"limit": 1}))
    same = {**friction, "oscillator.natural_frequency": spread | {"scale": "log"}}
    plain = drysim.sweep(scene(sweep=same, stroke={"limit": 1}))
    assert [row.metrics for row in table.rows] == [row.metrics for row in plain.rows]
    assert (draw_stroke(table), draw_spectra(plain)) == (None, None)
    acceleration, stroke = draw_spectra(table).axes
    assert "|ẍ|" in acceleration.get_title(loc="left")
    assert "xᵣ" in stroke.get_title(loc="left")
    for axes in acceleration, stroke:
        assert axes.get_xscale() == "log"
        assert "f₀" in axes.get_xlabel()


def test_a_spectrum_of_a_record_shows_the_peak_acceleration(tmp_path):
    (tmp_path / "u.csv").write_text("t [s],u_dd [m/s2]\n0,0\n0.1,9\n0.2,0\n0.3,0\n0.4,0\n")
    excitation = {"kind": "record", "file": str(tmp_path / "u.csv"), "time": "t"}
    blocks = {"excitation": excitation, "solver": None, "measure": None}
    table = drysim.sweep(scene(**blocks, sweep={"srs": [5, 50]}))
    assert optional_metrics(table.scenario) == ("x_dd_peak",)


def test_other_tables_show_the_peak_where_a_check_names_it():
    swept = {"excitation": NOISE, "measure": None, "sweep": {"friction.kinetic": [0, 20]}}
    assert optional_metrics(drysim.sweep(scene(**swept)).scenario) == ()
    table = drysim.sweep(scene(**swept, checks=["x_dd_peak < 1 km/s2"]))
    assert optional_metrics(table.scenario) == ("x_dd_peak",)
    assert table.best.objective == "T_a"
    assert METRICS_BY_NAME["x_dd_peak"].unit == "m/s2"
