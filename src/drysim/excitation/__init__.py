"""Excitations: types of base motion. A new one is a class and an entry in `EXCITATIONS`."""

from __future__ import annotations

from drysim.excitation.harmonic import Chirp, Harmonic, Rest, Shock, SineSum
from drysim.excitation.random import Psd, Road, Standard
from drysim.excitation.recorded import Record

EXCITATIONS = (Rest, Harmonic, SineSum, Chirp, Shock, Psd, Standard, Road, Record)

Excitation = Rest | Harmonic | SineSum | Chirp | Shock | Psd | Standard | Road | Record
