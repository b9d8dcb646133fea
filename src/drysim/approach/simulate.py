"""`simulate`: one call from arrays to arrays, without a scenario file.

Most of this module validates and converts the arguments.
"""

from __future__ import annotations

import math
from functools import partial
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from drysim.approach import APPROACHES_BY_NAME, EXACT, Approach
from drysim.approach.cost import StepCost, step_cost
from drysim.approach.solution import Events, Grid, Numerics, Response, elements
from drysim.core.compile import choose_engine
from drysim.core.model import (
    AnyLaw,
    CoulombLaw,
    EndStops,
    Floats,
    PiecewiseLaw,
    Plant,
    Points,
    Samples,
    State,
    StrokeLimits,
    limit_force,
)
from drysim.errors import SolverError, UsageError
from drysim.messages import shorten
from drysim.quantity import MAX_MAGNITUDE, MIN_MAGNITUDE

NUMERIC_KINDS = "iuf"
"""numpy kinds of integers and floats; arrays of other kinds are checked element by element."""


def simulate(
    *,
    m: float,
    k_x: float,
    b: float,
    F_fk: float = 0.0,
    F_fs: float | None = None,
    u_dd: ArrayLike,
    dt: float,
    x_r: float = 0.0,
    v_r: float = 0.0,
    approach: str = EXACT,
    x_rM: float | None = None,
    k_s: float | None = None,
    b_s: float = 0.0,
    e: float | None = None,
) -> Response:
    """Simulate the oscillator on a base with sampled acceleration.

    Parameters
    ----------
    m, k_x, b : float
        Mass [kg], stiffness [N/m] and viscous damping [N·s/m].
    F_fk, F_fs : float
        Kinetic friction force and static limit [N]; the static limit defaults to the kinetic
        force.
    u_dd : array_like, shape (n,)
        Base acceleration [m/s²], linear between samples.
    dt : float
        Step of the samples [s].
    x_r, v_r : float
        State at the first sample [m, m/s].
    approach : str
        Name of an approach.
    x_rM : float or None
        Position of the end stops [m], at |x_r| = x_rM; None for no stops.
    k_s, b_s : float
        Stiffness [N/m] and damping [N·s/m] of elastic stops.
    e : float or None
        Coefficient of restitution [-] of rigid stops, 0 to 1.

    Returns
    -------
    Response
        Arrays of shape (n,): t, x_r, v_r, x_dd, F_f, stuck, and F_stop of end stops; and the
        events.

    Raises
    ------
    UsageError
        If an argument is not a number, is not physical, or is not supported by the approach.
    SolverError
        If events do not advance in time, or the motion is not finite.
    """
    samples = to_samples("u_dd", u_dd)
    law = CoulombLaw(to_float("F_fk", F_fk), to_float("F_fs", F_fk if F_fs is None else F_fs))
    plant = Plant(to_float("m", m), to_float("k_x", k_x), to_float("b", b))
    start = State(to_float("x_r", x_r), to_float("v_r", v_r))
    motion = Samples(samples, to_float("dt", dt))
    check_arguments(plant, law, motion.dt, start)
    if not isinstance(approach, str) or approach not in APPROACHES_BY_NAME:
        raise UsageError(
            f"unknown approach `{approach}`", f"choose from {', '.join(APPROACHES_BY_NAME)}"
        )
    method = APPROACHES_BY_NAME[approach]
    if law.F_fs > law.F_fk and method.supports_friction and not method.supports_static:
        raise UsageError(
            f"{approach} does not model a static limit: F_fs = {law.F_fs:g} N must equal F_fk",
            "leave F_fs out, or choose `stick-slip` or `switch`",
        )
    if any(argument is not None for argument in (x_rM, k_s, e)) or to_float("b_s", b_s) != 0.0:
        stopped = stop_law(law, x_rM, k_s, b_s, e, start)
        if not method.supports_stops:
            raise UsageError(
                f"{approach} does not model end stops", "leave x_rM out, or choose `stick-slip`"
            )
        check_samples(samples)
        choose_engine(*work(method(), stopped, motion))
        return method().solve(plant, stopped, motion, start, motion.dt)
    choose_engine(*work(method(), law, motion))
    if law.F_fs == 0.0 or not method.supports_friction:
        return solve_linear(plant, motion, start)
    if approach != EXACT:  # the exact solver finds faults itself; a search costs 5 %
        check_samples(samples)
    try:
        return method().solve(plant, law, motion, start, motion.dt)
    except SolverError:
        check_samples(samples)
        raise


