"""spectra.csv: the spectra of a run, line by line, and what drysim.json says of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.report.cells import joined, texts
from drysim.report.tables import write

if TYPE_CHECKING:
    from drysim.spectra import Spectra
    from drysim.study.outcome import Outcome

HEADINGS = (
    "f [Hz]", "G_u [(m/s2)2/Hz]", "G_x [(m/s2)2/Hz]", "H1 [-]", "phase [rad]", "coherence [-]",
)  # fmt: skip


def spectra(outcome: Outcome, folder: Path) -> None:
    """Write spectra.csv, but only when spectra were asked for.

    Parameters
    ----------
    outcome : Outcome
    folder : Path
        Where to write.
    """
    found = outcome.spectra
    if found is None:
        return
    columns = (
        found.f, found.G_u, found.G_x, np.abs(found.H1), np.angle(found.H1), found.coherence,
    )  # fmt: skip
    cells = [[text if text != "nan" else "" for text in texts(column)] for column in columns]
    write(folder / "spectra.csv", HEADINGS, [joined(cells)])


def told(found: Spectra) -> dict[str, Any]:
    """Give how spectra were made, for drysim.json."""
    return {
        "method": "Welch, Hann window, half overlapping, mean of the window removed",
        "series": "means over every step, their fading with frequency taken back",
        "segment": found.segment,
        "segments": found.segments,
        "resolution": 1.0 / found.segment,
    }
