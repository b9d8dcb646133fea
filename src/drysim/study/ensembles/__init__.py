"""Ensembles: one scenario under many seeds, and what they have in common.

`by_seed` gives a Row for every seed, in order; where the scene allows, `blocks` measures many
of them in one call of the kernel. A Journal keeps them while the work goes on. The Ensemble has
the rows, a Statistic of every metric, and the Outcome of the one seed that is shown.
"""
