"""Shelf 2: what the surfaces do. A friction law is one file and one name here.

What else belongs to one: its formula with its branch in the core, its scenario in the gallery
(`friction-<law>`, with the picture of its loop) and its row in the README.
"""

from drysim.friction.coulomb import Coulomb
from drysim.friction.dahl import Dahl
from drysim.friction.jenkins import Jenkins
from drysim.friction.leuven import Leuven
from drysim.friction.lugre import Lugre
from drysim.friction.petrov_ewins import PetrovEwins
from drysim.friction.stribeck import Stribeck

FRICTIONS = (Coulomb, Stribeck, Jenkins, PetrovEwins, Dahl, Lugre, Leuven)

Friction = Coulomb | Stribeck | Jenkins | PetrovEwins | Dahl | Lugre | Leuven
