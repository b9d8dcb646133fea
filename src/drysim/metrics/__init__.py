"""Numbers that judge a motion.

`table` names every metric with its unit and measures those that need no grid: a_u, a_x, T_a,
T_x, shares, energies. `stroke` has excursions and contacts with end stops, `comfort` weighting
and SEAT, `spectra` PSD, H1 and coherence, `checks` what a scenario promises of all these.
"""
