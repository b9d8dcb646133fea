"""PNG: each picture is a function of what it shows and the folder to write it in."""

from drysim.report.plots.comparison import comparison as comparison
from drysim.report.plots.ensemble import ensemble as ensemble
from drysim.report.plots.response import response as response
from drysim.report.plots.spectra import spectra as spectra
from drysim.report.plots.speed_error import speed_error as speed_error
from drysim.report.plots.stroke import stroke as stroke
from drysim.report.plots.transmissibility import transmissibility as transmissibility
