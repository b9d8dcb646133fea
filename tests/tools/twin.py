"""Synthetic measurements for `drysim fit`: the motion of a known scene, with noise or none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import drysim
from drysim.approach.solution import Response
from drysim.metrics.spectra import transfer_estimate

RATE = 400.0
"""Samples a second."""

RECORDED = "excitation: {kind: record, file: base.csv, time: t, column: u_dd}\n"
"""The base motion that `write_twin` writes."""

CHANNELS = {"x_dd": "m/s2", "x_r": "m", "v_r": "m/s", "F_f": "N"}
"""Columns of run.csv with their units, after the time."""


def base_motion(seconds: float, seed: int, rms: float = 1.0, rate: float = RATE) -> np.ndarray:
    """Return band-limited noise between 0.5 and 10 Hz."""
    n = round(seconds * rate) + 1
    spectrum = np.fft.rfft(np.random.default_rng(seed).normal(size=n))
    f = np.fft.rfftfreq(n, 1.0 / rate)
    spectrum[(f < 0.5) | (f > 10.0)] = 0.0
    u_dd = np.fft.irfft(spectrum, n)
    return u_dd * (rms / u_dd.std())


def write_columns(file: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write a CSV file with every digit."""
    table = np.column_stack(list(columns.values()))
    np.savetxt(file, table, "%.17g", ",", header=",".join(columns), comments="")


def write_twin(
    folder: Path,
    truth: str,
    *,
    seconds: float = 6.0,
    seed: int = 3,
    rms: float = 1.0,
    rate: float = RATE,
    noise: Mapping[str, float] | None = None,
) -> Response:
    """Write base.csv and the motion of a scene, run.csv, into a folder; return the motion.

    Parameters
    ----------
    folder : Path
    truth : str
        Blocks of the scene as YAML; base.csv moves its base unless it has an excitation.
    seconds, seed, rms, rate : float, int, float, float
        Base motion.
    noise : mapping, optional
        Standard deviation of the noise of channels.
    """
    if "excitation" not in truth:
        u_dd = base_motion(seconds, seed, rms, rate)
        t = np.arange(len(u_dd)) / rate
        write_columns(folder / "base.csv", {"t [s]": t, "u_dd [m/s2]": u_dd})
        truth += RECORDED
    (folder / "truth.yaml").write_text(truth)
    response = drysim.run(drysim.load(folder / "truth.yaml")).response
    write_run(folder, response, noise or {}, seed)
    return response


def write_run(folder: Path, response: Response, noise: Mapping[str, float], seed: int) -> None:
    """Write the channels of a motion with white noise, run.csv."""
    random = np.random.default_rng(seed + 1)
    columns = {"t [s]": response.t}
    for name, unit in CHANNELS.items():
        values = np.array(getattr(response, name))
        columns[f"{name} [{unit}]"] = values + noise.get(name, 0.0) * random.normal(
            size=len(values)
        )
    write_columns(folder / "run.csv", columns)


def fit_text(known: str, free: str, measured: str = "x_dd: x_dd", more: str = "") -> str:
    """Return a scenario that fits free keys to run.csv, as YAML.

    `free` and `measured` are the entries of flow mappings, `more` are lines of the fit block.
    """
    if "excitation" not in known and "F_f" not in measured:
        known += RECORDED
    block = f"fit:\n  measured: {{file: run.csv, time: t, {measured}}}\n  free: {{{free}}}\n"
    return known + block + more


def fit_twin(
    folder: Path,
    known: str,
    free: str,
    measured: str = "x_dd: x_dd",
    more: str = "",
    workers: int | None = None,
) -> drysim.FitResult:
    """Return the fit of `fit_text`."""
    (folder / "twin.yaml").write_text(fit_text(known, free, measured, more))
    return drysim.fit(drysim.load(folder / "twin.yaml"), workers=workers)


def keys(*names: str) -> str:
    """Return free keys without start or bounds."""
    return ", ".join(f"{name}: {{}}" for name in names)


def values_of(result: drysim.FitResult) -> dict[str, float]:
    """Return the fitted values by key."""
    return {one.key: one.value for one in result.parameters}


CURVE_KEYS = (
    "oscillator.stiffness", "oscillator.damping", "friction.kinetic", "friction.static_ratio",
)  # fmt: skip
"""Keys that are fitted to curves."""


MASS = 75.0
"""Mass of the drawn seats [kg]."""


def drawn_seat(draw: np.random.Generator) -> tuple[dict[str, float], list[float]]:
    """Return values of a seat, and three levels; at the lowest it just breaks away."""
    natural = draw.uniform(1.0, 2.5)
    k_x = MASS * (2.0 * np.pi * natural) ** 2
    b = 2.0 * draw.uniform(0.1, 0.5) * np.sqrt(k_x * MASS)
    static_ratio, lowest = draw.uniform(1.0, 1.6), round(draw.uniform(0.3, 0.6), 2)
    levels = [lowest, round(1.7 * lowest, 2), round(3.0 * lowest, 2)]
    kinetic = draw.uniform(0.85, 0.97) * np.sqrt(2.0) * MASS * lowest / static_ratio
    return dict(zip(CURVE_KEYS, (k_x, b, kinetic, static_ratio), strict=True)), levels