def work(approach: Approach, law: AnyLaw, motion: Samples) -> StepCost:
    """Return the cost of all steps."""
    cost = step_cost(approach, law, motion)
    return cost._replace(steps=len(motion.u_dd) * cost.steps)


def stop_law(
    law: CoulombLaw,
    x_rM: float | None,
    k_s: float | None,
    b_s: float,
    e: float | None,
    start: State,
) -> PiecewiseLaw:
    """Return the law of friction and end stops; raise UsageError for invalid stops."""
    if x_rM is None or (k_s is None) == (e is None):
        raise UsageError("end stops need x_rM and either k_s (bumpers) or e (rigid)")
    x_rM, b_s = to_float("x_rM", x_rM), to_float("b_s", b_s)
    k_s, e = (
        None if argument is None else to_float(name, argument)
        for name, argument in (("k_s", k_s), ("e", e))
    )
    for name, value in (("x_rM", x_rM), ("k_s", 1.0 if k_s is None else k_s)):
        if not (math.isfinite(value) and value > 0.0):
            raise UsageError(f"{name} must be a finite number above 0, not {value:g}")
        check_magnitude(name, value)
    if not (math.isfinite(b_s) and b_s >= 0.0 and (b_s == 0.0 or e is None)):
        raise UsageError(f"b_s must be at least 0, and 0 with e, not {b_s:g}")
    check_magnitude("b_s", b_s)
    if e is not None and not 0.0 <= e <= 1.0:
        raise UsageError(f"e must lie between 0 and 1, not {e:g}")
    if e is not None and abs(start.x_r) > x_rM:
        raise UsageError(f"x_r = {start.x_r:g} m is beyond the rigid stops at {x_rM:g} m")
    stages = () if k_s is None else ((0.0, k_s),)
    stops = EndStops(StrokeLimits(x_rM, x_rM), stages, b_s, e or 0.0)
    return PiecewiseLaw(law.F_fk, law.F_fs, stops=stops)


def solve_linear(plant: Plant, motion: Samples, start: State) -> Response:
    """Return the motion without dry friction by one affine map per step.

    Turning points and metrics are not computed.
    """
    from drysim.core.compile import as_engine_array, engine
    from drysim.core.oscillator import linear_recursion

    u_dd = motion.u_dd[:]
    n = len(u_dd)
    x_r, v_r = as_engine_array(np.empty(n)), as_engine_array(np.empty(n))
    linear_recursion(plant, as_engine_array(u_dd), motion.dt, start.x_r, start.v_r, x_r, v_r)
    if not math.isfinite(x_r[-1] + v_r[-1]):
        check_samples(u_dd)
    F_L = limit_force(plant, start.x_r, u_dd[0])
    kind = np.array([np.sign(start.v_r) or -np.sign(F_L)], dtype=np.int8)
    events = Events(np.zeros(1), kind, np.array([start.x_r]), np.array([F_L]))
    why = "closed form in each step, no dry friction and no events"
    grid = Grid(motion.dt, n, partial(elements, u_dd), partial(linear_points, plant, x_r, v_r))
    numerics = Numerics("viscous", "recursion", why, engine(), n - 1, 1)
    return Response(plant, CoulombLaw(0.0, 0.0), motion, grid, events, numerics)


