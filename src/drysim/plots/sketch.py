"""Sketch of the model: a mass on a spring, a damper and a friction contact, on a moving base.

For a scenario, the sketch has the elements that its scene has, with their values.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drysim.core.model import has_friction
from drysim.plots.style import Style
from drysim.scenario.text import describe_limits
from drysim.wording import format_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.core.model import AnyLaw
    from drysim.scenario.model import Scenario

LINE: Style = {"color": "black", "linewidth": 1.4}
EDGE: Style = {"edgecolor": "black", "linewidth": 1.4}
ARROW: Style = {"arrowstyle": "-|>", "mutation_scale": 13, "color": "black"}
LEFT: Style = {"ha": "left", "va": "center"}
CENTRED: Style = {"ha": "center", "va": "center"}

BASE, MASS, HEIGHT = 1.05, 4.3, 6.6
"""Upper edge of the base, lower edge of the mass, and height of the sketch."""

UNITS_PER_INCH = 2.0
"""Length of an inch in the sketch."""


class Layout(NamedTuple):
    """Place of the first element, distance of the elements, and room beside the last one."""

    first: float
    spacing: float
    side: float


SYMBOLS, VALUES = Layout(2.0, 2.0, 4.4), Layout(3.2, 3.6, 5.6)
"""Layouts without and with values, which are wider."""


Draw = Callable[["Axes", float, str], None]
"""Draws an element between base and mass, given its place and its label."""


def draw(scenario: Scenario | None = None, varied: Collection[str] = ()) -> Figure:
    """Return the sketch of a scenario, or with all elements and without values.

    Parameters
    ----------
    scenario : Scenario, optional
    varied : collection of str, optional
        Dotted keys that vary, whose values are left out.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import FancyArrowPatch, Rectangle

    parts, limit = list(_parts(scenario, varied)), _limit(scenario, varied)
    layout = SYMBOLS if scenario is None else VALUES
    count = max(len(parts), 2)
    first, right = layout.first, layout.first + layout.spacing * (count - 1)
    width, middle = right + layout.side, (first + right) / 2
    size = width / UNITS_PER_INCH, HEIGHT / UNITS_PER_INCH
    figure = Figure(figsize=size)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(0, width)
    axes.set_ylim(0, HEIGHT)
    long = right - first + 1.6
    axes.add_patch(Rectangle((first - 0.8, MASS), long, 1.4, facecolor="#c9d8ea", **EDGE))
    mass = _label("mass m", "mass", scenario, varied, " ")
    axes.text(middle, 5.0, mass, size=12, **CENTRED)
    axes.add_patch(Rectangle((first - 1.2, 0.7), long + 0.8, 0.35, facecolor="#8a8a8a", **EDGE))
    rests = scenario is not None and scenario.excitation.kind == "rest"
    axes.text(middle, 0.32, "base at rest" if rests else "moving base", size=11, **CENTRED)
    for place, (draw_part, label) in enumerate(parts):
        draw_part(axes, first + layout.spacing * (place + (count - len(parts)) / 2), label)
    for symbol, foot in (("x", 4.65), ("u", 0.88))[: 1 if rests else 2]:
        axes.plot([right + 1.3, right + 1.9], [foot, foot], color="black", linewidth=1)
        tip = right + 1.6, foot + 0.95
        axes.add_patch(FancyArrowPatch((right + 1.6, foot), tip, **ARROW))
        axes.text(right + 1.85, foot + 0.55, f"{symbol}(t)", size=12, **LEFT)
    lines = filter(None, ("stroke", "xᵣ = x − u", limit))
    axes.text(right + 2.55, 4.0, "\n".join(lines), size=11, **LEFT)
    return figure


def _parts(scenario: Scenario | None, varied: Collection[str]) -> Iterator[tuple[Draw, str]]:
    """Yield what draws each element of a scene, with the label of the element."""
    if scenario is None:
        yield from ((_draw_spring, "kₓ"), (_draw_damper, "b"))
        yield _draw_contact, "friction F_fk, F_fs"
        return
    plant, law = scenario.oscillator.plant(), scenario.law()
    if plant.k_x > 0 or _names(("stiffness", "natural_frequency"), varied):
        yield _draw_spring, _label("kₓ", "stiffness", scenario, varied)
    if plant.b > 0 or law.damping or _names(("damping", "damping_ratio"), varied):
        yield _draw_damper, _label("b", "damping", scenario, varied)
    if has_friction(law) or any(key.startswith("friction.") for key in varied):
        yield partial(_draw_contact, elastic=law.is_elastic), _friction_label(law, varied)
    if law.stops is not None:
        peak = max(law.stops.limits)
        sides = describe_limits(law.stops.limits, peak)
        kind = "rigid stops" if law.stops.rigid else "bumpers"
        swept = any(key.startswith("stroke.") for key in varied)
        yield _draw_stops, f"{kind}\n{'varied' if swept else sides}"


