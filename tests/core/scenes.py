"""Scenes for the kernels, and the shortest road from a scene to its events."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np

PAPER = (75.0, 7500.0, 500.0)
"""Mass, stiffness and damping of the paper's oscillator."""


def log_of(kernel: SimpleNamespace, length: int = 20_000) -> Any:
    """Return an empty log."""
    whole, kind = np.zeros(length, dtype=np.int64), np.zeros(length, dtype=np.int8)
    return kernel.events.EventLog(
        whole, np.zeros(length), kind, np.zeros(length), np.zeros(length)
    )


def march(
    kernel: SimpleNamespace,
    u_dd: np.ndarray,
    dt: float,
    F: tuple[float, float],
    plant: tuple[float, float, float] = PAPER,
    start: tuple[float, float] = (0.0, 0.0),
) -> SimpleNamespace:
    """March over samples from a start; gives x_r, v_r, d and the events."""
    core_plant, law = kernel.model.Plant(*plant), kernel.model.CoulombLaw(*F)
    n = len(u_dd)
    # What the march leaves unwritten shows.
    x_r, v_r, d = np.full(n, np.nan), np.full(n, np.nan), np.full(n, 9, dtype=np.int64)
    mode = kernel.events.initial_direction(core_plant, law, *start, u_dd[0])[0]
    x_r[0], v_r[0], d[0] = *start, mode
    log = log_of(kernel)
    sampled = kernel.sampled
    end = sampled.march(
        kernel.forcing.Scene(core_plant, law, waves_of(kernel, [], law), u_dd, dt),
        sampled.SlipState(0, 0.0, *start, mode, math.nan, 0, math.inf),
        sampled.SampledMotion(x_r, v_r, d),
        log,
        n - 1,
        sampled.empty_base_sums(),
    )
    events = [column[: end.events].copy() for column in log]
    return SimpleNamespace(x_r=x_r, v_r=v_r, d=d, t=events[0] * dt + events[1], events=events)


def piecewise(
    kernel: SimpleNamespace,
    F: tuple[float, float],
    *,
    b: float = 500.0,
    k_t: float = 0.0,
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0),
    stops: tuple[float, float, float, float] = (math.inf, 0.0, 0.0, 0.0),
) -> Any:
    """Return a piecewise-linear law; `stops` are limit, stiffness, damping and restitution."""
    limit, k_s, b_s, e = stops
    modes, record = kernel.modes, kernel.compile.as_engine_array(np.ones(2))
    side = modes.Side(*F, b, limit)
    stages = (k_s, 0.0, 0.0), (0.0, math.inf, math.inf)
    return modes.KernelLaw(side, side, k_t, *wave, record, 0.0, *stages, b_s, e)


def waves_of(kernel: SimpleNamespace, sines: list[tuple[float, float, float]], law: Any) -> Any:
    """Return waves from (amplitude, frequency, phase)."""
    rows = list(sines)
    if law.variation:
        rows.append((0.0, law.omega / (2 * math.pi), law.phase))
    values = np.zeros(kernel.forcing.WAVE_COLUMNS * len(rows))
    for i, row in enumerate(rows):
        kernel.forcing.set_wave(values, i, *row)
    return kernel.forcing.Waves(values, len(rows), len(sines))


def march_sines(
    kernel: SimpleNamespace,
    sines: list[tuple[float, float, float]],
    law: tuple[float, ...],
    duration: float,
    plant: tuple[float, float, float] = PAPER,
    start: tuple[float, float] = (0.0, 0.0),
    d: int | None = None,
) -> SimpleNamespace:
    """Leap under sines from a start; gives the end state and the events."""
    core_plant, core_law = kernel.model.Plant(*plant), kernel.model.CoulombLaw(*law)
    u_dd = sum(A * math.sin(phase) for A, _, phase in sines)
    mode = (
        kernel.events.initial_direction(core_plant, core_law, *start, u_dd)[0]
        if d is None
        else d
    )
    log = log_of(kernel)
    waves = waves_of(kernel, sines, core_law)
    interval = kernel.march.Interval(0, 0.0, duration, 0.0, 0.0)
    state = kernel.march.SlipState(0, 0.0, *start, mode, math.nan, 0, math.inf)
    _, t, x_r, v_r, d_end, _, count, closest = kernel.march.march_sines(
        core_plant, core_law, waves, interval, state, log
    )
    return SimpleNamespace(
        t=log.s[:count].copy(), kind=log.kind[:count].copy(), x=log.x_r[:count].copy(),
        end=(t, x_r, v_r, d_end), closest=closest, mode=mode,
    )  # fmt: skip


def march_modes(
    kernel: SimpleNamespace, scene: Any, state: Any, room: int, calls: int = 1
) -> Any:
    """March from mode to mode over samples, in a number of calls.

    Each call but the last ends where so many of the rows are full, or steps are done. Returns
    the numbers of segments and of events, and the `ModesLog`.
    """
    core, last = kernel.march, len(scene.u_dd) - 2
    kinds: dict[str, Any] = {"n": int, "d": int, "kind": np.int8}
    segments, log = (
        table(*(np.zeros(room, kinds.get(name, float)) for name in table._fields))
        for table in (kernel.events.Segments, kernel.events.EventLog)
    )
    samples = kernel.sampled.SampledMotion(
        *np.zeros((2, last + 2)), np.zeros(last + 2, np.int8)
    )
    samples.x_r[0], samples.v_r[0], samples.d[0] = state.xi, state.v_r, state.mode.direction
    steps = core.ModeSteps(
        0, np.zeros((core.MODES, kernel.oscillator.STEP_COLUMNS)),
        *np.zeros((2, core.MODES, kernel.sampled.CHUNK)), *np.full((2, core.MODES), -1),
    )  # fmt: skip
    out = core.ModesLog(segments, log, samples)
    for call in range(1, calls + 1):
        full = room * call // calls
        until = (last + 1) if call == calls else min(call * kernel.sampled.CHUNK, last + 1)
        course = core.Course(last, scene.dt, until, call == calls, full)
        state = core.march_modes(scene, course, state, steps, out)
    assert state.n == last + 1 or state.events < 0
    return state.used, state.events, out
