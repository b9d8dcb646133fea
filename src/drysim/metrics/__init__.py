"""Metrics of a motion.

`table` lists every metric with its unit and computes those that need no grid: a_u, a_x, T_a,
T_x, shares, energies. `stroke` has excursions and contacts with end stops, `comfort` frequency
weighting and SEAT, `spectra` PSD, H1 and coherence, `checks` the checks of a scenario.
"""
