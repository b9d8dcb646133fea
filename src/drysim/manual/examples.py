"""Example values of scenario keys and metrics, for `drysim explain`.

The value of a key comes from the gallery, or from a table if no scenario of the gallery has the
key; the limit of a metric comes from tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

from drysim.scenario.keys import TAG_KEYS
from drysim.study.gallery import list_scenarios
from drysim.yaml_document import dump, read_document

MAX_LENGTH = 64
"""Maximum number of characters of a value from the gallery."""

VALUES = {
    "<key>.count": "20",
    "<key>.from": "10",
    "<key>.scale": "log",
    "<key>.step": "5",
    "<key>.to": "100",
    "about": "Seat on a rough floor, at most 25 mm of stroke.",
    "amplitude": "1.5",
    "assess": "{measured: {file: seat.csv, time: t, u_dd: floor, x_dd: seat}}",
    "assess.agree_within": "3 %",
    "assess.axes": "{x: {u_dd: floor_x, x_dd: seat_x}, y: {x_dd: seat_y}}",
    "assess.axes.x": "{u_dd: floor_x, x_dd: seat_x}",
    "assess.axes.y": "{u_dd: floor_y, x_dd: seat_y}",
    "assess.axes.z": "{u_dd: floor_z, x_dd: seat_z}",
    "assess.measured": "{file: seat.csv, time: t, u_dd: floor, x_dd: seat}",
    "band": "1 mm/s",
    "bands": "third-octave",
    "channel": "1",
    "checks": "[x_r_peak < 25 mm, T_a < 1.2]",
    "column": "u_dd",
    "compression": "30",
    "count": "20",
    "delay": "2 ms",
    "design": "{vary: {oscillator.damping: {from: 100, to: 4000}}, minimise: SEAT}",
    "design.over": "{oscillator.mass: [60, 90]}",
    "design.vary": "{oscillator.damping: {from: 100, to: 4000}}",
    "direction": "both",
    "distribution": "normal",
    "evaluations": "200",
    "excitation": "{kind: harmonic, frequency: 2, rms: 0.75}",
    "excitation.until": "{metric: T_a, half_width: 1 %}",
    "excitation.wave_numbers": "{from: 0.01, to: 10}",
    "exposure": "4 h",
    "extension": "60",
    "F_f.column": "F_f",
    "F_f.full_scale": "500 N",
    "F_f.unit": "N",
    "file": "record.csv",
    "fit": "{measured: {file: rig.csv, x_r: x}, free: {friction.kinetic: {}}}",
    "fit.curves": "[{file: lab.csv, frequency: f, T_a: T, rms: 0.5 m/s2}]",
    "fit.free": "{friction.kinetic: {}, oscillator.damping: {}}",
    "fit.measured": "{file: seat.csv, time: t, x_dd: seat}",
    "free.<key>.from": "10",
    "free.<key>.start": "30",
    "free.<key>.to": "90",
    "friction": "{kinetic: 45, static_ratio: 1.2}",
    "friction.<law>": "{kinetic: 30, static: 45}",
    "friction.normal_record": "{file: load.csv, time: t, column: F_N, unit: N}",
    "friction.normal_record.column": "F_N",
    "friction.normal_record.file": "load.csv",
    "friction.normal_record.full_scale": "2 kN",
    "friction.normal_record.missing": "-9999",
    "friction.normal_record.unit": "N",
    "friction.static": "54",
    "friction.static_ratio.from": "1",
    "friction.static_ratio.to": "1.5",
    "full_scale": "2 g",
    "gaps": "{fill: line, at_most: 20 ms}",
    "gaps.at_most": "20 ms",
    "gaps.fill": "line",
    "laws": "[coulomb, stribeck, dahl]",
    "mean": "45",
    "measure": "{settle: 5 s, duration: 60 s}",
    "measure.duration": "60 s",
    "measured.more_files": "[run-2.csv, run-3.csv]",
    "missing": "-9999",
    "mode": "45",
    "name": "my-seat",
    "noise": "{x_dd: 0.05}",
    "noise.F_f": "0.5",
    "noise.u_dd": "0.02",
    "noise.v_r": "1 mm/s",
    "noise.x_dd": "0.05",
    "noise.x_r": "0.1 mm",
    "normal_motion": "{amplitude: 0.1 mm, frequency: 5}",
    "normal_variation": "{amplitude: 0.4, frequency: 1.7}",
    "offset": "3 mm",
    "oscillator": "{mass: 75, stiffness: 7500, damping: 500}",
    "oscillator.damping": "500",
    "oscillator.damping_ratio": "0.25",
    "over": "{friction.kinetic: {from: 20, to: 60}}",
    "over.excitation.file": "[floor-1.csv, floor-2.csv]",
    "over.from_fit": "out/fit-seat",
    "per_octave": "6",
    "phase": "90 deg",
    "rate": "1 kHz",
    "remove": "mean",
    "remove.above": "80 Hz",
    "remove.below": "0.3 Hz",
    "remove.order": "4",
    "remove.trend": "mean",
    "resample": "{rate: 1 kHz, by: line}",
    "resample.by": "line",
    "roughness": "64e-6",
    "rows": "{where: {sensor: seat}}",
    "rows.from": "12",
    "rows.to": "6012",
    "rows.where": "{sensor: seat}",
    "sample": "{kind: sobol, count: 64, seed: 1, over: {friction.kinetic: {from: 20, to: 60}}}",
    "sample.from_fit": "out/fit-seat",
    "sample.over.<key>.from": "20",
    "sample.over.<key>.to": "60",
    "scale": "-1",
    "sd": "5",
    "seed": "1",
    "segment": "8 s",
    "sharpness": "1e4",
    "signum": "{method: rk4}",
    "skip": "3",
    "smooth": "{form: tanh, sharpness: 1e4}",
    "solver": "{step: 2.5 ms}",
    "spectra": "true",
    "srs": "{from: 1, to: 100, per_octave: 6}",
    "srs.from": "1",
    "srs.step": "1",
    "srs.to": "100",
    "stages": "[{from: 0, stiffness: 10 kN/m}, {from: 10 mm, stiffness: 40 kN/m}]",
    "curves[].displacement": "5 mm",
    "curves[].duration": "180 s",
    "curves[].estimator": "Hv",
    "curves[].velocity": "20 mm/s",
    "stages[].from": "10 mm",
    "stages[].stiffness": "40 kN/m",
    "start": "{x_r: 20 mm, v_r: 0}",
    "start.x_r": "20 mm",
    "static": "54",
    "step": "1 ms",
    "stops": "{stiffness: 20 kN/m}",
    "stroke": "{limit: 25 mm}",
    "stroke.limit.down": "20 mm",
    "stroke.limit.up": "30 mm",
    "sweep": "{friction.kinetic: [0, 15, 45]}",
    "sweep.excitation.file": "[floor-1.csv, floor-2.csv]",
    "sweep.srs.scale": "log",
    "switch": "{band: 1 mm/s}",
    "time": "t",
    "time_unit": "ms",
    "tolerance": "1e-10",
    "u_dd": "floor",
    "u_dd.column": "floor",
    "unit": "m/s2",
    "v_r.column": "v_r",
    "v_r.full_scale": "1 m/s",
    "v_r.unit": "m/s",
    "vary.<key>.from": "100",
    "vary.<key>.to": "4000",
    "wave_numbers.from": "0.01",
    "wave_numbers.to": "10",
    "window": "{from: 10 s, to: 70 s}",
    "window.from": "10 s",
    "window.to": "70 s",
    "within": "[x_r_peak < 30 mm, T_a < 1]",
    "x.x_dd": "seat_x",
    "x_dd.column": "x_dd",
    "x_r.column": "x_r",
    "x_r.full_scale": "50 mm",
    "x_r.unit": "mm",
    "y.x_dd": "seat_y",
    "z.x_dd": "seat_z",
    "zip": "{friction.kinetic: [15, 45], oscillator.damping: [500, 200]}",
}
"""Values of the keys that the gallery does not have, by the end of the dotted key. Those of a
whole key come before the gallery, too."""

KINDS = {
    "stribeck": "{law: stribeck, kinetic: 30, static: 45, stribeck_velocity: 10 mm/s}",
    "petrov-ewins": "{law: petrov-ewins, mu_kinetic: 0.3, normal: 150, "
    "tangential_stiffness: 45 kN/m, normal_stiffness: 100 kN/m, "
    "normal_motion: {amplitude: 2 mm, frequency: 4}}",
    "lugre": "{law: lugre, kinetic: 45, static: 54, stribeck_velocity: 5 mm/s, "
    "bristle_stiffness: 100 kN/m, bristle_damping: 300}",
    "leuven": "{law: leuven, kinetic: 45, static: 54, stribeck_velocity: 5 mm/s, "
    "bristle_stiffness: 30 kN/m, hysteresis_ratio: 2, transition: 2, bristle_damping: 300}",
    "sines": "{kind: sines, components: [{frequency: 1.6, rms: 0.5}, "
    "{frequency: 6.5, rms: 0.5}]}",
    "sweep": "{kind: sweep, from: 0.5, to: 10, scale: log, rms: 1, duration: 260 s}",
    "shock": "{kind: shock, pulse: half-sine, amplitude: 3 g, duration: 50 ms}",
    "psd": "{kind: psd, points: [[0.5, 0.1], [10, 0.1]], duration: 60 s, seed: 1}",
    "record": "{kind: record, file: floor.csv, time: t, column: u_dd}",
}
"""Kinds of blocks that are too long in the gallery."""

LIMITS = {
    "a_u": "> 0.7 m/s2",
    "a_w": "< 0.5 m/s2",
    "A_8": "< 0.5 m/s2",
    "chatter_share": "< 0.01",
    "closure": "< 1e-9",
    "contacts": "< 1",
    "crest_factor": "< 9",
    "crossing_rate": "< 5 1/s",
    "energy_residual": "< 1e-9",
    "energy_stored": "< 0.1 J",
    "fit_error": "< 5 %",
    "fit_error_held_out": "< 10 %",
    "law_residual": "< 1e-9",
    "limit_rate": "< 0.01 1/s",
    "multiplier_1_phase": "< 1 rad",
    "multiplier_2_phase": "< 1 rad",
    "stable": "== 1",
    "stuck_share": "< 20 %",
    "T_x": "< 1.5",
    "t_beyond": "< 0.1 s",
    "t_first_violation": "> 60 s",
    "u_rms": "> 5 mm",
    "v_r_rms": "< 0.2 m/s",
    "VDV": "< 9.1 m/s^1.75",
    "VDV_day": "< 9.1 m/s^1.75",
    "x_dd_peak": "< 15 m/s2",
    "x_r_min": "> -25 mm",
    "x_r_rms": "< 10 mm",
}
"""Limits of metrics that differ from what is usual for their unit."""

LIMITS_BY_UNIT = {
    "-": "< 1",
    "m": "< 25 mm",
    "m/s": "< 0.3 m/s",
    "m/s2": "< 1 m/s2",
    "N": "< 800 N",
    "N·s": "< 20 N*s",
    "J": "< 50 J",
}
"""Limits of the other metrics by their unit."""


def check(metric: str, unit: str) -> str:
    """Return a check of a metric with a limit as a seat may have it."""
    return f"{metric} {LIMITS.get(metric) or LIMITS_BY_UNIT[unit]}"


def value(key: str, kinds: Sequence[str]) -> str:
    """Return an example value of a dotted key as YAML on one line; empty if there is none.

    `kinds` are the kinds of the block that have the key, such as `road`.
    """
    if key in VALUES and ("." in key or not kinds[0]):
        return VALUES[key]
    gallery = _gallery()
    if example := next((gallery[key, kind] for kind in kinds if (key, kind) in gallery), ""):
        return example
    parts = key.split(".")
    tails = [".".join(parts[i:]) for i in range(len(parts))]
    return next((VALUES[tail] for tail in tails if tail in VALUES), "")


def of_kind(block: str, kind: str) -> str:
    """Return an example of a kind of block as YAML on one line; empty if there is none."""
    return KINDS.get(kind) or _gallery().get((block, kind), "")


@cache
def _gallery() -> dict[tuple[str, str], str]:
    """Return an example value for each dotted key in the gallery, as YAML on one line.

    The second key is the kind of the block, such as `road`; empty for a block without kinds.
    """
    values: dict[tuple[str, str], str] = {}

    def collect(prefix: str, content: Any, kind: str = "") -> None:
        if isinstance(content, dict) and prefix != "sweep":
            kind = next((str(content[tag]) for tag in TAG_KEYS if tag in content), kind)
            for key, inner in content.items():
                collect(f"{prefix}.{key}" if prefix else str(key), inner, kind)
        elif isinstance(content, list) and content and isinstance(content[0], dict):
            collect(f"{prefix}[]", content[0], kind)
        if prefix and len(text := _on_a_line(content)) <= MAX_LENGTH:
            values.setdefault((prefix, kind), text)

    for scenario in list_scenarios():
        collect("", read_document(scenario.file).value)
    return values


def _on_a_line(content: Any) -> str:
    """Return a value as YAML on one line."""
    if isinstance(content, dict):
        return (
            f"{{{', '.join(f'{key}: {_on_a_line(inner)}' for key, inner in content.items())}}}"
        )
    if isinstance(content, list):
        return f"[{', '.join(map(_on_a_line, content))}]"
    return dump({"key": content}).partition(":")[2].strip()
