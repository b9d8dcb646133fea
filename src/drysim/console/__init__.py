"""All that the terminal shows: the result on stdout, the talk on stderr. Writes no file."""

from drysim.console.faults import show_fault as show_fault
from drysim.console.faults import show_problems as show_problems
from drysim.console.summary import show_outcome as show_outcome
from drysim.console.summary import show_warnings as show_warnings
