"""The units that scenarios know, what they measure, and how people spell them."""

from __future__ import annotations

import math

KINDS = {
    "kg": "mass",
    "N/m": "stiffness",
    "N·s/m": "damping",
    "N": "force",
    "N·s": "impulse",
    "m": "length",
    "m/s": "velocity",
    "m/s²": "acceleration",
    "s": "time",
    "Hz": "frequency",
    "J": "energy",
    "rad": "angle",
    "(m/s²)²/Hz": "acceleration PSD",
    "m³": "PSD of height",
    "1/m": "wave number",
    "s/m": "sharpness",
    "m/s^1.75": "vibration dose",
    "": "plain number",
}
"""The units of a scenario and what they measure."""

ASCII = {
    "m/s2": "m/s²",
    "m/s^2": "m/s²",
    "N*s/m": "N·s/m",
    "N*s": "N·s",
    "1/s": "Hz",
    "-": "",
    "–": "",
}

# The everyday spellings need no units library. `g` depends on what is asked for. The first of
# each row is the unit itself.
PLAIN: dict[str, dict[str, float]] = {
    "kg": {"kg": 1, "g": 1e-3, "t": 1e3},
    "N/m": {"N/m": 1, "kN/m": 1e3, "N/mm": 1e3},
    "N·s/m": {"N*s/m": 1, "Ns/m": 1, "kg/s": 1, "kN*s/m": 1e3, "kNs/m": 1e3},
    "N": {"N": 1, "kN": 1e3},
    "N·s": {"N*s": 1, "Ns": 1, "kN*s": 1e3, "kNs": 1e3, "kg*m/s": 1},
    "m": {"m": 1, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3},
    "m/s²": {"m/s^2": 1, "g": 9.80665, "mg": 9.80665e-3, "cm/s^2": 1e-2, "mm/s^2": 1e-3},
    "s": {"s": 1, "ms": 1e-3, "min": 60},
    "Hz": {"Hz": 1, "1/s": 1, "kHz": 1e3},
    "J": {"J": 1, "mJ": 1e-3, "kJ": 1e3},
    "rad": {"rad": 1, "deg": math.pi / 180, "°": math.pi / 180},
    "(m/s²)²/Hz": {
        "m^2/s^3": 1,
        "(m/s^2)^2/Hz": 1,
        "(m/s^2)2/Hz": 1,
        "g^2/Hz": 96.1703842225,
    },
    "m³": {"m^3": 1, "cm^3": 1e-6, "mm^3": 1e-9},
    "s/m": {"s/m": 1, "s/mm": 1e3},
    "m/s^1.75": {"m/s^1.75": 1},
    "1/m": {"1/m": 1, "cycle/m": 1, "cycles/m": 1, "rad/m": 0.5 / math.pi},
    "": {"-": 1, "–": 1, "%": 1e-2},
}
