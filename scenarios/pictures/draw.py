"""Draw the pictures of the README and of the gallery; run by `make pictures`.

These are pictures written by drysim commands, and the friction loop of each law. They are
reduced to few colours to keep the files small.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle
from PIL import Image

import drysim
from drysim.plots import response, style
from drysim.scenario.reading import LAWS
from drysim.wording import length_unit

HERE = Path(__file__).parent
LOOPS = HERE / "loops"
GALLERY = HERE.parent
COLOURS, FEW = 64, 24
EVERY_LAW = " vs ".join([*(name for name in LAWS if name != "coulomb"), "coulomb"]).split()
PICTURES = {
    "seat-on-em1.png": (["run", f"{GALLERY}/seat-on-em1.yaml"], "response.png"),
    "seat-ensemble.png": (["run", f"{GALLERY}/seat-ensemble.yaml"], "ensemble.png"),
    "transmissibility.png": (
        ["sweep", f"{GALLERY}/paper-low-friction.yaml"],
        "transmissibility.png",
    ),
    "shock-response-spectrum.png": (
        ["sweep", f"{GALLERY}/shock-response-spectrum.yaml"],
        "stroke.png",
    ),
    "comparison.png": (
        ["compare", "signum", "vs", "stick-slip", "-s", f"{GALLERY}/paper-random.yaml"],
        "comparison.png",
    ),
    "friction-laws.png": (
        ["compare", *EVERY_LAW, "-s", f"{GALLERY}/friction-laws.yaml"],
        "comparison.png",
    ),
}
"""Command of each picture, and the file it writes."""

MODEL = "model.png"

SIZE, DOTS = (3.3, 2.9), 100
"""Size of the figure of a loop [inch], and dots per inch."""


def keep(drawn: Path, kept: Path, colours: int = COLOURS) -> None:
    """Save a picture with few colours."""
    whole = Image.open(drawn).convert("RGB")
    few = whole.quantize(colours, Image.Quantize.MAXCOVERAGE, kmeans=2)
    few.save(kept, optimize=True)


def draw(name: str, words: list[str], drawn: str) -> None:
    """Run a command and save its picture."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "out")
        command = [sys.executable, "-m", "drysim", *words, "--quiet", "--out", str(out)]
        subprocess.run(command, check=True)
        keep(out / drawn, HERE / name)


def loop(law: str) -> Figure:
    """Return the friction loop of a law in its gallery scenario."""
    made = drysim.run(drysim.load(GALLERY / f"friction-{law}.yaml"))
    motion, unit = made.response, length_unit(made.metrics["x_r_peak"])
    figure = Figure(figsize=SIZE, dpi=DOTS)
    axes = figure.add_axes((0.15, 0.17, 0.73, 0.63))
    response.draw_loop(axes, response.curve_with_events(motion, slice(None)), motion, unit)
    figure.text(0.02, 0.92, law, weight="bold", size=11)
    if not motion.law.variation:
        beside = {"transform": axes.get_yaxis_transform(), "va": "center", "size": 9}
        static = motion.law.can_stick or motion.law.F_fs > motion.law.F_fk
        symbol = "$F_{fs}$" if static else "$F_{fk}$"
        axes.text(1.01, motion.law.F_fs, symbol, **beside)
        axes.text(1.01, -motion.law.F_fs, f"$-${symbol}", **beside)
    return figure


def model() -> Figure:
    """Return the sketch of the model: mass, spring, damper and friction contact on a base."""
    figure = Figure(figsize=(5.2, 3.3), dpi=DOTS)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(0, 10.4)
    axes.set_ylim(0, 6.6)
    line = {"color": "black", "linewidth": 1.4}
    edge = {"edgecolor": "black", "linewidth": 1.4}
    arrow = {"arrowstyle": "-|>", "mutation_scale": 13, "color": "black"}
    left, centred = {"ha": "left", "va": "center"}, {"ha": "center", "va": "center"}
    axes.add_patch(Rectangle((1.2, 4.3), 5.6, 1.4, facecolor="#c9d8ea", **edge))
    axes.text(4.0, 5.0, "mass $m$", size=12, **centred)
    axes.add_patch(Rectangle((0.8, 0.7), 6.4, 0.35, facecolor="#8a8a8a", **edge))
    axes.text(4.0, 0.32, "moving base", size=11, **centred)
    low, high = 1.05, 4.3
    turns = np.linspace(low + 0.5, high - 0.5, 15)
    sides = 2.0 + 0.28 * np.array([0, *((-1) ** i for i in range(13)), 0])
    axes.plot([2.0, *sides, 2.0], [low, *turns, high], **line)
    axes.text(1.45, 2.7, "$k_x$", size=12, ha="right", va="center")
    axes.plot([4.0, 4.0], [low, 2.2], **line)
    axes.plot([3.62, 3.62, 4.38, 4.38], [3.2, 2.2, 2.2, 3.2], **line)
    axes.plot([3.68, 4.32], [2.8, 2.8], color="black", linewidth=3)
    axes.plot([4.0, 4.0], [2.8, high], **line)
    axes.text(3.4, 2.7, "$b$", size=12, ha="right", va="center")
    axes.plot([6.0, 6.0], [2.0, high], color="black", linewidth=5, solid_capstyle="butt")
    for pad, away in ((5.56, -1.0), (6.09, 1.0)):
        axes.add_patch(Rectangle((pad, 2.1), 0.35, 1.0, facecolor="#b3541e", **edge))
        tip = (6.0 + 0.46 * away, 2.6)
        axes.add_patch(FancyArrowPatch((6.0 + away, 2.6), tip, **arrow))
    axes.plot([5.73, 5.73, 6.27, 6.27], [2.1, 1.6, 1.6, 2.1], **line)
    axes.plot([6.0, 6.0], [low, 1.6], **line)
    axes.text(7.15, 2.6, "friction $F_{fk}$, $F_{fs}$", size=11, **left)
    for symbol, foot in (("x", 4.65), ("u", 0.88)):
        axes.plot([7.3, 7.9], [foot, foot], color="black", linewidth=1)
        axes.add_patch(FancyArrowPatch((7.6, foot), (7.6, foot + 0.95), **arrow))
        axes.text(7.85, foot + 0.55, f"${symbol}(t)$", size=12, **left)
    axes.text(8.55, 4.0, "stroke\n$x_r = x - u$", size=11, **left)
    return figure


def asked(name: str) -> bool:
    """Return whether to draw a picture: all, or those named on the command line."""
    return not sys.argv[1:] or name in sys.argv[1:]


for picture, (words, drawn) in PICTURES.items():
    if asked(picture):
        draw(picture, words, drawn)
if asked(MODEL):
    with tempfile.TemporaryDirectory() as place:
        style.save_picture(model, Path(place, MODEL))
        keep(Path(place, MODEL), HERE / MODEL, FEW)
for law in LAWS:
    name = f"friction-{law}.png"
    if asked(name):
        with tempfile.TemporaryDirectory() as place:
            style.save_picture(lambda law=law: loop(law), Path(place, name))
            keep(Path(place, name), LOOPS / name, FEW)
