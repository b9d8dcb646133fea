"""What holds for every scene, whatever its numbers: laws of physics, and of arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from drawn import Scene
from hypothesis import note

from drysim.approach.solution import Trajectory
from drysim.core.events import sign
from drysim.metrics.table import measure

CLOSES = 1e-10
"""What the energy balance may leave [-]: rounding leaves 1e-13 on most scenes."""

ROUNDINGS = 8 * 2.0**-52
"""Relative error of a force put together afresh."""

SUBNORMAL = 1e-290
"""A force or a sample so small has products that are no normal numbers, and round on their own
[N, m/s²]."""

CLOSE = 1e-12
"""A margin between |F_L| and F_fs [-] that the rounding of a state may reverse."""

GRAZING = 1e-7
"""A margin [-] of a stop at a double root of the velocity: square root of rounding, times 7."""

Law = Callable[[Scene], None]


def energy_closes(scene: Scene) -> None:
    """Work of the base = change of energy + viscous loss + friction loss.

    Distances are differences of x_r, whose rounding is work of friction, too.
    """
    values = measure(scene.trajectory(), (0.0, scene.end), None)
    keys = "energy_input", "energy_stored", "energy_friction", "energy_viscous"
    exchanged = max((abs(values[key]) for key in keys), default=0.0)
    rounding = ROUNDINGS * scene.F_fs * values["x_r_peak"]
    assert values["energy_residual"] * exchanged <= CLOSES * exchanged + rounding


def stuck_means_stuck(scene: Scene) -> None:
    """Where the mass is stuck its relative velocity is zero, and the interface bears F_L."""
    response = scene.response()
    stuck = response.stuck
    assert (response.v_r[stuck] == 0.0).all()
    spring, inertia = scene.k_x * response.x_r, scene.m * response.u_dd
    swing, f, phase = scene.variation
    limit = scene.F_fs * (1.0 + swing * np.sin(2.0 * math.pi * f * response.t + phase))
    beyond = np.abs(spring + inertia) - limit
    slack = ROUNDINGS * (np.abs(spring) + np.abs(inertia) + scene.F_fs)
    slack += 2.0**-50 * scene.m * sum(abs(A) * f * scene.end * 7.0 for A, f, _ in scene.sines)
    slack += 2.0**-50 * scene.F_fs * swing * f * scene.end * 7.0
    assert (beyond[stuck] <= slack[stuck]).all()


def friction_only_takes(scene: Scene) -> None:
    """Friction never pushes: F_f v_r >= 0 on the grid, and between events x_r goes one way."""
    response = scene.response()
    assert (response.F_f * response.v_r >= 0.0).all()
    trajectory = scene.trajectory()
    way = np.diff(np.append(trajectory.events.x_r, trajectory.state(scene.end).x_r))
    going = np.array([sign(int(kind)) for kind in trajectory.events.kind])
    scale = np.abs(trajectory.events.x_r).max() + np.abs(way).max()
    assert (going * way >= -ROUNDINGS * scale).all()
    assert (way[going == 0] == 0.0).all()


def mirror_is_exact(scene: Scene) -> None:
    """-ü gives -x_r, bit for bit."""
    other = scene._replace(
        x_r=-scene.x_r,
        v_r=-scene.v_r,
        u_dd=tuple(-value for value in scene.u_dd),
        sines=tuple((-A, f, phase) for A, f, phase in scene.sines),
    )
    same(scene, other, x=-1.0)


def motion_scales_with_its_causes(scene: Scene) -> None:
    """(ü, F_fk, F_fs, start) times 2^20 give x_r times 2^20, bit for bit."""
    factor = 2.0**20
    if not subnormal(scene):
        same(scene, scaled(scene, force=factor, motion=factor), x=factor)


def subnormal(scene: Scene) -> bool:
    """Whether numbers of a scene round on their own in other units."""
    return any(0.0 < abs(value) < SUBNORMAL for value in (scene.F_fk, *scene.u_dd))


def mass_is_a_unit(scene: Scene) -> None:
    """(m, k_x, b, F_fk, F_fs) times 2^-17 change nothing, bit for bit."""
    factor = 2.0**-17
    if not subnormal(scene):
        other = scaled(scene, force=factor)
        m, k_x, b = (factor * value for value in scene.plant)
        same(scene, other._replace(m=m, k_x=k_x, b=b))


def time_is_a_unit(scene: Scene) -> None:
    """Everything twice as slow gives x_r times 4, bit for bit."""
    if subnormal(scene):
        return
    same(
        scene,
        scene._replace(
            b=0.5 * scene.b,
            k_x=0.25 * scene.k_x,
            x_r=4.0 * scene.x_r,
            v_r=2.0 * scene.v_r,
            sines=tuple((A, 0.5 * f, phase) for A, f, phase in scene.sines),
            variation=(scene.variation[0], 0.5 * scene.variation[1], scene.variation[2]),
            dt=2.0 * scene.dt,
            duration=2.0 * scene.duration,
        ),
        x=4.0,
        t=2.0,
    )


def split_run_equals_the_whole(scene: Scene) -> None:
    """Stopped at half time and begun anew from its state and mode, the motion is the same."""
    if len(scene.u_dd) == 2:
        return
    first, second = halves(scene)
    trajectory, whole = first.trajectory(), scene.trajectory()
    middle, mode = (trajectory.state(first.end), sign(int(trajectory.events.kind[-1])))
    rest = second._replace(x_r=middle.x_r, v_r=middle.v_r).trajectory()
    if sign(int(rest.events.kind[0])) != mode or hinges(scene, whole):
        return  # broken away but not moving yet: the state alone does not tell the mode
    scale = np.abs(whole.events.x_r).max() + abs(whole.state(scene.end).x_r)
    gap = abs(rest.state(second.end).x_r - whole.state(scene.end).x_r)
    assert gap <= 1e-9 * scale


def halves(scene: Scene) -> tuple[Scene, Scene]:
    """Return the first half of a scene, and the second with its clock put back."""
    half = (len(scene.u_dd) - 1) // 2 * scene.dt if scene.u_dd else 0.5 * scene.duration
    cut = (len(scene.u_dd) - 1) // 2
    swing, f, phase = scene.variation
    later = (swing, f, phase + 2.0 * math.pi * ((f * half) % 1.0))
    sines = tuple(
        (A, f, phase + 2.0 * math.pi * ((f * half) % 1.0)) for A, f, phase in scene.sines
    )
    second = scene._replace(u_dd=scene.u_dd[cut:], sines=sines, variation=later)
    return (
        scene._replace(u_dd=scene.u_dd[: cut + 1], duration=half),
        second._replace(duration=scene.duration - half),
    )


def finer_grid_changes_no_metric(scene: Scene) -> None:
    """Metrics come from the continuous solution: the same lines on half the step.

    Only the time at rest is less certain where the mass stops at a double root of its velocity
    (an undamped mass on a straight ramp): known to the square root of rounding alone.
    """
    if not scene.u_dd:
        return
    n = len(scene.u_dd)
    fine = np.interp(np.arange(2 * n - 1) / 2, np.arange(n), scene.u_dd)
    other = scene._replace(u_dd=tuple(fine.tolist()), dt=0.5 * scene.dt)
    one, two = scene.trajectory(), other.trajectory()
    if hinges(scene, one) or hinges(other, two):
        return
    metrics = [measure(trajectory, (0.0, scene.end), None) for trajectory in (one, two)]
    # A mass that creeps to its place, or swings there without friction, stands once rounding
    # says so: creeping it may have 1e-4 of its way left after half a swing.
    creeps = scene.b**2 >= 0.9 * 4.0 * scene.k_x * scene.m
    swings = scene.F_fs <= CLOSE * scene.m * max(map(abs, scene.u_dd))
    grazes = min(one.closest_decision, two.closest_decision) <= GRAZING
    rests = () if creeps or swings or grazes else ("stuck_share",)
    # The time of a break-away is known to the rounding of forces, which may be far larger than
    # what drives the mass after it.
    a_scale = (scene.F_fs + scene.k_x * metrics[0]["x_r_peak"]) / scene.m
    rounding = {"a_x": 1e-10 * a_scale, "v_r_rms": 1e-12 * a_scale * scene.end}
    for name in ("a_x", "x_r_rms", "x_r_peak", "v_r_rms", *rests):
        allowed = max(rounding.get(name, 0.0), 1e-13)
        assert metrics[1][name] == pytest.approx(metrics[0][name], rel=1e-9, abs=allowed)


def hinges(scene: Scene, trajectory: Trajectory) -> bool:
    """Whether a stop, or the start from rest, was decided by rounding alone."""
    start = trajectory.events
    margin = abs(abs(start.F_L[0]) - scene.F_fs) if scene.v_r == 0.0 else scene.F_fs
    return trajectory.closest_decision <= CLOSE or bool(margin <= CLOSE * scene.F_fs)


def scaled(scene: Scene, force: float, motion: float = 1.0) -> Scene:
    """Return a scene with its friction forces and its motion times a factor each."""
    return scene._replace(
        F_fk=force * scene.F_fk,
        F_fs=force * scene.F_fs,
        x_r=motion * scene.x_r,
        v_r=motion * scene.v_r,
        u_dd=tuple(motion * value for value in scene.u_dd),
        sines=tuple((motion * A, f, phase) for A, f, phase in scene.sines),
    )


def same(scene: Scene, other: Scene, x: float = 1.0, t: float = 1.0) -> None:
    """Two scenes have the same events, but for a factor on places and one on times."""
    one, two = scene.trajectory(), other.trajectory()
    note(f"{one.events}\n{two.events}")
    assert np.array_equal(two.events.kind, one.events.kind * (-1 if x < 0 else 1))
    assert np.array_equal(two.events.t, one.events.t * t)
    assert np.array_equal(two.events.x_r, one.events.x_r * x)
    assert two.state(other.end) == pytest.approx(
        (one.state(scene.end).x_r * x, one.state(scene.end).v_r * x / t), rel=0.0, abs=0.0
    )


LAWS = (
    energy_closes,
    stuck_means_stuck,
    friction_only_takes,
    mirror_is_exact,
    motion_scales_with_its_causes,
    mass_is_a_unit,
    time_is_a_unit,
    split_run_equals_the_whole,
    finer_grid_changes_no_metric,
)