def _label(
    symbol: str,
    key: str,
    scenario: Scenario | None,
    varied: Collection[str],
    separator: str = "\n",
) -> str:
    """Return a symbol with the value of a key of the oscillator."""
    if scenario is None:
        return symbol
    plant, damping = scenario.oscillator.plant(), scenario.law().damping
    if _is_varied(key, scenario, varied):
        value = "varied"
    elif key == "damping" and damping is not None:
        value = f"{format_number(damping[0])} and\n{format_number(damping[1], 'N·s/m')}"
    else:
        number, unit = {
            "mass": (plant.m, "kg"),
            "stiffness": (plant.k_x, "N/m"),
            "damping": (plant.b, "N·s/m"),
        }[key]
        value = format_number(number, unit)
    return f"{symbol}{separator}{value}"


FOLLOWS_FROM = {
    "natural_frequency": ("natural_frequency", "mass"),
    "damping_ratio": ("damping_ratio", "stiffness", "natural_frequency", "mass"),
}
"""What determines stiffness or damping where a file states this key instead."""


def _is_varied(key: str, scenario: Scenario, varied: Collection[str]) -> bool:
    """Whether a value of the oscillator varies, by its key or by one that it follows from."""
    stated = {"stiffness": "natural_frequency", "damping": "damping_ratio"}.get(key, key)
    is_stated = key != stated and getattr(scenario.oscillator, stated) is not None
    return _names((key, *(FOLLOWS_FROM[stated] if is_stated else (stated,))), varied)


def _names(keys: Collection[str], varied: Collection[str]) -> bool:
    """Whether some of the keys of the oscillator vary, or parts of them."""
    return any(f"{name}.".startswith(f"oscillator.{key}.") for name in varied for key in keys)


def _friction_label(law: AnyLaw, varied: Collection[str]) -> str:
    """Return the friction forces."""
    if any(key.startswith("friction.") for key in varied):
        return "friction\nvaried"
    lines = ["friction", f"F_fk {format_number(law.F_fk, 'N')}"]
    if law.F_fs > law.F_fk:
        lines.append(f"F_fs {format_number(law.F_fs, 'N')}")
    return "\n".join(lines)


def _limit(scenario: Scenario | None, varied: Collection[str]) -> str:
    """Return the stroke limit; empty without one."""
    if scenario is None or scenario.stroke is None or scenario.stops is not None:
        return ""
    if any(key.startswith("stroke.") for key in varied):
        return "limit varied"
    limits = scenario.stroke.limits
    return f"limit {describe_limits(limits, max(limits))}"


def _draw_spring(axes: Axes, x: float, label: str) -> None:
    turns = np.linspace(BASE + 0.5, MASS - 0.5, 15)
    sides = x + 0.28 * np.array([0, *((-1) ** i for i in range(13)), 0])
    axes.plot([x, *sides, x], [BASE, *turns, MASS], **LINE)
    axes.text(x - 0.55, 2.7, label, size=12, ha="right", va="center")


def _draw_damper(axes: Axes, x: float, label: str) -> None:
    axes.plot([x, x], [BASE, 2.2], **LINE)
    axes.plot([x - 0.38, x - 0.38, x + 0.38, x + 0.38], [3.2, 2.2, 2.2, 3.2], **LINE)
    axes.plot([x - 0.32, x + 0.32], [2.8, 2.8], color="black", linewidth=3)
    axes.plot([x, x], [2.8, MASS], **LINE)
    axes.text(x - 0.6, 2.7, label, size=12, ha="right", va="center")


def _draw_contact(axes: Axes, x: float, label: str, elastic: bool = False) -> None:
    from matplotlib.patches import FancyArrowPatch, Rectangle

    axes.plot([x, x], [2.0, MASS], color="black", linewidth=5, solid_capstyle="butt")
    for pad, away in ((x - 0.44, -1.0), (x + 0.09, 1.0)):
        axes.add_patch(Rectangle((pad, 2.1), 0.35, 1.0, facecolor="#b3541e", **EDGE))
        tip = (x + 0.46 * away, 2.6)
        axes.add_patch(FancyArrowPatch((x + away, 2.6), tip, **ARROW))
    axes.plot([x - 0.27, x - 0.27, x + 0.27, x + 0.27], [2.1, 1.6, 1.6, 2.1], **LINE)
    if elastic:
        turns = np.linspace(BASE, 1.6, 7)
        axes.plot(x + 0.15 * np.array([0, 1, -1, 1, -1, 1, 0]), turns, **LINE)
    else:
        axes.plot([x, x], [BASE, 1.6], **LINE)
    axes.text(x + 1.15, 2.6, label, size=11, **LEFT)


def _draw_stops(axes: Axes, x: float, label: str) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle((x - 0.3, BASE), 0.6, 2.1, facecolor="white", **EDGE))
    axes.add_patch(Rectangle((x - 0.3, BASE + 2.1), 0.6, 0.35, facecolor="#444444", **EDGE))
    axes.text(x + 0.5, 2.3, label, size=11, **LEFT)
