"""What is solved, in words: the oscillator, its dry friction, its end stops."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import pi, sqrt

from drysim.core.normal_force.normal import Pressed, Pressure
from drysim.core.plant import AnyLaw, Dynamic, Law, Plant, Slider, Stopped
from drysim.wording.numbers import clean, length, number, percent

EVERY = {"kinetic": True, "static": True}
"""Friction forces that all cases share, where there is one case."""

NONE: Mapping[str, float] = {}
"""The ratios of a scene that is given by forces and damping alone."""


def scene(
    plant: Plant,
    law: AnyLaw,
    defaulted: bool = False,
    terms: Sequence[str] = (),
    swept: Collection[str] = (),
    shared: Mapping[str, bool] = EVERY,
    ratios: Mapping[str, float] = NONE,
    peak: float | None = None,
) -> Iterator[tuple[str, str]]:
    """Give what is solved, head by head: oscillator, friction, end stops where there are any.

    `shared` says whether all cases have one `kinetic` and one `static` friction force; the
    other parameters are those of `oscillator` and `friction`. What varies is left out. The
    greatest |x_r| [m], where it is known, gives the unit of end stops.
    """
    forces = friction(law, defaulted, **shared, terms=terms, swept=swept, ratios=ratios)
    heads = (
        ("oscillator", oscillator(plant, swept, ratios)),
        ("friction", forces),
        ("end stops", stops(law, swept, peak)),
    )
    return ((head, words) for head, words in heads if words)


def oscillator(
    plant: Plant, swept: Collection[str] = (), ratios: Mapping[str, float] = NONE
) -> str:
    """Give mass, spring and damper, with what follows from them.

    Parameters
    ----------
    plant : Plant
    swept : collection of str, optional
        Keys that vary from case to case; what they decide is left out.
    ratios : mapping, optional
        What the scenario gives as a ratio, `damping_ratio` and `static_ratio`: it stays where
        what it refers to varies.
    """
    varied = [key for key in swept if key.startswith("oscillator.")]
    m, k_x = "oscillator.mass" not in varied, "oscillator.stiffness" not in varied
    damped = not any("damping" in key for key in varied)
    by_ratio = "damping_ratio" in ratios
    parts = [f"m {number(plant.m, 'kg')}"] * m + [f"k_x {number(plant.k_x, 'N/m')}"] * k_x
    if damped and (not varied or not by_ratio):
        parts.append(f"b {number(plant.b, 'N·s/m')}")
    if plant.k_x > 0 and m and k_x:
        parts.append(f"f_0 {number(sqrt(plant.k_x / plant.m) / (2 * pi), 'Hz')}")
    if plant.k_x > 0 and damped and (not varied or by_ratio):
        xi = plant.b / (2 * sqrt(plant.m * plant.k_x))
        parts.append(f"ξ {number(xi, digits=3)}")
    return ", ".join(parts)


def friction(
    law: AnyLaw,
    defaulted: bool = False,
    kinetic: bool = True,
    static: bool = True,
    terms: Sequence[str] = (),
    swept: Collection[str] = (),
    ratios: Mapping[str, float] = NONE,
) -> str:
    """Give the dry friction.

    Parameters
    ----------
    law : AnyLaw
    defaulted : bool, optional
        Nobody named a static limit.
    kinetic, static : bool, optional
        Whether all cases share the force; one that they do not share is left out.
    terms : sequence of str, optional
        The name of a law other than Coulomb's, and what it has besides its forces.
    swept : collection of str, optional
        As in `oscillator`: how the normal force varies is left out where they decide it.
    ratios : mapping, optional
        As in `oscillator`.
    """
    if law.F_fs == 0 and kinetic and static:
        return "no dry friction"
    limit = static and (not terms or law.F_fs > law.F_fk)
    parts = [f"F_fk {number(law.F_fk, 'N')}"] * kinetic + [
        f"F_fs {number(law.F_fs, 'N')}"
    ] * limit
    if not static and "static_ratio" in ratios and "friction.static_ratio" not in swept:
        parts.append(f"F_fs/F_fk {number(ratios['static_ratio'])}")
    text = ", ".join([*terms[:1], *parts])
    if defaulted:
        text += " (not given: F_fs = F_fk)" if text else "F_fs = F_fk (not given)"
    text = ", ".join(filter(None, (text, *terms[1:])))
    varied = {key.rpartition(".")[2] for key in swept if key.startswith("friction.normal_")}
    if not isinstance(law, Dynamic) and law.variation and kinetic and static:
        text += _variation(law, varied)
    if isinstance(law, Pressed) and law.pressure is not None:
        text += f", {_pressure(law.pressure, bool(varied))}"
    return text


def _variation(law: Law | Stopped | Pressed | Slider, varied: Collection[str]) -> str:
    """Give how the normal force varies as a sine, as far as all cases share it."""
    parts = []
    if not {"amplitude", "normal_stiffness"} & {*varied}:
        parts.append(f"± {percent(law.variation)}")
    if "frequency" not in varied:
        parts.append(f"at {number(law.omega / (2 * pi), 'Hz')}")
    whose = "load" if isinstance(law, Slider) else "both"
    return f", {whose} {'varying ' * (parts[0][0] == 'a')}{' '.join(parts)}" if parts else ""


def stops(law: AnyLaw, swept: Collection[str] = (), peak: float | None = None) -> str:
    """Return the end stops, empty where there are none; `swept` as in `oscillator`."""
    if not isinstance(law, Stopped):
        return ""
    parts = [("limit", f"at ±{length(law.x_rM, peak)}")]
    if law.rigid:
        parts += [("stops", "rigid"), ("restitution", f"restitution {number(law.e)}")]
    else:
        parts += [("stiffness", number(law.k_s, "N/m")), ("damping", number(law.b_s, "N·s/m"))]
    varied = {key.rpartition(".")[2] for key in swept if key.startswith("stroke.")}
    return ", ".join(words for key, words in parts if key not in varied)


def _pressure(pressure: Pressure, varied: bool) -> str:
    """Give a recorded normal force: what it lies between, if all cases share it; its file."""
    files = ", ".join(clean(source.file) for source in pressure.inputs)
    if varied:
        return f"F_N recorded ({files})"
    ends = float(pressure.relative.min()), float(pressure.relative.max())
    low, high = (number(pressure.mean * share, digits=3) for share in ends)
    return f"F_N {low} to {high} N ({files})"
