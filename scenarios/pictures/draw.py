"""Draws the pictures of README.md. Run it in the checkout by `make pictures`.

The pictures are those that the commands write, in a few colours, which makes them small.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
GALLERY = HERE.parent
COLOURS = 64
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
}
"""The command behind every picture, and what it calls the picture."""


def draw(name: str, words: list[str], drawn: str) -> None:
    """Run a command and keep its picture."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "out")
        command = [sys.executable, "-m", "drysim", *words, "--quiet", "--out", str(out)]
        subprocess.run(command, check=True)
        whole = Image.open(out / drawn).convert("RGB")
        few = whole.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2)
        few.save(HERE / name, optimize=True)


for picture, (words, drawn) in PICTURES.items():
    draw(picture, words, drawn)
