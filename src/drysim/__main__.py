"""Lets `python -m drysim` be the command `drysim`."""

from drysim.cli import command

command()