def write_random_curves(
    folder: Path, seed: int, seconds: float = 900.0, more: str = ""
) -> dict[str, float]:
    """Write lab.csv with the transmissibility of a drawn seat under noise, and twin.yaml.

    Three levels of a flat spectrum, estimated by H1 over a time [s], with 2 % of noise; `more`
    are further keys of each curve. Returns the values to be found.
    """
    draw = np.random.default_rng(seed)
    values, levels = drawn_seat(draw)
    k_x, b, kinetic, ratio = values.values()
    frequencies, columns, curves = np.round(np.geomspace(0.6, 12.0, 30), 2), {}, []
    columns["f [Hz]"] = frequencies
    spectrum = "{kind: psd, points: [[0.5, 1], [20, 1]], rms: %s, duration: %s, seed: %s}"
    for i, level in enumerate(levels):
        base = spectrum % (level, seconds, 1_000_000 + 10 * seed + i)
        text = (
            f"oscillator: {{mass: {MASS}, stiffness: {k_x}, damping: {b}}}\n"
            f"friction: {{kinetic: {kinetic}, static_ratio: {ratio}}}\n"
            f"excitation: {base}\nsolver: {{step: 1 ms}}\n"
        )
        response = drysim.run(drysim.scenario(text)).response
        for name, channel in (("T_a", response.x_dd), ("T_x", response.x_r)):
            series = np.array(channel)
            estimate = transfer_estimate(np.array(response.u_dd), series, response.dt, 5.0)
            size = np.abs(estimate.H1)
            if name == "T_x":
                size = size * (2.0 * np.pi * estimate.f) ** 2
            exact = np.interp(frequencies, estimate.f, size)
            noisy = exact * (1.0 + 0.02 * draw.standard_normal(len(exact)))
            columns[f"{name}{i}"] = np.round(noisy, 4)
        names = f"T_a: T_a{i}, T_x: T_x{i}"
        curves.append(f"    - {{file: lab.csv, frequency: f, {names}, rms: {level}{more}}}\n")
    write_columns(folder / "lab.csv", columns)
    free = "".join(f"    {key}: {{}}\n" for key in CURVE_KEYS)
    (folder / "twin.yaml").write_text(
        f"oscillator: {{mass: {MASS}}}\nexcitation: {spectrum % (1, 60, 1 + 100 * seed)}\n"
        f"solver: {{step: 5 ms}}\nfit:\n  curves:\n{''.join(curves)}  free:\n{free}"
    )
    return values


def write_curves(
    folder: Path, seed: int, ratios: tuple[str, ...] = ("T_a", "T_x"), *, noise: float = 0.02
) -> dict[str, float]:
    """Write lab.csv with curves of a drawn seat at three levels, and twin.yaml to fit them.

    At the lowest level the mass just breaks away. Values have `noise`, relative, and three
    digits; without noise all digits. Returns the values to be found.
    """
    draw = np.random.default_rng(seed)
    values, levels = drawn_seat(draw)
    k_x, b, kinetic, static_ratio = values.values()
    frequencies = np.round(np.geomspace(0.5, 20.0, 25), 2).tolist()
    rows = drysim.sweep(
        drysim.scenario(
            {
                "oscillator": {"mass": MASS, "stiffness": k_x, "damping": b},
                "friction": {"kinetic": kinetic, "static_ratio": static_ratio},
                "excitation": {"kind": "harmonic", "frequency": 1.0, "rms": 1.0},
                "sweep": {"excitation.rms": levels, "excitation.frequency": frequencies},
            }
        ),
        workers=1,
    ).rows
    exact = {
        (row.point["excitation.frequency"], row.point["excitation.rms"]): row.metrics
        for row in rows
    }
    columns = {"f [Hz]": np.array(frequencies)}
    curves = []
    for i, level in enumerate(levels):
        names = [f"{ratio}{i}" for ratio in ratios]
        for ratio, name in zip(ratios, names, strict=True):
            curve = np.array([exact[f, level][ratio] for f in frequencies])
            noisy = np.round(curve * (1.0 + noise * draw.standard_normal(len(curve))), 3)
            columns[name] = noisy if noise else curve
        listed = ", ".join(
            f"{ratio}: {name}" for ratio, name in zip(ratios, names, strict=True)
        )
        curves.append(f"    - {{file: lab.csv, frequency: f, {listed}, rms: {level}}}\n")
    write_columns(folder / "lab.csv", columns)
    free = "".join(f"    {key}: {{}}\n" for key in CURVE_KEYS)
    excitation = "{kind: harmonic, frequency: 2 Hz, rms: 0.5}"
    (folder / "twin.yaml").write_text(
        f"oscillator: {{mass: {MASS}}}\nexcitation: {excitation}\n"
        f"fit:\n  curves:\n{''.join(curves)}  free:\n{free}"
    )
    return values
