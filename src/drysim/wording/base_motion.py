"""How the base moves, in words."""

from __future__ import annotations

from cmath import rect
from collections.abc import Collection, Iterator
from math import sqrt
from typing import Protocol

from drysim.core.motion import Samples, Sines, sample_squares
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import AnyLaw
from drysim.core.signal import moments
from drysim.wording.numbers import clean, number, percent

MUCH = 0.1
"""A mean above this share of the RMS about it changes the RMS by more than half a hundredth."""


class Base(Protocol):
    """An excitation: its kind on the shelf, and the base motion that it gives."""

    @property
    def kind(self) -> str:
        """Kind on the shelf."""

    @property
    def periodic(self) -> bool:
        """Whether it is made of sines."""

    @property
    def own_end(self) -> bool:
        """Whether it has a length of its own."""

    def motion(self) -> Sines | Samples:
        """Give the base motion."""

    def told(self, varied: Collection[str] = ()) -> str:
        """Give what it is by its keys, without those that vary."""


def excitation(base: Base, motion: Sines | Samples, level: bool = True) -> str:
    """Give the base motion: its kind on the shelf, what it is, and what it amounts to.

    Without `level` the RMS of a record is left out.
    """
    kind = f"{base.kind} {base.told()}".strip()
    if isinstance(motion, Samples):
        length = (len(motion.u_dd) - 1) * motion.dt
        scale = _times(motion.realised.get("scale", 1.0))
        files = "".join(f" {clean(source.file)}{scale}" for source in motion.inputs)
        grid = f"{len(motion.u_dd)} samples at {number(1 / motion.dt, 'Hz')}"
        told = (_level(motion) if level and motion.inputs else "") + _realised(motion)
        return f"{kind}{files}, {grid}, {number(length, 's')}{told}"
    if not motion.A:
        return f"{kind}, the base stands still"
    count = f", {len(motion.A)} components," if len(motion.A) > 1 else ""
    return f"{kind}{count} {_band(motion)}, {number(_rms(motion), 'm/s² RMS')}"


def excitations(base: Base, swept: Collection[str]) -> str:
    """Give what the base motions of a sweep have in common, where a key of theirs is swept."""
    keys = [key.removeprefix("excitation.") for key in swept if key.startswith("excitation.")]
    varied = {key.rpartition(".")[2] for key in keys}
    words = f"{base.kind} {base.told(keys)}".strip()
    if hasattr(base, "named"):
        scale = 1.0 if "scale" in varied else getattr(base, "scale", 1.0)
        words += f" {clean(base.named)}{_times(scale)}"
    if not base.periodic:
        return words + "".join(f", {each}" for each in _asked(base, varied))
    motion = base.motion()
    assert isinstance(motion, Sines), "what has frequencies is made of sines"
    band = f" {_band(motion)}" if motion.A and "frequency" not in varied else ""
    level = motion.A and not varied & {"rms", "amplitude", "phase"}
    return words + band + (f", {number(_rms(motion), 'm/s² RMS')}" if level else "")


def _asked(base: Base, varied: Collection[str]) -> Iterator[str]:
    """Give length and level that are asked of a generated motion, and not swept."""
    if base.own_end and hasattr(base, "duration") and "duration" not in varied:
        yield number(base.duration, "s")
    for key, words in (("rms", "m/s² RMS"), ("amplitude", "m/s² amplitude")):
        level = getattr(base, key, None) if base.own_end else None
        if level is not None and key not in varied:
            yield number(level, words)


def clean_up(motion: Sines | Samples | None, law: AnyLaw | None = None) -> list[str]:
    """Give what was done to a record, and to that of a normal force, step by step."""
    steps = motion.realised.get("clean_up", ()) if isinstance(motion, Samples) else ()
    assert isinstance(steps, list | tuple)
    told = [clean(step["sentence"]) for step in steps]
    pressure = law.pressure if isinstance(law, Pressed) else None
    force = pressure.clean_up if pressure else ()
    return told + [f"normal force: {clean(str(step['sentence']))}" for step in force]


def _times(scale: object) -> str:
    """Give the factor on every sample of a record, if it has one."""
    assert isinstance(scale, float), "a factor is a number"
    return "" if scale == 1.0 else f" times {number(scale)}"


def _level(motion: Samples) -> str:
    """Return the RMS of a record, with its mean where that shows in the RMS."""
    end = (len(motion.u_dd) - 1) * motion.dt
    square = sample_squares(motion._replace(u=None), 0.0, end)[0] / end
    mean = moments(motion.u_dd)[0]
    about = sqrt(max(0.0, square - mean**2))
    level = f", {number(sqrt(square), 'm/s² RMS')}, linear between samples"
    if abs(mean) <= MUCH * about:
        return level
    return f"{level}; mean {number(mean, 'm/s²')}, {number(about, 'm/s² RMS')} about it"


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


def _band(motion: Sines) -> str:
    """Give the frequency of sines, or what their frequencies lie between."""
    low, high = min(motion.f), max(motion.f)
    return number(low, "Hz") if low == high else f"{number(low)} to {number(high, 'Hz')}"


def _rms(motion: Sines) -> float:
    """Give the RMS of a sum of sines; those of one frequency add up by their phases."""
    sums: dict[float, complex] = {}
    for A, f, phase in zip(*motion, strict=True):
        sums[f] = sums.get(f, 0.0) + rect(A, phase)
    return sqrt(sum(abs(amplitude) ** 2 for amplitude in sums.values()) / 2)
