"""A small sound scenario, from which others are made."""

from __future__ import annotations

SEAT = """\
drysim: 1
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
measure: {steady: false, settle: 0, duration: 2}
"""
