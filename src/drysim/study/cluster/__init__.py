"""Cluster: the blocks of a sweep on the machines behind a Dask scheduler.

`far` wants the blocks in order and keeps them as they come. A Flight has some of them under way
to the workers behind a Link, as many together as a Load says; a Parcel holds all that a worker
needs to compute any of them.
"""