def linear_points(plant: Plant, x_r: Floats, v_r: Floats, first: int, last: int) -> Points:
    """Return grid points `first` to `last` - 1 of a motion without friction."""
    x, v = np.asarray(x_r)[first:last], np.asarray(v_r)[first:last]
    x_dd = x * (-plant.k_x / plant.m)
    x_dd -= v * (plant.b / plant.m)
    return Points(x, v, np.ones(len(x), dtype=np.int8), x_dd)


def to_float(name: str, argument: ArrayLike) -> float:
    """Convert an argument to a float; raise UsageError if it is not a number."""
    number = to_array(name, argument, "a number in SI")
    if number.ndim:
        raise UsageError(f"{name} must be a number in SI, not {shorten(repr(argument))}")
    return float(number)


def to_samples(name: str, argument: ArrayLike) -> Floats:
    """Convert an argument to an array of at least two samples, or raise UsageError."""
    samples = to_array(name, argument, "a one-dimensional array of numbers")
    if samples.ndim != 1 or len(samples) < 2:
        shape = f"not of shape {samples.shape}"
        raise UsageError(
            f"{name} must be a one-dimensional array of at least 2 samples, {shape}"
        )
    return samples


def to_array(name: str, argument: ArrayLike, what: str) -> Floats:
    """Convert integers and floats to an array; raise UsageError for anything else.

    Strings, booleans, dates, complex numbers and masked values are rejected.
    """
    try:
        array = np.asarray(argument)
        if array.dtype.kind not in NUMERIC_KINDS:
            array = np.asarray(argument, dtype=object)
            for index, value in np.ndenumerate(array):
                if isinstance(value, bool) or not isinstance(value, Real):
                    which = f"{name}{list(index) if index else ''}"
                    raise UsageError(
                        f"{which} must be a number in SI, not {shorten(repr(value))}"
                    )
        mask = getattr(argument, "mask", None) if isinstance(argument, np.ndarray) else None
        if mask is not None and np.any(mask):
            raise UsageError(f"{name} has masked values; fill them or remove them")
        return np.asarray(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as fault:
        raise UsageError(f"{name} must be {what}: {fault}") from None


def check_arguments(plant: Plant, law: CoulombLaw, dt: float, start: State) -> None:
    """Raise UsageError with the name of the first argument that is not physical."""
    named = {**plant._asdict(), "F_fk": law.F_fk, "F_fs": law.F_fs, "dt": dt, **start._asdict()}
    for name, value in named.items():
        if not math.isfinite(value):
            raise UsageError(f"{name} must be a finite number, not {value}")
        if value < 0.0 and name not in start._fields:
            bound = "above 0" if name in ("m", "dt") else "at least 0"
            raise UsageError(f"{name} must be {bound}, not {value:g}")
        check_magnitude(name, value)
    if plant.m == 0.0 or dt == 0.0:
        raise UsageError(f"{'dt' if plant.m else 'm'} must be above 0")
    if law.F_fs < law.F_fk:
        raise UsageError(f"F_fs = {law.F_fs:g} N must be at least F_fk = {law.F_fk:g} N")


def check_magnitude(name: str, value: float) -> None:
    """Raise UsageError for a number outside the bounds of a scenario file."""
    if value and not MIN_MAGNITUDE <= abs(value) <= MAX_MAGNITUDE:
        span = f"{MIN_MAGNITUDE:g} and {MAX_MAGNITUDE:g}"
        raise UsageError(f"{name} must lie between {span} in size, or be 0, not {value:g}")


def check_samples(u_dd: Floats) -> None:
    """Raise UsageError for the first sample that is not finite or too large."""
    if not (u_dd.min() >= -MAX_MAGNITUDE and u_dd.max() <= MAX_MAGNITUDE):
        index = int(np.flatnonzero(~(np.abs(u_dd) <= MAX_MAGNITUDE))[0])
        if not math.isfinite(u_dd[index]):
            raise UsageError(f"u_dd[{index}] must be a finite number, not {u_dd[index]}")
        raise UsageError(
            f"u_dd[{index}] must be at most {MAX_MAGNITUDE:g} in size, not {u_dd[index]:g}"
        )
