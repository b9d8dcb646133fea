"""The gate of `simulate`: what it is given becomes numbers, or earns a sentence."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from drysim.approach.events import Floats
from drysim.core.plant import Law, Plant
from drysim.core.state import State
from drysim.errors import UsageError
from drysim.quantity import GREATEST, LEAST, short

NUMBERS = "iuf"
"""Kinds of integers and floats; all other arrays are looked at one by one."""


def plain(name: str, given: ArrayLike) -> float:
    """Give a number; raise UsageError where it is none."""
    number = numbers(name, given, "a number in SI")
    if number.ndim:
        raise UsageError(f"{name} must be a number in SI, not {short(repr(given))}")
    return float(number)


def row(name: str, given: ArrayLike) -> Floats:
    """Give samples as numbers; raise UsageError where they are none, or fewer than two."""
    samples = numbers(name, given, "a row of numbers")
    if samples.ndim != 1 or len(samples) < 2:
        shape = f"not of shape {samples.shape}"
        raise UsageError(f"{name} must be a row of at least 2 samples, {shape}")
    return samples


def numbers(name: str, given: ArrayLike, what: str) -> Floats:
    """Give integers and floats as an array; raise UsageError where there is anything else.

    Words, truth values, dates, complex numbers and masked values are none.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind not in NUMBERS:
            array = np.asarray(given, dtype=object)
            for at, one in np.ndenumerate(array):
                if isinstance(one, bool) or not isinstance(one, Real):
                    which = f"{name}{list(at) if at else ''}"
                    raise UsageError(f"{which} must be a number in SI, not {short(repr(one))}")
        mask = getattr(given, "mask", None) if isinstance(given, np.ndarray) else None
        if mask is not None and np.any(mask):
            raise UsageError(f"{name} has masked values; fill them, or cut them out")
        return np.asarray(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as fault:
        raise UsageError(f"{name} must be {what}: {fault}") from None


def refuse_nonsense(plant: Plant, law: Law, dt: float, start: State) -> None:
    """Raise UsageError, naming the argument, where the arguments describe no oscillator."""
    named = {**plant._asdict(), "F_fk": law.F_fk, "F_fs": law.F_fs, "dt": dt, **start._asdict()}
    for name, value in named.items():
        if not math.isfinite(value):
            raise UsageError(f"{name} must be a finite number, not {value}")
        if value < 0.0 and name not in start._fields:
            bound = "above 0" if name in ("m", "dt") else "at least 0"
            raise UsageError(f"{name} must be {bound}, not {value:g}")
        refuse_size(name, value)
    if plant.m == 0.0 or dt == 0.0:
        raise UsageError(f"{'dt' if plant.m else 'm'} must be above 0")
    if law.F_fs < law.F_fk:
        raise UsageError(f"F_fs = {law.F_fs:g} N must be at least F_fk = {law.F_fk:g} N")


def refuse_size(name: str, value: float) -> None:
    """Raise UsageError where a number is out of the bounds of a scenario file."""
    if value and not LEAST <= abs(value) <= GREATEST:
        span = f"{LEAST:g} and {GREATEST:g}"
        raise UsageError(f"{name} must lie between {span} in size, or be 0, not {value:g}")


def refuse_faults(u_dd: Floats) -> None:
    """Raise UsageError, naming the first, where samples are not finite or beyond all bounds."""
    if not (u_dd.min() >= -GREATEST and u_dd.max() <= GREATEST):
        at = int(np.flatnonzero(~(np.abs(u_dd) <= GREATEST))[0])
        if not math.isfinite(u_dd[at]):
            raise UsageError(f"u_dd[{at}] must be a finite number, not {u_dd[at]}")
        raise UsageError(f"u_dd[{at}] must be at most {GREATEST:g} in size, not {u_dd[at]:g}")
