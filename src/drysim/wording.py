"""Numbers and scenes in words, for the terminal and for pictures alike."""

from __future__ import annotations

import re
from cmath import rect
from collections.abc import Collection, Mapping, Sequence
from math import floor, log10, pi, sqrt
from typing import Protocol

from drysim.core.motion import Samples, Sines
from drysim.core.plant import Law, Plant

SIGNIFICANT = 4
"""Digits that an engineer reads; the files hold them all."""

FEW = 5
"""Values of a swept key up to which each is named."""

UNKNOWN = "not known"


def number(value: float | None, unit: str = "", digits: int = SIGNIFICANT) -> str:
    """Give a number as people write it: few digits, no needless zeros, the unit behind.

    Parameters
    ----------
    value : float or None
        None reads `not known`.
    unit : str, optional
        Unit of the value; empty or a dash for none.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        E.g. `17.26 mm`, `7500 N/m`, `2.1e-15`.
    """
    if value is None:
        return UNKNOWN
    value += 0.0  # -0.0 is 0 to people
    size = floor(log10(abs(value))) if value and abs(value) < float("inf") else 0
    if -4 <= size < 6:
        text = f"{value:.{max(0, digits - 1 - size)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return f"{text} {unit}" if unit not in ("", "-", "–") else text


def millimetres(value: float | None) -> str:
    """Give a length [m] in millimetres, e.g. `17.26 mm`."""
    return number(None if value is None else value * 1e3, "mm")


def percent(share: float | None) -> str:
    """Give a share [-] in percent; what is neither 0 nor 1 is never rounded to look so."""
    if share is None:
        return UNKNOWN
    if 0 < share < 0.001 or 0.999 < share < 1:
        return "below 0.1 %" if share < 0.5 else "above 99.9 %"
    return number(share * 100, "%", 3)


def clean(text: str) -> str:
    """Give a user's text on one line, with all that could drive a terminal spelled out."""
    return "".join(map(_visible, " ".join(text.split())))


def _visible(sign: str) -> str:
    return sign if sign.isprintable() else sign.encode("unicode_escape").decode()


def scene(plant: Plant) -> str:
    """Give mass, spring and damper, with what follows from them."""
    parts = [
        f"m {number(plant.m, 'kg')}",
        f"k_x {number(plant.k_x, 'N/m')}",
        f"b {number(plant.b, 'N·s/m')}",
    ]
    if plant.k_x > 0:
        omega_0 = sqrt(plant.k_x / plant.m)
        parts.append(f"f_0 {number(omega_0 / (2 * pi), 'Hz')}")
        parts.append(f"ξ {number(plant.b / (2 * plant.m * omega_0), digits=3)}")
    return ", ".join(parts)


def unswept(plant: Plant, law: Law, axes: Sequence[Swept]) -> str:
    """Give what a sweep leaves alone of oscillator and friction; nothing of both varied."""
    blocks = {axis.key.partition(".")[0] for axis in axes if len(axis.values) > 1}
    known = [("oscillator", scene(plant)), ("friction", friction(law))]
    return "; ".join(words for block, words in known if block not in blocks)


def friction(law: Law, defaulted: bool = False) -> str:
    """Give the dry friction; `defaulted` says that nobody named a static limit."""
    if law.F_fs == 0:
        return "no dry friction"
    text = f"F_fk {number(law.F_fk, 'N')}, F_fs {number(law.F_fs, 'N')}"
    if defaulted:
        text += " (not given: F_fs = F_fk)"
    if law.variation:
        varied = f"± {percent(law.variation)} at {number(law.omega / (2 * pi), 'Hz')}"
        text += f", both {varied}"
    return text


def excitation(kind: str, motion: Sines | Samples) -> str:
    """Give the base motion: its kind on the shelf and what it amounts to."""
    if isinstance(motion, Samples):
        length = (len(motion.u_dd) - 1) * motion.dt
        files = "".join(f" {clean(source.file)}" for source in motion.inputs)
        files += f" {motion.realised['class']}" if "class" in motion.realised else ""
        grid = f"{len(motion.u_dd)} samples at {number(1 / motion.dt, 'Hz')}"
        return f"{kind}{files}, {grid}, {number(length, 's')}{_realised(motion)}"
    if not motion.A:
        return f"{kind}, the base stands still"
    low, high = min(motion.f), max(motion.f)
    band = number(low, "Hz") if low == high else f"{number(low)} to {number(high, 'Hz')}"
    count = f", {len(motion.A)} components," if len(motion.A) > 1 else ""
    return f"{kind}{count} {band}, {number(_rms(motion), 'm/s² RMS')}"


def _realised(motion: Samples) -> str:
    """Give what came out of a generated signal beside what was asked for."""
    words = []
    for name, unit in (("rms", "m/s² RMS"), ("velocity_change", "m/s velocity change")):
        found, asked = motion.realised.get(name), motion.realised.get(f"{name}_asked")
        if isinstance(found, float) and isinstance(asked, float):
            words.append(f"{number(found, unit)} (asked for: {number(asked)})")
    error = motion.realised.get("psd_error")
    if isinstance(error, float):
        words.append(f"PSD within {percent(error)} of its peak")
    return "".join(f", {word}" for word in words)


def _rms(motion: Sines) -> float:
    """Give the RMS of a sum of sines; those of one frequency add up by their phases."""
    sums: dict[float, complex] = {}
    for A, f, phase in zip(*motion, strict=True):
        sums[f] = sums.get(f, 0.0) + rect(A, phase)
    return sqrt(sum(abs(amplitude) ** 2 for amplitude in sums.values()) / 2)


class Swept(Protocol):
    """A swept key with its unit and values."""

    @property
    def key(self) -> str:
        """Dotted key of the scenario."""

    @property
    def unit(self) -> str:
        """SI unit as in the header of a table."""

    @property
    def values(self) -> tuple[float, ...]:
        """Values in the unit."""


def pretty(unit: str) -> str:
    """Give the unit of a table as people write it; nothing for a plain number."""
    signs = {"2": "²", "3": "³"}
    unit = re.sub(r"(?<=[a-z)])[23]", lambda digit: signs[digit[0]], unit)
    return "" if unit == "-" else unit.replace("*", "·")


def swept(axis: Swept) -> str:
    """Give what is swept, e.g. `excitation.frequency 0.5 to 10 Hz (96 values)`."""
    unit, values = pretty(axis.unit), axis.values
    if len(values) <= FEW:
        spelled = number(values[-1], unit)
        return f"{axis.key} {', '.join([*map(number, values[:-1]), spelled])}"
    low, high = number(min(values)), number(max(values), unit)
    return f"{axis.key} {low} to {high} ({len(values)} values)"


def place(point: Mapping[str, float], axes: Sequence[Swept]) -> str:
    """Give where a case is, e.g. `frequency 1.6 Hz, rms 0.5 m/s²`."""
    units = {axis.key: pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{short(key, units)} {number(value, units.get(key, ''))}"
        for key, value in point.items()
    )


def short(key: str, keys: Collection[str]) -> str:
    """Give the last word of a swept key, as long as no other ends in it."""
    last = key.rpartition(".")[2]
    return key if sum(other.rpartition(".")[2] == last for other in keys) > 1 else last
