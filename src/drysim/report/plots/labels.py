"""The words for swept keys in a picture: the symbols of the paper, where it has some."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from drysim import wording
from drysim.study.sweeps.survey import FREQUENCY

if TYPE_CHECKING:
    from drysim.scenario import Axis

FORCES = ("friction.kinetic", "friction.mu_kinetic", "friction.normal")
"""Keys that are drawn as what they come to: the kinetic friction force."""

LABELS = {
    FREQUENCY: "frequency $f$ [Hz]",
    "excitation.rms": "base acceleration $a_u$ RMS [m/s²]",
    **dict.fromkeys(FORCES, "kinetic friction force $F_{fk}$ [N]"),
}

SYMBOLS = {
    FREQUENCY: "$f$",
    "excitation.rms": "$a_u$",
    "oscillator.mass": "$m$",
    "oscillator.stiffness": "$k_x$",
    "oscillator.damping": "$b$",
    "oscillator.damping_ratio": "$\\xi$",
    "friction.kinetic": "$F_{fk}$",
    "friction.static": "$F_{fs}$",
    "friction.static_ratio": "$F_{fs}/F_{fk}$",
    "friction.normal": "$F_N$",
    "friction.mu_kinetic": "$\\mu_k$",
}
"""Keys that a legend calls by the symbols of the paper."""


def axis_label(axis: Axis) -> str:
    """Give the words for a swept key with their unit; for `FORCES` those of the force."""
    return LABELS.get(axis.key) or key_label(axis)


def key_label(axis: Axis) -> str:
    """Give the words for a swept key with its own unit, whatever it comes to."""
    if axis.key in LABELS and axis.key not in FORCES[1:]:
        return LABELS[axis.key]
    symbol = SYMBOLS.get(axis.key)
    name = axis.key.rpartition(".")[2].replace("_", " ")
    words = f"{name} {symbol}" if symbol else axis.key
    return f"{words} [{wording.pretty(axis.unit) or '–'}]"


def spoken(point: Mapping[str, float], axes: Sequence[Axis]) -> str:
    """Give where a curve is, in symbols where the paper has some."""
    units = {axis.key: wording.pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{SYMBOLS.get(key, wording.short(key, units))} {wording.number(value, units[key])}"
        for key, value in point.items()
    )


def title(point: Mapping[str, float], axes: Sequence[Axis]) -> str:
    """Give the words for a panel: what tells it from the others."""
    several = {axis.key for axis in axes if len(axis.values) > 1}
    return spoken({key: value for key, value in point.items() if key in several}, axes)
