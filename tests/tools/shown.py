"""What people see: a result on the console, and the words and curves of a picture."""

from functools import wraps
from pathlib import Path

import pytest

from drysim.console.summary import show_summary
from drysim.results import kind_of


def show(result, folder: Path | None = None):
    """Show a result; `folder` as of `show_summary`."""
    summary = kind_of(result).summary(result)
    complete = getattr(result, "complete", True)
    show_summary(summary, folder if complete else None, result.warnings)


def leave_pictures_empty(patch: pytest.MonkeyPatch) -> None:
    """Compose PNG pictures and do not draw them, where words are looked at only."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    drawn = FigureCanvasAgg.print_png

    @wraps(drawn)  # matplotlib looks at its parameters
    def written(canvas, file, **options) -> None:
        if isinstance(file, str):
            Path(file).touch()
        else:  # into memory, for a page
            drawn(canvas, file, **options)

    patch.setattr(FigureCanvasAgg, "print_png", written)


def legend(figure) -> list[str]:
    """Return the entries of the legend of a picture."""
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def labelled(axes, label: str) -> list:
    """Return the curves of a panel that carry a label."""
    return [line for line in axes.lines if line.get_label() == label]
