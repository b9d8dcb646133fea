"""Time the laws that have no closed form beside scipy's integrators: `make laws` runs it.

Each solves the paper's oscillator on a sine for 20 s, at an error of 1e-8 of the greatest
displacement: drysim at the coarsest tolerance that keeps it, scipy's `solve_ivp` at its own
1e-8, restarted at the events that the law has. Both give the motion on the same grid; drysim
then once more with its error stated, which takes a second solution. Processor time, medians.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from hysteresis import swing
from law_scenes import PAPER, REST, sine, solved
from scipy.integrate import solve_ivp  # noqa: TID253 - what it is compared with

from drysim.approach.stick_slip import StickSlip
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine
from drysim.core.model import BRISTLE, LEUVEN, STRIBECK, DynamicLaw

END, ERROR = 20.0, 1e-8
REPEATS, MANY = 5, 20

MOTION = sine(1.0, 1.6)
LAWS = {
    "stribeck": DynamicLaw(15.0, 18.0, STRIBECK, v_s=5e-3),
    "dahl": DynamicLaw(45.0, 45.0, BRISTLE, sigma_0=1e5),
    "lugre": DynamicLaw(45.0, 54.0, BRISTLE, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4),
    "leuven": DynamicLaw(
        45.0, 54.0, LEUVEN, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4, F_h=80.0
    ),
}
TOLERANCES = (1e-9, 1e-10, 1e-11, 1e-12)
METHODS = ("LSODA", "DOP853")
OMEGA = 2.0 * math.pi * MOTION.f[0]


def base(t: float) -> float:
    """Return ü [m/s²]."""
    return MOTION.A[0] * math.sin(OMEGA * t)


def curve(law: DynamicLaw, v: float) -> float:
    """Return the Stribeck curve [N]."""
    return law.F_fk + (law.F_fs - law.F_fk) * math.exp(-((v / law.v_s) ** 2))


def bristles(law: DynamicLaw, t: np.ndarray, method: str) -> np.ndarray:
    """Return x_r [m] of bristles, whose motion has no events."""
    m, k_x, b = PAPER

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, v, z = y
        z_d = v - law.sigma_0 * abs(v) * z / curve(law, v)
        F = law.sigma_0 * z + law.sigma_1 * z_d + law.sigma_2 * v
        return [v, -base(t) - (k_x * x + b * v + F) / m, z_d]

    return solve_ivp(rates, (0.0, END), [0.0] * 3, method, t, rtol=ERROR, atol=1e-12).y[0]


def sliding(law: DynamicLaw, t: np.ndarray, method: str) -> np.ndarray:
    """Return x_r [m] under Stribeck's friction, restarted where the mass stops and starts."""
    m, k_x, b = PAPER
    now, x, d, path = 0.0, 0.0, 0, np.zeros(len(t))
    while now < END:
        if d == 0:
            begin, (now, d) = now, break_away(law, x, now)
            path[(t >= begin) & (t <= now)] = x
            continue

        def rates(t: float, y: np.ndarray, d: int = d) -> list[float]:
            F = d * curve(law, y[1])
            return [y[1], -base(t) - (k_x * y[0] + b * y[1] + F) / m]

        def stop(t: float, y: np.ndarray, d: int = d) -> float:
            return d * y[1]

        stop.terminal, stop.direction = True, -1  # type: ignore[attr-defined]
        found = solve_ivp(
            rates, (now, END), [x, 0.0], method, rtol=ERROR, atol=1e-12, events=stop,
            dense_output=True,
        )  # fmt: skip
        inside = (t >= now) & (t <= found.t[-1])
        path[inside] = found.sol(t[inside])[0]
        now, x = found.t[-1], found.y[0, -1]
        F_L = m * base(now) + k_x * x
        d = 0 if abs(F_L) <= law.F_fs else -1 if F_L > 0 else 1
    return path


def break_away(law: DynamicLaw, x: float, now: float) -> tuple[float, int]:
    """Return when a stuck mass breaks away [s], in closed form, and the direction it takes."""
    m, k_x, _ = PAPER
    found = [(END, 1)]
    for side in (1, -1):
        level = (side * law.F_fs - k_x * x) / (m * MOTION.A[0])
        if abs(level) < 1.0:
            rise = math.asin(side * level)  # the force grows towards its side there
            phase = rise if side > 0 else rise + math.pi
            turns = math.ceil((OMEGA * now - phase) / (2.0 * math.pi))
            found.append(((phase + 2.0 * math.pi * turns) / OMEGA, -side))
    return min(found)


def peer(law: DynamicLaw, t: np.ndarray, method: str) -> np.ndarray:
    """Return x_r [m] by scipy."""
    if law.kind == LEUVEN:
        return swing(law, PAPER, base, END, t, method, ERROR)
    return (sliding if law.kind == STRIBECK else bristles)(law, t, method)


def tolerance_for(law: DynamicLaw, exact: np.ndarray) -> float:
    """Return the coarsest tolerance whose motion is within the error."""
    for tolerance in TOLERANCES:
        x_r = solved(law._replace(tolerance=tolerance), MOTION, duration=END).x_r
        if np.abs(x_r - exact).max() < ERROR * np.abs(exact).max():
            return tolerance
    raise AssertionError("no tolerance keeps the error")


def spent(job: Callable[[], object]) -> float:
    """Return the time of the processor that a job takes [s]."""
    began = time.process_time()
    job()
    return time.process_time() - began


def report(name: str, law: DynamicLaw) -> str:
    """Measure a law and its peers in turn; gives a line."""
    exact = solved(law._replace(tolerance=1e-13), MOTION, duration=END)
    t, peak = exact.t, np.abs(exact.x_r).max()
    mine = law._replace(tolerance=tolerance_for(law, exact.x_r))

    def motion() -> object:
        return StickSlip().trajectory(PAPER, mine, MOTION, REST, END).at(t)

    jobs: dict[str, Callable[[], object]] = {
        "motion": lambda: [motion() for _ in range(MANY)],
        "stated": lambda: [solved(mine, MOTION, duration=END) for _ in range(MANY)],
        **{method: partial(peer, law, t, method) for method in METHODS},
    }
    errors = {
        method: np.abs(peer(law, t, method) - exact.x_r).max() / peak for method in METHODS
    }
    rounds = [{key: spent(job) for key, job in jobs.items()} for _ in range(REPEATS)]
    median = {key: 1e3 * statistics.median(each[key] for each in rounds) for key in jobs}
    motion_alone, stated = median["motion"] / MANY, median["stated"] / MANY
    beside = "; ".join(
        f"{key} {median[key]:.0f} ms (error {errors[key]:.0e}), "
        f"{median[key] / motion_alone:.0f} and {median[key] / stated:.0f} times"
        for key in METHODS
    )
    return (
        f"{name}: {motion_alone:.2f} ms, {stated:.2f} ms with its error stated, "
        f"tolerance {mine.tolerance:.0e}; {beside}"
    )


if __name__ == "__main__":
    choose_engine(MAX_PLAIN_STEPS + 1)
    for name, law in LAWS.items():
        print(report(name, law), flush=True)
