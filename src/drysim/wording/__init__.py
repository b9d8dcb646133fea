"""Numbers and scenes in words, for the terminal and for pictures alike."""

from drysim.wording.base_motion import clean_up as clean_up
from drysim.wording.base_motion import excitation as excitation
from drysim.wording.base_motion import excitations as excitations
from drysim.wording.cases import located as located
from drysim.wording.cases import place as place
from drysim.wording.cases import places as places
from drysim.wording.cases import short as short
from drysim.wording.cases import stretch as stretch
from drysim.wording.cases import swept as swept
from drysim.wording.means import around as around
from drysim.wording.means import seeds as seeds
from drysim.wording.numbers import UNKNOWN as UNKNOWN
from drysim.wording.numbers import LengthUnit as LengthUnit
from drysim.wording.numbers import clean as clean
from drysim.wording.numbers import length as length
from drysim.wording.numbers import length_unit as length_unit
from drysim.wording.numbers import listed as listed
from drysim.wording.numbers import number as number
from drysim.wording.numbers import percent as percent
from drysim.wording.numbers import pretty as pretty
from drysim.wording.numbers import several as several
from drysim.wording.numbers import times as times
from drysim.wording.numbers import told_in as told_in
from drysim.wording.scenes import friction as friction
from drysim.wording.scenes import scene as scene
