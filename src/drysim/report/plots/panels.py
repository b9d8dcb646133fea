"""The panels of a response: accelerations, relative displacement, friction loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from drysim import wording
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import Slider, Stopped
from drysim.report.plots import curves
from drysim.report.plots.curves import Curve
from drysim.report.plots.limit import excursions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    from drysim.approach.bounded import Bounded
    from drysim.approach.events import Floats
    from drysim.approach.response import Response
    from drysim.core.plant import AnyLaw
    from drysim.wording import LengthUnit

CROWDED = 40
"""Crosses above which they are small, lest they hide the peaks that they mark."""

DENSE, THIN = 300, 0.6
"""Turning points above which a line would fill its panel, and its width then [pt]."""

VISIBLE = 500
"""Steps of height that can be told apart in a panel."""

FEW = 12
"""Points below which each is marked: a line alone might be too short to be seen."""

# Told apart in grey as well: by lightness, width and dashes. The base lies below the mass.
BASE: dict[str, Any] = {"color": "#9d9d9d", "linewidth": 0.8, "zorder": 1.9}
MASS: dict[str, Any] = {"color": "#0b3c6f", "linewidth": 1.4}
LIMIT: dict[str, Any] = {"color": "#b3261e", "linewidth": 1.2, "linestyle": (0, (6, 3))}
STATIC: dict[str, Any] = {"color": "#444444", "linewidth": 1.0, "linestyle": (0, (1, 2))}
BEYOND: dict[str, Any] = {"color": "#b3261e", "marker": "x", "markersize": 6, "zorder": 3}
STUCK: dict[str, Any] = {"facecolor": "#f0e2c0", "edgecolor": "none", "zorder": 0}
FRAME: dict[str, Any] = {"facecolor": "#0000000c", "edgecolor": "black", "linewidth": 0.8}
SETTLED: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0, (7, 2, 1, 2))}
BAND = "#bdbdbd"


def pair(
    figure: Figure, grid: GridSpec, begin: float, end: float, unit: LengthUnit
) -> tuple[Axes, Axes]:
    """Give empty panels of accelerations and relative displacement, one above the other."""
    above = figure.add_subplot(grid[0, 0])
    below = figure.add_subplot(grid[1, 0], sharex=above)
    above.set_title("acceleration [m/s²]", loc="left")
    above.tick_params(labelbottom=False)
    below.set_title(f"relative displacement $x_r$ [{unit.sign}]", loc="left")
    below.set_xlabel("time $t$ [s]")
    if end > begin:
        below.set_xlim(begin, end)
    for axes in (above, below):
        axes.yaxis.set_offset_position("right")
    return above, below


def lines(above: Axes, below: Axes, shown: Curve, unit: LengthUnit) -> None:
    """Draw accelerations and relative displacement over time."""
    mark = "." if len(shown.t) < FEW else ""
    above.plot(shown.t, shown.x_dd, **of_mass(shown.x_dd), marker=mark, label="mass ẍ")
    above.plot(shown.t, shown.u_dd, **BASE, label="base ü")
    x_r = shown.x_r * unit.per_metre
    below.plot(shown.t, x_r, **MASS, marker=mark)
    below.set_ylim(*_room(x_r))


def of_mass(series: Floats) -> dict[str, Any]:
    """Return the style of a line of the mass: thin where it has many turning points.

    Those that no eye sees, as rounding makes them on a level line, do not count.
    """
    known = series[np.isfinite(series)]
    scale = float(np.ptp(known)) if len(known) else 0.0
    steps = np.diff(np.round(VISIBLE * (known - known.min()) / scale)) if scale else known[:0]
    turns = np.count_nonzero(np.diff(np.signbit(steps[steps != 0])))
    return {**MASS, "linewidth": THIN} if turns > DENSE else MASS


def bands(above: Axes, below: Axes, motion: Response, unit: LengthUnit) -> None:
    """Draw the bands that a long response fills, that of the mass above that of the base."""
    filled: tuple[tuple[Axes, Callable[[slice], Floats], str], ...] = (
        (above, motion.base, BAND),
        (above, motion.acceleration, MASS["color"]),
        (below, lambda part: motion.points(part).x_r * unit.per_metre, MASS["color"]),
    )
    for axes, series, color in filled:
        at, low, high = curves.envelope(series, len(motion))
        axes.fill_between(at * motion.dt, low, high, color=color, linewidth=0.6)


def stuck(above: Axes, below: Axes, part: slice, motion: Response) -> None:
    """Shade the stretches in which the mass sticks, or holds on to a contact that yields."""
    word = held(motion.law)
    for begin, length in curves.stuck_stretches(motion, *curves.ends(motion, part)):
        for axes in (above, below):
            axes.axvspan(begin, begin + length, **STUCK, label=word)


def held(law: AnyLaw) -> str:
    """Name what is shaded: a contact that is a spring holds while the mass goes on moving."""
    return "contact holds" if isinstance(law, Slider) else "stuck"


def frame(above: Axes, below: Axes, begin: float, end: float) -> None:
    """Frame the stretch that is drawn once more below."""
    for axes in (above, below):
        axes.axvspan(begin, end, **FRAME)


def settled(above: Axes, below: Axes, begin: float) -> None:
    """Draw where the settling time ends, if there is any."""
    if begin > 0:
        for axes in (above, below):
            axes.axvline(begin, **SETTLED, label="metrics begin")


def stroke(axes: Axes, motion: Response, limit: float, far: float, unit: LengthUnit) -> None:
    """Draw the stroke limit and mark where it is met.

    Parameters
    ----------
    axes : Axes
        The panel of the relative displacement.
    motion : Response
    limit : float
        x_rM [m].
    far : float
        A limit more than this many times the peak would flatten the curve and is left out.
    unit : LengthUnit
        Of the panel.
    """
    peak = curves.greatest(motion, "x_r").value
    if limit > far * peak > 0:
        return
    hits = stops_met(motion)
    axes.autoscale(axis="y")
    for side in (-1, 1):
        what = "end stops" if hits else "stroke limit"
        label = f"{what} ±{wording.number(limit * unit.per_metre, unit.sign)}"
        axes.axhline(side * limit * unit.per_metre, **LIMIT, label=label)
    begin, end = axes.get_xlim()
    met = np.array(hits or excursions(motion, limit), dtype=float).reshape(-1, 2)
    met = met[(met[:, 0] >= begin) & (met[:, 0] <= end)] * (1.0, unit.per_metre)
    if len(met):
        label = "stop met" if hits else "limit met"
        style = {**BEYOND, "markersize": 3.5} if len(met) > CROWDED else BEYOND
        axes.plot(*met.T, **style, linestyle="none", clip_on=False, label=label)


def stops_met(response: Response) -> list[tuple[float, float]]:
    """Give time [s] and x_r [m] of every hit of an end stop."""
    law, track = response.law, cast("Bounded", response.track)
    if not isinstance(law, Stopped):
        return []
    t, v_r = track.hits()
    return list(zip(t.tolist(), np.copysign(law.x_rM, v_r).tolist(), strict=True))


def loop(axes: Axes, shown: Curve, motion: Response, unit: LengthUnit) -> None:
    """Draw the friction force over the relative displacement; what it encloses is its loss.

    A repetition of a steady orbit ends where it began, wherever its last grid point is.
    """
    whole = shown.t[0] == 0.0 and shown.t[-1] >= (len(motion) - 1) * motion.dt
    if whole and motion.numerics.period_multiple:
        shown = Curve(*(np.append(series, series[0]) for series in shown))
    x_r = shown.x_r * unit.per_metre
    axes.set_xlabel(f"relative displacement $x_r$ [{unit.sign}]", loc="left")
    axes.locator_params(axis="x", nbins=5)
    axes.yaxis.set_offset_position("right")
    if motion.law.F_fs == 0:
        axes.set_title("damping force $b\\,v_r$ [N]", loc="left")
        force = motion.plant.b * shown.v_r
        axes.plot(x_r, force, **of_mass(force))
        return
    axes.set_title("friction force $F_f$ [N]", loc="left")
    mark = "." if len(shown.t) < FEW else ""
    axes.plot(x_r, shown.F_f, **of_mass(shown.F_f), marker=mark)
    axes.set_xlim(*_room(x_r))
    if not (motion.law.variation or isinstance(motion.law, Pressed)):
        words, symbol = limit_of(motion.law)
        for side in (-1, 1):
            axes.axhline(side * motion.law.F_fs, **STATIC, label=f"{words} ±{symbol}")


def limit_of(law: AnyLaw) -> tuple[str, str]:
    """Name the greatest friction force: what yields, and grips as it drags, is never static."""
    if law.sticks or law.F_fs > law.F_fk:
        return "static limit", "$F_{fs}$"
    return "friction limit", "$F_{fk}$"


def _room(x_r: Floats) -> tuple[float | None, float | None]:
    """Give the range of a mass that does not move; otherwise the curve has its own."""
    low, high = float(x_r.min()), float(x_r.max())
    return (low - 1, high + 1) if low == high else (None, None)
