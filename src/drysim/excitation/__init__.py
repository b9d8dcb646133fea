"""Shelf 1: how the base moves. An excitation is one file and one name here."""

from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.excitation.psd import Psd
from drysim.excitation.record import Record
from drysim.excitation.rest import Rest

EXCITATIONS = (Rest, Harmonic, SineSum, Psd, Record)

Excitation = Rest | Harmonic | SineSum | Psd | Record
