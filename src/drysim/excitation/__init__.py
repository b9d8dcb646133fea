"""Shelf 1: how the base moves. An excitation is one class and one name here."""

from __future__ import annotations

from drysim.excitation.harmonic import Harmonic, Rest, SineSum
from drysim.excitation.random import Psd, Road, Standard
from drysim.excitation.recorded import Record
from drysim.excitation.transient import Chirp, Shock

EXCITATIONS = (Rest, Harmonic, SineSum, Chirp, Shock, Psd, Standard, Road, Record)

Excitation = Rest | Harmonic | SineSum | Chirp | Shock | Psd | Standard | Road | Record
