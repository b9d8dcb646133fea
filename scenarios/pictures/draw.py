"""Draws the pictures of the README and of the gallery, from the checkout by `make pictures`.

The pictures are those that the commands write, and of every friction law its loop, in a few
colours, which makes them small.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure
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
    "comparison.png": (
        ["compare", "signum", "vs", "stick-slip", "-s", f"{GALLERY}/paper-random.yaml"],
        "comparison.png",
    ),
    "friction-laws.png": (
        ["compare", *EVERY_LAW, "-s", f"{GALLERY}/friction-laws.yaml"],
        "comparison.png",
    ),
}
"""The command behind every picture, and what it calls the picture."""

SIZE, DOTS = (3.3, 2.9), 100
"""Size of a loop [inch] and its dots per inch."""


def keep(drawn: Path, kept: Path, colours: int = COLOURS) -> None:
    """Keep a picture in a few colours."""
    whole = Image.open(drawn).convert("RGB")
    few = whole.quantize(colours, Image.Quantize.MAXCOVERAGE, kmeans=2)
    few.save(kept, optimize=True)


def draw(name: str, words: list[str], drawn: str) -> None:
    """Run a command and keep its picture."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "out")
        command = [sys.executable, "-m", "drysim", *words, "--quiet", "--out", str(out)]
        subprocess.run(command, check=True)
        keep(out / drawn, HERE / name)


def loop(law: str) -> Figure:
    """Give the friction loop of a law in its scenario of the gallery."""
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


def asked(name: str) -> bool:
    """Whether a picture is to be drawn: all are, unless some are named."""
    return not sys.argv[1:] or name in sys.argv[1:]


for picture, (words, drawn) in PICTURES.items():
    if asked(picture):
        draw(picture, words, drawn)
for law in LAWS:
    name = f"friction-{law}.png"
    if asked(name):
        with tempfile.TemporaryDirectory() as place:
            style.save_png(lambda law=law: loop(law), Path(place, name))
            keep(Path(place, name), LOOPS / name, FEW)
