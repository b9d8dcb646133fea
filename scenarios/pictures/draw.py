"""Draw the pictures of the README and of the gallery; run by `make pictures`.

These are pictures written by drysim commands, and the friction loop of each law. They are
reduced to few colours to keep the files small.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image, ImageOps

import drysim
from drysim.plots import response, sketch, style
from drysim.scenario.laws import LAWS
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
    "hysteresis.png": (
        ["sweep", f"{GALLERY}/hysteresis-of-a-sweep.yaml"],
        "stroke.png",
    ),
    "shock-response-spectrum.png": (
        ["sweep", f"{GALLERY}/shock-response-spectrum.yaml"],
        "srs.png",
    ),
    "assess.png": (["assess", f"{GALLERY}/assess-seat.yaml"], "assess.png"),
    "design.png": (["design", f"{GALLERY}/design-seat.yaml"], "design.png"),
    "regime-map.png": (["map", f"{GALLERY}/regime-map.yaml"], "map.png"),
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

REPORT = "report.png"
BROWSERS = "chromium", "chromium-browser", "google-chrome"
PAGE, SHOWN = (1000, 1156), 640
"""Size of the head of a page, and width of its picture [pixel]."""

SIZE, DOTS = (3.3, 2.9), 100
"""Size of the figure of a loop [inch], and dots per inch of loops and model."""


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
    axes = figure.add_axes((0.15, 0.17, 0.71, 0.63))
    shown = response.closed_curve(response.curve_with_events(motion, slice(None)), motion)
    response.draw_loop(axes, shown, motion, unit)
    figure.text(0.02, 0.92, law, weight="bold", size=11)
    if not motion.law.variation:
        beside = {"transform": axes.get_yaxis_transform(), "va": "center", "size": 9}
        static = motion.law.can_stick or motion.law.F_fs > motion.law.F_fk
        symbol = "F_fs" if static else "F_fk"
        axes.text(1.01, motion.law.F_fs, symbol, **beside)
        axes.text(1.01, -motion.law.F_fs, f"−{symbol}", **beside)
    return figure


def model() -> Figure:
    """Return the sketch of the model: mass, spring, damper and friction contact on a base."""
    figure = sketch.draw()
    figure.set_dpi(DOTS)
    return figure


def draw_report() -> None:
    """Take a picture of the head of a report in a browser, if there is one."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print(f"{REPORT} stays as it is: it needs one of {', '.join(BROWSERS)}")
        return
    with tempfile.TemporaryDirectory() as place:
        result = drysim.run(drysim.load(GALLERY / "seat-on-em1.yaml"))
        page = drysim.report(result, Path(place, "report.html"))
        photo, few = Path(place, "page.png"), Path(place, "few.png")
        size = "{},{}".format(*PAGE)
        options = "--headless", "--no-sandbox", "--hide-scrollbars", f"--window-size={size}"
        command = [browser, *options, f"--screenshot={photo}", page.as_uri()]
        subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
        whole = Image.open(photo).convert("RGB").crop((0, 0, *PAGE))
        height = round(PAGE[1] * SHOWN / PAGE[0])
        small = whole.resize((SHOWN, height), Image.Resampling.LANCZOS)
        ImageOps.expand(small, 1, "#bbb").save(few)
        keep(few, HERE / REPORT)


def asked(name: str) -> bool:
    """Return whether to draw a picture: all, or those named on the command line."""
    return not sys.argv[1:] or name in sys.argv[1:]


for picture, (words, drawn) in PICTURES.items():
    if asked(picture):
        draw(picture, words, drawn)
if asked(REPORT):
    draw_report()
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
