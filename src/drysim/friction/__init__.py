"""Shelf 2: what the surfaces do. A friction law is one file and one name here."""

from drysim.friction.coulomb import Coulomb

FRICTIONS = (Coulomb,)

Friction = Coulomb
