"""Cluster: the blocks of a sweep on the machines behind a Dask scheduler."""
