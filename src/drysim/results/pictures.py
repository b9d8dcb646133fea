"""Pictures of a result; matplotlib is imported when the first one is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from drysim.errors import UsageError
from drysim.messages import name_hint
from drysim.results import kind_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drysim.results.kind import Picture
    from drysim.study.outcome import AnyResult


def pictures_of(result: AnyResult) -> Iterator[tuple[Picture, Callable[[], Figure | None]]]:
    """Yield each picture of a result, and what draws it; None if there is nothing to draw."""
    for picture in kind_of(result).pictures:
        yield picture, partial(draw, picture, result)


def draw(picture: Picture, result: AnyResult) -> Any:
    """Return a picture of a result as a figure of matplotlib; None if there is none."""
    module, function = picture.draw.split(".")
    return getattr(import_module(f"drysim.plots.{module}"), function)(picture.shown(result))


def plot(result: AnyResult, picture: str | None = None) -> Figure:
    """Return a picture of a result as a figure of matplotlib.

    Parameters
    ----------
    result : object
        What `run`, `sweep`, `compare`, `fit`, `design`, `branches` or `map_regimes` returned.
    picture : str, optional
        Name of the picture, that of its file; default: the main one.

    Returns
    -------
    matplotlib.figure.Figure
        As the commands write it: the motion of a run, distributions over seeds,
        transmissibilities of a sweep, approaches side by side, measured and fitted motion,
        the objective of designs, branches of periodic motions, or regimes over two keys.
        `figure.savefig` writes it.

    Raises
    ------
    UsageError
        When the result has no such picture, or nothing to draw in it.
    """
    kind = kind_of(result)
    pictures = {one.name: one for one in kind.pictures}
    if not pictures:
        raise UsageError(f"there are no pictures of {kind.what}")
    name = next(iter(pictures)) if picture is None else str(picture)
    if name not in pictures:
        hint = name_hint(name, pictures)
        raise UsageError(f"there is no picture `{name}` of {kind.what}{hint}")
    from drysim.plots import style

    style.import_matplotlib()
    style.register_with_notebook()
    with style.picture_style():
        figure: Figure | None = draw(pictures[name], result)
    if figure is None:
        raise UsageError(f"there is nothing for the picture `{name}` in this result")
    return figure
