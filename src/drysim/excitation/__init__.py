"""Shelf 1: how the base moves. An excitation is one file and one name here."""

from drysim.excitation.chirp import Chirp
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.excitation.psd import Psd
from drysim.excitation.record import Record
from drysim.excitation.rest import Rest
from drysim.excitation.road import Road
from drysim.excitation.shock import Shock
from drysim.excitation.standards import Standard

EXCITATIONS = (Rest, Harmonic, SineSum, Chirp, Shock, Psd, Standard, Road, Record)

Excitation = Rest | Harmonic | SineSum | Chirp | Shock | Psd | Standard | Road | Record
