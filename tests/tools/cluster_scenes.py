"""Sweeps of every kind that a cluster may be given, and what is left of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

ORBITS = """\
drysim: 1
name: orbits
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
stroke: {limit: 25 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
reference: viscous
checks: [T_a < 5]
sweep:
  excitation.frequency: {from: 0.5, to: 10, count: 300}
  friction.kinetic: [5, 15, 45]
"""

SEEDS = """\
drysim: 1
name: seeds
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation:
  {kind: psd, points: [[1, 0.1], [10, 0.1]], duration: 4, seed: 1, seeds: 20,
   until: {metric: T_a, half_width: 20 %}}
solver: {approach: stick-slip, step: 5e-3}
measure: {settle: 0, duration: 4}
reference: viscous
sweep: {friction.kinetic: [5, 15, 45], oscillator.damping: [100, 500]}
"""

RECORD = """\
drysim: 1
name: record
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: data/road.csv, rate: 200 Hz}
solver: {approach: stick-slip}
sweep: {excitation.scale: [1, 2], friction.kinetic: [5, 45]}
"""

SAMPLE = (
    ORBITS.replace("name: orbits", "name: sample").partition("sweep:")[0]
    + """\
sweep:
  sample:
    kind: sobol
    count: 600
    seed: 3
    over:
      oscillator.mass: {distribution: normal, mean: 75, sd: 5, from: 50}
      excitation.frequency: {from: 1, to: 5}
"""
)

UP_AND_DOWN = ORBITS.replace("name: orbits", "name: both") + "  direction: both\n"

ALL = {
    "orbits": ORBITS, "seeds": SEEDS, "record": RECORD, "sample": SAMPLE, "both": UP_AND_DOWN,
}  # fmt: skip

QUIET = ("--no-plots", "--quiet")


def written(folder: Path) -> Path:
    """Write every scenario, and the record of one of them."""
    (folder / "data").mkdir()
    values = np.random.Generator(np.random.PCG64(5)).normal(size=800)
    lines = "".join(f"{value}\n" for value in values.tolist())
    (folder / "data/road.csv").write_text("u_dd [m/s2]\n" + lines)
    for name, words in ALL.items():
        (folder / f"{name}.yaml").write_text(words)
    return folder


def table(folder: Path) -> bytes:
    """Return the bytes of a table."""
    return (folder / "transmissibility.csv").read_bytes()


def blocks_in(partial: Path) -> int:
    """Count the blocks of cases that a sweep under way has kept."""
    return sum(1 for _ in (partial / "cases").glob("*.npz"))


def pem(folder: Path, credentials: Any) -> list[object]:
    """Write credentials of a cluster as three files; give the options that name them."""
    words = credentials.tls_ca_file, credentials.tls_client_cert, credentials.tls_client_key
    files = [folder / name for name in ("ca.pem", "cert.pem", "key.pem")]
    for file, content in zip(files, words, strict=True):
        file.write_text(content)
    options = ("--tls-ca-file", "--tls-cert", "--tls-key")
    return [word for pair in zip(options, files, strict=True) for word in pair]
