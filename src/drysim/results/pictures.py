"""Pictures of a result; matplotlib is imported when the first one is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

from drysim.errors import UsageError
from drysim.messages import name_hint
from drysim.results import kind_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.results.kind import Picture
    from drysim.study.outcome import AnyResult


def pictures_of(result: AnyResult) -> Iterator[tuple[Picture, Callable[[], Figure | None]]]:
    """Yield each picture of a result, and what draws it; None if there is nothing to draw."""
    for picture in kind_of(result).pictures:
        yield picture, partial(draw, picture, result)


def draw(picture: Picture, result: AnyResult, ax: Axes | None = None) -> Any:
    """Return a picture of a result as a figure of matplotlib; None if there is none.

    It is drawn into `ax`, if given and if the picture may have a single panel.
    """
    module, function = picture.draw.split(".")
    axes = [ax] if picture.fits_axes else []
    return getattr(import_module(f"drysim.plots.{module}"), function)(
        picture.shown(result), *axes
    )


def plot(result: AnyResult, picture: str | None = None, ax: Axes | None = None) -> Figure:
    """Return a picture of a result as a figure of matplotlib.

    Parameters
    ----------
    result : object
        What `run`, `sweep`, `compare`, `fit`, `design`, `branches` or `map_regimes` returned.
    picture : str, optional
        Name of the picture, that of its file; default: the main one.
    ax : matplotlib.axes.Axes, optional
        Axes to draw a picture of one panel into, with a legend and without a heading;
        default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        As the commands write it: the motion of a run, distributions over seeds,
        transmissibilities of a sweep, approaches side by side, measured and fitted motion,
        the objective of designs, branches of periodic motions, or regimes over two keys.
        `figure.savefig` writes it. With `ax`, the figure of these axes.

    Raises
    ------
    UsageError
        When the result has no such picture, or nothing to draw in it, or when a picture of
        several panels shall be drawn into `ax`.
    """
    kind = kind_of(result)
    pictures = {each.name: each for each in kind.pictures}
    if not pictures:
        raise UsageError(f"there are no pictures of {kind.what}")
    name = next(iter(pictures)) if picture is None else str(picture)
    if name not in pictures:
        hint = name_hint(name, pictures)
        raise UsageError(f"there is no picture `{name}` of {kind.what}{hint}")
    from drysim.plots import style

    style.import_matplotlib()
    style.register_with_notebook()
    if ax is not None:
        from matplotlib.axes import Axes

        if not isinstance(ax, Axes):
            raise UsageError(
                f"expected axes of matplotlib, not {type(ax).__name__}",
                "pass one of the axes that `plt.subplots` returns",
            )
        if not pictures[name].fits_axes:
            raise style.panels_error("several")
    with style.picture_style():
        figure: Figure | None = draw(pictures[name], result, ax)
    if figure is None:
        raise UsageError(f"there is nothing for the picture `{name}` in this result")
    drawn_in: Any = figure if ax is None else ax.figure
    while not hasattr(drawn_in, "savefig"):  # a subfigure
        drawn_in = drawn_in.figure
    return cast("Figure", drawn_in)
