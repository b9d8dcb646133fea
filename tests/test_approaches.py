"""Contract of every approach, and the physics of the exact ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drysim.approach import APPROACHES, Approach
from drysim.approach.base_motion import count_grid_points
from drysim.approach.fixed_step import Moreau, Signum, Smooth, Switch
from drysim.approach.simulate import simulate
from drysim.approach.solution import Response, Trajectory
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Plant, Samples, Sines, State, StrokeLimits
from drysim.errors import SolverError, UsageError
from drysim.metrics.table import METRICS, measure
from drysim.orbits.search import find_orbit

PAPER = Plant(75.0, 7500.0, 500.0)
REST = State(0.0, 0.0)
SINE = Sines((1.0,), (2.0,), (0.0,))
STILL = Sines((), (), ())
PAIR = Sines((1.4, 0.9), (1.1, 3.7), (0.4, 1.0))


def noise(n: int, seed: int = 3) -> Samples:
    """Return smooth noise of a few hertz, 0.67 m/s² RMS, 400 samples a second."""
    rng = np.random.Generator(np.random.PCG64(seed))
    rough = np.convolve(rng.normal(size=n + 200), np.hanning(41), mode="same")[100 : n + 100]
    return Samples(rough * (0.67 / np.sqrt(np.mean(rough**2))), 2.5e-3)


VARYING = CoulombLaw(30.0, 40.0, 0.4, 10.7, 0.2)
SCENES = {
    "sine": (PAPER, CoulombLaw(15.0, 15.0), SINE, REST, 5.0),
    "two sines": (PAPER, CoulombLaw(30.0, 36.0), PAIR, State(0.001, 0.05), 5.0),
    "free decay": (Plant(1.0, 1.0, 0.0), CoulombLaw(1.0, 1.0), STILL, State(12.0, 6.0), 30.0),
    "samples": (PAPER, CoulombLaw(45.0, 54.0), noise(2000), REST, 4.9),
    "varying limits": (PAPER, VARYING, PAIR, REST, 5.0),
    "varying limits over samples": (PAPER, VARYING, noise(800), State(0.0, 0.02), 1.9),
    "rigid block": (Plant(75.0, 0.0, 0.0), CoulombLaw(15.0, 15.0), noise(2000), REST, 4.9),
    "heavy damping": (PAPER._replace(b=75e3), CoulombLaw(15.0, 18.0), PAIR, REST, 5.0),
    "critical damping": (
        PAPER._replace(b=1500.0), CoulombLaw(15.0, 18.0), noise(2000), REST, 4.9,
    ),
    "stiff": (PAPER._replace(k_x=3e8), CoulombLaw(15.0, 18.0), noise(600), REST, 1.4),
    "nearly no friction": (PAPER, CoulombLaw(1e-12, 1e-12), PAIR, REST, 5.0),
    "never moves": (PAPER, CoulombLaw(200.0, 200.0), PAIR, REST, 5.0),
}  # fmt: skip


def solved(name: str) -> Response:
    """Solve one of the scenes."""
    plant, law, motion, start, duration = SCENES[name]
    return StickSlip().solve(plant, law, motion, start, 2.5e-3, duration)


def track_of(response: Response) -> Trajectory:
    """Return the continuous solution of a response."""
    assert response.trajectory is not None
    return response.trajectory


@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("motion", [SINE, noise(400)])
def test_every_approach_gives_a_whole_response(approach: type, motion: Sines | Samples) -> None:
    response = approach().solve(PAPER, CoulombLaw(15.0, 15.0), motion, REST, 2.5e-3, 0.9)
    n = len(response.t)
    assert n == 361
    for series in (response.x_r, response.v_r, response.x_dd, response.F_f, response.u_dd):
        assert series.shape == (n,)
        assert np.isfinite(series).all()
    assert response.t[-1] == pytest.approx(0.9)
    assert response.numerics.approach == approach.model_fields["approach"].default
    assert response.numerics.why
    assert set(measure(track_of(response), (0.0, 0.9), StrokeLimits(0.025, 0.025))) == {
        metric.name for metric in METRICS
    }


@pytest.mark.parametrize("name", SCENES)
def test_energy_closes_in_any_window(name: str) -> None:
    for window in ((0.0, SCENES[name][-1]), (0.31234, 1.21987)):
        metrics = measure(track_of(solved(name)), window, None)
        assert metrics["energy_residual"] < 1e-11


@pytest.mark.parametrize("F_fk", [0.0, 45.0])
def test_energy_closes_behind_a_damper_that_hardly_yields(F_fk: float) -> None:
    # It had closed to 1e-8 only, for the flow had lost as many digits.
    motion = Samples(np.sin(0.1 * np.arange(200)), 2.5e-3)
    plant = PAPER._replace(b=1e12)
    response = StickSlip().solve(plant, CoulombLaw(F_fk, F_fk), motion, REST, motion.dt)
    residual = measure(track_of(response), (0.0, 199 * motion.dt), None)["energy_residual"]
    assert residual < 1e-14


@pytest.mark.parametrize("name", SCENES)
def test_metrics_of_two_halves_make_those_of_the_whole(name: str) -> None:
    duration = SCENES[name][-1]
    trajectory = solved(name).trajectory
    assert trajectory is not None
    cut = 0.377 * duration
    whole, one, other = (
        np.array(trajectory.totals(*window)[:7])
        for window in ((0.0, duration), (0.0, cut), (cut, duration))
    )
    assert np.abs(one + other - whole).max() <= 1e-12 * np.abs(whole).max()


@pytest.mark.parametrize("name", SCENES)
def test_friction_only_takes(name: str) -> None:
    response = solved(name)
    assert (response.F_f * response.v_r >= 0.0).all()
    assert (response.v_r[response.stuck] == 0.0).all()


@pytest.mark.parametrize("name", SCENES)
def test_force_balance_holds_at_every_point_of_the_grid(name: str) -> None:
    response = solved(name)
    plant = response.plant
    left = (
        plant.m * response.x_dd
        + plant.b * response.v_r
        + plant.k_x * response.x_r
        + response.F_f
    )
    assert np.abs(left).max() <= 1e-12 * np.abs(plant.m * response.x_dd).max() + 1e-20


def test_metrics_do_not_depend_on_the_output_step() -> None:
    coarse, fine = (
        measure(
            track_of(StickSlip().solve(PAPER, CoulombLaw(30.0, 36.0), PAIR, REST, step, 5.0)),
            (1.0, 5.0),
            StrokeLimits(0.02, 0.02),
        )
        for step in (0.5, 1e-3)
    )
    assert coarse == fine


@pytest.mark.parametrize(
    ("duration", "step", "points"),
    [(0.3, 0.1, 4), (2.9999, 1.0, 3), (7.5e6, 2.5e-3, 3 * 10**9 + 1),
     (1e9 + 0.3, 1.0, 10**9 + 1)],
)  # fmt: skip
def test_grid_ends_with_the_motion_however_long(
    duration: float, step: float, points: int
) -> None:
    assert count_grid_points(duration, step) == points


def test_without_friction_sines_give_the_closed_form_transmissibility() -> None:
    omega = 4 * math.pi
    response = StickSlip().solve(PAPER, CoulombLaw(0.0, 0.0), SINE, REST, 0.01, 12.0)
    metrics = measure(track_of(response), (10.0, 12.0), None)
    stiffness = PAPER.k_x - PAPER.m * omega**2
    exact = math.hypot(PAPER.k_x, PAPER.b * omega) / math.hypot(stiffness, PAPER.b * omega)
    relative = PAPER.m * omega**2 / math.hypot(stiffness, PAPER.b * omega)
    assert metrics["T_a"] == pytest.approx(exact, rel=1e-12)
    assert metrics["T_x"] == pytest.approx(relative, rel=1e-12)
    assert metrics["x_r_peak"] == pytest.approx(relative * 1.0 / omega**2, rel=1e-12)


def test_standstill_transmits_everything_and_moves_nothing() -> None:
    metrics = measure(
        track_of(StickSlip().solve(PAPER, CoulombLaw(75.0, 75.0), SINE, REST, 0.01, 3.0)),
        (0.0, 3.0),
        StrokeLimits(0.01, 0.01),
    )
    assert metrics["T_a"] == 1.0
    assert (metrics["T_x"], metrics["x_r_peak"], metrics["stuck_share"]) == (0.0, 0.0, 1.0)
    assert (metrics["violations"], metrics["t_first_violation"]) == (0, None)


def test_rigid_block_that_slides_without_stops_passes_on_its_friction() -> None:
    # k_x = b = 0 below the onset of stops: RMS x"/A is φ exactly.
    block, law = Plant(1.0, 0.0, 0.0), CoulombLaw(0.4, 0.4)
    phase = math.acos(math.pi * 0.4 / 2)
    sine = Sines((1.0,), (1 / (2 * math.pi),), (phase,))
    response = StickSlip().solve(block, law, sine, REST, 0.1, 40 * math.pi)
    metrics = measure(track_of(response), (2 * math.pi, 40 * math.pi), None)
    assert metrics["a_x"] == pytest.approx(0.4, rel=1e-12)
    assert metrics["stuck_share"] == 0.0


def test_orbit_loses_in_friction_four_times_force_times_stroke() -> None:
    approach, law = StickSlip(), CoulombLaw(45.0, 54.0)
    orbit = find_orbit(PAPER, law, Sines((1.06,), (3.0,), (0.0,)), REST, 1 / 3)
    assert orbit.settled
    response = approach.solve(
        PAPER, law, Sines((1.06,), (3.0,), (0.0,)), orbit.state, 1e-3, 1 / 3
    )
    metrics = measure(track_of(response), (0.0, 1 / 3), None)
    assert metrics["energy_friction"] == pytest.approx(
        4 * 45.0 * metrics["x_r_peak"], rel=1e-12
    )


def test_stroke_is_violated_at_the_very_limit_and_counted_by_excursion() -> None:
    response = StickSlip().solve(PAPER, CoulombLaw(15.0, 15.0), SINE, REST, 0.01, 5.0)
    peak = measure(track_of(response), (0.0, 5.0), None)["x_r_peak"]
    assert peak is not None
    at, above = (
        measure(track_of(response), (0.0, 5.0), StrokeLimits(limit, limit))
        for limit in (peak, peak * (1 + 1e-12))
    )
    assert at["violations"] >= 1
    assert above["violations"] == 0
    half = measure(track_of(response), (0.0, 5.0), StrokeLimits(peak / 2, peak / 2))
    trajectory = response.trajectory
    assert trajectory is not None
    assert abs(trajectory.state(half["t_first_violation"]).x_r) == pytest.approx(
        peak / 2, rel=1e-13
    )
    fine = np.abs([trajectory.state(t).x_r for t in np.linspace(0.0, 5.0, 20_001)]) >= peak / 2
    assert half["violations"] == np.count_nonzero(np.diff(fine.astype(int)) == 1)
    assert half["t_beyond"] == pytest.approx(5.0 * fine.mean(), abs=2e-3)


def test_simulate_gives_arrays_for_arrays() -> None:
    u_dd = noise(500).u_dd
    scene = {"m": 75.0, "k_x": 7500.0, "b": 500.0, "u_dd": u_dd, "dt": 2.5e-3}
    response = simulate(**scene, F_fk=15.0, F_fs=18.0)
    linear = simulate(**scene)
    viscous = simulate(**scene, F_fk=15.0, approach="viscous")
    assert response.x_dd.shape == response.stuck.shape == u_dd.shape
    assert len(response.events) > 1
    assert linear.numerics.core == "recursion"
    assert np.array_equal(linear.x_r, viscous.x_r)
    assert not linear.stuck.any()


@pytest.mark.parametrize(
    ("change", "words"),
    [({"m": 0.0}, "m must be above 0"), ({"m": -1.0}, "m must be above 0, not -1"),
     ({"F_fs": 10.0}, "F_fs = 10 N must be at least F_fk = 15 N"),
     ({"dt": 0.0}, "dt must be above 0"), ({"b": math.nan}, "b must be a finite number"),
     ({"u_dd": [1.0]}, "at least 2 samples"),
     ({"u_dd": [1.0, "a"]}, r"u_dd\[1\] must be a number in SI, not 'a'"),
     ({"u_dd": ["1", "2"]}, r"u_dd\[0\] must be a number in SI, not '1'"),
     ({"u_dd": np.array([1.0, 2.0j])}, r"u_dd\[0\] must be a number in SI, not \(1\+0j\)"),
     ({"u_dd": np.arange(2).astype("M8[s]")}, r"u_dd\[0\] must be a number in SI, not .*date"),
     ({"u_dd": np.ma.masked_equal([1.0, 1e6, 2.0], 1e6)}, "u_dd has masked values; fill them"),
     ({"u_dd": [[1.0], [1.0, 2.0]]}, "u_dd must be a one-dimensional array of numbers: "),
     ({"m": "5"}, "m must be a number in SI, not '5'"),
     ({"m": [75.0]}, r"m must be a number in SI, not \[75.0\]"),
     ({"dt": True}, "dt must be a number in SI, not True"),
     ({"b": 1j}, "b must be a number in SI, not 1j"),
     ({"x_rM": "1", "e": 0.5}, "x_rM must be a number in SI, not '1'"),
     ({"m": "75 kg"}, "m must be a number in SI, not '75 kg'"),
     ({"dt": None}, "dt must be a number in SI, not None"),
     ({"k_x": 10**400}, "k_x must be a number in SI: int too large"),
     ({"u_dd": [1.0, 10**400]}, "must be a one-dimensional array of numbers: int too large"),
     ({"u_dd": [1.0, math.inf]}, r"u_dd\[1\] must be a finite"),
     ({"m": 1e-320}, r"m must lie between 1e-30 and 1e\+30 in size, or be 0"),
     ({"m": 1e-3, "k_x": 1e308}, "k_x must lie between"),
     ({"m": 1e-3, "b": 1e308}, "b must lie between"),
     ({"F_fk": 1e-300}, "F_fk must lie between"),
     ({"dt": 1e-200}, "dt must lie between"),
     ({"x_r": -1e200}, "x_r must lie between"),
     ({"u_dd": [0.0, 1e31], "approach": "signum"}, r"u_dd\[1\] must be at most 1e\+30"),
     ({"approach": "signum", "F_fs": 18.0}, "does not model a static limit: F_fs = 18 N"),
     ({"x_rM": np.ones(2), "e": 0.5}, r"x_rM must be a number in SI, not array"),
     ({"b_s": np.ones(2)}, r"b_s must be a number in SI, not array"),
     ({"approach": ["signum"]}, r"unknown approach `\['signum'\]`"),
     ({"approach": "signom"}, "unknown approach `signom`")],
)  # fmt: skip
def test_simulate_refuses_nonsense_in_a_sentence(change: dict[str, object], words: str) -> None:
    scene = {"m": 75.0, "k_x": 7500.0, "b": 500.0, "F_fk": 15.0, "u_dd": [0.0] * 9, "dt": 1e-3}
    with pytest.raises(UsageError, match=words):
        simulate(**{**scene, **change})  # type: ignore[arg-type]


def test_simulate_takes_numbers_of_every_kind() -> None:
    scene = {"k_x": 7500, "b": np.float32(500), "F_fk": np.array(15.0), "dt": np.float64(1e-3)}
    u_dd = [0, 1, 2, -3]
    same = [u_dd, tuple(u_dd), np.array(u_dd, dtype=np.int16), np.ma.array(u_dd),
            np.array(u_dd, dtype=object), np.repeat(u_dd, 2)[::2]]  # fmt: skip
    found = [simulate(m=np.int64(75), u_dd=given, **scene).x_r for given in same]  # type: ignore[arg-type]
    assert all(np.array_equal(x_r, found[0]) for x_r in found)
    assert found[0].any()


@pytest.mark.parametrize("F_fk", [0.0, 15.0, 45.0, 1e9])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_faulty_sample_is_named_wherever_the_mass_slides_or_sticks(
    F_fk: float, value: float
) -> None:
    smooth = 2.0 * np.sin(np.arange(600) * 0.05)
    scene = {"m": 75.0, "k_x": 7500.0, "b": 500.0, "F_fk": F_fk, "dt": 2.5e-3}
    for at in (0, 1, 40, 255, 256, 257, 511, 598, 599):
        u_dd = smooth.copy()
        u_dd[at] = value
        u_dd[at + 30 :: 50] = math.nan
        with pytest.raises(UsageError, match=rf"u_dd\[{at}\] must be a finite number"):
            simulate(u_dd=u_dd, **scene)


STEPPED = [
    (Signum(), 0.02), (Signum(method="rk4"), 0.02), (Smooth(sharpness=1e4), 0.01),
    (Switch(), 0.02), (Moreau(), 5e-3),
]  # fmt: skip


@pytest.mark.parametrize(("approach", "off"), STEPPED)
def test_fixed_steps_come_near_the_exact_motion_where_the_mass_slides(
    approach: Approach, off: float
) -> None:
    law, motion = CoulombLaw(15.0, 15.0), Sines((1.0,), (5.0,), (0.3,))
    exact = StickSlip().solve(PAPER, law, motion, REST, 5e-4, 4.0)
    near = approach.solve(PAPER, law, motion, REST, 5e-4, 4.0)
    assert np.abs(near.x_r - exact.x_r).max() <= off * np.abs(exact.x_r).max()


def test_signum_invents_vibration_that_no_smaller_step_cures() -> None:
    # Where the mass stands still signum gives T_a = F_fk/(m a_u), whatever the integrator.
    law, motion = CoulombLaw(45.0, 45.0), Sines((0.33 * math.sqrt(2),), (5.0,), (0.0,))
    for method in ("euler", "semi-implicit", "heun", "rk4"):
        for step in (2.5e-3, 2.5e-4):
            response = Signum(method=method).solve(PAPER, law, motion, REST, step, 4.0)
            metrics = measure(track_of(response), (2.0, 4.0), None)
            assert metrics["T_a"] == pytest.approx(45.0 / (75.0 * 0.33), rel=0.02)
            if method in ("euler", "semi-implicit"):
                assert metrics["chatter_share"] > 0.6
            else:  # the sign changes between the stages of a step
                assert metrics["chatter_share"] < {"heun": 0.02, "rk4": 0.11}[method]


def test_moreau_sticks_truly_and_converges() -> None:
    law, motion = CoulombLaw(45.0, 45.0), Sines((0.75 * math.sqrt(2),), (2.0,), (0.0,))
    exact = StickSlip().solve(PAPER, law, motion, REST, 2.5e-3, 4.0)
    errors = []
    for step in (2.5e-3, 1.25e-3):
        near = Moreau().solve(PAPER, law, motion, REST, step, 4.0)
        metrics = measure(track_of(near), (0.0, 4.0), None)
        assert metrics["chatter_share"] == 0.0
        assert metrics["stuck_share"] > 0.05
        every = round(2.5e-3 / step)
        errors.append(np.abs(near.x_r[::every] - exact.x_r).max())
    assert errors[0] < 2e-3 * np.abs(exact.x_r).max()
    assert errors[1] < errors[0] / 1.5


@pytest.mark.parametrize("form", ["arctan", "tanh", "erf", "rational"])
def test_smooth_forms_tend_to_the_exact_answer_as_they_sharpen(form: str) -> None:
    law, motion = CoulombLaw(15.0, 15.0), Sines((0.5 * math.sqrt(2),), (5.0,), (0.0,))
    exact = measure(
        track_of(StickSlip().solve(PAPER, law, motion, REST, 1e-3, 4.0)), (2.0, 4.0), None
    )
    off = []
    for sharpness in (1e2, 1e3):
        smooth = Smooth(form=form, sharpness=sharpness)
        metrics = measure(
            track_of(smooth.solve(PAPER, law, motion, REST, 1e-3, 4.0)), (2.0, 4.0), None
        )
        off.append(abs(metrics["T_a"] / exact["T_a"] - 1.0))
    assert off[1] < off[0] / 3


def test_adaptive_smooth_agrees_with_small_fixed_steps() -> None:
    law, motion = CoulombLaw(15.0, 15.0), Sines((1.0,), (5.0,), (0.3,))
    adaptive, fixed = (
        Smooth(sharpness=300.0, method=method).solve(PAPER, law, motion, REST, 1e-3, 1.0)
        for method in ("adaptive", "rk4")
    )
    assert np.abs(adaptive.x_r - fixed.x_r).max() <= 1e-6 * np.abs(fixed.x_r).max()


def test_fixed_step_that_blows_up_is_said_with_its_time() -> None:
    stiff = Plant(1.0, 1e6, 0.0)
    with pytest.raises(SolverError, match=r"a step of 0\.1 s diverges at t ="):
        Signum(method="euler").solve(stiff, CoulombLaw(1.0, 1.0), SINE, REST, 0.1, 500.0)


def test_smooth_knows_the_displacement_of_the_base_where_it_is_known() -> None:
    # Between samples u is the cubic that ü bends, so a finer grid reads it as it is.
    dt, omega = 5e-3, 4.0
    t = np.arange(801) * dt
    h = 2 * math.sin(omega * dt / 2) / dt
    motion = Samples(-(h**2) * np.sin(omega * t), dt, u=np.sin(omega * t))
    law = CoulombLaw(15.0, 15.0)
    found, exact = (
        measure(track_of(approach.solve(PAPER, law, motion, REST, dt)), (0.0, 4.0), None)
        for approach in (Smooth(), StickSlip())
    )
    assert found["u_rms"] == pytest.approx(exact["u_rms"], rel=1e-3)
    assert found["T_x"] == pytest.approx(exact["T_x"], rel=2e-2)
